"""Estimated poses: the filter by hand and by chi-square, and laws that know estimates alone."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.core.kinematics import compose, fraction_of_motion, relative, wrap_angle
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import ScenarioError, scenario_from_dict
from mrs_simulator.scenario.team.estimates import Estimates
from mrs_simulator.scenario.team.odometry_errors import step_deviations
from mrs_simulator.sensors.mounts import read_mount
from mrs_simulator.sensors.pose_filter.estimation import Estimator
from mrs_simulator.sensors.pose_filter.kalman import Filter
from mrs_simulator.sensors.pose_filter.pose_measurements import MEASUREMENTS
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.sensors.types.position import GpsReading, geodetic, local_place
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.estimation import estimation_curves, estimation_measures
from mrs_simulator.verdict.judging import judged

ALPHA = (0.02, 0.0, 0.0, 0.02, 0.002, 0.002)
# 95 % of the mean of 200 chi-squares of 3 degrees: 600 degrees, over 200, after Wilson and Hilferty.
BOUNDS = 2.670, 3.349
N, STEP = 200, 0.1  # [-] robots, [s]


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
    slope = np.eye(3)[np.newaxis, :2]
    estimate.correct(np.array([0]), np.array([[4.0, 0.0]]), slope, np.array([3.0, 3.0]))
    np.testing.assert_allclose(estimate.pose, [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(
        np.diagonal(estimate.covariance, 0, 1, 2), [[0.75, 0.75, 0.1], [1, 1, 0.1]]
    )


def measurement(content):
    """Return what the sensor with ``content`` tells of poses."""
    mount = read_mount("x", content, "x")
    return MEASUREMENTS[mount.type](mount)


def test_headings_are_compared_across_the_turn():
    compass = measurement({"type": "compass"})
    off, slope = compass.off(np.array([[-3.1]]), np.array([[0.0, 0.0, 3.1]]))
    assert off[0, 0] == pytest.approx(2.0 * np.pi - 6.2) and slope.tolist() == [[[0, 0, 1]]]


def test_slopes_of_what_is_measured_are_those_of_small_changes():
    pose, step = np.array([[1.0, 2.0, 0.7], [-3.0, 0.5, -2.0]]), 1e-6
    place = {"place": [0.3, -0.2, 0.1]}
    for content in (GPS, RANGES, BEARINGS, {"type": "motion_capture"}, {"type": "compass"}):
        measured = measurement(dict(content, **({} if "noise" not in content else place)))
        expected, slope = measured.expected(pose)
        for axis in range(3):
            moved = pose + step * np.eye(3)[axis]
            change = (measured.expected(moved)[0] - expected) / step
            np.testing.assert_allclose(change, slope[:, :, axis], atol=1e-5)


def test_satellites_tell_the_place_that_was_meant():
    origin = np.radians(50.0), np.radians(8.0), 100.0
    place = np.array([[12.0, -30.0, 1.5]])
    reading = GpsReading(0.0, *(value[0] for value in geodetic(place, origin)))
    np.testing.assert_allclose(local_place(reading, origin), place[0], atol=1e-6)


def known(**sensors):
    """Return the ``Estimator`` of ``N`` robots at the origin with ``sensors``, and their ``Suite``."""
    content = {
        "poses": [[0.0, 2.0 * row, 0.0] for row in range(N)],
        "duration": 1.0,
        "step": STEP,
        "control": {"rate": 10},
        "odometry": "wheel",
        "odometry_errors": {"alpha": list(ALPHA)},
        "estimates": {"ekf": sorted(sensors)},
        "sensors": [{"mounts": sensors}],
        "seed": 5,
    }
    scenario = scenario_from_dict(content)
    team = Team.from_scenario(scenario)
    estimator, suite = Estimator.of_scenario(scenario, team), Suite.of_scenario(scenario, team)
    suite.activate({row: sorted(sensors) for row in range(N)})
    return estimator, suite


def chi_square(seed, steps=60, model=lambda estimator: None, **sensors):
    """Return ``e^T P^-1 e`` (N,) of robots on arcs whose odometry and ``sensors`` err as they say.

    ``model(estimator)`` may change what the filter believes.
    """
    estimator, suite = known(**sensors)
    model(estimator)
    draw = np.random.default_rng(seed)
    truth = estimator.pose
    odometry = truth.copy()
    v, w = np.full(N, 0.5), np.linspace(-0.3, 0.3, N)
    sizes = step_deviations(ALPHA, v, w, STEP)
    moved = np.stack([v * STEP, np.zeros(N), w * STEP], axis=1)
    for k in range(steps + 1):
        twist = np.stack([v, np.zeros(N), w], axis=1)
        suite.update(k, lambda k=k, pose=truth, twist=twist: State(k * STEP, pose, twist))
        heard = estimator.fresh(suite.readings(k * STEP))
        estimator.update(np.full(N, round(k * STEP * 1e9)), odometry, heard)
        error = np.stack([sizes[0], np.zeros(N), np.hypot(*sizes[1:])], axis=1)
        odometry = compose(odometry, moved + error * draw.normal(size=(N, 3)))
        last, truth = truth, compose(truth, moved)
    error = estimator.pose - last
    error[:, 2] = wrap_angle(error[:, 2])
    covariance = estimator.filter.covariance[:, :3, :3]
    return np.einsum("ij,ij->i", error, np.linalg.solve(covariance, error[..., np.newaxis])[..., 0])


GPS = {"type": "gps", "rate": 1.0, "noise": {"stddev": 0.1}}
GYRO = {
    "type": "imu",
    "rate": 10,
    "noise": {"rate": {"stddev": 0.05, "bias": {"stddev": 0.1}, "bias_walk": 0.01}},
}
RANGES = {
    "type": "beacons", "points": [[5.0, 100.0], [60.0, 200.0], [-60.0, 150.0]], "range": 1000.0,
    "occlusion": False, "rate": 2.0, "noise": {"range": {"stddev": 0.1}},
}  # fmt: skip
BEARINGS = dict(RANGES, bearing=True, noise={"range": {"stddev": 1.0}, "bearing": {"stddev": 0.01}})
LATE = dict(GPS, noise={"stddev": 0.1, "latency": 1.7})
BIASED = dict(GPS, noise={"stddev": 0.1, "bias": {"stddev": 0.3}, "bias_walk": 0.05})
EACH = [{"gps": GPS}, {"imu": GYRO, "gps": GPS}, {"b": RANGES}, {"b": BEARINGS}, {"gps": LATE}]
EACH += [{"gps": BIASED, "compass": {"type": "compass", "noise": {"stddev": 0.02}}}]


@pytest.mark.parametrize("sensors", EACH, ids=lambda each: "+".join(each))
def test_the_filter_knows_how_wrong_it_is(sensors):
    """The mean of the normalised errors' squares over 200 runs is within its chi-square bounds."""
    assert BOUNDS[0] < chi_square(1, **sensors).mean() < BOUNDS[1]


@pytest.mark.parametrize("rate", [7.0, 8.0, 30.0])
def test_a_gyro_counts_every_time_once(rate):
    """Also at rates that are no whole number of the world's steps, and above them."""
    estimator, suite = known(imu={"type": "imu", "rate": rate}, gps=GPS)
    pose, twist = estimator.pose, np.tile([0.0, 0.0, 0.3], (N, 1))
    for k in range(8):  # wheels that tell of twice the turn
        suite.update(k, lambda k=k: State(k * STEP, pose, twist))
        heard = [each for each in estimator.fresh(suite.readings(k * STEP)) if each[1] == "imu"]
        odometry = pose + k * np.array([0.0, 0.0, 0.06])
        estimator.update(np.full(N, round(k * STEP * 1e9)), odometry, heard)
    np.testing.assert_allclose(estimator.pose[:, 2], 7 * 0.03, atol=1e-12)


def trusting(estimator):
    estimator.model.alpha = tuple(0.25 * value for value in ALPHA)


def unbiased(estimator):
    """Let the filter take all biases to be known, and none."""
    estimator.filter.covariance[:, range(3, 3 + len(estimator.model.walks))] = 0.0
    estimator.model.walks[:] = 0.0


def test_a_filter_whose_model_is_wrong_does_not():
    assert chi_square(1, model=trusting, gps=GPS).mean() > 1.3 * BOUNDS[1]
    assert chi_square(1, model=unbiased, imu=GYRO, gps=GPS).mean() > 2.0 * BOUNDS[1]
    assert chi_square(1, model=unbiased, gps=BIASED).mean() > 2.0 * BOUNDS[1]
    # As if what comes late told of now.
    real = Estimator.fresh

    def hurried(estimator):
        estimator.fresh = lambda readings: [
            (stamp + int(1.7e9), *more) for stamp, *more in real(estimator, readings)
        ]

    assert chi_square(1, model=hurried, gps=LATE).mean() > 2.0 * BOUNDS[1]


def test_what_comes_late_is_taken_in_where_it_belongs():
    """In whatever order readings come, also between two odometries, the estimate is the same."""
    fix = [GpsReading(0.0, *(float(v[0]) for v in geodetic(np.array([[x, 0.1, 0.0]]), (0.0,) * 3)))
           for x in (0.02, 0.07, 0.11)]  # fmt: skip
    looks = [(stamp, "gps", [(0, each)]) for stamp, each in zip((20, 70, 100), fix)]
    ends = []
    for order in ((0, 1, 2), (2, 0, 1), (2, 1, 0)):
        estimator, _ = known(gps=dict(GPS))
        start = estimator.pose
        for k in range(6):
            odometry = compose(start, np.tile([0.04 * k, 0.0, 0.02 * k], (N, 1)))
            heard = [looks[order[k - 3]]] if k > 2 else []
            estimator.update(np.full(N, 40 * k), odometry, heard)
        ends.append((estimator.pose, estimator.filter.covariance))
    for pose, covariance in ends[1:]:
        np.testing.assert_array_equal(pose, ends[0][0])
        np.testing.assert_array_equal(covariance, ends[0][1])
    assert estimator.late == 0 and abs(ends[0][0][0, 1]) > 0.0
    # What is older than the filter remembers is left out, and counted.
    far = int(2e9)
    estimator.update(np.full(N, far), odometry, [])
    estimator.update(np.full(N, far + 40), odometry, [looks[0]])
    assert estimator.late == 1


def test_a_robot_that_was_put_elsewhere_is_believed_to_be_there():
    estimator, _ = known(gps=GPS)
    start = estimator.pose
    for k in range(3):
        estimator.update(
            np.full(N, round(0.1e9 * k)), compose(start, np.tile([0.05 * k, 0, 0.1], (N, 1)))
        )
    assert (estimator.filter.covariance[0, :2, :2] > 0.0).any()
    away = start + [3.0, 0.0, 1.0]
    estimator.update(np.full(N, round(0.3e9)), away)
    np.testing.assert_array_equal(estimator.pose, away)
    assert not estimator.filter.covariance.any()


def test_a_part_of_an_arc_lies_on_it():
    moved = np.array(
        [[1.0, 1.0, 0.5 * np.pi], [2.0, 0.0, 0.0]]
    )  # a quarter of a circle of radius 1
    part = fraction_of_motion(moved, 1.0 / 3.0)
    np.testing.assert_allclose(part[0], [np.sin(np.pi / 6), 1 - np.cos(np.pi / 6), np.pi / 6])
    np.testing.assert_allclose(part[1], [2.0 / 3.0, 0.0, 0.0])
    np.testing.assert_allclose(compose(part, relative(part, moved)), moved)


def test_commands_follow_from_what_the_law_knew_and_the_truth_is_beside_it(tmp_path):
    scenario = shipped("estimated_formation", duration=8.0)
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["outcome"] == "not_judged" and not failed(verdict)
    assert verdict["reason"].startswith("the law is confirmed; the theorem is not tested")
    assert check(verdict, "commands off")["measured"] < 1e-9
    assert "the law knew estimates" in check(verdict, "worst displacement")["note"]
    run = read_run_csv(str(tmp_path / "run.csv"), scenario)
    off = np.hypot(*np.moveaxis(run.estimate[:, :, :2] - run.pose[:, :, :2], 2, 0))
    assert verdict["estimation_error"] == pytest.approx(np.sqrt((off**2).mean()))
    assert 0.01 < off[-1].max() < 0.5 and np.array_equal(run.estimate[0], run.pose[0])
    # Where the record does not hold them, or not the truth, nothing is made of that.
    without, _ = judged(run._replace(estimate=None), make_control(scenario))
    assert "which the record does not hold" in check(without, "commands off")["note"]
    assert "estimation_error" not in without and without["outcome"] == "not_judged"
    unknown = run._replace(meta=dict(run.meta, truth_unknown=True))
    assert estimation_measures(unknown) == {} and estimation_curves(unknown) == []


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
        ({"ekf": "gps"}, "estimates.ekf: 'gps', wanted a list of different names"),
        ({"ekf": [], "beta": 1}, "unknown 'beta'"),
        ({"ekf": [], "alpha": [-1, 0, 0, 0, 0, 0]}, r"alpha\[0\]"),
    ):
        with pytest.raises(ScenarioError, match=said):
            scenario_from_dict(dict(base, estimates=wrong))
    with pytest.raises(ScenarioError, match="sensors of robot1 .*unknown 'gps'"):
        Experiment(scenario)
    with pytest.raises(
        ScenarioError, match="sonar is a sonar, wanted one of imu, beacons, compass, gps"
    ):
        Experiment(scenario_from_dict(dict(base, estimates={"ekf": ["sonar"]})))
    assert Estimator.of_scenario(scenario_from_dict(base), None) is None
