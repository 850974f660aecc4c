"""Processes in which users' code is run for a :class:`~mrs_simulator.control.user_code.Worker`.

A node forks them, before it has threads, so that they have all that it had loaded; a GUI, whose threads
may hold any lock, starts fresh interpreters.
"""

import array
import contextlib
import ctypes
import faulthandler
import importlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection, Pipe

from mrs_simulator.control.user_code import PACKAGE, outcome

DIES_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux' prctl
CHILD, SPARE = b"+", b"*"  # requests to a fork server
READY = b"!"  # from a spare that can take over
SHOW = signal.SIGUSR1  # makes a worker write where it is
HANDLE, PLACES = 250, "/proc/{}/fd/{}"  # of the file to which it does
CALL = re.compile(r'  File "(.*)", line (\d+) in (.*)')
NAP = 0.005  # [s] of wall time between two looks whether it has
NOT_USERS = PACKAGE, os.path.dirname(os.__file__), "<"  # how files begin that are not users'
LOOK_PERIOD = 0.5  # [s] of wall time between two looks for the parent
# The directory that it is called from may hold a user's random.py.
PROGRAM = "import sys; del sys.path[0]; from {} import _begin; _begin(*sys.argv[1:])".format(
    __name__
)


class Piped:
    """A process at the other end of a pipe; ending it kills it and the processes that it started."""

    def __init__(self, connection, process):
        """``process``: its id, which is that of its group."""
        self._connection, self._process = connection, process
        self._ending = threading.Lock()  # one thread may give it up while another sees its end

    def send(self, request):
        """Begin to serve ``request``."""
        self._connection.send(request)

    def ready(self, seconds):
        """Return whether the answer is there within ``seconds``."""
        return self._connection.poll(seconds)

    def receive(self):
        """Return the answer; ``EOFError`` if the process has ended."""
        return self._connection.recv()

    def where(self, patience):
        """Return file, line and function of users' code that the process is in now.

        "" where that is not known within ``patience`` [s].
        """
        with contextlib.suppress(OSError, ValueError):
            os.kill(self._process, SHOW)
            end = time.monotonic() + patience
            while time.monotonic() < end:
                with open(PLACES.format(self._process, HANDLE), encoding="utf-8") as places:
                    found = [CALL.match(line) for line in places if line.endswith("\n")]
                place = named_place(match.groups() for match in found if match)
                if place:  # else other threads may stand first in what is only half written
                    return place
                time.sleep(NAP)
        return ""

    def _kill(self):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process, signal.SIGKILL)


class FreshProcess(Piped):
    """Runs requests in an interpreter of its own, which loads what it needs."""

    def __init__(self, module):
        """``module``: the name of one whose ``serve`` serves requests."""
        ours, theirs = Pipe()
        with theirs:
            handle = theirs.fileno()
            self._program = subprocess.Popen(
                [sys.executable, "-c", PROGRAM, str(handle), str(os.getpid()), module],
                pass_fds=[handle],
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )
        super().__init__(ours, self._program.pid)

    def end(self, grace=0.0):
        """Kill the process, if it does not end within ``grace`` [s]; return its exit code."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._program.wait(grace)
        with self._ending:
            if not self._connection.closed:
                self._kill()
                self._connection.close()
        return self._program.wait()


def _begin(handle, parent, module):
    """Serve requests that come through the pipe ``handle`` while the process ``parent`` lives."""
    threading.Thread(target=_end_with, args=(int(parent),), daemon=True).start()
    with Connection(int(handle)) as connection:
        _serve_all(connection, importlib.import_module(module).serve)


def _end_with(parent):
    while os.getppid() == parent:
        time.sleep(LOOK_PERIOD)
    os._exit(1)


def _show_places():
    """Write, on the signal ``SHOW``, where all threads are to a file that others find; on Linux.

    It needs neither the interpreter's lock nor the law's cooperation.
    """
    if hasattr(os, "memfd_create"):
        os.dup2(os.memfd_create("places"), HANDLE)
        faulthandler.register(SHOW, HANDLE, all_threads=True)


def named_place(calls):
    """Return file, line and function of the first of ``calls`` that is in users' code, "" for none.

    ``calls``: ``(file, line, function)``, the innermost first.
    """
    for path, line, function in calls:
        if not path.startswith(NOT_USERS) and "-packages" not in path:
            return "{}:{}, in {}".format(os.path.basename(path), line, function)
    return ""


def _serve_all(connection, serve):
    _show_places()
    # The other end may have closed meanwhile, with requests or answers on their way.
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            connection.send(outcome(serve, connection.recv()))


class ForkServer:
    """A process that was forked before there were threads, and forks workers on request.

    Workers have all that the program had loaded, the user's classes too.  A spare of the server takes its
    place should it be killed.
    """

    def __init__(self, service):
        """``service()``: returns, in a forked process, the function that serves a request there."""
        self._channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        if os.fork() == 0:
            self._channel.close()
            guarded(_serve_forks, theirs, service)
        theirs.close()
        self._spare = self._forked_spare()

    def child(self):
        """Return the ``Connection`` to a new process that serves requests.

        Raises ``OSError`` where it and its spare were killed.
        """
        ours, theirs = Pipe()
        with theirs:
            try:
                self._hand_over(CHILD, theirs)
            except OSError:
                self._channel.close()
                self._channel = self._spare
                self._hand_over(CHILD, theirs)
                self._spare = self._forked_spare()
        return ours

    def _forked_spare(self):
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        with theirs:
            self._hand_over(SPARE, theirs)
        ours.recv(len(READY))  # until it can take over; or nothing, as the server was killed
        return ours

    def _hand_over(self, wanted, end):
        handle = array.array("i", [end.fileno()])
        self._channel.sendmsg([wanted], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, handle)])

    def close(self):
        """End it and all that it has forked."""
        self._channel.close()
        self._spare.close()


def guarded(function, *arguments):
    """Run ``function`` in a forked process, which ends after it, or with its parent."""
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)  # their parent ends them
        ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL)
        function(*arguments)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(0)


def _serve_forks(channel, service):
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # no exit codes are collected
    size = array.array("i").itemsize
    while True:
        data, received, _, _ = channel.recvmsg(1, socket.CMSG_SPACE(size))
        if not data:
            return
        handle = array.array("i", received[0][2][:size])[0]
        if os.fork() == 0:
            channel.close()
            if data == SPARE:  # it outlives its parent, and ends with its channel
                ctypes.CDLL(None).prctl(DIES_WITH_PARENT, 0)
                channel = socket.socket(fileno=handle)
                channel.send(READY)
                continue
            guarded(_serve, Connection(handle), service)
        os.close(handle)


def _serve(connection, service):
    os.setsid()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    connection.send(os.getpid())
    _serve_all(connection, service())


class ForkedProcess(Piped):
    """Runs requests in a process that is forked for them."""

    def __init__(self, fork_server):
        """``fork_server``: forks the process."""
        connection = fork_server.child()
        super().__init__(connection, connection.recv())

    def end(self, _grace=0.0):
        """Kill the process; its exit code is not known."""
        with self._ending:
            if self._connection.closed:
                return
            # One that has ended has closed its end: its number may be another's by now.
            if not (self._connection.poll(0) and self._has_ended()):
                self._kill()
            self._connection.close()

    def _has_ended(self):
        try:
            self._connection.recv()
        except (EOFError, OSError):
            return True
        return False
