"""Mistakes put into claims: predictions that are off, and which of them verdicts notice."""

import copy

import numpy as np
import pytest
from protocol_fixtures import shipped as scenario_of

from mrs_simulator.core.claims import Claim, Condition, rate, stays_below
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.protocols.making import make_control
from mrs_simulator.study.check.claim_mistakes import TIMES, confirmed, mistaken, shift_of

RATED = ("formation", "cyclic_pursuit", "wall_following", "displacement_formation", "consensus")
START = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]])


def check(name, predicted, passed):
    return {"name": name, "predicted": predicted, "passed": passed}


def test_rates_are_off_by_a_share_places_by_tolerances_and_bounds_not_at_all():
    assert shift_of(rate(2.0, None)) == pytest.approx(0.06)
    assert shift_of(Claim("settling time [s]", 50.0, 1.0, None)) == pytest.approx(1.5)
    assert shift_of(Claim("decay rate over theory's [-]", 1.0, 0.02, None)) == pytest.approx(0.03)
    assert shift_of(Claim("turn rate [rad/s]", 0.1, 0.005, None)) == pytest.approx(0.003)
    assert shift_of(Claim("final distance [m]", 0.0, 0.05, None)) == pytest.approx(0.15)
    assert shift_of(stays_below(None, 4.0, "farthest [m]", 1e-3)) == 0.0
    assert shift_of(Condition("gain above 0", True)) == 0.0


@pytest.mark.parametrize("name", sorted(HOMES))
def test_no_typed_tolerance_of_points_hides_a_wrong_rate_or_time(name):
    scenario = scenario_of({"formation": "paper_four"}.get(name, name))
    control = make_control(scenario)
    armed = control.team.has_arms  # which are no points
    control._keep(fidelity=control.fidelity if armed else "point_mass")
    claims = control.all_claims(control.points(scenario.poses))
    rates = [claim for claim in claims if shift_of(claim) and TIMES.search(claim.name)]
    for claim in rates:
        assert claim.tolerance < shift_of(claim), claim
    assert rates or name not in RATED


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_all_claims_of_a_mistaken_control_are_off_and_those_of_its_copies_too(sign):
    control = shipped("consensus")(range(1, 4))
    right = control.all_claims(START)
    for wrong in (mistaken(control, sign), copy.copy(mistaken(control, sign))):
        for claim, other in zip(right, wrong.all_claims(START)):
            assert other.name == claim.name
            if isinstance(claim, Claim):
                assert other.predicted == claim.predicted + sign * shift_of(claim)
    assert [each[:2] for each in control.all_claims(START)] == [each[:2] for each in right]


def test_wrong_claims_that_no_verdict_fails_are_named():
    right = {"checks": [check("a", 0.0, True), check("b", 1.0, True), check("c", 2.0, False)]}
    up = {"checks": [check("a", 0.3, False), check("b", 1.1, None), check("c", 2.1, True)]}
    down = {"checks": [check("a", -0.3, False), check("b", 0.9, True), check("c", 1.9, True)]}
    assert set(confirmed(right, [up, down])) == {"b"}
    assert set(confirmed(right, [down])) == {"b"} and not confirmed(right, [right])
