"""Robots that theory follows from the middle of a run on, or that disobey as their scenario says."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import part_of
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.verdict.theory.exact_runs import robots_run

ON_ROBOTS = "largest distance from the law on these robots"


@pytest.mark.parametrize(
    "name, changes",
    [
        ("displacement_formation", {"limits": "firmware"}),
        ("displacement_formation", {"limits": "top"}),
        ("formation_mixed", {"limits": "firmware"}),
        ("formation_boats", {}),
        ("formation_crazyflies", {}),
        ("formation_cars", {"limits": "firmware"}),
    ],
)
def test_robots_in_ramps_go_on_as_fast_as_they_were(name, changes, tmp_path):
    scenario = shipped(name, duration=2.0, fidelity="kinematic", **changes)
    run, _ = perform(scenario, str(tmp_path))
    control = make_control(run.scenario)
    rest = part_of(run.in_space(control.dimension), slice(4, None))
    found = robots_run(control, rest)
    np.testing.assert_allclose(found.hand, rest.hand, atol=1e-8)


@pytest.mark.parametrize("mismatch", [{"speed": 1.01}, {"track": 0.97, "delay": 0.1}])
@pytest.mark.parametrize("limits", ["none", "firmware"])
def test_robots_that_the_scenario_says_disobey_are_followed(mismatch, limits, tmp_path):
    scenario = shipped("displacement_formation", duration=2.0, mismatch=mismatch, limits=limits)
    verdict = verdict_of(scenario, tmp_path)
    found = check(verdict, ON_ROBOTS)
    assert found["passed"] and found["measured"] < 1e-9, found


def test_the_filter_hands_over_robots_in_ramps(tmp_path):
    angle = np.arange(6) * np.pi / 3.0
    poses = np.stack([4.8 * np.cos(angle), 4.8 * np.sin(angle), 0.0 * angle], axis=1).tolist()
    changes = {"limits": "firmware", "duration": 5.0, "poses": poses}
    scenario = shipped("displacement_formation", {"gain": 0.5}, **changes)
    control = dict(scenario.control.to_plain(), safety={"speed": 0.7})
    verdict = verdict_of(scenario.changed(control=control), tmp_path)
    found = check(verdict, ON_ROBOTS)
    assert found["passed"] and "after the safety filter acted" in found["note"], found


def test_odometry_with_declared_errors_fails_no_theorem(tmp_path):
    noisy = {"odometry": "wheel", "odometry_errors": {"Ed": 1.01, "Eb": 1.02}}
    verdict = verdict_of(shipped("paper", duration=60.0, **noisy), tmp_path)
    assert not failed(verdict) and verdict["outcome"] == "not_judged"
    assert "estimates: odometry" in check(verdict, "final gap")["note"]


def test_a_claim_that_a_mismatch_costs_too_much_is_not_judged(tmp_path):
    late = {"speed": 0.98, "delay": 0.1}
    verdict = verdict_of(
        shipped("marching", duration=20.0, fidelity="kinematic", mismatch=late), tmp_path
    )
    drift = check(verdict, "drift of the centre from the path")
    assert drift["passed"] is None and "mismatch" in drift["note"], drift
