"""Lockstep: simulated time waits until every controlled robot has answered its odometry."""

import time

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node.node_parameters import LOCKSTEP, SPEED
from mrs_simulator.ros.node.parameters import read

QUIET = 0.2  # [s] of wall time without an answer after which none is under way
LOOK = 0.02  # [s] of it that one look counts for at most: a stage that is held up receives nothing


@explained_by("docs/robots.md#robots-and-simulated-robots-in-one-team")
def lockstep_wanted(real, speed):
    """Return the parameter ``~lockstep``; ``ValueError`` if any robot of the rows ``real`` is real.

    ``auto``, as launch files say: where all robots are simulated, at another speed than 1; else a
    control that cannot keep up would drive another experiment.  ``speed``: the scenario's, unless
    ``~speed`` asks for another.
    """
    wanted = read(LOCKSTEP)
    if wanted == "auto":
        return not real and read(SPEED, speed) != 1.0
    if wanted and real:
        numbers = ", ".join(str(row + 1) for row in real)
        raise ValueError(
            "lockstep: true with real robots {}: simulated time cannot wait for what goes on by "
            "itself, wanted false".format(numbers)
        )
    return wanted


class Lockstep:
    """Keeps which robots have yet to answer, and when it is time to name the silent ones."""

    def __init__(self, timeout, clock=time.monotonic):
        """``timeout`` [s] of wall time after which silence is reported; ``clock`` in s."""
        self.timeout = timeout
        self._clock = clock
        self._waiting, self._repeated = set(), False
        self._since = self._looked = clock()
        self._calm = 0.0  # [s] without an answer

    def expect(self, rows):
        """Begin to wait for an answer of each robot in ``rows``."""
        self._waiting, self._repeated = set(rows), False
        self._since = self._clock()

    def answered(self, rows):
        """Count the answers of the robots in ``rows``."""
        self._waiting.difference_update(rows)
        self._calm, self._looked = 0.0, self._clock()

    @property
    def waiting_for(self):
        """Return the rows of the robots that have not answered, ascending."""
        return sorted(self._waiting)

    def settled(self, quiet=QUIET):
        """Return whether all have answered, and no further answer to the same odometry is under way.

        To be asked again and again.
        """
        now = self._clock()
        self._calm, self._looked = self._calm + min(now - self._looked, LOOK), now
        return not self._waiting and self._calm > quiet

    def may_go_on(self):
        """Return whether all have answered; of odometry that was said again, whether it is settled, too.

        Its second answer would else count as that to the next.
        """
        if self._repeated:
            return self.settled(min(QUIET, self.timeout))
        return not self._waiting

    def overdue(self):
        """Return whether the time limit has passed, and odometry is to be said again; it starts anew."""
        if self._waiting and self._clock() - self._since > self.timeout:
            self._since, self._repeated = self._clock(), True
            return True
        return False
