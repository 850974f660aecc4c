"""Planar bodies under forces against closed forms."""

import numpy as np
import pytest

from mrs_simulator.vehicles.drives import omnidirectional as omni
from mrs_simulator.world.motion.planar_body import (
    GRAVITY,
    Footing,
    PlanarBodies,
    about,
    stiffness,
    wheel_forces,
)

DT = 0.005  # [s]
MU = 0.6


def row(*values):
    return np.array([values], dtype=float)


def footing(along, across=None, mass=10.0, mu=MU, push=1e9, share=None):
    """Return the footing of one body whose wheels carry equal shares of its weight."""
    along = np.asarray(along, dtype=float)[np.newaxis]
    across = np.zeros_like(along) if across is None else np.asarray(across, dtype=float)[np.newaxis]
    count = along.shape[1]
    # Rollers turned against the rim, as a mecanum wheel has them, carry a greater force than the rim.
    slant = np.hypot(along[0, :, 0], along[0, :, 1])
    share = np.full(count, 1.0 / count) if share is None else np.asarray(share)
    grip = mu * GRAVITY * mass * share / slant
    push = np.broadcast_to(np.asarray(push, dtype=float), (count,))[np.newaxis]
    return Footing(along, across, grip[np.newaxis], push)


def drive(body, stand, rims, duration, dt=DT):
    gain = stiffness(stand, body.mass, body.inertia)
    for _ in range(int(round(duration / dt))):
        wrench, turning = wheel_forces(body.twist, rims, stand, gain)
        body.advance(wrench, dt)
    return turning


THREE = omni.omni_wheels(np.radians([60.0, 180.0, 300.0]), 0.175)
FOUR = omni.mecanum_wheels(0.47, 0.30)


def test_a_free_body_keeps_its_momentum_and_its_spin():
    body = PlanarBodies([2.0], [0.5], row(0.0, 0.0, 0.3), row(1.0, -0.5, 2.0))
    for _ in range(200):
        body.advance(np.zeros((1, 3)), DT)
    cos, sin = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(
        body.pose[0, :2], [cos + 0.5 * sin, sin - 0.5 * cos], atol=1e-12
    )  # 1 s along a straight line
    assert body.twist[0, 2] == 2.0
    assert np.hypot(*body.twist[0, :2]) == pytest.approx(np.hypot(1.0, 0.5))
    assert body.pose[0, 2] == pytest.approx(2.3)


def test_a_held_force_accelerates_and_a_torque_turns():
    bodies = PlanarBodies([2.0, 4.0], [0.5, 1.0], np.zeros((2, 3)))
    for _ in range(100):
        bodies.advance(np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 0.8]]), 0.01)
    np.testing.assert_allclose(bodies.twist, [[1.5, 0.0, 0.0], [0.0, 0.0, 0.8]], atol=1e-12)
    # Half a step further than a t^2/2, for the velocity goes first.
    assert bodies.pose[0, 0] == pytest.approx(0.5 * 1.5 * (1.0 + 0.01))
    assert bodies.pose[1, 2] == pytest.approx(0.5 * 0.8 * (1.0 + 0.01))


def test_thrust_against_drag_ends_at_their_ratio():
    body = PlanarBodies([28.0], [10.0], np.zeros((1, 3)))
    for step in range(4000):
        body.advance(row(10.0, 0.0, 0.0) - row(16.45, 15.8, 6.0) * body.twist, 0.01)
        if step == 169:  # the time constant 28/16.45 s
            assert body.twist[0, 0] == pytest.approx(10.0 / 16.45 * (1.0 - np.exp(-1.0)), rel=0.01)
    assert body.twist[0, 0] == pytest.approx(10.0 / 16.45)


@pytest.mark.parametrize("rolling", [THREE, FOUR])
@pytest.mark.parametrize("twist", [(0.3, 0.0, 0.0), (0.0, -0.2, 0.0), (0.0, 0.0, 0.5)])
def test_a_base_reaches_the_twist_that_its_wheels_are_driven_at(rolling, twist):
    body = PlanarBodies([10.0], [0.4], np.zeros((1, 3)))
    turning = drive(body, footing(rolling), row(*(rolling @ twist)), 1.0)
    np.testing.assert_allclose(body.twist, row(*twist), atol=1e-9)
    np.testing.assert_allclose(turning, row(*(rolling @ twist)), atol=1e-9)


@pytest.mark.parametrize(
    "rolling, direction, share",
    [
        ([[1.0, 0.0, -0.2], [1.0, 0.0, 0.2]], (1.0, 0.0), 1.0),  # two plain wheels ahead
        (THREE, (1.0, 0.0), 2.0 * np.sin(np.pi / 3.0) / 3.0),  # two of three, at 60 deg: 0.577
        (FOUR, (1.0, 0.0), np.sqrt(0.5)),  # rollers at 45 deg
        (FOUR, (0.0, 1.0), np.sqrt(0.5)),
    ],
)
def test_the_ground_gives_no_more_than_mu_g(rolling, direction, share):
    rolling = np.asarray(rolling)
    body = PlanarBodies([10.0], [0.4], np.zeros((1, 3)))
    drive(body, footing(rolling), row(*(rolling @ [*(50.0 * np.array(direction)), 0.0])), 0.5)
    speed = np.hypot(*body.twist[0, :2])
    assert speed / 0.5 == pytest.approx(share * MU * GRAVITY, rel=1e-9)
    assert body.twist[0, :2] @ direction == pytest.approx(speed)


def test_a_weak_motor_decides_before_the_ground_does():
    rolling = np.array([[1.0, 0.0, -0.2], [1.0, 0.0, 0.2]])
    body = PlanarBodies([10.0], [0.4], np.zeros((1, 3)))
    turning = drive(body, footing(rolling, push=4.0), row(50.0, 50.0), 0.5)
    assert body.twist[0, 0] / 0.5 == pytest.approx(2.0 * 4.0 / 10.0)
    # It rolls, almost: a wheel that spun would turn at 50 m/s.
    assert turning[0, 0] == pytest.approx(body.twist[0, 0], abs=0.01)


@pytest.mark.parametrize("strength, rim", [(0.5, 1.0 / np.sqrt(3.0)), (0.9, 2.0)])
def test_a_wheel_that_slides_sideways_still_pushes_with_all_its_motor_has(strength, rim):
    # Dragged sideways at 1 m/s, held to turn at 2 m/s: the ground pushes against the sliding contact.
    grip = MU * GRAVITY * 10.0
    stand = footing([[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]], push=strength * grip)
    gain = np.array([1e4])
    wrench, turning = wheel_forces(row(0.0, 1.0, 0.0), row(2.0), stand, gain)
    pull = min(strength, 2.0 / np.sqrt(5.0)) * grip
    np.testing.assert_allclose(wrench, row(pull, -np.sqrt(grip**2 - pull**2), 0.0), atol=1e-9)
    assert turning[0, 0] == pytest.approx(rim)  # a weak one slows until it needs no more


def single_track(steering, mass=3.74, wheelbase=0.3302, ahead=0.17145, mu=1.0489):
    """Return the footing about the centre of mass of a car of two wheels, rear and front."""
    cos, sin = np.cos(steering), np.sin(steering)
    along = np.array([[[1.0, 0.0, 0.0], [cos, sin, wheelbase * sin]]])
    across = np.array([[[0.0, 1.0, 0.0], [-sin, cos, wheelbase * cos]]])
    share = [1.0 - ahead / wheelbase, ahead / wheelbase]
    at_rear = footing(along[0], across[0], mass, mu, push=[1e9, 0.0], share=share)
    return at_rear._replace(along=about(along, [ahead]), across=about(across, [ahead]))


def test_a_slow_car_turns_by_its_steering_angle():
    body = PlanarBodies([3.74], [0.04712], np.zeros((1, 3)))
    drive(body, single_track(0.3), row(0.5, 0.0), 3.0)
    assert body.twist[0, 2] == pytest.approx(0.5 * np.tan(0.3) / 0.3302, rel=0.02)


def test_a_car_too_fast_for_its_curve_slides_out():
    # On the circle of the least radius, 0.742 m, the ground holds up to sqrt(mu g R) = 2.76 m/s.
    body = PlanarBodies([3.74], [0.04712], np.zeros((1, 3)), row(6.0, 0.0, 0.0))
    drive(body, single_track(0.4189), row(6.0, 0.0), 0.3)
    speed, omega = np.hypot(*body.twist[0, :2]), abs(body.twist[0, 2])
    assert omega < 0.7 * 6.0 * np.tan(0.4189) / 0.3302
    assert speed > 3.0


def test_the_ground_bends_a_path_by_no_more_than_mu_g():
    body = PlanarBodies([3.74], [0.04712], np.zeros((1, 3)), row(8.0, 0.0, 0.0))
    stand = single_track(0.3)
    gain = stiffness(stand, body.mass, body.inertia)
    for _ in range(100):
        wrench, _ = wheel_forces(body.twist, row(8.0, 0.0), stand, gain)
        assert np.hypot(*wrench[0, :2]) <= 1.0489 * GRAVITY * 3.74 * (1.0 + 1e-9)
        body.advance(wrench, DT)
