"""Command periods that the robots of a run missed: whether its timing can be trusted."""

MOST_MISSED = 0.05  # [-] share of the periods, beyond which a run is not judged
FEWEST = 20  # [-] periods of each robot, before which nothing is reported
DEGRADED = (
    "timing was degraded: {:.0%} of the command periods passed without a command, as simulated time "
    "outran the controller"
)


class MissedPeriods:
    """Counts over a run, from the totals that a stage publishes."""

    def __init__(self):
        self.begin()

    def begin(self):
        """Start counting for a new run."""
        self._first, self._last = None, None

    def note(self, stamp, robots, missed, periods):
        """Note the totals ``missed`` and ``periods`` of all ``robots`` up to ``stamp`` [s]."""
        totals = stamp, robots, missed, periods
        if self._last is not None and (stamp < self._last[0] or missed < self._last[2]):
            self.begin()  # the stage was started again
        self._first = self._first or totals
        self._last = totals

    def share(self):
        """Return the share of all robots' periods that were missed, 0 while there were few."""
        if self._first is None:
            return 0.0
        _, robots, missed, periods = self._last
        periods -= self._first[3]
        if periods < FEWEST * max(1, robots):
            return 0.0
        return min(1.0, (missed - self._first[2]) / periods)

    def text(self):
        """Return a text if the run's timing cannot be trusted, else ""."""
        share = self.share()
        return DEGRADED.format(share) if share > MOST_MISSED else ""
