"""Car-like robots: the bicycle model, its limits and the point ahead of the steered wheel."""

import numpy as np
import pytest

from mrs_simulator.core.kinematics import displaced, ramp
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.vehicles.drives import car
from mrs_simulator.vehicles.limits import AxisLimits

L, MOST, RATE = 0.3302, 0.4189, 3.2  # F1TENTH
CAR = car.CarParameters(wheelbase=L, steering_max=MOST, steering_rate=RATE, backward=5.0)
SMALL = 1e-12


def row(*values):
    return np.array([values])


def one(value):
    return np.array([value])


def limits(acceleration=9.51, top=20.0):
    return AxisLimits(np.array([top, np.inf]), np.array([acceleration, np.inf]))


def move(pose, speed, steering, command, step, **given):
    """Return speed, steering angle, mean twist and pose after ``step`` [s]."""
    inner, own = np.column_stack([speed, steering]), limits(**given)
    after, mean = ramp(inner, car.target(command, inner, own, CAR), car.rates(own, CAR), step)
    mean = car.velocities(mean, CAR)
    np.testing.assert_allclose(car.velocities(after, CAR), car.twist_of(*after.T, CAR))
    return after[:, 0], car.joints_of(after), mean, displaced(pose, mean, step)


def limited(command, steering):
    """Return ``command`` as the control's saturation lets it pass."""
    inner = car.inner_command(command, steering, CAR)
    ahead = np.abs(command / limits().top).max(axis=1)
    factor = np.maximum(car.excess(inner, steering, CAR, 0.02), ahead)
    return car.slowed(inner, np.maximum(factor, 1.0), steering, CAR)


def point(pose, steering, ahead, numbers=CAR):
    """Return the controlled points of cars."""
    direction = pose[:, 2] + steering
    along = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    heading = np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)
    return pose[:, :2] + car.pivot(numbers) * heading + car.arm(ahead, numbers) * along


def seen(vectors, angle):
    """Return components of ``vectors`` (1, 2) along and across a direction at ``angle`` (1,)."""
    (x, y), cos, sin = vectors[0], np.cos(angle), np.sin(angle)
    return cos * x + sin * y, cos * y - sin * x


def common(along, across, angle):
    """Return the vectors (1, 2) of such components; undoes ``seen``."""
    return np.stack(seen(np.stack([along, across], axis=1), -angle), axis=1)


def led(wanted, pose, steering, ahead):
    """Return the command that moves the point with the velocity ``wanted`` (1, 2) over 0.02 s."""
    return car.command(*seen(wanted, pose[:, 2] + steering), steering, ahead, 0.02, CAR)


def test_the_least_radius_and_the_turn_rate_there():
    np.testing.assert_allclose(
        car.twist_of(one(1.0), one(MOST), CAR), row(1.0, 1.0 / 0.7416), rtol=1e-4
    )


def test_a_twist_tells_the_steering_angle_unless_the_car_stands():
    commands = np.array([[2.0, 1.0], [-2.0, 1.0], [0.0, 0.0], [0.0, 3.0], [1.0, 9.0]])
    angle = np.arctan(0.5 * L)
    np.testing.assert_allclose(
        car.steering_of(commands, np.full(5, 0.1), CAR),
        [angle, -angle, 0.1, 0.1, np.arctan(9.0 * L)],
    )


def test_held_speed_and_steering_go_round_the_circle():
    steering = one(np.arctan(L / 2.0))  # a circle of radius 2 m
    pose, speed = row(0.0, 0.0, 0.0), one(1.0)
    command = car.twist_of(speed, steering, CAR)
    for _ in range(100):  # half a turn in 2 pi s
        speed, steering, _, pose = move(pose, speed, steering, command, 0.02 * np.pi)
    np.testing.assert_allclose(pose[0, :2], [0.0, 4.0], atol=1e-9)
    assert np.cos(pose[0, 2]) == pytest.approx(-1.0)


def test_steering_takes_its_time_and_ends_at_its_limit():
    pose, speed, steering = row(0.0, 0.0, 0.0), one(1.0), one(0.0)
    command = row(1.0, 100.0)
    assert car.joints_after(command, steering, CAR, 0.1)[0] == pytest.approx(0.32)
    speed, steering, mean, _ = move(pose, speed, steering, command, 0.1)
    assert steering[0] == pytest.approx(0.32)  # 3.2 rad/s for 0.1 s
    assert mean[0, 1] == pytest.approx(np.tan(0.16) / L)
    _, steering, _, _ = move(pose, speed, steering, command, 0.1)
    assert steering[0] == MOST


def test_the_speed_has_other_limits_forwards_than_backwards():
    pose, steering = row(0.0, 0.0, 0.0), one(0.0)
    for wanted, reached in ((30.0, 20.0), (-30.0, -5.0)):
        speed, _, _, _ = move(pose, one(0.0), steering, row(wanted, 0.0), 1.0, acceleration=1e3)
        assert speed[0] == reached
    speed, _, mean, _ = move(pose, one(0.0), steering, row(9.0, 0.0), 0.1)
    assert speed[0] == pytest.approx(0.951)
    assert mean[0, 0] == pytest.approx(0.4755)


def test_a_stopped_car_keeps_its_wheels_turned():
    _, steering, _, after = move(row(1.0, 2.0, 0.3), one(0.0), one(0.2), row(0.0, 0.0), 0.1)
    assert steering[0] == 0.2
    np.testing.assert_array_equal(after, row(1.0, 2.0, 0.3))


def test_the_point_lies_ahead_of_the_steered_wheel():
    numbers = CAR._replace(wheelbase=0.3)
    np.testing.assert_allclose(
        point(row(1.0, 2.0, 0.5 * np.pi), one(-0.5 * np.pi), 0.1, numbers), row(1.1, 2.3)
    )


@pytest.mark.parametrize("steering", [-0.4, 0.0, 0.3])
def test_the_mapping_moves_the_point_as_wanted(steering):
    # By differences of the true motion, not by the formula that the mapping inverts.
    pose, steering, ahead, dt = row(0.4, -1.2, 2.2), one(steering), 0.15, 1e-6
    x, y, theta = pose[0]
    for angle in np.linspace(0.0, 6.0, 7):
        wanted = row(np.cos(angle), np.sin(angle))
        (speed,), (rate,) = car.inputs(*seen(wanted, pose[:, 2] + steering), steering, ahead, CAR)
        turned = dt * speed * np.tan(steering[0] + 0.5 * dt * rate) / L
        middle = theta + 0.5 * turned
        after = row(
            x + dt * speed * np.cos(middle), y + dt * speed * np.sin(middle), theta + turned
        )
        gone = point(after, steering + dt * rate, ahead) - point(pose, steering, ahead)
        np.testing.assert_allclose(gone / dt, wanted, atol=1e-5)
        np.testing.assert_allclose(
            common(
                *car.point_velocity(one(speed), one(rate), steering, ahead, CAR),
                pose[:, 2] + steering,
            ),
            wanted,
            atol=SMALL,
        )


def test_the_point_follows_a_wanted_path_on_the_wire():
    """Twists of 50 Hz lead the point of a car along a line 0.3 m beside it, as a first-order law wants."""
    pose, steering, speed, ahead = row(0.0, 0.0, 0.0), one(0.0), one(0.0), 0.3
    for step in range(500):
        at = point(pose, steering, ahead)
        target = np.array([[0.63 + 0.5 * 0.02 * step, 0.3]])
        wanted = row(0.5, 0.0) + 1.0 * (target - at)
        command = limited(led(wanted, pose, steering, ahead), steering)
        speed, steering, _, pose = move(pose, speed, steering, command, 0.02, acceleration=1e3)
    # One step behind.
    assert np.abs(point(pose, steering, ahead) - target).max() < 0.011
    assert abs(steering[0]) < 1e-3


def test_a_car_that_cannot_steer_further_turns_forwards_until_its_aim_is_ahead():
    pose, steering, speed = row(0.0, 0.0, 0.0), one(0.0), one(0.0)
    wanted = row(-1.0, 0.2)  # behind
    turned_forwards = False
    for _ in range(400):
        command = limited(led(wanted, pose, steering, 0.3), steering)
        at_limit = abs(steering[0]) == pytest.approx(MOST)
        turned_forwards |= at_limit and command[0, 0] > 0.9
        speed, steering, _, pose = move(pose, speed, steering, command, 0.02)
    assert turned_forwards
    assert np.cos(pose[0, 2] - np.arctan2(0.2, -1.0)) > 0.999
    assert abs(steering[0]) < 0.01


def test_the_excess_is_of_speed_or_of_steering_rate():
    commands = car.twist_of(
        np.array([30.0, -10.0, 1.0]), np.array([0.1, 0.1, 0.1 + 3.2 * 0.02 * 4.0]), CAR
    )
    steering = np.full(3, 0.1)
    inner = car.inner_command(commands, steering, CAR)
    excess = car.excess(inner, steering, CAR, 0.02)
    np.testing.assert_allclose(excess, [0.0, 2.0, 4.0], atol=SMALL)
    none = car.excess(inner, steering, car.unlimited(CAR), 0.02)
    np.testing.assert_array_equal(none, 0.0)
    fast = Team(("f1tenth",) * 3).excess(commands, steering, 0.02)
    assert fast[0] == pytest.approx(30.0 / kind("f1tenth").limits["firmware"][0].top)


def test_a_steering_rate_at_its_limit_shows_in_a_recording():
    """Three cars, two samples: the second car is asked to steer as fast as it can, then no more."""
    team, most = Team(("f1tenth",) * 3), 3.2 * 0.02
    steering = np.array([[0.1, 0.1, 0.0], [0.1, 0.1 + most, 0.0]])
    asked = np.array([[0.1 + 0.9 * most, 0.1 + most, 0.0], [0.1, 0.1 + most, 0.0]])
    pose = np.zeros((2, 3, 3))
    points = np.stack([team.point(*each, 0.2) for each in zip(pose, steering)])
    numbers = team.groups[0].numbers
    command = np.stack([car.twist_of(np.ones(3), each, numbers) for each in asked])
    found = team.limits_in(command, pose, points, 0.2, 0.02, 0.999)
    np.testing.assert_array_equal(found, [[False, True, False], [False, False, False]])
    assert not team.at_limits(command, 0.999).any()  # no command alone tells it


def test_a_slowed_command_keeps_the_direction_of_the_point():
    steering = one(0.1)
    full = car.twist_of(one(1.2), one(0.3), CAR)
    slow = car.slowed(row(1.2, 0.3), one(4.0), steering, CAR)
    assert slow[0, 0] == pytest.approx(0.3)
    assert car.steering_of(slow, steering, CAR)[0] == pytest.approx(0.15)
    slowly, fast = (car.velocity(each, steering, 0.2, 0.02, CAR) for each in (slow, full))
    np.testing.assert_allclose(slowly, np.array(fast) / 4.0, rtol=1e-12)


def test_a_command_means_the_velocity_that_it_was_made_of():
    pose, steering, wanted = row(1.0, 0.0, 0.4), one(0.1), row(0.7, 0.5)
    command = led(wanted, pose, steering, 0.2)
    given = common(*car.velocity(command, steering, 0.2, 0.02, CAR), pose[:, 2] + steering)
    np.testing.assert_allclose(given, wanted, rtol=1e-12)


def test_a_standing_car_creeps_to_steer():
    # Wanted: straight across the wheel, so no speed; a Twist of v = 0 could not tell the angle.
    command = led(row(0.0, 0.01), row(0.0, 0.0, 0.0), one(0.0), 0.2)
    assert command[0, 0] == car.CREEP
    assert car.steering_of(command, one(0.0), CAR)[0] == pytest.approx(0.001)
    assert (led(row(0.0, 0.0), row(0.0, 0.0, 0.0), one(0.0), 0.2) == 0.0).all()


def test_a_contact_slows_a_car_and_its_turning_with_it():
    inner = np.array([[2.0, 0.3], [-2.0, 0.3], [0.0, 0.0]])
    blocked = car.blocked(inner, np.array([[0.5, 0.0], [0.5, 0.0], [0.1, 0.0]]))
    np.testing.assert_allclose(blocked, [[0.5, 0.3], [0.0, 0.3], [0.0, 0.0]])
    turning = car.velocities(blocked, CAR)[:, 1]
    np.testing.assert_allclose(turning, [0.5 * np.tan(0.3) / L, 0.0, 0.0])


def test_odometry_follows_distance_and_turn():
    pose = estimate = row(0.0, 0.0, 0.0)
    speed, steering = one(0.0), one(0.0)
    for step in range(200):
        wanted = car.twist_of(one(1.0 + np.sin(0.1 * step)), one(0.3 * np.cos(0.07 * step)), CAR)
        speed, steering, mean, pose = move(pose, speed, steering, wanted, 0.02)
        rolled = 0.02 * car.rim_speeds(mean, steering, CAR)
        estimate = car.odometry_pose(estimate, rolled, steering, CAR)
    np.testing.assert_allclose(estimate, pose, atol=SMALL)
