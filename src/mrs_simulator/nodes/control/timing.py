"""Response times of the control to odometry, and missed periods."""

import time
from collections import deque

import numpy as np

KEPT = 50  # [-] odometry cycles of which the round trips are told, a second at 50 Hz


class RoundTrips:
    """Wall time from odometry's leaving to the next command of each robot."""

    def __init__(self, n, clock=time.monotonic):
        """``n`` robots; ``clock`` gives wall time in s, the same as that of the commands' arrival."""
        self._clock = clock
        self.missed = 0
        self.begin(n)

    def begin(self, n):
        """Begin anew with n robots; the periods missed so far stay counted."""
        self._trips = deque(maxlen=KEPT)
        self._sent, self._waiting = 0.0, np.zeros(n, dtype=bool)
        self._told = np.ones(n, dtype=bool)  # the period that has begun is not judged

    def sent(self):
        """Odometry of all robots leaves now."""
        self._sent = self._clock()
        self._waiting[:] = True
        self._trips.append([])

    def answered(self, rows, times):
        """Commands of the robots ``rows`` (m,) came at ``times`` (m,) [s]."""
        self._told[rows] = True
        first = self._waiting[rows]
        if first.any():
            self._trips[-1].append(np.maximum(times[first] - self._sent, 0.0))
            self._waiting[rows] = False

    def end_period(self, commanded):
        """A command period ends: count the robots that are ``commanded`` (n,) and were not told."""
        self.missed += int(np.count_nonzero(commanded & ~self._told))
        self._told[:] = False

    def median_and_p99(self):
        """Return median and 99th percentile of the last trips [s]; nan before any."""
        trips = [part for cycle in self._trips for part in cycle]
        if not trips:
            return np.nan, np.nan
        return tuple(np.percentile(np.concatenate(trips), (50.0, 99.0)).tolist())
