"""The control node over ROS: it drives, it stops, and it says why."""

import os
import re
import signal

import pytest
import rospy
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator.control.user_code import CallFailed
from mrs_simulator.nodes.control import reconfigure
from mrs_simulator.nodes.control.node import ControlNode
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FORWARD = """
from mrs_simulator import PioneerControl, make_twist, run

class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.3, 0.0) for i in pos_map}

if __name__ == "__main__":
    run(Forward)
"""
BROKEN = """
from mrs_simulator import PioneerControl, make_twist

class Raises(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: 1.0 / 0.0 for i in pos_map}

class Nan(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(float("nan"), 0.0) for i in pos_map}

class TooFew(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return [make_twist(0.3, 0.0)]

class TurnsNan(PioneerControl):
    calls = 0
    def calculateControlLaw(self, pos_map):
        self.calls += 1
        return {i: make_twist(0.3 if self.calls < 50 else float("nan"), 0.0) for i in pos_map}
"""

HANGING = """
import os, time
from mrs_simulator import PioneerControl, make_twist

class Hangs(PioneerControl):
    def calculateControlLaw(self, pos_map):
        while os.path.exists({0!r} + "/hang"):
            open({0!r} + "/hangs", "w").close()
            time.sleep(0.01)
        return {{i: make_twist(0.3, 0.0) for i in pos_map}}
"""


HOLDING = """
import itertools, os, time
from mrs_simulator import PioneerControl, make_twist

class Holds(PioneerControl):
    def calculateControlLaw(self, pos_map):
        if os.path.exists({0!r} + "/hang"):
            open({0!r} + "/hangs", "w").close()
            sum(itertools.repeat(1, 10**13))  # holds the interpreter's lock
        return {{i: make_twist(0.3, 0.0) for i in pos_map}}

    def targets(self, hand):
        raise SystemExit("no targets")
"""


@pytest.fixture
def law(tmp_path):
    """Write a file of laws; return its path."""

    def write(text):
        path = tmp_path / "my_law.py"
        path.write_text(text)
        return str(path)

    return write


def moving(probe, n):
    """Wait until n robots move."""
    probe.wait("len(state('vx') or []) == {} and min(map(abs, state('vx'))) > 0.05".format(n))


def at_rest(probe):
    """Wait until every robot stands; return the simulated time of that state [s]."""
    return probe.wait("max(map(abs, state('vx') + state('omega'))) == 0.0 and stamp()")


@pytest.mark.parametrize("ends", [False, True])
def test_a_law_that_is_ended_with_its_node_has_not_failed(monkeypatch, ends):
    logged, node = [], ControlNode.__new__(ControlNode)
    node._stop = logged.append
    monkeypatch.setattr(rospy, "is_shutdown", lambda: ends)
    monkeypatch.setattr(rospy, "logerr", lambda text, *given: logged.append(text % given))
    node._lose(CallFailed("EOFError", "", "its process ended", "its process ended"))
    assert ["failed" in text for text in logged] == ([] if ends else [True, True])


def test_the_shipped_law_drives_and_stops_by_service(ros):
    ros.node("stage", "--robots", 3)
    control = ros.node("pioneer_control", "--robots", 3)
    probe = ros.probe()
    probe.wait("max(map(abs, state('vx') or [0])) > 0.1")
    assert probe.wait("control('protocol')") == "Formation"
    assert probe.ask("call('/pioneer_control/stop', Trigger)")[0] is True
    at_rest(probe)
    probe.wait("control('trouble') == 'stopped by request'")
    assert probe.ask("call('/pioneer_control/start', Trigger)")[0] is True
    probe.wait("max(map(abs, state('vx'))) > 0.1")
    wait_until(lambda: "Formation for 3 robots, a command every 0.02 s" in log_of(control))


def test_the_emergency_stop_holds_until_it_is_released(ros):
    ros.node("stage", "--robots", 3)
    ros.node("pioneer_control", "--robots", 3)
    probe = ros.probe()
    probe.wait("max(map(abs, state('vx') or [0])) > 0.1")
    probe.ask("press(True)")
    at_rest(probe)
    probe.wait("control('trouble') == 'emergency stop'")
    assert probe.ask("call('/pioneer_control/start', Trigger)")[0] is False
    # Released, the robots still stand until they are told to go on.
    probe.ask("press(False)")
    probe.wait("control('trouble').startswith('the emergency stop was released, then call')")
    assert not probe.ask("control('running')")
    start = "call('/pioneer_control/start', Trigger)"
    assert probe.ask(start) == [True, "running"]
    probe.wait("max(map(abs, state('vx'))) > 0.1 and control('trouble') == ''")
    assert probe.ask(start) == [True, "running already"]


def test_a_law_runs_as_a_script_of_its_own(ros, law):
    ros.node("stage", "--robots", 2)
    ros.start("control", ["python3", law(FORWARD), "--robots", "2"])
    moving(ros.probe(), 2)


def test_the_readmes_protocol_is_short_and_runs(ros, law):
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        code = file.read().partition("```python\n")[2].partition("```")[0]
    assert len(code.splitlines()) <= 15
    ros.node("stage", "--robots", 3)
    ros.start("control", ["python3", law(code), "--robots", "3"])
    moving(ros.probe(), 3)


def test_a_law_is_named_by_its_file(ros, law):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2, "_protocol:=" + law(FORWARD) + ":Forward")
    moving(ros.probe(), 2)


def test_autostart_can_wait_for_the_service(ros, law):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2, "--protocol", law(FORWARD), "_autostart:=false")
    probe = ros.probe()
    probe.wait("control('trouble') == 'not started'")
    probe.wait_simulated(0.5)
    assert probe.ask("max(map(abs, state('vx')))") == 0.0
    probe.ask("call('/pioneer_control/start', Trigger)")
    moving(probe, 2)


def test_a_broken_law_never_moves_a_robot(ros, law):
    ros.node("stage", "--robots", 2)
    probe = ros.probe()
    for name, said in (
        ("Raises", "ZeroDivisionError"),
        ("Nan", "the law gave robot 1 v = nan"),
        ("TooFew", "returned list of 1, wanted 2 Twists"),
    ):
        protocol = law(BROKEN) + ":" + name
        control = ros.node("pioneer_control", "--robots", 2, "--protocol", protocol, name=name)
        probe.wait("{!r} in (control('trouble') or '')".format(said))
        assert "the law failed" in probe.ask("control('trouble')")
        wait_until(lambda c=control, s=said: s in log_of(c) and "Traceback" in log_of(c))
        probe.wait_simulated(0.5)
        assert probe.ask("[state('x')[0], max(map(abs, state('vx') + state('omega')))]") == [
            pytest.approx(9.95, abs=1e-12),
            0.0,
        ]
        assert control.poll() is None
        control.kill()
        control.wait(PATIENCE)


def test_a_law_that_breaks_on_the_way_stops_the_robots(ros, law):
    ros.node("stage", "--robots", 2)
    probe = ros.probe()  # before the law begins: it breaks after a second
    control = ros.node("pioneer_control", "--robots", 2, "--protocol", law(BROKEN) + ":TurnsNan")
    moving(probe, 2)
    probe.wait("'the law failed' in (control('trouble') or '')")
    probe.wait("status_stamp() >= {!r}".format(at_rest(probe)))
    assert probe.ask("status('refused')") == [0, 0]  # it was not the stage that stopped them
    assert control.poll() is None


@pytest.fixture
def hung(ros, law, tmp_path):
    return hang(ros, law, tmp_path)


def hang(ros, law, tmp_path, *arguments):
    """Return control node and probe of a team that moves while its law hangs until a file is gone."""
    ros.node("stage", "--robots", 2, "_cmd_vel_timeout:=1000")
    text = HANGING.format(str(tmp_path))
    control = ros.node("pioneer_control", "--robots", 2, "--protocol", law(text), *arguments)
    probe = ros.probe()
    moving(probe, 2)
    (tmp_path / "hang").touch()
    wait_until((tmp_path / "hangs").exists)
    return control, probe


def test_an_emergency_stop_waits_for_no_law(hung, tmp_path):
    control, probe = hung
    probe.ask("press(True)")
    at_rest(probe)
    (tmp_path / "hang").unlink()
    probe.wait("control('trouble') == 'emergency stop'")
    assert not probe.ask("control('running')")
    wait_until(lambda: "emergency stop" in log_of(control))
    at_rest(probe)


def test_the_nodes_last_zeros_wait_for_no_law(hung, tmp_path):
    control, probe = hung
    control.send_signal(signal.SIGINT)
    at_rest(probe)
    (tmp_path / "hang").unlink()
    assert control.wait(PATIENCE) is not None
    assert probe.ask("max(map(abs, state('vx') + state('omega')))") == 0.0


@pytest.mark.parametrize("limit", [1, 1000])
def test_real_robots_stop_when_their_law_hangs(ros, law, tmp_path, limit):
    """The law is given up after its limit; where that is long, the robots stop all the same."""
    patient = ("_autostart:=true", "_odom_timeout:=1000", "_stuck_time:=0", "_resume:=true")
    patient += ("_law_limit:={}".format(limit),)
    control, probe = hang(ros, law, tmp_path, "_real:=1,2", *patient)
    at_rest(probe)
    (tmp_path / "hang").unlink()
    probe.wait("'took too long' in (control('trouble') or '')")
    assert not probe.ask("control('running')")
    wait_until(lambda: "took too long" in log_of(control))
    at_rest(probe)
    probe.wait("call('/pioneer_control/start', Trigger)[0]")
    moving(probe, 2)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_robots_stop_when_the_node_ends(ros, law, number):
    ros.node("stage", "--robots", 2, "_cmd_vel_timeout:=1000")
    control = ros.node("pioneer_control", "--robots", 2, "--protocol", law(FORWARD))
    probe = ros.probe()
    moving(probe, 2)
    control.send_signal(number)
    at_rest(probe)  # by its last zeros: the watchdog is not due for 1000 s
    assert control.wait(PATIENCE) is not None


def test_killing_the_control_node_stops_every_robot_within_the_watchdogs_time(ros, law):
    stage = ros.node("stage", "--robots", 3)
    control = ros.node("pioneer_control", "--robots", 3, "--protocol", law(FORWARD))
    probe = ros.probe()
    moving(probe, 3)
    # Slowly: the latency of this test's own looks is then short in simulated time.
    assert probe.ask("call('/stage/set_speed', SetSpeed, 0.25)")[0]
    probe.wait("status('speed') == 0.25")
    control.kill()
    killed = probe.ask("now()")
    stopped = at_rest(probe)
    # The bound is the watchdog's 0.6 s of simulated time, and that latency.
    assert stopped - killed < 0.6 + 0.5
    probe.wait("status('timed_out') == [1, 2, 3]")
    wait_until(lambda: "robot1, robot2, robot3 stopped: no command for 0.6 s" in log_of(stage))


def test_killing_the_stage_stops_the_commands(ros, law):
    stage = ros.node("stage", "--robots", 2)
    ahead = FORWARD.replace("0.3", "0.3 if self.time >= 0.0 else -0.3")
    control = ros.node("pioneer_control", "--robots", 2, "--protocol", law(ahead))
    probe = ros.probe()
    probe.ask("listen('/robot1/cmd_vel', Twist)")
    probe.wait("(sent(1) or [0])[0] > 0.1")
    moving(probe, 2)
    stage.kill()
    probe.wait("sent(1) == [0.0, 0.0]")
    seen = probe.ask("counts['/robot1/cmd_vel']")
    why = "robots stopped: .*(is silent|no fresh odometry of robot1)"
    wait_until(lambda: re.search(why, log_of(control)))
    assert probe.ask("counts['/robot1/cmd_vel']") <= seen + 1
    # A stage started again is driven again from the law's time zero, as its clock begins anew.
    stage.wait(PATIENCE)
    ros.node("stage", "--robots", 2, name="again")
    probe.wait("sent(1)[0] > 0.1")


def test_missing_odometry_is_named(ros, law):
    ros.node("stage", "--robots", 2)
    control = ros.node("pioneer_control", "--robots", 3, "--protocol", law(FORWARD))
    probe = ros.probe()
    probe.wait("'no fresh odometry of robot3 (never received)' in (control('trouble') or '')")
    assert probe.ask("control('stale')") == [3]
    probe.wait_simulated(0.5)
    assert probe.ask("max(map(abs, state('vx')))") == 0.0
    # What is missing is logged every five seconds; before it may be the clock.
    wait_until(lambda: "robot3" in log_of(control))


def test_parameters_change_while_running(ros):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2)
    code = """
import rospy
from dynamic_reconfigure.client import Client
rospy.init_node("changes")
client = Client("pioneer_control", timeout=60)
print(sorted(k for k in client.get_configuration() if k != "groups"))
print(client.update_configuration({"k": 0.05, "closure": "cycle"})["k"])
print(client.update_configuration({"k": 0.0})["k"])
answer = client.update_configuration({"c": 1.5})
print(answer["c"], answer["closure"])
"""
    said = ros.python(code).splitlines()
    assert said == ["['T', 'c', 'closure', 'k', 'l']", "0.05", "0.05", "1.5 cycle"]


def test_the_topology_is_replaced_while_running(ros):
    ros.node("stage", "--robots", 3)
    ros.node("pioneer_control", "--robots", 3)
    probe = ros.probe()
    assert probe.wait("control('heard')") == [2, 3]
    call = "call('/pioneer_control/set_topology', SetTopology, {}, {}, [], False)"
    assert probe.ask(call.format([1, 1], [2, 3])) == [True, "2 edges"]
    probe.wait("control('hears') == [1, 1] and control('directed') is False")
    probe.wait("len(control('target_x')) == 3")
    for hears, heard, said in (
        ([1], [1], "no neighbour of its own"),
        ([1], [4], "from 1 to 3"),
        ([1], [], "as many"),
    ):
        done, message = probe.ask(call.format(hears, heard))
        assert not done and said in message
    code = "import rospy; from dynamic_reconfigure.client import Client; rospy.init_node('c'); "
    code += "print(Client('pioneer_control', timeout=60).get_configuration()['closure'])"
    assert ros.python(code).strip() == "topology"


def test_edges_and_parameters_may_change_at_the_same_time(ros):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2)
    code = """
import threading, rospy
from dynamic_reconfigure.client import Client
from mrs_simulator.srv import SetTopology
rospy.init_node("changes", disable_rostime=True)
client = Client("pioneer_control", timeout=60)
edges = rospy.ServiceProxy("/pioneer_control/set_topology", SetTopology)
thread = threading.Thread(target=lambda: [edges([1], [2], [], False) for _ in range(20)])
thread.start()
for k in range(1, 21):
    client.update_configuration({"k": 0.01 * k})
thread.join()
print(client.update_configuration({})["k"])  # what is in force; the client's own copy comes later
"""
    assert ros.python(code).strip() == "0.2"
    assert ros.probe().wait("control('hears') == [1]")


def test_the_warning_is_given(ros):
    scenario = os.path.join(ROOT, "scenarios", "paper_literal.yaml")
    ros.node("stage", "--scenario", scenario)
    control = ros.node("pioneer_control", "--scenario", scenario)
    assert "may spin for ever" in wait_until(lambda: "spin" in log_of(control) and log_of(control))


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["--protocol", "formatoin"], "did you mean 'formation'"),
        (["--protocol", "nowhere.py:Law"], "nowhere.py"),
        (["--scenario", "nowhere.yaml"], "nowhere.yaml"),
        (["_rate:=0"], "rate = 0: wanted a number from 0.1 to 1000"),
        (["_odom_timeout:=soon"], "odom_timeout = 'soon'"),
    ],
)
def test_bad_arguments_are_said(ros, arguments, said):
    control = ros.node("pioneer_control", *arguments)
    assert control.wait(PATIENCE) == 2
    assert said in log_of(control) and "Traceback" not in log_of(control)


def test_a_law_that_holds_the_interpreter_is_given_up_and_started_again(ros, law, tmp_path):
    ros.node("stage", "--robots", 2, "_cmd_vel_timeout:=1000")
    path = law(HOLDING.format(str(tmp_path)))
    control = ros.node("pioneer_control", "--robots", 2, "--protocol", path, "_law_limit:=3")
    probe = ros.probe()
    moving(probe, 2)
    wait_until(lambda: "targets: SystemExit: no targets" in log_of(control))
    (tmp_path / "hang").touch()
    wait_until((tmp_path / "hangs").exists)
    # Its status tells of it before it is given up.
    probe.wait("'the law has not answered for' in control('trouble')")
    probe.wait("'took too long' in control('trouble')")
    assert probe.ask("'it is at ' in control('trouble')")  # file, line and function
    at_rest(probe)
    assert probe.ask("call('/pioneer_control/stop', Trigger)")[0]
    (tmp_path / "hang").unlink()
    assert probe.ask("call('/pioneer_control/start', Trigger)")[0]
    moving(probe, 2)
    control.send_signal(signal.SIGINT)
    assert control.wait(PATIENCE) is not None


def test_a_stop_waits_for_no_law_and_is_published_at_once(hung, tmp_path):
    _, probe = hung
    assert probe.ask("call('/pioneer_control/stop', Trigger)")[0]
    at_rest(probe)
    probe.wait("control('trouble') == 'stopped by request' and not control('running')")
    assert (tmp_path / "hang").exists()
    (tmp_path / "hang").unlink()
    assert probe.ask("call('/pioneer_control/start', Trigger)")[0]
    moving(probe, 2)


@pytest.fixture
def parameter_server(monkeypatch):
    """The parameters of a ROS master, a dictionary."""
    kept = {}
    missing = object()

    def get_param(name, default=missing):
        return kept[name] if default is missing else kept.get(name, default)

    monkeypatch.setattr(rospy, "get_param", get_param)
    monkeypatch.setattr(rospy, "set_param", kept.__setitem__)
    monkeypatch.setattr(rospy, "delete_param", kept.__delitem__)
    monkeypatch.setattr(rospy, "has_param", kept.__contains__)
    return kept


def served(**parameters):
    """Return a server for the parameters of the law of carrying.yaml, without its topics."""
    server = reconfigure.TellingServer.__new__(reconfigure.TellingServer)
    scenario = load_scenario(scenario_path("carrying.yaml"))
    control = scenario.control._replace(parameters={**scenario.control.parameters, **parameters})
    law = make_control(scenario._replace(control=control))
    server.ns, server.type = "~", reconfigure._config_type(law)
    server.config = dict(server.type.defaults)
    server._copy_from_parameter_server()
    server._copy_to_parameter_server()
    return server


def test_parameters_of_the_node_are_not_taken_for_the_laws(parameter_server):
    """The launch file sets the node a ``speed`` of the simulation, many laws have one of their own."""
    parameter_server.update({"~speed": "", "~gain": 0.7})
    server = served()
    assert (server.config["speed"], server.config["gain"]) == (0.25, 0.7)
    assert parameter_server["~speed"] == "" and parameter_server["~coupling"] == 0.3


def test_a_controller_does_not_take_the_parameters_that_one_before_wrote(parameter_server):
    served(gain=0.7)  # and it is killed
    assert served(gain=0.6).config["gain"] == parameter_server["~gain"] == 0.6
    parameter_server["~gain"] = 0.9  # by a user
    killed = served(gain=0.6)
    assert killed.config["gain"] == 0.9
    killed.config["gain"] = 0.2  # by rqt_reconfigure
    killed._copy_to_parameter_server()
    ended = served(gain=0.5)  # what was given stays, what was tried while it ran does not
    assert ended.config["gain"] == 0.9
    killed.withdraw()  # it ended late, and takes nothing away from the other
    assert parameter_server["~coupling"] == 0.3
    ended.withdraw()
    assert parameter_server == {"~gain": 0.9}
