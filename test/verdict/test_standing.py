"""How claims stand while a run goes on: beside theory at that moment, not beside its end."""

import numpy as np
from protocol_fixtures import shipped

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import converges_to, invariant
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Collision, part_of
from mrs_simulator.record.run_changes import Change
from mrs_simulator.study.run.experiment import played
from mrs_simulator.verdict import standing
from mrs_simulator.verdict.standing import FAILING, NOT_JUDGED, ON_COURSE, OPEN, standings

LIMIT = "distance from agreement on w^T p(0) [m]"
DRIFT, RATE = "drift of w^T p [m]", "decay rate of the disagreement [1/s]"


def consensus():
    run, _ = played(shipped("consensus"))
    return make_control(run.scenario), run


def stands(rows):
    return {row["name"]: row["standing"] for row in rows}


def of(rows, name):
    (row,) = [row for row in rows if row["name"] == name]
    return row


def test_what_theory_has_not_reached_yet_either_is_on_course_and_theory_is_made_once(monkeypatch):
    control, run = consensus()
    early, known = standings(control, part_of(run, slice(0, 20)))
    assert stands(early)[RATE] == OPEN and stands(early)[DRIFT] == ON_COURSE
    limit = of(early, LIMIT)
    assert limit["standing"] == ON_COURSE and limit["difference"] > 1.0
    assert 0.0 < limit["margin"] < limit["tolerance"] and "as theory has it" in limit["note"]
    monkeypatch.setattr(standing, "exact_run", None)
    late, _ = standings(control, run, known)
    assert set(stands(late).values()) == {ON_COURSE}
    assert of(late, LIMIT)["margin"] == of(late, LIMIT)["tolerance"] - of(late, LIMIT)["measured"]


def test_a_run_that_falls_behind_theory_is_not_decided_at_first_and_fails_then():
    control, run = consensus()
    slow = run.replace(time=5.0 * run.time)  # a fifth as fast as theory
    slow = slow.replace(scenario=run.scenario._replace(duration=100.0))
    assert stands(standings(control, part_of(slow, slice(0, 20)))[0])[LIMIT] == OPEN
    row = of(standings(control, part_of(slow, slice(0, 60)))[0], LIMIT)
    assert row["standing"] == FAILING and row["margin"] < 0.0
    assert "theory has shown it since" in row["note"]


def test_an_invariant_that_is_left_fails_at_once():
    control, run = consensus()
    hand = run.hand + 0.01 * np.arange(len(run.time))[:, np.newaxis, np.newaxis]
    assert (
        stands(standings(control, part_of(run.replace(hand=hand), slice(0, 30)))[0])[DRIFT]
        == FAILING
    )


def test_after_a_change_what_comes_then_is_looked_at_and_after_a_touch_nothing_of_the_theorem():
    control, run = consensus()
    gains = run.scenario.to_dict()["control"]
    change = Change(5.0, "control", {**gains, "parameters": {"gain": 0.2}})
    rows, _ = standings(control, part_of(run, slice(0, 80)).replace(meta={"changes": [change]}))
    assert of(rows, RATE)["predicted"] < 0.45 and "from 5.1 s on" in of(rows, RATE)["note"]
    touched = part_of(run, slice(0, 80))
    touched.collisions = [Collision(3.0, "robot1", "crate", 0.0, 0.0)]
    rows, _ = standings(control, touched)
    assert stands(rows)[LIMIT] == NOT_JUDGED and stands(rows)["collisions"] == FAILING


class Unpublished(PioneerControl):
    def pointMassLaw(self, hand):
        return np.tile([0.1, 0.0], (len(hand), 1))

    def claims(self, start):
        near = start.mean(axis=0) + [1.0, 0.0]
        return [invariant(lambda hand: hand.mean(axis=1), 0.05), converges_to(near, 9.0)]


def test_of_a_law_without_theory_a_claim_fails_once_it_holds_no_more():
    run, _ = played(shipped("consensus"), Unpublished)
    control, known = make_control(run.scenario, Unpublished), None
    rows, known = standings(control, part_of(run, slice(0, 4)), known)
    assert stands(rows)["drift of the invariant"] == ON_COURSE
    rows, known = standings(control, part_of(run, slice(0, 40)), known)
    assert of(rows, "drift of the invariant")["note"] == "it was shown before"
    rows, _ = standings(control, part_of(run, slice(0, 40)))
    assert stands(rows)["drift of the invariant"] == OPEN


def test_requirements_are_decided_as_formulas_are():
    wanted = {"apart": "always(distance > 0.5 m)", "near": "always(distance > 4 m)"}
    run, _ = played(shipped("consensus").changed(requirements=wanted))
    rows, _ = standings(make_control(run.scenario), part_of(run, slice(0, 10)))
    assert (stands(rows)["apart"], stands(rows)["near"]) == (OPEN, FAILING)
    assert of(rows, "near")["margin"] < 0.0 and of(rows, "near")["member"]


def test_collisions_to_which_theory_leads_are_not_judged():
    control, run = consensus()  # of all, at one point
    run.collisions = [Collision(15.0, "robot1", "robot2", 0.0, 0.0)]
    row = of(standings(control, run)[0], "collisions")
    assert row["standing"] == NOT_JUDGED and "theory leads their points there" in row["note"]
