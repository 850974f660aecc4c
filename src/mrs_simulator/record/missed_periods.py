"""How many of their command periods the robots of a run missed: whether its timing is to be trusted."""

MOST_MISSED = 0.05  # [-] share of the periods, beyond which a run is not judged
FEWEST = 20  # [-] periods of each robot, before which nothing is said
DEGRADED = (
    "timing was degraded: {:.0%} of the command periods passed without a command, as simulated time "
    "outran the controller"
)


class MissedPeriods:
    """Counts over a run, from the totals that a stage tells."""

    def __init__(self):
        self.begin()

    def begin(self):
        """Begin anew with a run."""
        self._first, self._last = None, None

    def note(self, stamp, robots, missed, periods):
        """Take in that up to ``stamp`` [s] ``robots`` missed so many of their ``periods``, both in all."""
        told = stamp, robots, missed, periods
        if self._last is not None and (stamp < self._last[0] or missed < self._last[2]):
            self.begin()  # the stage was started again
        self._first = self._first or told
        self._last = told

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
        """Return in words that the run's timing cannot be trusted, or ""."""
        share = self.share()
        return DEGRADED.format(share) if share > MOST_MISSED else ""
