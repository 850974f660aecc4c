"""The poses that a control has estimated, until the samples of their times are there.  No Qt, no ROS."""

from collections import deque

import numpy as np

from mrs_simulator.verdict.estimation import SAME, held_at

KEPT = 500  # [-] newest estimates


class EstimateLog:
    """The newest estimates of a team, in the order of their stamps."""

    def __init__(self):
        self._estimates = deque(maxlen=KEPT)  # (stamp [s], pose (n, 3))

    def clear(self):
        """Clear everything."""
        self._estimates.clear()

    def add(self, stamp, pose):
        """Add ``pose`` (n, 3) [m, m, rad] of the time ``stamp`` [s]; one that went back begins anew."""
        if self._estimates and (
            stamp < self._estimates[-1][0] or len(pose) != len(self._estimates[-1][1])
        ):
            self._estimates.clear()
        self._estimates.append((stamp, pose))

    @property
    def first(self):
        """Return the time [s] of the oldest, infinite where there is none."""
        return self._estimates[0][0] if self._estimates else np.inf

    def at(self, times):
        """Return which of ``times`` (m,) [s] have estimates that held then, bool, and these (k, n, 3).

        Of times after the newest it is not known yet.
        """
        stamps = [stamp for stamp, _ in self._estimates]
        found = held_at(stamps, times)
        known = (found >= 0) & (times <= (stamps[-1] if stamps else -np.inf) + SAME)
        return known, np.array([self._estimates[place][1] for place in found[known]])
