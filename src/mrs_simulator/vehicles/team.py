"""A team: the robots of a run, each of its kind, grouped by drive."""

import functools
from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.arrays import read_only
from mrs_simulator.core.kinematics import TWIST_AXES, UNICYCLE_AXES, cos_sin, max_abs
from mrs_simulator.core.snapshots import Constant
from mrs_simulator.core.spatial import upright
from mrs_simulator.scenario.team.robots import DEFAULT_KIND
from mrs_simulator.state.columns import JOINTS, SPATIAL, Z
from mrs_simulator.state.layout import Layout
from mrs_simulator.vehicles.drives import drive_module
from mrs_simulator.vehicles.kind import AxisLimit
from mrs_simulator.vehicles.limits import AxisLimits, kind_limits, stacked
from mrs_simulator.vehicles.registry import kind

NO_LIMIT = AxisLimit(np.inf, np.inf)
EVERY = slice(None)


def on_all_axes(command, axes):
    """Return ``command`` (n, a), whose columns are ``axes``, as all components of Twist, (n, 6)."""
    result = np.zeros((len(command), len(TWIST_AXES)))
    result[:, [TWIST_AXES.index(axis) for axis in axes]] = command
    return result


def on_axes(command, axes, wanted):
    """Return ``command`` (n, a), whose columns are ``axes``, with the columns ``wanted``; 0 for more."""
    if axes == wanted:
        return command
    return on_all_axes(command, axes)[:, [TWIST_AXES.index(axis) for axis in wanted]]


class Group(NamedTuple):
    """The robots of one drive."""

    drive: Any  # the module
    rows: Any  # of the robots in the team: EVERY, else indices (m,)
    span: slice  # of the robots where those of one drive come together: ``Team.by_group``
    columns: Any  # of the drive's axes among the team's: EVERY, another slice where that does, or indices
    kinds: Tuple[Any, ...]
    numbers: Any  # the drive's parameters: those that its functions use are columns (m,)
    limits: AxisLimits  # of the drive's axes, (m, axes)

    def of(self, values):
        """Return the group's part (m, axes of the drive) of ``values`` (n, axes of the team)."""
        # Column by column in memory, without gaps: numpy is three times as fast then.
        own = values.T if self.columns is EVERY else values.T[self.columns]
        return own.T if self.rows is EVERY else own.take(self.rows, axis=1).T

    def part(self, values):
        """Return the group's part (m, axes of the drive) of ``values`` (n, a) that lie group after group.

        Read only: unevenly spaced columns are a copy.  :meth:`fill` writes.
        """
        if self.rows is EVERY:
            return values
        own = values[self.span, self.columns]
        own.flags.writeable = False  # writing to a copy would be lost silently
        return own

    def fill(self, values, part):
        """Write the group's ``part`` into ``values`` (n, a) that lie group after group."""
        values[self.span, self.columns] = part

    def inner_command(self, command, joints):
        """Return the inner states of the group's ``command``, both (m, axes of the drive)."""
        if self.drive.JOINTS:
            return self.drive.inner_command(command, joints, self.numbers)
        return command

    def wanted(self, along, across, joints, l, period):
        """Return the inner states (m, axes of the drive) that move the points ``along`` and ``across``."""
        function = self.drive.wanted if self.drive.JOINTS else self.drive.command
        return function(along, across, joints, l, period, self.numbers)

    def velocities(self, inner):
        """Return the velocities along the drive's axes of ``inner`` states, (m, axes of the drive)."""
        return self.drive.velocities(inner, self.numbers) if self.drive.JOINTS else inner

    def joints_of(self, inner):
        """Return the inner joints (m,) [rad] of ``inner`` states, 0 where the drive has none."""
        return self.drive.joints_of(inner) if self.drive.JOINTS else np.zeros(len(inner))

    def at(self, values):
        """Return the group's rows of ``values`` (..., n, a): (..., m, a)."""
        return values if self.rows is EVERY else values.T.take(self.rows, axis=1).T

    def put(self, values, part):
        """Write the group's ``part`` into ``values`` (n, axes of the team)."""
        columns = np.arange(values.shape[1])[self.columns]
        for column, own in zip(columns.tolist(), part.T):
            values[self.rows, column] = own


class Outlines(NamedTuple):
    """The robots' outlines seen from above, [m]; (n,) each, a float where all are the same."""

    front: Any
    rear: Any
    width: Any
    reach: Any
    round: Any  # bool


class Team(Constant):
    """The robots of a run; not to be changed.  Arrays hold one robot per row."""

    # coordinates of the controlled points: robots in the air fly such laws at their altitude
    dimension = 2
    has_arms = False
    # whether limits of each axis are all that there are, and no axis is without
    _is_bounded = False

    def __init__(self, kinds, limits="firmware", relative_to="", own=None):
        """``kinds``: a ``Kind`` or its name for each robot; ``limits`` as in ``kind_limits``.

        ``relative_to``, ``own``: where kinds that are not shipped are found, as in ``vehicles.kind``.

        Raises ``ValueError`` for an unknown kind.
        """
        found = {}
        self.kinds = tuple(_looked_up(each, found, relative_to, own) for each in kinds)
        self.n = len(self.kinds)
        distinct = list(dict.fromkeys(self.kinds))
        known = {axis for each in distinct for axis in each.axes}
        self.axes = tuple(axis for axis in TWIST_AXES if axis in known)
        self.robot_axes = self._rows(lambda each: [axis in each.axes for axis in self.axes], bool)
        drives = tuple(dict.fromkeys(each.drive for each in self.kinds))
        of_kind = {each: kind_limits(each, limits) for each in distinct}
        order = sorted(range(self.n), key=lambda row: drives.index(self.kinds[row].drive))
        self._order, self._place = np.array(order), np.argsort(order)
        self.groups = tuple(self._group(drive, of_kind, limits) for drive in drives)
        if len(self.groups) == 1:
            del self._order, self._place  # large, and needed by several groups alone
        # Whether a drive has an inner joint that moves, such as a steering angle.
        self.jointed = tuple(group for group in self.groups if group.drive.JOINTS)
        self.has_joints = bool(self.jointed)
        # Whether jointed robots are limited by their inner states alone.
        self.limits_joints = self.has_joints and not any(map(_limits_other_axes, self.jointed))
        self._limited = tuple(g for g in self.groups if g.drive.OWN_LIMITS or g.drive.JOINTS)
        # An axis that a robot ignores has no limit: its command is 0.
        by_axis = {}
        for each in distinct:
            given = dict(zip(each.axes, of_kind[each]))
            by_axis[each] = tuple(given.get(axis, NO_LIMIT) for axis in self.axes)
        self.limits = stacked([by_axis[each] for each in self.kinds])
        self.timeouts = self._rows(lambda each: each.command_timeout)
        self.reach = self._rows(lambda each: each.body.reach)
        self.speeds = self._speeds()
        self.airborne = self._rows(lambda each: each.module.MEDIUM == "air", bool)
        self.afloat = self._rows(lambda each: each.module.MEDIUM == "water", bool)
        self.is_spatial = bool(self.airborne.any())
        # Of all components of a Twist: where the axes are, and which a robot ignores, (n, 6) bool.
        self.components = _places([TWIST_AXES.index(axis) for axis in self.axes])
        self.ignored_axes = np.ones((self.n, len(TWIST_AXES)), dtype=bool)
        self.ignored_axes[:, self.components] = ~self.robot_axes
        self._top = self.by_group(lambda group: group.limits.top, np.inf)
        self._is_bounded = bool(
            not self._limited and (self._top > 0.0).all() and (self._top < np.inf).all()
        )
        self._pivots = np.zeros(self.n)  # [m] ahead of the centres, about which the points turn
        for group in self.jointed:
            self._pivots[group.rows] = group.drive.pivot(group.numbers)
        self.rest_joints = np.zeros(self.n)  # [rad], initial inner joints
        self._arms_of, self._leads_of = {}, {}  # by l, of the last l

    @classmethod
    def of(cls, kinds, limits="firmware"):
        """Return ``kinds`` if it is a team already, else the team of these ``kinds``."""
        return kinds if isinstance(kinds, cls) else cls(kinds, limits)

    @classmethod
    def from_scenario(cls, scenario, limits="scenario"):
        """Return the team of ``scenario``, under its own limits or other ``limits``."""
        limits = scenario.limits if limits == "scenario" else limits
        return cls(scenario.kinds, limits, scenario.directory, scenario.own_kinds)

    def _rows(self, value, dtype=float):
        """Return ``value`` of each robot's kind as an array (n, ...)."""
        of_kind = {each: value(each) for each in dict.fromkeys(self.kinds)}
        return np.array([of_kind[each] for each in self.kinds], dtype=dtype)

    def _speeds(self):
        """Return bounds of the robots' speeds and turn rates, (n, 2) [m/s, rad/s]."""
        top = np.where(self.robot_axes, self.limits.top, 0.0)
        linear = np.array([axis.startswith("linear") for axis in self.axes])
        across = [top[:, linear], top[:, ~linear]]
        return np.stack([_length(values) for values in across], axis=1)

    def _group(self, drive, of_kind, limits):
        module = drive_module(drive)
        rows = [row for row, each in enumerate(self.kinds) if each.drive == drive]
        begin = self._place[rows[0]]
        kinds = tuple(self.kinds[row] for row in rows)
        columns = [self.axes.index(axis) for axis in module.AXES]
        numbers = columns_of(kinds, module)
        return Group(
            module,
            EVERY if len(rows) == self.n else np.array(rows),
            slice(begin, begin + len(rows)),
            EVERY if len(columns) == len(self.axes) else _places(columns),
            kinds,
            numbers if limits is not None else module.unlimited(numbers),
            stacked([of_kind[each] for each in kinds]).of_all(len(kinds)),
        )

    @property
    def notes(self):
        """Return what users of the robots' kinds should know, a list of texts."""
        return [note for each in dict.fromkeys(self.kinds) for note in each.notes]

    @property
    def outlines(self):
        """Return the robots' ``Outlines``."""
        bodies = [each.body for each in self.kinds]
        return Outlines(
            *(shared([getattr(body, key) for body in bodies]) for key in Outlines._fields)
        )

    @property
    def is_of_unicycles(self):
        """Return whether all robots follow ``(v, omega)`` and have hand points."""
        hands = all(group.drive.POINT == "hand point" for group in self.groups)
        return self.axes == UNICYCLE_AXES and hands and not self.has_joints

    @property
    def lateness(self):
        """Return the greatest lag [s] of robots in water or air, by their time constants; else 0."""
        late = [g.drive.lateness(g.numbers) for g in self.groups if hasattr(g.drive, "lateness")]
        return max(late, default=0.0)

    def tracking(self, speed):
        """Return the greatest lag (n,) [m] of robots behind velocities of up to ``speed`` (n,) [m/s].

        0 for drives without one.
        """
        result = np.zeros(self.n)
        for g in self.groups:
            if hasattr(g.drive, "tracking"):
                result[g.rows] = g.drive.tracking(speed[g.rows], g.numbers)
        return result

    @property
    def downwash(self):
        """Return the greatest ratio of vertical to horizontal clearance between robots."""
        factors = [getattr(g.numbers, "downwash", 1.0) for g in self.groups]
        return float(max(np.max(factor) for factor in factors))

    @property
    def landing(self):
        """Return the commands (n, a) with which robots that fly come down, 0 for all others."""
        result = np.zeros((self.n, len(self.axes)))
        for g in self.groups:
            if hasattr(g.drive, "landing"):
                g.put(result, g.drive.landing(len(g.kinds), g.numbers))
        return result

    def layout(self, is_there):
        """Return the ``Layout`` of a recording of these robots.

        ``is_there(column)``: whether there is a ``Column``, as a scenario or a state has it.
        """
        names = tuple(each.name for each in self.kinds)
        return Layout.of_team(self, is_there, names if set(names) != {DEFAULT_KIND} else ())

    def recorded(self, state, l):
        """Return ``state``, at one time, with the controlled points that a recording has.

        With arms it has columns of space in any case.
        """
        joints = state.joints if state.has(JOINTS) else 0.0
        hand = self.point(state.pose, joints, l)[:, :2]
        if not self.has_arms:
            return state.replace(hand=hand, point_z=state.z if state.has(Z) else None)
        if not state.has(SPATIAL):
            state = state.replace(spatial=upright(state.pose[:, 2]))
        height = self.tools(state.pose, state.joints, l)[:, 2]
        return state.replace(hand=hand, point_z=state.z + height)

    def by_group(self, of_group, fill=0.0):
        """Return values (n, a), group after group, of which ``of_group(group)`` is each group's part.

        (m, axes of the drive); ``fill``: the value for axes that a group does not have.
        """
        if len(self.groups) == 1:
            return of_group(self.groups[0])
        values = np.zeros((self.n, len(self.axes)), order="F")
        if fill:
            values.fill(fill)
        for group in self.groups:
            group.fill(values, of_group(group))
        return values

    def in_rows(self, by_group):
        """Return values (n, ...) that lie ``by_group``, group after group, in the robots' order."""
        return by_group if len(self.groups) == 1 else by_group.T.take(self._place, axis=-1).T

    def grouped(self, values):
        """Return ``values`` (n, ...), in the robots' order, group after group; undoes ``in_rows``."""
        if len(self.groups) == 1:
            return values
        return values[self._order] if values.ndim == 1 else values.T.take(self._order, axis=-1).T

    def joints_of(self, inner):
        """Return the drives' inner joints, (n,) [rad], 0 where none is, of the groups' ``inner`` states."""
        joints = np.zeros(self.n)
        for group, own in zip(self.groups, inner):
            if group.drive.JOINTS:
                joints[group.rows] = group.joints_of(own)
        return joints

    def lead(self, l):
        """Return how far [m] the controlled points are from the centres at most, () or (n,)."""
        if l not in self._leads_of:
            leads = np.empty(self.n)
            for g in self.groups:
                leads[g.rows] = g.drive.lead(l, g.numbers)
            self._leads_of = {l: read_only(leads) if (leads != leads[0]).any() else float(leads[0])}
        return self._leads_of[l]

    def pointing(self, pose, joints):
        """Return cosine and sine of the headings in which the points' arms lie, (..., n)."""
        heading = pose[..., 2]
        return cos_sin(heading + joints if self.has_joints else heading)

    def point(self, pose, joints, l, pointing=None):
        """Return the controlled points (..., n, 2) [m] of robots at ``pose`` (..., n, 3).

        Each is an arm's length ahead of its robot's centre, or, where there are joints, of a pivot ahead
        of that.  ``pointing``: what :meth:`pointing` returns, to save computing it again.
        """
        arm, x, y = self._arms(l), pose[..., 0], pose[..., 1]
        if arm is None:
            return pose[..., :2].copy(order="F")
        if self.has_joints:
            cos, sin = cos_sin(pose[..., 2])
            x, y = x + self._pivots * cos, y + self._pivots * sin
        cos, sin = pointing or self.pointing(pose, joints)
        result = np.empty(pose.shape[:-1] + (2,), order="F")
        for place, turn, at in ((x, cos, result[..., 0]), (y, sin, result[..., 1])):
            np.multiply(arm, turn, at)
            np.add(place, at, at)
        return result

    def _arms(self, l):
        """Return the lengths [m] of the points' arms, (n,); None where all are 0."""
        if l not in self._arms_of:
            arms = np.empty(self.n)
            for g in self.groups:
                arms[g.rows] = g.drive.arm(l, g.numbers)
            self._arms_of = {l: arms if arms.any() else None}
        return self._arms_of[l]

    def velocity(self, command, pose, joints, l, period):
        """Return the points' velocities (n, 2) [m/s] under ``command`` (n, a)."""
        along, across = np.empty(self.n), np.empty(self.n)
        for g in self.groups:
            own = g.of(command), joints[g.rows]
            along[g.rows], across[g.rows] = g.drive.velocity(*own, l, period, g.numbers)
        return _turned(along, across, *self.pointing(pose, joints))

    def command(self, velocity, pose, joints, l, period, pointing=None):
        """Return the commands (n, a) that give the points ``velocity`` (n, 2) [m/s].

        ``pointing`` as in :meth:`point`.
        """
        along, across = _along(velocity, *(pointing or self.pointing(pose, joints)))
        if len(self.groups) == 1:
            (group,) = self.groups
            return group.drive.command(along, across, joints, l, period, group.numbers)
        along, across, joints = map(self.grouped, (along, across, joints))
        return self.in_rows(self.by_group(lambda g: g.drive.command(
            along[g.span], across[g.span], joints[g.span], l, period, g.numbers
        )))  # fmt: skip

    def command_within(self, velocity, pose, joints, l, period, scope, pointing=None):
        """Return :meth:`command` after :meth:`saturated`, but for the last bits, in less time.

        A steering angle is limited as it is, not through the turn rate.
        """
        along, across = _along(velocity, *(pointing or self.pointing(pose, joints)))
        along, across, joints = map(self.grouped, (along, across, joints))
        inner_command, own = np.zeros((self.n, len(self.axes)), order="F"), []
        for g in self.groups:
            at = joints[g.span]
            part = g.wanted(along[g.span], across[g.span], at, l, period)
            g.fill(inner_command, part)
            own.append((g, part, at))
        return self._limited_by(scope, inner_command, period, own)

    def velocities_in(self, command, pose, points, l, period):
        """Return the points' velocities (k, n, 2) [m/s] under recorded commands (k, n, a).

        ``pose`` (k, n, 3) and ``points`` (k, n, 2) as recorded, from which inner joints follow.
        """
        result = np.empty(points.shape)
        for g in self.groups:
            own, headings, joints, numbers = _recorded(g, command, pose, points, l)
            along_across = g.drive.velocity(own, joints, l, period, numbers)
            found = _turned(*along_across, *cos_sin(headings + joints))
            result[:, g.rows] = found.reshape((-1, len(g.kinds), 2))
        return result

    def limits_in(self, command, pose, points, l, period, share=1.0):
        """Return where recorded commands have reached ``share`` of a limit, (k, n) bool.

        As :meth:`at_limits`, also of the rates of joints, which a single command does not show.
        Arguments as of :meth:`velocities_in`.
        """
        result = self.at_limits(command, share)
        for g in self.jointed:
            if not g.drive.OWN_LIMITS:
                continue
            own, _, joints, numbers = _recorded(g, command, pose, points, l)
            inner_command = g.drive.inner_command(own, joints, numbers)
            factor = g.drive.excess(inner_command, joints, numbers, period)
            result[:, g.rows] |= factor.reshape(-1, len(g.kinds)) >= share
        return result

    def excess(self, command, joints, period):
        """Return by which factor each ``command`` (n, a) is beyond its robot's limits, (n,).

        ``joints`` (n,) [rad] now; ``period`` [s] for which the command is held.
        """
        command = self.grouped(command)
        return self.in_rows(self._excess(command, period, self._own(command, joints)))

    def _own(self, command, joints):
        """Return the groups with own limits or joints, the inner states of ``command``, and joints.

        ``command`` (n, a) lies group after group here and below, ``joints`` (n,) in the robots' order.
        """
        if not self._limited:
            return ()
        joints = self.grouped(joints)
        own = [(g, joints[g.span]) for g in self._limited]
        return [(g, g.inner_command(g.part(command), at), at) for g, at in own]

    def _excess(self, command, period, own):
        factor = functools.reduce(np.maximum, (np.abs(command) / self._top).T)
        for g, inner_command, joints in own:
            if g.drive.OWN_LIMITS:
                part = factor[g.span]
                np.maximum(part, g.drive.excess(inner_command, joints, g.numbers, period), out=part)
        return factor

    def at_limits(self, command, share=1.0):
        """Return where a ``command`` (..., n, a) has reached ``share`` of a limit, (..., n) bool."""
        result = np.zeros(command.shape[:-1], dtype=bool)
        for g in self.groups:
            own = command[..., g.rows, :][..., g.columns]
            result[..., g.rows] = g.drive.at_limits(own, g.limits.top, g.numbers, share)
        return result

    def slowed(self, command, factor, joints):
        """Return ``command`` (n, a) with the speeds divided by ``factor`` (n,), at least 1.

        The points move in the same directions, more slowly.
        """
        command = self.grouped(command)
        own, factor = self._own(command, joints), self.grouped(np.asarray(factor))
        return self.in_rows(_slowed(command, factor, own))

    def saturated(self, command, joints, period, scope):
        """Return ``command`` (n, a), held for ``period`` [s], within each robot's limits.

        ``scope``: each robot slowed by a factor of its own, "robot", or all by the greatest, "team".
        """
        command = self.grouped(command)
        return self._limited_by(scope, command, period, self._own(command, joints))

    def is_within(self, command):
        """Return whether ``command`` (n, a) is finite and sure to be within each robot's limits.

        ``False`` means unknown, as with axes without limits, or a drive's own limits.
        """
        return self._is_bounded and max_abs(self.grouped(command) / self._top) <= 1.0

    def _limited_by(self, scope, command, period, own):
        factor = np.maximum(self._excess(command, period, own), 1.0)
        if scope == "team":
            factor = np.full(self.n, factor.max())
        return self.in_rows(_slowed(command, factor, own))

    def joints_after(self, command, joints, period):
        """Return the drives' inner joints, (n,) [rad], after ``period`` [s] of ``command`` (n, a)."""
        result = joints.copy()
        for g in self.jointed:
            own = g.of(command), joints[g.rows]
            result[g.rows] = g.drive.joints_after(*own, g.numbers, period)
        return result


def _recorded(group, command, pose, points, l):
    """Return commands, headings, inner joints and numbers of the robots of ``group``, sample by sample.

    Arguments as of ``Team.velocities_in``; all results have one row for each sample and robot.
    """
    numbers = group.numbers._replace(**{
        key: _tiled(getattr(group.numbers, key), len(command)) for key in group.drive.COLUMNS
    })  # fmt: skip
    own = command[:, group.rows][..., group.columns], pose[:, group.rows], points[:, group.rows]
    command, pose, points = (values.reshape(-1, values.shape[-1]) for values in own)
    joints = np.zeros(len(pose))
    if group.drive.JOINTS:
        joints = group.drive.joints_seen(pose, points, l, numbers)
    return command, pose[:, 2], joints, numbers


def _limits_other_axes(group):
    """Return whether axes are limited of which the group's drive has no limits."""
    others = [axis not in group.drive.LIMIT_AXES for axis in group.drive.AXES]
    return bool(np.isfinite(group.limits.top[:, others]).any())


def _slowed(command, factor, own):
    result = (command.T / factor).T
    for g, inner_command, joints in own:
        if g.drive.JOINTS:
            g.fill(result, g.drive.slowed(inner_command, factor[g.span], joints, g.numbers))
    return result


def _places(indices):
    """Return ascending ``indices`` as a slice if they are evenly spaced, which is quicker, else (m,)."""
    steps = set(np.diff(indices).tolist()) or {1}
    if len(steps) == 1:
        return slice(indices[0], indices[-1] + 1, steps.pop())
    return np.array(indices)


def _along(velocity, cos, sin):
    """Return the components (n,) of ``velocity`` (n, 2) along and across directions of ``cos``, ``sin``."""
    x, y = velocity[:, 0], velocity[:, 1]
    return cos * x + sin * y, cos * y - sin * x


def _turned(along, across, cos, sin):
    """Return vectors (n, 2) of components ``along`` and ``across`` directions of ``cos`` and ``sin``."""
    result = np.empty((len(along), 2), order="F")
    result[:, 0], result[:, 1] = cos * along - sin * across, sin * along + cos * across
    return result


def _length(values):
    """Return the length of each row of ``values``, to the bit where only one is not 0."""
    if values.shape[1] == 1:
        return values[:, 0]
    return np.sqrt(np.square(values).sum(axis=1))


def columns_of(kinds, module):
    """Return the drive's parameters of ``kinds``, column by column."""
    first = kinds[0].numbers
    given = {key: shared([getattr(each.numbers, key) for each in kinds]) for key in module.COLUMNS}
    # numpy takes two arrays of one shape in half the time that it takes an array and a number.
    given = {
        key: np.full(len(kinds), value) if isinstance(value, (float, int)) else value
        for key, value in given.items()
    }
    return first._replace(**given)


def _tiled(number, count):
    """Return a column of numbers ``count`` times over; one number, or one matrix, as it is."""
    if not isinstance(number, np.ndarray):
        return number
    return np.tile(number, (count,) + (1,) * (number.ndim - 1))


def shared(values):
    """Return the value that all ``values`` are, else all of them as an array (n,)."""
    first = values[0]
    return first if all(value == first for value in values) else np.array(values)


def _looked_up(name, found, relative_to, own):
    if name not in found:
        found[name] = kind(name, relative_to, own)
    return found[name]
