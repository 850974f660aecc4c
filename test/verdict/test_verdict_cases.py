"""Correct runs are never failed, and wrong ones are, whatever hid them: limits, short runs, starts."""

import numpy as np
import pytest
from protocol_fixtures import as_points, check, failed, shipped, verdict_of

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import Claim, Condition, NothingDecays, converges_to, decreases, rate
from mrs_simulator.protocols.consensus.law import Consensus
from mrs_simulator.protocols.gathering.law import Containment, Rendezvous
from mrs_simulator.protocols.shapes.law import DisplacementFormation
from mrs_simulator.record.recording import Run
from mrs_simulator.study.run.simulating import simulate

PENTAGRAM = [
    [5.0 * np.cos(4 * np.pi * k / 5), 5.0 * np.sin(4 * np.pi * k / 5), 0.0] for k in range(5)
]
RING = {"edges": [[1, 2], [2, 3], [3, 4], [4, 5], [5, 1]], "directed": False}
CHAIN = {"edges": [[1, 2], [2, 3], [3, 4], [4, 5], [5, 6]]}
LINE = [[4.0 * k, 0.0, 0.0] for k in range(6)]


def controlled(scenario, **changes):
    return scenario.changed(control=dict(scenario.control._asdict(), **changes))


CORRECT = {
    "the paper's path for 110 s": lambda: shipped("paper", {"closure": "path"}, duration=110.0),
    "points for 80 s": lambda: shipped("paper_theory", duration=80.0),
    "a delay near its bound": lambda: shipped("delayed_consensus", {"tau": 0.76}, duration=15.0),
    "little damping": lambda: shipped("second_order_consensus", {"g": 1.5}, duration=15.0),
    "a short run": lambda: shipped("consensus", duration=6.0),
    "a start without the slowest mode": lambda: shipped(
        "consensus", robots=5, poses=PENTAGRAM, topology=RING
    ),
    "no simple modes": lambda: as_points(
        shipped("containment", {"leaders": 1}, robots=6, poses=LINE, topology=CHAIN, duration=60.0)
    ),
    "one factor for the team": lambda: controlled(
        shipped("paper_four", {"closure": "cycle"}), saturation="team"
    ),
    "a safety filter that acts": lambda: controlled(
        shipped("consensus", fidelity="kinematic", limits="top", duration=10.0),
        safety=True,
        saturation="robot",
    ),
    "a flock from a line": lambda: shipped("flocking", robots=6, poses=LINE, duration=8.0),
    "a leader's first seconds": lambda: shipped("leader_follower", duration=4.0),
    "firmware's ramps": lambda: shipped("displacement_formation", limits="firmware", duration=30.0),
}


@pytest.mark.parametrize("name", sorted(CORRECT))
def test_a_correct_run_is_not_failed(tmp_path, name):
    verdict = verdict_of(CORRECT[name](), tmp_path)
    assert verdict["outcome"] != "failed", (failed(verdict), verdict["checks"])


def test_a_run_too_short_for_a_claim_says_so(tmp_path):
    verdict = verdict_of(CORRECT["a short run"](), tmp_path)
    limit = check(verdict, "distance from agreement")
    assert limit["passed"] is None and limit["measured"] > limit["tolerance"]
    assert limit["note"] == "run too short for this claim: 11 s are needed, 6 s were run"
    assert verdict["outcome"] == "passed"  # its commands and its motion were judged


def test_a_filter_that_acts_rules_the_claims_out(tmp_path):
    verdict = verdict_of(CORRECT["a safety filter that acts"](), tmp_path)
    notes = {one["note"] for one in verdict["checks"] if one["passed"] is None}
    assert notes == {"does not apply: the safety filter acted"}
    assert verdict["outcome"] == "not_judged" and check(verdict, "least distance")["passed"]


def test_a_run_is_judged_once_the_filter_has_acted_last(tmp_path):
    """Two robots pass each other; from then on the law alone moves them, and a weak one fails."""

    class Weak(DisplacementFormation):
        def pointMassLaw(self, hand):
            return 0.95 * super().pointMassLaw(hand)

    given = shipped(
        "displacement_formation",
        {"shape": "line", "size": 3.0, "gain": 0.3},
        robots=2,
        poses=[[-2.0, 0.2, 0.0], [2.0, 0.0, 3.14]],
        topology={"preset": "path"},
        duration=11.0,
    )
    given = controlled(given, safety=True)
    right, wrong = verdict_of(given, tmp_path), verdict_of(given, tmp_path, Weak)
    rate = check(right, "decay rate")
    assert right["outcome"] == "passed" and rate["passed"], right["checks"]
    assert rate["note"].endswith("s on, after the safety filter acted")
    assert {rate["name"], "commands off the published law [-]"} <= set(failed(wrong))


class Hasty(Containment):
    def pointMassLaw(self, hand):
        return 1.1 * super().pointMassLaw(hand)


def test_a_moment_at_a_limit_hides_no_wrong_gain(tmp_path):
    given = shipped("containment", limits={"v_max": 1.2, "omega_max": 6.2832}, duration=50.0)
    right = verdict_of(given, tmp_path)
    rate, far = check(right, "decay rate"), check(right, "largest distance from the exact")
    assert rate["passed"] and not rate["note"], rate  # it is the same with and without limits
    assert far["passed"] and "from 1.5 s on, after robot5 was at its limits" in far["note"], far
    assert right["outcome"] == "passed"
    wrong = verdict_of(given, tmp_path, Hasty)
    assert {"commands off the published law [-]", rate["name"], far["name"]} <= set(failed(wrong))


@pytest.mark.parametrize(
    "name, limits, duration, claim",
    [
        ("cucker_smale", {"v_max": 1.5, "omega_max": 6.2832}, 12.0, "drift of the mean velocity"),
        (
            "marching",
            {"v_max": 1.2, "omega_max": 6.2832},
            20.0,
            "drift of the centre from the path",
        ),
        (
            "leader_follower",
            {"v_max": 1.05, "omega_max": 3.0},
            22.0,
            "decay rate of the separation",
        ),
    ],
)
def test_what_a_law_remembers_is_known_after_a_limit(tmp_path, name, limits, duration, claim):
    given = controlled(
        shipped(name, fidelity="kinematic", limits=limits, duration=duration), saturation="robot"
    )
    verdict = verdict_of(given, tmp_path)
    one = check(verdict, claim)
    assert one["passed"] and " s on, after robot" in one["note"], one


def test_a_condition_that_is_sufficient_only_fails_no_run(tmp_path):
    given = shipped("second_order_consensus", {"g": 0.2}, duration=5.0)
    verdict = verdict_of(given, tmp_path)  # below a bound that is necessary
    assert verdict["outcome"] == "failed"
    assert check(verdict, "distance from w^T p(0)")["measured"] > 0.0
    few = verdict_of(shipped("rendezvous", {"gain": 2.0}, duration=1.0), tmp_path)
    assert few["outcome"] == "not_judged" and "curvature of the tension" in few["reason"]
    assert check(few, "distance from the mean")["measured"] > 0.0


class OneStands(Consensus):
    def pointMassLaw(self, hand):
        velocity = super().pointMassLaw(hand)
        velocity[0] = 0.0
        return velocity


def test_robots_that_touch_are_reported_and_their_law_is_judged_before(tmp_path):
    given = controlled(
        shipped("consensus", fidelity="kinematic", limits="top", duration=15.0), saturation="robot"
    )
    right, wrong = verdict_of(given, tmp_path), verdict_of(given, tmp_path, OneStands)
    assert (
        failed(right) == []
        and "theory leads their points there" in check(right, "collisions")["note"]
    )
    note = check(right, "distance from agreement")["note"]
    assert note.startswith("does not apply: robot") and " touched at " in note
    followed = check(right, "largest distance from the law on these robots")
    assert followed["passed"] and followed["note"].startswith("until robot")
    assert followed["name"] in failed(wrong)


def near_the_range(places, heading, **changes):
    parameters = {"gain": 0.05, "radius": 4.0}
    poses = [[x, 0.0, heading] for x in places]
    return shipped("rendezvous", parameters, fidelity="kinematic", poses=poses,
                   robots=len(places), odometry="wheel", **changes)  # fmt: skip


class OtherWay(Rendezvous):
    def pointMassLaw(self, hand):
        return -super().pointMassLaw(hand)


def test_drift_near_the_range_of_an_edge_fails_no_law(tmp_path):
    given = near_the_range([3.999999, 7.499999, 11.489999], 1.26, rate=10, duration=2.0)
    one = check(verdict_of(given, tmp_path), "commands off the published law")
    assert one["passed"] is None and "drift, or another law" in one["note"], one
    far = near_the_range([0.0, 2.0, 4.0], 1.26, rate=10, duration=2.0)
    assert check(verdict_of(far, tmp_path), "commands off the published law")["passed"]
    wrong = check(verdict_of(far, tmp_path, OtherWay), "commands off the published law")
    assert wrong["passed"] is False and wrong["measured"] > 1.0, wrong


@pytest.mark.parametrize("fidelity", ("point_mass", "kinematic"))
def test_a_command_that_no_world_takes_ends_the_run_and_names_itself(fidelity, tmp_path):
    given = near_the_range([0.0, 4.0 - 1e-7, 7.0], 0.0, duration=1.0)
    verdict = verdict_of(given.changed(fidelity=fidelity, odometry="world"), tmp_path)
    assert "at 0.000 s robot" in verdict["ended"] and "at most 1e+12" in verdict["ended"]
    assert "commands off the published law [-]" not in failed(verdict)


def run_of(values):
    """A run of one point whose distance from the origin is each of ``values``."""
    hand = np.zeros((len(values), 1, 2))
    hand[:, 0, 0] = values
    return Run(0.1 * np.arange(len(values)), np.array([1]), None, hand, None)


def test_growth_is_seen_far_below_the_start():
    claim = decreases(lambda hand: hand[:, 0, 0], "growth")
    falling = np.exp(-np.arange(60.0) / 3.0)
    assert claim.measure(run_of(falling)) == 0.0
    falling[50] *= 2.0  # 1e-7 of the start
    assert claim.measure(run_of(falling)) > 0.4


def test_a_rate_is_measured_above_what_friction_leaves():
    """Of ``exp(-t) + 0.002``: on the plateau it is 0, above ``floor`` it is off by what is left at most."""
    time = 0.1 * np.arange(100.0)
    values = np.exp(-time) + 0.002

    def claimed(floor):
        return rate(1.0, lambda hand: hand[:, 0, 0], 0.05, floor=floor)

    run = run_of(values)
    assert claimed(0.0).measure(run) < 0.5
    assert 0.9 < claimed(0.02).measure(run) < 1.0
    with pytest.raises(NothingDecays, match="begins at 1, and below 2 friction holds robots"):
        claimed(2.0).measure(run)
    assert "follow small velocities in part" in claimed(None).unproved


class Shapeless(Consensus):
    def prediction(self, start, time):
        return np.zeros((3, 2))

    def claims(self, start):
        pair = Claim("a pair [m]", 0.0, 1.0, lambda run: run.hand[-1, 0])
        return [*super().claims(start), "no claim", pair, converges_to(np.zeros((2, 2)))]


def test_wrong_shapes_are_reported_and_the_rest_is_judged(tmp_path):
    verdict = verdict_of(shipped("consensus"), tmp_path, Shapeless)
    assert verdict["outcome"] == "failed"
    told = {one["name"]: one["note"] for one in verdict["checks"] if one["passed"] is False}
    assert "shape (3, 2), wanted (201, 6, 2)" in told["prediction() returns"]
    assert "'no claim' among them, wanted Claims and Conditions" in told["claims() returns"]
    assert "of shape (2,), wanted one number" in told["a pair [m]"]
    assert "place = an array (2, 2), wanted points (6, 2)" in told["claims() returns"]
    assert check(verdict, "decay rate")["passed"] and check(verdict, "drift of w^T p")["passed"]


class TwoMeet(PioneerControl):
    def pointMassLaw(self, hand):
        return hand[::-1] - hand


def test_collisions_say_who_and_when(tmp_path):
    given = shipped("reynolds", robots=2, poses=[[0, 0, 0], [1.5, 0, 0]], duration=3.0)
    given = controlled(given, parameters={"l": 0.1})
    collisions = check(verdict_of(given, tmp_path, TwoMeet), "collisions")
    assert collisions["note"].startswith("robot1 and robot2 at ") and "s" in collisions["note"]
    assert collisions["passed"] is False


def test_what_the_dead_band_holds_still_decays_no_more(tmp_path):
    given = shipped("displacement_formation", fidelity="kinematic", duration=20.0)
    verdict = verdict_of(controlled(given, deadband=0.01), tmp_path)
    rate = check(verdict, "decay rate")
    assert rate["passed"] is None and "the dead band 0.01 holds robots still" in rate["note"], rate


class Gathering(PioneerControl):
    def pointMassLaw(self, hand):
        return 0.5 * (hand.mean(axis=0) - hand)

    def claims(self, start):
        return [converges_to(start.mean(axis=0))]


def test_a_claim_that_limits_move_says_how_to_allow_them(tmp_path):
    given = shipped(
        "displacement_formation", duration=12.0, limits={"v_max": 0.3, "omega_max": 1.0}
    )
    given = controlled(given, saturation="robot", parameters={"l": 0.1})
    one = check(verdict_of(given, tmp_path, Gathering), "final distance")
    assert one["passed"] is False and "say free=True" in one["note"], one
    assert one["note"].startswith(
        "the run is too short: what it misses still falls, from 5.26 to 4.37"
    )


class Shifted(PioneerControl):
    """A row, whose middle moves to where the claim has it only while no robot is at a limit."""

    def pointMassLaw(self, hand):
        return -0.1 * (self.topology.laplacian() @ (hand - [[-3.0, 0.0], [0.0, 0.0], [3.0, 0.0]]))

    def claims(self, start):
        return [converges_to(start.mean(axis=0) + [[-3.0, 0.0], [0.0, 0.0], [3.0, 0.0]])]


def test_what_has_settled_elsewhere_by_limits_is_not_called_short():
    given = {
        "poses": [[-4.0, 3.0, 0.0], [0.0, -6.0, 0.0], [2.0, 9.0, 0.0]],
        "topology": {"preset": "path"},
        "limits": {"v_max": 0.3, "omega_max": 1.0},
        "duration": 90.0,
    }
    one = check(simulate(given, protocol=Shifted).verdict, "final distance")
    assert one["passed"] is False and "say free=True" in one["note"], one
    assert "too short" not in one["note"]


class Connected(Gathering):
    def claims(self, start):
        two = Condition("two robots", len(start) > 5)
        return [Condition("connected", self.topology.has_spanning_tree()), two]


@pytest.mark.parametrize("topology", [None, {"edges": []}])
def test_a_condition_that_fails_for_want_of_a_topology_says_so(topology):
    given = {"poses": [[0, 0, 0], [9, 0, 0], [0, 9, 0]], "duration": 1.0}
    given.update({} if topology is None else {"topology": topology})
    verdict = simulate(given, protocol=Connected).verdict
    said = "the scenario has no topology; wanted one, such as topology: {preset: ring}"
    lacks = topology is None
    assert check(verdict, "connected")["note"] == (said if lacks else "")
    assert check(verdict, "two robots")["note"] == ""
    assert verdict["reason"].endswith(said if lacks else "connected, two robots does not hold")
