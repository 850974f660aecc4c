"""Odometry that overtakes /clock is waited for; one from another time is refused."""

import numpy as np
import pytest
import rospy

from mrs_simulator.ros import odometry_inbox
from mrs_simulator.ros.messages import team_odometry
from mrs_simulator.ros.planar_messages import PlanarOdometry

POSES = np.array([[1.0, 2.0, 0.3], [4.0, 5.0, -0.6]])
IN_2096 = 3976214400.0  # [s]


class Clock:
    """Simulated time, which goes on by ``step`` [s] at each look."""

    def __init__(self, now, step):
        self.now, self.step = now, step

    def __call__(self):
        self.now += self.step
        return self.now


@pytest.fixture(params=["each robot's topic", "the team's topic"])
def hear(request, monkeypatch):
    """Return a function that hears robots 1 and 2 at ``stamp`` under ``clock``; it returns the inbox."""
    monkeypatch.setattr(odometry_inbox, "CLOCK_PATIENCE", 0.05)
    monkeypatch.setattr(odometry_inbox.rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(odometry_inbox.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(odometry_inbox, "read", lambda _: "")
    monkeypatch.setattr(odometry_inbox.OdometryInbox, "doubled", dict)

    def by_robots(stamp):
        inbox = odometry_inbox.OdometryInbox([1, 2], topic="/robot{}/odom")
        for row, pose in enumerate(POSES.tolist()):
            message = PlanarOdometry()
            message.stamp, message.frame, message.length = rospy.Time.from_sec(stamp), "odom", 1.0
            message.planar, message.body, message.z = tuple(pose), (0.0, 0.0, 0.0), 0.0
            inbox.put(message, row)
        return inbox

    def by_team(stamp):
        inbox = odometry_inbox.TeamInbox([1, 2])
        inbox._subscriber = type("Topic", (), {"resolved_name": "/stage/odometry"})
        inbox.put(team_odometry([1, 2], POSES, stamp=rospy.Time.from_sec(stamp)))
        return inbox

    def heard(stamp, clock):
        monkeypatch.setattr(odometry_inbox.rospy, "get_time", clock)
        return (by_robots if "each" in request.param else by_team)(stamp)

    return heard


def test_odometry_waits_for_a_clock_that_is_late(hear):
    # At 5 times real time and more, 0.1 s of wall time without the clock's thread are 0.5 s.
    inbox = hear(11.0, Clock(10.0, 0.1))
    assert inbox.refused() == ([0, 0], {})
    np.testing.assert_array_equal(inbox.pose(), POSES)


def test_odometry_from_the_time_of_the_clock_is_not_waited_for(hear):
    clock = Clock(10.0, 0.0)
    inbox = hear(10.49, clock)
    assert inbox.refused() == ([0, 0], {})
    np.testing.assert_array_equal(inbox.pose(), POSES)


@pytest.mark.parametrize("stamp", [11.0, IN_2096])
def test_a_stamp_that_the_clock_does_not_come_to_is_refused(hear, stamp):
    inbox = hear(stamp, Clock(10.0, 0.0))
    counts, reasons = inbox.refused()
    assert counts == [1, 1] and np.isnan(inbox.pose()).all()
    assert all("after the simulated time" in reasons[number] for number in (1, 2))


def test_without_a_clock_nothing_is_waited_for(hear):
    np.testing.assert_array_equal(hear(11.0, Clock(0.0, 0.0)).pose(), POSES)
