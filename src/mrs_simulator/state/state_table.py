"""The state of a team: its columns, as arrays of one robot per row."""

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.state.columns import COLUMNS, GROUPS


class StateTable:
    """Columns of n robots at one time, (n, ...), or at each of m times, (m, n, ...).

    ``state.pose`` and ``state[POSE]`` are the same array.  A column that these robots do not have is
    absent.  A ``Group`` is read as its named tuple, ``state.spatial``, and given as one.
    """

    def __init__(self, time=None, robots=(), kinds=(), axes=UNICYCLE_AXES, **columns):
        """``time`` [s]; ``robots``: their numbers; ``kinds``: their names, () where unknown.

        ``axes``: those of commands; ``columns``: arrays by the names of columns, named tuples by those of
        groups; None for one that is absent.
        """
        self.time, self.robots, self.kinds, self.axes = time, robots, kinds, axes
        self._put(columns)

    def _put(self, columns):
        own = self.__dict__
        for name, value in columns.items():
            if name in GROUPS:
                group = GROUPS[name].columns
                self._put(dict(zip(group, (None,) * len(group) if value is None else value)))
            elif name not in COLUMNS and name not in own:
                raise TypeError(unknown_name("a state", name, [*COLUMNS, *GROUPS]))
            elif value is None and name in COLUMNS:
                own.pop(name, None)
            else:
                own[name] = value

    def has(self, column):
        """Return whether there is this ``Column`` or ``Group``."""
        return all(name in self.__dict__ for name in getattr(column, "columns", (column.name,)))

    def __getitem__(self, column):
        return getattr(self, column.name)

    def __getattr__(self, name):  # of what is no attribute
        if name in GROUPS and self.has(GROUPS[name]):
            group = GROUPS[name]
            return group.kind(*(getattr(self, each) for each in group.columns))
        raise AttributeError(
            "no {} in this state, which has {}".format(name, ", ".join(vars(self)))
        )

    def replace(self, **changes):
        """Return a state with other values of these attributes or columns; None takes a column away."""
        result = self._twin()
        result._put(changes)
        return result

    def _twin(self):
        """Return a state with the same arrays; ``copy.copy`` takes five times as long."""
        result = object.__new__(type(self))
        result.__dict__.update(self.__dict__)
        return result

    def at(self, rows):
        """Return the samples ``rows`` of a state at m times: an index, a slice or a mask."""
        own = vars(self)
        return self.replace(**{name: own[name][rows] for name in SAMPLED.keys() & own.keys()})

    def numbers_with(self, flag):
        """Return the numbers of the robots of which the column ``flag`` is true, none without it."""
        if not self.has(flag):
            return frozenset()
        return frozenset(number for number, true in zip(self.robots, self[flag]) if true)

    def copy(self):
        """Return a state with its own arrays."""
        result = self._twin()
        own = result.__dict__
        own.update([(name, np.array(value)) for name, value in own.items() if name in COLUMNS])
        return result

    def first_infinite(self):
        """Return a column's name and the first row in which it is not finite; None without any."""
        for name, values in vars(self).items():
            if name in COLUMNS and not np.isfinite(values).all():
                return name, int(np.argwhere(~np.isfinite(values))[0, 0])
        return None

    @property
    def heights(self):
        """Return the heights (..., n) [m] above the ground."""
        return self.__dict__.get("z", np.zeros(self.pose.shape[:-1]))


SAMPLED = {"time": float, **{name: column.kind for name, column in COLUMNS.items()}}


def stacked(states):
    """Return the state at m times of a list of ``states`` of one team, with the columns that all have."""
    own = [vars(state) for state in states]
    common = {name: all(name in each for each in own) for name in SAMPLED}
    columns = {
        name: np.array([each[name] for each in own], dtype=SAMPLED[name]) if there else None
        for name, there in common.items()
    }
    return states[0].replace(**columns)
