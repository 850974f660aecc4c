"""Estimates of poses from odometry, gyro, compass, satellites, beacons and motion capture.

Recent events are kept in the order of their stamps: a late measurement is inserted where it belongs, and
what followed is computed again.
"""

import numpy as np

from mrs_simulator.core.kinematics import relative
from mrs_simulator.scenario.team.estimates import ALPHA, EKF, ODOMETRY
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.pose_filter.measurement_buffer import (
    MeasurementBuffer,
    Move,
    Observation,
    Relocation,
)
from mrs_simulator.sensors.pose_filter.model import Model, mounts_for_estimates

SLACK = 0.5  # [s] by which a reading may be later than its sensor's latency
PUT = 0.3, 1.5  # [m], [-] of the top speed: a robot that moves farther at once was put there


class Estimator:
    """Poses of a team as its scenario says that they are estimated.

    Times are whole numbers of ns, of any clock that odometry and readings share.
    """

    def __init__(self, estimates, team, mounts, poses, alpha, step):
        """``mounts``: of each robot, as of ``fitted_mounts``; ``poses`` (n, 3) at the beginning.

        ``alpha``: of the odometry's noise, as the filter takes it to be; ``step`` [s] of the world.
        Raises ``ScenarioError`` for sensors that robots lack, or that measure no pose.
        """
        self._source, fitted = estimates.source, mounts_for_estimates(estimates, team, mounts)
        self._names = list(fitted)
        self.model = Model(fitted, poses, alpha, step)
        self.filter, self._gyro = self.model.filter, self.model.gyro
        self._n, self._speeds = team.n, np.broadcast_to(team.speeds, (team.n, 2))[:, 0]
        latest = max([mount.latency for mount in fitted.values()], default=0.0)
        self._buffer = MeasurementBuffer(self.filter, int(1e9 * (latest + SLACK)))
        self._stamps = self._odometry = None
        self._put = np.zeros(team.n, dtype=bool)  # robots that begin anew
        self._pending, self._taken = [], {}
        self.late = 0  # readings so far that came too late to be used

    @classmethod
    def of_scenario(cls, scenario, team):
        """Return the ``Estimator`` of the ``scenario``, None where it has no ``estimates``."""
        if scenario.estimates is None:
            return None
        errors, given = scenario.odometry_errors, scenario.estimates.alpha
        alpha = given or (errors.alpha if errors is not None else ALPHA)
        mounts = fitted_mounts(team, scenario.sensors)
        return cls(scenario.estimates, team, mounts, scenario.poses, alpha, scenario.step)

    @property
    def pose(self):
        """Return a copy of the estimated poses (n, 3)."""
        return self.filter.pose.copy()

    def fresh(self, readings):
        """Return the new ones of ``readings``, ``{row: {name: reading}}``, in the form of ``update``."""
        found = {}
        for name in self._names:
            for row in range(self._n):
                reading = readings[row].get(name)
                if reading is not None and self._taken.get((row, name)) != reading.stamp:
                    self._taken[row, name] = reading.stamp
                    found.setdefault((nanoseconds(reading.stamp), name), []).append((row, reading))
        return [(stamp, name, rows) for (stamp, name), rows in found.items()]

    def update(self, stamps, odometry, readings=()):
        """Update the estimates by the newest ``odometry`` (n, 3), in the common frame, and by readings.

        ``stamps`` (n,) [ns] of the odometry; ``readings``: ``[(stamp, name, [(row, reading)])]`` with
        stamps in ns.  A robot that is farther from its last pose than it can have driven was put there.
        """
        stamps, odometry = np.asarray(stamps, dtype=np.int64), np.array(odometry)
        if self._stamps is None:
            self.filter.pose = odometry
            self._begin(stamps, odometry)
        if self._source == ODOMETRY:
            self.filter.pose = odometry
        elif self._source == EKF:
            self._follow(stamps, odometry)
            self._observe(stamps, list(readings))
            self._replay(int(stamps.min()))
        else:
            for _, name, rows in sorted(readings, key=lambda each: each[0]):
                self._take_measured(name, rows)

    def _take_measured(self, name, readings):
        """Set poses to the measurements of the sensor ``name``; where values are lost, poses stay."""
        rows, measured = self._values(name, readings)
        kept = np.isfinite(measured).all(axis=1)
        pose = self.filter.pose.copy()
        pose[rows[kept]] = measured[kept]
        self.filter.pose = pose

    def _values(self, name, readings):
        values = np.array([self.model.measured[name].values(reading) for _, reading in readings])
        return np.array([row for row, _ in readings]), values

    # Events of the filter ------------------------------------------------------------------------

    def _begin(self, stamps, odometry):
        self._stamps, self._odometry = stamps.copy(), odometry
        self._buffer.begin(int(stamps.min()))

    def _follow(self, stamps, odometry):
        """Add the moves between the last odometry and the new."""
        rows = np.flatnonzero(stamps > self._stamps)
        if not len(rows):
            return
        moved = relative(self._odometry[rows], odometry[rows])
        spans = (stamps - self._stamps)[rows]
        most = PUT[0] + PUT[1] * self._speeds[rows] * spans / 1e9
        far = self._put[rows] | (np.hypot(moved[:, 0], moved[:, 1]) > most)
        self._put[rows] = False
        for start, end in sorted(set(zip(self._stamps[rows].tolist(), stamps[rows].tolist()))):
            alike = (self._stamps[rows] == start) & (stamps[rows] == end)
            driven, put = alike & ~far, alike & far
            if driven.any():
                move = Move(start, end, rows[driven], moved[driven])
                self._buffer.add(move, order=-1)
            if put.any():
                self._buffer.add(Relocation(end, rows[put], odometry[rows[put]]), order=-1)
        self._stamps[rows], self._odometry = stamps[rows], odometry

    def restart(self, rows):
        """Let robots ``rows``, which were moved by hand, begin anew at their next odometry."""
        self._put[rows] = True

    def _observe(self, stamps, readings):
        """Add the ``readings``; those that are newer than the odometry wait for it."""
        waiting, self._pending = self._pending + readings, []
        for stamp, name, found in waiting:
            if self._gyro is not None and name == self._gyro.name:
                self._buffer.replay_from(self._gyro.take(stamp, found))
                continue
            early = [each for each in found if stamp > stamps[each[0]]]
            if early:
                self._pending.append((stamp, name, early))
                found = [each for each in found if stamp <= stamps[each[0]]]
            if found:
                seen = Observation(stamp, name, *self._values(name, found))
                self.late += not self._buffer.add(seen, order=self._names.index(name))

    def _replay(self, until):
        """Apply new events to the filter; all odometry is known up to ``until`` [ns]."""
        self._buffer.replay(self.model.apply, until)
        if self._gyro is not None:
            self._gyro.forget(until - self._buffer.reach)


def nanoseconds(seconds):
    """Return times [s] as whole numbers of ns."""
    return int(round(1e9 * seconds))
