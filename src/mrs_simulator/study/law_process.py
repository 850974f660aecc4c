"""A user's law in a process of its own: whatever it does, the program that asks goes on.

A protocol's file may raise anything, end its interpreter, or never finish importing.  Shipped laws
are asked in this process.
"""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection, Pipe

from mrs_simulator.control.laws import HOMES
from mrs_simulator.control.user_code import call
from mrs_simulator.study import law_answers

LIMIT = 30.0  # [s] of wall time for one answer, the import of the law's file included
GRACE = 0.1  # [s] of wall time for an answer before ``waiting`` is called
POLL = 0.02  # [s] of wall time between two calls of ``waiting``
FAREWELL = 1.0  # [s] of wall time for a process that has closed its pipe
LOOK_PERIOD = 0.5  # [s] of wall time between two looks for the parent
# The directory that it is called from may hold a user's random.py.
PROGRAM = (
    "import sys; del sys.path[0]; from {} import serve; serve(*map(int, sys.argv[1:]))".format(
        __name__
    )
)
PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class LawError(ValueError):
    """A law that raised, hung or ended its process; the message says where in the user's file."""


class LawProcess:
    """Asks laws through the functions of :mod:`law_answers`; from one thread at a time.

    ``waiting(seconds)`` is called again and again while an answer is awaited for longer than ``GRACE``;
    what it raises ends the law's process and is raised.  ``waited()`` is called after that.
    """

    def __init__(self, limit=LIMIT):
        """``limit`` [s] of wall time for one answer of a user's law."""
        self.limit = limit
        self.waiting, self.waited = lambda seconds: None, lambda: None
        self._process, self._pipe = None, None
        self._lock, self._busy = threading.RLock(), False

    def ask(self, function, scenario, *arguments):
        """Return ``law_answers.<function>(scenario, *arguments)``.

        Raises what a shipped law raises, and ``LawError`` for any failure of a user's law.
        """
        if scenario.control.protocol in HOMES:
            return getattr(law_answers, function)(scenario, *arguments)
        with self._lock:
            if self._busy:  # by the same thread, in ``waiting``
                raise LawError("another law is being tried")
            try:
                return self._ask((function, scenario) + arguments, scenario.control.protocol)
            except (EOFError, OSError):
                code = self.close(FAREWELL)
                raise LawError(
                    "{}: ended its process (exit code {})".format(scenario.control.protocol, code)
                ) from None

    def _ask(self, request, name):
        if self._process is None or self._process.poll() is not None:
            self._start()
        self._pipe.send(request)
        if not self._pipe.poll(GRACE):
            self._busy = True
            try:
                self._await(name)
            except BaseException:
                self.close()
                raise
            finally:
                self._busy = False
                self.waited()
        success, answer = self._pipe.recv()
        if not success:
            raise LawError(answer)
        return answer

    def _await(self, name):
        begun = time.monotonic()
        while not self._pipe.poll(POLL):
            taken = time.monotonic() - begun
            if taken > self.limit:
                raise LawError("{}: no answer within {:g} s".format(name, self.limit))
            self.waiting(taken)

    def _start(self):
        self._pipe, theirs = Pipe()
        with theirs:
            handle = theirs.fileno()
            # Not a fork: the threads of the program that asks may hold any lock.
            self._process = subprocess.Popen(
                [sys.executable, "-c", PROGRAM, str(handle), str(os.getpid())],
                pass_fds=[handle],
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )

    def close(self, farewell=0.0):
        """Kill the process, with what it has started; return its exit code, None without one.

        One that is ending has ``farewell`` [s] for that.
        """
        process, self._process = self._process, None
        if process is None:
            return None
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(farewell)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        self._pipe.close()
        return process.wait()


def blamed(error):
    """Return what ``error`` says, with the last line of a user's file that led to it."""
    origin = error.__cause__ or error
    frames = [
        frame
        for frame in traceback.extract_tb(origin.__traceback__)
        if not frame.filename.startswith((PACKAGE, "<"))
    ]
    own = [frame for frame in frames if "site-packages" not in frame.filename] or frames
    worded = isinstance(error, (ValueError, OSError)) and (origin is not error or not own)
    said = str(error) if worded else "{}: {}".format(type(error).__name__, error)
    if not own or isinstance(origin, SyntaxError):  # which names file and line itself
        return said
    inside = "" if own[-1].name == "<module>" else ", in {}".format(own[-1].name)
    line = ": " + own[-1].line if own[-1].line else ""
    return "{}\n{}:{}{}{}".format(said, own[-1].filename, own[-1].lineno, inside, line)


def serve(handle, parent):
    """Answer the requests that come through the pipe ``handle`` while the process ``parent`` lives."""
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    with Connection(handle) as pipe, contextlib.suppress(EOFError):
        while True:
            function, *arguments = pipe.recv()
            try:
                answer = True, call(getattr(law_answers, function), *arguments)
            except Exception as error:
                answer = False, blamed(error)
            pipe.send(answer)


def _end_with(parent):
    while os.getppid() == parent:
        time.sleep(LOOK_PERIOD)
    os._exit(1)
