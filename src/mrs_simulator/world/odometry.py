"""Wheel odometry: dead reckoning from a robot's own encoders."""

import numpy as np

from mrs_simulator.world.noise import RobotStreams, TeamStream

# Of a kinematic robot, whose model has no slip of its own: relative standard deviations.
WHEEL_MISMATCH = 0.002  # [-] of each wheel's radius, the same all the time
WHEEL_SLIP = 0.02  # [-] of the distance rolled in one step
SENSOR = 1  # of the wheels, among a robot's noise streams


class WheelOdometry:
    """Starts at zero where each robot stands and integrates its encoders, as real odometry does."""

    def __init__(self, team, mismatch=0.0, slip=0.0, seed=0):
        """``mismatch`` and ``slip`` are relative standard deviations, seeded.

        Each robot has a noise stream of its own; only in a team of one drive all draw from one, as
        they did before there were others, so that a seed goes on giving the same run.
        """
        self._team, self._mismatch, self._slip = team, mismatch, slip
        self._parts = []
        self._counted = [group.drive.ENCODERS > 0 for group in team.groups]
        for group in team.groups:
            if not group.drive.ENCODERS:
                continue  # the world tells what such robots know of themselves
            m, shared = len(group.kinds), len(team.groups) == 1
            rows = np.arange(team.n)[group.rows]
            noise = TeamStream(seed, m) if shared else RobotStreams(seed, rows, SENSOR)
            self._parts.append(_Part(group, noise, mismatch, slip))
        self.reset()

    def reset(self):
        """Start anew at zero, with encoders at zero and the noise from its beginning."""
        self.pose = np.zeros((self._team.n, 3))
        for part in self._parts:
            part.reset()

    def update(self, travel, joints):
        """Take in the encoders: for each group ``travel`` (m, wheels), distance rolled so far [m].

        ``joints`` (n,) [rad]: the drives' inner joints.
        """
        travel = [each for each, counted in zip(travel, self._counted) if counted]
        if len(self._counted) == 1 and self._parts:
            self.pose = self._parts[0].reckoned(self.pose, travel[0], joints)
            return
        pose = self.pose.copy()
        for part, rolled in zip(self._parts, travel):
            rows = part.group.rows
            pose[rows] = part.reckoned(self.pose[rows], rolled, joints[rows])
        self.pose = pose


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

    def reckoned(self, pose, travel, joints):
        rolled = travel - self._travel
        self._travel = travel.copy()
        if self._slip or self._mismatch:
            rolled = rolled * (self._scale + self._slip * self._noise.draw())
        return self.group.drive.reckoned(pose, rolled, joints, self.group.numbers)
