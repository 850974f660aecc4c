"""The stage over ROS: topics, frames, clock, services, watchdogs, any number of robots."""

import contextlib
import math
import socket
import xmlrpc.client
from types import SimpleNamespace

import numpy as np
import pytest
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator.core import compiling
from mrs_simulator.core.pacing import Pacer
from mrs_simulator.nodes.stage.stage import Stage
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.world.world import EVERY, World


def start(ros, *arguments, name="stage"):
    """Start a stage and a probe that has seen its clock."""
    stage = ros.node("stage", *arguments, name=name)
    probe = ros.probe()
    probe.wait("now()")
    return stage, probe


def test_a_single_robot_has_its_namespace_frames_and_true_odometry(ros):
    _, probe = start(ros, "--robots", 1, "_speed:=5")
    probe.ask("listen('/robot1/odom', Odometry)")
    probe.ask("drive([1], 0.3, 0.2)")
    odom = probe.wait("(odom(1) or {}).get('twist', [0])[0] > 0.25 and odom(1)")
    assert (odom["frame"], odom["child"]) == ("robot1/odom", "robot1/base_link")
    assert odom["twist"] == pytest.approx([0.3, 0.0, 0.2], abs=0.06)
    assert odom["covariance"][0] > 0.0 and odom["covariance"][14] > 1e3
    assert odom["stamp"] % 20000000 == 0  # whole steps of 20 ms
    probe.wait("'robot1/base_link' in transforms and 'robot1/odom' in transforms")
    links = [
        probe.ask(
            "[transforms[f'robot1/{x}'].header.frame_id, transforms[f'robot1/{x}'].child_frame_id]".replace(
                "{x}", child
            )
        )
        for child in ("odom", "base_link")
    ]
    assert links == [["world", "robot1/odom"], ["robot1/odom", "robot1/base_link"]]


def test_odometry_tells_how_far_its_declared_errors_have_grown(ros, tmp_path):
    scenario = tmp_path / "errors.yaml"
    errors = "odometry: wheel\nodometry_errors: {alpha: [0.01, 0, 0, 0, 0, 0.01], Eb: 1.05}\n"
    scenario.write_text("poses: [[0, 0, 0.5]]\nlimits: none\nduration: 1000\n" + errors)
    _, probe = start(ros, "--scenario", scenario, "_speed:=2")
    probe.ask("listen('/robot1/odom', Odometry)")
    known = probe.wait("(odom(1) or {}).get('covariance')")
    assert [known[k] for k in (0, 7, 35)] == pytest.approx([1e-6] * 3, abs=1e-12)
    probe.ask("drive([1], 0.5, 0.0)")
    probe.wait("odom(1)['pose'][0] > 1.0")
    probe.ask("drive([1], 0.0, 0.0)")
    probe.wait("odom(1)['twist'][0] == 0.0")
    odom = probe.ask("odom(1)")
    # Of x alone, 0.01 0.5^2 T = 0.01 0.5 x; turns have not begun.
    known = odom["covariance"]
    assert known[0] == pytest.approx(0.005 * odom["pose"][0], rel=0.05)
    assert known[14] == 1e6 and known[35] == pytest.approx(1e-6, abs=1e-12)
    probe.ask("drive([1], 0.0, 0.5)")
    odom = probe.wait("odom(1)['pose'][2] > 0.2 and odom(1)")
    turned = 2.0 * math.asin(odom["pose"][2])
    # It truly turns at 0.5/1.05 rad/s: 0.01 (0.5/1.05)^2 T, T = turned/0.5.
    grown = 0.004535 * turned + (0.05 * turned) ** 2
    assert odom["covariance"][35] == pytest.approx(grown, rel=0.1)
    probe.ask("call('/stage/reset', Trigger)")
    probe.wait("max(odom(1)['covariance'][:2]) < 1e-5")


def test_frame_names_are_parameters_and_wheel_odometry_starts_at_zero(ros):
    arguments = ["--robots", 1, "--odometry", "wheel", "_world_frame:=/map"]
    _, probe = start(ros, *arguments, "_odom_frame:=odom_{}", "_base_frame:=base_{}")
    probe.ask("listen('/robot1/odom', Odometry)")
    odom = probe.wait("odom(1)")
    assert (odom["frame"], odom["child"]) == ("odom_1", "base_1")
    assert odom["pose"] == [0.0, 0.0, 0.0]
    probe.wait("'odom_1' in transforms")
    assert probe.ask("transforms['odom_1'].header.frame_id") == "map"
    origin = probe.ask("transforms['odom_1'].transform.translation.x")
    assert origin == pytest.approx(9.95)  # where the scenario puts the first robot


@pytest.mark.parametrize("n", [1, pytest.param(7, marks=pytest.mark.release), 100])
def test_any_number_spawns_and_drives(ros, n):
    # The test's commands to 100 robots may be late on a busy machine; who was early may collide.
    _, probe = start(ros, "--robots", n, "_speed:=2", "_cmd_vel_timeout:=1000")
    probe.wait("state('robot') == list(range(1, {} + 1))".format(n))
    x, y = probe.ask("[state('x'), state('y')]")
    probe.ask("drive(range(1, {} + 1), 0.2, 0.0)".format(n))
    moved = "min(map(math.dist, zip(state('x'), state('y')), {}))"
    probe.wait("state('x') and {} > 0.05".format(moved.format(list(zip(x, y)))))


def test_the_dynamic_stage_drives(ros):
    _, probe = start(ros, "--robots", 2, "--fidelity", "dynamic", "_speed:=2")
    probe.ask("drive([1, 2], 0.2, 0.0)")
    probe.wait("min(state('vx') or [0]) > 0.15")
    assert probe.wait("status('fidelity')") == "dynamic"


def test_silence_stops_each_robot_by_its_own_clock(ros):
    stage, probe = start(ros, "--robots", 2)
    probe.ask("drive([1, 2], 0.3, 0.0)")
    probe.wait("min(state('vx') or [0]) > 0.2")
    probe.ask("driven.pop(1) and None")
    probe.wait("status('timed_out') == [1]")
    probe.wait("state('vx')[0] == 0.0 and state('vx')[1] > 0.2")
    wait_until(lambda: "robot1 stopped: no command for 0.6 s" in log_of(stage))


def test_commands_that_are_not_finite_are_refused_counted_and_said(ros):
    stage, probe = start(ros, "--robots", 2)
    probe.ask("drive([1], float('nan'), 0.0) and drive([2], 0.0, float('inf'))")
    probe.wait("min(status('refused') or [0]) >= 3")
    assert probe.wait("state('x') and [state('x')[0], state('vx'), state('omega')]") == [
        pytest.approx(9.95),
        [0.0, 0.0],
        [0.0, 0.0],
    ]
    wait_until(lambda: "refused commands for robot1, robot2: not finite" in log_of(stage))


def test_pause_step_reset_and_speed(ros):
    _, probe = start(ros, "--robots", 2)
    probe.ask("drive([1, 2], 0.3, 0.0)")
    probe.wait("min(state('vx') or [0]) > 0.1")
    assert probe.ask("call('/stage/step', StepStage, 5)")[0] is False
    assert probe.ask("call('/stage/pause', SetBool, True)") == [True, "paused"]
    # While paused the time stands and the clock keeps coming.
    then = probe.wait("status('paused') and clock_repeats > 2 and now()")
    seen = probe.ask("counts['clock']")
    probe.wait("counts['clock'] > {} + 5".format(seen))
    assert probe.ask("now()") == then
    assert probe.ask("call('/stage/step', StepStage, 5)")[0] is True
    probe.wait("abs(now() - {!r} - 0.1) < 1e-6".format(then))
    assert probe.ask("call('/stage/step', StepStage, 0)")[0] is False
    # Reset: robots back at once, time goes on.
    probe.ask("release()")
    assert probe.ask("call('/stage/reset', Trigger)")[0] is True
    assert probe.wait(
        "now() > {!r} + 0.1 and state('vx') == [0.0, 0.0] and state('x')".format(then)
    )[0] == pytest.approx(9.95)
    assert probe.ask("call('/stage/set_speed', SetSpeed, 0.1)") == [True, "speed 0.1"]
    assert probe.ask("call('/stage/set_speed', SetSpeed, -1.0)")[0] is False
    assert probe.ask("call('/stage/pause', SetBool, False)") == [True, "running"]
    probe.wait("0.0 < status('real_time_factor') < 0.2")
    assert probe.ask("call('/stage/set_speed', SetSpeed, 20.0)") == [True, "speed 20"]
    probe.wait("status('real_time_factor') > 0.4")  # a busy machine does not reach 20
    assert probe.ask("clock_went_back") is False


def test_a_run_pauses_so_many_steps_after_its_first_command(ros):
    _, probe = start(ros, "--robots", 1)
    ask = "call('/stage/pause_after', StepStage, {})"
    assert probe.ask(ask.format(30)) == [True, "pauses after 30 steps of 0.02 s"]
    probe.ask("drive([1], 0.0, 0.0)")
    probe.wait("now() > 1.0 and not status('paused')")  # a robot that stands begins no run
    probe.ask("drive([1], 0.3, 0.0)")
    world = World.from_scenario(load_scenario(scenario_path("paper.yaml")).overridden(robots=1))
    world.set_commands(EVERY, np.array([[0.3, 0.0]]))
    for _ in range(30):
        world.step()
    probe.wait("status('paused') and stamp() == status_stamp()")  # the state after the last step
    assert probe.ask("state('x')[0]") == pytest.approx(world.pose[0, 0], abs=1e-9)
    assert probe.ask("call('/stage/pause', SetBool, False)") == [True, "running"]
    then = probe.ask("now()")
    probe.wait("now() > {!r} + 1.0 and not status('paused')".format(then))  # once
    assert probe.ask(ask.format(1000))[0] and probe.ask(ask.format(0))[1].startswith("goes on")


def test_peers_that_connect_and_send_no_header_keep_none_out(ros):
    stage, probe = start(ros, "--robots", 1)
    probe.wait("state('robot')")
    master = xmlrpc.client.ServerProxy(ros.uri)
    node = xmlrpc.client.ServerProxy(master.lookupNode("/test", "/stage")[2])
    _, host, port = node.requestTopic("/test", "/stage/state", [["TCPROS"]])[2]
    with contextlib.ExitStack() as silent:
        for peer in range(10):  # more than rospy's queue of connections holds
            connection = silent.enter_context(socket.create_connection((host, port)))
            connection.send(bytes(peer % 3))  # nothing, or half of a length
        late = ros.probe()
        assert late.wait("state('robot')") == [1]


def test_the_team_is_set_all_at_once_or_not_at_all(ros):
    _, probe = start(ros, "--robots", 2)
    done, said = probe.ask("set_team([[0, 0, 0], [5, 0, 0], [5.1, 0.1, 0]])")
    assert not done and "robot2 and robot3 overlap" in said
    assert probe.ask("set_team([[0, 0, 0], [float('nan'), 0, 0]])")[0] is False
    assert probe.ask("set_team([])")[0] is False
    done, said = probe.ask("set_team([[3.0 * k, 0, 0] for k in range(1001)])")
    assert (
        not done and said == "1001 robots: wanted at most 1000, the stage's parameter most_robots"
    )
    assert probe.wait("state('robot')") == [1, 2]
    assert probe.ask("set_team([[0, 0, 0], [5, 0, 0], [0, 5, 1.5]])") == [True, "3 robots"]
    probe.wait("state('robot') == [1, 2, 3]")
    probe.ask("listen('/robot3/odom', Odometry)")
    assert probe.wait("odom(3)")["pose"][:2] == [0.0, 5.0]
    assert probe.ask("set_team([[0, 0, 0]])") == [True, "1 robot"]
    probe.wait("state('robot') == [1]")
    assert probe.ask("'/robot3/odom' in dict(rospy.get_published_topics())") is False
    assert probe.ask("clock_went_back") is False


def test_a_team_without_some_robots_of_the_graph_is_set(ros, tmp_path):
    (tmp_path / "three.yaml").write_text(
        "poses: [[0, 0, 0], [3, 0, 0], [6, 0, 0]]\ntopology: {edges: [[1, 2], [2, 3]]}\n"
    )
    _, probe = start(ros, "--scenario", tmp_path / "three.yaml")
    assert probe.ask("set_team([])")[0] is False
    assert probe.ask("set_team([[0, 0, 0], [5, 0, 0]])") == [True, "2 robots"]
    probe.wait("state('robot') == [1, 2]")


def test_collisions_are_published_once(ros):
    stage, probe = start(ros, "--robots", 2)
    probe.ask("set_team([[0, 0, 0], [1, 0, 3.14159265]])")
    # Time waits until both have their commands, however busy the machine is.
    probe.ask("call('/stage/pause', SetBool, True)")
    probe.wait("status('paused')")
    probe.ask("drive([1, 2], 0.5, 0.0)")
    probe.wait("state('commanded') == [True, True]")
    probe.ask("call('/stage/pause', SetBool, False)")
    probe.wait("collisions")
    probe.wait("status('collisions') == 1")
    first = probe.ask("collisions[0][:3]")
    assert first == ["robot1", "robot2", pytest.approx(0.5, abs=0.02)]
    assert probe.ask("status('closest_approach')") == pytest.approx(0.42, abs=0.02)
    assert probe.ask("len(collisions)") == 1
    wait_until(lambda: "collision of robot1 and robot2" in log_of(stage))


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["--scenario", "nowhere.yaml"], "nowhere.yaml"),
        (["--robots", "some"], "robots = 'some'"),
        (["--fidelity", "kinematik"], "'kinematik', wanted one of kinematic"),
        (["_cmd_vel_timeout:=-1"], "cmd_vel_timeout = -1: wanted a number above 0"),
        (["_speed:=fast"], "speed = 'fast'"),
        (["_odom_frame:=odom"], "odom_frame = 'odom': wanted one {}"),
        (["_paused:=3"], "paused = 3: wanted true or false"),
        (["--colour", "red"], "--colour"),
    ],
)
def test_bad_arguments_and_parameters_are_said(ros, arguments, said):
    stage = ros.node("stage", *arguments)
    assert stage.wait(PATIENCE) == 2
    assert said in log_of(stage) and "Traceback" not in log_of(stage)


@pytest.mark.parametrize(
    "speed, chosen, waits",
    [(0.0, None, False), (1.0, None, True), (20.0, None, False), (1.0, "1", False)],
)
def test_a_stage_in_real_time_does_not_wait_for_compilation(speed, chosen, waits):
    seen = []
    world = SimpleNamespace(step=lambda: seen.append(compiling._is_in_time()))
    with compiling.chosen(chosen):
        Stage._move(SimpleNamespace(pacer=Pacer(speed), world=world))
    assert seen == [waits] and not compiling._is_in_time()
