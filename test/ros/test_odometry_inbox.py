"""Odometry that overtakes /clock is waited for; one from another time is refused."""

from unittest import mock

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import TransformStamped

from mrs_simulator.core.spatial import Spatial
from mrs_simulator.nodes.control.tf_inbox import TransformInbox
from mrs_simulator.ros.message_forms.messages import team_odometry
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry
from mrs_simulator.ros.receive import odometry_inbox

POSES = np.array([[1.0, 2.0, 0.3], [4.0, 5.0, -0.6]])
TWISTS = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
LEVEL = (0.0, 0.0, 0.0, 1.0)
MORE = np.array([[0.7, 0.8, 0.9], [1.0, 1.1, 1.2]])  # vz, wx, wy
IN_2096 = 3976214400.0  # [s]


def odometry(row, stamp, z):
    """Return what the robot of ``row`` tells, ``z`` [m] high, as it is received."""
    message = PlanarOdometry()
    message.stamp, message.frame, message.length = stamp, "odom", 1.0
    message.planar, message.body = tuple(POSES[row]), tuple(TWISTS[row])
    message.z, message.lift = z, (z, *LEVEL, *MORE[row])
    return message


class Clock:
    """Simulated time, which goes on by ``step`` [s] at each look."""

    def __init__(self, now, step):
        self.now, self.step = now, step

    def __call__(self):
        self.now += self.step
        return self.now


@pytest.fixture(params=["each robot's topic", "the team's topic"])
def hear(request, monkeypatch):
    """Return a function that hears robots 1 and 2 at ``stamp`` under ``clock``, and ``z`` high.

    It returns the inbox, which waits for a late clock for ``patience`` [s].
    """
    monkeypatch.setattr(odometry_inbox.rospy, "Subscriber", mock.MagicMock())
    monkeypatch.setattr(odometry_inbox.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(odometry_inbox, "read", lambda _: "")
    monkeypatch.setattr(odometry_inbox.OdometryInbox, "doubled", dict)

    def by_robots(stamp, z):
        inbox = odometry_inbox.OdometryInbox([1, 2], topic="/robot{}/odom")
        for row in (0, 1):
            inbox.put(odometry(row, rospy.Time.from_sec(stamp), z[row]), row)
        return inbox

    def by_team(stamp, z):
        inbox = odometry_inbox.TeamInbox([1, 2])
        inbox._subscriber = type("Topic", (), {"resolved_name": "/stage/odometry"})
        level = Spatial(np.array(z), np.tile(LEVEL, (2, 1)), MORE)
        inbox.put(team_odometry([1, 2], POSES, TWISTS, rospy.Time.from_sec(stamp), level))
        return inbox

    def heard(stamp, clock, z=(0.0, 0.0), patience=0.05):
        monkeypatch.setattr(odometry_inbox, "CLOCK_PATIENCE", patience)
        monkeypatch.setattr(odometry_inbox.rospy, "get_time", clock)
        return (by_robots if "each" in request.param else by_team)(stamp, z)

    return heard


def test_odometry_waits_for_a_clock_that_is_late(hear):
    # At 5 times real time and more, 0.1 s of wall time without the clock's thread are 0.5 s.
    inbox = hear(11.0, Clock(10.0, 0.1), patience=60.0)  # this clock comes to it
    assert inbox.refused() == ([0, 0], {})
    np.testing.assert_array_equal(inbox.pose(), POSES)


def test_odometry_from_the_time_of_the_clock_is_not_waited_for(hear):
    clock = Clock(10.0, 0.0)
    inbox = hear(10.49, clock)
    assert inbox.refused() == ([0, 0], {})
    np.testing.assert_array_equal(inbox.pose(), POSES)


def test_odometry_tells_twist_and_what_leaves_the_plane(hear):
    inbox = hear(10.0, Clock(10.0, 0.0), z=(1.5, 2.5))
    np.testing.assert_array_equal(inbox.twists(), TWISTS)
    z, orientation, twist = inbox.spatial()
    assert z.tolist() == [1.5, 2.5] and orientation.tolist() == [list(LEVEL)] * 2
    np.testing.assert_array_equal(twist, MORE)


@pytest.mark.parametrize("stamp", [11.0, IN_2096])
def test_a_stamp_that_the_clock_does_not_come_to_is_refused(hear, stamp):
    inbox = hear(stamp, Clock(10.0, 0.0))
    counts, reasons = inbox.refused()
    assert counts == [1, 1] and np.isnan(inbox.pose()).all()
    assert all("after the simulated time" in reasons[number] for number in (1, 2))


def test_without_a_clock_nothing_is_waited_for(hear):
    np.testing.assert_array_equal(hear(11.0, Clock(0.0, 0.0)).pose(), POSES)


@pytest.mark.parametrize("z", [np.nan, -1e9])
def test_a_height_that_cannot_be_is_refused(hear, z):
    inbox = hear(10.0, Clock(10.0, 0.0), (z, 1.5))
    counts, reasons = inbox.refused()
    assert counts == [1, 0] and "height" in reasons[1]
    assert np.isnan(inbox.pose()[0]).all() and inbox.heights()[1] == 1.5


@pytest.mark.parametrize("twists", ["TWISTS", "MORE"])  # in the plane, and out of it
def test_a_twist_that_is_not_finite_is_refused_by_name(hear, monkeypatch, twists):
    wrong = globals()[twists].astype(float).copy()
    wrong[0, 0] = np.nan
    monkeypatch.setitem(globals(), twists, wrong)
    inbox = hear(10.0, Clock(10.0, 0.0), (1.5, 1.5))
    counts, reasons = inbox.refused()
    assert counts == [1, 0] and "its twist is not finite: (" in reasons[1]
    assert np.isnan(inbox.pose()[0]).all() and np.isfinite(inbox.twists()).all()


def test_who_climbs_straight_up_does_not_repeat_itself(hear, monkeypatch):
    seconds = iter(np.arange(100.0))
    monkeypatch.setattr(odometry_inbox.time, "monotonic", lambda: next(seconds))
    inbox = hear(10.0, Clock(10.0, 0.0), (1.0, 2.0))
    before = inbox.changed.copy()
    team = isinstance(inbox, odometry_inbox.TeamInbox)
    for row in (0, 1):
        if not team:
            inbox.put(odometry(row, rospy.Time(10), (1.1, 2.0)[row]), row)
    if team:
        level = Spatial(
            np.array([1.1, 2.0]), np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)), np.zeros((2, 3))
        )
        inbox.put(team_odometry([1, 2], POSES, None, rospy.Time(10), level))
    assert ((inbox.changed > before) == [True, False]).all()


def test_transforms_tell_heights():
    inbox = TransformInbox.__new__(TransformInbox)
    odometry_inbox.Inbox.__init__(inbox, [1])
    found = TransformStamped()  # without a stamp: a static one
    found.transform.translation.z, found.transform.rotation.w = 1.5, 1.0
    inbox._take(0, found, 0.0)
    assert inbox.heights() == [1.5]
    found.transform.translation.z = float("nan")
    inbox._take(0, found, 0.0)
    assert inbox.heights() == [1.5] and inbox.intake.refused == [1]


JOINTS = np.array([[0.1, 0.2], [0.3, 0.4]])


@pytest.fixture
def team_inbox(monkeypatch):
    monkeypatch.setattr(odometry_inbox.rospy, "Subscriber", mock.MagicMock())
    monkeypatch.setattr(odometry_inbox.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(odometry_inbox.rospy, "get_time", Clock(10.0, 0.0))
    inbox = odometry_inbox.TeamInbox([1, 2])
    inbox._subscriber = type("Topic", (), {"resolved_name": "/stage/odometry"})
    inbox.put(with_joints(10.0, JOINTS))
    return inbox


def with_joints(stamp, joints, numbers=(1, 2), poses=POSES):
    stamp = rospy.Time.from_sec(stamp)
    return team_odometry(numbers, np.array(poses), TWISTS, stamp, joints=np.array(joints))


def test_joints_are_those_of_the_robots_by_their_numbers(team_inbox):
    np.testing.assert_array_equal(team_inbox.joints, JOINTS)
    team_inbox.put(with_joints(10.1, JOINTS[::-1], (2, 1)))
    np.testing.assert_array_equal(team_inbox.joints, JOINTS)


def test_joints_of_a_refused_message_are_not_taken(team_inbox):
    team_inbox.put(with_joints(5.0, JOINTS + 1.0))
    np.testing.assert_array_equal(team_inbox.joints, JOINTS)
    counts, reasons = team_inbox.refused()
    assert counts == [1, 1] and "before the simulated time" in reasons[1]


@pytest.mark.parametrize("field", ["joint", "theta"])
def test_a_robot_with_a_joint_or_heading_that_is_not_finite_is_refused(team_inbox, field):
    message = with_joints(10.1, JOINTS + 1.0)
    getattr(message, field)[-1] = np.nan
    team_inbox.put(message)
    np.testing.assert_array_equal(team_inbox.joints, [JOINTS[0] + 1.0, JOINTS[1]])
    counts, reasons = team_inbox.refused()
    assert counts == [0, 1] and "not finite" in reasons[2]


def test_a_malformed_message_of_the_team_is_refused_and_counted(team_inbox):
    message = with_joints(10.1, JOINTS)
    message.joint = [0.0] * 3
    team_inbox.put(message)
    counts, reasons = team_inbox.refused()
    assert counts == [1, 1] and "2 robots, 3 joint" in reasons[1]
