"""How many of their command periods the robots of a run missed: whether its timing is to be trusted."""

MOST_MISSED = 0.05  # [-] share of the periods, beyond which a run is not judged
FEWEST = 20  # [-] periods, before which nothing is said
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

    def note(self, stamp, robots, missed, period):
        """Take in that ``robots`` missed so many periods of ``period`` [s] up to ``stamp`` [s], in all."""
        told = stamp, robots, missed, period
        if self._last is not None and (stamp < self._last[0] or missed < self._last[2]):
            self.begin()  # the stage was started again
        self._first = self._first or told
        self._last = told

    def share(self):
        """Return the share of all robots' periods that were missed, 0 while there were few."""
        if self._first is None or self._last[3] <= 0.0:
            return 0.0
        stamp, robots, missed, period = self._last
        periods = (stamp - self._first[0]) / period
        if periods < FEWEST:
            return 0.0
        return min(1.0, (missed - self._first[2]) / (periods * max(1, robots)))

    def text(self):
        """Return in words that the run's timing cannot be trusted, or ""."""
        share = self.share()
        return DEGRADED.format(share) if share > MOST_MISSED else ""
