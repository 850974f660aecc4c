"""A team: the robots of a run, each of its kind, grouped by drive."""

import os
from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import TWIST_AXES, UNICYCLE_AXES
from mrs_simulator.core.robots import DEFAULT_KIND
from mrs_simulator.core.run_columns import Columns
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
    rows: Any  # of the robots in the team: EVERY, another slice where that does, else indices (m,)
    columns: Any  # of the drive's axes among the team's, likewise
    kinds: Tuple[Any, ...]
    numbers: (
        Any  # the drive's ``Numbers``: a number is a float if it is the same for all, else (m,)
    )
    limits: AxisLimits  # of the drive's axes

    def of(self, values):
        """Return the group's part (m, axes of the drive) of ``values`` (n, axes of the team)."""
        part = values if self.rows is EVERY else values[self.rows]
        return part if self.columns is EVERY else part[:, self.columns]

    def put(self, values, part):
        """Write the group's ``part`` into ``values`` (n, axes of the team)."""
        if isinstance(self.rows, slice) or isinstance(self.columns, slice):
            values[self.rows, self.columns] = part
        else:
            values[self.rows[:, np.newaxis], self.columns] = part


class Outlines(NamedTuple):
    """The robots' outlines seen from above, [m]; (n,) each, a float where all are the same."""

    front: Any
    rear: Any
    width: Any
    reach: Any
    round: Any  # bool


class Team:
    """The robots of a run; not to be changed.  Arrays hold one robot per row."""

    dimension = 2  # coordinates of the controlled points: no drive leaves the ground

    def __init__(self, kinds, limits="firmware", beside="", own=None):
        """``kinds``: a ``Kind`` or its name for each robot; ``limits`` as in ``kind_limits``.

        ``beside``, ``own``: where kinds that are not shipped are found, as in ``vehicles.kind``.

        Raises ``ValueError`` for an unknown kind.
        """
        found = {}
        self.kinds = tuple(_looked_up(each, found, beside, own) for each in kinds)
        self.n = len(self.kinds)
        distinct = list(dict.fromkeys(self.kinds))
        known = {axis for each in distinct for axis in each.axes}
        self.axes = tuple(axis for axis in TWIST_AXES if axis in known)
        self.robot_axes = self._rows(lambda each: [axis in each.axes for axis in self.axes], bool)
        drives = tuple(dict.fromkeys(each.drive for each in self.kinds))
        of_kind = {each: kind_limits(each, limits) for each in distinct}
        self.groups = tuple(self._group(drive, of_kind, limits) for drive in drives)
        # An axis that a robot does not obey has no limit: its command is 0.
        by_axis = {}
        for each in distinct:
            given = dict(zip(each.axes, of_kind[each]))
            by_axis[each] = tuple(given.get(axis, NO_LIMIT) for axis in self.axes)
        self.limits = stacked([by_axis[each] for each in self.kinds])
        self.timeouts = self._rows(lambda each: each.command_timeout)
        self.reach = self._rows(lambda each: each.body.reach)
        self.speeds = self._speeds()
        self.record_columns = self._record_columns()

    @classmethod
    def of(cls, kinds, limits="firmware"):
        """Return ``kinds`` if it is a team already, else the team of these ``kinds``."""
        return kinds if isinstance(kinds, cls) else cls(kinds, limits)

    @classmethod
    def from_scenario(cls, scenario, limits="scenario"):
        """Return the team of ``scenario``, under its own limits or other ``limits``."""
        limits = scenario.limits if limits == "scenario" else limits
        beside = os.path.dirname(scenario.path) if scenario.path else ""
        return cls(scenario.kinds, limits, beside, scenario.own_kinds)

    def __deepcopy__(self, memo):
        return self

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
        kinds = tuple(self.kinds[row] for row in rows)
        columns = [self.axes.index(axis) for axis in module.AXES]
        numbers = columns_of(kinds, module)
        return Group(
            module,
            EVERY if len(rows) == self.n else _places(rows),
            EVERY if len(columns) == len(self.axes) else _places(columns),
            kinds,
            numbers if limits is not None else module.unlimited(numbers),
            stacked([of_kind[each] for each in kinds]),
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
    def has_joints(self):
        """Return whether a drive has an inner joint that moves, such as a steering angle."""
        return any(group.drive.JOINTS for group in self.groups)

    @property
    def is_of_unicycles(self):
        """Return whether all robots obey ``(v, omega)`` and have hand points."""
        return self.axes == UNICYCLE_AXES and not self.has_joints

    def _record_columns(self):
        """Return the ``Columns`` that a recording of these robots needs."""
        names = tuple(each.name for each in self.kinds)
        return Columns(
            axes=self.axes,
            twist=not self.is_of_unicycles,
            joints=self.has_joints,
            kinds=names if set(names) != {DEFAULT_KIND} else (),
        )

    def lead(self, l):
        """Return how far [m] the controlled points are from the centres at most, () or (n,)."""
        leads = self._each(
            lambda g, rows: np.broadcast_to(g.drive.lead(l, g.numbers), len(g.kinds))
        )
        return shared(leads.tolist())

    def point(self, pose, joints, l):
        """Return the controlled points (..., n, 2) [m] of robots at ``pose`` (..., n, 3)."""
        if len(self.groups) == 1:
            (g,) = self.groups
            return g.drive.point(pose, joints, l, g.numbers)
        result = np.empty(pose.shape[:-1] + (2,), order="F")
        for g in self.groups:
            own = g.drive.point(pose[..., g.rows, :], joints[g.rows], l, g.numbers)
            result[..., g.rows, :] = own
        return result

    def velocity(self, command, pose, joints, l, period):
        """Return the points' velocities (n, 2) [m/s] under ``command`` (n, a)."""
        return self._each(
            lambda g, rows: g.drive.velocity(
                g.of(command), pose[rows], joints[rows], l, period, g.numbers
            ),
            (2,),
        )

    def velocities_in(self, command, pose, points, l, period):
        """Return the points' velocities (k, n, 2) [m/s] under recorded commands (k, n, a).

        ``pose`` (k, n, 3) and ``points`` (k, n, 2) as recorded, from which inner joints follow.
        """
        result = np.empty(points.shape)
        for g in self.groups:
            shape = (-1, len(g.kinds))
            own = command[:, g.rows][..., g.columns], pose[:, g.rows], points[:, g.rows]
            numbers = g.numbers._replace(**{
                key: _tiled(getattr(g.numbers, key), len(command)) for key in g.drive.COLUMNS
            })  # fmt: skip
            flat = [values.reshape(-1, values.shape[-1]) for values in own]
            joints = g.drive.joints_seen(flat[1], flat[2], l, numbers)
            found = g.drive.velocity(flat[0], flat[1], joints, l, period, numbers)
            result[:, g.rows] = found.reshape(shape + (2,))
        return result

    def command(self, velocity, pose, joints, l, period):
        """Return the commands (n, a) that give the points ``velocity`` (n, 2) [m/s]."""
        if len(self.groups) == 1:
            (g,) = self.groups
            return g.drive.command(velocity, pose, joints, l, period, g.numbers)
        result = np.zeros((self.n, len(self.axes)), order="F")
        for g in self.groups:
            rows = g.rows
            own = g.drive.command(velocity[rows], pose[rows], joints[rows], l, period, g.numbers)
            g.put(result, own)
        return result

    def excess(self, command, joints, period):
        """Return by which factor each ``command`` (n, a) is beyond its robot's limits, (n,).

        ``joints`` (n,) [rad] now; ``period`` [s] for which the command is held.
        """
        return self._each(
            lambda g, rows: g.drive.excess(
                g.of(command), joints[rows], g.limits.top, g.numbers, period
            )
        )

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
        if len(self.groups) == 1:
            (g,) = self.groups
            return g.drive.slowed(command, factor, joints, g.numbers)
        result = command.copy(order="K")
        for g in self.groups:
            by = factor[g.rows]
            if g.drive.JOINTS or np.maximum.reduce(by) > 1.0:
                g.put(result, g.drive.slowed(g.of(command), by, joints[g.rows], g.numbers))
        return result

    def joints_after(self, command, joints, period):
        """Return the drives' inner joints, (n,) [rad], after ``period`` [s] of ``command`` (n, a)."""
        result = joints.copy()
        for g in self.groups:
            if g.drive.JOINTS:
                after = g.drive.joints_after(g.of(command), joints[g.rows], g.numbers, period)
                result[g.rows] = after
        return result

    def _each(self, of_group, width=()):
        """Return what ``of_group`` gives for each group, as one array (n,) + ``width``."""
        if len(self.groups) == 1:
            return of_group(self.groups[0], EVERY)
        result = np.empty((self.n,) + width, order="F")
        for group in self.groups:
            result[group.rows] = of_group(group, group.rows)
        return result


def _places(indices):
    """Return ascending ``indices`` as a slice if they are evenly spaced, which is quicker, else (m,)."""
    steps = set(np.diff(indices).tolist()) or {1}
    if len(steps) == 1:
        return slice(indices[0], indices[-1] + 1, steps.pop())
    return np.array(indices)


def _length(values):
    """Return the length of each row of ``values``, to the bit where only one is not 0."""
    if values.shape[1] == 1:
        return values[:, 0]
    return np.sqrt(np.square(values).sum(axis=1))


def columns_of(kinds, module):
    """Return the drive's ``Numbers`` of ``kinds``, column by column."""
    first = kinds[0].numbers
    given = {key: shared([getattr(each.numbers, key) for each in kinds]) for key in module.COLUMNS}
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


def joined(team, parts):
    """Return the ``parts`` (m,) of the team's groups as one array (n,)."""
    if len(parts) == 1:
        return parts[0]
    result = np.empty(team.n)
    for group, part in zip(team.groups, parts):
        result[group.rows] = part
    return result


def _looked_up(name, found, beside, own):
    if name not in found:
        found[name] = kind(name, beside, own)
    return found[name]
