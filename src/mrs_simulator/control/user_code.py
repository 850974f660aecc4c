"""Calls of users' code, and running it isolated from the rest of a program.

A law may raise anything, SystemExit too, hang, hold the interpreter's lock or end its process.
``call`` turns whatever it raises into an ``Exception``; ``Worker`` has it run in a process
(:mod:`worker_process`), or a thread, of its own, and gives it up after a time limit.
"""

import dis
import os
import queue
import signal
import threading
import time
import traceback
from typing import NamedTuple

from mrs_simulator.core.doc_links import named, words
from mrs_simulator.core.reports import report

PATIENCE = 2.0  # [s] of wall time that a request waits for the one before it
NAP = 0.05  # [s] of wall time between two calls of ``meanwhile``
LONGEST_LOOK = 1.0  # [s] of wall time for where a process is that does not answer
GRACE = 1.0  # [s] of wall time for a process that has closed its pipe
RAISE = dis.opmap["RAISE_VARARGS"]
ENDED = "its process ended"
WHOLE_TRACE = "MRS_SIMULATOR_TRACEBACK"  # environment variable: 1 for this package's lines, too
PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class UserCodeError(RuntimeError):
    """Users' code raised what is no ``Exception``, as ``sys.exit()`` does; the message names it."""


class CallFailed(RuntimeError):
    """Users' code raised in its worker.

    ``kind`` is the error's type, ``trace`` its traceback, and ``said`` it in one or two lines, with the
    user's file and line.
    """

    def __init__(self, kind, text, trace, said):
        super().__init__(text)
        self.kind, self.trace, self.said = kind, trace, said


class TimedOut(RuntimeError):
    """Users' code did not end within its limit in its worker, which was given up."""


def call(function, *arguments, **named):
    """Return ``function(*arguments, **named)``, users' code; only an ``Exception`` leaves it.

    Raises what it raises; ``UserCodeError`` for what is no ``Exception``, such as ``SystemExit``, but
    for an interrupt from the keyboard.
    """
    try:
        return function(*arguments, **named)
    except Exception:
        raise
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) and is_from_keyboard(error):
            raise
        text = "{}({})".format(type(error).__name__, words(error))
        raise UserCodeError("it tried to end the program: " + text) from error


def is_from_keyboard(error):
    """Return whether a ``KeyboardInterrupt`` came by a signal: no statement ``raise`` is where it began."""
    trace = error.__traceback__
    while trace.tb_next is not None:
        trace = trace.tb_next
    code, handler = trace.tb_frame.f_code, signal.getsignal(signal.SIGINT)
    return code.co_code[trace.tb_lasti] != RAISE or code is getattr(handler, "__code__", None)


def raised(error):
    """Return what users' code raised, given an ``error`` that left :func:`call`."""
    return error.__cause__ if isinstance(error, UserCodeError) else error


class Failure(NamedTuple):
    """What users' code raised, as texts, which can be sent between processes."""

    kind: str
    text: str
    trace: str
    said: str


def outcome(serve, request):
    """Return ``(True, value)`` of ``serve(*request)``, or ``(False, Failure)``."""
    try:
        return True, call(serve, *request)
    except (Exception, KeyboardInterrupt) as error:
        origin = raised(error)
        kind, trace = type(origin).__name__, traceback.format_exc()
        return False, Failure(kind, words(origin), trace, blamed(error))


def print_raised(error):
    """Print the traceback of ``error`` on stderr: the users' own lines, and not this package's.

    All lines where users have none in it, or where the environment has ``WHOLE_TRACE=1``.
    """
    trace = traceback.TracebackException.from_exception(raised(error))
    if os.environ.get(WHOLE_TRACE, "0") == "0":
        link = trace
        while link is not None:
            own = _own_frames(link.stack)
            link.stack = traceback.StackSummary.from_list(own) if own else link.stack
            link = link.__cause__ or link.__context__
    report("".join(trace.format()).rstrip("\n"))


def _own_frames(stack):
    """Return those frames of a ``stack`` that are in users' files."""
    frames = [frame for frame in stack if not frame.filename.startswith((PACKAGE, "<"))]
    return [frame for frame in frames if "site-packages" not in frame.filename] or frames


def blamed(error):
    """Return what ``error`` says, with the last line of a user's file that led to it."""
    origin = raised(error.__cause__ or error)
    own = _own_frames(traceback.extract_tb(origin.__traceback__))
    worded = isinstance(error, (ValueError, OSError)) and (origin is not error or not own)
    said = words(error) if worded else named(error)
    if not own or isinstance(origin, SyntaxError):  # which names file and line itself
        return said
    inside = "" if own[-1].name == "<module>" else ", in {}".format(own[-1].name)
    line = ": " + own[-1].line if own[-1].line else ""
    return "{}\n{}:{}{}{}".format(said, own[-1].filename, own[-1].lineno, inside, line)


class Worker:
    """Serves requests one after the other, isolated; a request that takes too long ends it."""

    def __init__(self, runner):
        """``runner``: :class:`WorkerThread`, :class:`InPlace`, or a process."""
        self._runner, self._busy = runner, threading.Lock()
        self.given_up = False

    def ask(self, request, limit, meanwhile=None):
        """Return the service's answer to ``request``, a tuple; ``meanwhile()`` is called while waiting.

        Raises ``CallFailed``; ``TimedOut`` after ``limit`` [s] of wall time, and from then on.  What
        ``meanwhile`` raises is raised, and ends it.
        """
        end = time.monotonic() + limit
        if not self._busy.acquire(timeout=min(PATIENCE, limit)):
            raise TimedOut("it is still busy")
        try:
            if self.given_up:
                raise TimedOut("it was given up")
            self._runner.send(request)
            self._await(end, limit, meanwhile)
            done, value = self._runner.receive()
        except (EOFError, OSError):
            self.given_up = True
            code = self._runner.end(GRACE)
            text = ENDED if code is None else "{} (exit code {})".format(ENDED, code)
            raise CallFailed("SystemExit", text, text, text) from None
        finally:
            self._busy.release()
        if not done:
            raise CallFailed(*value)
        return value

    def _await(self, end, limit, meanwhile):
        while not self._runner.ready(max(0.0, min(NAP, end - time.monotonic()))):
            if time.monotonic() >= end:
                where = self._runner.where(min(limit, LONGEST_LOOK))
                self.give_up()
                at = ", it is at {}".format(where) if where else ""
                raise TimedOut("no answer within {:g} s{}".format(limit, at))
            if meanwhile is not None:
                try:
                    meanwhile()
                except BaseException:
                    self.give_up()
                    raise

    @property
    def busy(self):
        """Return whether a request is under way."""
        return self._busy.locked()

    def give_up(self):
        """End it, also during a request, without waiting."""
        self.given_up = True
        self._runner.end()


class WorkerThread:
    """Runs requests in a thread of this process, which cannot be ended, only abandoned."""

    def __init__(self, service):
        """``service()``: returns the function that serves a request."""
        self._requests, self._answers = queue.Queue(), queue.Queue()
        self._answer = None
        threading.Thread(target=self._run, args=(service,), daemon=True).start()

    def _run(self, service):
        serve = service()
        for request in iter(self._requests.get, None):
            self._answers.put(outcome(serve, request))

    def send(self, request):
        """Begin to serve ``request``."""
        self._requests.put(request)

    def ready(self, seconds):
        """Return whether the answer is there within ``seconds``."""
        try:
            self._answer = self._answers.get(timeout=seconds) if seconds else None
        except queue.Empty:
            return False
        return self._answer is not None

    def receive(self):
        """Return the answer."""
        return self._answer

    def where(self, _):
        """Return "", not known."""
        return ""

    def end(self, _grace=0.0):
        """Take no more requests."""
        self._requests.put(None)


class InPlace:
    """Runs requests in the caller's thread: for laws that are known to end."""

    def __init__(self, service):
        """``service()``: returns the function that serves a request."""
        self._serve, self._answer = service(), None

    def send(self, request):
        """Serve ``request``."""
        self._answer = outcome(self._serve, request)

    def ready(self, _):
        """Return whether the answer is there."""
        return True

    def receive(self):
        """Return the answer."""
        return self._answer

    def end(self, _grace=0.0):
        """Do nothing."""
