"""Poses of the robots by their own odometry, as last reported."""

import numpy as np

from mrs_simulator.core.arrays import read_only
from mrs_simulator.core.kinematics import compose, relative
from mrs_simulator.core.spatial import turned
from mrs_simulator.vehicles.odometry_rates import OdometrySchedule, odometry_steps
from mrs_simulator.world.part import Part
from mrs_simulator.world.wheel_odometry.odometry import WHEEL_MISMATCH, WHEEL_SLIP, WheelOdometry


class Estimates(Part):
    """Odometry of the robots that a ``motion`` moves: true poses, or those reckoned from their wheels."""

    def __init__(self, team, motion, clock, settings, starts):
        """``settings``: the ``WorldSettings``; ``starts`` (n, 3): where robots begin."""
        by_wheels, rate = settings.by_wheels, settings.odometry_rate
        errors = settings.odometry_errors
        self._team, self._motion, self._clock = team, motion, clock
        self._starts, self._mirrored = starts, settings.mirrored
        self._wheels, self._by_wheels = None, by_wheels
        if by_wheels or errors is not None:
            # wheels that roll in pybullet slip themselves
            slips = settings.fidelity == "kinematic" and errors is None
            noise = (WHEEL_MISMATCH, WHEEL_SLIP) if slips else (0.0, 0.0)
            given = *noise, settings.seed, errors, clock.step_size
            self._wheels = WheelOdometry(team, starts[:, 2], *given)
        self._aloft = np.flatnonzero(team.airborne)
        self._schedule = None
        if rate is not None:
            self._schedule = OdometrySchedule(odometry_steps(team, rate, clock.step_size))
        if self.can_fuse:
            self.after_step = None
        self.reset()

    @property
    def can_fuse(self):
        """Return whether estimates are the true poses, at each step."""
        return not self._by_wheels and self._schedule is None

    def reset(self):
        """Let all robots report their poses."""
        if self._schedule is None:  # they always report the newest
            return
        self._reported = self._newest().copy()
        self._reported_z = None if self._motion.z is None else self._motion.z.copy()

    def after_step(self):
        """Follow the motion by one step."""
        if self._by_wheels:
            self._count_wheels()
        if self._schedule is not None:
            due = self._schedule.due(self._clock.steps - self._clock.begun)
            rows = np.union1d(due, self._mirrored)
            self._reported[rows] = self._newest()[rows]
            if self._reported_z is not None:
                self._reported_z[rows] = self._motion.z[rows]

    def _count_wheels(self):
        joints, pose = self._motion.joints(), self._motion.pose
        drives = joints if joints.ndim == 1 else joints[:, 0]
        self._wheels.update(self._motion.wheel_travel, drives, pose[:, 2])
        if len(self._aloft):  # robots without encoders know how they have moved
            moved = relative(self._starts[self._aloft], pose[self._aloft])
            self._wheels.pose[self._aloft] = moved

    def odometry(self):
        """Return the poses by odometry, (n, 3), each in its robot's odometry frame, read-only."""
        return read_only(self._wheels.pose if self._by_wheels else self._motion.pose)

    def spatial(self):
        """Return the ``Spatial`` that goes with :meth:`odometry`, None for a team on the ground.

        Heights are above the ground, whatever the odometry.
        """
        spatial = self._motion.spatial
        if spatial is None or not self._by_wheels:
            return spatial
        return spatial._replace(orientation=turned(spatial.orientation, -self._starts[:, 2]))

    def origins(self):
        """Return the poses of the odometry frames in the common frame, (n, 3)."""
        return self._starts if self._by_wheels else np.zeros((self._team.n, 3))

    def pose(self):
        """Return the last reported poses in the common frame, (n, 3), read-only."""
        return read_only(self._newest() if self._schedule is None else self._reported)

    def z(self):
        """Return the heights (n,) [m] that go with :meth:`pose`; None for a team on the ground."""
        if self._motion.z is None:
            return None
        return read_only(self._motion.z if self._schedule is None else self._reported_z)

    def _newest(self):
        if not self._by_wheels:
            return self._motion.pose
        estimate = compose(self._starts, self._wheels.pose)
        estimate[self._mirrored] = self._motion.pose[self._mirrored]
        return estimate
