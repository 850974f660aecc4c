"""The filter's model: how odometry and readings predict and correct poses and biases."""

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.team.estimates import EKF
from mrs_simulator.scenario.team.odometry_errors import step_deviations, true_squares
from mrs_simulator.sensors.pose_filter.gyro import Gyro
from mrs_simulator.sensors.pose_filter.kalman import Filter
from mrs_simulator.sensors.pose_filter.measurement_buffer import Move, Relocation
from mrs_simulator.sensors.pose_filter.pose_measurements import MEASUREMENTS

FUSED_TYPES = ("imu", *sorted(MEASUREMENTS))  # types of sensors that the filter uses


class Model:
    """The ``filter`` of a team, the sensors that correct it, and the columns of their biases."""

    def __init__(self, fitted, poses, alpha, step):
        """``fitted``: mounts by name, as of ``mounts_for_estimates``; ``poses`` (n, 3) at first.

        ``alpha``: of the odometry's noise, as the filter takes it to be; ``step`` [s] of the world.
        Raises ``ScenarioError`` for two gyros.
        """
        self.alpha, self._names = alpha, list(fitted)
        self.measured = {
            name: MEASUREMENTS[mount.type](mount)
            for name, mount in fitted.items()
            if mount.type != "imu"
        }
        self.gyro = _gyro_of(fitted, step)
        self.filter = Filter(poses, biases=self._layout())

    def _layout(self):
        """Give each biased sensor its columns of the state; return the biases' variances at first."""
        first, walks, self._columns = [], [], {}
        sensors = dict(self.measured)
        if self.gyro is not None:
            sensors[self.gyro.name] = self.gyro
        for name in self._names:
            if sensors[name].is_biased:
                self._columns[name] = slice(
                    3 + len(first), 3 + len(first) + len(sensors[name].first)
                )
                first.extend(sensors[name].first)
                walks.extend(sensors[name].walks)
        self.walks = np.array(walks)
        return first

    def apply(self, event):
        """Apply one event to the filter: a ``Move``, a ``Relocation`` or an ``Observation``."""
        if isinstance(event, Move):
            self._move(event)
        elif isinstance(event, Relocation):
            self.filter.restart(event.rows, event.pose)
        else:
            self._correct(event)

    def _move(self, event):
        seconds, moved = (event.end - event.start) / 1e9, event.moved
        speed, rate = np.hypot(moved[:, 0], moved[:, 1]) / seconds, moved[:, 2] / seconds
        speed, rate = np.sqrt(true_squares(self.alpha, speed, rate, seconds))
        distance, turn, heading = step_deviations(self.alpha, speed, rate, seconds)
        variances = np.stack([distance**2, np.zeros_like(speed), turn**2 + heading**2], axis=1)
        turning = None
        if self.gyro is not None:
            moved, turning = moved.copy(), np.zeros((len(moved), len(self.walks)))
            covered = self.gyro.turn(event, moved, variances)
            if self.gyro.name in self._columns:
                turning[:, self._columns[self.gyro.name].start - 3] = covered
        self.filter.move(moved, variances, event.rows, turning, self.walks * seconds)

    def _correct(self, event):
        measured = self.measured[event.name]
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
            if len(self.walks):
                slope = self._with_biases(slope, columns)
            self.filter.correct(rows, off[:, group], slope[:, group], measured.variances[group])

    def _with_biases(self, slope, columns):
        """Return ``slope`` (m, k, 3) by the whole state: each value contains its own bias."""
        m, k = slope.shape[:2]
        full = np.zeros((m, k, 3 + len(self.walks)))
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


def _checked(name, own, estimates, team):
    """Return the mount ``name`` of all robots; ``ScenarioError`` if one lacks it, or it does not fit."""
    for row, each in enumerate(own):
        if name not in each:
            owner = "estimates: sensors of robot{} ({})".format(row + 1, team.kinds[row].name)
            raise ScenarioError(unknown_name(owner, name, each))
    mounts = [each[name] for each in own]
    types = FUSED_TYPES if estimates.source == EKF else ("motion_capture",)
    for mount in mounts:
        if mount.type not in types:
            text = "estimates: {} is a {}, wanted one of {}"
            raise ScenarioError(text.format(name, mount.type, ", ".join(types)))
        if mount != mounts[0]:
            text = "estimates: {} is not alike on all robots, wanted one for all"
            raise ScenarioError(text.format(name))
    return mounts[0]


def mounts_for_estimates(estimates, team, mounts):
    """Return the mounts by name of the sensors that ``estimates`` ask for; ``mounts``: of each robot.

    Raises ``ScenarioError`` where robots lack one or have different ones, or where it measures no pose.
    """
    own = [{mount.name: mount for mount in each} for each in mounts]
    return {name: _checked(name, own, estimates, team) for name in estimates.asked}
