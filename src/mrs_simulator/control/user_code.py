"""The one way in which users' code is called, and where it is run apart from what must go on.

A law may raise anything, SystemExit too, hang, hold the interpreter's lock or end its process.
``call`` turns whatever it raises into an ``Exception``; ``Worker`` runs it in a process, or a thread,
of its own, and gives it up after a time limit.
"""

import array
import contextlib
import ctypes
import multiprocessing.connection
import os
import queue
import signal
import socket
import threading
import time
import traceback
from typing import NamedTuple

PATIENCE = 2.0  # [s] of wall time that a request waits for the one before it
NAP = 0.05  # [s] of wall time between two calls of ``meanwhile``
DIES_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux' prctl
ENDED = "its process ended"


class UserCodeError(RuntimeError):
    """Users' code raised something that is no error, as ``sys.exit()`` does; the message names it."""


class CallFailed(RuntimeError):
    """Users' code that is run apart raised; ``trace`` has its traceback, ``kind`` the error's type."""

    def __init__(self, kind, text, trace):
        super().__init__(text)
        self.kind, self.trace = kind, trace


class TimedOut(RuntimeError):
    """Users' code that is run apart did not end within its limit, and was given up."""


def call(function, *arguments, **named):
    """Return ``function(*arguments, **named)``, users' code; only an ``Exception`` leaves it.

    Raises what it raises; ``UserCodeError`` for what is no ``Exception``, such as ``SystemExit``, but
    for an interrupt from the keyboard.
    """
    try:
        return function(*arguments, **named)
    except (Exception, KeyboardInterrupt):
        raise
    except BaseException as error:
        text = "{}({})".format(type(error).__name__, error)
        raise UserCodeError("it tried to end the program: " + text) from error


def raised(error):
    """Return what users' code raised, of an ``error`` that left :func:`call`."""
    return error.__cause__ if isinstance(error, UserCodeError) else error


class Failure(NamedTuple):
    """What users' code raised, in words that pass between processes."""

    kind: str
    text: str
    trace: str


def _outcome(serve, request):
    """Return ``(True, value)`` of ``serve(*request)``, or ``(False, Failure)``."""
    try:
        return True, call(serve, *request)
    except (Exception, KeyboardInterrupt) as error:
        origin = raised(error)
        return False, Failure(type(origin).__name__, str(origin), traceback.format_exc())


class Worker:
    """Serves requests one after the other, apart; one that takes too long ends it."""

    def __init__(self, apart):
        """``apart``: what runs them: :class:`ProcessApart`, :class:`ThreadApart` or :class:`InPlace`."""
        self._apart, self._busy = apart, threading.Lock()
        self.given_up = False

    def ask(self, request, limit, meanwhile=None):
        """Return what the service makes of ``request``, a tuple; ``meanwhile()`` is called as it waits.

        Raises ``CallFailed``; ``TimedOut`` after ``limit`` [s] of wall time, and from then on.
        """
        end = time.monotonic() + limit
        if not self._busy.acquire(timeout=min(PATIENCE, limit)):
            raise TimedOut("it is still busy")
        try:
            if self.given_up:
                raise TimedOut("it was given up")
            self._apart.send(request)
            while not self._apart.ready(max(0.0, min(NAP, end - time.monotonic()))):
                if time.monotonic() >= end:
                    self.give_up()
                    raise TimedOut("no answer within {:g} s".format(limit))
                if meanwhile is not None:
                    meanwhile()
            done, value = self._apart.receive()
        except (EOFError, OSError):
            self.give_up()
            raise CallFailed("SystemExit", ENDED, ENDED) from None
        finally:
            self._busy.release()
        if not done:
            raise CallFailed(*value)
        return value

    @property
    def busy(self):
        """Return whether a request is under way."""
        return self._busy.locked()

    def give_up(self):
        """End it, whatever it is at; nobody waits for that."""
        self.given_up = True
        self._apart.end()


class ThreadApart:
    """Runs requests in a thread of this process, which cannot be ended, only left alone."""

    def __init__(self, service):
        """``service()``: returns the function that serves a request."""
        self._requests, self._answers = queue.Queue(), queue.Queue()
        self._answer = None
        threading.Thread(target=self._run, args=(service,), daemon=True).start()

    def _run(self, service):
        serve = service()
        for request in iter(self._requests.get, None):
            self._answers.put(_outcome(serve, request))

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

    def end(self):
        """Take no more requests."""
        self._requests.put(None)


class InPlace:
    """Runs requests where they are asked for: for laws that are known to end."""

    def __init__(self, service):
        """``service()``: returns the function that serves a request."""
        self._serve, self._answer = service(), None

    def send(self, request):
        """Serve ``request``."""
        self._answer = _outcome(self._serve, request)

    def ready(self, _):
        """Return whether the answer is there."""
        return True

    def receive(self):
        """Return the answer."""
        return self._answer

    def end(self):
        """Nothing is to be ended."""


class Nursery:
    """A process that was forked before there were threads, and forks others whenever asked.

    What is forked has all that the program had loaded, the user's classes too.
    """

    def __init__(self, service):
        """``service()``: returns, in a forked process, the function that serves a request there."""
        self._channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        if os.fork() == 0:
            self._channel.close()
            _guarded(_breed, theirs, service)
        theirs.close()

    def child(self):
        """Return the ``Connection`` to a new process that serves requests."""
        ours, theirs = multiprocessing.connection.Pipe()
        handle = array.array("i", [theirs.fileno()])
        self._channel.sendmsg([b"+"], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, handle)])
        theirs.close()
        return ours

    def close(self):
        """End it, and with it all that it has forked."""
        self._channel.close()


def _guarded(function, *arguments):
    """Run ``function`` in a forked process, which ends with it and with its parent."""
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)  # their parent sees to the end of both
        ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL)
        function(*arguments)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(0)


def _breed(channel, service):
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how they ended
    size = array.array("i").itemsize
    while True:
        data, received, _, _ = channel.recvmsg(1, socket.CMSG_SPACE(size))
        if not data:
            return
        handle = array.array("i", received[0][2][:size])[0]
        if os.fork() == 0:
            channel.close()
            _guarded(_serve, multiprocessing.connection.Connection(handle), service)
        os.close(handle)


def _serve(connection, service):
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    connection.send(os.getpid())
    serve = service()
    while True:
        try:
            request = connection.recv()
        except EOFError:
            return
        connection.send(_outcome(serve, request))


class ProcessApart:
    """Runs requests in a process of its own, which is killed when it is given up."""

    def __init__(self, nursery):
        """``nursery``: forks the process."""
        self._connection = nursery.child()
        self._process = self._connection.recv()

    def send(self, request):
        """Begin to serve ``request``."""
        self._connection.send(request)

    def ready(self, seconds):
        """Return whether the answer is there within ``seconds``."""
        return self._connection.poll(seconds)

    def receive(self):
        """Return the answer; ``EOFError`` if the process has ended."""
        return self._connection.recv()

    def end(self):
        """Kill the process."""
        if not self._connection.closed:
            # One that has ended has closed its end: its number may be another's by now.
            if not (self._connection.poll(0) and self._has_ended()):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(self._process, signal.SIGKILL)
            self._connection.close()

    def _has_ended(self):
        try:
            self._connection.recv()
        except (EOFError, OSError):
            return True
        return False
