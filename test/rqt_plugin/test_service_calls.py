"""What the GUI asks for in the background: a server that hangs blocks no other."""

import os
import signal
import sys
import threading
import time
from unittest.mock import MagicMock

import pytest
import rospy
from ros_fixtures import PATIENCE, wait_until

from mrs_simulator.rqt_plugin.ros_side import service_calls
from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
from mrs_simulator.rqt_plugin.ros_side.service_calls import CONTROLLER, STAGE, ServiceCalls
from mrs_simulator.rqt_plugin.run.processes import Processes


@pytest.fixture
def hung():
    """Return work that goes on until the test ends."""
    end = threading.Event()
    yield lambda: (end.wait(), "late")
    end.set()


def taken_until(asked, name):
    """Return the results up to that called ``name``."""
    taken = []

    def come():
        taken.extend(asked.take_results())
        return name in [result[0] for result in taken]

    wait_until(come)
    return taken


def test_a_hung_controller_keeps_neither_the_stage_nor_its_own_stop_waiting(hung):
    asked = ServiceCalls()
    asked.put(CONTROLLER, "start", hung)
    asked.put(STAGE, "pause", lambda: (True, "paused"))
    assert taken_until(asked, "pause")[-1] == ("pause", True, "paused")
    asked.put(CONTROLLER, "stop", lambda: (True, "stopped"))
    assert taken_until(asked, "stop")[-1] == ("stop", True, "stopped")


def test_requests_to_one_server_keep_their_order():
    asked, done = ServiceCalls(), []
    for name in ("reset", "pause", "set_team"):
        asked.put(STAGE, name, lambda name=name: (done.append(name) is None, ""))
    taken_until(asked, "set_team")
    assert done == ["reset", "pause", "set_team"]


def test_a_run_begins_before_a_controller_is_started_and_after_robots_were_put_back(monkeypatch):
    done, answer = [], MagicMock(success=True)
    monkeypatch.setattr(service_calls.rospy, "wait_for_service", lambda *_: None)
    proxy = lambda service, _: lambda: done.append(service) or answer  # noqa: E731
    monkeypatch.setattr(service_calls.rospy, "ServiceProxy", proxy)
    connection = RosConnection.__new__(RosConnection)
    connection._calls, connection.begin_run = ServiceCalls(), lambda: done.append("run")
    for name in ("reset", "start"):
        connection.ask(name)
        taken_until(connection._calls, name)
    assert done == ["stage/reset", "run", "run", "pioneer_control/start"]


def test_an_answer_that_is_missing_is_said_once(hung, monkeypatch):
    monkeypatch.setattr(service_calls, "SLOW", 0.05)
    asked = ServiceCalls()
    asked.put(CONTROLLER, "start", hung)
    reported = taken_until(asked, "slow")
    assert reported == [("slow", True, "start: the controller has not answered yet")]
    asked.put(STAGE, "pause", lambda: (True, ""))
    assert [name for name, _, _ in taken_until(asked, "pause")] == ["pause"]


def test_nothing_is_done_after_the_close(monkeypatch):
    asked, goes_on, done = ServiceCalls(), threading.Event(), []
    asked.put(CONTROLLER, "parameters", lambda: (goes_on.wait(), ""))
    asked.put(CONTROLLER, "start", lambda: (done.append("start") is None, ""))
    asked.close(time.monotonic() + 0.2)
    goes_on.set()
    for line in asked._queues.values():
        line.thread.join()
    assert done == []  # no robot starts later


def test_what_does_not_hang_is_done_before_the_close():
    asked, done = ServiceCalls(), []
    for name in ("reset", "pause"):
        asked.put(STAGE, name, lambda name=name: (done.append(name) is None, ""))
    asked.close(time.monotonic() + PATIENCE)
    assert done == ["reset", "pause"]


PROGRAM = """#!{}
import os, signal, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
print("ready", flush=True)
while not os.path.exists("{}"):
    time.sleep(0.01)
"""


def test_the_close_of_programs_does_not_wait_for_one_that_takes_its_time(monkeypatch, tmp_path):
    rosrun, may_end = tmp_path / "rosrun", tmp_path / "may_end"
    rosrun.write_text(PROGRAM.format(sys.executable, may_end))
    rosrun.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(
        "mrs_simulator.rqt_plugin.run.processes.ENDINGS", ((signal.SIGINT, PATIENCE),)
    )
    processes = Processes()
    processes.start("stage", "stage")
    program = processes.running["stage"]
    wait_until(lambda: "ready" in processes.output("stage"))
    processes.close()
    assert program.poll() is None  # a thread waits for it, not the GUI
    may_end.write_text("")
    processes.wait_closed()
    assert program.poll() == 0 and not os.path.exists(processes.directory)


@pytest.mark.parametrize(
    "raised, said",
    [
        (
            rospy.ROSException("timeout exceeded while waiting for service /pioneer_control/x"),
            "not there",
        ),
        (rospy.ServiceException("unable to connect to service: [Errno 111]"), "ended before"),
    ],
)
def test_a_server_that_is_gone_is_named_as_in_the_window(monkeypatch, raised, said):
    monkeypatch.setattr(rospy, "wait_for_service", MagicMock(side_effect=raised))
    asked = ServiceCalls()
    asked.ask("set_topology", ())
    success, answer = taken_until(asked, "set_topology")[-1][1:]
    assert not success and answer.startswith("the controller ") and said in answer
