"""Commands over ROS answer the odometry of their own period, not the one before it."""

import numpy as np
import pytest
import rospy

from mrs_simulator.nodes.control.command_times import LATE, CommandTimes
from mrs_simulator.ros.message_forms.messages import team_odometry
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry
from mrs_simulator.ros.receive import odometry_inbox
from mrs_simulator.ros.receive.expected_odometry import NEVER, ExpectedOdometry
from mrs_simulator.ros.receive.odometry_inbox import Inbox, OdometryInbox, TeamInbox

PERIOD = 0.02  # [s]


class Team:
    """A control's inbox and times, with a clock of simulated time and one of wall time."""

    def __init__(self, inbox, n=2, period=PERIOD):
        self.inbox, self.wall, self.now = inbox(range(1, n + 1)), 0.0, 10.0
        self.rows = list(range(n))
        self.times = CommandTimes(period, lambda: self.wall)
        self.answered = []  # (time, stamps) of each command [s]

    def hears(self, stamp, rows=None):
        """Hear ``rows``, by default all, whose odometry is stamped ``stamp`` [s]."""
        rows = self.rows if rows is None else rows
        stamp = rospy.Time.from_sec(stamp)
        if isinstance(self.inbox, TeamInbox):
            numbers = [row + 1 for row in rows]
            self.inbox.put(team_odometry(numbers, np.zeros((len(rows), 3)), None, stamp))
        else:
            for row in rows:
                self.inbox.put(odometry(stamp), row)
        self.looks()

    def clock(self, now):
        self.now = now
        self.inbox.wake()
        self.looks()

    def looks(self):
        if self.times.take(self.now, lambda now: self.inbox.is_up_to_date(self.rows, now)):
            self.answered.append((round(self.now, 6), self.inbox.stamps().round(6).tolist()))

    def begins(self):
        """Take the first commands, in the usual order, and forget them."""
        for k in range(3):
            self.clock(10.0 + k * PERIOD)
            self.hears(10.0 + k * PERIOD)
        self.answered.clear()


def odometry(stamp):
    """Return a message of a robot's own topic, as it is received."""
    message = PlanarOdometry()
    message.stamp, message.frame, message.length = stamp, "odom", 1.0
    message.planar, message.body, message.z = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    message.lift = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    return message


@pytest.fixture(params=["each robot's topic", "the team's topic"])
def team_of(request, monkeypatch):
    """Return what makes a ``Team``."""
    monkeypatch.setattr(odometry_inbox.rospy, "Subscriber", lambda *_, **__: Topic)
    monkeypatch.setattr(odometry_inbox, "read", lambda _: "")
    kind = OdometryInbox if "each" in request.param else TeamInbox

    def make(**more):
        team = Team(kind, **more)
        monkeypatch.setattr(odometry_inbox.rospy, "get_time", lambda: team.now)
        return team

    return make


class Topic:
    resolved_name = "/odom"
    impl = type("Topic", (), {"add_connection": None})


def stamps(team):
    return [told[0] for _, told in team.answered]


def test_a_command_waits_for_the_odometry_of_its_time(team_of):
    team = team_of()
    team.begins()
    # After a disturbance several messages come at once, the clock first, and an odometry is left over.
    team.clock(10.08)
    team.hears(10.06)
    team.hears(10.08)
    for k in range(5, 30):
        team.clock(10.0 + k * PERIOD)
        team.wall += 0.001
        team.hears(10.0 + k * PERIOD)
        team.wall += 0.019
    assert team.times.missed == 1  # that of the disturbance
    assert team.answered == [(t, [t, t]) for t in np.round(10.0 + PERIOD * np.arange(4, 30), 6)]


def test_odometry_that_overtakes_the_clock_waits_for_it(team_of):
    team = team_of()
    team.begins()
    for k in range(3, 9):
        team.hears(10.0 + k * PERIOD)
        assert len(team.answered) == k - 3
        team.clock(10.0 + k * PERIOD)
        assert stamps(team)[-1] == pytest.approx(10.0 + k * PERIOD)


def test_every_robot_is_waited_for_but_not_for_ever(team_of):
    team = team_of()
    team.begins()
    team.clock(10.06)
    team.hears(10.06, [0])
    team.wall += LATE * PERIOD - 0.001
    team.looks()
    assert not team.answered
    team.wall += 0.002
    team.looks()
    assert team.answered == [(10.06, [10.06, 10.04])]
    team.clock(10.08)  # the next one is waited for as long
    assert len(team.answered) == 1
    team.hears(10.08)
    assert team.answered[1:] == [(10.08, [10.08, 10.08])]


def test_where_simulated_time_is_slow_it_is_waited_for_too(team_of):
    team = team_of()
    team.begins()
    for k in range(3, 9):
        team.wall += 10.0 * PERIOD
        team.clock(10.0 + k * PERIOD)
        team.hears(10.0 + k * PERIOD)
    assert stamps(team) == pytest.approx([10.0 + k * PERIOD for k in range(3, 9)])


@pytest.mark.parametrize(
    "gap, period", [(0.1, 0.02), (0.02, 0.1), (0.02, 0.033), (0.04, 0.02), (0.02, 0.02)]
)
def test_at_any_two_rates_commands_keep_theirs_with_the_newest_odometry(team_of, gap, period):
    team, made = team_of(period=period), []
    for k in range(400):
        now = 10.0 + 0.01 * k
        team.clock(now)
        if k % round(gap / 0.01) == 0:
            team.hears(now)
        assert team.wall == 0.0  # nothing that comes less often is waited for
        if len(team.answered) > len(made):
            made.append(now)
    settled = team.answered[-60:]
    periods = np.diff([now for now, _ in settled])
    assert abs(periods.mean() - period) < 0.002 and periods.max() < period + 0.0101
    ages = np.array([now - told[0] for now, told in settled])
    assert ages.min() > -1e-6 and ages.max() < gap - 0.0099


def test_robots_whose_odometry_comes_less_often_hold_up_none(team_of):
    team = team_of(n=3)
    team.inbox.set_periods([PERIOD, PERIOD, 5 * PERIOD], PERIOD)
    for k in range(60):
        team.clock(10.0 + k * PERIOD)
        team.hears(10.0 + k * PERIOD, [0, 1] + [2] * (k % 5 == 0))
        assert team.answered[-1][0] == pytest.approx(team.now)
    ages = np.array([np.subtract(now, told) for now, told in team.answered[-50:]])
    assert np.allclose(ages[:, :2], 0.0, atol=1e-6) and ages[:, 2].max() < 0.0801


def test_a_message_that_is_lost_does_not_make_the_next_one_early(team_of):
    team = team_of()
    team.begins()
    team.hears(10.08)  # 10.06 is lost
    team.clock(10.08)
    team.answered.clear()
    team.clock(10.10)
    assert not team.answered
    team.hears(10.10)
    assert stamps(team) == [10.1]


def test_a_stage_that_is_started_again_is_waited_for(team_of):
    team = team_of()
    team.begins()
    for k in range(3, 100):
        team.clock(10.0 + k * PERIOD)
        team.hears(10.0 + k * PERIOD)
    team.answered.clear()
    team.clock(10.0)
    assert not team.answered  # what is known is of the run before
    team.hears(10.0)
    for k in range(1, 5):
        team.clock(10.0 + k * PERIOD)
        team.hears(10.0 + k * PERIOD)
    assert stamps(team) == pytest.approx([10.0 + k * PERIOD for k in range(5)])
    assert team.times.missed == 0


def test_a_pause_changes_nothing(team_of):
    team = team_of()
    team.begins()
    for _ in range(50):
        team.wall += 0.05
        team.clock(10.04)
    assert not team.answered
    team.clock(10.06)
    team.hears(10.06)
    assert team.answered == [(10.06, [10.06, 10.06])]


def test_commands_left_out_are_missed_while_it_runs():
    times = CommandTimes(PERIOD)
    assert times.take(10.0) and not times.take(10.01) and times.take(10.02)
    assert times.take(10.1) and times.missed == 3
    assert times.take(10.2, running=False) and times.missed == 3
    times.forget()
    assert times.take(11.0) and times.missed == 3


def test_odometry_is_expected_by_the_stamps_before_it():
    told = np.full(3, NEVER)
    expected = ExpectedOdometry(told, 0.5)
    assert expected.missing([0, 1, 2], 10.0).tolist() == [0, 1, 2]
    for stamp in (10.0, 10.1, 10.2):
        nanoseconds = round(stamp * 1e9)
        expected.note(0, nanoseconds)
        expected.note_all(np.array([1, 2]), nanoseconds)
        told[:] = nanoseconds
    assert expected.missing([0, 1, 2], 10.28).tolist() == []
    assert expected.missing([0, 2], 10.3).tolist() == [0, 2]
    assert expected.missing([0], 10.2).tolist() == expected.missing([0], 9.8).tolist() == []
    assert expected.missing([0, 1], 9.6).tolist() == [0, 1]  # the clock went back


def test_only_what_is_waited_for_wakes_the_control():
    inbox = Inbox([1, 2, 3])

    def wakes(*rows):
        with inbox._changed:
            inbox._news = False
            inbox._note_arrival(rows)
        return inbox._news

    assert wakes(0)  # nobody has said what is waited for
    assert not inbox.is_up_to_date([0, 2], 10.0)
    assert not wakes(0) and not wakes(1) and wakes(2)
    assert not wakes(0)
    inbox.wake()
    assert inbox._news
