"""Errors of wheel odometry: UMBmark's square in closed form, and the velocity motion model's statistics."""

import math

import numpy as np
import pytest

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.team.odometry_errors import (
    OdometryErrors,
    step_deviations,
    true_squares,
)
from mrs_simulator.world.wheel_odometry.covariance import OdometryCovariance
from mrs_simulator.world.world import EVERY, World, WorldError

TRACK = 0.357  # [m] of a P3-DX


def square_return(errors, side, track, clockwise=False):
    """Return where a robot ends, (x, y) [m], that by its odometry has driven a square of ``side`` [m].

    It begins at 0 along x and turns on the spot at each corner by 90 deg as it believes; exact arcs.
    ``track`` [m]: the nominal one.  A closed form to compare runs with.
    """
    left, right = errors.wheels
    way = 1.0 if not clockwise else -1.0
    bend = (
        (right - left) * side / (errors.Eb * track)
    )  # what is believed to be straight turns by it
    mean = 0.5 * (left + right) * side
    chord = mean * (math.sin(0.5 * bend) / (0.5 * bend) if bend else 1.0)
    turn = way * 0.25 * math.pi * (left + right) / errors.Eb
    drift = way * 0.125 * math.pi * track * (right - left)  # along the arc of a corner
    x = y = heading = 0.0
    for _ in range(4):
        x += chord * math.cos(heading + 0.5 * bend)
        y += chord * math.sin(heading + 0.5 * bend)
        heading += bend
        arc = drift * (math.sin(0.5 * turn) / (0.5 * turn))
        x += arc * math.cos(heading + 0.5 * turn)
        y += arc * math.sin(heading + 0.5 * turn)
        heading += turn
    return x, y


def world(errors, n=1, **more):
    content = dict({"robots": n, "limits": "none", "odometry": "wheel"}, **more)
    content["poses"] = [[0.0, 4.0 * k, 0.0] for k in range(n)]
    return World.from_scenario(scenario_from_dict(dict(content, odometry_errors=errors)))


def drive(moved, v, w, seconds):
    for _ in range(int(round(seconds / moved.step_size))):
        moved.set_commands(EVERY, np.array([[v, w]] * moved.n))
        moved.step()


CASES = [  # Ed, Eb, clockwise, and the return error [mm] on a 4 m square
    (1.005, 1.0, True, (-405, -507)),
    (1.005, 1.0, False, (480, -383)),
    (1.0, 1.01, True, (-122, -128)),
    (1.0, 1.01, False, (-122, 128)),
]


@pytest.mark.parametrize("ed, eb, clockwise, wanted", CASES)
def test_the_square_of_umbmark_has_its_return_errors(ed, eb, clockwise, wanted):
    errors = OdometryErrors(Ed=ed, Eb=eb)
    closed = square_return(errors, 4.0, TRACK, clockwise)
    assert [1000.0 * value for value in closed] == pytest.approx(wanted, abs=0.5)
    # The odometry believes the square that is commanded: legs of 8 s, corners of 2 s.
    moved, way = world({"Ed": ed, "Eb": eb}), -1.0 if clockwise else 1.0
    for _ in range(4):
        drive(moved, 0.5, 0.0, 8.0)
        drive(moved, 0.0, way * 0.25 * math.pi, 2.0)
    assert moved.estimates.odometry()[0, :2] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert moved.pose[0, :2] == pytest.approx(closed, abs=1e-9)


RADIUS = 71.5785  # [m] of the circle that is commanded straight: 0.357 (1.005 + 1)/(2 (1.005 - 1))


def circle(pose):
    """Return the radius [m] of the circle along x at 0 on which a robot is at ``pose``."""
    return (pose[0] ** 2 + pose[1] ** 2) / (2.0 * pose[1])


EXACT = [("kinematic", "pybullet"), ("dynamic", "planar")]


@pytest.mark.parametrize("fidelity, engine", EXACT)
def test_unequal_wheels_let_the_robot_veer_and_not_its_odometry(fidelity, engine):
    more = {"fidelity": fidelity, "limits": "firmware"}
    if fidelity == "dynamic":
        more["engine"] = engine
    moved = world({"Ed": 1.005}, **more)
    drive(moved, 0.5, 0.0, 4.0)
    assert circle(moved.pose[0]) == pytest.approx(RADIUS, rel=1e-9)
    gone = moved.estimates.odometry()[0, 0]
    assert moved.pose[0, 2] == pytest.approx(gone / RADIUS, rel=1e-9) and gone > 1.5
    assert moved.estimates.odometry()[0, 1:] == pytest.approx([0.0, 0.0], abs=1e-9)
    moved.close()
    moved = world({"Eb": 1.1}, **more)
    drive(moved, 0.0, 0.5, 4.0)
    assert moved.twist[0, 2] == pytest.approx(0.454545, abs=1e-4)  # 0.5/1.1
    assert moved.estimates.odometry()[0, 2] == pytest.approx(
        1.1 * moved.pose[0, 2], abs=1e-3
    )  # of 1.9
    moved.close()


@pytest.mark.parametrize("kind, rate", [("pioneer3dx", 0.133387), ("husky", 0.044494)])
def test_in_pybullet_they_veer_as_far_as_its_wheels_hold(kind, rate):
    """0.5 m/s straight, Ed = 1.1: 0.5 2 (1.1 - 1)/((1.1 + 1) b), with tracks of 0.357 m and 1.07025 m."""
    moved = world({"Ed": 1.1}, model=kind, fidelity="dynamic")
    drive(moved, 0.5, 0.0, 1.0)
    assert moved.twist[0, 2] == pytest.approx(rate, rel=0.03)
    other = world({}, model=kind, fidelity="dynamic")
    drive(other, 0.5, rate, 1.0)
    assert moved.pose[0] == pytest.approx(other.pose[0], abs=1e-5)
    for each in (moved, other):
        each.close()


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_encoders_count_turns_of_wheels_that_they_take_for_nominal(fidelity):
    moved = world({"Ed": 1.05}, fidelity=fidelity)
    drive(moved, 0.5, 0.0, 2.0)
    (travel,) = moved.sensed().travel
    assert travel[0] == pytest.approx([1.0, 1.0], abs=0.005)
    assert moved.twist[0, 2] == pytest.approx(0.068320, rel=0.04)  # 0.5 2 0.05/(2.05 0.357)
    moved.close()


def test_a_base_beside_a_flyer_and_one_with_an_arm_veer_too():
    poses = [[0.0, 0.0, 0.0], [0.0, 9.0, 0.0]]
    for kinds in (("pioneer3dx", "crazyflie2"), ("husky_panda", "pioneer3dx")):
        errors = OdometryErrors(Ed=1.1)
        more = {"odometry_kind": "wheel", "limits": None, "odometry_errors": errors}
        moved = World(kinds, poses, fidelity="dynamic", **more)
        command = np.zeros((2, len(moved.team.axes)))
        command[:, 0] = 0.5
        for _ in range(50):
            moved.set_commands(EVERY, command)
            moved.step()
        wheeled = [row for row, name in enumerate(kinds) if name != "crazyflie2"]
        tracks = [moved.team.kinds[row].numbers.track for row in wheeled]
        wanted = [0.5 * 2.0 * 0.1 / (2.1 * track) for track in tracks]
        assert moved.twist[wheeled, 2] == pytest.approx(wanted, rel=0.1)
        moved.close()


def test_without_errors_odometry_is_exact():
    moved = world({})
    drive(moved, 0.5, 0.3, 4.0)
    assert moved.estimates.odometry()[0] == pytest.approx(moved.pose[0], abs=1e-9)


@pytest.mark.parametrize("step", [0.02, 0.01])
def test_the_velocity_model_has_its_variances_whatever_the_step(step):
    n = 2500
    moved = world({"alpha": [0.04, 0.0, 0.01, 0.0, 0.0, 0.0]}, n, step=step)
    drive(moved, 0.5, 0.0, 1.0)
    error = moved.estimates.odometry() - moved.pose + [0.0, 4.0, 0.0] * np.arange(n)[:, np.newaxis]
    # Over 1 s at 0.5 m/s: a distance of sqrt(0.04 0.5^2) = 0.1 m, a turn of 0.05 rad.
    four = 4.0 / np.sqrt(2.0 * n)
    assert error[:, 0].std() == pytest.approx(0.1, rel=four)
    assert error[:, 2].std() == pytest.approx(0.05, rel=four)
    assert abs(np.corrcoef(error[:, 0], error[:, 2])[0, 1]) < 4.0 / np.sqrt(n)


def test_a_turn_on_the_spot_errs_by_its_own_alphas():
    n = 2500
    moved = world({"alpha": [0.0, 0.0, 0.0, 0.01, 0.0, 0.03]}, n)
    drive(moved, 0.0, 0.5, 1.0)
    error = moved.estimates.odometry()[:, 2] - moved.pose[:, 2]
    # Turn and heading add up: sqrt((0.01 + 0.03) 0.5^2) = 0.1 rad.
    assert error.std() == pytest.approx(0.1, rel=4.0 / np.sqrt(2.0 * n))
    drift = moved.estimates.odometry()[:, :2]
    assert np.abs(drift).max() < 1e-9


def test_a_robot_errs_by_itself():
    errors = {"alpha": [0.04, 0.0, 0.01, 0.0, 0.0, 0.0]}
    alone, beside = world(errors), world(errors, 3)
    for moved in (alone, beside):
        drive(moved, 0.5, 0.1, 1.0)
    assert np.array_equal(alone.estimates.odometry()[0], beside.estimates.odometry()[0])
    assert not np.array_equal(beside.estimates.odometry()[0], beside.estimates.odometry()[1])


@pytest.mark.parametrize(
    "errors, more, wanted",
    [
        ({"alpha": [0.1]}, {}, "odometry_errors.alpha: .0.1., wanted a list of 6"),
        (
            {"alpha": [0, 0, -1, 0, 0, 0]},
            {},
            r"odometry_errors.alpha\[2\]: -1, wanted a number of at least 0",
        ),
        ({"Ed": 0.0}, {}, "odometry_errors.Ed: 0.0, wanted a number from 0.5 to 2"),
        ({"ed": 1.0}, {}, "odometry_errors: unknown 'ed' .known: Eb, Ed, alpha"),
        ({}, {"odometry": "world"}, "odometry_errors: given, but odometry is world"),
    ],
)
def test_impossible_errors_are_refused_by_name(errors, more, wanted):
    with pytest.raises(ScenarioError, match=wanted):
        world(errors, **more)


def test_unequal_wheels_are_of_robots_with_a_left_and_a_right_one():
    for model in ("robotino3", "f1tenth"):
        with pytest.raises(WorldError, match="Ed = 1.01, Eb = 1, but a .* has no left and right"):
            world({"Ed": 1.01}, model=model)
    world({"alpha": [0.1] * 6}, model="robotino3")


# A gyro, and factors drawn once ----------------------------------------------------------------


def test_a_gyro_takes_the_place_of_the_wheels_turns():
    """A wrong track is not felt: the gyro tells the true turn, the wheels the true way of the centre."""
    moved = world({"Eb": 1.1, "gyro": {}})
    drive(moved, 0.4, 0.5, 5.0)
    assert moved.estimates.pose()[0] == pytest.approx(
        moved.pose[0], abs=1e-5
    )  # arcs bend otherwise
    wrong = world({"Eb": 1.1})
    drive(wrong, 0.4, 0.5, 5.0)
    assert wrong.estimates.odometry()[0, 2] == pytest.approx(1.1 * wrong.pose[0, 2], abs=1e-9)


def test_a_gyros_bias_turns_the_odometry():
    moved = world({"gyro": {"bias": 0.01}})
    drive(moved, 0.0, 0.0, 10.0)
    assert moved.estimates.odometry()[0] == pytest.approx([0.0, 0.0, 0.1], abs=1e-9)
    moved.reset()
    drive(moved, 0.0, 0.0, 1.0)
    assert moved.estimates.odometry()[0, 2] == pytest.approx(0.01, abs=1e-9)


def test_a_gyros_angle_walks_by_the_root_of_time():
    moved = world({"gyro": {"walk": 0.02}}, n=300)
    drive(moved, 0.0, 0.0, 4.0)
    assert moved.estimates.odometry()[:, 2].std() == pytest.approx(0.04, rel=0.15)


def test_factors_are_even_and_kept():
    moved = world({"factor": 0.1}, n=400)
    drive(moved, 0.5, 0.0, 1.0)
    first = moved.estimates.odometry()[:, 0] / 0.5 - 1.0
    assert np.abs(first).max() <= 0.1 and np.abs(first.mean()) < 0.01
    assert first.std() == pytest.approx(0.1 / math.sqrt(3.0), rel=0.1)
    drive(moved, 0.5, 0.0, 1.0)
    assert moved.estimates.odometry()[:, 0] == pytest.approx(1.0 + first, abs=1e-9)
    drive(moved, 0.0, 0.5, 1.0)
    turned = moved.estimates.odometry()[:, 2] / 0.5 - 1.0
    assert abs(np.corrcoef(first, turned)[0, 1]) < 0.2 and np.abs(turned).max() <= 0.1


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"factor": 0.6}, "factor: 0.6"),
        ({"gyro": {"drift": 1}}, "unknown 'drift'"),
        ({"gyro": {"walk": -1}}, "walk"),
    ],
)
def test_wrong_factors_and_gyros_are_named(wrong, said):
    with pytest.raises(ScenarioError, match=said):
        world(wrong)


def test_they_are_written_as_they_are_read():
    given = {"factor": 0.01, "gyro": {"bias": 0.001, "walk": 0.002}}
    content = {"poses": [[0, 0, 0]], "odometry": "wheel", "odometry_errors": given}
    errors = scenario_from_dict(content).odometry_errors
    again = scenario_from_dict(dict(content, odometry_errors=errors.to_plain()))
    assert again.odometry_errors == errors == OdometryErrors(factor=0.01, gyro=(0.001, 0.002))


def test_the_noise_in_odometrys_speeds_is_known():
    """Squares of noisy speeds, with the noise taken out, have the mean of the true ones' squares."""
    alpha, step, v, w = (0.02, 0.01, 0.004, 0.02, 0.002, 0.002), 0.02, 0.3, 0.5
    draw, m = np.random.default_rng(3), 40000
    distance, turn, heading = step_deviations(alpha, v, w, step)
    told_v = v + distance / step * draw.normal(size=m)
    told_w = w + np.hypot(turn, heading) / step * draw.normal(size=m)
    assert (told_v**2).mean() > 1.5 * v * v  # most of it would be noise
    mean = [(told_v**2).mean() ** 0.5], [(told_w**2).mean() ** 0.5]
    squares = true_squares(alpha, *map(np.array, mean), step)
    np.testing.assert_allclose(squares[:, 0], [v * v, w * w], rtol=0.02)
    assert not true_squares(alpha, np.zeros(1), np.zeros(1), step).any()


# How sure it is --------------------------------------------------------------------------------


def driven(errors, n, legs, every=1):
    """Return the covariances (n, 3, 3) that are told of robots that have driven ``legs``, and their world.

    Each is (v, w, seconds); odometry is told ``every`` so many steps of 0.1 s.
    """
    moved = world(errors, n, control={"rate": 10.0}, step=0.1)
    content = {"poses": [[0, 0, 0]], "odometry": "wheel", "odometry_errors": errors}
    given = scenario_from_dict(content).odometry_errors
    sure = OdometryCovariance(moved.team, given, moved.pose, moved.estimates.odometry())
    for v, w, seconds in legs:
        for _ in range(int(round(seconds / 0.1 / every))):
            for _ in range(every):
                moved.set_commands(EVERY, np.array([[v, w]] * n))
                moved.step()
            sure.follow(moved.pose, moved.estimates.odometry(), 0.1 * every)
    return sure.covariance(), moved


LEGS = ((0.5, 0.0, 1.0), (0.3, 0.8, 1.6))


@pytest.mark.parametrize(
    "n, every, errors",
    [
        (
            10000,
            1,
            {
                "alpha": [0.01, 0.0, 0.0, 0.002, 0.002, 0.001],
                "gyro": {"walk": 0.02},
                "factor": 0.03,
            },
        ),
        (2000, 2, {"alpha": [0.01, 0.004, 0.0, 0.002, 0.002, 0.001]}),
        (2000, 1, {"factor": 0.05}),
    ],
)
def test_the_covariance_published_is_that_of_ten_thousand_robots(n, every, errors):
    told, moved = driven(errors, n, LEGS, every)
    error = relative_errors(moved)
    found, expected = np.cov(error.T), told.mean(axis=0)
    # A covariance of n draws is within 4 of its standard deviations; 3 % more for what is not linear.
    variances = np.diagonal(expected)
    spread = np.sqrt((expected**2 + np.outer(variances, variances)) / n)
    scale = np.sqrt(np.outer(variances, variances))
    assert (np.abs(found - expected) < 4.0 * spread + 0.03 * scale).all(), (found, expected)


def relative_errors(moved):
    """Return how far odometry is off, (n, 3), in the axes in which robots began."""
    return (
        moved.estimates.odometry()
        - moved.pose
        + [0.0, 4.0, 0.0] * np.arange(moved.n)[:, np.newaxis]
    )


@pytest.mark.parametrize("errors", [{"Ed": 1.005}, {"Eb": 1.01}, {"gyro": {"bias": 0.01}}])
def test_what_is_always_alike_has_its_own_square_as_variance(errors):
    told, moved = driven(errors, 1, LEGS)
    error = relative_errors(moved)[0]
    np.testing.assert_allclose(told[0], np.outer(error, error), atol=0.04 * (error @ error))


def test_who_stands_is_as_sure_as_before_and_another_run_begins_surely():
    told, _ = driven({"alpha": [0.01] * 6}, 1, [(0.0, 0.0, 2.0)])
    assert not told.any()
    moved, _ = driven({"alpha": [0.01] * 6}, 1, LEGS)
    more, _ = driven({"alpha": [0.01] * 6}, 1, (*LEGS, (0.0, 0.0, 2.0)))
    np.testing.assert_allclose(more, moved, rtol=0.02)  # it ramps down
