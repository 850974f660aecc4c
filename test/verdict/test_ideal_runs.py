"""Theorems of laws without a form on points are tested on ideal robots under the law itself."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.core.claims import ends_at
from mrs_simulator.protocols.sensing.law import SensedFollowing
from mrs_simulator.study.run.simulating import simulate
from mrs_simulator.verdict.theory import ideal_runs
from mrs_simulator.verdict.theory.ideal_runs import IdealRuns

STARTS = [[0.0, 0.0, 0.0], [-3.0, 0.0, 0.0]]


class Follow(PioneerControl):
    """Robot 2 follows robot 1: the gap obeys ``d' = 0.1 - 0.2 (d - 1)`` and ends at 1.5 m."""

    GAP = 1.5

    def calculateControlLaw(self, pos_map):
        ahead = pos_map[1].x - pos_map[2].x
        return {1: make_twist(0.1, 0.0), 2: make_twist(0.2 * (ahead - 1.0), 0.0)}

    def claims(self, start):
        return [ends_at(lambda at: at[:, 0, 0] - at[:, 1, 0], self.GAP, 0.01, "gap [m]")]


class Wrong(Follow):
    GAP = 1.55


def verdict_of(protocol, duration, rate=10.0, **changes):
    control = {"rate": rate, **changes.pop("control", {})}
    given = {"poses": STARTS, "limits": "none", "duration": duration, "control": control}
    return simulate({**given, **changes}, protocol=protocol).verdict


class Pursuit(PioneerControl):
    """Cyclic pursuit turned by pi/n: a circle of neutral modes, which held commands let grow slowly."""

    SHARE = 1.0

    def pointMassLaw(self, hand):
        ahead = np.exp(-1j * np.pi / len(hand)) * ((np.roll(hand, -1, axis=0) - hand) @ [1.0, 1j])
        return np.column_stack([ahead.real, ahead.imag])

    def claims(self, start):
        modes = np.abs(np.fft.fft(start @ [1.0, 1j])) / len(start)
        return [ends_at(self.radius, self.SHARE * modes[1], 0.05, "radius [m]")]

    @staticmethod
    def radius(hand):
        return np.linalg.norm(hand - hand.mean(axis=1, keepdims=True), axis=2).max(axis=1)


class PursuitWrong(Pursuit):
    SHARE = 1.1


def radius_of(protocol, duration, rate):
    angles = 2.0 * np.pi * np.arange(4) / 4
    poses = [[3.0 * np.cos(a) + 0.4 * np.cos(2.0 * a), 3.0 * np.sin(a), 0.0] for a in angles]
    control = {"saturation": "none"}
    changes = {"poses": poses, "fidelity": "point_mass", "control": control}
    return check(verdict_of(protocol, duration, rate, **changes), "radius [m]")


@pytest.fixture
def short_runs(monkeypatch):
    """Follow ideal robots a tenth as long as usual, which is enough of a circle."""
    monkeypatch.setattr(ideal_runs, "MOST_COMMANDS", 10000)


@pytest.mark.parametrize("duration", [1.0, pytest.param(6.0, marks=pytest.mark.release)])
def test_a_drift_by_held_commands_is_no_mistake_of_the_law(duration, short_runs):
    found = radius_of(Pursuit, duration, 20.0)
    assert found["passed"] is False and found["note"].startswith("false by held commands: ")
    limit = float(found["note"].split("comes to ")[1].split()[0])
    assert limit == pytest.approx(found["predicted"], abs=0.05)


def test_a_wrong_limit_is_false_of_the_law_beside_a_drift_too(short_runs):
    assert radius_of(PursuitWrong, 3.0, 20.0)["note"].startswith("false of the law itself: ")


@pytest.mark.parametrize("duration", [10.0, pytest.param(40.0, marks=pytest.mark.release)])
def test_a_false_theorem_of_twists_is_false_of_the_law_itself(duration, short_runs):
    found = check(verdict_of(Wrong, duration), "gap [m]")
    assert found["passed"] is False
    assert found["note"].startswith("false of the law itself: the run of ideal robots")
    assert "has 1.5 after" in found["note"]


def test_a_run_that_is_too_short_is_not_judged_and_says_how_long_it_has_to_be():
    verdict = verdict_of(Follow, 4.0)
    # the gap is 3 m at first: 1.5 (1 - 0.02)^(10 t) < 0.01 from 24.8 s on
    assert verdict["outcome"] == "not_judged"
    assert verdict["reason"] == "the theorem is not tested: 25 s are needed, 4 s were run"
    assert verdict_of(Follow, 27.0)["outcome"] == "passed"


def test_ideal_robots_have_no_limits_no_delay_and_no_filter():
    wrong = {"mismatch": {"speed": 0.5, "delay": 0.4}, "control": {"safety": True}}
    run = simulate(
        {"poses": STARTS, "duration": 3.0, "limits": {"v_max": 0.1, "omega_max": 1.0}, **wrong},
        protocol=Follow,
    )
    ideal = IdealRuns(run._control, run.run).over(30.0)
    gap = ideal.pose[:, 0, 0] - ideal.pose[:, 1, 0]
    assert gap == pytest.approx(1.5 + 1.5 * np.exp(-0.2 * ideal.time), abs=0.01)


def test_ideal_robots_sense_what_stands_in_the_scene():
    control = shipped("wall_following").changed(duration=1.0)
    run = simulate(control)
    ideal = IdealRuns(run._control, run.run).over(20.0)
    assert np.abs(ideal.hand[-1, :, 1]).max() < 0.02  # a metre from the wall at y = 1 m
    assert IdealRuns(run._control, run.run).over(1e6) is None


class FartherApart(SensedFollowing):
    """Claims steady ranges that are 0.2 m too long."""

    def claims(self, start):
        return [
            each._replace(predicted=0.2) if getattr(each, "name", "").startswith("worst") else each
            for each in super().claims(start)
        ]


def test_a_false_theorem_of_a_law_by_sensors_is_false_of_the_law_itself(short_runs):
    two = [[0.0, 0.0, 0.0], [-1.6, 0.3, 0.1]]
    scenario = shipped("sensed_following", duration=12.0).changed(robots=2, poses=two)
    found = check(simulate(scenario, protocol=FartherApart).verdict, "worst range")
    assert found["passed"] is False and "false of the law itself" in found["note"]


def test_a_law_that_raises_elsewhere_costs_no_verdict():
    class Late(Follow):
        def calculateControlLaw(self, pos_map):
            if self.time > 5.0:
                raise RuntimeError("no more")
            return super().calculateControlLaw(pos_map)

    verdict = verdict_of(Late, 4.0)
    assert check(verdict, "gap [m]")["passed"] is None
