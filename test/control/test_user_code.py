"""Users' code is called in one way: whatever it raises, and however long it takes."""

import itertools
import os
import runpy
import signal
import subprocess
import sys
import threading
import time
from multiprocessing import Pipe
from types import SimpleNamespace

import numpy as np
import pytest
from ros_fixtures import wait_until

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.control import worker_process
from mrs_simulator.control.user_code import (
    CallFailed,
    InPlace,
    TimedOut,
    UserCodeError,
    Worker,
    WorkerThread,
    call,
)
from mrs_simulator.control.worker_process import ForkedProcess, ForkServer, FreshProcess
from mrs_simulator.core.graphs import Topology
from mrs_simulator.nodes.control.law_client import (
    Law,
    LawService,
    is_shipped,
    speaks_ros,
    where_to_run,
)
from mrs_simulator.protocols.loading import ProtocolError, load_protocol
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run.experiment import run_experiment

POSE = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 1.0]])
LONG = 60.0  # [s]


class Odd(PioneerControl):
    """Does what laws ought not to, by where its first robot stands."""

    def calculateControlLaw(self, pos_map):
        what = round(pos_map[1].x)
        if what == 1:
            sys.exit("enough")
        if what == 2:
            os._exit(3)
        if what == 3:
            sum(itertools.repeat(1, 10**12))  # which holds the interpreter's lock
        if what == 4:
            time.sleep(LONG)
        if what == 5:
            raise KeyError("five")
        return {number: make_twist(0.1 * number, self.time) for number in pos_map}

    def targets(self, hand):
        sys.exit("no targets")


HANGING = """
import time


def spin():
    while True:
        time.sleep(0.01)


def hold():
    sum(range(10**15))  # one call, in which no other thread runs
"""


def serve(request):
    if request == "pid":
        return os.getpid()
    if request == "hang":
        time.sleep(LONG)
    if request == "exit":
        sys.exit("enough")
    if request == "start":
        return subprocess.Popen(["sleep", str(LONG)]).pid
    if request == "end":
        os._exit(7)
    if "() of " in request:
        name, _, path = request.partition("() of ")
        runpy.run_path(path)[name]()
    return request


def apart(kind):
    """Return what runs ``serve``, and what is to be closed at the end."""
    if kind is ForkedProcess:
        fork_server = ForkServer(lambda: serve)
        return ForkedProcess(fork_server), fork_server.close
    if kind is FreshProcess:
        return FreshProcess(__name__), lambda: None
    return kind(lambda: serve), lambda: None


def is_gone(process):
    try:
        with open("/proc/{}/stat".format(process)) as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@pytest.fixture(autouse=True)
def found(monkeypatch):
    """Have processes find this module."""
    here = os.path.dirname(os.path.abspath(__file__))
    paths = [here, os.path.dirname(here), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", ":".join(paths))


def test_only_errors_leave_users_code():
    assert call(max, 1, 2) == 2
    with pytest.raises(KeyError):
        call({}.__getitem__, 1)
    with pytest.raises(UserCodeError, match=r"tried to end the program: SystemExit\(enough\)"):
        call(sys.exit, "enough")

    class Strange(BaseException):
        pass

    def raises(kind):
        raise kind

    with pytest.raises(UserCodeError, match="Strange"):
        call(raises, Strange)
    with pytest.raises(UserCodeError, match="KeyboardInterrupt"):  # nobody pressed a key
        call(raises, KeyboardInterrupt)


@pytest.mark.parametrize("kind", [ForkedProcess, FreshProcess, WorkerThread, InPlace])
def test_what_runs_apart_answers_and_its_errors_come_back(kind):
    runs, close = apart(kind)
    worker = Worker(runs)
    assert worker.ask(("hello",), LONG) == "hello"
    assert (worker.ask(("pid",), LONG) == os.getpid()) is (kind in (WorkerThread, InPlace))
    with pytest.raises(CallFailed, match="enough") as raised:
        worker.ask(("exit",), LONG)
    assert raised.value.kind == "SystemExit"
    assert "Traceback" in raised.value.trace and not worker.given_up
    assert "SystemExit(enough)\n" + __file__ in raised.value.said
    assert "in serve: sys.exit" in raised.value.said
    assert worker.ask(("again",), LONG) == "again"
    worker.give_up()
    close()


@pytest.mark.parametrize("kind", [ForkedProcess, FreshProcess])
def test_what_is_given_up_is_killed_with_all_that_it_has_started(kind):
    runs, close = apart(kind)
    worker = Worker(runs)
    started = worker.ask(("start",), LONG), worker.ask(("pid",), LONG)

    def give_up():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        worker.ask(("hang",), LONG, give_up)
    assert worker.given_up
    for process in started:
        wait_until(lambda process=process: is_gone(process))
    close()


class OnceClosed:
    """A connection that takes its time to close, and must be closed by one thread alone."""

    closed, closings = False, 0

    def close(self):
        self.closings += 1
        time.sleep(0.1)
        self.closed = True


def test_two_threads_may_end_a_process_at_once():
    process = FreshProcess("mrs_simulator.study.run.law_process")
    process._connection.close()
    process._connection = OnceClosed()
    threads = [threading.Thread(target=process.end) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert process._connection.closings == 1


@pytest.mark.parametrize("kind, said", [(ForkedProcess, "ended"), (FreshProcess, "exit code 7")])
def test_a_process_that_ends_is_reported(kind, said):
    runs, close = apart(kind)
    worker = Worker(runs)
    with pytest.raises(CallFailed, match=said):
        worker.ask(("end",), LONG)
    assert worker.given_up
    close()


@pytest.mark.parametrize("kind", [ForkedProcess, FreshProcess, WorkerThread])
def test_what_takes_too_long_is_given_up_while_others_go_on(kind):
    runs, close = apart(kind)
    worker, seen = Worker(runs), []
    process = worker.ask(("pid",), LONG)
    with pytest.raises(TimedOut, match=r"no answer within 0\.2 s"):
        worker.ask(("hang",), 0.2, lambda: seen.append(worker.busy))
    assert seen and all(seen) and worker.given_up
    with pytest.raises(TimedOut, match="given up"):
        worker.ask(("hello",), LONG)
    if kind is not WorkerThread:
        wait_until(lambda: is_gone(process))
    close()


@pytest.mark.parametrize("kind", [ForkedProcess, FreshProcess])
@pytest.mark.parametrize("how", ["spin", "hold"])
def test_where_users_code_hangs_is_told(kind, how, tmp_path):
    law = tmp_path / "law.py"
    law.write_text(HANGING)
    runs, close = apart(kind)
    worker = Worker(runs)
    worker.ask(("pid",), LONG)  # it has begun
    with pytest.raises(TimedOut, match=r"no answer within 1 s, it is at law\.py:\d+, in " + how):
        worker.ask(("{}() of {}".format(how, law),), 1.0)
    close()


def test_where_it_hangs_is_read_once_it_is_written_whole(monkeypatch, tmp_path):
    """Threads of the worker's own come first, and a line may be there in part."""
    places, own = tmp_path / "7-250", os.path.dirname(worker_process.__file__)
    whole = '  File "{}/a.py", line 3 in look\n\n  File "/home/me/law.py", line 7 in hold\n'.format(
        own
    )
    lengths = iter((0, whole.index("\n") + 1, len(whole) - 3, len(whole)))

    def go_on(_):
        places.write_text(whole[: next(lengths)])

    go_on(0.0)
    monkeypatch.setattr(worker_process, "PLACES", str(tmp_path / "{}-{}"))
    monkeypatch.setattr(worker_process.os, "kill", lambda *_: None)
    monkeypatch.setattr(worker_process, "time", SimpleNamespace(monotonic=lambda: 0.0, sleep=go_on))
    assert worker_process.Piped(None, 7).where(1.0) == "law.py:7, in hold"


def test_processes_end_with_the_program_that_has_them():
    code = (
        "import os, signal, time\n"
        "from mrs_simulator.control.worker_process import ForkServer, ForkedProcess\n"
        "def hang(_):\n    time.sleep(60.0)\n"
        "fork_server = ForkServer(lambda: hang)\n"
        "runs = ForkedProcess(fork_server)\n"
        "runs.send(('',))\n"
        "print(runs._process, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    program = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, timeout=LONG)
    assert program.returncode == -signal.SIGKILL
    wait_until(lambda: is_gone(int(program.stdout)))


@pytest.fixture
def law():
    """Return a law in a process of its own, whose commands may take half a second."""
    scenario = load_scenario(scenario_path("paper.yaml")).with_robots(2)
    scenario = scenario._replace(control=scenario.control._replace(parameters={}))
    fork_server = ForkServer(lambda: LawService(Odd))
    made = Law(scenario, Odd, LONG, where_to_run(Odd, fork_server))
    yield made
    made.end()
    fork_server.close()


def at(what):
    return POSE + np.array([[float(what), 0.0, 0.0], [0.0, 0.0, 0.0]])


def test_a_law_in_a_process_of_its_own_drives(law):
    assert law.begin(POSE) == [] and law.numbers == (1, 2) and not law.lost
    np.testing.assert_allclose(law.commands(POSE, 0.25, LONG), [[0.1, 0.25], [0.2, 0.25]])
    law.set_parameters({"l": 0.3})
    law.set_topology(Topology(2, [(1, 2, 1.0)], True))
    assert law.parameters == {"l": 0.3} and len(law.state.topology.edges) == 1
    with pytest.raises(ValueError, match="l = -1"):
        law.set_parameters({"l": -1.0})
    assert law.parameters == {"l": 0.3}


def test_an_edit_of_a_law_that_was_given_up_is_taken(law):
    with pytest.raises(TimedOut):
        law.commands(at(4), 0.0, 0.1)
    assert law.lost
    law.set_topology(Topology(2, [(1, 2, 1.0)], True))
    assert not law.lost and len(law.state.topology.edges) == 1
    law.end()
    law.set_parameters({"l": 0.3})
    assert law.parameters == {"l": 0.3} and len(law.state.topology.edges) == 1
    with pytest.raises(ValueError, match="l = -1"):
        law.set_parameters({"l": -1.0})


@pytest.mark.parametrize("what, said", [(1, "enough"), (2, "its process ended"), (5, "five")])
def test_what_a_law_raises_is_reported(law, what, said):
    with pytest.raises(CallFailed, match=said):
        law.commands(at(what), 0.0, LONG)
    assert law.lost is (what == 2)
    with pytest.raises((CallFailed, TimedOut), match=r"no targets|given up"):
        law.targets(POSE, LONG)


@pytest.mark.parametrize("what", [3, 4])
def test_a_law_that_hangs_is_given_up_and_made_again(law, what):
    law.set_parameters({"l": 0.3})
    with pytest.raises(TimedOut):
        law.commands(at(what), 0.0, 0.3)
    assert law.lost
    law.remake()
    assert not law.lost and law.parameters == {"l": 0.3}
    np.testing.assert_allclose(law.commands(POSE, 0.0, LONG), [[0.1, 0.0], [0.2, 0.0]])


def test_laws_that_use_ros_are_known(tmp_path):
    path = tmp_path / "own.py"
    path.write_text("from mrs_simulator import PioneerControl\nclass Own(PioneerControl): pass\n")
    assert not speaks_ros(load_protocol(str(path)))
    path = tmp_path / "with_ros.py"
    path.write_text(
        "import rospy\nfrom mrs_simulator import PioneerControl\nclass Own(PioneerControl): pass\n"
    )
    assert speaks_ros(load_protocol(str(path)))
    shipped = load_protocol("formation")
    assert is_shipped(shipped) and not speaks_ros(shipped) and not is_shipped(Odd)


@pytest.mark.parametrize("hook", ["claims", "measures", "prediction", "start"])
def test_a_law_that_exits_costs_a_run_no_more_than_its_part(tmp_path, hook):
    def exits(self, *_):
        sys.exit("no " + hook)

    kind = type("Exits", (load_protocol("consensus"),), {hook: exits})
    scenario = load_scenario(scenario_path("paper.yaml")).with_protocol("consensus")
    verdict = run_experiment(scenario.changed(duration=0.1), str(tmp_path), kind, formats=())
    assert not verdict["passed"]
    if hook == "start":
        assert "no start" in verdict["ended"]
    else:
        assert hook + "() returns" in [check["name"] for check in verdict["checks"]]


def test_a_law_that_exits_when_it_is_made_is_bad_input():
    def exits(self, *_, **__):
        sys.exit("not made")

    kind = type("Exits", (PioneerControl,), {"__init__": exits})
    scenario = load_scenario(scenario_path("paper.yaml"))
    with pytest.raises(ProtocolError, match="not made"):
        make_control(scenario, kind)


@pytest.mark.parametrize("requests", [1, 2])
def test_a_process_whose_asker_has_gone_ends_without_a_word(requests):
    asker, server = Pipe()
    for _ in range(requests):
        asker.send(("a",))
    asker.close()
    with server:
        worker_process._serve_all(server, str.upper)


def test_a_law_is_made_again_whichever_of_its_processes_was_killed():
    fork_server = ForkServer(lambda: lambda which: (os.getpid(), os.getppid())[which])
    for which in (1, 1, 1, 0):  # what has taken the place of the first has a spare, too
        worker = Worker(ForkedProcess(fork_server))
        process = worker.ask((which,), LONG)
        os.kill(process, signal.SIGKILL)
        wait_until(lambda process=process: is_gone(process))
        with pytest.raises(CallFailed, match="ended"):
            worker.ask((which,), LONG)
        assert worker.given_up
    process = Worker(ForkedProcess(fork_server)).ask((1,), LONG)
    fork_server.close()
    wait_until(lambda: is_gone(process))


def test_the_spare_of_a_fork_server_is_there_from_its_beginning(monkeypatch):
    forked, fork, handle = [], os.fork, signal.signal
    monkeypatch.setattr(os, "fork", lambda: forked.append(fork()) or forked[-1])

    def slowly(number, handler):
        time.sleep(0.1 if number == signal.SIGCHLD else 0.0)
        return handle(number, handler)

    monkeypatch.setattr(worker_process.signal, "signal", slowly)
    fork_server = ForkServer(lambda: lambda: 7)
    os.kill(forked[0], signal.SIGKILL)
    wait_until(lambda: is_gone(forked[0]))
    assert Worker(ForkedProcess(fork_server)).ask((), LONG) == 7
    fork_server.close()


def test_a_law_whose_processes_are_all_gone_says_what_to_do(law):
    def gone():
        raise BrokenPipeError(32, "Broken pipe")

    law.end()
    law._apart = gone
    with pytest.raises(ValueError, match="processes that run laws were killed .* start it anew"):
        law.remake()
    assert law.lost
