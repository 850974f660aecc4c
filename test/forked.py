"""Starts rosmaster and nodes as forks of a process that has loaded what they import.

Loading it anew costs each process half a second of processor time, more than most tests take otherwise.
The programs run as they stand; tests of ``rosrun``, and one of a launch file, start them from nothing.
Programs and laws of windows without ROS are forks of another process, which loads nothing of ROS.
"""

import atexit
import contextlib
import fcntl
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
import tempfile
import threading
import time
import types

LOADED = (
    "logging.config",
    "rosmaster",
    "rospy",
    "mrs_simulator.nodes.control.program",
    "mrs_simulator.nodes.record.node",
    "mrs_simulator.nodes.stage.node",
    "mrs_simulator.study.draw.figures",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_pdf",
    "sensor_msgs.msg",
    "tf2_msgs.msg",
    "visualization_msgs.msg",
)
LOADED_WITHOUT_ROS = (
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_pdf",
    "matplotlib.backends.backend_svg",
    "mrs_simulator.__main__",
    "mrs_simulator.rqt_plugin.local_side.engine",
    "mrs_simulator.study.results.figure_command",
    "mrs_simulator.study.results.report",
    "mrs_simulator.study.run.law_answers",
)
MODULES_OF_ROS = (
    "rospy",
    "rosgraph",
    "rosgraph_msgs",
    "std_msgs",
    "std_srvs",
    "geometry_msgs",
    "mrs_simulator.msg",
    "mrs_simulator.srv",
)
READ_WHEN_LOADED = ("LD_", "MKL_", "MPL", "MRS_", "OMP_", "OPENBLAS_", "PYTHON")
PARENT = "MRS_SIMULATOR_PARENT"
READY = b"!"
WITHOUT_ROS = "without ROS"
HIGH = 300  # [-] above the numbers of files that a process is to have
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

    def __init__(self, *options):
        """``options``: ``WITHOUT_ROS``, or none."""
        self._options = options
        self._socket, other = socket.socketpair()
        self._environment = dict(os.environ, PYTHONUNBUFFERED="1")
        self._asking = threading.Lock()
        with other:
            self._begin(other)
        self._socket.settimeout(LIMIT)
        self._answers = self._socket.makefile("r")

    def _begin(self, other):
        number = other.fileno()
        command = [sys.executable, os.path.abspath(__file__), str(number), *self._options]
        self._process = subprocess.Popen(command, env=self._environment, pass_fds=(number,))
        self.pid = self._process.pid
        atexit.register(self.close)

    def can_run(self, environment):
        """Return whether what is loaded is what a process with ``environment`` would load."""
        names = {*environment, *self._environment} - {PARENT}
        told = (name for name in names if name.startswith(READ_WHEN_LOADED))
        return all(environment.get(name) == self._environment.get(name) for name in told)

    def start(self, script, arguments, environment, log, errors, directory=None, **given):
        """Run a ``script`` of Python; its output goes to the files ``log`` and ``errors``.

        ``loaded``: names of further modules that are loaded before, once for all such processes;
        ``paths``: of directories that it finds modules in before all others;
        ``leads``: whether it leads a group of processes of its own.
        """
        with open(os.devnull) as nothing, open(log, "ab") as file, open(errors, "ab") as other:
            streams = nothing.fileno(), file.fileno(), other.fileno()
            return self._start([script, *arguments], environment, streams, directory, **given)

    def start_piped(self, script, environment, *arguments):
        """Run a ``script`` of Python with pipes to its input and from its output."""
        (stdin, to), (of, stdout) = os.pipe(), os.pipe()
        process = self._start([script, *arguments], environment, (stdin, stdout, 2))
        os.close(stdin)
        os.close(stdout)
        process.stdin, process.stdout = os.fdopen(to, "wb"), os.fdopen(of, "rb")
        return process

    def popen(
        self,
        command,
        stdin=None,
        stdout=None,
        stderr=None,
        env=None,
        pass_fds=(),
        start_new_session=False,
        cwd=None,
    ):
        """Do what ``subprocess.Popen`` does; what is Python, and loaded here, is forked.

        The process that forks is then its parent, also where the command or ``env`` say who that is.
        """
        environment = dict(os.environ if env is None else env)
        if command[0] != sys.executable or not self.can_run(environment):
            given = dict(stdin=stdin, stdout=stdout, stderr=stderr, pass_fds=pass_fds, cwd=cwd)
            return subprocess.Popen(command, env=env, start_new_session=start_new_session, **given)
        parents = {str(os.getpid()): str(self.pid)}
        args = [parents.get(each, each) for each in command[1:]]
        if PARENT in environment:
            environment[PARENT] = str(self.pid)
        with open(os.devnull) as nothing:
            out = 1 if stdout is None else stdout.fileno()
            streams = [nothing.fileno(), out, 2 if stderr is None else out, *pass_fds]
            numbers = [0, 1, 2, *pass_fds]
            given = dict(leads=start_new_session, numbers=numbers)
            return self._start(args, environment, streams, cwd, **given)

    def _start(
        self,
        args,
        environment,
        streams,
        directory=None,
        loaded=(),
        leads=False,
        numbers=(0, 1, 2),
        paths=(),
    ):
        given = dict(args=args, environment=environment, directory=directory or os.getcwd())
        given.update(loaded=list(loaded), leads=leads, numbers=list(numbers), paths=list(paths))
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


@functools.lru_cache(maxsize=None)
def forker_without_ros():
    """Return the ``Forker`` of this process that loads nothing of ROS, started at the first call."""
    return Forker(WITHOUT_ROS)


def forking_subprocess(forks):
    """Return what stands for the module ``subprocess`` where the ``Forker`` ``forks`` starts processes."""
    return types.SimpleNamespace(**dict(vars(subprocess), Popen=forks.popen))


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
                count = len(request["numbers"])
                request["streams"] = multiprocessing.reduction.recvfds(link, count)
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
    streams = [fcntl.fcntl(each, fcntl.F_DUPFD, HIGH) for each in request["streams"]]
    for stream in request["streams"]:
        os.close(stream)
    for number, stream in zip(request["numbers"], streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.argv[:] = request["args"]  # the list that defaults of arguments know
    sys.path[0] = "" if sys.argv[0] in ("-m", "-c") else os.path.dirname(sys.argv[0])
    sys.path[1:1] = request["paths"]
    atexit.unregister(shutil.rmtree)  # of what the others go on using
    random.seed()
    tempfile.tempdir = None  # it may be another in this environment
    if sys.modules["rospy"]:
        names = sys.modules["rospy"].names
        # Which rospy does when it is loaded.
        names.reload_mappings(sys.argv)
        names._set_caller_id(names.get_ros_namespace(argv=sys.argv) + "unnamed")


def run_main():
    """Run the script, the module after ``-m`` or the code after ``-c`` that ``sys.argv`` begins with."""
    if sys.argv[0] == "-m":
        del sys.argv[0]
        sys.path[0] = os.getcwd()
        for module in (sys.argv[0], sys.argv[0] + ".__main__"):
            sys.modules.pop(module, None)  # it runs under another name
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    elif sys.argv[0] == "-c":
        code = compile(sys.argv.pop(1), "<string>", "exec")
        sys.modules["__main__"] = main = types.ModuleType("__main__")
        exec(code, main.__dict__)
    else:
        runpy.run_path(sys.argv[0], run_name="__main__")


def run():
    """Run a program to its end and end this process, as the interpreter does.

    But what was loaded is not taken down, for which all of it would be copied from the process that forked.
    """
    code = 1
    try:
        run_main()
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
        run()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends with the tests
    if WITHOUT_ROS in sys.argv:
        sys.modules.update(dict.fromkeys(MODULES_OF_ROS))
        load(LOADED_WITHOUT_ROS)
    else:
        load(LOADED)
        # Also of programs that are not the package's: a core busy while each ends.
        sys.modules["mrs_simulator.ros.node.lifecycle"].hasten_rospy()
    sys.modules["mrs_simulator.vehicles.registry"].shipped_kind("pioneer3dx")  # most tests' robots
    fork_for(socket.socket(fileno=int(sys.argv[1])))
