"""A ROS master of the test's own, and nodes that end with it."""

import contextlib
import functools
import glob
import json
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

import pytest
from forked import Forked, forker

PATIENCE = 60.0  # [s] with a machine that has much else to do
STOP_LIMIT = 30.0  # [s], likewise
MOST_PRINTED = 2000  # characters of each process's log beside a failure
COMMANDS_OF_ROS = (
    "rosmaster",
    "rosmsg",
    "rosparam",
    "rosservice",
    "rossrv",
    "rostopic",
)  # in Python
QUICK_ROSRUN = """#!/bin/sh
[ "$1" = mrs_simulator ] || exec {rosrun} "$@"
program={place}$2
shift 2
exec "$program" "$@"
"""


def free_port():
    """Return a port of this host that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def heed_interrupts():
    """In a child: take SIGINT as at a terminal, though the tests run as a background job."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def wait_until(condition, limit=PATIENCE, nap=0.02):
    """Return the condition's first true value; fail the test after ``limit`` [s]."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(nap)
    pytest.fail("not within {:g} s: {}".format(limit, getattr(condition, "__name__", condition)))


def start_logged(command, log, environment, **given):
    """Start a process whose output goes to the file ``log``; ``given``: what ``Popen`` takes."""
    with open(log, "ab") as file:
        streams = dict(stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT)
        process = subprocess.Popen(
            command, env=environment, preexec_fn=heed_interrupts, **dict(streams, **given)
        )
    process.log = log
    return process


@functools.lru_cache(maxsize=None)
def program(script):
    """Return the path of a program of the package: the one that ``rosrun`` would search for each time."""
    find = ["catkin_find", "--first-only", "--without-underlays", "--libexec", "mrs_simulator"]
    found = subprocess.run(find, stdout=subprocess.PIPE, check=True, timeout=PATIENCE)
    return os.path.join(found.stdout.decode().strip(), script)


@functools.lru_cache(maxsize=None)
def log_settings():
    """Return the path of the settings that each program of ROS would search all packages for."""
    import rospkg  # not for the tests without ROS

    return os.path.join(rospkg.RosPack().get_path("rosgraph"), "conf", "python_logging.conf")


def python_script(command, directory):
    """Return the script and the arguments of a ``command`` that is Python's, else None.

    Code of ``-c`` is written to ``directory``.  rosrun, and roslaunch but to tell parameters, are None:
    they start processes.
    """
    first, *arguments = command
    if first in COMMANDS_OF_ROS or command[:2] == ("roslaunch", "--dump-params"):
        return [shutil.which(first), *arguments]
    if first not in ("python3", sys.executable):
        return None
    if arguments[0] != "-c":
        return arguments
    with tempfile.NamedTemporaryFile("w", suffix=".py", dir=directory, delete=False) as file:
        file.write(arguments[1])
    return [file.name, *arguments[2:]]


class Ros:
    """A master on a free port and the processes started under it.

    ``paths``: of directories in which nodes find modules before all others.
    """

    def __init__(self, directory):
        self.directory = directory
        self.processes, self._launches, self.paths = [], [], []
        self.uri = "http://127.0.0.1:{}".format(free_port())
        self.environment = dict(
            os.environ,
            ROS_MASTER_URI=self.uri,
            ROS_HOSTNAME="127.0.0.1",
            ROS_LOG_DIR=directory,
            PYTHONUNBUFFERED="1",
            ROS_PYTHON_LOG_CONFIG_FILE=log_settings(),
        )
        self.environment.pop("ROS_IP", None)
        port = self.uri.rpartition(":")[2]
        self.master = self._forked("master", shutil.which("rosmaster"), "--core", "-p", port)
        wait_until(self._master_answers)
        xmlrpc.client.ServerProxy(self.uri).setParam("/test", "/use_sim_time", True)

    def _master_answers(self):
        with contextlib.suppress(OSError):
            return xmlrpc.client.ServerProxy(self.uri).getPid("/test")[0] == 1
        return False

    def start(self, name, command, directory=None, loaded=()):
        """Start a process of the test's own; its output goes to a file.

        Python is forked; ``loaded``: names of modules that are loaded before, once for all such forks.
        """
        script = python_script(command, self.directory)
        if script is not None:
            return self._forked(name, *script, directory=directory, loaded=loaded)
        return self._started(name, command, directory)

    def launch(self, *arguments):
        """Start ``roslaunch``, with its nodes of Python as forks."""
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "forked_launch.py")
        if forker().can_run(self.environment):
            process = self._forked("launch", script, *arguments, loaded=["roslaunch"])
        else:
            process = self._started("launch", ["roslaunch", *arguments], None)
        self._launches.append(process)
        return process

    def _started(self, name, command, directory, errors=None):
        log = os.path.join(self.directory, name + ".log")
        path = os.pathsep.join([*self.paths, self.environment.get("PYTHONPATH", "")])
        environment = dict(self.environment, **{"PYTHONPATH": path} if self.paths else {})
        with contextlib.ExitStack() as stack:
            given = {} if errors is None else {"stderr": stack.enter_context(open(errors, "ab"))}
            process = start_logged(command, log, environment, cwd=directory, **given)
        self.processes.append(process)
        return process

    def printed(self):
        """Return the ends of the logs of all processes, as sections of a test's report."""
        sections = []
        for path in sorted(glob.glob(os.path.join(self.directory, "*.log"))):
            with open(path, encoding="utf-8", errors="replace") as file:
                sections.append((os.path.basename(path), file.read()[-MOST_PRINTED:]))
        return sections

    def node(self, script, *arguments, name=None):
        """Start a node of the package, as rosrun would."""
        return self._forked(name or script, program(script), *map(str, arguments))

    def _forked(self, name, script, *arguments, directory=None, loaded=(), errors=None):
        """Start a ``script`` of Python, where it can be as a fork of what is loaded already.

        ``errors``: the file of its standard error, where that is not to be in the log.
        """
        if not forker().can_run(self.environment):
            return self._started(name, [sys.executable, script, *arguments], directory, errors)
        log = os.path.join(self.directory, name + ".log")
        places = log, errors or log, directory
        given = dict(loaded=loaded, paths=self.paths)
        process = forker().start(script, arguments, self.environment, *places, **given)
        process.log = log
        self.processes.append(process)
        return process

    def use_quick_rosrun(self):
        """Let ``rosrun`` start programs of the package without its search, which costs as much as they."""
        path = os.path.join(tempfile.mkdtemp(dir=self.directory), "rosrun")
        with open(path, "w") as file:
            file.write(QUICK_ROSRUN.format(rosrun=shutil.which("rosrun"), place=program("")))
        os.chmod(path, 0o755)
        self.environment["FORKED_PROGRAMS"] = program("")
        self.environment["PATH"] = os.path.dirname(path) + os.pathsep + self.environment["PATH"]

    def probe(self):
        """Start a :class:`Probe`."""
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ros_probe.py")
        if forker().can_run(self.environment):
            process = forker().start_piped(script, self.environment)
        else:
            process = subprocess.Popen(
                [sys.executable, script],
                env=self.environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                preexec_fn=heed_interrupts,
            )
        self.processes.append(process)
        return Probe(process)

    def wait_for_connections(self, subscriber, topics, limit=PATIENCE):
        """Wait until publishers are connected to a node whose name begins so, on all of ``topics``."""
        master = xmlrpc.client.ServerProxy(self.uri)

        def is_connected():
            published = dict(master.getSystemState("/test")[2][0])
            connected = set()
            for node in set().union(*map(published.get, topics & published.keys())):
                with xmlrpc.client.ServerProxy(master.lookupNode("/test", node)[2]) as publisher:
                    links = publisher.getBusInfo("/test")[2]
                connected |= {link[4] for link in links if str(link[1]).startswith(subscriber)}
            return topics <= connected

        wait_until(is_connected, limit)

    def call(self, *arguments, limit=PATIENCE):
        """Run a ROS command to its end; return its output."""
        script = python_script(arguments, self.directory)
        if script is None:
            return subprocess.run(
                arguments, env=self.environment, timeout=limit, check=True, stdout=subprocess.PIPE
            ).stdout.decode()
        out = tempfile.mkdtemp(dir=self.directory)
        names = (os.path.join(out, name) for name in ("out", "errors"))
        loaded = ["roslaunch"] * (arguments[0] == "roslaunch")
        process = self._forked(next(names), *script, errors=next(names), loaded=loaded)
        code = process.wait(limit)
        if code != 0:
            raise subprocess.CalledProcessError(code, arguments, log_of(process))
        return log_of(process)

    def python(self, code, *arguments, limit=PATIENCE):
        """Run a piece of Python as a ROS program; return its output."""
        return self.call(sys.executable, "-c", code, *map(str, arguments), limit=limit)

    def judged(self, record, out, limit=PATIENCE):
        """Return the verdict that the node ``record`` wrote to ``out``; its figures are not waited for."""
        path = os.path.join(str(out), "verdict.json")
        wait_until(lambda: os.path.exists(path) or record.poll() is not None, limit)
        assert os.path.exists(path), log_of(record)
        record.kill()
        record.wait(STOP_LIMIT)
        with open(path, encoding="utf-8") as file:
            return json.load(file)

    def stop(self, process):
        """End a process: politely first, then for certain."""
        self._stop_all([process])

    @staticmethod
    def _stop_all(processes):
        running = [process for process in processes if process.poll() is None]
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            try:
                process.wait(STOP_LIMIT)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(STOP_LIMIT)

    def close(self):
        """End everything, the master last; forks, but for launches, have nothing to keep nor to end."""
        others = [process for process in self.processes if process is not self.master]
        forked = [
            each for each in others if isinstance(each, Forked) and each not in self._launches
        ]
        for process in forked:
            process.kill()
        for process in forked:
            process.wait(STOP_LIMIT)
        self._stop_all(others)
        self.master.kill()
        self.master.wait(STOP_LIMIT)


class Probe:
    """A listening node in a process of its own; ``ask`` gets the value of an expression there."""

    def __init__(self, process):
        self._process = process
        assert self._line() == "ready\n"

    def _line(self, limit=PATIENCE):
        ready, _, _ = select.select([self._process.stdout], [], [], limit)
        assert ready, "the probe did not answer within {:g} s".format(limit)
        return self._process.stdout.readline().decode()

    def _answer(self, expression):
        self._process.stdin.write(expression.encode() + b"\n")
        self._process.stdin.flush()
        return json.loads(self._line())

    def ask(self, expression):
        """Return the expression's value, made of plain values."""
        answer = self._answer(expression)
        assert "error" not in answer, "{}: {}".format(expression, answer["error"])
        return answer["value"]

    def wait(self, expression, limit=PATIENCE):
        """Return the expression's first true value; fail the test after ``limit`` [s].

        An expression that raises is not true yet: each topic begins when it does, in no order.
        """

        def value():
            answer = self._answer(expression)
            value.__name__ = ": ".join(filter(None, (expression, answer.get("error"))))
            return answer.get("value")

        return wait_until(value, limit)

    def wait_simulated(self, seconds, limit=PATIENCE):
        """Wait until simulated time has gone on by ``seconds``, and the stage's state was heard."""
        self.wait("state('x') is not None")
        begin = self.wait("now()")
        self.wait("now() >= {!r}".format(begin + seconds), limit)


def log_of(process):
    """Return what a process has printed so far."""
    with open(process.log, encoding="utf-8", errors="replace") as file:
        return file.read()


@pytest.fixture
def ros():
    """A :class:`Ros` that ends with the test."""
    with tempfile.TemporaryDirectory(prefix="mrs_simulator_test_") as directory:
        running = Ros(directory)
        try:
            yield running
        finally:
            running.close()
