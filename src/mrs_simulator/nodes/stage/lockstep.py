"""Lockstep: simulated time waits until every controlled robot has answered its odometry."""

import time

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node.node_parameters import LOCKSTEP, SPEED
from mrs_simulator.ros.node.parameters import read

QUIET = 0.2  # [s] of wall time without an answer after which none is under way


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
        self._waiting = set()
        self._since = self._received_at = clock()

    def expect(self, rows):
        """Begin to wait for an answer of each robot in ``rows``."""
        self._waiting = set(rows)
        self._since = self._clock()

    def answered(self, rows):
        """Count the answers of the robots in ``rows``."""
        self._waiting.difference_update(rows)
        self._received_at = self._clock()

    @property
    def waiting_for(self):
        """Return the rows of the robots that have not answered, ascending."""
        return sorted(self._waiting)

    def settled(self):
        """Return whether all have answered, and no further answer to the same odometry is under way."""
        return not self._waiting and self._clock() - self._received_at > QUIET

    def overdue(self):
        """Return whether the time limit has passed; it then starts anew."""
        if self._waiting and self._clock() - self._since > self.timeout:
            self._since = self._clock()
            return True
        return False
