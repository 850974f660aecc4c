"""Response times of the control to odometry, and missed periods."""

import time
from collections import deque

import numpy as np

KEPT = 50  # [-] odometry cycles of which the round trips are told, a second at 50 Hz
# [s] of wall time: a command that comes back so soon was outrun by simulated time, however much of that
# has passed meanwhile; after a longer pause somebody may have stopped the controller.
OUTRUN = 1.0


class RoundTrips:
    """Wall time from odometry's leaving to the next command of each robot."""

    def __init__(self, n, clock=time.monotonic):
        """``n`` robots; ``clock`` gives wall time in s, the same as that of the commands' arrival."""
        self._clock = clock
        self.missed = self.periods = 0
        self.begin(n)

    def begin(self, n):
        """Begin anew with n robots; the periods missed so far stay counted."""
        self._trips = deque(maxlen=KEPT)
        self._sent, self._waiting = 0.0, np.zeros(n, dtype=bool)
        self._told = np.ones(n, dtype=bool)  # the period that has begun is not judged
        self._heard = np.full(n, -np.inf)  # [s] when each robot's newest command came
        self._away = np.zeros(n, dtype=int)  # periods since, that count if it was only outrun

    def sent(self, rows=None):
        """Odometry of the robots ``rows`` leaves now, by default of all."""
        self._sent = self._clock()
        self._waiting[:] = rows is None
        self._waiting[[] if rows is None else rows] = True
        self._trips.append([])

    def answered(self, rows, times):
        """Commands of the robots ``rows`` (m,) came at ``times`` (m,) [s]."""
        self._told[rows] = True
        soon = times - self._heard[rows] < OUTRUN
        self.missed += int(self._away[rows][soon].sum())
        self._heard[rows], self._away[rows] = times, 0
        first = self._waiting[rows]
        if first.any():
            self._trips[-1].append(np.maximum(times[first] - self._sent, 0.0))
            self._waiting[rows] = False

    def end_period(self, driven):
        """A command period ends: count the robots that were not told anything in it.

        Those ``driven`` (n,), under a command other than to stand, at once; others, such as those that
        their watchdogs stopped, when their commands come back at once (``OUTRUN``).
        """
        self.periods += len(driven)
        silent = ~self._told
        self.missed += int(np.count_nonzero(driven & silent))
        self._away += ~driven & silent
        self._told[:] = False

    def median_and_p99(self):
        """Return median and 99th percentile of the last trips [s]; nan before any."""
        trips = [part for cycle in self._trips for part in cycle]
        if not trips:
            return np.nan, np.nan
        return tuple(np.percentile(np.concatenate(trips), (50.0, 99.0)).tolist())
