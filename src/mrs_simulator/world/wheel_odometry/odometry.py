"""Wheel odometry: dead reckoning from a robot's own encoders."""

import math

import numpy as np

from mrs_simulator.core.kinematics import compose, cos_sin, relative, wrap_angle
from mrs_simulator.scenario.team.odometry_errors import step_deviations
from mrs_simulator.world.wheel_odometry.noise import RobotStreams, TeamStream

# Of a kinematic robot, whose model has no slip of its own: relative standard deviations.
WHEEL_MISMATCH = 0.002  # [-] of each wheel's radius, the same all the time
WHEEL_SLIP = 0.02  # [-] of the distance rolled in one step
SENSOR = 1  # of the wheels, among a robot's noise streams
MOTION = 3  # of the velocity motion model
FACTOR, GYRO = 4, 5  # of factors drawn once, and of a gyro's angle


class WheelOdometry:
    """Starts at zero where each robot stands and integrates its encoders, as real odometry does."""

    def __init__(self, team, heading, mismatch, slip, seed, errors, step):
        """``heading`` (n,) [rad]: at which robots stand, for a gyro; ``mismatch`` and ``slip`` are relative
        standard deviations, seeded.

        ``errors``: ``OdometryErrors``, or None; ``step`` [s] between two updates.
        Its unequal wheels show in what encoders count (``uneven_wheels``), and in nothing here.

        Each robot has a noise stream of its own; only in a team of one drive all draw from one, as
        they did before there were others, so that a seed goes on giving the same run.
        """
        self._heading, self._parts = np.array(heading), []
        self._counted = [group.drive.ENCODERS > 0 for group in team.groups]
        for group in team.groups:
            if not group.drive.ENCODERS:
                continue  # their odometry is the true motion, set by the world
            wheels, shared = group.drive.ENCODERS, len(team.groups) == 1
            own = seed, np.arange(team.n)[group.rows], SENSOR
            noise = TeamStream(seed, team.n, wheels) if shared else RobotStreams(*own, wheels)
            self._parts.append(_Part(group, noise, mismatch, slip))
        self._alpha, self._step = errors.alpha if errors else (), step
        self._motion = RobotStreams(seed, range(team.n), MOTION, 3) if any(self._alpha) else None
        self._gyro = errors.gyro if errors else None
        self._walk = RobotStreams(seed, range(team.n), GYRO, 1) if self._gyro else None
        self._factors = np.ones((team.n, 3))
        if errors is not None and errors.factor:
            self._factors[:, [0, 2]] += errors.factor * _evenly(seed, team.n)
            self._factors[:, 1] = self._factors[:, 0]
        self.pose = np.zeros((team.n, 3))

    def update(self, travel, joints, heading):
        """Take in the encoders: for each group ``travel`` (m, wheels), distance rolled so far [m].

        ``joints`` (n,) [rad]: the drives' inner joints; ``heading`` (n,) [rad]: the true ones, for a gyro.
        """
        before = self.pose
        self._reckon(travel, joints)
        if self._gyro:
            self._turn(before, heading)
        if (self._factors != 1.0).any():
            self.pose = compose(before, relative(before, self.pose) * self._factors)
        if self._motion:
            moved = relative(before, self.pose)
            self.pose = compose(before, moved + self._noise_of(moved / self._step))

    def _turn(self, before, heading):
        """Replace the turns of this step by those of a gyro, on the arc that results."""
        bias, walk = self._gyro
        turn = wrap_angle(heading - self._heading) + bias * self._step
        self._heading = np.array(heading)
        turn = turn + walk * np.sqrt(self._step) * self._walk.draw()[:, 0]
        moved = relative(before, self.pose)
        cos, sin = cos_sin(0.5 * (turn - moved[:, 2]))  # between the chords of both arcs
        x, y = moved[:, 0], moved[:, 1]
        moved = np.stack([cos * x - sin * y, sin * x + cos * y, turn], axis=1)
        self.pose = compose(before, moved)

    def _noise_of(self, twist):
        """Return the error (n, 3) of a step at ``twist`` (n, 3), of the velocity motion model."""
        v, w = np.hypot(twist[:, 0], twist[:, 1]), twist[:, 2]
        distance, turn, heading = (
            each * drawn
            for each, drawn in zip(
                step_deviations(self._alpha, v, w, self._step), self._motion.draw().T
            )
        )
        return np.stack([distance, np.zeros_like(v), turn + heading], axis=1)

    def _reckon(self, travel, joints):
        travel = [each for each, counted in zip(travel, self._counted) if counted]
        if len(self._counted) == 1 and self._parts:
            self.pose = self._parts[0].odometry_pose(self.pose, travel[0], joints)
            return
        pose = self.pose.copy()
        for part, rolled in zip(self._parts, travel):
            rows = part.group.rows
            pose[rows] = part.odometry_pose(self.pose[rows], rolled, joints[rows])
        self.pose = pose


def _evenly(seed, n):
    """Return numbers (n, 2) from -1 to 1 of a stream of each robot's own."""
    streams = RobotStreams(seed, range(n), FACTOR, 2)
    # Of a normal number its share of all below it is even.
    share = np.vectorize(math.erf)(streams.draw() / math.sqrt(2.0))
    return np.asarray(share, dtype=float)


class _Part:
    """The odometry of the robots of one drive."""

    def __init__(self, group, noise, mismatch, slip):
        self.group, self._noise, self._slip = group, noise, slip
        self._travel = np.zeros((len(group.kinds), group.drive.ENCODERS))
        self._noisy = bool(slip or mismatch)
        self._scale = 1.0 + mismatch * noise.draw()

    def odometry_pose(self, pose, travel, joints):
        rolled = travel - self._travel
        self._travel = travel.copy()
        if self._noisy:
            rolled = rolled * (self._scale + self._slip * self._noise.draw())
        return self.group.drive.odometry_pose(pose, rolled, joints, self.group.numbers)
