"""Semi-physical teams over ROS: real robots among the stage's simulated ones."""

import math
import sys

import pytest
import yaml
from ros_fixtures import PATIENCE, log_of, wait_until
from test_rosaria import FORWARD
from test_stage_node import start

NEVER = "_stuck_time:=0", "_frozen_time:=0"  # what stands in for a robot stays where it is
CARRIED = "_max_jump:=0"  # robots may be put elsewhere
CAMERA = """
import rospy; from geometry_msgs.msg import PoseStamped; rospy.init_node("camera")
out = rospy.Publisher("/robot2/pose", PoseStamped, queue_size=1); m = PoseStamped()
m.pose.position.x, m.pose.orientation.w = 7.0, 1.0
while not rospy.core._shutdown_flag:
    m.header.stamp = rospy.Time.from_sec(time.time()); out.publish(m); time.sleep(0.05)
"""
TEAM = """
robots: 3
poses: [[0.0, 0.0, 0.0], [3.0, 0.0, 1.5707963], [0.0, 5.0, 0.0]]
odometry: {}
"""


def start_team(ros, tmp_path, *arguments, odometry="world", real="2"):
    path = tmp_path / "team.yaml"
    path.write_text(TEAM.format(odometry))
    return start(ros, "--scenario", path, "--real", real, *arguments)


def published(probe):
    return set(probe.ask("[name for name, _ in rospy.get_published_topics()]"))


def test_a_real_robot_is_shown_where_its_odometry_says(ros, tmp_path):
    stage, probe = start_team(ros, tmp_path)
    probe.wait("status('real_silent') == [2]")
    assert "no odometry of real robot2 for 0.5 s" in wait_until(
        lambda: "no odometry of" in log_of(stage) and log_of(stage)
    )
    probe.wait("state('real') == [False, True, False]")
    assert probe.ask("[state('x')[1], state('y')[1]]") == [3.0, 0.0]  # where the scenario says
    topics = published(probe)
    assert "/robot1/odom" in topics and "/robot2/odom" not in topics
    probe.wait("'robot1/base_link' in transforms and 'robot3/odom' in transforms")
    probe.ask("stand_in(2, [4.0, 1.0, 0.5], [0.2, -0.1])")
    probe.wait("status('real_silent') == [] and state('x')[1] == 4.0")
    told = "[state(key)[1] for key in ('y', 'theta', 'vx', 'vy', 'omega')]"
    assert probe.wait("state('vx')[1] and " + told) == [
        pytest.approx(value) for value in (1.0, 0.5, 0.2, 0.0, -0.1)
    ]
    probe.ask("fall_silent(2)")
    probe.wait("status('real_silent') == [2] and state('vx')[1] == 0.0")
    assert probe.ask("state('x')[1]") == 4.0
    assert not {"robot2/base_link", "robot2/odom"} & set(probe.ask("list(transforms)"))


def test_wheel_odometry_begins_at_the_scenarios_pose(ros, tmp_path):
    _, probe = start_team(ros, tmp_path, CARRIED, odometry="wheel")
    probe.ask("stand_in(2, [1.0, 0.5, 0.25])")
    # Robot 2 began at (3, 0) with its nose along y.
    probe.wait("abs((state('x') or [0, 0])[1] - 2.5) < 1e-6")
    y, theta = probe.ask("[state('y')[1], state('theta')[1]]")
    assert (y, theta) == pytest.approx((1.0, 0.5 * math.pi + 0.25), abs=1e-6)
    # What cannot be true is no news of it.
    for impossible in ("[float('nan'), 0.5, 0.25]", "[1e6, 1e6, 0.25]"):
        probe.wait("status('real_silent') == []")
        probe.ask("stand_in(2, {})".format(impossible))
        probe.wait("status('real_silent') == [2]")
        probe.ask("stand_in(2, [1.0, 0.5, 0.25])")
    assert probe.ask("state('x')[1]") == pytest.approx(2.5, abs=1e-6)


def test_a_real_robot_whose_odometry_jumps_is_not_silently_followed(ros, tmp_path):
    stage, probe = start_team(ros, tmp_path, odometry="wheel")
    probe.ask("stand_in(2, [1.0, 0.5, 0.25])")
    probe.wait("abs((state('x') or [0, 0])[1] - 2.5) < 1e-6 and status('real_silent') == []")
    # Its driver was restarted.
    probe.ask("stand_in(2, [0.0, 0.0, 0.0])")
    probe.wait("status('real_silent') == [2]")
    wait_until(lambda: "robot2: the odometry jumped by 1.12 m" in log_of(stage))
    assert probe.ask("state('x')[1]") == pytest.approx(2.5, abs=1e-6)
    assert probe.ask("call('/stage/reset', Trigger)")[0]
    probe.wait("abs(state('x')[1] - 3.0) < 1e-6 and status('real_silent') == []")


def test_a_real_robot_stands_where_the_control_nodes_frame_has_it(ros, tmp_path):
    _, probe = start_team(ros, tmp_path, "_frame_source:=external", odometry="wheel")
    ros.start("camera", [sys.executable, "-c", "import time" + CAMERA])
    probe.ask("stand_in(2, [1.0, 0.5, 0.25])")
    probe.wait("(state('x') or [0, 0])[1] == 7.0")


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_simulated_robots_collide_with_a_real_one_which_the_stage_does_not_command(
    ros, tmp_path, fidelity
):
    _, probe = start_team(ros, tmp_path, "--fidelity", fidelity)
    probe.ask("stand_in(2, [0.8, 0.0, 3.1])")
    probe.wait("(state('x') or [0, 0])[1] == 0.8")
    probe.ask("drive([1, 2, 3], 0.5, 0.0)")
    probe.wait("[each[:2] for each in collisions] == [['robot1', 'robot2']]", limit=60)
    probe.wait_simulated(0.5)
    x = probe.wait("state('x')[2] > 0.3 and state('x')")  # which may have its command later
    assert x[1] == 0.8 and x[0] < 0.5
    # The command that it was given is told.
    probe.wait("[state('command_v')[1], state('commanded')[1]] == [0.5, True]")


def test_a_start_with_control_waits_for_no_real_robot(ros, tmp_path):
    _, probe = start_team(ros, tmp_path, "_wait_for_control:=true", real="2,3")
    probe.ask("listen('/robot1/odom', Odometry) and drive([1], 0.2, 0.0)")
    probe.wait("state('x') and state('x')[0] > 0.05", limit=60)


@pytest.mark.parametrize("node, real", [("stage", "--real"), ("pioneer_control", "_real:=2,3")])
def test_lockstep_cannot_wait_for_real_robots(ros, tmp_path, node, real):
    arguments = [real, "2,3"] if node == "stage" else [real]
    process = ros.node(node, "--robots", 3, "_lockstep:=true", *arguments)
    assert process.wait(PATIENCE) == 2
    assert "lockstep: true with real robots 2, 3: simulated time cannot wait" in log_of(process)


def test_a_real_robot_is_followed_while_the_stage_is_paused(ros, tmp_path):
    _, probe = start_team(ros, tmp_path, "_paused:=true", CARRIED)
    probe.ask("stand_in(2, [4.0, 1.0, 0.5])")
    probe.wait("(state('x') or [0, 0])[1] == 4.0")
    paused = probe.ask("now()")
    probe.ask("stand_in(2, [4.5, 1.0, 0.5])")
    probe.wait("state('x')[1] == 4.5")
    assert probe.ask("[now(), state('x')[0], state('x')[2]]") == [paused, 0.0, 0.0]


def drive_team(ros, tmp_path, *arguments):
    """Start the team with robot 2 stood in for, driven straight on; return stage, control and probe."""
    stage, probe = start_team(ros, tmp_path)
    probe.ask("stand_in(2, [3.0, 0.0, 1.5707963])")
    probe.ask("listen('/robot2/cmd_vel', Twist)")
    (tmp_path / "law.py").write_text(FORWARD)
    team = ["--scenario", tmp_path / "team.yaml", "--protocol", tmp_path / "law.py"]
    control = ros.node(
        "pioneer_control",
        *team,
        "_real:=2",
        "_autostart:=true",
        *NEVER,
        "_odom_timeout:=2",
        *arguments,
    )
    probe.wait("sent(2) == [0.2, 0.0]")
    return stage, control, probe


def test_a_pause_stops_the_real_robots_until_start(ros, tmp_path):
    _, control, probe = drive_team(ros, tmp_path)
    assert probe.ask("call('/stage/pause', SetBool, True)")[0]
    probe.wait("sent(2) == [0.0, 0.0]")
    probe.wait("'simulated time stands still' in control('trouble')")
    wait_until(lambda: "robots stopped: simulated time stands still" in log_of(control))
    done, said = probe.ask("call('/pioneer_control/start', Trigger)")
    assert not done and said.startswith("simulated time stands still")
    assert probe.ask("call('/stage/pause', SetBool, False)")[0]
    probe.wait_simulated(0.5)
    assert probe.ask("sent(2)") == [0.0, 0.0] and not probe.ask("control('running')")
    wait_until(lambda: probe.ask("call('/pioneer_control/start', Trigger)")[0])
    probe.wait("sent(2) == [0.2, 0.0]")


def test_the_silence_of_a_real_robot_shows_though_simulated_time_stands(ros, tmp_path):
    _, _, probe = drive_team(ros, tmp_path, "_odom_timeout:=1.2")
    assert probe.ask("call('/stage/pause', SetBool, True)")[0]
    probe.wait("'simulated time stands still' in control('trouble')")
    probe.wait("control('stale') == []")
    probe.ask("fall_silent(2)")
    probe.wait("control('stale') == [2]")


def test_the_jump_of_a_real_robot_is_noticed_and_that_of_a_simulated_one_is_not(ros, tmp_path):
    _, _, probe = drive_team(ros, tmp_path, "_odom_timeout:=5", "_resume:=true")
    probe.wait("(state('x') or [0])[0] > 0.3")
    assert probe.ask("call('/stage/reset', Trigger)")[0]
    probe.wait("0.0 < state('x')[0] < 0.2")
    probe.wait("control('trouble') == ''")
    probe.ask("stand_in(2, [6.0, 0.0, 1.5707963])")
    probe.wait("'robot2: the odometry jumped by 3.00 m' in control('trouble')")
    probe.wait("max(map(abs, state('vx'))) == 0.0")


def test_reset_and_a_new_team_know_the_real_robot(ros, tmp_path):
    _, probe = start_team(ros, tmp_path, CARRIED)
    probe.ask("stand_in(2, [4.0, 1.0, 0.0])")
    probe.wait("(state('x') or [0, 0])[1] == 4.0")
    assert probe.ask("call('/stage/reset', Trigger)")[0] is True
    probe.wait_simulated(0.1)
    assert probe.ask("state('x')") == [0.0, 4.0, 0.0]
    done, said = probe.ask("set_team([[0, 0, 0]])")
    assert not done and "real robots [2]: wanted numbers from 1 to 1" in said
    assert probe.ask("set_team([[0, 0, 0], [3, 0, 0]])") == [True, "2 robots"]
    probe.wait("state('real') == [False, True] and state('x')[1] == 4.0")
    # In the way of a reset it is named.
    probe.ask("stand_in(2, [0.1, 0.1, 0.0])")
    probe.wait("state('x')[1] == 0.1")
    done, said = probe.ask("call('/stage/reset', Trigger)")
    assert not done and "robot1 and robot2 overlap" in said


@pytest.mark.parametrize(
    "real, said",
    [
        ("4", "real robots [4]: wanted numbers from 1 to 3"),
        ("0,1", "real robots [0, 1]: wanted numbers from 1 to 3"),
        ("2;3", "real = '2;3': wanted robots' numbers with commas between them"),
    ],
)
def test_numbers_that_are_no_robots_are_said(ros, tmp_path, real, said):
    path = tmp_path / "team.yaml"
    path.write_text(TEAM.format("world"))
    stage = ros.node("stage", "--scenario", path, "--real", real)
    assert stage.wait(PATIENCE) == 2
    assert said in log_of(stage) and "Traceback" not in log_of(stage)


def test_the_control_node_too_says_which_numbers_are_no_robots(ros):
    control = ros.node("pioneer_control", "--robots", 3, "_real:=[2, 4]")
    assert control.wait(PATIENCE) == 2
    said = "parameter /pioneer_control/real names [4]: wanted numbers from 1 to 3"
    assert said in log_of(control) and "Traceback" not in log_of(control)


def parameters_of_launch(ros, *arguments):
    """Return the parameters that simulation.launch sets, by name."""
    return yaml.safe_load(
        ros.call("roslaunch", "--dump-params", "mrs_simulator", "simulation.launch", *arguments)
    )


def test_the_launch_file_starts_no_real_robot_and_knows_their_guards(ros):
    guards = ["geofence:=-4, -4, 4, 4", "min_distance:=0.8", "v_max:=0.2", "omega_max:=0.5"]
    given = parameters_of_launch(ros, "real:=1,3", "dry_run:=true", "resume:=false", *guards)
    told = {name: given["/pioneer_control/" + name] for name in ("real", "autostart", "dry_run")}
    assert told == {"real": "1,3", "autostart": False, "dry_run": True}
    assert given["/stage/wait_for_control"] is False
    assert given["/pioneer_control/geofence"] == "-4, -4, 4, 4"
    assert given["/pioneer_control/min_distance"] == 0.8
    assert (given["/pioneer_control/v_max"], given["/pioneer_control/omega_max"]) == (0.2, 0.5)
    assert given["/pioneer_control/resume"] is False
    # One robot's number is not taken for none, and simulated ones go at once.
    assert parameters_of_launch(ros, "real:=2")["/pioneer_control/autostart"] is False
    assert parameters_of_launch(ros)["/pioneer_control/autostart"] is True
