"""Starts rosmaster and nodes as forks of a process that has loaded what they import.

Loading it anew costs each process half a second of processor time, more than most tests take otherwise.
The programs run as they stand; tests of launch files and of ``rosrun`` start them from nothing.
"""

import atexit
import contextlib
import functools
import gc
import importlib
import json
import multiprocessing.reduction
import os
import random
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

LOADED = (
    "logging.config",
    "rosmaster",
    "rospy",
    "mrs_simulator.nodes.control.program",
    "mrs_simulator.nodes.record.node",
    "mrs_simulator.nodes.stage.node",
    "sensor_msgs.msg",
    "tf2_msgs.msg",
    "visualization_msgs.msg",
)
READ_WHEN_LOADED = ("LD_", "MKL_", "MPL", "MRS_", "OMP_", "OPENBLAS_", "PYTHON")
READY = b"!"
NAP, LONGEST_NAP = 0.005, 0.05  # [s] each next one is longer by half
LIMIT = 60.0  # [s]


class Forked:
    """A process that was forked, with what tests use of ``subprocess.Popen``."""

    def __init__(self, ask, pid, args):
        self._ask, self.pid, self.args, self.returncode = ask, pid, args, None
        self.stdin = self.stdout = None

    def poll(self):
        """Return its exit code, None while it runs."""
        if self.returncode is None:
            self.returncode = self._ask({"poll": self.pid})
        return self.returncode

    def wait(self, timeout=None):
        """Return its exit code; ``TimeoutExpired`` after ``timeout`` [s]."""
        end = None if timeout is None else time.monotonic() + timeout
        nap = NAP
        while self.poll() is None:
            if end is not None and time.monotonic() > end:
                raise subprocess.TimeoutExpired(self.args, timeout)
            time.sleep(nap)
            nap = min(1.5 * nap, LONGEST_NAP)
        return self.returncode

    def send_signal(self, number):
        """Send it a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self):
        """End it politely."""
        self.send_signal(signal.SIGTERM)

    def kill(self):
        """End it for certain."""
        self.send_signal(signal.SIGKILL)


class Forker:
    """The process that forks."""

    def __init__(self):
        self._socket, other = socket.socketpair()
        self._environment = dict(os.environ, PYTHONUNBUFFERED="1")
        self._asking = threading.Lock()
        with other:
            self._begin(other)
        self._socket.settimeout(LIMIT)
        self._answers = self._socket.makefile("r")

    def _begin(self, other):
        number = other.fileno()
        command = [sys.executable, os.path.abspath(__file__), str(number)]
        self._process = subprocess.Popen(command, env=self._environment, pass_fds=(number,))
        atexit.register(self.close)

    def can_run(self, environment):
        """Return whether what is loaded is what a process with ``environment`` would load."""
        names = {*environment, *self._environment}
        told = (name for name in names if name.startswith(READ_WHEN_LOADED))
        return all(environment.get(name) == self._environment.get(name) for name in told)

    def start(self, script, arguments, environment, log, errors, directory=None, **given):
        """Run a ``script`` of Python; its output goes to the files ``log`` and ``errors``.

        ``loaded``: names of further modules that are loaded before, once for all such processes;
        ``leads``: whether it leads a group of processes of its own.
        """
        with open(os.devnull) as nothing, open(log, "ab") as file, open(errors, "ab") as other:
            streams = nothing.fileno(), file.fileno(), other.fileno()
            return self._start(script, arguments, environment, streams, directory, **given)

    def start_piped(self, script, environment):
        """Run a ``script`` of Python with pipes to its input and from its output."""
        (stdin, to), (of, stdout) = os.pipe(), os.pipe()
        process = self._start(script, (), environment, (stdin, stdout, 2))
        os.close(stdin)
        os.close(stdout)
        process.stdin, process.stdout = os.fdopen(to, "wb"), os.fdopen(of, "rb")
        return process

    def _start(
        self, script, arguments, environment, streams, directory=None, loaded=(), leads=False
    ):
        args = [script, *arguments]
        given = dict(args=args, environment=environment, directory=directory or os.getcwd())
        given.update(loaded=list(loaded), leads=leads)
        return Forked(self._ask, self._ask(given, streams), args)

    def _ask(self, request, streams=()):
        with self._asking:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
            if streams:
                assert self._socket.recv(1) == READY
                multiprocessing.reduction.sendfds(self._socket, streams)
            return json.loads(self._answers.readline())

    def close(self):
        """End it, when all that it started has ended."""
        self._answers.close()
        self._socket.close()
        self._process.wait(LIMIT)


class OwnForker(Forker):
    """A fork of this process, with what is loaded here, that forks; it ends with this process.

    To be made before there are threads.  ``pid``: the parent of what it starts.
    """

    def _begin(self, other):
        self.pid = os.fork()
        if self.pid == 0:
            self._socket.close()
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            fork_for(other)
            os._exit(0)


@functools.lru_cache(maxsize=None)
def forker():
    """Return the ``Forker`` of this process, started at the first call."""
    return Forker()


def load(modules):
    """Import what is not yet loaded of the ``modules``."""
    new = [module for module in modules if module not in sys.modules]
    for module in new:
        importlib.import_module(module)
    if new:
        gc.freeze()


def serve(link):
    """Fork for each request on the socket ``link``; return in the child its request."""
    children = {}
    with link, link.makefile("r") as requests:
        for line in requests:
            request = json.loads(line)
            if "poll" in request:
                answer = children[request["poll"]] = _exit_code(children, request["poll"])
            else:
                link.sendall(READY)
                request["streams"] = multiprocessing.reduction.recvfds(link, 3)
                load(request["loaded"])
                answer = os.fork()
                if answer == 0:
                    return request
                if request["leads"]:
                    os.setpgid(answer, answer)
                for number in request["streams"]:
                    os.close(number)
                children[answer] = None
            link.sendall(json.dumps(answer).encode() + b"\n")
    return None


def _exit_code(children, pid):
    if children[pid] is not None:
        return children[pid]
    ended, status = os.waitpid(pid, os.WNOHANG)
    if not ended:
        return None
    return -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def become(request):
    """Let this process look as if the interpreter had been started with the script of ``request``."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.clear()
    os.environ.update(request["environment"])
    os.chdir(request["directory"])
    for number, stream in enumerate(request["streams"]):
        os.dup2(stream, number)
        os.close(stream)
    sys.argv[:] = request["args"]  # the list that defaults of arguments know
    sys.path[0] = os.path.dirname(sys.argv[0])
    atexit.unregister(shutil.rmtree)  # of what the others go on using
    random.seed()
    names = sys.modules["rospy"].names
    # Which rospy does when it is loaded.
    names.reload_mappings(sys.argv)
    names._set_caller_id(names.get_ros_namespace(argv=sys.argv) + "unnamed")


def run(script):
    """Run a ``script`` to its end and end this process, as the interpreter does.

    But what was loaded is not taken down, for which all of it would be copied from the process that forked.
    """
    code = 1
    try:
        runpy.run_path(script, run_name="__main__")
        code = 0
    except SystemExit as error:
        code = error.code or 0
        if not isinstance(code, int):
            print(code, file=sys.stderr)
            code = 1
    except KeyboardInterrupt:  # of which the process dies
        raise
    except BaseException:
        sys.excepthook(*sys.exc_info())
    threading._shutdown()
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)


def fork_for(link):
    """Fork for each request on the socket ``link``, and run in each child what it asks for."""
    with contextlib.closing(link):
        child = serve(link)
    if child is not None:
        become(child)
        run(sys.argv[0])


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends with the tests
    load(LOADED)
    # Also of programs that are not the package's: a core busy while each ends.
    sys.modules["mrs_simulator.ros.node.lifecycle"].end_servers_with_sockets()
    sys.modules["mrs_simulator.vehicles.registry"].shipped_kind("pioneer3dx")  # most tests' robots
    fork_for(socket.socket(fileno=int(sys.argv[1])))
