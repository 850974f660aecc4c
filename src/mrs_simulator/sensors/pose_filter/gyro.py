"""Turns measured by gyros, in place of those of the wheels."""

import bisect

import numpy as np

from mrs_simulator.core.step_rates import steps_between
from mrs_simulator.sensors.noise import NOISELESS
from mrs_simulator.sensors.pose_filter.pose_measurements import offset, white


class Gyro:
    """Recent readings of the gyros of a team.

    A reading holds for the period before its stamp, as far as the reading before it does not cover that.
    """

    def __init__(self, mount, step):
        """``mount`` of the inertial sensor; ``step`` [s] of the world."""
        noise = dict(mount.noise).get("rate", NOISELESS)
        self.name = mount.name
        self._period = max(steps_between(mount.rate, step) * step, 1.0 / mount.rate)
        self._reach = int(round(1e9 * self._period))  # [ns]
        self._variance = white(noise)
        self.first, self.walks = [offset(noise)], [noise.bias_walk**2]
        self.is_biased = bool(self.first[0] + self.walks[0])
        self._readings = []  # (stamp, count, rows, rates), by stamp
        self._count = 0

    def take(self, stamp, readings):
        """Add ``readings``, ``[(row, reading)]``; return the time [ns] from which on they hold."""
        rates = np.array([reading.rate[2] for _, reading in readings])
        known = np.isfinite(rates)
        rows = np.array([row for row, _ in readings])[known]
        self._count += 1
        bisect.insort(self._readings, (stamp, self._count, rows, rates[known]))
        return stamp - self._reach

    def forget(self, before):
        """Drop the readings with stamps before ``before`` [ns]."""
        del self._readings[: bisect.bisect_left(self._readings, (before,))]

    def turn(self, move, moved, variances):
        """Write the gyros' turns into ``moved`` (m, 3) and ``variances`` (m, 3) of a ``Move``.

        Return for how many seconds (m,) of it there are readings; for the rest the wheels' turns stay.
        """
        turned, covered = np.zeros(len(moved)), np.zeros(len(moved), dtype=np.int64)
        until = np.full(len(moved), move.start)  # [ns] up to which turns are covered
        at = bisect.bisect_right(self._readings, (move.start, np.inf))
        for stamp, _, rows, rates in self._readings[at:]:
            if stamp - self._reach >= move.end:
                break
            _, here, there = np.intersect1d(move.rows, rows, True, return_indices=True)
            begun = np.maximum(until[here], stamp - self._reach)
            until[here] = min(stamp, move.end)
            overlap = until[here] - begun
            turned[here] += rates[there] * (overlap / 1e9)
            covered[here] += overlap
        left = 1.0 - covered / (move.end - move.start)
        known = covered > 0
        seconds = covered[known] / 1e9
        moved[known, 2] = turned[known] + left[known] * moved[known, 2]
        # Until the next reading the error is the same: its steps add up, and not their squares.
        error = self._variance * seconds * self._period
        variances[known, 2] = error + left[known] * variances[known, 2]
        return covered / 1e9
