"""Runs read from rosbags: of real robots' own topics, and bags that are none."""

import numpy as np
import pytest
import rosbag
import rospy
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from mrs_simulator.msg import ControlStatus, StageStatus, TeamCommand
from mrs_simulator.record.controller_log import EMERGENCY
from mrs_simulator.record.recording import RunError
from mrs_simulator.ros.message_forms.messages import read_answered
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.results.bag_reading import read_bag
from mrs_simulator.verdict.requirements.results import evaluated
from mrs_simulator.verdict.verdict import judge

SCENARIO = {"poses": [[10.0, 0.0, 0.0], [0.0, 5.0, np.pi / 2]], "duration": 2.0}


def write(path, odom="RosAria/pose", command="RosAria/cmd_vel", jitter=0.0, held_up=()):
    """Two robots of which each goes straight on at 0.5 m/s, by its own odometry, from 1 s on.

    Before they are told to stand; every other odometry is late by ``jitter`` [s]; of
    robot 2 that of the steps ``held_up`` comes 0.15 s after its stamp.
    """
    with rosbag.Bag(str(path), "w") as bag:
        for step in range(31):
            stamp = rospy.Time.from_sec(100.0 + 0.1 * step + jitter * (step % 2))
            for robot in (1, 2):
                message = Odometry()
                message.header.stamp = stamp
                message.pose.pose.position.x = 0.05 * max(0, step - 10)
                message.pose.pose.orientation.w = 1.0
                message.twist.twist.linear.x = 0.5 if step > 10 else 0.0
                wait = 0.15 if robot == 2 and step in held_up else 0.0
                came = stamp + rospy.Duration.from_sec(wait)
                bag.write("/robot{}/{}".format(robot, odom), message, came)
                if step >= 5:
                    twist = Twist()
                    twist.linear.x = 0.5 if step >= 10 else 0.0
                    bag.write("/robot{}/{}".format(robot, command), twist, stamp)
    return str(path)


@pytest.mark.parametrize(
    "odom, command", [("RosAria/pose", "RosAria/cmd_vel"), ("odom", "cmd_vel")]
)
def test_real_robots_are_read_in_the_common_frame(tmp_path, odom, command):
    scenario = scenario_from_dict(dict(SCENARIO, odometry="wheel"))
    run = read_bag(write(tmp_path / "run.bag", odom, command), scenario)
    assert list(run.robots) == [1, 2]
    assert run.time[0] == 0.0 and run.time[-1] == pytest.approx(1.9, abs=0.11)
    # Robot 1 starts at (10, 0) along x, robot 2 at (0, 5) along y.
    # The other robots are as they were last heard, at most one message earlier.
    expected = [[11.0, 0.0, 0.0], [0.0, 6.0, np.pi / 2]]
    np.testing.assert_allclose(run.pose[-1], expected, atol=0.0501)
    np.testing.assert_allclose(run.pose[-1, 0], expected[0], atol=1e-9)
    np.testing.assert_array_equal(run.command[-1], [[0.5, 0.0], [0.5, 0.0]])


def test_requirements_of_speed_go_by_what_robots_measure(tmp_path):
    wanted = {"slow": "always(speed < 0.6 m/s)"}
    scenario = scenario_from_dict(
        dict(SCENARIO, odometry="wheel", requirements=wanted, record_rate=10)
    )
    run = read_bag(write(tmp_path / "run.bag", held_up=(20,)), scenario)
    moved = np.linalg.norm(np.diff(run.pose[:, 1, :2], axis=0), axis=1) / np.diff(run.time)
    assert moved.max() > 0.6  # which one difference says of late poses
    (slow,) = evaluated(None, run)
    assert slow["met"] and slow["margin"] == pytest.approx(0.1)


def test_what_a_joystick_did_before_the_start_is_no_part_of_the_run(tmp_path):
    path = write(tmp_path / "run.bag")
    with rosbag.Bag(path, "a") as bag:
        for moment, running in ((99.0, False), (101.45, True), (102.05, False)):
            bag.write(
                "/pioneer_control/status",
                ControlStatus(running=running),
                rospy.Time.from_sec(moment),
            )
    run = read_bag(path, scenario_from_dict(dict(SCENARIO, odometry="wheel")))
    # At 101.5 s: the controller was started 0.45 s after the robots were first commanded.
    np.testing.assert_allclose(run.pose[0, 0], [10.25, 0.0, 0.0], atol=0.0501)
    assert run.time[-1] == pytest.approx(1.5, abs=0.11)  # a stop ends nothing


@pytest.mark.parametrize("goes_on", [False, True])
def test_a_run_that_an_emergency_stop_ended_is_not_complete(tmp_path, goes_on):
    path = write(tmp_path / "run.bag")
    told = [(99.0, True, ""), (101.6, False, EMERGENCY), (102.5, goes_on, "" if goes_on else "no")]
    with rosbag.Bag(path, "a") as bag:
        for moment, running, trouble in told:
            status = ControlStatus(running=running, trouble=trouble)
            status.header.stamp = rospy.Time.from_sec(moment)
            bag.write("/pioneer_control/status", status, status.header.stamp)
    verdict = judge(read_bag(path, scenario_from_dict(SCENARIO)))
    assert verdict["ended"] == ("complete" if goes_on else "at 0.500 s emergency stop")
    checks = {check["name"]: check["passed"] for check in verdict["checks"]}
    assert checks["ended"] is goes_on


def test_odometry_that_is_late_at_times_is_all_there(tmp_path):
    scenario = scenario_from_dict(dict(SCENARIO, duration=1.5))
    run = read_bag(write(tmp_path / "run.bag", jitter=0.02), scenario)
    assert len(run.time) == 16 and np.diff(run.time).max() < 0.13
    # What nobody measured is not judged.
    assert run.meta["collisions_unknown"]
    checks = {check["name"]: check["passed"] for check in judge(run)["checks"]}
    assert checks["collisions"] is None and checks["ended"] is True


def test_odometry_of_the_common_frame_stays_as_it_is(tmp_path):
    run = read_bag(write(tmp_path / "run.bag"), scenario_from_dict(SCENARIO))
    np.testing.assert_allclose(run.pose[-1, :, 0], 1.0, atol=0.0501)


OLD_COMMAND = "uint32[] robot\nfloat64[] v\nfloat64[] omega\n"


def test_commands_for_all_of_earlier_versions_are_read(tmp_path):
    path = write(tmp_path / "run.bag")
    name = "mrs_simulator/TeamCommand"
    earlier = generate_dynamic(name, OLD_COMMAND)[name]
    assert earlier._md5sum != TeamCommand._md5sum
    with rosbag.Bag(path, "a") as bag:
        bag.write("/stage/command", earlier([1, 2], [0.5, 0.4], [0.0, 0.1]), rospy.Time(101))
    assert len(read_bag(path, scenario_from_dict(SCENARIO)).time) > 15
    with rosbag.Bag(path) as bag:
        _, message, _ = next(bag.read_messages(["/stage/command"]))
    assert np.isnan(read_answered(message)).all()


def test_degraded_timing_is_reported_of_a_bag_too(tmp_path):
    path = write(tmp_path / "run.bag")
    with rosbag.Bag(path, "a") as bag:
        for stamp, missed, periods in ((99.0, 500, 0), (101.1, 500, 100), (102.8, 520, 190)):
            status = StageStatus(robots=2, missed_periods=missed, command_periods=periods)
            status.header.stamp = rospy.Time.from_sec(stamp)
            bag.write("/stage/status", status, status.header.stamp)
    verdict = judge(read_bag(path, scenario_from_dict(SCENARIO)), claims=[])
    assert "timing was degraded: 22%" in verdict["reason"] and not verdict["passed"]


def test_what_is_no_bag_is_refused_by_name(tmp_path):
    (tmp_path / "text.bag").write_text("no bag")
    with pytest.raises(RunError, match="text.bag"):
        read_bag(str(tmp_path / "text.bag"))
    with rosbag.Bag(str(tmp_path / "empty.bag"), "w"):
        pass
    with pytest.raises(RunError, match="empty.bag"):
        read_bag(str(tmp_path / "empty.bag"))


def fly(path, rising):
    """Two robots whose odometry tells a height: robot 2 rises by ``rising`` [m] at each message."""
    with rosbag.Bag(str(path), "w") as bag:
        for step in range(11):
            stamp = rospy.Time.from_sec(1.0 + 0.1 * step)
            for robot in (1, 2):
                message, twist = Odometry(), Twist()
                message.header.stamp, twist.linear.x = stamp, 0.1
                message.pose.pose.position.z = 0.3 + (robot - 1) * rising * step
                message.pose.pose.orientation.w = 1.0
                message.twist.twist.linear.z = (robot - 1) * rising / 0.1
                bag.write("/robot{}/cmd_vel".format(robot), twist, stamp)
                bag.write("/robot{}/odom".format(robot), message, stamp)
    return str(path)


def test_robots_that_rise_are_read_in_space(tmp_path):
    scenario = scenario_from_dict(dict(SCENARIO, duration=0.8))
    run = read_bag(fly(tmp_path / "run.bag", 0.5), scenario)
    assert run.spatial.z[:, 0].tolist() == [0.3] * len(run.time)
    np.testing.assert_allclose(np.diff(run.spatial.z[:, 1]), 0.5)
    np.testing.assert_allclose(run.spatial.twist[1:, 1, 0], 5.0)
    # A driver that tells where the axle is does not make a robot fly.
    assert read_bag(fly(tmp_path / "low.bag", 0.0), scenario).spatial is None
