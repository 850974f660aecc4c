"""The arithmetic of fences, distances, jumps and speeds."""

import math

import numpy as np
import pytest

from mrs_simulator.core.guards import (
    JumpBounds,
    Tracks,
    Violations,
    checked_fence,
    limited,
    outside,
    pairs_nearer,
    slowed,
)
from mrs_simulator.core.kinematics import Limits, compose, origins

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
    tracks = Tracks(2, BOUNDS)
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
    tracks = Tracks(1, BOUNDS)
    tracks.take(0, (0.0, 0.0, 0.0), (0.0, 0.0))
    tracks.take(0, (0.8, 0.0, 0.0), (0.001, 0.8))
    assert tracks.jumps == {}


def test_without_bounds_every_pose_is_believed():
    tracks = Tracks(1)
    tracks.take(0, (0.0, 0.0, 0.0), (0.0, 0.0))
    tracks.take(0, (80.0, 0.0, 0.0), (0.001, 0.8))
    assert tracks.jumps == {} and tracks.pose[0, 0] == 80.0
