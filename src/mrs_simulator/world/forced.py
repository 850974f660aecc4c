"""Robots of one drive that forces of water or air move, worked out as arrays, without a solver."""

import numpy as np

from mrs_simulator.world.kinematic import GroupMotion, into_body


class ForcedGroup(GroupMotion):
    """The inner state of the robots of one drive, and their motion with forces."""

    def __init__(self, group, step, encoders, environment, weather):
        """``weather``: what these robots feel; the others as ``GroupMotion`` has them."""
        self._weather = weather
        super().__init__(group, step, encoders, environment)

    def reset(self):
        """Be at rest."""
        super().reset()
        self._inner = self.group.drive.begin(len(self.group.kinds))
        self._weather.reset()

    def advance(self, pose, command):
        """Return the poses (m, 3) after a step from ``pose`` under ``command`` (m, axes)."""
        group, drive = self.group, self.group.drive
        after, self._inner = drive.forced(
            pose,
            self._inner,
            command,
            group.limits,
            group.numbers,
            self._weather.felt(),
            self._step,
        )
        self.velocity = drive.obeyed(self._inner)
        if self._encoders:
            rims = drive.rim_speeds(self.velocity, self.joints, group.numbers)
            self.travel += self._step * rims
        self._farthest = float(np.abs(after[:, :2] - pose[:, :2]).sum(axis=1).max(initial=0.0))
        return after

    def farthest(self):
        """Return a distance [m] that no robot's centre exceeded in the last step."""
        return self._farthest

    def fill_twist(self, twist, theta):
        """Write the body twists (m, 3) over ground into ``twist``; ``theta`` (m,) [rad]."""
        twist[:] = self.group.drive.twist_of(self._inner)
        self._add_drift(twist, theta)

    def feel(self, pushed, theta, moved):
        """Let the robots in ``pushed`` (m,) bool be as fast as contacts let them.

        ``theta`` (m,) [rad] before the step; ``moved`` (m, 2) [m/s] in the common frame.
        """
        moved = into_body(moved[pushed] - self._current, theta[pushed])
        self._inner = self.group.drive.stopped(self._inner, pushed, moved)
        self.velocity = self.group.drive.obeyed(self._inner)
