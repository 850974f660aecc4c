"""Rotors, rigid bodies in the air and their controllers: closed forms with typed-out numbers."""

import numpy as np
import pytest
from flight_fixtures import crazyflie, flown, hovering, published, tilts

from mrs_simulator.vehicles.drives import flight, flight_control, quadrotor, rotors

RPM = 2.0 * np.pi / 60.0
EARTH = 9.8  # [m/s^2], as the sources of the Crazyflie's numbers have it
ONE = crazyflie()


def row(*values):
    return np.array([values])


def test_hover_and_top_speed_of_the_rotors():
    assert rotors.hover_speed(ONE, EARTH) / RPM == pytest.approx(14468.0, abs=1.0)
    assert rotors.greatest_thrust(ONE) == pytest.approx(0.5954, abs=1e-4)
    hover = rotors.wrench_of(row(*[14468.4 * RPM] * 4), ONE)
    np.testing.assert_allclose(hover, row(0.2646, 0.0, 0.0, 0.0), atol=1e-4)
    # Thrust to weight 2.25 at 21703 rpm, and a climb with 1.25 g.
    assert rotors.greatest_thrust(ONE) / (0.027 * EARTH) == pytest.approx(2.25, abs=1e-3)
    assert rotors.greatest_climb(ONE, EARTH) == pytest.approx(12.25, abs=0.01)


def test_torques_of_the_rotors():
    most = 21703.0 * RPM
    # Left ones: front left is the fourth, rear left the third.
    roll = rotors.wrench_of(row(0.0, 0.0, most, most), ONE)
    np.testing.assert_allclose(roll, row(0.2977, 8.36e-3, 0.0, 0.0), atol=1e-4)
    nose_down = rotors.wrench_of(row(0.0, most, most, 0.0), ONE)
    np.testing.assert_allclose(nose_down, row(0.2977, 0.0, 8.36e-3, 0.0), atol=1e-4)
    turn = rotors.wrench_of(row(most, 0.0, most, 0.0), ONE)
    np.testing.assert_allclose(turn, row(0.29768, 0.0, 0.0, 7.48e-3), atol=1e-5)


def test_senses_are_those_of_cf2x():
    """gym-pybullet-drones: propellers 0 to 3 at (28, 28), (-28, 28), (-28, -28), (28, -28) mm, and the
    torque about z is -t0 + t1 - t2 + t3 of theirs; ours begin front right and go clockwise."""
    places = np.array([[28.0, -28.0], [-28.0, -28.0], [-28.0, 28.0], [28.0, 28.0]])
    given = {(28.0, 28.0): -1.0, (-28.0, 28.0): 1.0, (-28.0, -28.0): -1.0, (28.0, -28.0): 1.0}
    wrench = rotors.wrench_of(1000.0 * np.eye(4), ONE)
    assert np.sign(wrench[:, 3]).tolist() == [given[tuple(place)] for place in places.tolist()]
    np.testing.assert_array_equal(np.sign(wrench[:, 1]), np.sign(places[:, 1]))  # y x F
    np.testing.assert_array_equal(np.sign(wrench[:, 2]), -np.sign(places[:, 0]))


def test_rotor_speeds_give_the_wrench_that_is_asked_for():
    draw = np.random.default_rng(1)
    wrench = draw.uniform(-1.0, 1.0, (50, 4)) * [0.05, 5e-4, 5e-4, 5e-4] + [0.27, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(
        rotors.wrench_of(rotors.speeds_of(wrench, ONE), ONE), wrench, rtol=1e-12, atol=1e-15
    )


def test_thrust_gives_way_to_torques():
    # All thrust and some roll: together more than the rotors can.
    told = rotors.speeds_of(row(0.5954, 2e-3, 0.0, 0.0), ONE)
    assert told.max() == pytest.approx(21703.0 * RPM)
    got = rotors.wrench_of(told, ONE)
    np.testing.assert_allclose(got[:, 1:], row(2e-3, 0.0, 0.0), atol=1e-12)
    # Two rotors at most; the others less by 2e-3/(2 lever) each: 0.5954 - 2e-3/0.02807.
    assert got[0, 0] == pytest.approx(0.5241, abs=1e-4)
    assert rotors.speeds_of(row(0.0, 2e-3, 0.0, 0.0), ONE).min() == 0.0


def test_motors_lag_by_72_ms():
    after = rotors.lagged_speeds(row(*[1000.0] * 4), row(*[2000.0] * 4), ONE, 0.072)
    np.testing.assert_allclose(after, 1632.1206, atol=1e-4)
    at_once = rotors.lagged_speeds(
        row(*[1000.0] * 4), row(*[2000.0] * 4), crazyflie(lag=0.0), 0.002
    )
    np.testing.assert_allclose(at_once, 2000.0)


def test_drag_while_hovering():
    across, _, up = rotors.hover_drag(ONE, EARTH).ravel()
    assert across == pytest.approx(5.56e-3, abs=1e-5)
    assert up == pytest.approx(6.25e-3, abs=1e-5)
    assert 0.027 / across == pytest.approx(4.85, abs=0.01)  # [s], a time constant


def sinks_at(share, duration=40.0):
    """Return the speed [m/s] of a level fall with the rotors held at ``share`` of hovering."""
    state = hovering(1, ONE)
    held = share * state.rotors
    state = state._replace(rotors=held)
    for _ in range(int(duration / 0.05)):
        state = flight.advanced(state, flight.acting(state, ONE), held, 0.0, ONE, 0.05)
    return -state.velocity[0, 2]


def test_drag_gives_a_terminal_speed():
    # (1 - 0.9^2) m g = 4 d_z 0.9 n_hover v: 0.0503253/5.626e-3.
    assert sinks_at(0.9) == pytest.approx(8.945, abs=0.005)
    # Tilted by 20 deg, at constant height: m g tan(20 deg) = d v sum(n), n = n_hover/sqrt(cos(20 deg)).
    axis = row(np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0)))
    speeds = np.full((1, 4), 14475.8 * RPM / np.sqrt(np.cos(np.radians(20.0))))
    isotropic = ONE._replace(drag=(9.1785e-7,) * 3)
    drag = flight.drag_of(row(16.79, 0.0, 0.0), axis, speeds, isotropic)
    assert -drag[0, 0] == pytest.approx(0.027 * 9.81 * np.tan(np.radians(20.0)), rel=2e-3)


def test_drag_is_that_of_the_body_frame():
    sideways = row(1.0, 0.0, 0.0)  # the body's z axis lies along the motion
    speeds = np.full((1, 4), 1000.0)
    np.testing.assert_allclose(
        flight.drag_of(row(2.0, 1.0, 0.0), sideways, speeds, ONE),
        row(-8.2488e-3, -3.6714e-3, 0.0),
        rtol=1e-12,
    )


def test_a_body_in_free_fall():
    state = hovering(2, ONE)._replace(rotors=np.zeros((2, 4)))
    for _ in range(500):
        state = flight.advanced(state, flight.acting(state, ONE), np.zeros((2, 4)), 0.0, ONE, 0.002)
    np.testing.assert_allclose(state.velocity[:, 2], -9.81, rtol=1e-12)
    np.testing.assert_allclose(
        state.place[:, 2], -4.905, rtol=3e-3
    )  # symplectic: g h/2 a second more


def test_a_tumbling_body_keeps_momentum_and_energy():
    numbers = crazyflie(inertia=(1.4e-5, 2.0e-5, 2.6e-5), drag=(0.0,) * 3)
    state = hovering(1, numbers)._replace(
        rates=np.array([[1.0, 5.0, 0.2]], order="F"), rotors=np.zeros((1, 4))
    )
    begin, energy = momentum(state, numbers), (numbers.inertia * state.rates**2).sum()
    for _ in range(2000):
        forces = flight.acting(state, numbers)
        state = flight.advanced(state, forces, state.rotors, 0.0, numbers, 0.0005)
    np.testing.assert_allclose(momentum(state, numbers), begin, atol=0.01 * np.linalg.norm(begin))
    assert (numbers.inertia * state.rates**2).sum() == pytest.approx(energy, rel=0.01)
    assert abs(state.rates[0, 0]) > 1.5  # about the middle axis it has turned over


def momentum(state, numbers):
    x, y, z, w = state.attitude[0]
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    np.testing.assert_allclose(flight.upward(state.attitude)[0], turn[:, 2], atol=1e-12)
    return turn @ (numbers.inertia * state.rates[0])


def test_the_attitude_wanted_points_the_thrust():
    acceleration = row(3.0, -2.0, 1.0)
    attitude = flight_control.attitude_of(acceleration, np.array([0.7]))
    np.testing.assert_allclose(np.linalg.norm(attitude), 1.0)
    thrust = np.array([3.0, -2.0, 10.81])
    np.testing.assert_allclose(
        flight.upward(attitude)[0], thrust / np.linalg.norm(thrust), atol=1e-12
    )
    still = flight_control.attitude_of(np.zeros((1, 3)), np.array([0.7]))
    np.testing.assert_allclose(still, row(0.0, 0.0, np.sin(0.35), np.cos(0.35)), atol=1e-12)
    np.testing.assert_allclose(
        flight_control.turn_to(flight_control.attitude_of(np.zeros((1, 3)), np.zeros(1)), still),
        row(0.0, 0.0, 2.0 * np.sin(0.35)),
    )


def test_attitude_has_three_poles_in_one_place():
    np.testing.assert_allclose(flight_control.poles_at(30.0, 0.072), (10.0, 194.4, 5.48))
    state, step, seen = hovering(1, ONE), 0.0005, []
    wanted = np.array([[np.sin(0.005), 0.0, 0.0, np.cos(0.005)]])  # 0.01 rad about x
    for _ in range(600):
        forces = flight.acting(state, ONE)
        told = flight_control.rotor_speeds(
            state, forces, np.zeros((1, 3)), wanted, np.zeros(1), ONE
        )
        state = flight.advanced(state, forces, told, 0.0, ONE, step)
        seen.append(2.0 * state.attitude[0, 0])
    scaled = 30.0 * step * np.arange(1, 601)
    exact = 0.01 * (1.0 - (1.0 + scaled + 0.5 * scaled**2) * np.exp(-scaled))
    np.testing.assert_allclose(seen, exact, atol=3e-4)


# A step of velocity ahead with the published gains and motors without lag, as measured with a planar
# simulation of that project's controller: 63 % after [s], tilt [deg]; the overshoot is 17 to 18 %.
@pytest.mark.parametrize(
    "speed, after, tilt",
    [(0.1, 0.217, 2.4), (0.25, 0.228, 5.9), (0.5, 0.245, 11.6), (1.0, 0.274, 22.4)],
)
def test_a_step_of_velocity_with_the_published_gains(speed, after, tilt):
    numbers, step = published(), 1.0 / 240.0
    state, wanted, seen = hovering(1, numbers), row(speed, 0.0, 0.0), []
    for _ in range(480):
        acceleration = flight_control.wanted_acceleration(state.velocity, wanted, numbers)
        attitude = flight_control.attitude_of(acceleration, np.zeros(1))
        forces = flight.acting(state, numbers)
        told = flight_control.rotor_speeds(
            state, forces, acceleration, attitude, np.zeros(1), numbers
        )
        state = flight.advanced(state, forces, told, 0.0, numbers, step)
        seen.append((state.velocity[0, 0], float(tilts(state.attitude)[0])))
    speeds, steep = np.array(seen).T
    assert step * (1 + np.argmax(speeds >= 0.632 * speed)) == pytest.approx(after, abs=0.006)
    assert speeds.max() / speed - 1.0 == pytest.approx(0.175, abs=0.01)
    assert np.degrees(steep.max()) == pytest.approx(tilt, rel=0.05)
    assert abs(state.place[0, 2]) < 0.002


def test_with_lagging_motors_the_published_gains_let_it_fall():
    numbers = published()._replace(lag=0.072)
    seen = flown(hovering(1, numbers), row(1.0, 0.0, 0.0), 3.0, numbers)
    assert seen.place[-1, 0, 2] < -1.0 or tilts(seen.attitude).max() > 1.5


def test_a_step_of_velocity_with_our_gains():
    """Up to the greatest speed; from about 1.4 m/s on the greatest tilt decides how quick it is."""
    speeds, wanted = np.array([0.25, 1.0, 3.0, 8.33]), np.zeros((4, 3))
    wanted[:, 0] = speeds
    seen = flown(hovering(4, ONE), wanted, 5.0, ONE)
    share = seen.velocity[:, :, 0] / speeds
    after = 0.02 * (1 + np.argmax(share >= 0.632, axis=0))
    np.testing.assert_allclose(after, [0.28, 0.28, 0.46, 1.15], atol=0.031)
    assert (share.max(axis=0) < [1.02, 1.02, 1.01, 1.005]).all()
    np.testing.assert_allclose(share[-1], 1.0, rtol=1e-3)
    assert tilts(seen.attitude).max() < np.radians(30.5)
    np.testing.assert_allclose(seen.place[..., 2], 0.0, atol=0.08)
    np.testing.assert_allclose(seen.velocity[..., 1], 0.0, atol=1e-9)


def test_a_hundred_robots_are_stable_at_every_velocity_and_heading():
    """From any allowed velocity to any other, at once, whatever the heading."""
    draw = np.random.default_rng(5)
    heading = draw.uniform(-np.pi, np.pi, 100)
    first, then = draw.uniform(-1.0, 1.0, (2, 100, 3)) * [8.33, 8.33, 1.0]
    then[:50] = -first[:50]
    state = hovering(100, ONE, heading, 50.0)
    going = flown(state, first, 5.0, ONE, heading=heading)
    last = flight.Flight(*(part[-1] for part in going))
    back = flown(last, then, 7.0, ONE, heading=heading)
    for seen, wanted in ((going, first), (back, then)):
        assert tilts(seen.attitude).max() < np.radians(33.0)
        np.testing.assert_allclose(seen.velocity[-1], wanted, atol=0.05)
        up = seen.velocity[..., 2]
        assert up.max() < 1.4
        assert up.min() > -1.4
        turned = 2.0 * np.arctan2(seen.attitude[-1, :, 2], seen.attitude[-1, :, 3]) - heading
        np.testing.assert_allclose(np.sin(0.5 * turned), 0.0, atol=0.01)


def test_each_of_a_hundred_flies_as_if_it_were_alone():
    draw = np.random.default_rng(6)
    wanted, heading = draw.uniform(-1.0, 1.0, (100, 3)), draw.uniform(-3.0, 3.0, 100)
    together = flown(hovering(100, ONE, heading), wanted, 0.4, ONE, heading=heading)
    for robot in (0, 57, 99):
        alone = flown(
            hovering(1, ONE, heading[robot]), wanted[[robot]], 0.4, ONE, heading=heading[robot]
        )
        for part, own in zip(together, alone):
            np.testing.assert_allclose(part[:, robot], own[:, 0], rtol=1e-9, atol=1e-12)


def test_robots_of_two_kinds_fly_side_by_side():
    heavy = crazyflie(effect=tuple(2.0 * v for v in ONE.effect), inertia=(2.8e-5, 2.8e-5, 4.34e-5))
    heavy = heavy._replace(mass=0.054)
    both = quadrotor.QuadrotorParameters(*(np.array(pair) for pair in zip(ONE, heavy)))
    wanted = np.array([[1.0, 0.5, 0.2], [1.0, 0.5, 0.2]])
    seen = flown(hovering(2, both), wanted, 1.0, both)
    for robot, numbers in enumerate((ONE, heavy)):
        alone = flown(hovering(1, numbers), wanted[:1], 1.0, numbers)
        np.testing.assert_allclose(seen.velocity[:, robot], alone.velocity[:, 0], atol=1e-9)


def test_velocity_follows_without_forces():
    # Within what the tilt allows, 9.81 tan(30 deg) 0.25 s = 1.416 m/s: exponentially.
    after, mean = quadrotor.followed(row(0.0, 0.0, 0.0), row(0.3, 0.4, 0.0), ONE, 0.25)
    np.testing.assert_allclose(after, row(0.3, 0.4, 0.0) * 0.6321206, atol=1e-7)
    np.testing.assert_allclose(mean, row(0.3, 0.4, 0.0) * 0.3678794, atol=1e-7)
    # From 5 m/s at 5.66381 m/s^2 first, in a straight line.
    after, mean = quadrotor.followed(row(0.0, 0.0, 0.0), row(3.0, 4.0, 0.0), ONE, 0.5)
    np.testing.assert_allclose(np.linalg.norm(after), 2.831904, atol=1e-6)
    np.testing.assert_allclose(mean, row(0.6, 0.8, 0.0) * 0.5 * 2.831904, atol=1e-6)
    np.testing.assert_allclose(after, row(0.6, 0.8, 0.0) * 2.831904, atol=1e-6)
    # Down with half of gravity, up with 0.8 of 12.24 m/s^2.
    after, _ = quadrotor.followed(
        np.zeros((2, 3)), np.diag([0, 0, -9.0])[[2, 2]] * [[1], [-1]], ONE, 0.1
    )
    np.testing.assert_allclose(after[:, 2], [-0.4905, 0.9794], atol=2e-4)


def test_following_is_the_same_in_one_step_and_in_many():
    wanted, velocity = row(2.0, -1.0, 1.5), row(-1.0, 0.0, -1.0)
    once, mean = quadrotor.followed(velocity, wanted, ONE, 0.6)
    went = 0.0
    for _ in range(30):
        velocity, part = quadrotor.followed(velocity, wanted, ONE, 0.02)
        went = went + part / 30.0
    np.testing.assert_allclose(velocity, once, atol=1e-12)
    np.testing.assert_allclose(went, mean, atol=1e-12)


def test_without_limits_it_answers_at_once():
    free = quadrotor.unlimited(ONE)
    after, mean = quadrotor.followed(row(0.0, 1.0, 0.0), row(40.0, 0.0, -30.0), free, 0.02)
    np.testing.assert_allclose(after, row(40.0, 0.0, -30.0), atol=1e-9)
    np.testing.assert_allclose(mean, after, atol=1e-6)
    standing, _ = quadrotor.followed(row(1.0, 2.0, 3.0), row(1.0, 2.0, 3.0), ONE, 0.02)
    np.testing.assert_allclose(standing, row(1.0, 2.0, 3.0))


def test_commands_are_along_the_heading():
    told = quadrotor.level(row(1.0, 0.5, 0.2, 9.0), np.array([0.5 * np.pi]))
    np.testing.assert_allclose(told, row(-0.5, 1.0, 0.2), atol=1e-12)
