"""When the law is to be asked, where simulated time does not wait for the answer."""

import time

LATE = 1.5  # [-] periods of wall time for which a due command waits for its odometry
EARLY = 1e-6  # [s] by which equal times may differ


class CommandTimes:
    """Commands at a fixed rate, each made of the newest odometry that is due by then.

    Simulated time comes on /clock shortly before the odometry of the same time.  A command that did not
    wait for it would answer odometry one period old, and so would every later one.
    """

    def __init__(self, period, clock=time.monotonic):
        """``period`` [s] between two commands; ``clock`` gives wall time in s."""
        self.period, self._clock = period, clock
        self.missed = 0  # periods in which no command was made
        self.forget()

    def forget(self):
        """Begin anew: the next command is due at once, and what passes until then is not missed."""
        self._next, self._waiting = None, None

    def take(self, now, is_up_to_date=None, running=True):
        """Return whether a command is to be made at ``now`` [s]; then it counts as made.

        ``is_up_to_date(now)``: returns whether all odometry due by then is there, asked where a command is
        due; by default nothing is waited for.  After ``LATE`` periods of wall time nor is odometry.  While
        ``running`` the periods that were left out are missed.
        """
        if not self._is_due(now):
            self._waiting = None
            return False
        if is_up_to_date is not None and not is_up_to_date(now):
            wall = self._clock()
            self._waiting = wall if self._waiting is None else self._waiting
            if wall - self._waiting <= LATE * self.period:
                return False
        self._go_on(now, running)
        return True

    def _is_due(self, now):
        if self._next is None or self._next - now <= EARLY:
            return True
        # Longer than this means that the clock went back: a simulator was started again.
        return self._next - now > 2.0 * self.period

    def _go_on(self, now, running):
        late = self._next is None or not -EARLY <= now - self._next <= self.period
        if late and self._next is not None and now > self._next and running:
            self.missed += int((now - self._next) / self.period + EARLY)
        self._next = (now if late else self._next) + self.period
        self._waiting = None
