"""Motion without forces: each drive's exact kinematics, and point masses for pure theory."""

import os

import numpy as np

from mrs_simulator.core.environment import CALM
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.drives import differential
from mrs_simulator.vehicles.team import joined
from mrs_simulator.world.bodies import Bodies


def move_function(drive):
    """Return ``drive.move``, or its compiled twin with ``MRS_SIMULATOR_COMPILED=1`` where there is one."""
    wanted = os.environ.get("MRS_SIMULATOR_COMPILED", "0")
    if wanted not in ("0", "1"):
        raise ValueError("MRS_SIMULATOR_COMPILED={}: wanted 0 or 1".format(wanted))
    if wanted == "0" or drive is not differential:
        return drive.move
    from mrs_simulator.world.compiled import compiled_move  # numba only where it is wanted

    return compiled_move()


SHORT = 0.05  # [m] in a step: a bound that is worth more than the time to look at every robot


class GroupMotion:
    """The inner state of the robots of one drive, and their exact motion."""

    def __init__(self, group, step, encoders, environment=CALM):
        """``group``: a ``vehicles.team.Group``; ``step`` [s]; ``encoders``: keep ``travel``.

        ``environment``: its current carries robots in the water.
        """
        self.group, self._step = group, step
        self._move, self._encoders = move_function(group.drive), encoders
        afloat = group.drive.MEDIUM == "water"
        self._current = np.array(environment.current if afloat else CALM.current)
        self._drifting = bool(self._current.any())
        self._drift = step * float(np.hypot(*self._current))  # [m] in a step
        self._reach = step * group.drive.top_speed(group.limits) + self._drift
        self.reset()

    def reset(self):
        """Be at rest."""
        m, drive = len(self.group.kinds), self.group.drive
        self.velocity = np.zeros((m, len(drive.AXES)), order="F")
        self.joints = np.zeros(m)
        self.travel = np.zeros((m, drive.ENCODERS), order="F") if self._encoders else None

    def advance(self, pose, command):
        """Return the poses (m, 3) after a step from ``pose`` under ``command`` (m, axes)."""
        group = self.group
        self.velocity, self.joints, self._mean, after = self._move(
            pose, self.velocity, self.joints, command, group.limits, group.numbers, self._step
        )
        if self._encoders:
            rims = group.drive.rim_speeds(self._mean, self.joints, group.numbers)
            self.travel += self._step * rims
        if self._drifting:
            after[:, :2] += self._step * self._current
        return after

    def farthest(self):
        """Return a distance [m] that no robot's centre exceeded in the last step."""
        if self._reach < SHORT:
            return self._reach
        return self._step * self.group.drive.farthest(self._mean) + self._drift

    def fill_twist(self, twist, theta):
        """Write the body twists (m, 3) over ground into ``twist``; ``theta`` (m,) [rad]."""
        self.group.drive.fill_twist(twist, self.velocity, self.joints, self.group.numbers)
        if self._drifting:
            # A drive writes those entries alone that it moves by.
            twist[:, 1] = 0.0
            self._add_drift(twist, theta)

    def _add_drift(self, twist, theta):
        if self._drifting:
            twist[:, :2] += into_body(np.tile(self._current, (len(theta), 1)), theta)

    def feel(self, pushed, theta, moved):
        """Let the robots in ``pushed`` (m,) bool be as fast as contacts let them.

        ``theta`` (m,) [rad] before the step; ``moved`` (m, 2) [m/s] in the common frame.
        """
        moved = moved[pushed] - self._current if self._drifting else moved[pushed]
        body = into_body(moved, theta[pushed])
        self.velocity[pushed] = self.group.drive.blocked(self.velocity[pushed], body)


def into_body(vectors, theta):
    """Return ``vectors`` (m, 2), of the common frame, in the bodies' frames."""
    cos, sin = cos_sin(theta)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)


class KinematicMotion:
    """Robots moved exactly, with the firmware's limits, bodies kept apart."""

    def __init__(self, kinds, poses, obstacles=(), limits="firmware", step=0.02, mirrored=(),
                 encoders=False, environment=CALM, make_group=GroupMotion):  # fmt: skip
        """``kinds``: the ``Team``, or its kinds; ``poses`` (n, 3); ``step`` [s] of one advance.

        ``limits`` as in ``vehicles.limits.kind_limits``; ``mirrored``: rows of robots that ``place``
        alone moves; ``encoders``: keep ``wheel_travel``, which only odometry wants; ``make_group``:
        what makes the motion of a group, by default its exact kinematics.
        """
        self.step = step
        self.team = Team.of(kinds, limits)
        self._groups = [
            make_group(group, step, encoders, environment) for group in self.team.groups
        ]
        self._bodies = Bodies(self.team, obstacles, mirrored)
        self._mirrored = np.array(mirrored, dtype=int)
        self._simulated = None if not len(mirrored) else ~self._bodies.mirrored
        self._order, self._parts = _order_of(self.team)
        self._place = None if self._order is None else np.argsort(self._order)
        self.reset(np.asarray(poses, dtype=float))

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        self.pose = np.array(poses, dtype=float, order="F")
        self.twist = np.zeros_like(self.pose)
        self._by_group = np.zeros_like(self.pose)
        for each in self._groups:
            each.reset()
        self._contacts = []
        self._bodies.moved_elsewhere()

    @property
    def wheel_travel(self):
        """Return how far the wheels of each group have rolled, a list of (m, encoders) [m]."""
        return [each.travel for each in self._groups]

    def joints(self):
        """Return the drives' inner joints, such as steering angles, (n,) [rad]; 0 where none is."""
        return joined(self.team, [each.joints for each in self._groups])

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def advance(self, command):
        """Move for one step under ``command`` (n, a), a column for each axis of the team."""
        if len(self._mirrored):
            command = command.copy(order="K")
            command[self._mirrored] = 0.0
        before = self.pose
        free = self._moved(before, command)
        if len(self._mirrored):
            free[self._mirrored] = before[self._mirrored]  # no current carries them off
        self.pose = free.copy()
        self._contacts = self._bodies.separate(self.pose, self._farthest())
        if self._contacts:
            self._feel_contacts(before, free)
        self._fill_twist()

    def _moved(self, before, command):
        if self._order is None:
            return self._groups[0].advance(before, command)
        # Rows are put together by group once, so that a group's are a slice.
        before, command = _taken(before, self._order), _taken(command, self._order)
        free = np.empty_like(before)
        for each, part in zip(self._groups, self._parts):
            free[part] = each.advance(before[part], command[part][:, each.group.columns])
        return _taken(free, self._place)

    def _fill_twist(self):
        twist = self.twist if self._order is None and self._simulated is None else self._by_group
        for each, part in zip(self._groups, self._parts):
            each.fill_twist(twist[part], self.pose[each.group.rows, 2])
        if twist is self.twist:
            return
        twist = twist if self._order is None else _taken(twist, self._place)
        if self._simulated is None:
            self.twist = twist
        else:
            self.twist[self._simulated] = twist[self._simulated]

    def _farthest(self):
        """Return a distance [m] that no robot exceeds in a step."""
        if len(self._mirrored):
            return np.inf
        return max(each.farthest() for each in self._groups)

    def _feel_contacts(self, before, free):
        pushed = np.any(self.pose[:, :2] != free[:, :2], axis=1)
        moved = (self.pose[:, :2] - before[:, :2]) / self.step
        for each in self._groups:
            rows = each.group.rows
            each.feel(pushed[rows], before[rows, 2], moved[rows])

    def contacts(self):
        """Return the contacts of the last step: ``(first, second, x, y)`` each."""
        return [contact[:4] for contact in self._contacts]

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return self._bodies.closest(self.pose)

    def close(self):
        """Nothing is held."""


def _order_of(team):
    """Return the rows of the team's groups one after the other, and the slice of each group in it.

    The order of a team of one drive is None: that in which its robots are.
    """
    ends = np.cumsum([len(group.kinds) for group in team.groups]).tolist()
    parts = [slice(begin, end) for begin, end in zip([0, *ends], ends)]
    if len(team.groups) == 1:
        return None, parts
    rows = np.arange(team.n)
    return np.concatenate([rows[group.rows] for group in team.groups]), parts


def _taken(values, rows):
    """Return ``values[rows]`` (n, ...), column by column in memory."""
    return values.T.take(rows, axis=1).T


class PointMassMotion:
    """Controlled points as point masses: ``alpha' = A(theta) (v, omega)``, (3), headings frozen.

    No limits and no bodies: the world of the theorems.  A command held for one step moves the point
    by exactly ``step * alpha'``.
    """

    def __init__(self, kinds, poses, hand_length, step=0.02, mirrored=(), period=0.0,
                 environment=CALM):  # fmt: skip
        """``kinds``: the ``Team``, or its kinds; ``hand_length`` [m] is l, as the drives' points take it.

        ``mirrored``: rows of robots that ``place`` alone moves; ``period`` [s] for which a command is
        held, by default ``step``: a car's tells the steering angle at its end; ``environment``: its current
        carries points in the water.
        """
        self.step, self._period = step, period or step
        self.team = Team.of(kinds, None)
        self._hand_length = hand_length
        self._mirrored = np.array(mirrored, dtype=int)
        self._current = np.zeros((self.team.n, 2))
        for group in self.team.groups:
            if group.drive.MEDIUM == "water":
                self._current[group.rows] = environment.current
        self._current[self._mirrored] = 0.0
        self._drifting = bool(self._current.any())
        self.wheel_travel = [
            np.zeros((len(group.kinds), group.drive.ENCODERS)) for group in self.team.groups
        ]
        self.reset(poses)

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3)."""
        self.pose = np.array(poses, dtype=float)
        self.twist = np.zeros_like(self.pose)

    def joints(self):
        """Return the drives' inner joints, (n,) [rad]: none of them moves."""
        return np.zeros(self.team.n)

    def place(self, rows, poses, twists):
        """Put mirrored robots ``rows`` (m,) at ``poses`` (m, 3) with body ``twists`` (m, 3)."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.pose[rows], self.twist[rows] = poses, twists

    def advance(self, command):
        """Move for one step under ``command`` (n, a); the body twist is the point's velocity."""
        mirrored_twist = self.twist[self._mirrored]
        command = np.array(command, dtype=float)
        command[self._mirrored] = 0.0
        u = self.team.velocity(command, self.pose, self.joints(), self._hand_length, self._period)
        if self._drifting:
            u = u + self._current
        cos, sin = cos_sin(self.pose[:, 2])
        self.pose[:, :2] += self.step * u
        self.twist[:, 0] = cos * u[:, 0] + sin * u[:, 1]
        self.twist[:, 1] = cos * u[:, 1] - sin * u[:, 0]
        self.twist[self._mirrored] = mirrored_twist

    def contacts(self):
        """Return no contacts: points have no bodies."""
        return []

    def closest(self):
        """Return the least distance [m] between two robots' centres now; inf for one robot."""
        return least_distance(self.pose[:, :2])

    def close(self):
        """Nothing is held."""
