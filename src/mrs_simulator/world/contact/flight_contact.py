"""Contact of robots that fly: bodies in pybullet while they are within reach of something to touch.

Flight stays where it is: from one substep to the next, a body is put where it was and given the velocities
that flight gives it, weight and rotors included; the solver moves it on and lets it touch the ground,
obstacles and others of its drive.  Who touches nothing flies on as without it.  None within reach costs a
few comparisons, and no solver.
"""

import importlib.util

import numpy as np

from mrs_simulator.core.snapshots import NotCopied
from mrs_simulator.core.spatial import rotated
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import Cylinder, is_flat
from mrs_simulator.vehicles.drives.flight import upright_share
from mrs_simulator.world.contact.collisions import VerletList

MARGIN = 0.02  # [m] by which bodies are within reach before they touch
LEVEL = 0.98  # [-] of a body's axis that points up, above which it lands as flight has it
HARD = 1.0  # [m/s] of sinking, above which it does not
FRICTION, BOUNCE = 0.5, 0.2  # [-] chosen for plastic on a floor
ROLLING = 1e-3  # [m] likewise
DEEP = 1e-3  # [m] of penetration, below which bodies that slide along each other touch as well
ROUNDING = 1e-6  # [m] by which places may be rounded, generously
FEW = 1e-6  # [N] of a contact, above which there is one
PARKED = -100.0  # [m] where bodies are that touch nothing


def is_available():
    """Return whether the solver is installed."""
    return importlib.util.find_spec("pybullet") is not None


class FlightContacts:
    """The m robots of a drive that flies, and the solver for those within reach of something."""

    def __init__(self, kinds, names, obstacles, free):
        """``kinds`` and ``names`` of the robots; ``free`` (m,) bool: robots moved here."""
        self._kinds, self._names, self._free = kinds, names, np.array(free)
        self._tall = np.array([kind.body.height for kind in kinds])
        # [m] from the ground to the middles
        self._half_up = np.column_stack([np.zeros((len(kinds), 2)), 0.5 * self._tall])
        self._reach = np.hypot([kind.body.reach for kind in kinds], 0.5 * self._tall)
        self._obstacles = self._given = self._before = _solid(obstacles)
        self._list = VerletList(2.0 * float(self._reach.max(initial=0.0)) + MARGIN)
        self._client, self._bodies, self._near = None, {}, ()
        self._found = {}

    def move_obstacles(self, obstacles):
        """Let the ``obstacles``, of the same number and sizes, be where they are after the next step."""
        self._before, self._obstacles = self._obstacles, _solid(obstacles)

    def solver(self, inner, step):
        """Return the ``touch`` of ``flown`` for a ``step`` [s] from ``inner``, None if no robot is near."""
        self._found = {}
        near = self._within_reach(inner, step)
        if not near.any():
            self._park(())
            return None
        rows = np.flatnonzero(near)
        if self._client is None:
            self._open()
        self._movers.aim(self._before, self._obstacles, step)
        self._park(rows.tolist())
        return lambda before, after, duration: self._touch(rows, before, after, duration)

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y, z)`` each."""
        return list(self._found.values())

    def __getstate__(self):
        if self._client is not None:
            raise NotCopied("the memory of pybullet's solver cannot be copied")
        return vars(self)

    def close(self):
        """Give back what the solver holds."""
        if self._client is not None:
            from mrs_simulator.world.contact.scene import close_solver

            close_solver(self._client)
            self._client = None

    # Who is within reach -------------------------------------------------------------------------

    def _within_reach(self, inner, step):
        """Return which robots, (m,) bool, may touch something within a ``step`` [s]."""
        flight = inner.flight
        place, near = self._middles(flight.place), np.zeros(len(self._tall), dtype=bool)
        way = MARGIN + step * np.sqrt((flight.velocity**2).sum(axis=1))
        for obstacle, given in zip(self._obstacles, self._given):
            comes = step * given.track.speed if moves(given) else 0.0
            near |= _gap(obstacle, place) < self._reach + way + comes
        hard = (upright_share(flight.attitude) < LEVEL) | (flight.velocity[:, 2] < -HARD)
        if inner.working is not None:
            hard |= ~inner.working.all(axis=1)
        near |= hard & (flight.place[:, 2] > 0.0) & (place[:, 2] < self._reach + way)
        first, second = self._list.pairs(flight.place[:, :2])
        if len(first):
            apart = np.sqrt(((place[second] - place[first]) ** 2).sum(axis=1))
            meet = apart < (self._reach + way)[first] + (self._reach + way)[second]
            near[first[meet]] = near[second[meet]] = True
        return near & self._free

    def _middles(self, place):
        return place + self._half_up

    def room(self, place):
        """Return how far [m] robots may move from ``place`` (m, 3) before bodies can touch each other or
        obstacles."""
        self._list.clear()
        first, second = self._list.pairs(place[:, :2])
        place, room = self._middles(place), self._list.unlisted(place[:, :2])
        if len(first):
            apart = np.sqrt(((place[second] - place[first]) ** 2).sum(axis=1))
            room = min(room, 0.5 * (apart - self._reach[first] - self._reach[second]).min())
        for obstacle in self._obstacles:
            room = min(room, (_gap(obstacle, place) - self._reach).min())
        return float(room) - ROUNDING

    @property
    def contact(self):
        """Return what ``flight_stretches.reached`` takes of bodies."""
        return self._reach, np.ascontiguousarray(self._half_up[:, 2]), MARGIN, LEVEL, HARD

    def forget(self):
        """Forget the contacts of the last step."""
        self._found = {}

    # The solver ----------------------------------------------------------------------------------

    def _open(self):
        from mrs_simulator.world.contact.movers import ObstacleMover
        from mrs_simulator.world.contact.scene import add_ground, add_obstacle, open_solver

        self._client = open_solver()
        bodies = {add_ground(self._client): "ground"}
        solid = [add_obstacle(self._client, each) for each in self._obstacles]
        bodies.update(zip(solid, (each.name for each in self._obstacles)))
        self._movers = ObstacleMover(self._client, self._given, solid)
        for body in bodies:
            self._change(body, lateralFriction=FRICTION, restitution=BOUNCE)
        self._fixed = bodies

    def _change(self, body, **values):
        import pybullet

        pybullet.changeDynamics(body, -1, physicsClientId=self._client, **values)

    def _body(self, row):
        import pybullet

        kind, client = self._kinds[row], {"physicsClientId": self._client}
        body = kind.body
        if body.round:
            form = {"shapeType": pybullet.GEOM_CYLINDER, "radius": body.reach}
            form["height"] = body.height
        else:
            half = [0.5 * body.length, 0.5 * body.width, 0.5 * body.height]
            form = {"shapeType": pybullet.GEOM_BOX, "halfExtents": half}
        shape = pybullet.createCollisionShape(**form, **client)
        made = pybullet.createMultiBody(
            kind.mass, shape, -1, [10.0 * row, 0.0, PARKED], useMaximalCoordinates=0, **client
        )
        inertia = list(kind.numbers.inertia)
        self._change(made, localInertiaDiagonal=inertia, lateralFriction=FRICTION)
        self._change(made, rollingFriction=ROLLING, spinningFriction=ROLLING)
        self._change(made, restitution=BOUNCE, linearDamping=0.0, angularDamping=0.0)
        self._change(made, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        return made

    def _park(self, rows):
        """Have the bodies of ``rows`` touch, and no others."""
        if not len(rows) and not len(self._near):
            return
        import pybullet

        for row in set(self._near) ^ set(rows):
            if row not in self._bodies:
                self._bodies[row] = self._body(row)
            group = 1 if row in rows else 0
            pybullet.setCollisionFilterGroupMask(
                self._bodies[row], -1, group, group, physicsClientId=self._client
            )
        self._near = tuple(rows)

    def _touch(self, rows, before, after, duration):
        """Return ``after`` with the bodies ``rows`` as the solver moves them on from ``before``."""
        import pybullet

        client = {"physicsClientId": self._client}
        place = self._middles(before.place)
        rates = rotated(before.attitude, after.rates)  # into the common frame
        for row in rows.tolist():
            body = self._bodies[row]
            where = place[row].tolist(), before.attitude[row].tolist()
            pybullet.resetBasePositionAndOrientation(body, *where, **client)
            how = after.velocity[row].tolist(), rates[row].tolist()
            pybullet.resetBaseVelocity(body, *how, **client)
        self._movers.advance(duration)
        pybullet.setPhysicsEngineParameter(fixedTimeStep=duration, numSubSteps=0, **client)
        pybullet.stepSimulation(**client)
        rows = self._touched(rows)
        if not len(rows):
            return after
        parts = [part.copy(order="F") for part in after[:4]]
        for row in rows.tolist():
            body = self._bodies[row]
            where, turn = pybullet.getBasePositionAndOrientation(body, **client)
            velocity, turning = pybullet.getBaseVelocity(body, **client)
            for part, value in zip(parts, (where, velocity, turn, turning)):
                part[row] = value
        parts[0][rows, 2] -= 0.5 * self._tall[rows]
        back = parts[2][rows] * [-1.0, -1.0, -1.0, 1.0]
        parts[3][rows] = rotated(back, parts[3][rows])
        return after._replace(place=parts[0], velocity=parts[1], attitude=parts[2], rates=parts[3])

    def _touched(self, rows):
        """Return which of ``rows`` touch something now, and keep what they touch but for the ground.

        All others fly on as if there were no solver, to the last bit.
        """
        import pybullet

        names, touched = {self._bodies[row]: self._names[row] for row in rows.tolist()}, set()
        names.update(self._fixed)
        for point in pybullet.getContactPoints(physicsClientId=self._client):
            if point[1] not in names or point[2] not in names:
                continue
            if point[9] > FEW or point[8] < -DEEP:
                touched.update(point[1:3])
                first, second = sorted((names[point[1]], names[point[2]]), key=self._order)
                if "ground" not in (first, second):
                    self._found.setdefault((first, second), (first, second, *point[5]))
        return np.array([row for row in rows.tolist() if self._bodies[row] in touched], dtype=int)

    def _order(self, name):
        return (0, self._names.index(name)) if name in self._names else (1, 0)


def _solid(obstacles):
    return [each for each in obstacles if not is_flat(each)]


def _gap(obstacle, place):
    """Return how far ``place`` (m, 3) is from an obstacle, (m,) [m]; 0 inside."""
    x, y = place[:, 0] - obstacle.x, place[:, 1] - obstacle.y
    above = np.maximum(place[:, 2] - obstacle.height, 0.0)
    if isinstance(obstacle, Cylinder):
        beside = np.maximum(np.hypot(x, y) - obstacle.radius, 0.0)
        return np.hypot(beside, above)
    cos, sin = np.cos(obstacle.yaw), np.sin(obstacle.yaw)
    along = np.maximum(np.abs(cos * x + sin * y) - 0.5 * obstacle.length, 0.0)
    across = np.maximum(np.abs(cos * y - sin * x) - 0.5 * obstacle.width, 0.0)
    return np.sqrt(along * along + across * across + above * above)
