"""Wheel odometry: dead reckoning from a robot's own encoders."""

import numpy as np

from mrs_simulator.core.kinematics import arc, body_speeds, wrap_angle

# Of a kinematic robot, whose model has no slip of its own: relative standard deviations.
WHEEL_MISMATCH = 0.002  # [-] of each wheel's radius, the same all the time
WHEEL_SLIP = 0.02  # [-] of the distance rolled in one step


class WheelOdometry:
    """Starts at zero where each robot stands and integrates its encoders, as real odometry does."""

    def __init__(self, n, track, mismatch=0.0, slip=0.0, seed=0):
        """``track`` [m]; ``mismatch`` and ``slip`` are relative standard deviations, seeded."""
        self._track = track
        self._mismatch, self._slip = mismatch, slip
        self._draw = np.random.default_rng(seed)
        self.reset(n)

    def reset(self, n):
        """Start anew at zero, with encoders at zero, for n robots."""
        self.pose = np.zeros((n, 3))
        self._travel = np.zeros((n, 2))
        self._scale = 1.0 + self._mismatch * self._draw.standard_normal((n, 2))

    def update(self, travel):
        """Take in the encoders: ``travel`` (n, 2), distance rolled so far by left, right [m]."""
        rolled = travel - self._travel
        self._travel = travel.copy()
        if self._slip or self._mismatch:
            noise = self._slip * self._draw.standard_normal(rolled.shape)
            rolled = rolled * (self._scale + noise)
        self.pose = arc(self.pose, body_speeds(rolled, self._track), 1.0)
        self.pose[:, 2] = wrap_angle(self.pose[:, 2])
