"""A display's questions to a law, answered by a process of its own where the law is a user's.

A protocol's file may raise anything, end its interpreter, or never finish importing.  Shipped laws
are asked in this process what they answer at once (0.3 s at most, of 200 robots), and apart for
predictions, which take some of them 10 s: computed in a thread they would hold up a window.
"""

import threading
import time

from mrs_simulator.control.user_code import ENDED, CallFailed, TimedOut, Worker
from mrs_simulator.control.worker_process import FreshProcess
from mrs_simulator.protocols import HOMES
from mrs_simulator.study.run import law_answers

LIMIT = 30.0  # [s] of wall time for one answer, the import of the law's file included
# Answers that may take seconds, whatever the law.
LONG = ("prediction", "forecast", "ahead", "standings_of", "verdict_on")
GRACE = 0.1  # [s] of wall time for an answer before ``waiting`` is called


class LawError(ValueError):
    """A law that raised, hung or ended its process; the message says where in the user's file."""

    page = "docs/protocols.md"


class LawProcess:
    """Asks laws through the functions of :mod:`law_answers`; from one thread at a time.

    ``waiting(seconds)`` is called again and again while an answer is awaited for longer than ``GRACE``;
    what it raises ends the law's process and is raised.  ``waited()`` is called after that.
    """

    def __init__(self, limit=LIMIT):
        """``limit`` [s] of wall time for one answer of a user's law."""
        self.limit = limit
        self.waiting, self.waited = lambda seconds: None, lambda: None
        self._worker, self._closed = None, False
        self._lock, self._busy = threading.RLock(), False
        self._starting = threading.Lock()

    def ask(self, function, scenario, *arguments):
        """Return ``law_answers.<function>(scenario, *arguments)``.

        Raises what a shipped law raises, and ``LawError`` for any failure of a user's law.
        """
        if scenario.control.protocol in HOMES and function not in LONG:
            return law_answers.serve(function, scenario, *arguments)
        with self._lock:
            if self._busy:  # by the same thread, in ``waiting``
                raise LawError("another law is being tried")
            self._busy = True
            try:
                return self._ask((function, scenario, *arguments), scenario.control.protocol)
            finally:
                self._busy = False

    def _ask(self, request, name):
        with self._starting:
            if self._closed:
                raise LawError("{}: not asked any more".format(name))
            if self._worker is None or self._worker.given_up:
                self._worker = Worker(FreshProcess(law_answers.__name__))
        begun, notified = time.monotonic(), []

        def meanwhile():
            taken = time.monotonic() - begun
            if taken > GRACE:
                notified.append(taken)
                self.waiting(taken)

        try:
            return self._worker.ask(request, self.limit, meanwhile)
        except TimedOut as error:
            raise LawError("{}: {}".format(name, error)) from None
        except CallFailed as error:
            ended = str(error).startswith(ENDED)
            raise LawError("{}: {}".format(name, error) if ended else error.said) from None
        finally:
            if notified:
                self.waited()

    def close(self):
        """End the process, with what it has started, and start no other."""
        with self._starting:
            self._closed = True
        if self._worker is not None:
            self._worker.give_up()
