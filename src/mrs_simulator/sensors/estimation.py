"""Estimates of poses from what robots measure: odometry, gyro, compass, satellites, motion capture.

An extended Kalman filter of x, y, theta for each robot (Thrun, Burgard, Fox, Probabilistic Robotics, 3.3):
odometry moves the estimate, whatever tells of the pose corrects it.
"""

import numpy as np

from mrs_simulator.core.estimates import ALPHA, EKF, ODOMETRY
from mrs_simulator.core.kinematics import compose, cos_sin, relative, wrap_angle
from mrs_simulator.core.odometry_errors import step_deviations
from mrs_simulator.core.parameters import unknown_name
from mrs_simulator.core.reading import ScenarioError
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.noise import SILENCE
from mrs_simulator.sensors.types.position import local_place

FILTERED = ("compass", "gps", "imu", "motion_capture")  # types of sensors that the filter takes
CERTAIN = 1e-12  # [m^2, rad^2] a sensor without noise is not taken to be surer than that


class Filter:
    """Extended Kalman filters of n robots: ``pose`` (n, 3) and its ``covariance`` (n, 3, 3)."""

    def __init__(self, pose, covariance=None):
        """``pose`` (n, 3) [m, m, rad] at first, known with ``covariance`` (n, 3, 3), by default exactly."""
        self.pose = np.array(pose, dtype=float)
        n = len(self.pose)
        self.covariance = np.zeros((n, 3, 3)) if covariance is None else np.array(covariance)

    def move(self, moved, variances):
        """Move by ``moved`` (n, 3), each in its own frame, with ``variances`` (n, 3) along its own axes.

        p' = p + R(theta) d,   theta' = theta + d_theta,   P' = F P F^T + G Q G^T.
        """
        cos, sin = cos_sin(self.pose[:, 2])
        x, y = moved[:, 0], moved[:, 1]
        jacobian, turn = (np.tile(np.eye(3), (len(moved), 1, 1)) for _ in range(2))
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -sin * x - cos * y, cos * x - sin * y
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cos, -sin, sin, cos
        self.pose = np.array(compose(self.pose, moved))
        self.covariance = jacobian @ self.covariance @ np.swapaxes(jacobian, 1, 2)
        self.covariance += (turn * variances[:, np.newaxis]) @ np.swapaxes(turn, 1, 2)

    def correct(self, rows, measured, components, variances, places=None):
        """Take in ``measured`` (m, k) of ``components`` of the poses of robots ``rows`` (m,).

        ``variances`` (k,); ``places`` (m, 2) [m]: where on the robots that is measured, in their frames.
        What is lost, nan, changes nothing.

            K = P H^T (H P H^T + R)^-1,   P' = (1 - K H) P (1 - K H)^T + K R K^T.
        """
        kept = np.isfinite(measured).all(axis=1)
        rows, measured = rows[kept], measured[kept]
        if not len(rows):
            return
        pose, before = self.pose[rows], self.covariance[rows]
        expected, slope = pose.copy(), np.tile(np.eye(3), (len(rows), 1, 1))
        if places is not None:
            cos, sin = cos_sin(pose[:, 2])
            x, y = places
            ahead, aside = cos * x - sin * y, sin * x + cos * y
            expected[:, 0] += ahead
            expected[:, 1] += aside
            slope[:, 0, 2], slope[:, 1, 2] = -aside, ahead
        slope, off = slope[:, components], measured - expected[:, components]
        angular = np.array(components) == 2
        off[:, angular] = wrap_angle(off[:, angular])
        noise = np.diag(np.maximum(variances, CERTAIN))
        back = np.swapaxes(slope, 1, 2)
        gain = before @ back @ np.linalg.inv(slope @ before @ back + noise)
        self.pose[rows] = pose + np.einsum("ijk,ik->ij", gain, off)
        self.pose[rows, 2] = wrap_angle(self.pose[rows, 2])
        left = np.eye(3) - gain @ slope
        self.covariance[rows] = left @ before @ np.swapaxes(
            left, 1, 2
        ) + gain @ noise @ np.swapaxes(gain, 1, 2)


def nees(error, covariance):
    """Return ``e^T P^-1 e`` (m,) of errors (m, 3), ``covariance`` (m, 3, 3): chi-square, 3 degrees."""
    error = np.array(error)
    error[:, 2] = wrap_angle(error[:, 2])
    return np.einsum("ij,ij->i", error, np.linalg.solve(covariance, error[..., np.newaxis])[..., 0])


class Estimator:
    """Poses of a team as its scenario says that they are estimated."""

    def __init__(self, estimates, team, mounts, poses, alpha, step):
        """``mounts``: of each robot, as of ``fitted_mounts``; ``poses`` (n, 3) at the beginning.

        ``alpha``: of the odometry's noise, as the filter takes it to be; ``step`` [s] of the world.
        Raises ``ScenarioError`` for sensors that robots lack, or that tell no pose.
        """
        self._estimates, self._step = estimates, step
        self._rows = np.arange(team.n)
        own = [{mount.name: mount for mount in each} for each in mounts]
        self._mounts = {name: _checked(name, own, estimates, team) for name in estimates.asked}
        self.filter = Filter(poses)
        self._alpha, self._odometry, self._taken = alpha, None, {}

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

    def update(self, odometry, readings):
        """Take in the ``odometry`` (n, 3) in the common frame after a step, and the newest ``readings``.

        ``readings``: ``{row: {name: reading}}``, as of ``Suite.readings``.
        """
        odometry = np.array(odometry)
        if self._estimates.source == ODOMETRY:
            self.filter.pose = odometry
            return
        if self._estimates.source == EKF:
            self._move(odometry, readings)
        for name, mounts in self._mounts.items():
            fresh = [row for row in self._rows if self._is_new(row, name, readings)]
            if fresh and mounts[0].type != "imu":
                self._correct(np.array(fresh), name, mounts, readings)

    def _is_new(self, row, name, readings):
        reading = readings[row].get(name)
        stamp = None if reading is None else reading.stamp
        if stamp is None or self._taken.get((row, name)) == stamp:
            return False
        self._taken[row, name] = stamp
        return True

    def _move(self, odometry, readings):
        """Move by what the odometry, and a gyro for the turn, tell of the last step."""
        before, self._odometry = self._odometry, odometry
        if before is None:
            return
        moved = relative(before, odometry)
        speed, rate = np.hypot(moved[:, 0], moved[:, 1]) / self._step, moved[:, 2] / self._step
        distance, turn, heading = step_deviations(self._alpha, speed, rate, self._step)
        variances = np.stack([distance**2, np.zeros_like(speed), turn**2 + heading**2], axis=1)
        for name, mounts in self._mounts.items():
            if mounts[0].type == "imu":
                self._turn(name, mounts, moved, variances, readings)
        self.filter.move(moved, variances)

    def _turn(self, name, mounts, moved, variances, readings):
        """Put turns by the gyro ``name`` in place of the odometry's, in ``moved`` and ``variances``."""
        for row, mount in enumerate(mounts):
            reading = readings[row].get(name)
            if reading is None or not np.isfinite(reading.rate[2]):
                continue
            moved[row, 2] = reading.rate[2] * self._step
            deviation = dict(mount.noise).get("rate", SILENCE).stddev
            # Until the next reading the error is the same: its steps add up, and not their squares.
            variances[row, 2] = deviation**2 * self._step * max(self._step, 1.0 / mount.rate)

    def _correct(self, rows, name, mounts, readings):
        found = [readings[row][name] for row in rows]
        mount = mounts[0]
        noise = {quantity: each.stddev**2 for quantity, each in mount.noise}
        places = None
        if mount.type == "compass":
            measured, components = np.array([[each.heading] for each in found]), [2]
            variances = [noise.get("", 0.0)]
        elif mount.type == "gps":
            origin = mount.numbers.origin
            measured, components = (
                np.array([local_place(each, origin)[:2] for each in found]),
                [0, 1],
            )
            variances, places = [noise.get("", 0.0)] * 2, mount.place[:2]
        else:
            measured = np.array([[each.x, each.y, each.theta] for each in found])
            components = [0, 1, 2]
            variances = [noise.get("position", 0.0)] * 2 + [noise.get("heading", 0.0)]
        if self._estimates.source != EKF:  # poses as the sensor tells them
            kept = np.isfinite(measured).all(axis=1)
            self.filter.pose[rows[kept]] = measured[kept]
            return
        self.filter.correct(rows, measured, components, np.array(variances), places)


def _checked(name, own, estimates, team):
    """Return the mounts ``name`` of all robots; ``ScenarioError`` where one lacks it or it does not fit."""
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
    return mounts
