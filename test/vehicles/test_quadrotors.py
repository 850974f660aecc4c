"""Quadrotors as the world moves them, without forces and with them."""

import numpy as np
import pytest
from flight_fixtures import crazyflie, tilts

from mrs_simulator.core.spatial import headings
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.vehicles.drives import compiled_flight, quadrotor, quadrotor_forces
from mrs_simulator.vehicles.drives.compiled_flight import table_of
from mrs_simulator.vehicles.drives.flight import at_rest
from mrs_simulator.vehicles.drives.rotors import hover_speed
from mrs_simulator.vehicles.limits import AxisLimits

ONE = crazyflie()
LIMITS = AxisLimits(np.array([1.0, 1.0, 1.0, 2.0]), np.full(4, np.inf))
BOTH = pytest.mark.parametrize("motion", [quadrotor, quadrotor_forces])
STEP = 0.02


def row(*values):
    return np.array([values])


def flown(motion, inner, command, duration):
    for _ in range(int(round(duration / STEP))):
        inner = motion.flown(inner, np.array(command), LIMITS, ONE, STEP)
    return inner


def hovering(motion, *pose, z=1.0):
    return motion.begin(row(*pose), np.array([z]), ONE)


@BOTH
def test_a_command_of_zero_hovers(motion):
    inner = flown(motion, hovering(motion, 1.0, 2.0, 0.5), row(0.0, 0.0, 0.0, 0.0), 5.0)
    pose, twist, spatial = motion.state(inner)
    np.testing.assert_allclose(pose, row(1.0, 2.0, 0.5), atol=1e-9)
    np.testing.assert_allclose(twist, 0.0, atol=1e-9)
    np.testing.assert_allclose(spatial.z, 1.0, atol=1e-9)
    np.testing.assert_allclose(spatial.twist, 0.0, atol=1e-9)


@BOTH
def test_commands_are_along_the_heading_and_up(motion):
    inner = flown(motion, hovering(motion, 0.0, 0.0, 0.5 * np.pi), row(0.5, 0.2, 0.3, 0.0), 5.0)
    pose, twist, spatial = motion.state(inner)
    np.testing.assert_allclose(twist, row(0.5, 0.2, 0.0), atol=5e-3)  # body frame, a little tilted
    np.testing.assert_allclose(spatial.twist, row(0.3, 0.0, 0.0), atol=8e-3)
    # Less what is lost until it goes that fast.
    assert pose[0, 1] == pytest.approx(2.5, abs=0.15)
    assert pose[0, 0] == pytest.approx(-1.0, abs=0.07)
    assert spatial.z[0] == pytest.approx(2.5, abs=0.1)


@BOTH
def test_it_turns_on_the_spot_and_in_flight(motion):
    inner = flown(motion, hovering(motion, 0.0, 0.0, 0.0), row(0.0, 0.0, 0.0, 1.0), 4.0)
    pose, twist, spatial = motion.state(inner)
    assert pose[0, 2] == pytest.approx(4.0 - 2.0 * np.pi, abs=0.06)
    assert twist[0, 2] == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(pose[0, :2], 0.0, atol=1e-3)
    assert headings(spatial.orientation)[0] == pytest.approx(pose[0, 2], abs=1e-9)
    # A circle of 0.5 m while it turns by 1 rad/s.
    seen = []
    for _ in range(430):
        inner = flown(motion, inner, row(0.5, 0.0, 0.0, 1.0), STEP)
        seen.append(motion.state(inner)[0][0, :2].copy())
    across = np.ptp(np.array(seen)[110:], axis=0)
    np.testing.assert_allclose(across, 1.0, atol=0.08)


@BOTH
def test_it_leans_into_where_it_speeds_up(motion):
    inner = flown(motion, hovering(motion, 0.0, 0.0, 1.0), row(1.0, 0.0, 0.0, 0.0), 0.1)
    _, _, spatial = motion.state(inner)
    assert tilts(spatial.orientation)[0] > 0.1
    assert headings(spatial.orientation)[0] == pytest.approx(1.0, abs=1e-6)
    x, y, z, w = spatial.orientation[0]
    up = np.array([2.0 * (x * z + w * y), 2.0 * (y * z - w * x)])
    np.testing.assert_allclose(up / np.hypot(*up), [np.cos(1.0), np.sin(1.0)], atol=1e-3)


@BOTH
def test_it_stands_until_it_is_commanded_to_rise_and_again_once_it_has_landed(motion):
    inner = hovering(motion, 0.0, 0.0, 0.3, z=0.0)
    inner = flown(motion, inner, row(0.8, 0.0, 0.0, 1.0), 1.0)
    pose, twist, spatial = motion.state(inner)
    np.testing.assert_allclose(pose, row(0.0, 0.0, 0.3), atol=1e-12)
    assert spatial.z[0] == 0.0
    inner = flown(motion, inner, row(0.0, 0.0, 0.5, 0.0), 2.0)
    assert motion.state(inner)[2].z[0] == pytest.approx(0.9, abs=0.15)
    for _ in range(350):
        inner = flown(motion, inner, row(0.3, 0.0, -0.5, 0.0), STEP)
        z = motion.state(inner)[2].z
        if z[0] < 0.0:  # as the world does
            place = np.column_stack([motion.state(inner)[0][:, :2], [0.0]])
            inner = motion.stopped(inner, z < 0.0, place, np.array([np.inf, np.inf, 0.0]))
    pose, twist, spatial = motion.state(inner)
    assert spatial.z[0] == 0.0
    np.testing.assert_allclose(twist, 0.0, atol=1e-6)
    np.testing.assert_allclose(tilts(spatial.orientation), 0.0, atol=1e-6)
    assert 0.2 < pose[0, 0] < 0.8


def test_rotors_run_out_on_the_ground():
    inner = hovering(quadrotor_forces, 0.0, 0.0, 0.0, z=0.0)
    assert not inner.flight.rotors.any()
    assert hovering(quadrotor_forces, 0.0, 0.0, 0.0).flight.rotors == pytest.approx(
        hover_speed(ONE)
    )
    inner = flown(quadrotor_forces, inner, row(0.0, 0.0, 0.5, 0.0), 1.0)
    place = row(0.0, 0.0, 0.0)
    inner = quadrotor_forces.stopped(inner, np.array([True]), place, np.zeros(3))
    inner = flown(quadrotor_forces, inner, row(0.0, 0.0, 0.0, 0.0), 0.072)
    left = inner.flight.rotors / hover_speed(ONE)
    np.testing.assert_allclose(left, np.exp(-0.08 / 0.072), atol=0.05)


def test_the_height_is_held_with_forces():
    inner = hovering(quadrotor_forces, 0.0, 0.0, 0.0)
    inner = flown(quadrotor_forces, inner, row(0.0, 0.0, 1.0, 0.0), 1.0)
    climbed = inner.place[0, 2]
    inner = flown(quadrotor_forces, inner, row(1.0, 0.0, 0.0, 0.0), 4.0)
    # It comes to rest a quarter of a second after, at 4/s, and stays there while it speeds up.
    assert inner.place[0, 2] == pytest.approx(climbed + 0.25, abs=0.03)
    pushed = quadrotor_forces.stopped(
        inner, np.array([True]), inner.place - [[0.0, 0.0, 0.2]], np.full(3, np.inf)
    )
    back = flown(quadrotor_forces, pushed, row(0.0, 0.0, 0.0, 0.0), 4.0)
    assert back.place[0, 2] == pytest.approx(inner.place[0, 2], abs=0.01)


def in_wind(inner, command, seconds):
    for _ in range(int(round(seconds / STEP))):
        inner = quadrotor_forces.flown(inner, command, LIMITS, ONE, STEP, row(2.0, 0.0, 0.0))
    return inner


def test_wind_carries_one_that_flies_along_by_its_drag_over_its_gain():
    inner = in_wind(hovering(quadrotor_forces, 0.0, 0.0, 0.0), row(0.0, 0.5, 0.0, 0.0), 5.0)
    # 5.56e-3 N s/m of 2 m/s on 27 g against 4/s: 0.412/4.
    assert inner.velocity[0] == pytest.approx([0.103, 0.5, 0.0], abs=0.002)


def test_one_that_hovers_keeps_its_place_in_wind():
    """At first as its gain has it, by 0.103/1.5 m at most; then c learns the 0.103 m/s, and e is 0."""
    inner, farthest = hovering(quadrotor_forces, 0.0, 0.0, 0.7), 0.0
    for _ in range(15):
        inner = in_wind(inner, row(0.0, 0.0, 0.0, 0.0), 1.0)
        farthest = max(farthest, inner.place[0, 0])
    assert 0.02 < farthest < 0.0687
    assert inner.against[0] == pytest.approx([-0.103, 0.0], abs=0.002)
    np.testing.assert_allclose(inner.velocity, 0.0, atol=1e-3)
    np.testing.assert_allclose(inner.place, row(0.0, 0.0, 1.0), atol=2e-3)


@BOTH
def test_one_that_is_stopped_stays_a_time_constant_of_its_velocity_ahead(motion):
    """T = 0.25 s at 0.4 m/s: 0.1 m, with forces as without, since a body's lags take nothing of its way."""
    inner = flown(motion, hovering(motion, 0.0, 0.0, 0.0), row(0.4, 0.0, 0.0, 0.0), 3.0)
    begin = inner.place[0, 0]
    assert begin == pytest.approx(0.4 * (3.0 - 0.25), abs=0.002)
    inner = flown(motion, inner, row(0.0, 0.0, 0.0, 0.0), 5.0)
    assert inner.place[0, 0] - begin == pytest.approx(0.1, abs=0.002)


@pytest.mark.parametrize("name, wanted", [("crazyflie2", (0.25, 0.28)), ("ardrone2", (0.57, 0.60))])
def test_a_step_reaches_63_percent_alike_with_forces_and_without(name, wanted):
    """1 - 1/e after T without forces; with forces three poles at 30/s and 24/s add some 0.03 s."""
    given = kind(name)
    numbers = given.numbers._replace(mass=given.mass)
    found = []
    for motion in (quadrotor, quadrotor_forces):
        inner, count = motion.begin(row(0.0, 0.0, 0.0), np.ones(1), numbers), 0
        while inner.velocity[0, 0] < 0.3 * 0.6321206 - 1e-9:
            inner = motion.flown(inner, row(0.3, 0.0, 0.0, 0.0), LIMITS, numbers, 0.01)
            count = count + 1
        found.append(0.01 * count)
    assert found == pytest.approx(wanted, abs=0.015)


@BOTH
def test_a_contact_takes_velocity_alone_of_those_it_pushed(motion):
    inner = motion.begin(np.zeros((2, 3)), np.ones(2), ONE)
    inner = flown(motion, inner, [[1.0, 0.0, 0.0, 0.0]] * 2, 2.0)
    place = inner.place - 0.1
    after = motion.stopped(inner, np.array([True, False]), place, np.array([0.2, 1.0, 0.0]))
    np.testing.assert_allclose(after.place, [place[0], inner.place[1]])
    np.testing.assert_allclose(after.velocity[:, 0], [0.2, inner.velocity[1, 0]])


def test_a_command_too_fast_keeps_its_direction():
    told = quadrotor.possible(np.array([[4.0, -2.0, 1.0, 9.0], [0.1, 0.2, 0.3, -0.5]]), LIMITS)
    np.testing.assert_allclose(told, [[1.0, -0.5, 0.25, 2.0], [0.1, 0.2, 0.3, -0.5]])
    assert quadrotor.at_limits(row(0.0, 0.0, -0.95, 0.0), LIMITS.top, ONE, 0.9).all()


def test_a_velocity_of_the_point_becomes_a_command_and_back():
    along, across = np.random.default_rng(2).normal(size=(2, 20))
    told = quadrotor.command(along, across, None, 0.05, 0.02, ONE)
    assert not told[:, 2:].any()
    np.testing.assert_array_equal(quadrotor.velocity(told, None, 0.05, 0.02, ONE), (along, across))
    assert quadrotor.arm(0.05, ONE) == quadrotor.lead(0.05, ONE) == 0.0


def test_silence_hovers_first_and_lands_then():
    told = quadrotor.silent(np.array([0.1, 4.9, 5.1]), ONE)
    np.testing.assert_array_equal(told[:, 2], [0.0, 0.0, -0.3])
    assert not told[:, [0, 1, 3]].any()


@pytest.fixture(params=["plain", pytest.param("compiled", marks=pytest.mark.release)])
def loops(request):
    """Return the loops of quadrotors' forces, as Python runs them and compiled."""
    if request.param == "plain":
        return compiled_flight.plain_loops()
    pytest.importorskip("numba")
    return compiled_flight.compiled_loops()


@pytest.mark.parametrize("kinds", [("crazyflie2",), ("crazyflie2", "ardrone2")])
def test_compiled_substeps_lead_to_the_same_bits(loops, kinds, monkeypatch):
    (group,) = Team.of(4 * kinds, "firmware").groups
    draw, m = np.random.default_rng(5), len(group.kinds)
    most = np.full((m, 3), 50.0) if len(kinds) > 1 else (50.0, 50.0, 50.0)
    numbers = group.numbers._replace(turning_max=most)  # without bounds otherwise
    place = np.abs(draw.uniform(-1.0, 1.0, (m, 3))) * [1.0, 1.0, 0.2]  # some come down
    flight = at_rest(place, draw.uniform(-3.0, 3.0, m), hover_speed(numbers))
    velocity, rates = (np.asfortranarray(draw.normal(size=(m, 3))) for _ in range(2))
    flight = flight._replace(velocity=velocity, rates=30.0 * rates)
    wanted, air = draw.uniform(-1.0, 1.0, (2, m, 3))
    wanted[::2] *= 20.0  # beyond what tilt and thrust allow
    heading, turning = draw.uniform(-1.0, 1.0, (2, m))
    told = []
    for chosen in (None, loops):
        monkeypatch.setattr(quadrotor_forces, "same_bits", lambda *_, chosen=chosen, **__: chosen)
        after = flight
        for _ in range(10):
            given = wanted, heading, turning, air, numbers, 0.018
            after = quadrotor_forces.moved(after, *given)
        told.append(after)
    assert all(np.array_equal(*each) for each in zip(*told))
    assert 0 < (told[0].place[:, 2] == 0.0).sum() < m


@pytest.mark.parametrize("kinds", [("crazyflie2",), ("crazyflie2", "ardrone2")])
def test_compiled_steps_lead_to_the_same_bits(loops, kinds, monkeypatch):
    """Robots hold places or heights in wind, climb, turn, are told to fly too fast, and land at last."""
    (group,) = Team.of(6 * kinds, "firmware").groups
    draw, m = np.random.default_rng(6), len(group.kinds)
    pose = np.column_stack([draw.uniform(-1.0, 1.0, (m, 2)), draw.uniform(-3.0, 3.0, m)])
    inner = quadrotor_forces.begin(pose, draw.uniform(0.3, 0.5, m), group.numbers)
    inner = inner._replace(against=np.asfortranarray(draw.choice([-1.0, 0.0, 1.0], (m, 2))))
    commands = np.where(draw.random((30, m, 4)) < 0.5, 0.0, draw.normal(size=(30, m, 4)))
    commands[:, 0], commands[15:, 1:3, 2] = 0.0, -5.0  # one holds its place, two come down
    commands[:, 3] *= 50.0
    air, told, used = np.full((m, 3), 0.5), [], []
    monkeypatch.setattr(
        quadrotor_forces, "table_of", lambda *each: used.append(1) or table_of(*each)
    )
    for chosen in (None, loops):
        monkeypatch.setattr(quadrotor_forces, "same_bits", lambda *_, chosen=chosen, **__: chosen)
        after = inner
        for command in commands:
            for _ in range(4):
                given = after, command, group.limits, group.numbers, 0.02, air
                after = quadrotor_forces.flown(*given)
        told.append(after)
    for one, other in zip(told[0].flight + told[0][1:4], told[1].flight + told[1][1:4]):
        np.testing.assert_array_equal(one, other)
    assert told[0].working is None and told[1].working is None and 40 < len(used) < 120
    assert 0 < (told[0].place[:, 2] == 0.0).sum() < m and np.abs(told[0].against).max() == 1.0
