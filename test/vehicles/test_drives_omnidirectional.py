"""Omnidirectional bases: wheel speeds, limits, exact motion and odometry, with typed-out numbers."""

import numpy as np
import pytest

from mrs_simulator.core.kinematics import Limits, cos_sin, displaced, ramp
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.vehicles.drives import omnidirectional as omni
from mrs_simulator.vehicles.limits import AxisLimits

ANGLES = np.radians([60.0, 180.0, 300.0])
SMALL = 1e-12


def row(*values):
    return np.array([values])


def numbers(rolling, rim_max=np.inf):
    rolling = np.concatenate([rolling, np.zeros((4 - len(rolling), 3))])
    return omni.OmnidirectionalParameters(rolling, np.linalg.pinv(rolling), rim_max)


THREE = numbers(omni.omni_wheels(ANGLES, 0.175))  # Robotino 3
FOUR = numbers(omni.mecanum_wheels(0.47, 0.30))  # youBot


def top_speed_along(direction, numbers):
    """Return the greatest speed, (m,) [m/s], that the rims allow in ``direction`` (m,) [rad] of the
    body, not turning."""
    cos, sin = cos_sin(direction)
    along = np.stack([cos, sin, np.zeros_like(cos)], axis=-1)
    return numbers.rim_max / np.abs(omni.rim_speeds(along, None, numbers)).max(axis=1)


def rims(twist, of):
    return omni.rim_speeds(twist, None, of)


def test_three_omni_wheels_drive_counter_clockwise():
    # Straight ahead the two front wheels run at sin 60 deg, one against the other; the rear one rolls.
    np.testing.assert_allclose(
        rims(row(1.0, 0.0, 0.0), THREE), row(-0.8660254, 0.0, 0.8660254, 0.0), atol=1e-7
    )
    np.testing.assert_allclose(
        rims(row(0.0, 1.0, 0.0), THREE), row(0.5, -1.0, 0.5, 0.0), atol=SMALL
    )
    np.testing.assert_allclose(rims(row(0.0, 0.0, 2.0), THREE), row(0.35, 0.35, 0.35, 0.0))


def test_the_sum_of_three_rim_speeds_is_that_of_turning():
    twists = np.random.default_rng(1).normal(size=(20, 3))
    np.testing.assert_allclose(
        rims(twists, THREE).sum(axis=1), 3.0 * 0.175 * twists[:, 2], atol=SMALL
    )


@pytest.mark.parametrize(
    "twist, wheels",
    [
        ((0.5, 0.0, 0.0), (10.526316, 10.526316, 10.526316, 10.526316)),
        ((0.0, 0.5, 0.0), (-10.526316, 10.526316, 10.526316, -10.526316)),
        ((0.0, 0.0, 1.0), (-8.105263, 8.105263, -8.105263, 8.105263)),
    ],
)
def test_four_mecanum_wheels_turn_as_worked_out_by_hand(twist, wheels):
    np.testing.assert_allclose(rims(row(*twist), FOUR) / 0.0475, row(*wheels), rtol=1e-6)


def test_the_body_twist_is_recovered_from_the_wheels_of_a_mixed_group():
    both = omni.OmnidirectionalParameters(
        *(np.array([getattr(n, key) for n in (THREE, FOUR)]) for key in omni.COLUMNS)
    )
    twists = np.array([[0.3, -0.2, 0.7], [-0.1, 0.4, -0.9]])
    turning = rims(twists, both)
    assert turning[0, 3] == 0.0  # the fourth wheel of a base with three
    np.testing.assert_allclose(omni.body_twist(turning, both), twists, atol=SMALL)


def test_the_residual_shows_a_wheel_that_slips():
    turning = rims(row(0.3, -0.2, 0.7), FOUR)
    np.testing.assert_allclose(omni.residual(turning, FOUR), 0.0, atol=SMALL)
    turning[0, 0] += 0.04  # front left spins
    np.testing.assert_allclose(
        omni.residual(turning, FOUR), row(0.01, 0.01, -0.01, -0.01), atol=SMALL
    )


def test_the_rims_decide_the_top_speed_in_each_direction():
    # 3000 rpm over a gear of 32 at a radius of 0.06 m; best between two wheels' axes, at 1/cos 30 deg.
    rim = 3000.0 / 60.0 * 2.0 * np.pi / 32.0 * 0.060
    assert rim == pytest.approx(0.589049, abs=1e-6)
    speeds = top_speed_along(
        np.array([0.0, 0.5 * np.pi, *np.linspace(0.0, 6.28, 200)]), THREE._replace(rim_max=rim)
    )
    assert speeds[:2].tolist() == pytest.approx([0.680175, 0.589049], abs=1e-6)
    assert speeds.max() <= speeds[0] + SMALL
    assert speeds.min() >= speeds[1] - SMALL


def test_a_command_beyond_the_rims_is_slowed_along_its_direction():
    top, base = np.array([1.0, 1.0, 9.0]), THREE._replace(rim_max=0.5)
    wanted = row(0.0, 0.8, -0.4)  # rims 0.33, -0.87, 0.33
    limited = omni.limited(wanted, top, base)
    np.testing.assert_allclose(limited, wanted * 0.5 / 0.87)
    assert np.abs(rims(limited, base)).max() == pytest.approx(0.5)
    factor = np.maximum(omni.excess(wanted, None, base, 0.02), np.abs(wanted / top).max())
    assert factor[0] == pytest.approx(0.87 / 0.5)
    np.testing.assert_allclose(wanted / factor, limited)
    assert omni.excess(limited, None, base, 0.02)[0] == pytest.approx(1.0)
    np.testing.assert_array_equal(omni.limited(wanted, top, omni.unlimited(base)), wanted)


@pytest.mark.parametrize("name", ["robotino3", "youbot"])
def test_far_within_limits_no_rim_needs_a_look(name, monkeypatch):
    base, draw = kind(name).numbers, np.random.default_rng(1)
    fastest = draw.choice([-1.0, 1.0], (64, 3)) * np.nextafter(base.easy, 0.0)
    assert 0.99 < np.abs(rims(fastest, base)).max() / base.rim_max < 1.0
    careful = base._replace(easy=0.0)
    for command in (fastest, 1.1 * fastest):
        factor = np.maximum(omni.excess(command, None, base, 0.02), 1.0)
        np.testing.assert_array_equal(
            factor, np.maximum(omni.excess(command, None, careful, 0.02), 1.0)
        )
        limited = [omni.limited(command, np.full(3, np.inf), each) for each in (base, careful)]
        np.testing.assert_array_equal(*limited)
    monkeypatch.setattr(omni, "_fastest", None)
    np.testing.assert_array_equal(omni.limited(fastest, np.full(3, np.inf), base), fastest)


def test_an_axis_has_a_limit_of_its_own():
    top, base = np.array([0.2, 1.0, 9.0]), THREE._replace(rim_max=10.0)
    np.testing.assert_allclose(omni.limited(row(-0.4, 0.3, 0.0), top, base), row(-0.2, 0.3, 0.0))
    team = Team(("robotino3",), Limits(0.2, 9.0, np.inf, np.inf))
    assert team.excess(row(-0.4, 0.1, 0.0), np.zeros(1), 0.02)[0] == pytest.approx(2.0)


def test_a_held_twist_moves_along_its_circle():
    # A quarter turn at 0.5 m/s to the left and 0.5 rad/s: the circle's centre is 1 m behind.
    after = displaced(row(0.0, 0.0, 0.0), row(0.0, 0.5, 0.5), np.pi)
    np.testing.assert_allclose(after, row(-1.0, 1.0, 0.5 * np.pi), atol=SMALL)
    half = displaced(row(0.3, 0.1, 1.9), row(0.3, -0.2, 0.8), 0.35)
    half = displaced(half, row(0.3, -0.2, 0.8), 0.35)
    whole = displaced(row(0.3, 0.1, 1.9), row(0.3, -0.2, 0.8), 0.7)
    np.testing.assert_allclose(half, whole, atol=1e-14)
    straight = displaced(row(1.0, 2.0, 0.5 * np.pi), row(0.4, 0.1, 0.0), 2.0)
    np.testing.assert_allclose(straight, row(0.8, 2.8, 0.5 * np.pi), atol=1e-14)


def test_ramps_bring_every_axis_to_its_target():
    limits = AxisLimits(np.array([1.0, 1.0, 3.0]), np.array([0.4, 0.4, 1.6]))
    pose, velocity = row(0.0, 0.0, 0.0), np.zeros((1, 3))
    for _ in range(50):
        target = omni.target(row(0.2, 0.0, 0.0), velocity, limits, THREE)
        velocity, mean = ramp(velocity, target, omni.rates(limits, THREE), 0.02)
        pose = displaced(pose, mean, 0.02)
    np.testing.assert_allclose(velocity, row(0.2, 0.0, 0.0), atol=SMALL)
    # 0.2 m/s after 0.5 s: 0.05 m on the ramp and 0.1 m after it.
    np.testing.assert_allclose(pose, row(0.15, 0.0, 0.0), atol=SMALL)


def test_encoders_give_the_pose_back():
    pose = estimate = row(0.0, 0.0, 0.0)
    draw = np.random.default_rng(4)
    for _ in range(100):
        twist = draw.normal(size=(1, 3))
        pose = displaced(pose, twist, 0.05)
        estimate = omni.odometry_pose(estimate, 0.05 * rims(twist, FOUR), None, FOUR)
    np.testing.assert_allclose(estimate, pose, atol=SMALL)


def test_the_centre_moves_as_wanted_whatever_the_heading():
    pose = np.array([[1.0, 2.0, 0.5 * np.pi], [0.0, 0.0, 2.1]])
    team, still = Team(("robotino3",) * 2), np.zeros(2)
    np.testing.assert_array_equal(team.point(pose, still, 0.3), pose[:, :2])
    wanted = np.array([[0.3, 0.1], [-0.2, 0.5]])
    command = team.command(wanted, pose, still, 0.3, 0.02)
    np.testing.assert_allclose(command[0], [0.1, -0.3, 0.0], atol=1e-15)
    given = team.velocity(command, pose, still, 0.3, 0.02)
    np.testing.assert_allclose(given, wanted, atol=1e-15)
    moved = displaced(pose, command, 0.1)
    np.testing.assert_allclose(moved[:, :2] - pose[:, :2], 0.1 * wanted, atol=1e-15)
    np.testing.assert_array_equal(moved[:, 2], pose[:, 2])


def test_a_contact_slows_the_axis_that_it_blocks():
    velocity = np.array([[0.4, -0.3, 0.1]])
    np.testing.assert_allclose(omni.blocked(velocity, row(0.1, -0.5)), row(0.1, -0.3, 0.1))
    np.testing.assert_allclose(omni.blocked(velocity, row(-0.1, 0.1)), row(0.0, 0.0, 0.1))


def test_wheel_forces_and_wheel_speeds_are_dual():
    # Power at the rims is power at the body.
    forces, twist = row(3.0, -1.0, 2.0, 0.5), row(0.3, -0.2, 0.7)
    wrench = forces @ FOUR.rolling
    assert np.sum(wrench * twist) == pytest.approx(np.sum(forces * rims(twist, FOUR)), abs=SMALL)
