"""Fixtures that all tests share, and the choice of the quick ones and of one room's."""

import gc
import glob
import os
import resource
import shutil
import signal
import sys
import tempfile

# Before numpy is loaded: workers and processes share the cores, and each one's second thread would spin.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import pytest
from gui_fixtures import app, forked_programs, gui, no_hidden_errors, no_predictions  # noqa: F401
from old_rospy import rospy_fails_by_itself, stand_aside
from ros_fixtures import ros  # noqa: F401

# A test with one of these fixtures starts a ROS master or a GUI's process.
PROCESSES = {"ros", "gui", "hosts"}
HERE = os.path.dirname(os.path.abspath(__file__))
FOLDERS = sorted(
    {
        os.path.basename(os.path.dirname(path))
        for path in glob.glob(os.path.join(HERE, "*", "test_*.py"))
    }
)
# Tests of one folder share helpers with those of others.
sys.path[:0] = [os.path.join(HERE, folder) for folder in FOLDERS]
SLOW_LIST = os.path.join(HERE, "slow_tests.txt")
OLD_ROSPY = rospy_fails_by_itself()
SLOW = 0.12  # [s] of processor time from which on a test is slow
# Tests start hundreds of processes: let them find their modules compiled, whatever is set here.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# Windows keep settings, runs and unsaved edits below HOME: neither the user's, nor those of tests beside.
CACHE = os.path.join(os.path.expanduser("~"), ".cache", "matplotlib")
os.environ.setdefault("MPLCONFIGDIR", CACHE)  # to read all fonts anew takes seconds
for variable in ("XDG_DATA_HOME", "XDG_CACHE_HOME"):
    os.environ.pop(variable, None)
OWN_HOME = os.environ["HOME"] = tempfile.mkdtemp(prefix="mrs_simulator_home_")
os.environ["PYTHONPYCACHEPREFIX"] = os.path.join(os.path.dirname(HERE), "build", "pycache")
# Nor is pytest to rewrite their assertions each time, where this process runs them itself.
sys.dont_write_bytecode, sys.pycache_prefix = False, os.environ["PYTHONPYCACHEPREFIX"]


@pytest.fixture
def interruptible():
    """Let an interrupt raise ``KeyboardInterrupt``, whatever programs that ran in this process left."""
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, handler)


def pytest_addoption(parser):
    """Add ``--all``, ``--fast``, ``--processes``, ``--room`` and ``--list-slow``."""
    parser.addoption("--all", action="store_true", help="also what is run before a release")
    parser.addoption("--fast", action="store_true", help="only quick tests that start no ROS")
    parser.addoption(
        "--processes", choices=("only", "without"), help="only tests that start ROS, or all others"
    )
    parser.addoption("--room", choices=FOLDERS, help="only the tests in this folder")
    parser.addoption(
        "--list-slow", metavar="FILE", help="append the functions of slow tests to FILE"
    )


def pytest_configure(config):
    """Compile only what tests ask for.

    Before a release runs compile what users' runs compile, which takes minutes where nothing is kept yet.
    """
    if not config.getoption("--all"):
        os.environ.setdefault("MRS_SIMULATOR_COMPILED", "0")


def pytest_unconfigure():
    """Remove the directory of settings."""
    shutil.rmtree(OWN_HOME, ignore_errors=True)


@pytest.hookimpl(hookwrapper=True)
def pytest_collection():
    """Keep the garbage collector away from what is collected here, and stays to the end."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(config, items):
    """Keep the tests that ``--all``, ``--fast``, ``--processes`` and ``--room`` ask for."""
    options = "--all", "--fast", "--processes", "--room"
    everything, fast, processes, room = map(config.getoption, options)
    with open(SLOW_LIST, encoding="utf-8") as file:
        slow = {line.strip() for line in file}
    kept, left = [], []
    for item in items:
        starts = bool(PROCESSES.intersection(item.fixturenames))
        starts = starts or item.get_closest_marker("processes") is not None
        wanted = not (fast and (starts or _function(item) in slow))
        wanted = wanted and (processes is None or starts == (processes == "only"))
        wanted = wanted and (not room or _folder(item) == room)
        wanted = wanted and (everything or item.get_closest_marker("release") is None)
        (kept if wanted else left).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = kept


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """With ``--list-slow``, note the test's function if the test was slow."""
    begun = _processor_time()
    yield
    path = item.config.getoption("--list-slow")
    if path and _processor_time() - begun > SLOW:
        with open(path, "a", encoding="utf-8") as file:
            file.write(_function(item) + "\n")


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item):
    """Let failures that are rospy's own stand aside; show with others what the processes printed."""
    outcome = yield
    report = outcome.get_result()
    if OLD_ROSPY:
        stand_aside(report, item)
    if report.failed and "ros" in getattr(item, "funcargs", ()):
        report.sections += item.funcargs["ros"].printed()


def _folder(item):
    """Return the folder below this one that holds a test."""
    return os.path.relpath(str(item.path), HERE).split(os.sep)[0]


def _function(item):
    """Return ``file.py::function`` of a test, without the values of its parameters."""
    return "{}::{}".format(os.path.relpath(str(item.path), HERE), item.originalname)


def _processor_time():
    """Return the processor time [s] of this process and of the children that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)
