"""Robots that forces of water or air move, worked out as arrays, without a solver."""

import numpy as np

from mrs_simulator.vehicles.team import columns_of
from mrs_simulator.world.kinematic import KinematicMotion
from mrs_simulator.world.weather import Weather


class ForcedMotion(KinematicMotion):
    """Robots under forces, kept apart as without them."""

    def __init__(self, kinds, *arguments, environment, seed, **named):
        """As ``KinematicMotion``; ``seed``: of the gusts and waves of ``environment``."""
        self._environment, self._seed = environment, seed
        super().__init__(kinds, *arguments, environment=environment, **named)

    def reset(self, poses):
        """Put the robots at rest at ``poses`` (n, 3), in weather from its beginning."""
        super().reset(poses)
        self._reach = np.inf  # waves push harder than thrusters
        self._parts = {group.drive: self._part(group) for group in self.team.groups}

    def _part(self, group):
        rows = np.arange(self.team.n)[group.rows]
        weather = Weather(self._environment, self.step, self._seed, rows)
        return ForcedGroup(group, weather, self.step)

    def _moved(self, before, command):
        after = before.copy(order="F")
        for group, travel in zip(self.team.groups, self.wheel_travel):
            part = self._parts[group.drive]
            after[group.rows] = part.advance(before[group.rows], group.of(command))
            if self._encoders:
                travel += self.step * part.counted()
        after[self._mirrored] = before[self._mirrored]  # nothing carries them off
        return after

    def _own_twist(self):
        twist = np.zeros_like(self.pose)
        for group in self.team.groups:
            twist[group.rows] = self._parts[group.drive].twist()
        return twist

    def _feel(self, group, pushed, moved):
        self._parts[group.drive].feel(pushed, moved)


class ForcedGroup:
    """The inner state of the robots of one drive under forces."""

    def __init__(self, group, weather, step):
        """``group``: a ``vehicles.team.Group``; ``weather``: what these robots feel; ``step`` [s]."""
        self._drive, self._limits = group.drive, group.limits
        self._numbers = columns_of(group.kinds, group.drive)  # whatever the limits
        self._weather, self._step = weather, step
        self._state = group.drive.begin(len(group.kinds))
        weather.reset()

    def advance(self, pose, command):
        """Return the poses (m, 3) after a step from ``pose`` under ``command`` (m, axes)."""
        after, self._state = self._drive.forced(
            pose,
            self._state,
            command,
            self._limits,
            self._numbers,
            self._weather.felt(),
            self._step,
        )
        return after

    def counted(self):
        """Return what the encoders count per second, (m, encoders)."""
        velocity = self._drive.obeyed(self._state)
        return self._drive.rim_speeds(velocity, np.zeros(len(velocity)), self._numbers)

    def twist(self):
        """Return the body twists (m, 3) through the water, [m/s, m/s, rad/s]."""
        return self._drive.twist_of(self._state)

    def feel(self, pushed, moved):
        """Let the robots ``pushed`` (m,) bool be as fast as contacts let them, ``moved`` (m, 2) [m/s]."""
        self._state = self._drive.stopped(self._state, pushed, moved[pushed])
