"""Trajectories of minimum snap, and how closely robots that fly follow them."""

import math

import numpy as np
import pytest

from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.shapes.published import least_snap
from mrs_simulator.protocols.trajectory.equations import minimum_snap, tracking_bound
from mrs_simulator.protocols.trajectory.law import read_waypoints
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import run_experiment

POINTS = np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 1.5], [4.0, 2.5, 2.0], [1.0, 4.0, 1.5]])


def test_one_leg_is_the_known_polynomial():
    """From rest to rest over T: ``s = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7``, x = t/T."""
    curve = minimum_snap([[0.0], [2.0]], 0.5)
    assert curve.times.tolist() == [0.0, 4.0]
    np.testing.assert_allclose(
        curve.pieces[0, :, 0] / 2.0, [0, 0, 0, 0, 35, -84, 70, -20], atol=1e-9
    )


def test_it_passes_its_points_smoothly_and_rests_at_its_ends():
    curve = minimum_snap(POINTS, 0.4)
    np.testing.assert_allclose(curve.at(curve.times), POINTS, atol=1e-9)
    for order in (1, 2, 3):
        np.testing.assert_allclose(curve.at(curve.times[[0, -1]], order), 0.0, atol=1e-9)
    for order in range(1, 7):
        before = curve.at(curve.times[1:-1] - 1e-9, order)
        after = curve.at(curve.times[1:-1], order)
        np.testing.assert_allclose(before, after, atol=1e-6)
    late = curve.times[-1] + np.array([0.1, 5.0])
    np.testing.assert_allclose(curve.at(late), np.tile(POINTS[-1], (2, 1)), atol=1e-12)


@pytest.mark.parametrize("points", [POINTS, POINTS[:, :2], POINTS[:2], POINTS[:1]])
def test_it_is_stated_twice(points):
    curve, other = minimum_snap(points, 0.4), least_snap(points, 0.4)
    time = np.linspace(0.0, curve.times[-1] + 1.0, 40)
    np.testing.assert_allclose(curve.at(time), [other(each) for each in time], atol=1e-9)


def test_resting_at_each_point_costs_more_snap():
    def cost(curve):
        time = np.linspace(0.0, curve.times[-1], 4001)[:-1]
        return np.sum(curve.at(time, 4) ** 2)

    best, rest = minimum_snap(POINTS, 0.4), [0, 0, 0, 0, 35, -84, 70, -20]
    steps = np.diff(POINTS, axis=0)
    pieces = steps[:, np.newaxis] * np.reshape(rest, (8, 1))
    pieces[:, 0] = POINTS[:-1]
    resting = best._replace(pieces=pieces)
    np.testing.assert_allclose(resting.at(best.times), POINTS, atol=1e-9)
    assert cost(best) < 0.7 * cost(resting)
    half = best._replace(pieces=0.5 * (best.pieces + pieces))
    assert cost(best) < cost(half) < cost(resting)


def test_the_bound_on_tracking_is_met_and_close():
    """A double integration of ``T e'' + e' + k e = T r''`` at the worst r'': constant."""
    late, gain, most = 0.4, 0.5, 0.3
    bound = tracking_bound(0.0, most, gain, late)
    assert bound == pytest.approx(0.24)
    error = rate = 0.0
    for _ in range(40000):
        rate += 1e-3 * (most - (rate + gain * error) / late)
        error += 1e-3 * rate
    assert 0.99 * bound < error < bound * (1.0 + 1e-6)
    assert math.isnan(tracking_bound(0.0, most, 1.0, late))


@pytest.mark.parametrize(
    "text", ["", "0 0", "0 0 1, 1", "a b c", "0 0 1, 0 0 1", "0 0 nan", "0 0 1,, 1 1 1", "1e9 0 0"]
)
def test_waypoints_that_are_none_are_refused(text):
    with pytest.raises(ValueError, match="waypoints = "):
        read_waypoints(text, 3)


def following(**more):
    content = {
        "model": "ardrone2",
        "poses": [[0.0, 0.0, 0.4]],
        "altitude": 1.0,
        "control": {
            "protocol": "trajectory",
            "dimension": 3,
            "rate": 20,
            "parameters": {"gain": 0.3, "waypoints": "0 0 1, 2 1 1.6", "speed": 0.4},
        },
        "duration": 8.0,
        "step": 0.05,
    }
    return scenario_from_dict(dict(content, **more))


@pytest.mark.parametrize("fidelity", ["point_mass", "kinematic", "dynamic"])
def test_a_drone_follows_within_its_bound(fidelity, tmp_path):
    verdict = run_experiment(following(fidelity=fidelity), str(tmp_path), formats=())
    assert verdict["outcome"] == "passed", verdict["checks"]
    bound = next(c for c in verdict["checks"] if c["name"] == "tracking error [m]")
    least, most = (0.0, 1e-6) if fidelity == "point_mass" else (0.05, 0.4)
    assert bound["passed"] and least < bound["measured"] < most


def test_waypoints_of_another_dimension_name_what_is_wanted():
    scenario = following()
    flat = scenario._replace(control=scenario.control._replace(dimension=2))
    with pytest.raises(ValueError, match="wanted points of 2 numbers each, as in '0 0, 4 3'"):
        make_control(flat)
