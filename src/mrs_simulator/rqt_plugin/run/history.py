"""Newest state and history of a run, without Qt and ROS."""

import copy
from collections import deque

import numpy as np

from mrs_simulator.record.run_changes import ControllerRecord
from mrs_simulator.rqt_plugin.run.estimate_log import EstimateLog
from mrs_simulator.state.columns import COLUMNS, ESTIMATE, REAL, RECORDED
from mrs_simulator.state.layout import Layout
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.verdict.estimation import SAME

MOST_VALUES = 3000000  # [-] numbers held of one run; beyond, every other sample is dropped
FEWEST_SAMPLES = 500
ROUNDING = 1e-6  # [s] that a run's end may lack
MOST_COLLISIONS = 10000
EMPTY = {"pose": np.empty((0, 3)), "twist": np.empty((0, 3)), "command": np.empty((0, 2))}


class History:
    """The samples of a run, bounded: when full, every other sample is dropped."""

    def __init__(self):
        self.before_clearing = lambda: None  # called before the samples are dropped
        self.cleared = 0  # [-] times that :meth:`clear` was called
        self._filled, self._estimate_log = 0, EstimateLog()
        self.applied = ControllerRecord()  # by the controllers of this run
        # the directory to which a program records the run, None where none does
        self.recorded = None
        self.clear()

    def begin_run(self, recorded):
        """Clear everything for a run that is ``recorded`` to a directory, or None."""
        self.clear()
        self.recorded = recorded

    def clear(self):
        """Clear everything."""
        self.cleared += 1
        if self._filled:
            self.before_clearing()
        # What was edited and what the stage published when the run began: later edits are of other runs.
        self.scenario, self.staged = None, None
        self.applied.begin_run()
        self.saved = -np.inf  # [s] up to which the run was saved
        self.moved = -np.inf  # [s] of the newest command that was not zero
        self._take(StateTable(**EMPTY))
        self.begun = None  # begun: [s] at the first command that was not zero
        self.real = frozenset()
        self.collisions = deque(maxlen=MOST_COLLISIONS)
        self.incidents = deque(maxlen=MOST_COLLISIONS)
        self._filled, self._stride, self._skipped = 0, 1, 0
        self._dropped = None  # [s] of the newest sample that was dropped
        self._lent = False  # whether a frozen copy shares the arrays
        self._time, self._table = np.empty(0), np.empty((0, 0, self._layout.width))
        self._estimate = None  # (rows, n, 3) once estimates were received, nan where there is none
        self._estimate_log.clear()

    def append(self, snapshot):
        """Add ``snapshot``, a ``StateTable``; another team, or a time that went back, begins anew.

        Of samples of one time the newest is kept: a command, or the stage's state instead of odometry.
        A full history drops every other sample, but neither the first one nor the last of a run: that comes
        twice, since time stands then.
        """
        newest = self._time[self._filled - 1] if self._filled else -np.inf
        layout = Layout.of_state(snapshot, RECORDED)
        if (snapshot.robots, layout) != (self.numbers, self._layout) or snapshot.time < newest:
            self._begin(snapshot)
        begins = False
        if np.any(snapshot.command):
            begins = self.begun is None
            self.begun = snapshot.time if begins else self.begun
            self.moved = snapshot.time
        self.real = snapshot.numbers_with(REAL)
        if self._filled and snapshot.time == newest:
            self._put(self._filled - 1, snapshot)
            return
        self._skipped += 1
        ends = snapshot.time == self._dropped
        if self._filled and self._skipped < self._stride and not (begins or ends):
            self._dropped = snapshot.time
            return
        self._skipped = 0
        if self._filled == len(self._time):
            self._thin()
        self._time[self._filled] = snapshot.time
        if self._estimate is not None:
            self._estimate[self._filled] = np.nan
        self._put(self._filled, snapshot)
        self._filled += 1

    def _put(self, place, snapshot):
        row = self._table[place]
        for name, at in self._places.items():
            row[:, at] = getattr(snapshot, name)

    def _take(self, snapshot):
        """Take the team and the columns of ``snapshot``."""
        self.numbers, self.axes = snapshot.robots, snapshot.axes
        self._layout = Layout.of_state(snapshot, RECORDED)
        self._places = self._layout.places()

    def _begin(self, snapshot):
        self.clear()
        self._take(snapshot)
        most = MOST_VALUES // (self._layout.width * max(1, len(self.numbers)))
        self._time = np.empty(min(max(FEWEST_SAMPLES, most), 40000))
        self._table = np.empty((len(self._time), len(self.numbers), self._layout.width))

    def fill(self, state):
        """Hold the samples of ``state``, a ``StateTable`` at m times, all of one run, and no others."""
        self.clear()
        self._estimate = state.estimate if state.has(ESTIMATE) else None
        state = state.replace(estimate=None)
        self._take(state.at(0))
        self._time, self._filled = state.time, len(state.time)
        self._table = np.empty((self._filled, len(self.numbers), self._layout.width))
        for name, at in self._places.items():
            values = getattr(state, name)
            self._table[:, :, at] = values[:, np.newaxis] if COLUMNS[name].of_team else values
        self.begun = float(state.time[0])

    def _thin(self):
        first = self.first_row() % 2  # where the run begins
        kept = len(self._time[first::2])
        for name in ("_time", "_table", "_estimate"):
            held = getattr(self, name)
            if held is not None:
                # Frozen copies keep their arrays.
                thinned = np.empty_like(held) if self._lent else held
                thinned[:kept] = held[first::2]
                setattr(self, name, thinned)
        self._lent, self._filled, self._stride = False, kept, 2 * self._stride

    def take_estimates(self, estimates):
        """Add ``estimates`` of the control, each ``(stamp [s], robots' numbers, pose (n, 3))``.

        Each sample gets the estimates that held then, whichever of the two came first.
        """
        for stamp, numbers, pose in estimates:
            if tuple(numbers) == self.numbers:
                self._estimate_log.add(stamp, pose)
        begin = int(np.searchsorted(self.time, self._estimate_log.first - SAME))
        known, poses = self._estimate_log.at(self.time[begin:])
        if not known.any():
            return
        if self._estimate is None:
            self._estimate = np.full((len(self._time), len(self.numbers), 3), np.nan)
        self._estimate[begin : self._filled][known] = poses

    def is_unsaved(self, shortest):
        """Return whether robots were commanded for ``shortest`` [s] that are in no saved run."""
        begun = np.inf if self.begun is None else self.begun
        return bool(self.moved - max(begun, self.saved) >= shortest)

    @property
    def begin(self):
        """Return the time [s] at which the run begins, that of the first sample before any command.

        0 without samples.
        """
        return float(self.time[self.first_row()]) if self._filled else 0.0

    def facts_of_real(self):
        """Return what ``run.json`` says of a run with real robots; nothing where all are simulated."""
        if not self.real:
            return {}
        alone = self.real.issuperset(self.numbers)  # nothing measures collisions of real robots
        return {"real": sorted(self.real), **({"collisions_unknown": True} if alone else {})}

    def lasts(self, duration):
        """Return whether the run, which has begun, is ``duration`` [s] long by now."""
        return self.time[-1] - self.begun >= duration - ROUNDING

    def first_row(self):
        """Return the row where the run begins, with the first command; 0 while there was none."""
        return 0 if self.begun is None else int(np.searchsorted(self.time, self.begun))

    def frozen(self, begin):
        """Return a ``History`` of the samples from row ``begin`` on, not affected by later ones.

        Nothing is copied, which would take a tenth of a second.
        """
        result = self.kept(slice(begin, None))
        result.before_clearing = lambda: None
        result.collisions, self._lent = list(self.collisions), True
        return result

    def kept(self, rows):
        """Return a ``History`` of the samples ``rows`` alone, a slice or (m,) bool, for reading."""
        result = copy.copy(self)
        result._time, result._table = self.time[rows], self._table[: self._filled][rows]
        result._filled = len(result._time)
        if self._estimate is not None:
            result._estimate = self.estimate[rows]
        return result

    def without_estimates(self):
        """Return a ``History`` of the same samples of which no estimates are known."""
        result = copy.copy(self)
        result._estimate = None
        return result

    @property
    def time(self):
        """Return the times (m,) [s]."""
        return self._time[: self._filled]

    @property
    def pose(self):
        """Return the poses (m, n, 3) [m, m, rad]."""
        return self._table[: self._filled, :, self._places["pose"]]

    @property
    def estimate(self):
        """Return the control's estimated poses (m, n, 3), nan where it has none; None without any."""
        return None if self._estimate is None else self._estimate[: self._filled]

    @property
    def state(self):
        """Return the ``StateTable`` of all samples, of views."""
        columns = self._layout.columns_of(self._table[: self._filled])
        estimate, axes = self.estimate, self.axes
        return StateTable(self.time, self.numbers, axes=axes, estimate=estimate, **columns)
