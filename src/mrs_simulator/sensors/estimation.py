"""Estimates of poses from odometry, gyro, compass, satellites, beacons and motion capture.

The estimator keeps what it was told of late in the order of the stamps: a measurement that comes late is
taken in where it belongs, and what followed is reckoned anew.
"""

import numpy as np

from mrs_simulator.core.estimates import ALPHA, EKF, ODOMETRY
from mrs_simulator.core.kinematics import relative, wrap_angle
from mrs_simulator.core.odometry_errors import step_deviations, true_squares
from mrs_simulator.core.parameters import unknown_name
from mrs_simulator.core.reading import ScenarioError
from mrs_simulator.sensors.filtering import Filter
from mrs_simulator.sensors.gyro import Gyro
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.pose_measurements import MEASUREMENTS
from mrs_simulator.sensors.story import Look, Move, Put, Story

FILTERED = ("imu", *sorted(MEASUREMENTS))  # types of sensors that the filter takes
SLACK = 0.5  # [s] by which a reading may be later than its sensor's latency
PUT = 0.3, 1.5  # [m], [-] of the top speed: who moves farther at once was put there


class Estimator:
    """Poses of a team as its scenario says that they are estimated.

    Times are whole numbers of ns, of any clock that odometry and readings share.
    """

    def __init__(self, estimates, team, mounts, poses, alpha, step):
        """``mounts``: of each robot, as of ``fitted_mounts``; ``poses`` (n, 3) at the beginning.

        ``alpha``: of the odometry's noise, as the filter takes it to be; ``step`` [s] of the world.
        Raises ``ScenarioError`` for sensors that robots lack, or that tell no pose.
        """
        self._source, self._alpha = estimates.source, alpha
        own = [{mount.name: mount for mount in each} for each in mounts]
        fitted = {name: _checked(name, own, estimates, team) for name in estimates.asked}
        self._names = list(fitted)
        self._measured = {
            name: MEASUREMENTS[mount.type](mount)
            for name, mount in fitted.items()
            if mount.type != "imu"
        }
        self._gyro = _gyro_of(fitted, step)
        self._n, self._speeds = team.n, np.broadcast_to(team.speeds, (team.n, 2))[:, 0]
        self.filter = Filter(poses, biases=self._layout())
        latest = max([mount.latency for mount in fitted.values()], default=0.0)
        self._story = Story(self.filter, int(1e9 * (latest + SLACK)))
        self._told = self._odometry = None
        self._put = np.zeros(team.n, dtype=bool)  # who is to begin anew
        self._pending, self._taken = [], {}
        self.late = 0  # readings so far that came too late to be taken in

    @classmethod
    def of_scenario(cls, scenario, team):
        """Return the ``Estimator`` of the ``scenario``, None where it says nothing of estimates."""
        if scenario.estimates is None:
            return None
        errors, given = scenario.odometry_errors, scenario.estimates.alpha
        alpha = given or (errors.alpha if errors is not None else ALPHA)
        mounts = fitted_mounts(team, scenario.sensors)
        return cls(scenario.estimates, team, mounts, scenario.poses, alpha, scenario.step)

    def _layout(self):
        """Give each biased sensor its columns of the state; return the biases' variances at first."""
        first, walks, self._columns = [], [], {}
        sensors = dict(self._measured)
        if self._gyro is not None:
            sensors[self._gyro.name] = self._gyro
        for name in self._names:
            if sensors[name].is_biased:
                self._columns[name] = slice(
                    3 + len(first), 3 + len(first) + len(sensors[name].first)
                )
                first.extend(sensors[name].first)
                walks.extend(sensors[name].walks)
        self._walks = np.array(walks)
        return first

    @property
    def pose(self):
        """Return the poses (n, 3) as they are estimated now; the caller's own."""
        return self.filter.pose.copy()

    def fresh(self, readings):
        """Return what is new in ``readings``, ``{row: {name: reading}}``, as ``update`` takes it."""
        found = {}
        for name in self._names:
            for row in range(self._n):
                reading = readings[row].get(name)
                if reading is not None and self._taken.get((row, name)) != reading.stamp:
                    self._taken[row, name] = reading.stamp
                    found.setdefault((nanoseconds(reading.stamp), name), []).append((row, reading))
        return [(stamp, name, heard) for (stamp, name), heard in found.items()]

    def update(self, told, odometry, heard=()):
        """Take in the newest ``odometry`` (n, 3), in the common frame, and the readings that have come.

        ``told`` (n,) [ns]: when each was true; ``heard``: ``[(stamp, name, [(row, reading)])]`` with
        stamps in ns.  A robot that is farther from where it was than it can have gone was put there.
        """
        told, odometry = np.asarray(told, dtype=np.int64), np.array(odometry)
        if self._told is None:
            self.filter.pose = odometry
            self._begin(told, odometry)
        if self._source == ODOMETRY:
            self.filter.pose = odometry
        elif self._source == EKF:
            self._follow(told, odometry)
            self._look(told, list(heard))
            self._reckon(int(told.min()))
        else:
            for _, name, rows in sorted(heard, key=lambda each: each[0]):
                self._take_as_told(name, rows)

    def _take_as_told(self, name, heard):
        """Take poses as the sensor ``name`` tells them; what is lost leaves the last."""
        rows, measured = self._values(name, heard)
        kept = np.isfinite(measured).all(axis=1)
        pose = self.filter.pose.copy()
        pose[rows[kept]] = measured[kept]
        self.filter.pose = pose

    def _values(self, name, heard):
        values = np.array([self._measured[name].values(reading) for _, reading in heard])
        return np.array([row for row, _ in heard]), values

    # What the filter is told ---------------------------------------------------------------------

    def _begin(self, told, odometry):
        self._told, self._odometry = told.copy(), odometry
        self._story.begin(int(told.min()))

    def _follow(self, told, odometry):
        """Note the moves that new odometry tells of."""
        rows = np.flatnonzero(told > self._told)
        if not len(rows):
            return
        moved = relative(self._odometry[rows], odometry[rows])
        spans = (told - self._told)[rows]
        most = PUT[0] + PUT[1] * self._speeds[rows] * spans / 1e9
        far = self._put[rows] | (np.hypot(moved[:, 0], moved[:, 1]) > most)
        self._put[rows] = False
        for start, end in sorted(set(zip(self._told[rows].tolist(), told[rows].tolist()))):
            alike = (self._told[rows] == start) & (told[rows] == end)
            driven, put = alike & ~far, alike & far
            if driven.any():
                move = Move(start, end, rows[driven], moved[driven])
                self._story.add(move, order=-1)
            if put.any():
                self._story.add(Put(end, rows[put], odometry[rows[put]]), order=-1)
        self._told[rows], self._odometry = told[rows], odometry

    def restart(self, rows):
        """Let robots ``rows`` begin anew where their odometry tells next: somebody has put them there."""
        self._put[rows] = True

    def _look(self, told, heard):
        """Note the readings ``heard``; those of later than the odometry wait for it."""
        waiting, self._pending = self._pending + heard, []
        for stamp, name, found in waiting:
            if self._gyro is not None and name == self._gyro.name:
                self._story.again_from(self._gyro.take(stamp, found))
                continue
            early = [each for each in found if stamp > told[each[0]]]
            if early:
                self._pending.append((stamp, name, early))
                found = [each for each in found if stamp <= told[each[0]]]
            if found:
                look = Look(stamp, name, *self._values(name, found))
                self.late += not self._story.add(look, order=self._names.index(name))

    def _reckon(self, until):
        """Let the filter take in what is new; all odometry is known up to ``until`` [ns]."""
        self._story.tell(self._apply, until)
        if self._gyro is not None:
            self._gyro.forget(until - self._story.reach)

    # What the filter makes of it -----------------------------------------------------------------

    def _apply(self, event):
        """Let the filter take in one event of its story."""
        if isinstance(event, Move):
            self._move(event)
        elif isinstance(event, Put):
            self.filter.restart(event.rows, event.pose)
        else:
            self._correct(event)

    def _move(self, event):
        seconds, moved = (event.end - event.start) / 1e9, event.moved
        speed, rate = np.hypot(moved[:, 0], moved[:, 1]) / seconds, moved[:, 2] / seconds
        speed, rate = np.sqrt(true_squares(self._alpha, speed, rate, seconds))
        distance, turn, heading = step_deviations(self._alpha, speed, rate, seconds)
        variances = np.stack([distance**2, np.zeros_like(speed), turn**2 + heading**2], axis=1)
        turning = None
        if self._gyro is not None:
            moved, turning = moved.copy(), np.zeros((len(moved), len(self._walks)))
            covered = self._gyro.turn(event, moved, variances)
            if self._gyro.name in self._columns:
                turning[:, self._columns[self._gyro.name].start - 3] = covered
        self.filter.move(moved, variances, event.rows, turning, self._walks * seconds)

    def _correct(self, event):
        measured = self._measured[event.name]
        columns = self._columns.get(event.name)
        for group in measured.groups:
            kept = np.isfinite(event.values[:, group]).all(axis=1)
            rows = event.rows[kept]
            if not len(rows):
                continue
            off, slope = measured.off(event.values[kept], self.filter.pose[rows])
            if columns is not None:
                off = off - self.filter.bias[rows, columns.start - 3 : columns.stop - 3]
                off[:, measured.angular] = wrap_angle(off[:, measured.angular])
            if len(self._walks):
                slope = self._with_biases(slope, columns)
            self.filter.correct(rows, off[:, group], slope[:, group], measured.variances[group])

    def _with_biases(self, slope, columns):
        """Return ``slope`` (m, k, 3) by the whole state: each value contains its own bias."""
        m, k = slope.shape[:2]
        full = np.zeros((m, k, 3 + len(self._walks)))
        full[:, :, :3] = slope
        if columns is not None:
            full[:, range(k), range(columns.start, columns.stop)] = 1.0
        return full


def _gyro_of(fitted, step):
    """Return the ``Gyro`` of the mounts ``fitted`` by name, None where there is none."""
    found = [mount for mount in fitted.values() if mount.type == "imu"]
    if len(found) > 1:
        text = "estimates: {} and {} are both an imu, wanted one at most"
        raise ScenarioError(text.format(found[0].name, found[1].name))
    return Gyro(found[0], step) if found else None


def nanoseconds(seconds):
    """Return times [s] as whole numbers of ns."""
    return int(round(1e9 * seconds))


def _checked(name, own, estimates, team):
    """Return the mount ``name`` of all robots; ``ScenarioError`` if one lacks it, or it does not fit."""
    for row, each in enumerate(own):
        if name not in each:
            owner = "estimates: sensors of robot{} ({})".format(row + 1, team.kinds[row].name)
            raise ScenarioError(unknown_name(owner, name, each))
    mounts = [each[name] for each in own]
    types = FILTERED if estimates.source == EKF else ("motion_capture",)
    for mount in mounts:
        if mount.type not in types:
            text = "estimates: {} is a {}, wanted one of {}"
            raise ScenarioError(text.format(name, mount.type, ", ".join(types)))
        if mount != mounts[0]:
            text = "estimates: {} is not alike on all robots, wanted one for all"
            raise ScenarioError(text.format(name))
    return mounts[0]
