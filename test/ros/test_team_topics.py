"""One topic for all robots: the same run as with a topic for each, and nothing taken on trust."""

import sys
import threading

import numpy as np
import pytest
from ros_fixtures import log_of, wait_until

from mrs_simulator.control.guards import JumpBounds, Tracks
from mrs_simulator.nodes.stage.answered_odometry import Answers
from mrs_simulator.nodes.stage.robot_topics import Inbox as StageInbox
from mrs_simulator.nodes.stage.round_trips import RoundTrips
from mrs_simulator.ros.message_forms.messages import MessageError, read_answered, team_command
from mrs_simulator.ros.message_forms.planar_messages import QuickTwist
from mrs_simulator.ros.receive.odometry_inbox import Inbox

POSES = np.array([[1.0, 2.0, 0.3], [4.0, 5.0, -0.6]])


def recorded(ros, directory, team_topics):
    """Run two simulated seconds in lockstep; return run.csv as a table."""
    out, given = directory / team_topics, ("--robots", 3, "_lockstep:=true")
    nodes = [
        ros.node("stage", *given, "_speed:=0", "_wait_for_recorders:=1"),
        ros.node("pioneer_control", *given, "_team_topics:=" + team_topics),
        ros.node("record", *given[:2], "--out", out, "--duration", 2),
    ]
    ros.judged(nodes[-1], out)
    for node in nodes:
        ros.stop(node)
    return np.genfromtxt(out / "run.csv", delimiter=",", skip_header=1)


def test_both_kinds_of_topics_give_the_same_run(ros, tmp_path):
    by_robot, by_team = (recorded(ros, tmp_path, choice) for choice in ("never", "always"))
    assert len(by_robot) == 3 * 21
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
    # Which odometry a command answers is known only because the message for all tells it.
    assert probe.wait("0.0 < (status('round_trip_p99') or 0.0) and status('robots')") == 60
    control.kill()
    probe.wait("max(map(abs, state('vx') + state('omega'))) == 0.0")
    assert probe.wait("len(status('timed_out'))") == 60


def test_a_stage_without_team_topics_is_driven_robot_by_robot(ros):
    ros.node("stage", "--robots", 60, "--real", "60", "stage/command:=/elsewhere")
    control = ros.node("pioneer_control", "--robots", 60, "_odom_timeout:=1000")
    wait_until(lambda: "none found: each robot has its own topics" in log_of(control))


def test_a_malformed_command_moves_no_robot_and_is_named(ros):
    stage = ros.node("stage", "--robots", 3)
    probe = ros.probe()
    probe.wait("now()")
    code = """
import rospy
from mrs_simulator.msg import TeamCommand
rospy.init_node("sender", disable_rostime=True)
publisher = rospy.Publisher("/stage/command", TeamCommand, queue_size=10, latch=True)
publisher.publish(TeamCommand({}))
rospy.spin()
"""

    def send(command):
        for process in sending:
            ros.stop(process)
        sending[:] = [ros.start("sender", [sys.executable, "-c", code.format(command)])]
        ros.wait_for_connections("/stage", {"/stage/command"})

    sending = []
    send("robot=[1, 2, 3], v=[0.5, 0.5], omega=[0.0, 0.0, 0.0]")
    wait_until(lambda: "3 robots, 2 v; wanted as many of each" in log_of(stage))
    send("robot=[0, 2], v=[0.5, 0.5], omega=[0.0, 0.0]")
    send("robot=[2, 9], v=[float('nan'), 0.5], omega=[0.0, 0.0]")
    probe.wait("status('refused') == [0, 1, 0]")
    assert probe.ask("any(state('commanded'))") is False
    assert probe.ask("max(map(abs, state('vx')))") == 0.0
    # A component that the robot does not obey is left out, counted, and said once.
    send("robot=[3], v=[0.0], omega=[0.0], vy=[0.4]")
    probe.wait("status('unobeyed') == [0, 0, 1]")
    told = "robot3 was commanded linear.y, which a Pioneer 3-DX does not obey"
    wait_until(lambda: "[WARN" in log_of(stage) and told in log_of(stage))


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


PERIOD = 0.02  # [s]


def delayed(delay, told=True, cycles=200, period=PERIOD):
    """Return the ``RoundTrips`` of two robots whose every odometry is answered after ``delay`` [s]."""
    now = [0.0]
    trips = RoundTrips(2, period, clock=lambda: now[0])
    driven = np.ones(2, dtype=bool)
    for cycle in range(cycles):
        now[0] = cycle * period
        if cycle:
            trips.end_period(now[0], driven)
        trips.sent(now[0])
        answered = [k for k in range(cycle) if now[0] < k * period + delay <= now[0] + period]
        answered = answered or [cycle] * (delay < period)
        for k in answered:
            came = max(now[0], k * period + delay)
            stamps = np.full(2, k * period if told else np.nan)
            trips.answered([0, 1], [came, came], stamps, now[0])
    return trips


@pytest.mark.parametrize("delay", [0.005, 0.011, 0.070, 1.3])
def test_a_late_answer_counts_for_the_odometry_that_it_answers(delay):
    trips = delayed(delay)
    assert trips.median_and_p99() == pytest.approx((delay, delay), rel=0.01)
    # The last odometry before the end has no answer yet, nor have the first periods been judged.
    assert trips.missed == (0 if delay < 2 * PERIOD else 2 * (200 - 3))
    assert trips.periods == 2 * 199


def test_of_commands_without_a_stamp_no_round_trip_is_reported():
    trips = delayed(0.070, told=False)
    assert np.isnan(trips.median_and_p99()).all()
    assert trips.missed == 2 * 2  # before the first came


def test_round_trips_are_of_the_whole_run():
    trips = RoundTrips(1, PERIOD, clock=lambda: 0.0)
    for cycle in range(1000):  # each odometry leaves at 0
        trips.sent(float(cycle))
        took = 0.5 if cycle < 20 else 0.002 + 1e-6 * cycle
        trips.answered([0], [took], [float(cycle)], float(cycle))
        trips.answered([0], [9.0], [float(cycle)], float(cycle))  # only the first answer counts
    assert trips.median_and_p99() == pytest.approx((0.00251, 0.5), rel=0.01)


def test_periods_count_by_the_odometry_that_was_answered():
    trips = RoundTrips(3, PERIOD)
    commanded = np.array([True, True, False])
    for cycle, (rows, answers) in enumerate(
        [([0, 1], 0), ([0], 1), ([0, 1], 1), ([0], 3), ([0], 4), ([0], 5)]
    ):
        now = cycle * PERIOD
        trips.end_period(now, commanded)
        trips.sent(now)
        trips.answered(rows, [now] * len(rows), [answers * PERIOD] * len(rows), now)
    # The first that began, of cycle 0, is judged at the beginning of cycle 2; those of cycles 4 and 5
    # are not yet.  Robot 1 answered that of cycle 1 a period late, robot 0 not that of cycle 2 at all.
    assert trips.missed == 1 + 2
    trips.begin(2, PERIOD)
    assert trips.missed == 3 and np.isnan(trips.median_and_p99()).all()


def test_periods_after_a_watchdog_count_where_the_controller_was_only_outrun():
    trips, nobody = RoundTrips(2, 0.02), np.zeros(2, dtype=bool)
    unknown = [np.nan]
    trips.answered([0, 1], [5.0, 5.0], unknown * 2, 1.0)
    for cycle in range(102):  # simulated time is fast: both were stopped by their watchdogs
        trips.end_period(1.0 + 0.02 * cycle, nobody)
    assert trips.missed == 0 and trips.periods == 204
    trips.answered([0], [5.1], unknown, 3.1)
    assert trips.missed == 100
    trips.answered([1], [9.0], unknown, 3.2)  # somebody had stopped it
    assert trips.missed == 100


def twist(v):
    return (v, 0.0, 0.0, 0.0, 0.0, 0.25)


def test_a_twist_answers_the_odometry_that_its_controller_tells_beside_it():
    answers = Answers(2)
    for cycle in range(5):
        answers.expect([0, 1], [twist(0.1 * cycle), twist(1.0)], [cycle, cycle])
    # On a slow line: the Twists of cycle 1 come when those of cycle 4 were sent; that of robot 0's cycle 0
    # never came.
    answers.note(0, twist(0.1), 7.0)
    answers.note(1, twist(1.0), 7.1)
    answers.note(8, twist(0.5), 7.2)
    rows, times, stamps = answers.take()
    assert rows.tolist() == [0, 1] and times.tolist() == [7.0, 7.1]
    # All of robot 1 are alike: which of them came cannot be known.
    assert stamps[0] == 1.0 and np.isnan(stamps[1])
    answers.note(0, twist(0.5), 8.0)  # outruns what is told of it
    assert len(answers.take()[0]) == 0
    answers.expect([0, 1], [twist(0.5), twist(2.0)], [5, np.nan])
    answers.note(1, twist(2.0), 8.1)
    rows, times, stamps = answers.take()
    assert rows.tolist() == [0, 1] and times.tolist() == [8.0, 8.1]
    assert stamps[0] == 5.0 and np.isnan(stamps[1])  # no odometry
    answers.note(0, twist(9.0), 9.0)  # somebody else's
    assert len(answers.take()[0]) == 0 and np.isnan(answers.take()[2]).tolist() == [True]
    answers.expect([2, 2**32 - 2], [twist(1.0)] * 2, [6.0, 6.0])  # no robots
    answers.note(2, twist(1.0), 9.0)
    assert len(answers.take()[0]) == 0


def test_stamps_of_commands_for_all_come_through_with_them():
    answers = Answers(2)
    answers.note_all([0, 1, 2], 3.0, np.array([1.0, 1.0, 2.0]))
    rows, times, stamps = answers.take()
    assert rows.tolist() == [0, 1] and times.tolist() == [3.0] * 2 and stamps.tolist() == [1.0] * 2
    for stamps in ([1.5, 1.5], [1.5, 1.25], [1.5, np.nan]):
        message = team_command([1, 2], np.zeros((2, 2)), answered=stamps)
        np.testing.assert_array_equal(read_answered(message), stamps)
    assert np.isnan(read_answered(team_command([1, 2], np.zeros((2, 2))))).all()
    with pytest.raises(MessageError, match="3 robots, 2 odometry"):
        read_answered(team_command([1, 2, 3], np.zeros((3, 2)), answered=[1.0, 2.0]))


LATE_LAW = """
import time
from mrs_simulator.protocols.formation.law import Formation

class Late(Formation):
    def pointMassLaw(self, hand):
        time.sleep({})
        return super().pointMassLaw(hand)
"""


def test_a_law_that_takes_many_periods_is_seen_to_over_ros(ros, tmp_path):
    delay = 0.15
    law = tmp_path / "late.py"
    law.write_text(LATE_LAW.format(delay))
    ros.node("stage", "--robots", 3)
    control = ("--robots", 3, "--protocol", "{}:Late".format(law), "_law_process:=false")
    ros.node("pioneer_control", *control)
    probe = ros.probe()
    probe.wait("(status('command_periods') or 0) > 150")
    probe.wait("0.0 < (status('round_trip_median') or 0.0) < {!r}".format(2.5 * delay))
    # What the machine adds, but for moments, is far less than the period by which the old way was out.
    assert probe.ask("status('round_trip_median')") > delay
    # One in eight or so is answered at all, and none in time.
    probe.wait("status('missed_periods') / status('command_periods') > 0.6")


def test_what_comes_before_the_wait_is_not_slept_through():
    inbox = Inbox([1, 2, 3])
    inbox.wake()
    waiter = threading.Thread(target=inbox.wait, args=(60.0,), daemon=True)
    waiter.start()
    wait_until(lambda: not waiter.is_alive())


def quick(value):
    message = QuickTwist()
    message.values = (value,) * 6
    return message


def test_of_several_commands_the_newest_is_taken(monkeypatch):
    inbox = StageInbox()
    monkeypatch.setattr(inbox, "_senders", type("Anybody", (), {"note": lambda *_: None}))
    nobody = np.full(3, np.nan)
    rows, commands = inbox.take(6)
    assert rows == [] and commands.shape == (0, 6)
    inbox.put(quick(1.0), 3)
    inbox.put_all(np.array([5, 3, 0]), np.tile([[2.0], [3.0], [4.0]], 6), nobody)
    inbox.put(quick(5.0), 5)
    rows, commands = inbox.take(6)
    assert rows == [0, 3, 5] and commands.tolist() == [[4.0] * 6, [3.0] * 6, [5.0] * 6]
    assert inbox.take(6)[0] == []
    inbox.put_all(np.array([-1, 1, 4]), np.ones((3, 6)), nobody)
    rows, commands = inbox.take(4)  # there is no robot 0, and robot 5 has been taken away
    assert rows == [1] and commands.tolist() == [[1.0] * 6]
    assert inbox.answers.take()[0].tolist() == []
    inbox.answers.begin(4)
    inbox.answers.note_all(np.array([-1, 1, 4]), 0.0, nobody)
    assert inbox.answers.take()[0].tolist() == [1]


@pytest.mark.parametrize("waits", [False, True])
def test_a_stage_that_waits_misses_no_period_though_it_learns_late_what_is_answered(waits):
    trips, driven = RoundTrips(2, 0.1), np.ones(2, dtype=bool)
    for period in range(6):
        now = 0.1 * period
        trips.end_period(now, driven)
        trips.sent(now)
        if waits:
            trips.waited_for(np.arange(2))
        if period >= 3:  # announced on a topic of its own, read three periods later
            trips.answered([0, 1], [0.0, 0.0], [now - 0.3] * 2, now)
    assert trips.missed == (0 if waits else 8) and trips.periods == 12
