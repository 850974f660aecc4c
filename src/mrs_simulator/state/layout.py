"""Where the columns of a state lie in rows of numbers, as in ``run.csv``."""

from typing import NamedTuple, Tuple

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.state.columns import (
    COLUMNS,
    COMMAND,
    HAND,
    JOINT,
    JOINTS,
    POSE,
    RECORDED,
    always,
    axes_in,
)

STAMPS = ("time", "robot")  # the columns of a file before the numbers
KIND = "kind"  # its last one
BASIC = POSE, HAND, COMMAND  # of every recording


class Layout(NamedTuple):
    """Which columns a row has, in order, and how many numbers each."""

    widths: Tuple[Tuple[str, int], ...]  # by the columns' names
    axes: Tuple[str, ...] = UNICYCLE_AXES  # of commands
    kinds: Tuple[str, ...] = ()  # of the robots, () for a file without that column

    @classmethod
    def of_team(cls, team, is_there, kinds=()):
        """Return the layout of a recording of ``team``; ``is_there(column)``: whether it has a column."""
        counts = ((each, is_there(each) and each.of(team)) for each in RECORDED)
        widths = [(each.name, each.width(count)) for each, count in counts if count]
        return cls(tuple(widths), team.axes, kinds)

    @classmethod
    def of_state(cls, state, columns):
        """Return the layout of the ``columns`` that ``state``, at one time, has."""
        there = [each for each in columns if state.has(each)]
        shapes = [state[each].shape[each.rank :] for each in there]
        widths = [(each.name, *(shape or (1,))) for each, shape in zip(there, shapes)]
        return cls(tuple(widths), state.axes)

    @property
    def names(self):
        """Return the names of all columns of a file, in order."""
        columns = (COLUMNS[name].names(width, self.axes) for name, width in self.widths)
        return sum(columns, STAMPS) + ((KIND,) if self.kinds else ())

    @property
    def width(self):
        """Return how many numbers a row has."""
        return sum(width for _, width in self.widths)

    def also(self, column):
        """Return the layout with all numbers of a ``column``, at its place."""
        widths = {**dict(self.widths), column.name: len(column.csv)}
        there = [(each.name, widths[each.name]) for each in RECORDED if each.name in widths]
        return self._replace(widths=tuple(there))

    def without(self, *columns):
        """Return the layout without ``columns``."""
        names = {column.name for column in columns}
        return self._replace(widths=tuple(each for each in self.widths if each[0] not in names))

    def places(self):
        """Return where in a row each column is, by name: an index where it is flat, else a slice."""
        begin, result = 0, {}
        for name, width in self.widths:
            is_flat = width == 1 and COLUMNS[name].is_flat
            result[name] = begin if is_flat else slice(begin, begin + width)
            begin += width
        return result

    def columns_of(self, table):
        """Return views of the columns in ``table`` (m, n, width), by name; those of the team (m, ...)."""
        robots = {name: 0 if COLUMNS[name].of_team else slice(None) for name, _ in self.widths}
        return {name: table[:, robots[name], at] for name, at in self.places().items()}


def basic_layout(axes=UNICYCLE_AXES):
    """Return the ``Layout`` of poses, controlled points and commands with ``axes`` alone."""
    return Layout(tuple((each.name, each.width(len(axes))) for each in BASIC), axes)


def layout_in(names):
    """Return the ``Layout`` of a file whose first line has ``names``; None if it is no recording.

    Columns of one rule are there together, but for those of each team, which may be newer than the file.
    Kinds are not known yet: one without a name stands for them.
    """
    axes = axes_in(names)
    counts = {column: column.csv[0] in names for column in RECORDED if not callable(column.csv)}
    counts[COMMAND] = len(axes)
    counts[JOINTS] = sum(name.startswith(JOINT) for name in names)
    there = [column for column in RECORDED if counts[column]]
    rules = {(each.of, each.given) for each in there} - {(always, always)}
    if any(
        each in BASIC or (each.of, each.given) in rules for each in RECORDED if not counts[each]
    ):
        return None
    widths = tuple((each.name, each.width(counts[each])) for each in there)
    found = Layout(widths, axes, ("",) if KIND in names else ())
    return found if found.names == tuple(names) else None
