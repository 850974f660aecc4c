"""Verdicts test the theorem: a false one fails, whatever is published of the law, and at any duration."""

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import (
    Claim,
    converges_to,
    disagreement,
    distance_to,
    ends_at,
    rate,
)
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.protocols.published.laws import Averaging, weights_of
from mrs_simulator.study.run.simulating import simulate

DIRECTED = {"directed": True, "edges": [[1, 2], [2, 3], [3, 4], [4, 1], [1, 3]]}
CHAIN = {"directed": True, "edges": [[1, 2], [2, 3], [3, 4]]}
PLACES = [[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [4.0, 3.0, 2.0], [0.0, 4.0, 0.5]]


class Agree(PioneerControl):
    """Consensus with a published law, whose subclasses claim what is true of it, or not."""

    MEMORYLESS = True

    def pointMassLaw(self, hand):
        return -0.5 * self.topology.laplacian() @ hand

    def published(self):
        return Averaging(weights_of(self.topology), 0.5)


class ToTheMean(Agree):
    def claims(self, start):
        return [converges_to(start.mean(axis=0), 0.02)]


class AtTheRate(Agree):
    TIMES = 1.0

    def claims(self, start):
        own = linear_theorem(0.5 * self.topology.laplacian()).held_rate(self.period)
        return [rate(self.TIMES * own, disagreement, 0.02)]


class TwiceAsFast(AtTheRate):
    TIMES = 2.0


class Faster(AtTheRate):
    TIMES = 1.04


class Between(AtTheRate):
    TIMES = 3.0


class Slower(AtTheRate):
    TIMES = 0.5


def run_of(protocol, topology, duration, poses=PLACES, fidelity="point_mass"):
    scenario = {
        "poses": poses,
        "topology": topology,
        "duration": duration,
        "fidelity": fidelity,
        "limits": "none",
    }
    return simulate(scenario, protocol=protocol)


def check_of(run, beginning):
    (found,) = [c for c in run.verdict["checks"] if c["name"].startswith(beginning)]
    return found


@pytest.mark.parametrize("duration", [2.0, 100.0, pytest.param(300.0, marks=pytest.mark.release)])
def test_the_mean_of_a_directed_graph_is_false_of_the_law_itself(duration):
    run = run_of(ToTheMean, DIRECTED, duration)
    found = check_of(run, "final distance")
    assert run.verdict["outcome"] == "failed" and found["passed"] is False
    assert found["note"].startswith("false of the law itself: the exact solution")
    assert found["tolerance"] == 0.02


def test_a_false_theorem_fails_whatever_the_robots_do():
    found = check_of(run_of(ToTheMean, DIRECTED, 8.0, fidelity="kinematic"), "final distance")
    assert found["passed"] is False and "false of the law itself" in found["note"]


@pytest.mark.parametrize(
    "wrong, duration",
    [
        (TwiceAsFast, 10.0),
        (Faster, 10.0),
        (Faster, 100.0),
        (Slower, 10.0),
        pytest.param(TwiceAsFast, 100.0, marks=pytest.mark.release),
        pytest.param(Slower, 100.0, marks=pytest.mark.release),
    ],
)
def test_a_false_rate_is_false_of_the_law_itself(wrong, duration):
    found = check_of(run_of(wrong, {"preset": "path"}, duration), "decay rate")
    assert found["passed"] is False and "decays by" in found["note"]


def test_the_true_rate_passes_and_before_it_shows_is_not_judged():
    assert run_of(AtTheRate, DIRECTED, 60.0).passed
    run = run_of(AtTheRate, DIRECTED, 3.0)
    assert run.verdict["outcome"] == "not_judged"
    assert "the law is confirmed; the theorem is not tested: " in run.verdict["reason"]
    needed = float(run.verdict["reason"].split(": ")[-1].split()[0])
    assert run_of(AtTheRate, DIRECTED, needed + 1.0).passed
    assert not run_of(AtTheRate, DIRECTED, 0.9 * needed - 1.0).passed


def test_a_start_without_the_slowest_mode_is_no_proof_against_a_rate():
    line = [[x, 0.7 * x, 0.0] for x in (1.0, -1.0, -1.0, 1.0)]  # the third of the path's modes
    run = run_of(AtTheRate, {"preset": "path"}, 60.0, line)
    found = check_of(run, "decay rate")
    assert found["passed"] is None and run.verdict["outcome"] != "failed"
    text, shown = found["note"].rsplit(" by ", 1)
    assert text.endswith("this start lacks the slowest mode; one beside it decays")
    assert float(shown.split()[0]) == pytest.approx(found["predicted"], rel=0.01)
    # A rate between those of this start and of one beside it is of neither.
    found = check_of(run_of(Between, {"preset": "path"}, 60.0, line), "decay rate")
    assert found["passed"] is False and "from one beside it" in found["note"]


def test_what_comes_back_at_twice_the_time_has_not_settled():
    def still_turns(run):
        """Return what is the same after 10, 20, 40, ... s, and nothing after 300 s."""
        lasted = run.time[-1] - run.time[0]
        return 0.0 if lasted > 300.0 else 0.5 + 0.4 * np.sin(2.0 * np.pi * np.log2(lasted / 10.0))

    class Turns(Agree):
        def claims(self, start):
            return [Claim("what turns [-]", 0.0, 0.02, still_turns)]

    found = check_of(run_of(Turns, {"preset": "path"}, 10.0), "what turns")
    assert found["passed"] is None and found["note"].startswith("run too short for this claim")


def test_a_defective_mode_has_no_simple_rate():
    class OfTheChain(Agree):
        def claims(self, start):
            return [rate(0.5, distance_to(start[3]), 0.02)]

    found = check_of(run_of(OfTheChain, CHAIN, 60.0), "decay rate")
    assert found["passed"] is None and "no simple rate" in found["note"]


def test_what_held_commands_make_false_is_said():
    class Continuous(Agree):
        def claims(self, start):
            own = np.sort(np.linalg.eigvals(0.5 * self.topology.laplacian()).real)[1]
            return [rate(own, disagreement, 0.015)]

    found = check_of(run_of(Continuous, {"preset": "complete"}, 20.0), "decay rate")
    assert found["passed"] is False and found["note"].startswith("false by held commands")


@pytest.mark.parametrize("gain, times", [(60.0, 2), (170.0, 4)])
def test_so_many_commands_more_are_named_as_mend_what_few_make_false(gain, times):
    """Two points agree while ``|1 - 2 gain/rate| < 1``: not at 50 Hz, but at so many times that."""

    class Strong(Agree):
        def pointMassLaw(self, hand):
            return -gain * (self.topology.laplacian() @ hand)

        def published(self):
            return Averaging(weights_of(self.topology), gain)

        def claims(self, start):
            size = lambda hand: np.log10(1.0 + np.ptp(hand, axis=1).max(axis=1))  # noqa: E731
            return [ends_at(size, 0.0, 0.01, "size of the spread [-]")]

    start = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    found = check_of(run_of(Strong, {"preset": "complete"}, 0.1, start), "size")
    assert found["passed"] is False and found["note"].startswith("false by held commands"), found
    assert found["note"].endswith("with {} times the commands".format(times))


def test_a_law_alone_is_no_theorem():
    verdict = simulate("paper", duration=3.0).verdict
    assert verdict["outcome"] == "not_judged" and not verdict["passed"]
    assert verdict["reason"].startswith("the law is confirmed; the theorem is not tested: ")
    assert verdict["reason"].endswith(" s are needed, 3 s were run")


# By scenario: the beginnings of claims, and how many times, or how far [m] aside, each is false.
FALSE_IN_SHIPPED = {
    "displacement_formation": {"decay rate": (1.03, 0.0), "distance from d": (1.0, 0.06)},
    "consensus": {"decay rate": (1.03, 0.0), "distance from": (1.0, 0.06)},
    "discrete_consensus": {"decay rate": (0.97, 0.0)},
    "paper": {
        "settling time": (1.03, 0.0),
        "final gap": (1.0125, 0.0),
        "distance from final": (1.0, 0.12),
    },
}


@pytest.mark.parametrize("name", FALSE_IN_SHIPPED)
def test_a_false_claim_of_a_shipped_law_fails(name):
    scenario, wrong = shipped(name), FALSE_IN_SHIPPED[name]
    own = load_protocol(scenario.control.protocol)

    class Falsified(own):
        def all_claims(self, start):
            return [self._false(claim) for claim in own.all_claims(self, start)]

        def _false(self, claim):
            by = next((by for name, by in wrong.items() if claim.name.startswith(name)), None)
            if by is None:
                return claim
            times, aside = by
            if not aside:
                return claim._replace(predicted=times * claim.predicted)
            moved = aside * np.array([0.6, 0.8])
            return claim._replace(
                measure=lambda run: claim.measure(run._replace(hand=run.hand - moved))
            )

    run = simulate(scenario, protocol=Falsified)
    found = {name: check_of(run, name)["passed"] for name in wrong}
    assert found == dict.fromkeys(wrong, False) and run.verdict["outcome"] == "failed"
