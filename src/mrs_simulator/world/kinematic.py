"""Motion without forces: exact arcs of unicycles, and point masses for pure theory."""

import os

import numpy as np

from mrs_simulator.core.kinematics import (
    arc,
    clip_commands,
    cos_sin,
    point_mass_from_unicycle,
    ramp,
    wheel_speeds,
    wrap_angle,
)
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.vehicles import limits_of_team, robot_kind
from mrs_simulator.world.bodies import Bodies


def drive(pose, velocity, command, top, acceleration, step):
    """Return velocities (n, 2), their means over the step (n, 2) and poses (n, 3) after ``step`` [s].

    Commands are clipped to ``top`` and ramped by ``acceleration``, (2,) each; the arc is that of the
    mean velocity.  Arrays lie in memory column by column.
    """
    velocity, mean = ramp(velocity, clip_commands(command, top), acceleration, step)
    after = arc(pose, mean, step)
    after[:, 2] = wrap_angle(after[:, 2])
    return velocity, mean, after


def drive_function():
    """Return ``drive``, or its compiled twin with ``MRS_SIMULATOR_COMPILED=1`` in the environment."""
    wanted = os.environ.get("MRS_SIMULATOR_COMPILED", "0")
    if wanted not in ("0", "1"):
        raise ValueError("MRS_SIMULATOR_COMPILED={}: wanted 0 or 1".format(wanted))
    if wanted == "0":
        return drive
    from mrs_simulator.world.compiled import compiled_drive  # numba only where it is wanted

    return compiled_drive()


class KinematicMotion:
    """Unicycles (1) integrated exactly, with the firmware's limits, bodies kept apart."""

    def __init__(
        self,
        kinds,
        poses,
        obstacles=(),
        limits="firmware",
        step=0.02,
        mirrored=(),
        encoders=False,
    ):
        """``poses`` (n, 3); ``limits`` as in ``robots.limits_of``; ``step`` [s] of one advance.

        ``mirrored``: rows of robots that ``place`` alone moves.  ``encoders``: keep ``wheel_travel``
        (n, 2) [m], which only odometry wants.
        """
        self.step = step
        self.limits = limits_of_team(kinds, limits)
        self._top, self._ramp = self.limits.velocities(), self.limits.accelerations()
        self._encoders = encoders
        self._drive = drive_function()
        self._track = robot_kind(kinds[0]).WHEEL_TRACK
        self._bodies = Bodies(kinds, obstacles, mirrored)
        self._mirrored = np.array(mirrored, dtype=int)
        self._moving = np.flatnonzero(~self._bodies.mirrored) if len(mirrored) else slice(None)
        self.reset(np.asarray(poses, dtype=float))

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        self.pose = np.array(poses, dtype=float, order="F")
        self.twist = np.zeros_like(self.pose)
        self.wheel_travel = np.zeros((len(self.pose), 2), order="F") if self._encoders else None
        self._velocity = np.zeros((len(self.pose), 2), order="F")
        self._contacts = []
        self._bodies.moved_elsewhere()

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def advance(self, command):
        """Move for one step under ``command`` (n, 2) [m/s, rad/s].

        Velocities are clipped and ramped as the firmware does; the arc is that of the mean
        velocity over the step, exact while ``v`` and ``omega`` hold.
        """
        if len(self._mirrored):
            command = command.copy(order="K")
            command[self._mirrored] = 0.0
        before = self.pose
        self._velocity, mean, free = self._drive(
            before, self._velocity, command, self._top, self._ramp, self.step
        )
        if self._encoders:
            self.wheel_travel += self.step * wheel_speeds(mean, self._track)
        self.pose = free.copy()
        self._contacts = self._bodies.separate(self.pose, self._farthest(mean))
        if self._contacts:
            self._feel_contacts(before, free)
        own = self._moving
        self.twist[own, 0], self.twist[own, 2] = self._velocity[own, 0], self._velocity[own, 1]

    def _farthest(self, mean):
        """Return a distance [m] that no robot exceeds in a step at the ``mean`` velocities (n, 2)."""
        if len(self._mirrored):
            return np.inf
        fastest = self.limits.v_max
        return self.step * (fastest if fastest < np.inf else np.abs(mean[:, 0]).max())

    def _feel_contacts(self, before, free):
        """A robot that was pushed has the forward speed with which it really moved."""
        pushed = np.any(self.pose[:, :2] != free[:, :2], axis=1)
        moved = (self.pose[pushed, :2] - before[pushed, :2]) / self.step
        theta = before[pushed, 2]
        cos, sin = cos_sin(theta)
        speed = cos * moved[:, 0] + sin * moved[:, 1]
        own = self._velocity[pushed, 0]
        # No faster than its wheels turn, and never the other way.
        self._velocity[pushed, 0] = np.sign(own) * np.clip(np.sign(own) * speed, 0.0, np.abs(own))

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y)`` each."""
        return [contact[:4] for contact in self._contacts]

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._bodies.closest(self.pose)

    def close(self):
        """Nothing is held."""


class PointMassMotion:
    """Hand points as point masses: ``alpha' = A(theta) (v, omega)``, (3), with the heading frozen.

    No limits and no bodies: the world of the theorems.  A command held for one step moves the hand
    point by exactly ``step * alpha'``.
    """

    def __init__(self, kinds, poses, hand_length, step=0.02, mirrored=()):
        """``hand_length`` [m] is l, the hand point's distance from the centre.

        ``mirrored``: rows of robots that ``place`` alone moves.
        """
        self.step = step
        self.limits = limits_of_team(kinds, None)
        self._hand_length = hand_length
        self._mirrored = np.array(mirrored, dtype=int)
        self.reset(poses)

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        self.pose = np.array(poses, dtype=float)
        self.twist = np.zeros_like(self.pose)
        self.wheel_travel = np.zeros((len(self.pose), 2))

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def advance(self, command):
        """Move for one step under ``command`` (n, 2); body twist ``(v, l omega, 0)``."""
        mirrored_twist = self.twist[self._mirrored]
        command = np.array(command, dtype=float)
        command[self._mirrored] = 0.0
        u = point_mass_from_unicycle(command, self.pose[:, 2], self._hand_length)
        self.pose[:, :2] += self.step * u
        self.twist[:, 0] = command[:, 0]
        self.twist[:, 1] = self._hand_length * command[:, 1]
        self.twist[self._mirrored] = mirrored_twist

    def contacts(self):
        """Return no contacts: points have no bodies."""
        return []

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return least_distance(self.pose[:, :2])

    def close(self):
        """Nothing is held."""
