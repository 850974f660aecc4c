"""The arithmetic of fences, distances, jumps and speeds."""

import math

import numpy as np
import pytest

from mrs_simulator.control.guards import (
    JumpBounds,
    Repetition,
    Standstill,
    Tracks,
    Violations,
    body_motion,
    checked_fence,
    limited,
    outside,
    pairs_nearer,
    planar,
    slowed,
)
from mrs_simulator.core.kinematics import Limits, arc, compose, origins, ramp

POSE = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [3.0, 0.5, 2.0], [9.0, -1.0, 3.0]])
FENCE = (-1.0, -1.0, 5.0, 5.0)


def test_origins_undo_compose():
    draw = np.random.default_rng(1)
    common, pose = draw.uniform(-3.0, 3.0, (2, 50, 3))
    np.testing.assert_allclose(compose(origins(common, pose), pose), common, atol=1e-12)


def test_outside_the_fence():
    assert outside(POSE, FENCE) == [3]
    assert outside(POSE, None) == []
    assert outside(np.full((2, 3), np.nan), FENCE) == []


@pytest.mark.parametrize("fence", [(1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 1.0, 1.0)])
def test_a_fence_that_holds_nothing_is_refused(fence):
    with pytest.raises(ValueError, match="x_min < x_max"):
        checked_fence(fence)


def test_pairs_that_are_too_near():
    assert pairs_nearer(POSE, 1.0) == [(1, 2, 0.5)]
    assert pairs_nearer(POSE, 0.0) == []
    assert len(pairs_nearer(POSE, 100.0)) == 6
    assert pairs_nearer(np.array([[0.0, 0.0, 0.0], [np.nan] * 3]), 1.0) == []


def test_violations_stand_until_they_are_gone_and_released():
    guard = Violations((1, 2, 3, 4), FENCE, 1.0)
    assert guard.check(POSE) == [
        "robot2 stopped: 0.50 m from robot3",
        "robot3 stopped: 0.50 m from robot2",
        "robot4 stopped: outside the geofence at (9.00, -1.00)",
    ]
    assert guard.check(POSE) == []
    apart = POSE + np.array([[0.0, 0.0, 0.0]] * 2 + [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    assert guard.check(apart) == [] and sorted(guard.reasons) == [1, 2, 3]
    guard.release(apart)
    assert guard.text() == "robot4 stopped: outside the geofence at (9.00, -1.00)"


def test_two_reasons_are_both_said():
    guard = Violations((1, 2), (-1.0, -1.0, 0.2, 1.0), 1.0)
    guard.check(np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]]))
    assert "robot2 stopped: outside the geofence at (0.50, 0.00) and 0.50 m from" in guard.text()


def test_slowed_commands_keep_their_shape():
    command = np.array([[1.0, 0.5], [0.1, 0.0], [0.0, -4.0]])
    slow = slowed(command, 0.2, 1.0)
    np.testing.assert_allclose(slow, [[0.2, 0.1], [0.1, 0.0], [0.0, -1.0]])
    np.testing.assert_array_equal(slowed(command, 0.2, 1.0, "none"), slow)
    np.testing.assert_allclose(slowed(command, 0.2, 1.0, "team"), command / 5.0)
    np.testing.assert_array_equal(slowed(command, math.inf, math.inf), command)
    # Each robot its own: the second slower than asked for, the third not.
    tops = np.array([1.0, 0.05, 0.2]), np.array([math.inf, 1.0, 8.0])
    expected = [[1.0, 0.5], [0.05, 0.0], [0.0, -4.0]]
    np.testing.assert_allclose(slowed(command, *tops), expected)
    np.testing.assert_allclose(slowed(command, *tops, scope="team"), command / 2.0)


def test_limits_are_only_lowered():
    limits = Limits(0.75, 1.7, 0.3, 1.7)
    assert limited(limits, v_max=0.2) == limits._replace(v_max=0.2)
    assert limited(limits, v_max=2.0, omega_max=1.0) == limits._replace(omega_max=1.0)


BOUNDS = JumpBounds(slack=0.3, v_max=1.0, omega_max=1.0, longest=1.1, silence=0.5)


@pytest.mark.parametrize(
    "before, after, dt, jumps",
    [
        ((0, 0, 0), (0.44, 0, 0), 0.1, False),
        ((0, 0, 0), (0.46, 0, 0), 0.1, True),
        ((0, 0, 3.1), (0, 0, -3.1), 0.1, False),
        ((0, 0, 0), (0, 0, 0.46), 0.1, True),
        ((5, 0, 0), (3.2, 0, 0), 60.0, False),
        ((5, 0, 0), (3.0, 0, 0), 60.0, True),  # nobody drives for ever without being heard
        ((0.1, 0, 0), (0, 0, 0), 0.6, True),  # back at the origin after a silence: begun anew
        ((0.1, 0, 0), (0, 0, 0), 0.1, False),
        ((0.01, 0, 0), (0, 0, 0), 0.6, False),
        ((0, 0, 0.1), (0, 0, 0), 0.6, True),
    ],
)
def test_jumps(before, after, dt, jumps):
    assert bool(BOUNDS.exceeded(before, after, dt)) is jumps


def test_a_jump_is_not_followed_until_it_is_accepted():
    tracks = Tracks(2, [BOUNDS] * 2)
    for t in range(5):
        tracks.take(0, (0.1 * t, 0.0, 0.0), (0.1 * t, 0.1 * t))
    tracks.take(0, (5.0, 0.0, 0.0), (0.5, 0.5))
    tracks.take(0, (5.1, 0.0, 0.0), (0.6, 0.6))
    assert tracks.jumps == {0: "jumped by 4.60 m and 0.00 rad within 0.10 s"}
    np.testing.assert_allclose(tracks.pose[0], (0.4, 0.0, 0.0))
    assert np.isnan(tracks.pose[1]).all()
    tracks.accept()
    tracks.take(0, (5.2, 0.0, 0.0), (0.7, 0.7))
    np.testing.assert_allclose(tracks.pose[0], (5.2, 0.0, 0.0))
    np.testing.assert_allclose(tracks.first[0], (5.1, 0.0, 0.0))
    assert tracks.jumps == {}


def test_a_burst_after_a_stall_is_no_jump():
    tracks = Tracks(1, [BOUNDS])
    tracks.take(0, (0.0, 0.0, 0.0), (0.0, 0.0))
    tracks.take(0, (0.8, 0.0, 0.0), (0.001, 0.8))
    assert tracks.jumps == {}


def test_without_bounds_every_pose_is_believed():
    tracks = Tracks(1)
    tracks.take(0, (0.0, 0.0, 0.0), (0.0, 0.0))
    tracks.take(0, (80.0, 0.0, 0.0), (0.001, 0.8))
    assert tracks.jumps == {} and tracks.pose[0, 0] == 80.0


def test_bounds_are_each_robots_own():
    tracks = Tracks(2, [None, BOUNDS])
    for t, x in ((0.0, 0.0), (0.1, 5.0)):
        for row in (0, 1):
            tracks.take(row, (x, 0.0, 0.0), (t, t))
    assert list(tracks.jumps) == [1] and tracks.pose[:, 0].tolist() == [5.0, 0.0]


def test_the_motion_of_the_body():
    before = np.array([[1.0, 2.0, 0.5 * math.pi], [0.0, 0.0, 3.1], [0.0, 0.0, 0.0]])
    after = np.array([[1.0, 1.5, 0.5 * math.pi], [0.0, 0.0, -3.1], [0.0, 0.4, 0.0]])
    expected = [[-0.5, 0.0], [0.0, 2.0 * math.pi - 6.2], [0.0, 0.0]]
    np.testing.assert_allclose(body_motion(before, after)[:, [0, 2]], expected, atol=1e-12)
    np.testing.assert_allclose(body_motion(before, after)[:, 1], [0.0, 0.0, 0.4], atol=1e-12)


def when_stuck(told, done, patience=2.0, seconds=10.0, odometry=0.1, period=0.05):
    """Return when [s] each robot was first found stuck, ``inf`` if never.

    ``told`` and ``done``: the commands and the twists in force from time t on, (n, 2).
    """
    pose = np.zeros((len(told(0.0)), 3))
    guard = Standstill(np.full(len(pose), patience))
    found, heard, next_odometry = np.full(len(pose), math.inf), pose, 0.0
    for step in range(int(round(seconds / period))):
        t = step * period
        if t >= next_odometry - 1e-9:
            heard, next_odometry = pose, next_odometry + odometry
        command = told(t - period) if step else np.zeros_like(told(0.0))
        rows = guard.stuck(t, heard, command)
        found[rows] = np.minimum(found[rows], t)
        pose = arc(pose, done(t), period)
    return found


STANDS, CREEPS = np.zeros(2), np.array([0.03, 0.0])


def test_who_is_commanded_to_move_and_does_not_is_found():
    told = np.array([[0.3, 0.0], [0.0, 0.5], [-0.3, 0.2], [0.3, 0.0], [0.04, 0.05], [0.3, 0.0]])
    done = np.array([STANDS, STANDS, STANDS, CREEPS, STANDS, [0.0, 1.0]])  # the last turns instead
    found = when_stuck(lambda t: told, lambda t: done)
    np.testing.assert_allclose(found, [2.05, 2.05, 2.05, 2.05, math.inf, 2.05], atol=0.06)
    assert (when_stuck(lambda t: told, lambda t: done, patience=math.inf) == math.inf).all()


def test_who_stops_on_the_way_is_found_after_the_patience():
    told = np.array([[0.3, 0.0]])
    found = when_stuck(lambda t: told, lambda t: told if t < 4.0 else np.zeros((1, 2)))
    assert 6.0 < found[0] < 7.2  # the average has forgotten the drive after 0.8 s


def test_who_moves_however_badly_is_left_alone():
    def told(t):
        v = 0.75 if t < 5.0 else -0.75  # turns about on the way: its ramp takes 5 s
        return np.array([[v, 0.0], [0.3, 1.5 * math.cos(9.0 * t)], [0.06, 1.7], [0.2, 0.0]])

    reached = {0.0: np.zeros((4, 2))}

    def done(t):
        """Return what ramps, a blocked turn, a blocked drive and a quarter of the speed leave."""
        velocity, _ = ramp(reached[0.0], told(t), np.array([0.3, 1.7]), 0.05)
        reached[0.0] = velocity
        return velocity * [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.3, 1.0]]

    assert (when_stuck(told, done) == math.inf).all()


def test_nothing_is_known_of_a_long_gap_and_of_the_time_before_a_release():
    guard, told, pose = Standstill([2.0]), np.array([[0.3, 0.0]]), np.zeros((1, 3))
    for t in (0.0, 0.9, 1.8):
        assert guard.stuck(t, pose, told) == []
    assert guard.stuck(30.0, pose, told) == []
    guard.forget()
    for t in (30.1, 31.0, 31.9):
        assert guard.stuck(t, pose, told) == []
    assert guard.stuck(32.2, pose, told) == [0]
    assert guard.stuck(1.0, pose, told) == []  # another simulator's clock


def test_other_causes_join_and_are_gone_when_released():
    guard = Violations((1, 2), FENCE)
    assert guard.check(POSE[:2], {1: "stuck"}) == ["robot2 stopped: stuck"]
    assert guard.check(POSE[:2], {1: "stuck"}) == []
    guard.release(POSE[:2])
    assert guard.reasons == {}


def repeated(command, seconds=2.0, patience=0.5, period=0.05, changes=()):
    """Return when a robot told ``command(t)`` that changes at the times ``changes`` is found frozen."""
    watch, changed = Repetition([patience]), -math.inf
    for step in range(int(round(seconds / period)) + 1):
        now = round(step * period, 9)
        changed = max([t for t in changes if t <= now], default=changed)
        told = np.array([command(now - period)])  # in force until now
        if watch.frozen(now, np.array([changed]), told):
            return now
    return None


@pytest.mark.parametrize(
    "v, omega, found",
    [
        (0.75, 0.0, 0.5),
        (-0.3, 0.0, 0.5),
        (0.041, 0.0, 0.5),
        (0.039, 0.0, None),  # 20 mm in half a second
        (0.0, math.radians(5.0), 0.5),
        (0.0, math.radians(3.0), None),
        (0.0004, 0.0, None),  # which the driver rounds to nothing
    ],
)
def test_odometry_that_repeats_itself_is_a_lost_link(v, omega, found):
    assert repeated(lambda t: (v, omega)) == (found and pytest.approx(found + 0.05, abs=0.06))


def test_a_robot_that_rested_has_its_time_to_move():
    def late(t):
        return (0.75 if t >= 1.0 else 0.0, 0.0)

    assert repeated(late) == pytest.approx(1.5, abs=0.11)
    assert repeated(late, changes=[1.2, 1.3, 1.6, 1.9]) is None
    assert repeated(late, seconds=3.0, changes=[1.2, 1.3]) == pytest.approx(1.8, abs=0.06)


def test_commands_with_pauses_do_not_hide_a_lost_link():
    assert repeated(lambda t: (0.4 if round(t / 0.05) % 2 else 0.0, 0.0)) is not None
    assert repeated(lambda t: (0.75, 0.0), patience=math.inf) is None


BASE = ("linear.x", "linear.y", "angular.z")


@pytest.mark.parametrize("moves", [True, False])
def test_a_base_that_is_commanded_to_go_sideways_is_stuck_only_where_it_does_not(moves):
    guard, told, pose = Standstill([2.0]), np.array([[0.0, 0.3, 0.0]]), np.zeros((1, 3))
    found = []
    for step in range(100):
        found += guard.stuck(0.05 * step, pose, told)
        pose = pose + [0.0, 0.3 * 0.05 * moves, 0.0]
    assert bool(found) is not moves


def test_a_base_is_slowed_along_its_direction():
    slow = slowed(np.array([[0.3, 0.4, 0.1]]), 0.25, 1.0, axes=BASE)
    np.testing.assert_allclose(slow, [[0.15, 0.2, 0.05]])


AIR = ("linear.x", "linear.y", "linear.z", "angular.z")
ABOVE = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 3.0], [0.3, 0.0, 0.0, 3.4]])


def test_robots_above_each_other_are_as_far_apart_as_they_are():
    assert pairs_nearer(ABOVE, 1.0) == [(1, 2, pytest.approx(0.5))]
    guard = Violations((1, 2, 3), min_distance=1.0)
    assert guard.check(ABOVE) == [
        "robot2 stopped: 0.50 m from robot3",
        "robot3 stopped: 0.50 m from robot2",
    ]
    many = np.column_stack([np.zeros((100, 3)), np.arange(100.0)])  # enough for the grid
    assert pairs_nearer(many, 1.1)[0] == (0, 1, 1.0) and len(pairs_nearer(many, 1.1)) == 99


def test_a_climb_is_slowed_as_any_other_speed():
    slow = slowed(np.array([[0.0, 0.3, 0.4, 0.1]]), 0.25, 1.0, axes=AIR)
    np.testing.assert_allclose(slow, [[0.0, 0.15, 0.2, 0.05]])
    assert slowed(np.array([[0.0, 0.0, -1.0, 0.0]]), 0.25, 1.0, axes=AIR)[0, 2] == -0.25


@pytest.mark.parametrize("climb", [0.3, -0.3])
@pytest.mark.parametrize("moves", [True, False])
def test_a_robot_commanded_to_climb_is_stuck_only_where_it_does_not(climb, moves):
    told = planar(np.array([[0.0, 0.0, climb, 0.0]]), AIR)
    guard, watch, pose = Standstill([2.0]), Repetition([0.5]), np.array([[0.0, 0.0, 0.0, 5.0]])
    found, frozen, changed = [], [], 0.0
    for step in range(100):
        now = 0.05 * step
        found += guard.stuck(now, pose, told)
        frozen += watch.frozen(now, np.array([changed]), told)
        pose = pose + [0.0, 0.0, 0.0, 0.05 * climb * moves]
        changed = now if moves else changed
    assert bool(found) is bool(frozen) is not moves


def test_a_jump_up_is_a_jump():
    tracks = Tracks(1, [BOUNDS])
    for t in range(5):
        tracks.take(0, (0.0, 0.0, 0.0), (0.1 * t, 0.1 * t), 1.0 + 0.05 * t)
    assert tracks.jumps == {}
    tracks.take(0, (0.0, 0.0, 0.0), (0.5, 0.5), 4.2)
    assert tracks.jumps == {0: "jumped by 3.00 m and 0.00 rad within 0.10 s"}
    tracks.accept()
    tracks.take_all(np.array([0]), np.zeros((1, 3)), (0.6, 0.6), np.array([0.0]))
    assert "4.20 m" in tracks.jumps[0]
