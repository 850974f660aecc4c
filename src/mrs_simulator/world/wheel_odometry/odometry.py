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

    def __init__(self, team, mismatch=0.0, slip=0.0, seed=0, errors=None, step=0.02):
        """``mismatch`` and ``slip`` are relative standard deviations, seeded.

        ``errors``: ``OdometryErrors``, or None; ``step`` [s] between two updates.
        Its unequal wheels show in what encoders count (``uneven_wheels``), and in nothing here.

        Each robot has a noise stream of its own; only in a team of one drive all draw from one, as
        they did before there were others, so that a seed goes on giving the same run.
        """
        self._team, self._mismatch, self._slip = team, mismatch, slip
        self._parts = []
        self._counted = [group.drive.ENCODERS > 0 for group in team.groups]
        for group in team.groups:
            if not group.drive.ENCODERS:
                continue  # their odometry is the true motion, set by the world
            m, shared = len(group.kinds), len(team.groups) == 1
            rows = np.arange(team.n)[group.rows]
            noise = TeamStream(seed, m) if shared else RobotStreams(seed, rows, SENSOR)
            self._parts.append(_Part(group, noise, mismatch, slip))
        self._alpha, self._step = errors.alpha if errors else (), step
        self._motion = RobotStreams(seed, range(team.n), MOTION) if any(self._alpha) else None
        self._gyro = errors.gyro if errors else None
        self._walk = RobotStreams(seed, range(team.n), GYRO) if self._gyro else None
        self._factors = np.ones((team.n, 3))
        if errors is not None and errors.factor:
            self._factors[:, [0, 2]] += errors.factor * _evenly(seed, team.n)
            self._factors[:, 1] = self._factors[:, 0]
        self.reset()

    def begin_at(self, heading):
        """Tell the headings (n,) [rad] at which robots stand, for a gyro."""
        self._begun = np.array(heading)

    def reset(self):
        """Start anew at zero, with encoders at zero and the noise from its beginning."""
        self.pose = np.zeros((self._team.n, 3))
        for part in self._parts:
            part.reset()
        if self._motion:
            self._motion.begin(3)
        if self._walk:
            self._walk.begin(1)
        self._heading = None

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
        last = self._begun if self._heading is None else self._heading
        self._heading = np.array(heading)
        turn = wrap_angle(self._heading - last) + bias * self._step
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
    streams = RobotStreams(seed, range(n), FACTOR)
    streams.begin(2)
    # Of a normal number its share of all below it is even.
    share = np.vectorize(math.erf)(streams.draw() / math.sqrt(2.0))
    return np.asarray(share, dtype=float)


class _Part:
    """The odometry of the robots of one drive."""

    def __init__(self, group, noise, mismatch, slip):
        self.group, self._noise = group, noise
        self._mismatch, self._slip = mismatch, slip

    def reset(self):
        wheels = self.group.drive.ENCODERS
        self._noise.begin(wheels)
        self._travel = np.zeros((len(self.group.kinds), wheels))
        self._scale = 1.0 + self._mismatch * self._noise.draw()

    def odometry_pose(self, pose, travel, joints):
        rolled = travel - self._travel
        self._travel = travel.copy()
        if self._slip or self._mismatch:
            rolled = rolled * (self._scale + self._slip * self._noise.draw())
        return self.group.drive.odometry_pose(pose, rolled, joints, self.group.numbers)
