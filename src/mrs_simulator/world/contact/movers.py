"""Obstacles on tracks in a solver: bodies without mass that push what is in their way."""

import numpy as np
import pybullet

from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import clearance

LEVEL = [0.0, 0.0, 0.0]
JUMP = 2.0  # [-] of the way at its speed, beyond which an obstacle was put elsewhere and did not move there
NEAR = 0.1  # [m] from a robot's reach


class ObstacleMover:
    """Moves the obstacles on tracks in the solver of one ``client``.

    The solver takes the velocity of a body without mass into its contacts, and does not move it: it is put
    where it is before each substep.
    """

    def __init__(self, client, obstacles, bodies):
        """``bodies``: of ``obstacles`` in the solver, None for those that have none there."""
        self._client = {"physicsClientId": client}
        self._rows = [row for row, each in enumerate(obstacles) if moves(each)]
        self._bodies = [bodies[row] for row in self._rows]
        self._speeds = np.array([obstacles[row].track.speed for row in self._rows])
        self.aim(obstacles, obstacles, 1.0)

    def __bool__(self):
        return bool(self._rows)

    def aim(self, before, after, step):
        """Let all go within a ``step`` [s] of substeps from where they are ``before`` to where ``after``.

        Both are all of the scene's obstacles, in the same order.
        """
        self._now = [after[row] for row in self._rows]
        begin, end = (
            np.array([[each[row].x, each[row].y] for row in self._rows]).reshape(-1, 2)
            for each in (before, after)
        )
        way = end - begin
        jumps = np.hypot(*way.T) > JUMP * self._speeds * step
        self._velocity = np.where(jumps[:, np.newaxis], 0.0, way / step)
        self._place = end - step * self._velocity

    def put(self, obstacles):
        """Have all stand where ``obstacles`` are."""
        self.aim(obstacles, obstacles, 1.0)
        self.advance(0.0)

    def advance(self, duration):
        """Put all where they are now, for a substep of ``duration`` [s]."""
        rows = zip(self._bodies, self._now, self._place.tolist(), self._velocity.tolist())
        for body, obstacle, place, velocity in rows:
            turn = pybullet.getQuaternionFromEuler([0.0, 0.0, getattr(obstacle, "yaw", 0.0)])
            where = [*place, 0.5 * obstacle.height]
            pybullet.resetBasePositionAndOrientation(body, where, turn, **self._client)
            pybullet.resetBaseVelocity(body, [*velocity, 0.0], LEVEL, **self._client)
        self._place = self._place + duration * self._velocity

    def are_near(self, points, reach):
        """Return whether any is near a robot at ``points`` (n, 2) that reaches ``reach`` (n,) [m] far."""
        return any((clearance(each, points)[0] < reach + NEAR).any() for each in self._now)
