"""Vessels: closed forms with typed-out numbers."""

import numpy as np
import pytest
from vessel_fixtures import HERON, OTTER, WAMV, numbers_of

from mrs_simulator.vehicles.drives import hydrodynamics, thrusters, vessel, vessel_dynamics

BOATS = {"heron": numbers_of(HERON), "otter": numbers_of(OTTER), "wamv": numbers_of(WAMV)}
EVERY = sorted(BOATS)


def row(*values):
    return np.array([values])


def steady_speed(force, numbers):
    """Return the speed [m/s] straight ahead at which ``force`` [N] is balanced, a number or (m,)."""
    linear, quadratic = (
        hydrodynamics.parts(numbers.linear)[0],
        hydrodynamics.parts(numbers.quadratic)[0],
    )
    force = np.asarray(force, dtype=float)
    # Free of cancellation, and right without quadratic damping.
    return 2.0 * force / (linear + np.sqrt(linear**2 + 4.0 * quadratic * np.abs(force)))


def pushed(force, numbers, duration, velocity=(0.0, 0.0, 0.0), step=0.02):
    """Return the velocity (3,) after ``duration`` [s] under a ``force`` (3,) that holds."""
    velocity = row(*velocity)
    for _ in range(int(round(duration / step))):
        velocity = hydrodynamics.moved(velocity, row(*force), numbers, step)
    return velocity[0]


def both(*numbers):
    """Return the numbers of a group of several kinds."""
    return vessel.VesselParameters(*(np.array(values) for values in zip(*numbers)))


@pytest.mark.parametrize(
    "name, force, speed",
    [
        ("heron", 10.0, 0.553),
        ("heron", 20.0, 1.027),
        ("heron", 40.0, 1.832),
        ("heron", 62.0, 2.579),
        ("wamv", 485.3, 2.259),
        ("otter", 239.4, 3.087),
    ],
)
def test_steady_speeds(name, force, speed):
    assert steady_speed(force, BOATS[name]) == pytest.approx(speed, abs=1e-3)
    assert steady_speed(-force, BOATS[name]) == pytest.approx(-speed, abs=1e-3)
    reached = pushed((force, 0.0, 0.0), BOATS[name], 40.0, step=0.1)
    np.testing.assert_allclose(reached, [speed, 0.0, 0.0], atol=1e-3)


@pytest.mark.parametrize("name, time", [("heron", 1.702), ("otter", 1.1025)])
def test_time_constants_of_surge(name, time):
    # Of a small speed: quadratic damping does not count.
    left = pushed((0.0, 0.0, 0.0), BOATS[name], time, (1e-3, 0.0, 0.0), step=time / 100.0)
    assert left[0] == pytest.approx(0.3679e-3, rel=1e-3)


def test_time_constants_of_sway_and_yaw():
    # Without the coupling of both: 1 s each, as the Otter's source chooses its damping.
    alone = BOATS["otter"]._replace(inertia=(85.5, 162.5, 42.65, 0.0), quadratic=(0.0,) * 3)
    left = pushed((0.0, 0.0, 0.0), alone, 1.0, (0.0, 1e-3, 1e-3), step=0.01)
    np.testing.assert_allclose(left, [0.0, 0.3679e-3, 0.3679e-3], atol=1e-6)


def test_turning_is_balanced_by_damping():
    # 80 N and 40 N: 15.8 N m = 42.65 r (1 + 10 r); without surge and sway there is no coupling.
    held = hydrodynamics.resistance(row(0.0, 0.0, 0.1486), BOATS["otter"])
    np.testing.assert_allclose(held[0, 2], 15.75, atol=0.05)
    # C(v) v by hand: -(162.5 v + 12.25 r) r, 85.5 u r, (162.5 - 85.5) u v + 12.25 u r.
    velocity = row(1.0, 0.2, 0.3)
    damped = hydrodynamics.damping(velocity, BOATS["otter"]) * velocity
    np.testing.assert_allclose(
        hydrodynamics.resistance(velocity, BOATS["otter"]) - damped,
        row(-10.8525, 25.65, 19.075),
        rtol=1e-12,
    )


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("step", [0.005, 0.02, 0.5])
def test_energy_never_grows_without_forces(name, step):
    velocity = np.random.default_rng(3).normal(size=(200, 3)) * [2.0, 1.0, 1.0]
    before = hydrodynamics.energy(velocity, BOATS[name])
    for _ in range(40):
        velocity = hydrodynamics.moved(velocity, np.zeros((200, 3)), BOATS[name], step)
        after = hydrodynamics.energy(velocity, BOATS[name])
        assert (after <= before * (1.0 + 1e-12)).all()
        before = after


@pytest.mark.parametrize("name", EVERY)
def test_the_coriolis_matrix_does_no_work(name):
    free = BOATS[name]._replace(linear=(0.0,) * 3, quadratic=(0.0,) * 3)
    velocity = np.random.default_rng(4).normal(size=(50, 3))
    work = (velocity * hydrodynamics.resistance(velocity, free)).sum(axis=1)
    np.testing.assert_allclose(work, 0.0, atol=1e-9)
    begin = hydrodynamics.energy(velocity, free)
    for _ in range(100):
        velocity = hydrodynamics.moved(velocity, np.zeros((50, 3)), free, 0.02)
    np.testing.assert_allclose(hydrodynamics.energy(velocity, free), begin, rtol=1e-9)


@pytest.mark.parametrize("name", EVERY)
def test_a_boat_without_thrust_drifts_with_the_current(name):
    current, pose = np.array([0.3, -0.4]), row(1.0, 2.0, 0.8)
    # At rest over ground at first.
    velocity = -hydrodynamics.over_ground(np.zeros((1, 3)), pose[:, 2], current)
    np.testing.assert_allclose(
        hydrodynamics.over_ground(velocity, pose[:, 2], current), 0.0, atol=1e-12
    )
    for _ in range(300):
        after = hydrodynamics.moved(velocity, np.zeros((1, 3)), BOATS[name], 0.1)
        last, pose = pose, hydrodynamics.drifted(pose, 0.5 * (velocity + after), current, 0.1)
        velocity = after
    np.testing.assert_allclose((pose - last)[0, :2] / 0.1, current, atol=2e-3)


def test_the_way_through_the_water_is_exact_while_the_velocity_holds():
    pose = row(0.0, 0.0, 0.0)
    once = hydrodynamics.drifted(pose, row(1.0, 0.0, 0.5), np.array([0.2, 0.1]), np.pi)
    # A quarter of a circle of 2 m, and pi seconds of the current.
    np.testing.assert_allclose(
        once, row(2.0 + 0.2 * np.pi, 2.0 + 0.1 * np.pi, 0.5 * np.pi), atol=1e-12
    )
    for _ in range(100):
        pose = hydrodynamics.drifted(pose, row(1.0, 0.0, 0.5), np.array([0.2, 0.1]), np.pi / 100)
    np.testing.assert_allclose(pose, once, atol=1e-12)


def test_wind_pushes_an_unpowered_boat():
    # 0.5 (5 - u)^2 = 51.3 u + 72.4 u^2: 0.180 m/s.
    numbers, velocity = BOATS["wamv"], np.zeros((1, 3))
    for _ in range(600):
        air = row(5.0, 0.0) - velocity[:, :2]
        force = hydrodynamics.wind_force(air, numbers)
        velocity = hydrodynamics.moved(velocity, force, numbers, 0.1)
    np.testing.assert_allclose(velocity, row(0.180, 0.0, 0.0), atol=1e-3)
    np.testing.assert_allclose(
        hydrodynamics.wind_force(row(2.0, -3.0), numbers), row(2.0, -4.5, 3.96)
    )


def test_curves_of_thrusters():
    heron, otter, wamv = (BOATS[name] for name in ("heron", "otter", "wamv"))
    np.testing.assert_allclose(thrusters.thrust(row(0.5, -0.5), heron), row(22.5, -12.5))
    np.testing.assert_allclose(thrusters.thrust(row(9.0, -9.0), heron), row(45.0, -25.0))
    np.testing.assert_allclose(
        thrusters.thrust(row(103.93, -101.74), otter), row(119.68, -66.71), atol=0.01
    )
    np.testing.assert_allclose(thrusters.thrust(row(1.0, 1.0), wamv).sum(), 485.3, atol=0.1)
    np.testing.assert_allclose(thrusters.thrust(row(0.005, -0.005), wamv), 0.0)
    np.testing.assert_allclose(thrusters.thrust(row(-1.0, 0.0), wamv), row(-101.85, 0.0), atol=0.01)


@pytest.mark.parametrize("name", EVERY)
def test_the_command_for_a_thrust_gives_it(name):
    numbers = BOATS[name]
    wanted = np.linspace(-20.0, 40.0, 24).reshape(12, 2)
    wanted[np.abs(wanted) < 1.3] = 0.0  # less a WAM-V does not give
    command = thrusters.command_for(wanted, numbers)
    np.testing.assert_allclose(thrusters.thrust(command, numbers), wanted, atol=1e-6)
    np.testing.assert_allclose(thrusters.command_for(np.zeros((1, 2)), numbers), 0.0, atol=0.01)
    np.testing.assert_allclose(
        thrusters.thrust(thrusters.command_for(np.zeros((1, 2)), numbers), numbers), 0.0
    )


def test_who_pushes_how_much():
    heron = BOATS["heron"]
    # 30 N ahead and 3.78 N m to the left: 15 N each, and 5 N more on the right than in the middle.
    given = thrusters.allocated(np.array([30.0]), np.array([3.78]), heron)
    np.testing.assert_allclose(given, row(10.0, 20.0))
    # Full ahead and a turn to the right: the turn is kept.
    given = thrusters.allocated(np.array([90.0]), np.array([-7.56]), heron)
    np.testing.assert_allclose(given, row(45.0, 25.0))
    # More torque than there is: 35 N to either side of 10 N.
    given = thrusters.allocated(np.array([0.0]), np.array([99.0]), heron)
    np.testing.assert_allclose(given, row(-25.0, 45.0))


def test_a_propellers_shaft_lags():
    otter = BOATS["otter"]
    after = thrusters.after_lag(row(0.0, 50.0), row(100.0, 50.0), otter, 0.1)
    np.testing.assert_allclose(after, row(63.2121, 50.0), atol=1e-4)


def driven(name, wanted, duration, step=0.02):
    """Return boats of a kind, one for each of ``wanted`` (m, 2) [m/s, rad/s], after ``duration`` [s]."""
    wanted, force = np.array(wanted), np.zeros((len(wanted), 3))
    afloat = vessel_dynamics.begin(len(wanted))
    for _ in range(int(round(duration / step))):
        afloat, _ = vessel_dynamics.advanced(afloat, force, BOATS[name], step, wanted)
    return afloat


@pytest.mark.parametrize(
    "name, surge, yaw",
    [("heron", 0.8503, 0.4545), ("otter", 0.5244, 0.3341), ("wamv", 0.8396, 0.5023)],
)
def test_speeds_are_held_by_their_controllers(name, surge, yaw):
    times = vessel_dynamics.responses(BOATS[name]).ravel()
    np.testing.assert_allclose(times, [surge, yaw], atol=1e-3)
    told = np.array([(1.0, 0.0), (0.8, 0.2), (0.3, -0.3), (9.0, 0.0)])
    held = driven(name, told, 20.0).velocity
    np.testing.assert_allclose(held[:3, 0], told[:3, 0], rtol=0.0, atol=0.1)
    # The Heron's controller of turning has no integral.
    atol = 0.08 if name == "heron" else 0.04
    np.testing.assert_allclose(held[:3, 2], told[:3, 1], rtol=0.0, atol=atol)
    # A boat cannot do more than its thrusters.
    most = thrusters.thrust(row(999.0, 999.0), BOATS[name]).sum()
    assert held[3, 0] == pytest.approx(steady_speed(most, BOATS[name]), rel=1e-3)


def test_the_integral_waits_while_thrusters_give_all_they_can():
    afloat = driven("otter", [(9.0, 0.0)], 30.0)
    assert abs(afloat.integral[0, 0]) < 1.0
    for _ in range(500):
        afloat, _ = vessel_dynamics.advanced(
            afloat, np.zeros((1, 3)), BOATS["otter"], 0.02, row(1.0, 0.0)
        )
    # It slowed down from 3.09 m/s, with more than wanted for a while.
    assert afloat.velocity[0, 0] == pytest.approx(1.0, abs=0.06)


def test_what_a_boat_of_one_kind_does_another_beside_it_does_not_change():
    numbers = both(*(BOATS[name] for name in EVERY))
    afloat, wanted = vessel_dynamics.begin(3), np.tile(row(0.8, 0.2), (3, 1))
    for _ in range(100):
        afloat, _ = vessel_dynamics.advanced(afloat, np.zeros((3, 3)), numbers, 0.02, wanted)
    for robot, name in enumerate(EVERY):
        alone = driven(name, [(0.8, 0.2)], 2.0)
        for part, own in zip(afloat, alone):
            np.testing.assert_allclose(part[robot], own[0], rtol=1e-9, atol=1e-12)
