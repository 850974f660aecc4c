"""Full dynamics: what slip costs a claim is taken from the record, and hides no wrong law."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.core.claims import Claim
from mrs_simulator.protocols import shipped as law_of
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.published.arms import robots_of
from mrs_simulator.record.recording import Run
from mrs_simulator.verdict.theory.motion import limit_to_grip
from mrs_simulator.verdict.theory.recorded_slip import run_with_recorded_slip
from mrs_simulator.verdict.verdict import Theory, judge

DRIFT, WORST = "drift of w^T p", "worst displacement error"


def slipping(weaker=1.0, off=0.0):
    """Return a run of points, 40 % too slow and ``weaker`` under displacements, and its control.

    The law sees them ``off`` by so much [m].
    """
    free = {"v_max": 100.0, "omega_max": 1000.0}
    scenario = shipped("displacement_formation", odometry="world", limits=free)
    control = make_control(scenario._replace(fidelity="kinematic"))
    time = control.period * np.arange(60)
    hand, pose, command = [control.points(np.array(scenario.poses))], [], []
    away = off * np.array([[k, -k] for k in range(scenario.n)])
    for _ in time:
        heading = np.array(scenario.poses)[:, 2]
        arm = control.l * np.column_stack([np.cos(heading), np.sin(heading)])
        pose.append(np.column_stack([hand[-1] - arm, heading]))
        wanted = weaker * control.pointMassLaw(hand[-1] + away)
        command.append(
            control.saturated(control.commands_for(wanted, pose[-1]), control.saturation)
        )
        moved = control.team.velocity(
            command[-1], pose[-1], np.zeros(scenario.n), control.l, control.period
        )
        hand.append(hand[-1] + 0.6 * control.period * moved)
    facts = {"lockstep": True}
    robots = np.arange(1, scenario.n + 1)
    arrays = map(np.array, (pose, hand[:-1], command))
    run = Run(time, robots, *arrays, [], scenario, facts)
    if off:
        run = run._replace(estimate=run.pose + np.pad(away, [(0, 0), (0, 1)]))
    return control, run


def test_a_right_law_with_the_slip_of_a_run_goes_the_way_of_that_run():
    control, run = slipping()
    np.testing.assert_allclose(run_with_recorded_slip(control, run).hand, run.hand, atol=1e-12)


def test_what_a_law_took_for_poses_is_known_where_it_was_recorded():
    control, run = slipping(off=0.1)
    wheels = run._replace(scenario=run.scenario._replace(odometry="wheel"))
    np.testing.assert_allclose(run_with_recorded_slip(control, wheels).hand, run.hand, atol=1e-12)
    assert (
        np.abs(run_with_recorded_slip(control, run._replace(estimate=None)).hand - run.hand).max()
        > 0.05
    )


def test_a_weak_law_does_not_even_with_its_slip():
    control, run = slipping(weaker=0.9)
    found = run_with_recorded_slip(control, run).hand
    away = np.linalg.norm(found - run.hand, axis=2).max(axis=1)
    assert away[-1] > 0.01 and (np.diff(away) >= 0.0).all()


@pytest.mark.parametrize("changes", [{"odometry": "wheels"}, None])
def test_what_is_not_known_is_not_made_up(changes):
    control, run = slipping()
    if changes is None:
        assert run_with_recorded_slip(control, run._replace(meta={})) is None
        assert run_with_recorded_slip(control, run._replace(time=1.1 * run.time)) is None
    else:
        assert (
            run_with_recorded_slip(control, run._replace(scenario=run.scenario._replace(**changes)))
            is None
        )


def judged_of(measured, slipped, relation="equal"):
    """Return the check of a claim of 10 that allows robots 3, and points 0.1, by what was measured."""

    def run(value):
        hand = np.full((4, 1, 2), value)
        return Run(np.arange(4.0), np.array([1]), np.zeros((4, 1, 3)), hand, hand[..., :2])

    claim = Claim("ten", 10.0, 3.0, lambda run: float(run.hand[-1, 0, 0]), relation)
    theory = Theory(None, run(10.0), run(slipped), {"ten": 0.1})
    return check(judge(run(measured), [claim], theory=theory), "ten")


@pytest.mark.parametrize(
    "measured, slipped, passes",
    [
        (12.0, 12.0, True),
        (12.05, 12.0, True),
        (12.2, 12.0, False),
        (10.0, 12.0, False),
        (14.0, 14.0, False),
    ],
)
def test_robots_are_to_do_what_the_law_does_with_their_slip(measured, slipped, passes):
    found = judged_of(measured, slipped)
    assert found["passed"] is passes, found
    assert found["tolerance"] == 3.0  # whatever was recorded


def test_of_a_bound_only_one_side_counts():
    assert judged_of(9.0, 12.0, "at most")["passed"] and judged_of(12.05, 12.0, "at most")["passed"]
    assert judged_of(12.2, 12.0, "at most")["passed"] is False


def test_a_drift_within_what_robots_are_allowed_fails(tmp_path):
    class Drifting(law_of("displacement_formation")):
        def pointMassLaw(self, hand):
            return super().pointMassLaw(hand) + np.array([0.01, 0.0])

    scenario = shipped("displacement_formation", duration=4.0, fidelity="dynamic")
    right = check(verdict_of(scenario, tmp_path / "right"), DRIFT)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Drifting), DRIFT)
    assert right["passed"] and 0.15 <= right["tolerance"] < 0.16, right
    assert wrong["passed"] is False and wrong["measured"] < 0.15, wrong


def test_wheels_speed_up_no_faster_than_friction_lets_them():
    control = make_control(shipped("displacement_formation"))
    robots = robots_of(control)
    limit_to_grip(robots)
    ((_, part),) = robots.parts
    # Half of 9 kg on the wheels, friction 0.9; a box of 0.511 m x 0.425 m on a track of 0.357 m.
    assert part.acceleration[0] == pytest.approx([4.41, 21.4], rel=0.01) and robots.is_ramped
    slow = make_control(shipped("displacement_formation", limits="firmware"))
    robots = robots_of(slow)
    limit_to_grip(robots)
    assert robots.parts[0][1].acceleration[0] == pytest.approx([0.3, np.deg2rad(100.0)])


def test_what_grip_costs_is_reported_where_a_claim_would_fail_without(tmp_path):
    given = shipped("displacement_formation", rate=10, fidelity="dynamic", duration=6.0)
    one = check(verdict_of(given, tmp_path), DRIFT)
    assert one["passed"] and "no faster than their friction lets them cost 0.1" in one["note"], one
    assert 0.2 < one["measured"] <= one["tolerance"] < 0.4
