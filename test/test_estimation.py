"""Estimated poses: the filter by hand and by chi-square, and laws that know estimates alone."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.core.estimates import Estimates
from mrs_simulator.core.odometry_errors import step_deviations
from mrs_simulator.core.recording import read_run_csv
from mrs_simulator.core.scenario import ScenarioError, scenario_from_dict
from mrs_simulator.sensors.estimation import Estimator, Filter, nees
from mrs_simulator.sensors.types.position import GpsReading, geodetic, local_place
from mrs_simulator.study.experiment import Experiment

ALPHA = (0.02, 0.0, 0.0, 0.02, 0.002, 0.002)
# 95 % of the mean of 200 chi-squares of 3 degrees: 600 degrees, over 200, after Wilson and Hilferty.
BOUNDS = 2.670, 3.349


def test_moving_makes_the_estimate_uncertain_as_by_hand():
    estimate = Filter([[1.0, 2.0, 0.5 * np.pi]], np.diag([0.1, 0.2, 0.03])[np.newaxis])
    estimate.move(np.array([[2.0, 0.0, 0.1]]), np.array([[0.05, 0.0, 0.01]]))
    np.testing.assert_allclose(estimate.pose, [[1.0, 4.0, 0.5 * np.pi + 0.1]])
    # A heading that is off by e moves the end of 2 m along y by -2 e along x.
    expected = [
        [0.1 + 4 * 0.03, 0.0, -2 * 0.03],
        [0.0, 0.2 + 0.05, 0.0],
        [-2 * 0.03, 0.0, 0.03 + 0.01],
    ]
    np.testing.assert_allclose(estimate.covariance[0], expected, atol=1e-15)


def test_a_measured_position_is_weighed_by_its_variance():
    estimate = Filter([[0.0, 0.0, 0.0]] * 2, np.tile(np.diag([1.0, 1.0, 0.1]), (2, 1, 1)))
    estimate.correct(
        np.array([0, 1]), np.array([[4.0, 0.0], [np.nan, 1.0]]), [0, 1], np.array([3.0, 3.0])
    )
    np.testing.assert_allclose(estimate.pose, [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(
        np.diagonal(estimate.covariance, 0, 1, 2), [[0.75, 0.75, 0.1], [1, 1, 0.1]]
    )


def test_headings_are_compared_across_the_turn():
    estimate = Filter([[0.0, 0.0, 3.1]], np.diag([0.0, 0.0, 1.0])[np.newaxis])
    estimate.correct(np.array([0]), np.array([[-3.1]]), [2], np.array([1.0]))
    assert abs(estimate.pose[0, 2]) == pytest.approx(np.pi)


def test_an_antenna_ahead_of_the_centre_tells_of_the_heading():
    estimate = Filter([[0.0, 0.0, 0.0]], np.diag([0.0, 0.0, 1.0])[np.newaxis])
    estimate.correct(
        np.array([0]), np.array([[0.5, 0.1]]), [0, 1], np.array([1e-6, 1e-6]), (0.5, 0.0)
    )
    assert estimate.pose[0, 2] == pytest.approx(0.2, rel=1e-3)


def test_satellites_tell_the_place_that_was_meant():
    origin = np.radians(50.0), np.radians(8.0), 100.0
    place = np.array([[12.0, -30.0, 1.5]])
    reading = GpsReading(0.0, *(value[0] for value in geodetic(place, origin)))
    np.testing.assert_allclose(local_place(reading, origin), place[0], atol=1e-6)


def normalised(seed, told=ALPHA, n=50, steps=200, step=0.1):
    """Return the NEES (n,) of robots on arcs whose odometry errs by ``ALPHA``, fixed each second."""
    draw = np.random.default_rng(seed)
    truth, estimate = np.zeros((n, 3)), Filter(np.zeros((n, 3)))
    v, w = np.full(n, 0.5), np.linspace(-0.3, 0.3, n)
    for k in range(steps):
        sizes = step_deviations(ALPHA, v, w, step)
        error = np.stack([sizes[0], np.zeros(n), np.hypot(*sizes[1:])], axis=1) * draw.normal(
            size=(n, 3)
        )
        moved = np.stack([v * step, np.zeros(n), w * step], axis=1)
        mover = Filter(truth)
        mover.move(moved, np.zeros((n, 3)))
        truth = mover.pose
        assumed = step_deviations(told, v, w, step)
        variances = np.stack(
            [assumed[0] ** 2, np.zeros(n), assumed[1] ** 2 + assumed[2] ** 2], axis=1
        )
        estimate.move(moved + error, variances)
        if k % 10 == 9:
            measured = truth[:, :2] + draw.normal(0.0, 0.1, (n, 2))
            estimate.correct(np.arange(n), measured, [0, 1], np.full(2, 0.01))
    return nees(estimate.pose - truth, estimate.covariance)


def test_the_filter_knows_how_wrong_it_is():
    """The mean of the normalised errors' squares over 200 seeded runs is within its chi-square bounds."""
    assert BOUNDS[0] < np.mean([normalised(seed) for seed in range(4)]) < BOUNDS[1]


def test_a_filter_that_trusts_its_wheels_too_much_does_not():
    sure = tuple(0.25 * value for value in ALPHA)
    assert np.mean([normalised(seed, sure) for seed in range(1)]) > 1.3 * BOUNDS[1]


def test_commands_follow_from_what_the_law_knew_and_the_truth_is_beside_it(tmp_path):
    scenario = shipped("estimated_formation", duration=8.0)
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["outcome"] == "passed" and not failed(verdict)
    assert check(verdict, "commands off")["measured"] < 1e-9
    assert "the law knew estimates" in check(verdict, "worst displacement")["note"]
    run = read_run_csv(str(tmp_path / "run.csv"), scenario)
    off = np.hypot(*np.moveaxis(run.estimate[:, :, :2] - run.pose[:, :, :2], 2, 0))
    assert verdict["estimation_error"] == pytest.approx(np.sqrt((off**2).mean()))
    assert 0.01 < off[-1].max() < 0.5 and np.array_equal(run.estimate[0], run.pose[0])


def drifted(estimates, **more):
    """Return the team's errors (n,) [m] after 12 s on the formation's way."""
    scenario = shipped("estimated_formation", duration=12.0, estimates=estimates, **more)
    experiment = Experiment(scenario)
    for _, pose, _ in experiment.samples():
        last = pose
    return np.hypot(*(experiment.estimator.pose - last)[:, :2].T)


def test_the_filter_is_nearer_than_odometry_and_than_satellites():
    odometry, both = drifted("odometry"), drifted({"ekf": ["gps", "imu"]})
    assert np.sqrt((both**2).mean()) < 0.35  # satellites alone: 0.5 m along each axis
    assert np.sqrt((both**2).mean()) < np.sqrt((odometry**2).mean())


def test_poses_may_come_as_a_sensor_tells_them():
    told = {"type": "motion_capture", "noise": {"position": {"stddev": 0.01}}}
    off = drifted("cameras", sensors=[{"mounts": {"cameras": told}}])
    assert 0.0 < off.max() < 0.06


def test_estimates_are_read_and_refused():
    base = {"poses": [[0.0, 0.0, 0.0]], "duration": 0.1}
    scenario = scenario_from_dict(dict(base, estimates={"ekf": ["gps"], "alpha": list(ALPHA)}))
    assert scenario.estimates == Estimates("ekf", ("gps",), ALPHA)
    again = scenario_from_dict(dict(base, **{"estimates": scenario.to_dict()["estimates"]}))
    assert again.estimates == scenario.estimates
    for wrong, said in (
        ({"ekf": "gps"}, "estimates.ekf: 'gps', wanted names"),
        ({"ekf": [], "beta": 1}, "unknown 'beta'"),
        ({"ekf": [], "alpha": [-1, 0, 0, 0, 0, 0]}, r"alpha\[0\]"),
    ):
        with pytest.raises(ScenarioError, match=said):
            scenario_from_dict(dict(base, estimates=wrong))
    with pytest.raises(ScenarioError, match="sensors of robot1 .*unknown 'gps'"):
        Experiment(scenario)
    with pytest.raises(ScenarioError, match="sonar is a sonar, wanted one of compass, gps"):
        Experiment(scenario_from_dict(dict(base, estimates={"ekf": ["sonar"]})))
    assert Estimator.of_scenario(scenario_from_dict(base), None) is None
