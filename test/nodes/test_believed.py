"""Nothing old, impossible or doubled is believed: asserted from what the robots are sent."""

import sys
import xmlrpc.client

import numpy as np
import pytest
from ros_fixtures import PATIENCE, log_of, wait_until
from test_control_node import FORWARD, at_rest, moving

from mrs_simulator.record.recording import read_run_csv

RELAY = """
import collections, time, rospy
from nav_msgs.msg import Odometry
rospy.init_node("relay", disable_rostime=True)
kept = collections.deque()
out = rospy.Publisher("/late/robot1/odom", Odometry, queue_size=1)
rospy.Subscriber("/robot1/odom", Odometry, kept.append)
while not rospy.core._shutdown_flag:
    # Late by a second of simulated time, however slowly that goes.
    while kept and (kept[-1].header.stamp - kept[0].header.stamp).to_sec() >= 1.0:
        out.publish(kept.popleft())
    time.sleep(0.005)
"""
TROUBLE = "(control('trouble') or '')"


@pytest.fixture
def law(tmp_path):
    """Return the path of a law that drives every robot straight on."""
    path = tmp_path / "law.py"
    path.write_text(FORWARD)
    return path


@pytest.fixture
def real(ros, law):
    """Return the probe that stands in for real robot 1, driven straight on by a control node."""
    xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/use_sim_time", False)
    probe = ros.probe()
    probe.ask("listen('/robot1/cmd_vel', Twist) and stand_in(1, [0.0, 0.0, 0.0])")
    given = ["_autostart:=true", "_resume:=true", "_stuck_time:=0", "_frozen_time:=0"]
    given += ["_odom_timeout:=0.4"]  # a busy machine may hold it up: it goes on by itself
    ros.node("pioneer_control", "--robots", 1, "--protocol", law, *given)
    probe.wait("(sent(1) or [0])[0] == 0.3")
    return probe


def test_what_cannot_tell_where_a_real_robot_is_stops_it_and_is_named(real):
    message = "driven['/robot1/odom'][1]"
    right = "setattr({}{}, {!r}, {!r}) or True"
    for place, name, wrong, good, said in (
        (".header", "frame_id", "map", "odom", "in frame 'map', wanted one called odom"),
        (".pose.pose.orientation", "w", 0.0, 1.0, "its quaternion has length 0"),
        (".pose.pose.position", "x", 1e6, 0.0, "at (1e+06, 0) m"),
    ):
        real.ask(right.format(message, place, name, wrong))
        real.wait("sent(1) == [0.0, 0.0]")
        real.wait("{!r} in {}".format(said, TROUBLE))
        assert said in real.ask("control('refusal')") and real.ask("control('refused')")[0] > 0
        real.ask(right.format(message, place, name, good))
        real.wait("sent(1)[0] == 0.3")
    real.ask("unstamped.add('/robot1/odom')")
    for seconds, said in ((0, "its stamp is not set"), (3976214400, "its clock jumped")):
        real.ask("setattr({}.header, 'stamp', rospy.Time({})) or True".format(message, seconds))
        real.wait("sent(1) == [0.0, 0.0] and {!r} in {}".format(said, TROUBLE))


def test_simulated_robots_are_not_driven_by_odometry_that_comes_late(ros, law):
    ros.node("stage", "--robots", 1)
    ros.start("relay", [sys.executable, "-c", RELAY])
    late = "_odom_topic:=/late/robot{}/odom"
    ros.node("pioneer_control", "--robots", 1, "--protocol", law, late)
    probe = ros.probe()
    probe.wait("'refused: stamped' in {0} and 'before the simulated time' in {0}".format(TROUBLE))
    probe.wait_simulated(1.0)
    probe.wait("control('refused')[0] > 10")
    assert probe.ask("state('vx')") == [0.0]


def test_two_controllers_stop_all_robots_and_name_each_other(ros, law):
    ros.node("stage", "--robots", 2)
    given = ["--robots", 2, "--protocol", law]
    ros.node("pioneer_control", *given)
    probe = ros.probe()
    moving(probe, 2)
    probe.ask("listen('/other/status', ControlStatus)")
    other = ros.node("pioneer_control", *given, "__name:=other", name="other")
    both = "'/other and /pioneer_control both publish /robot1/cmd_vel and 1 more'"
    probe.wait("{} in {}".format(both, TROUBLE))
    probe.wait("{} in (plain('/other/status').get('trouble') or '')".format(both))
    at_rest(probe)
    done, said = probe.ask("call('/pioneer_control/stop', Trigger)")
    assert not done and "stop the other too" in said
    other.kill()  # which leaves its name in the master's books
    other.wait(PATIENCE)
    wait_until(lambda: probe.ask("call('/pioneer_control/stop', Trigger)")[0])
    assert probe.ask("call('/pioneer_control/start', Trigger)")[0]
    moving(probe, 2)


def test_a_stage_that_two_nodes_command_obeys_neither(ros):
    ros.node("stage", "--robots", 2)
    probe = ros.probe()
    speed = "abs((state('vx') or [0])[0]) + abs((state('vy') or [0])[0])"

    def send(name, v):
        given = [
            "-r",
            "20",
            "/robot1/cmd_vel",
            "geometry_msgs/Twist",
            "{{linear: {{x: {}}}}}".format(v),
        ]
        ros.start(name, ["rostopic", "pub", *given])

    send("one", 0.2)
    probe.wait(speed + " > 0.1")
    send("two", 0.3)
    probe.wait("'both publish /robot1/cmd_vel' in (status('trouble') or '')")
    probe.wait(speed + " == 0.0")
    where = probe.ask("[state('x')[0], state('y')[0]]")
    probe.wait_simulated(1.0)
    assert probe.ask("[state('x')[0], state('y')[0]]") == where


def test_a_second_stage_does_not_start_and_another_ones_odometry_stops_the_robots(ros, law):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2, "--protocol", law)
    probe = ros.probe()
    moving(probe, 2)
    second = ros.node("stage", "--robots", 2, "__name:=second", name="second")
    probe.ask("stand_in(2, [1.0, 0.0, 0.0])")
    probe.wait("'/probe' in {0} and '/stage both publish /robot2/odom' in {0}".format(TROUBLE))
    at_rest(probe)
    probe.ask("release()")
    moving(probe, 2)
    # Somebody else's commands: the stage obeys neither.
    probe.ask("drive([1], -0.5, 0.0)")
    probe.wait("'/pioneer_control and /probe' in status('trouble')")
    at_rest(probe)
    assert second.wait(PATIENCE) == 2  # it has waited for the end of the other
    assert "/stage publishes it already" in log_of(second) and "Traceback" not in log_of(second)


def test_real_robots_stand_until_they_are_started(ros, law):
    xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/use_sim_time", False)
    control = ros.start("control", [sys.executable, str(law), "--robots", "1"])
    probe = ros.probe()
    probe.ask("listen('/robot1/cmd_vel', Twist) and stand_in(1, [0.0, 0.0, 0.0])")
    probe.wait("control('trouble') == 'not started' and control('stale') == []")
    check = "rosrun mrs_simulator preflight --robots 1 --protocol {}:Forward".format(law)
    wait_until(lambda: check in log_of(control))
    assert probe.ask("[sent(1), control('running')]") in ([None, False], [[0.0, 0.0], False])
    probe.wait("call('/pioneer_control/start', Trigger) == [True, 'running']")
    probe.wait("(sent(1) or [0])[0] == 0.3")


def test_a_reset_ends_the_recorded_run(ros, law, tmp_path):
    ros.node("stage", "--robots", 2, "_wait_for_recorders:=1")
    ros.node("pioneer_control", "--robots", 2, "--protocol", law)
    given = ["--robots", 2, "--protocol", law, "--duration", 60, "--out", tmp_path / "run"]
    record = ros.node("record", *given)
    probe = ros.probe()
    moving(probe, 2)
    probe.wait("abs(state('x')[0] - 9.95) > 0.5")
    assert probe.ask("call('/stage/reset', Trigger)")[0]
    verdict = ros.judged(record, tmp_path / "run")
    assert verdict["ended"] == "the stage was reset, or given another team"
    assert not verdict["passed"]
    run = read_run_csv(str(tmp_path / "run" / "run.csv"))
    assert abs(np.diff(run.pose[:, :, 0], axis=0)).max() < 0.1
