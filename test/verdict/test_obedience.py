"""Robots that do not do as commanded are named: wheel or axis, by gain, dead time and bias."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped

from mrs_simulator import PioneerControl, simulate
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.published.drives import Unicycles
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import perform, run_experiment
from mrs_simulator.verdict import obedience
from mrs_simulator.verdict.obedience import _inverses, _velocities, obedience_checks
from mrs_simulator.verdict.theory import motion

STEP, TRACK, TIME = 0.02, 0.357, np.arange(0.0, 12.0, 0.1)
GAIN, DEAD_TIME, BIAS = "gain of wheels", "dead time of wheels", "bias of wheels"


def driven(wheels=lambda rims, now: rims, speed=0.3, turn=0.4):
    """Return checks of two Pioneers; what ``wheels`` makes of the rims (2,) [m/s] moves the second one."""
    scenario = shipped("displacement_formation", poses=[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], robots=2,
                       topology={"preset": "complete"}, fidelity="kinematic", duration=12.0)  # fmt: skip
    control = make_control(scenario)

    def commanded(now):
        return np.array([speed * (1.0 + np.sin(0.9 * now)), turn * np.cos(0.7 * now)])

    place, pose = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), []
    for now in TIME:
        pose.append(place.copy())
        for k in range(5):
            v, omega = commanded(now + k * STEP)
            rims = np.array([v - 0.5 * TRACK * omega, v + 0.5 * TRACK * omega])
            for row, (left, right) in enumerate((rims, wheels(rims, now))):
                v, omega = 0.5 * (left + right), (right - left) / TRACK
                middle = place[row, 2] + 0.5 * STEP * omega
                place[row] += STEP * np.array([v * np.cos(middle), v * np.sin(middle), omega])
    command = np.array([[commanded(now)] * 2 for now in TIME])
    pose = np.array(pose)
    hand = pose[..., :2] + control.l * np.stack(
        [np.cos(pose[..., 2]), np.sin(pose[..., 2])], axis=2
    )
    run = Run(TIME, np.array([1, 2]), pose, hand, command, [], scenario, {"lockstep": True})
    return {"checks": [each._asdict() for each in obedience_checks(control, run)]}


@pytest.mark.parametrize("name", ["lossy_consensus", "event_triggered_consensus"])
def test_commands_that_jump_between_samples_are_not_held_against_robots(name):
    limits = {"v_max": 1.5, "omega_max": 6.2832}
    changes = {"fidelity": "kinematic", "limits": limits, "duration": 6.0}
    for rate, fitted in ((10.0, False), (50.0, True)):
        verdict = simulate(shipped(name, rate=50.0, record_rate=rate, **changes)).verdict
        found = {each["name"]: each["passed"] for each in verdict["checks"]}
        assert any(name.startswith(GAIN) for name in found) is fitted
        assert verdict["outcome"] != "failed", (rate, found)


def test_robots_that_obey_pass():
    found = driven()
    for name, exact in ((GAIN, 1.0), (DEAD_TIME, 0.0), (BIAS, 0.0)):
        one = check(found, name)
        assert one["passed"] and one["measured"] == pytest.approx(exact, abs=2e-3), one


@pytest.mark.parametrize(
    "wheels, name, where, value",
    [
        (lambda rims, now: rims * [0.9, 1.0], GAIN, "left wheel", 0.9),
        (lambda rims, now: rims * [1.0, 1.05], GAIN, "right wheel", 1.05),
        (lambda rims, now: 0.0 * rims if now > 6.0 else rims, GAIN, "wheel", 0.0),
        (lambda rims, now: rims + [0.03, 0.0], BIAS, "left wheel", 0.03),
    ],
)
def test_a_wheel_that_does_not_is_named(wheels, name, where, value):
    one = check(driven(wheels), name)
    assert one["passed"] is False and one["measured"] == pytest.approx(value, abs=1e-2), one
    assert "robot2" in one["note"] and where in one["note"], one


def test_of_robots_at_rest_no_gain_is_reported():
    found = driven(speed=0.0, turn=0.0)
    assert (
        check(found, GAIN)["passed"] is None
        and "undecided for robot1" in check(found, GAIN)["note"]
    )
    assert check(found, BIAS)["passed"]


def test_a_robot_that_creeps_while_it_is_to_stand_is_named():
    one = check(driven(lambda rims, now: rims + 0.01, 0.0, 0.0), BIAS)
    assert one["passed"] is False and "robot2" in one["note"], one


@pytest.mark.parametrize(
    "limits, mismatch",
    [("none", None), ("top", None), ("firmware", None), ("firmware", {"speed": 0.97})],
)
def test_all_ways_between_samples_at_once_are_those_one_after_the_other(
    limits, mismatch, tmp_path, monkeypatch
):
    more = {"mismatch": mismatch} if mismatch else {}
    scenario = shipped("displacement_formation", fidelity="kinematic", limits=limits, duration=4.0)
    run, control = perform(scenario.changed(**more), str(tmp_path))
    moves, own = [], Unicycles.move
    monkeypatch.setattr(Unicycles, "move", lambda *given: moves.append(1) or own(*given))
    asked, _ = _velocities(control, run)
    assert len(moves) == 5  # the steps from a sample to the next, not those of the run
    monkeypatch.setattr(motion, "EVEN", -1.0)
    one_by_one, _ = _velocities(control, run)
    assert len(moves) > 150
    assert np.abs(asked - one_by_one).max() < 1e-12


def test_headings_that_swing_between_samples_are_no_bias_of_wheels(tmp_path):
    """At 50 commands a second and 10 samples it is not known for how long ramps have lasted."""
    corners = 1.5 * np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])

    class Gather(PioneerControl):
        def pointMassLaw(self, hand):
            return -0.3 * self.topology.laplacian() @ (hand - corners)

    content = {
        "poses": [[4, -1, 0], [2, 5, 1], [-3, 2, 2], [-1, -4, 3]],
        "topology": {"preset": "ring"},
        "duration": 12,
    }
    verdict = run_experiment(scenario_from_dict(content), str(tmp_path), Gather, formats=())
    bias = check(verdict, BIAS)
    assert bias["passed"] and abs(bias["measured"]) > 0.01, bias


def test_inverses_are_those_of_lapack():
    half = np.random.default_rng(1).normal(size=(20, 4, 3, 3)) * [1.0, 30.0, 1e-3]
    matrix = half @ np.swapaxes(half, -1, -2) + 0.1 * np.eye(3)
    product = _inverses(matrix) @ matrix
    assert np.abs(product - np.eye(3)).max() < 1e-10


@pytest.mark.parametrize("mismatch", [{}, {"speed": [0.9, 1.0, 1.0, 1.1, 1.0, 1.0, 1.0]}])
def test_robots_are_fitted_in_parts_as_all_at_once(mismatch, monkeypatch, tmp_path):
    scenario = shipped("paper", duration=12.0, mismatch=mismatch)
    run, control = perform(scenario, str(tmp_path))
    sizes = []
    fitted = obedience._fits_of
    monkeypatch.setattr(
        obedience, "_fits_of", lambda *given: sizes.append(given[0].team.n) or fitted(*given)
    )
    whole = obedience.fits(control, run)
    monkeypatch.setattr(obedience, "AT_ONCE", 3 * len(run.time))
    parts = obedience.fits(control, run)
    assert sizes == ([7, 7] if mismatch else [7, 3, 3, 1])
    assert list(parts.names) == list(whole.names) and parts.windows == whole.windows
    for field in ("obeyed", "spread", "found", "error"):
        assert np.array_equal(getattr(parts, field), getattr(whole, field)), field


def test_windows_are_fitted_at_once_as_one_by_one(monkeypatch, tmp_path):
    run, control = perform(shipped("paper", duration=22.0), str(tmp_path))
    given, fitted = [], obedience._fitted
    monkeypatch.setattr(
        obedience, "_fitted", lambda *arrays: given.append(arrays) or fitted(*arrays)
    )
    fits = obedience.fits(control, run)
    whole, beside = given
    assert len(fits.windows) == 5 and beside[1].shape[1] == 4 * control.team.n
    for row, window in enumerate(fits.windows[1:], 1):
        seen = [each[window] for each in whole[:-2]]
        found, error = fitted(*seen, obedience._slopes(*seen[:2]), whole[-1])
        assert np.array_equal(fits.found[row], found) and np.array_equal(fits.error[row], error)
