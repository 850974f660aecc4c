"""Estimates of poses from odometry, gyro, compass, satellites, beacons and motion capture.

The estimator keeps what it was told of late in the order of the stamps: a measurement that comes late is
taken in where it belongs, and what followed is reckoned anew.
"""

import numpy as np

from mrs_simulator.core.kinematics import relative
from mrs_simulator.scenario.team.estimates import ALPHA, EKF, ODOMETRY
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.pose_filter.measurement_buffer import Look, Move, Put, Story
from mrs_simulator.sensors.pose_filter.model import Model, fitted_alike

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
        self._source, fitted = estimates.source, fitted_alike(estimates, team, mounts)
        self._names = list(fitted)
        self.model = Model(fitted, poses, alpha, step)
        self.filter, self._gyro = self.model.filter, self.model.gyro
        self._n, self._speeds = team.n, np.broadcast_to(team.speeds, (team.n, 2))[:, 0]
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
        values = np.array([self.model.measured[name].values(reading) for _, reading in heard])
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
        self._story.tell(self.model.apply, until)
        if self._gyro is not None:
            self._gyro.forget(until - self._story.reach)


def nanoseconds(seconds):
    """Return times [s] as whole numbers of ns."""
    return int(round(1e9 * seconds))
