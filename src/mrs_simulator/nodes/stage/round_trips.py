"""Round trips from odometry to the commands that answer it, and missed periods."""

import time

import numpy as np

from mrs_simulator.core.log_histogram import LogHistogram

KEPT = 4096  # [-] stamps of odometry that an answer may still come to: over a minute at 50 Hz
LATEST = 1e11  # [s] beyond which a stamp is none
SLACK = 1e-6  # [s] by which stamps of the same time may differ
# [s] of wall time: a command that comes back so soon was outrun by simulated time, however much of that
# has passed meanwhile; after a longer pause a person may have stopped the controller.
OUTRUN = 1.0


class RoundTrips:
    """Wall time from each odometry's leaving to the first command of each robot that answers it.

    A command answers the odometry whose stamp its sender gives.  Where none is given, the command counts
    for the period in which it came, and for no round trip.
    """

    def __init__(self, n, period, clock=time.monotonic):
        """``n`` robots, a command due every ``period`` [s] of simulated time.

        ``clock`` gives wall time in s, the same as that of the commands' arrival.
        """
        self._clock = clock
        self.missed = self.periods = 0
        self.begin(n, period)

    def begin(self, n, period):
        """Begin anew with n robots; the periods missed so far stay counted."""
        self._trips, self._period = LogHistogram(), period
        self._left = {}  # [s] of wall time by the stamp of the odometry [us], ascending
        self._newest = np.full(n, -1, dtype=np.int64)  # [us] stamp that each robot answered last
        self._begun = (-np.inf, -np.inf)  # [s] when the last period and this one began
        self._past = None  # who was commanded in the last one, and who was driven; None: not judged
        self._commanded = np.ones(n, dtype=bool)  # the period that has begun is not judged
        self._received_at = np.full(n, -np.inf)  # [s] when each robot's newest command came
        self._away = np.zeros(n, dtype=int)  # periods since, that count if it was only outrun

    def sent(self, stamp):
        """Odometry stamped ``stamp`` [s] leaves now; what leaves again with a stamp left before."""
        self._left.setdefault(int(_microseconds(stamp)), self._clock())
        if len(self._left) > KEPT:
            del self._left[next(iter(self._left))]

    def answered(self, rows, times, stamps, now):
        """Commands of the robots ``rows`` (m,) came at ``times`` (m,) [s] of wall time.

        ``stamps`` (m,) [s]: of the odometry that each answers, NaN where unknown; ``now`` [s]:
        simulated time.
        """
        rows, times = np.asarray(rows, dtype=int), np.asarray(times, dtype=float)
        stamps = np.asarray(stamps, dtype=float)
        self._note_periods(rows, stamps, now)
        soon = times - self._received_at[rows] < OUTRUN
        self.missed += int(self._away[rows][soon].sum())
        self._received_at[rows], self._away[rows] = times, 0
        known = np.abs(stamps) < LATEST
        keys = _microseconds(stamps[known])
        for key in np.unique(keys).tolist():
            which = rows[known][keys == key]
            first = self._newest[which] < key
            if key in self._left and first.any():
                self._trips.add(times[known][keys == key][first] - self._left[key])
                self._newest[which[first]] = key

    def waited_for(self, rows):
        """Commands of the robots ``rows`` came, for which time has waited: the period has them.

        Which odometry they answer may become known later, after whole periods of a fast simulation.
        """
        self._commanded[rows] = True

    def _note_periods(self, rows, stamps, now):
        """Take in for which periods commands came in time: of this one or the last."""
        unknown = ~np.isfinite(stamps)
        on_time = now - stamps <= self._period + SLACK
        last, this = self._begun
        self._commanded[rows[unknown | (on_time & (stamps >= this - SLACK))]] = True
        if self._past is not None:
            late = on_time & (stamps >= last - SLACK) & (stamps < this - SLACK)
            self._past[0][rows[late]] = True

    def end_period(self, now, driven):
        """A command period ends at ``now`` [s] of simulated time, and another begins.

        Judged is the one before it: an answer to its odometry may have come one period late.  Counted are
        the robots without one, those ``driven`` (n,), under a command other than to stand, at once;
        others, such as those that their watchdogs stopped, when their commands come back at once
        (``OUTRUN``).
        """
        judged, self._past = self._past, (self._commanded, np.array(driven))
        self._commanded = np.zeros_like(self._commanded)
        self._begun = (self._begun[1], now)
        self.periods += len(driven)
        if judged is not None:
            silent, driven = ~judged[0], judged[1]
            self.missed += int(np.count_nonzero(driven & silent))
            self._away += ~driven & silent

    def median_and_p99(self):
        """Return median and 99th percentile of all trips since it began [s]; nan before any."""
        return self._trips.quantile(0.5), self._trips.quantile(0.99)


def _microseconds(seconds):
    """Return times [s] as whole microseconds, in which equal stamps are equal."""
    return np.rint(1e6 * np.asarray(seconds)).astype(np.int64)
