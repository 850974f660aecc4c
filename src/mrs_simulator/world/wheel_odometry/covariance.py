"""Covariance of wheel odometry, by the scenario's model of its errors."""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, relative
from mrs_simulator.scenario.team.odometry_errors import step_deviations


class OdometryCovariance:
    """Covariances of the poses by odometry, each in its own frame, to first order.

    Errors that are new in each step, of covariance Q in the robot's axes, and errors e that stay, of
    variances V, on which a step's way depends by D, give

        C = P + J V J^T,   P' = F P F^T + G Q G^T,   J' = F J + G D

    with F and G the slopes of the new pose by the old one and by the way (Smith and Cheeseman, 1986).
    What is drawn once for a run stays, and so does what is the same for all robots, such as ``Ed``:
    it is unknown to those who use the odometry, and its variance is its square, as of an unknown sign.
    """

    def __init__(self, team, errors, poses, odometry):
        """``errors``: ``OdometryErrors``.

        ``poses``, ``odometry`` (n, 3): true and reported poses at the beginning, which are known exactly.
        """
        self._errors = errors
        self._counted, self._track = np.zeros(team.n, dtype=bool), np.ones(team.n)
        for group in team.groups:
            self._counted[group.rows] = group.drive.ENCODERS > 0  # others know how they move
            self._track[group.rows] = getattr(group.numbers, "track", 1.0)
        self._by_wheels = 0.0 if errors.gyro else 1.0  # a gyro measures turns in their place
        bias, self._walk = errors.gyro or (0.0, 0.0)
        drawn = errors.factor / 3.0**0.5  # evenly, one for distances and one for turns
        stays = drawn, drawn, bias, errors.Ed - 1.0, errors.Eb - 1.0
        self._variances = np.square(stays)
        self._poses, self._odometry = np.array(poses), np.array(odometry)
        self._new = np.zeros((team.n, 3, 3))
        self._slopes = np.zeros((team.n, 3, len(self._variances)))

    def follow(self, poses, odometry, seconds):
        """Update by ``poses`` and ``odometry`` (n, 3), ``seconds`` after the last ones."""
        if not seconds > 0.0:
            return
        way, reported = relative(self._poses, poses), relative(self._odometry, odometry)
        before = self._odometry[:, 2]
        self._poses, self._odometry = np.array(poses), np.array(odometry)
        forth, turn = _slopes(before, reported)
        new = turn @ self._step_noise(way, seconds) @ np.swapaxes(turn, 1, 2)
        self._new = forth @ self._new @ np.swapaxes(forth, 1, 2) + new
        self._slopes = forth @ self._slopes + turn @ self._step_slopes(reported, seconds)

    def _step_noise(self, way, seconds):
        """Return the covariance (n, 3, 3) of new errors on a ``way`` (n, 3), in the robots' axes."""
        speed, rate = np.hypot(way[:, 0], way[:, 1]) / seconds, way[:, 2] / seconds
        distance, turn, heading = step_deviations(self._errors.alpha, speed, rate, seconds)
        noise = np.zeros((len(way), 3, 3))
        noise[:, 0, 0] = distance**2
        noise[:, 2, 2] = turn**2 + heading**2 + self._walk**2 * seconds
        return noise

    def _step_slopes(self, reported, seconds):
        """Return the slopes (n, 3, 5) of the step ``reported`` (n, 3) by the errors that stay."""
        x, y, turn = reported.T
        slopes = np.zeros((len(reported), 3, len(self._variances)))
        slopes[:, 0, 0], slopes[:, 1, 0], slopes[:, 2, 1] = x, y, turn
        slopes[:, 2, 2] = seconds
        # The right wheel Ed times the left one: arcs for straight lines, and the reverse.
        slopes[:, 0, 3] = 0.25 * self._track * turn
        slopes[:, 2, 3] = self._by_wheels * x / self._track
        slopes[:, 2, 4] = self._by_wheels * turn
        return slopes

    def covariance(self):
        """Return the covariances (n, 3, 3) of x, y [m] and theta [rad]."""
        slopes = self._slopes
        result = self._new + (slopes * self._variances) @ np.swapaxes(slopes, 1, 2)
        result[~self._counted] = 0.0
        return result


def _slopes(heading, way):
    """Return the slopes of ``compose(pose, way)`` by the pose, of that ``heading`` (n,), and by the way."""
    cos, sin = cos_sin(heading)
    forth, turn = np.tile(np.eye(3), (len(way), 1, 1)), np.tile(np.eye(3), (len(way), 1, 1))
    x, y = way[:, 0], way[:, 1]
    forth[:, 0, 2], forth[:, 1, 2] = -sin * x - cos * y, cos * x - sin * y
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cos, -sin, sin, cos
    return forth, turn
