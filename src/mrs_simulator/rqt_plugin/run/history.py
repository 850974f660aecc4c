"""Newest state and history of a run, without Qt and ROS."""

import copy
from collections import deque
from typing import FrozenSet, NamedTuple, Optional, Tuple, Union

import numpy as np

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.core.spatial import Spatial
from mrs_simulator.record.run_changes import ControllerRecord
from mrs_simulator.rqt_plugin.run.estimate_log import EstimateLog
from mrs_simulator.state.columns import LoadState
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.verdict.estimation import SAME

MOST_VALUES = 3000000  # [-] numbers held of one run; beyond, every other sample is dropped
FEWEST_SAMPLES = 500
MOST_COLLISIONS = 10000
STATE = 7  # [-] columns of a sample before those of the command: pose 3, twist 3, joint
LOADED = (
    10  # [-] columns after those of robots that carry a load: force 3, its place 3, orientation 4
)
IN_SPACE = 8  # [-] columns after it, of robots that leave the ground: z, orientation 4, twist 3


class Snapshot(NamedTuple):
    """The team at one time; arrays hold one robot per row."""

    time: float  # [s] of the stage; of real robots alone since the first message
    numbers: Tuple[int, ...]
    pose: np.ndarray  # (n, 3) [m, m, rad], common frame
    twist: np.ndarray  # (n, 3) [m/s, m/s, rad/s], robot's frame
    command: np.ndarray  # (n, a) [m/s, rad/s]
    fresh: np.ndarray  # (n,) bool, whether there is recent data of the robot
    real: FrozenSet[int] = frozenset()  # numbers of the robots that are not simulated
    axes: Tuple[str, ...] = (
        UNICYCLE_AXES  # the components of Twist that commands have, those of arms last
    )
    joints: Union[np.ndarray, float] = 0.0  # (n,) [rad]; (n, 1 + k) of robots with arms
    spatial: Optional[Spatial] = None  # None for a team on the ground
    load: Optional[LoadState] = None  # what robots carry together


class History:
    """The samples of a run, bounded: when full, every other sample is dropped."""

    def __init__(self):
        self.before_clearing = lambda: None  # called before the samples are dropped
        self._filled, self._estimate_log = 0, EstimateLog()
        self.applied = ControllerRecord()  # by the controllers of this run
        self.clear()

    def clear(self):
        """Clear everything."""
        if self._filled:
            self.before_clearing()
        # What was edited and what the stage published when the run began: later edits are of other runs.
        self.scenario, self.staged = None, None
        self.applied.begin_run()
        self.saved = -np.inf  # [s] up to which the run was saved
        self.moved = -np.inf  # [s] of the newest command that was not zero
        self.axes, self._in_space, self._arm_joints = UNICYCLE_AXES, False, 0
        self._loaded = False
        self.numbers, self.begun = (), None  # begun: [s] at the first command that was not zero
        self.real = frozenset()
        self.collisions = deque(maxlen=MOST_COLLISIONS)
        self.incidents = deque(maxlen=MOST_COLLISIONS)
        self._filled, self._stride, self._skipped = 0, 1, 0
        self._lent = False  # whether a frozen copy shares the arrays
        self._time, self._table = np.empty(0), np.empty((0, 0, STATE + len(UNICYCLE_AXES)))
        self._estimate = None  # (rows, n, 3) once estimates were received, nan where there is none
        self._estimate_log.clear()

    def append(self, snapshot):
        """Add ``snapshot``; another team, or a time that went back, begins anew.

        Of samples of one time the newest is kept: a command, or the stage's state instead of odometry.
        """
        newest = self._time[self._filled - 1] if self._filled else -np.inf
        team = snapshot.numbers, snapshot.axes, snapshot.spatial is not None
        team += (snapshot.load is not None,)
        if (
            team != (self.numbers, self.axes, self._in_space, self._loaded)
            or snapshot.time < newest
        ):
            self._begin(
                *team, np.shape(snapshot.joints)[1] - 1 if np.ndim(snapshot.joints) > 1 else 0
            )
        if np.any(snapshot.command):
            self.begun = snapshot.time if self.begun is None else self.begun
            self.moved = snapshot.time
        self.real = snapshot.real
        if self._filled and snapshot.time == newest:
            self._put(self._filled - 1, snapshot)
            return
        self._skipped += 1
        if self._filled and self._skipped < self._stride:
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
        row[:, :3], row[:, 3:6] = snapshot.pose, snapshot.twist
        if self._arm_joints:
            row[:, 6], row[:, -self._arm_joints :] = snapshot.joints[:, 0], snapshot.joints[:, 1:]
        else:
            row[:, 6] = snapshot.joints
        end = STATE + len(self.axes)
        row[:, STATE:end] = snapshot.command
        if self._in_space:
            row[:, end], row[:, end + 1 : end + 5] = snapshot.spatial[:2]
            row[:, end + 5 : end + IN_SPACE] = snapshot.spatial.twist
        if self._loaded:
            place, turn, force = snapshot.load
            block = row[:, self._load_columns]
            block[:, :3], block[:, 3:6], block[:, 6:] = force, place, turn

    def _begin(self, numbers, axes, in_space, loaded, arm_joints=0):
        self.clear()
        self.numbers, self.axes, self._in_space = numbers, axes, in_space
        self._arm_joints, self._loaded = arm_joints, loaded
        begin = STATE + len(axes) + IN_SPACE * in_space
        self._load_columns = slice(begin, begin + LOADED * loaded)
        columns = self._load_columns.stop + arm_joints
        most = max(FEWEST_SAMPLES, MOST_VALUES // (columns * max(1, len(numbers))))
        self._time = np.empty(min(most, 40000))
        self._table = np.empty((len(self._time), len(numbers), columns))

    def _thin(self):
        kept = len(self._time[::2])
        for name in ("_time", "_table", "_estimate"):
            held = getattr(self, name)
            if held is not None:
                # Frozen copies keep their arrays.
                thinned = np.empty_like(held) if self._lent else held
                thinned[:kept] = held[::2]
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
        return self._table[: self._filled, :, :3]

    @property
    def estimate(self):
        """Return the control's estimated poses (m, n, 3), nan where it has none; None without any."""
        return None if self._estimate is None else self._estimate[: self._filled]

    @property
    def twist(self):
        """Return the body twists (m, n, 3) [m/s, m/s, rad/s]."""
        return self._table[: self._filled, :, 3:6]

    @property
    def joints(self):
        """Return the drives' inner joints (m, n) [rad], with those of arms after them (m, n, 1 + k)."""
        table = self._table[: self._filled]
        if not self._arm_joints:
            return table[:, :, 6]
        return np.concatenate([table[:, :, 6:7], table[:, :, -self._arm_joints :]], axis=2)

    @property
    def command(self):
        """Return the commands (m, n, a) [m/s, rad/s], a column for each of ``axes``."""
        return self._table[: self._filled, :, STATE : STATE + len(self.axes)]

    @property
    def spatial(self):
        """Return the ``Spatial`` (m, n, ...) of robots that leave the ground, None of a team on it."""
        if not self._in_space:
            return None
        block = self._table[: self._filled, :, STATE + len(self.axes) :]
        return Spatial(block[:, :, 0], block[:, :, 1:5], block[:, :, 5:IN_SPACE])

    @property
    def load(self):
        """Return the ``LoadState`` (m, ...) of what the robots carry together, None without a load."""
        if not self._loaded:
            return None
        block = self._table[: self._filled, :, self._load_columns]
        return LoadState(block[:, 0, 3:6], block[:, 0, 6:], block[:, :, :3])

    @property
    def state(self):
        """Return the ``StateTable`` of all samples."""
        names = ("pose", "twist", "command", "joints", "spatial", "load", "estimate")
        columns = {name: getattr(self, name) for name in names}
        return StateTable(self.time, self.numbers, axes=self.axes, **columns)
