"""Bodies that theory leads into each other: told before the run, and not judged after the first touch."""

import numpy as np
import pytest
from protocol_fixtures import check, failed, shipped, verdict_of

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import converges_to
from mrs_simulator.protocols.consensus.law import Consensus
from mrs_simulator.protocols.making import make_control
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.study.run.law_answers import facts
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.theory import exact_runs
from mrs_simulator.verdict.theory.meetings import meetings, meetings_ahead

NEAR = [[0.0, 0.0, 0.0], [3.0, 0.0, np.pi]]


class Meet(PioneerControl):
    """A law without a published form: only its claims, or its prediction, tell where it leads."""

    PARAMETERS = Consensus.PARAMETERS

    def pointMassLaw(self, hand):
        return 0.5 * (hand.mean(axis=0) - hand)


class Claimed(Meet):
    def claims(self, start):
        return [converges_to(start.mean(axis=0))]


class Predicted(Meet):
    def prediction(self, start, time):
        mean = start.mean(axis=0)
        return mean + np.exp(-0.5 * np.asarray(time))[:, np.newaxis, np.newaxis] * (start - mean)


class Elsewhere(Meet):
    def claims(self, start):
        return [converges_to(start + [[-1.0, 0.0], [1.0, 0.0]])]


def pair(**changes):
    changes = {"fidelity": "kinematic", "duration": 8.0, **changes}
    return shipped("consensus", robots=2, poses=NEAR, topology={"edges": [[1, 2]]}, **changes)


def told(scenario, protocol=None):
    return meetings_ahead(make_control(scenario, protocol), scenario)


def test_points_that_come_too_near_are_found_with_their_time():
    control = make_control(pair())
    time = np.linspace(0.0, 2.0, 21)
    hand = np.zeros((21, 2, 2))
    hand[:, 1, 0] = 2.0 - time
    width = 0.5 * control.team.kinds[0].body.width
    (when,) = meetings(control.team, hand, time).values()
    assert -0.1 <= when - (2.0 - 2.0 * min(width, control.team.kinds[0].body.front)) <= 0.15
    assert meetings(control.team, hand, time, z=np.array([0.0, 5.0])) == {}


@pytest.mark.parametrize("axis", (0, 1))
def test_bodies_meet_as_near_as_circles_inside_both_touch(axis):
    team = make_control(pair()).team
    body = team.kinds[0].body
    touching = 2.0 * min(body.front, body.rear, 0.5 * body.width)
    for share, row in ((0.999, 0), (0.999, 4), (1.001, 0)):
        hand = np.zeros((5, 2, 2))
        hand[:, 1, axis] = 10.0
        hand[row, 1, axis] = share * touching  # in one sample of five, the first or the last
        assert list(meetings(team, hand, np.arange(5.0))) == ([(0, 1)] if share < 1.0 else [])


@pytest.mark.filterwarnings("error")
def test_points_that_go_to_infinity_meet_nobody_there():
    control = make_control(pair())
    time = np.linspace(0.0, 1.0, 3)
    hand = np.array(
        [[[0.0, 0.0], [2.0, 0.0]], [[-1e200, 0.0], [1e200, 0.0]], [[-np.inf, 0.0], [np.inf, 0.0]]]
    )
    assert meetings(control.team, hand, time) == {}


@pytest.mark.parametrize("law", (None, Claimed, Predicted))
def test_meetings_are_foretold_with_the_remedies(law, tmp_path, capsys):
    (text,) = told(pair(), law)
    assert text.startswith("theory leads the points of robot1 and robot2 (at ")
    assert "fidelity: point_mass" in text
    run, _ = perform(pair(duration=6.0), str(tmp_path), law)
    assert text.split(" (at")[0] in capsys.readouterr().err
    assert any(each.startswith("theory leads") for each in run.meta["warnings"])


def test_nothing_is_foretold_of_points_nor_where_theory_keeps_bodies_apart():
    assert told(pair(fidelity="point_mass")) == []
    assert told(shipped("paper")) == [] and told(pair(), Meet) == []
    assert told(pair(), Elsewhere) == []


def test_the_facts_of_an_edited_scenario_have_it():
    assert "theory leads the points of robot1" in facts(pair()).warnings[""]


@pytest.mark.parametrize("law", (Claimed, Predicted))
def test_claims_of_a_law_without_published_form_are_not_judged_after_the_touch(law, tmp_path):
    verdict = verdict_of(pair(), tmp_path, law)
    collisions = check(verdict, "collisions")
    assert collisions["measured"] > 0 and collisions["passed"] is None, collisions
    assert failed(verdict) == [] and verdict["outcome"] == "not_judged"


def test_a_collision_that_theory_did_not_ask_for_fails(tmp_path):
    assert "collisions" in failed(verdict_of(pair(), tmp_path, Elsewhere))
    assert "collisions" in failed(verdict_of(pair(), tmp_path, Meet))


def test_the_exact_run_is_computed_once_for_warning_and_verdict(tmp_path, monkeypatch):
    made, own = [], exact_runs._exact_run
    monkeypatch.setattr(exact_runs, "_exact_run", lambda *given: made.append(given) or own(*given))
    run, control = perform(shipped("paper", duration=2.0), str(tmp_path))
    made_ahead = len(made)
    judged(run, control)
    lengths = [len(given[1].time) for given in made]
    assert made_ahead == 1 and lengths.count(len(run.time)) == 1, lengths


def thrown(distance, gain, saturation="none", **changes):
    """Three robots on a line of which one command carries an edge past the range of 4 m."""
    poses = [[0.0, 0.0, 0.0], [distance, 0.0, 0.0], [distance + 3.0, 0.0, 0.0]]
    parameters = {"gain": gain, "radius": 4.0}
    given = shipped(
        "rendezvous", parameters, robots=3, poses=poses, fidelity="kinematic", **changes
    )
    return given._replace(control=given.control._replace(saturation=saturation))


def test_points_that_pass_each_other_between_two_samples_are_found():
    control = make_control(pair())
    hand = np.zeros((2, 2, 2))
    hand[:, 1, 0] = 5.0, -5.0
    assert list(meetings(control.team, hand, np.array([0.0, 0.1]))) == [(0, 1)]


@pytest.mark.parametrize(
    "scenario",
    (
        thrown(3.9, 0.215, duration=1.0),  # onto another robot, between two samples
        thrown(3.9, 0.7, "robot", limits="top", duration=4.5),
    ),
    ids=("without limits", "within limits"),
)
def test_robots_that_one_command_throws_apart_fail_by_no_collision(scenario, tmp_path):
    verdict = verdict_of(scenario, tmp_path)
    assert check(verdict, "collisions")["measured"] > 0
    assert failed(verdict) == [] and "curvature of the tension" in verdict["reason"]
