"""One topic for all robots: the same run as with a topic for each, and nothing taken on trust."""

import threading

import numpy as np
import pytest
from ros_fixtures import log_of, wait_until

from mrs_simulator.core.guards import JumpBounds, Tracks
from mrs_simulator.nodes.control.timing import RoundTrips
from mrs_simulator.ros.odometry_inbox import Inbox

POSES = np.array([[1.0, 2.0, 0.3], [4.0, 5.0, -0.6]])


def recorded(ros, directory, team_topics):
    """Run four simulated seconds in lockstep; return run.csv as a table."""
    out = directory / team_topics
    nodes = [
        ros.node("stage", "_lockstep:=true", "_speed:=0", "_wait_for_recorders:=1"),
        ros.node("pioneer_control", "_lockstep:=true", "_team_topics:=" + team_topics),
        ros.node("record", "--out", out, "--duration", 4),
    ]
    nodes[-1].wait(60)
    for node in nodes:
        ros.stop(node)
    return np.genfromtxt(out / "run.csv", delimiter=",", skip_header=1)


def test_both_kinds_of_topics_give_the_same_run(ros, tmp_path):
    by_robot, by_team = (recorded(ros, tmp_path, choice) for choice in ("never", "always"))
    assert len(by_robot) == 7 * 41
    # nav_msgs/Odometry tells a heading as a quaternion, which costs its last digit.
    np.testing.assert_allclose(by_team, by_robot, rtol=0.0, atol=1e-10)


def test_a_large_team_uses_one_topic_by_itself_and_stops_with_its_control(ros):
    ros.node("stage", "--robots", 60)
    control = ros.node("pioneer_control", "--robots", 60)
    probe = ros.probe()
    probe.wait("max(map(abs, state('vx') or [0])) > 0.1")
    publishers = ros.python(
        "import rosgraph\n"
        "published, subscribed, _ = rosgraph.Master('/test').getSystemState()\n"
        "print(dict(published).get('/stage/command'), dict(published).get('/robot1/cmd_vel'))\n"
        "print('/robot1/cmd_vel' in dict(subscribed))"
    )
    assert publishers.split("\n")[:2] == ["['/pioneer_control'] None", "True"]
    assert probe.wait("0.0 < (status('round_trip_p99') or 0.0) and status('robots')") == 60
    control.kill()
    probe.wait("max(map(abs, state('vx') + state('omega'))) == 0.0")
    assert probe.wait("len(status('timed_out'))") == 60


def test_a_stage_without_team_topics_is_driven_robot_by_robot(ros):
    ros.node("stage", "--robots", 60, "--real", "60", "stage/command:=/elsewhere")
    control = ros.node("pioneer_control", "--robots", 60, "_odom_timeout:=1000")
    wait_until(lambda: "none found: each robot has its own topics" in log_of(control))


def test_a_malformed_command_moves_nobody_and_is_named(ros):
    stage = ros.node("stage", "--robots", 3)
    probe = ros.probe()
    probe.wait("now()")
    code = """
import rospy, sys
from mrs_simulator.msg import TeamCommand
rospy.init_node("sender", disable_rostime=True)
publisher = rospy.Publisher("/stage/command", TeamCommand, queue_size=10, latch=True)
publisher.publish(TeamCommand({}))
rospy.sleep(1.0)
"""
    ros.python(code.format("robot=[1, 2, 3], v=[0.5, 0.5], omega=[0.0, 0.0, 0.0]"))
    wait_until(lambda: "3 robots, 2 v; wanted as many of each" in log_of(stage))
    ros.python(code.format("robot=[0, 2], v=[0.5, 0.5], omega=[0.0, 0.0]"))
    ros.python(code.format("robot=[2, 9], v=[float('nan'), 0.5], omega=[0.0, 0.0]"))
    probe.wait("status('refused') == [0, 1, 0]")
    assert probe.ask("any(state('commanded'))") is False
    assert probe.ask("max(map(abs, state('vx')))") == 0.0
    # A component that the robot does not obey is left out, counted, and said once.
    ros.python(code.format("robot=[3], v=[0.0], omega=[0.0], vy=[0.4]"))
    probe.wait("status('unobeyed') == [0, 0, 1]")
    told = "robot3 was told linear.y, which a Pioneer 3-DX does not obey"
    assert log_of(stage).count("[WARN") >= 1 and told in log_of(stage)


@pytest.mark.parametrize("bounds", [None, [JumpBounds(0.3, 1.0, 1.0)] * 3])
def test_tracks_take_all_robots_as_they_take_each(bounds):
    one, all_at_once = Tracks(3, bounds), Tracks(3, bounds)
    for time, shift in ((1.0, 0.0), (1.1, 0.01), (1.2, 5.0)):
        for row, pose in zip((0, 2), (POSES + shift).tolist()):
            one.take(row, pose, (time, time))
        level = np.zeros(2)
        all_at_once.take_all(np.array([0, 2]), POSES + shift, (time, time), level)
    np.testing.assert_array_equal(one.pose, all_at_once.pose)
    np.testing.assert_array_equal(one.first, all_at_once.first)
    assert one.jumps == all_at_once.jumps and len(one.jumps) == (0 if bounds is None else 2)


def test_round_trips_and_missed_periods():
    now = [10.0]
    trips = RoundTrips(3, clock=lambda: now[0])
    commanded = np.array([True, True, False])
    assert np.isnan(trips.median_and_p99()).all()
    trips.end_period(commanded)  # had begun before anything was sent
    trips.sent()
    trips.answered([0, 1], np.array([10.004, 10.006]))
    trips.answered([0], np.array([10.010]))  # only the first answer counts
    assert trips.median_and_p99() == pytest.approx((0.005, 0.00598))
    trips.end_period(commanded)
    assert trips.missed == 0
    now[0] = 10.02
    trips.sent()
    trips.answered([1], np.array([10.021]))
    trips.end_period(commanded)
    assert trips.missed == 1  # robot 1; the third is not under command
    trips.begin(2)
    assert trips.missed == 1 and np.isnan(trips.median_and_p99()).all()
    assert trips.periods == 9


def test_periods_after_a_watchdog_count_where_the_controller_was_only_outrun():
    trips, nobody = RoundTrips(2, clock=lambda: 0.0), np.zeros(2, dtype=bool)
    trips.answered([0, 1], np.array([5.0, 5.0]))
    for _ in range(101):  # simulated time is fast: both were stopped by their watchdogs
        trips.end_period(nobody)
    assert trips.missed == 0 and trips.periods == 202
    trips.answered([0], np.array([5.1]))
    assert trips.missed == 100
    trips.answered([1], np.array([9.0]))  # somebody had stopped it
    assert trips.missed == 100


def test_what_comes_before_the_wait_is_not_slept_through():
    inbox = Inbox([1, 2, 3])
    inbox.wake()
    waiter = threading.Thread(target=inbox.wait, args=(60.0,), daemon=True)
    waiter.start()
    wait_until(lambda: not waiter.is_alive())


def test_poses_are_fresh_until_used():
    inbox = Inbox([1, 2, 3])
    assert inbox.all_fresh([]) and not inbox.all_fresh([0, 2])
    with inbox._changed:
        inbox._note_arrival([0, 2])
    assert inbox.all_fresh([0, 2]) and not inbox.all_fresh([0, 1])
    inbox.used()
    assert not inbox.all_fresh([0])
