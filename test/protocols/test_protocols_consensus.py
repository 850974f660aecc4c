"""The consensus family: each equation in numbers, theorems by simulation, bounds from both sides."""

import numpy as np
import pytest
from protocol_fixtures import ended_early, part_of_shipped, played
from protocol_fixtures import shipped as scenario_of

from mrs_simulator import open_run, run_experiment, simulate
from mrs_simulator.core.claims import Condition, disagreement, extent
from mrs_simulator.core.graphs import Topology, arcs_of
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.linear_theorem import linear_theorem
from mrs_simulator.core.spectra import spectral_radius
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.protocols.consensus import equations as laws
from mrs_simulator.protocols.consensus.resilient_equations import is_robust, resilient_consensus
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.study.results.report import judged
from mrs_simulator.study.run.experiment import Experiment

# By the share of their duration after which they have agreed.
SCENARIOS = {
    "consensus": 0.7,
    "consensus_directed": 0.7,
    "delayed_consensus": 0.5,
    "discrete_consensus": 0.7,
    "event_triggered_consensus": 0.6,
    "lossy_consensus": 0.7,
    "resilient_consensus": 0.6,
    "second_order_consensus": 0.6,
    "switching_consensus": 0.6,
}


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a scenario and returns verdict and recording.

    With ``law`` the robots follow it while the shipped protocol makes the claims.
    """

    def runs(name, law=None, **changes):
        scenario, protocol = scenario_of(name, **changes), None
        if law is not None:
            protocol = type("Broken", (shipped(scenario.control.protocol),), {"pointMassLaw": law})
            control = dict(scenario.control._asdict(), protocol="test:Broken")
            scenario = scenario.changed(control=control)
        verdict = run_experiment(scenario, str(tmp_path), protocol, formats=())
        return verdict, read_run_csv(str(tmp_path / "run.csv"), scenario)

    return runs


def with_value(name, value):
    """Return a law that takes another value of a parameter than the claims do."""

    def law(self, hand):
        claimed = getattr(self, name)
        setattr(self, name, value)
        try:
            return super(type(self), self).pointMassLaw(hand)
        finally:
            setattr(self, name, claimed)

    return law


def check(verdict, words):
    (found,) = [check for check in verdict["checks"] if words in check["name"]]
    return found


def failed(verdict):
    return [check["name"] for check in verdict["checks"] if check["passed"] is False]


def track_of(name, **changes):
    """Return the hand points, (m, n, 2), of a run without its files."""
    samples = Experiment(scenario_of(name, **changes)).samples()
    return np.array([hand_points(pose, 0.05) for _, pose, _ in samples])


@ended_early(SCENARIOS)
def test_the_example_passes_all_its_claims(run, name, share):
    verdict, _ = run(name, duration=part_of_shipped(name, share).duration)
    assert verdict["passed"], verdict["checks"]
    assert all(check["passed"] for check in verdict["checks"]), "a claim was skipped"
    assert len(verdict["checks"]) >= 7


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_wrong_sign_fails(run, name):
    protocol = shipped(scenario_of(name).control.protocol)

    def away(self, hand):
        return -protocol.pointMassLaw(self, hand)

    verdict, _ = run(name, law=away, duration=5.0)
    assert len(failed(verdict)) >= 2


@pytest.mark.parametrize("name", SCENARIOS)
def test_missing_edges_and_a_negative_gain_are_said(run, name):
    verdict, _ = run(name, topology={"edges": [[1, 2]], "directed": False}, duration=0.5)
    if name == "resilient_consensus":  # robustness is sufficient: without it theory says nothing
        assert verdict["outcome"] == "not_judged" and "robust does not" in verdict["reason"]
    else:
        assert set(failed(verdict)) & {"spanning tree", "jointly a spanning tree"}
    if "gain" in scenario_of(name).control.parameters:
        verdict, _ = run(name, parameters={"gain": -0.1}, duration=0.5)
        assert "gain above 0" in failed(verdict)


@pytest.mark.parametrize("name", sorted(set(SCENARIOS) - {"resilient_consensus"}))
def test_one_robot_agrees_with_itself(run, name):
    verdict, _ = run(
        name,
        robots=1,
        poses=[[1.0, 2.0, 0.0]],
        topology={"edges": [], "directed": False},
        duration=1.0,
    )
    assert verdict["passed"], verdict["checks"]


@pytest.mark.parametrize("name", sorted(name for name in HOMES if "consensus" in name))
def test_a_control_begins_anew_when_time_goes_back(name):
    scenario = scenario_of(name)
    control = shipped(name)(range(1, scenario.n + 1), scenario.topology, period=0.02)
    np.testing.assert_array_equal(
        played(control, scenario, 0.02, 30), played(control, scenario, 0.02, 30)
    )


# Consensus over directed graphs, and in steps ----------------------------------------------------


def test_a_directed_graph_weighs_by_its_left_null_vector(run):
    verdict, recorded = run("consensus_directed")
    start = recorded.hand[0]
    decided = (4.0 * start[0] + 2.0 * start[1] + 1.0 * start[2]) / 7.0
    np.testing.assert_allclose(recorded.hand[-1], np.tile(decided, (6, 1)), atol=1e-3)
    assert np.linalg.norm(start.mean(axis=0) - decided) > 1.0
    assert check(verdict, "decay rate")["predicted"] == pytest.approx(0.5025, abs=1e-4)


def test_without_simple_modes_no_rate_is_claimed(run):
    verdict, _ = run("consensus", topology={"preset": "chain"}, duration=40.0)
    assert verdict["passed"]
    assert not [c for c in verdict["checks"] if "rate" in c["name"]]
    assert not linear_theorem(Topology.preset("cycle", 5).laplacian()).is_defective


@pytest.mark.parametrize("gain, holds", [(49.0, True), (51.0, False)])
def test_a_directed_ring_of_three_bears_less_gain_than_its_radius_says(run, gain, holds):
    """mu = 3/2 +- i sqrt(3)/2: 2 Re/|mu|^2 = 1, against 2/|mu| = 1.155."""
    ring = {"robots": 3, "poses": [[3, 0, 0], [-2, 4, 0], [-1, -3, 0]]}
    ring["topology"] = {"preset": "cycle"}
    for name, bound in (
        ("consensus", "gain Tc < 2/lambda_max"),
        ("displacement_formation", "gain Tc < 2/lambda_max"),
        ("marching", "Tc < 2/(gain lambda_max + anchor) [s]"),
    ):
        control = make_control(scenario_of(name, {"gain": gain}, **ring))
        conditions = [c for c in control.claims(np.zeros((3, 2))) if isinstance(c, Condition)]
        assert [c.name for c in conditions if not c.holds] == ([] if holds else [bound])
    verdict, recorded = run("consensus", parameters={"gain": gain}, **ring)
    assert verdict["passed"] == holds
    assert (disagreement(recorded.hand)[-1] < 1e-3) == holds


def test_discrete_consensus_in_numbers():
    path = Topology.preset("path", 3)
    p = np.array([[0.0, 0.0], [1.0, 2.0], [4.0, 0.0]])
    expected = [[0.25, 0.5], [1.5, 1.0], [3.25, 0.5]]
    np.testing.assert_allclose(laws.discrete_consensus(p, path, 0.25), expected, atol=1e-12)
    assert laws.largest_step(path) == pytest.approx(2.0 / 3.0)  # eigenvalues 0, 1, 3
    # A directed ring of four: mu = 1 - i, 2, 1 + i; 2 Re/|mu|^2 = 1 for each.
    assert laws.largest_step(Topology.preset("cycle", 4)) == pytest.approx(1.0)


def test_discrete_consensus_converges_below_the_bound_only(run):
    topology = scenario_of("discrete_consensus").topology
    bound = 2.0 / spectral_radius(topology)
    verdict, recorded = run("discrete_consensus", parameters={"eps": 0.95 * bound}, duration=60.0)
    assert verdict["passed"], verdict["checks"]
    steps = recorded.hand[:5]
    expected = [recorded.hand[0]]
    for _ in range(4):
        expected.append(expected[-1] - 0.95 * bound * topology.laplacian() @ expected[-1])
    np.testing.assert_allclose(steps, expected, atol=1e-12)
    verdict, recorded = run("discrete_consensus", parameters={"eps": 1.05 * bound}, duration=60.0)
    assert failed(verdict) == ["eps < 2/lambda_max"]
    assert disagreement(recorded.hand)[-1] > disagreement(recorded.hand)[0]


# Delayed -----------------------------------------------------------------------------------------


def test_delay_bounds_in_numbers():
    ring = scenario_of("delayed_consensus").topology  # lambda_max = 4
    assert linear_theorem(0.5 * ring.laplacian()).longest_delay == pytest.approx(np.pi / 4.0)
    # mu = 1 - i, 2, 1 + i: (pi/4)/sqrt 2 and (pi/2)/2.
    directed = Topology.preset("cycle", 4)
    assert linear_theorem(directed.laplacian()).longest_delay == pytest.approx(
        np.pi / 4.0 / np.sqrt(2.0)
    )
    # Two robots, mu = 2, one step of delay: z^2 - z + 2 gain Tc = 0; z = 0.5 +- 0.5i at 0.5.
    pair = Topology.preset("path", 2).laplacian()
    assert linear_theorem(2.5 * pair).held_rate(0.1, 1) == pytest.approx(np.log(2.0) / 2.0 / 0.1)
    # d steps of delay: unstable from gain Tc mu = 2 sin(pi/(2(2d+1))) on.
    for d in (1, 5, 20):
        edge = np.sin(np.pi / (2.0 * (2 * d + 1)))
        assert linear_theorem(0.999 * edge * pair).held_rate(1.0, d) > 0.0
        assert linear_theorem(1.001 * edge * pair).held_rate(1.0, d) < 0.0


def test_delayed_law_uses_the_positions_of_tau_ago():
    topology = Topology.preset("path", 2)
    control = shipped("delayed_consensus")(
        (1, 2), topology, parameters={"gain": 2.0, "tau": 0.2}, period=0.1
    )
    seen = []
    for step in range(5):
        control.time = 0.1 * step
        seen.append(control.pointMassLaw(np.array([[0.0, 0.0], [1.0 + step, 0.0]]))[0, 0])
    assert seen == [2.0, 2.0, 2.0, 4.0, 6.0]


@pytest.mark.parametrize("share, stable", [(0.95, True), (1.05, False)])
def test_delayed_consensus_five_percent_either_side(run, share, stable):
    tau = float(share * np.pi / (2.0 * 4.0))  # gain 2, lambda_max 2
    parameters, duration = {"gain": 2.0, "tau": tau}, 60.0 if stable else 30.0
    two = {"robots": 2, "poses": [[3, 0, 0], [-2, 4, 0]], "topology": {"preset": "path"}}
    changes = {"parameters": parameters, "duration": duration, **two}
    verdict, recorded = run("delayed_consensus", rate=100, **changes)
    size = disagreement(recorded.hand)
    if stable:
        assert verdict["passed"], verdict["checks"]
        assert size[-50:].max() < 1e-2 * size[0]
    else:
        assert failed(verdict) == ["tau < pi/(2 gain lambda_max) [s]", "stable with held commands"]
        assert size[-50:].max() > 10.0 * size[0]


# Second order ------------------------------------------------------------------------------------


def test_second_order_in_numbers():
    chain = Topology.preset("chain", 2)
    p, v = np.array([[0.0, 0.0], [1.0, 2.0]]), np.array([[1.0, 0.0], [0.0, 0.5]])
    force = laws.second_order_consensus(p, v, chain, 2.0)
    np.testing.assert_allclose(force, [[-1.0, 3.0], [0.0, 0.0]])
    # Ring of six: mu = (1 -+ i sqrt 3)/2 is the worst: sqrt(0.75/(0.5 * 1)).
    assert laws.least_damping(Topology.preset("cycle", 6)) == pytest.approx(np.sqrt(1.5))
    assert laws.least_damping(Topology.preset("path", 5)) == 0.0


def test_second_order_rate_is_that_of_the_whole_matrix():
    topology, g, T = Topology.preset("cycle", 6), 2.0, 0.01
    L, eye = topology.laplacian(), np.eye(6)
    matrix = np.block([[eye - T * T * L, T * (eye - T * g * L)], [-T * L, eye - T * g * L]])
    sizes = np.sort(np.abs(np.linalg.eigvals(matrix)))
    np.testing.assert_allclose(sizes[-2:], 1.0, atol=1e-6)
    found = linear_theorem(laws.unshared_motion(topology, g, T)).held_rate(T)
    assert found == pytest.approx(-np.log(sizes[-3]) / T)


@pytest.mark.parametrize("share, stable", [(0.95, False), (1.05, True)])
def test_second_order_five_percent_either_side(run, share, stable):
    g = float(share * np.sqrt(1.5))
    changes = {"parameters": {"g": g}, "duration": 190.0 if stable else 80.0, "record_rate": 2.0}
    verdict, recorded = run("second_order_consensus", rate=50, **changes)
    size = disagreement(recorded.hand)
    if stable:
        assert verdict["passed"], verdict["checks"]
        assert size[-20:].max() < 1e-2 * size[0]
    else:
        assert "g > max sqrt(Im(mu)^2/(Re(mu)|mu|^2)) [s]" in failed(verdict)
        assert size[-20:].max() > 2.0 * size[0]


def test_second_order_agrees_on_a_velocity(run):
    _, recorded = run("second_order_consensus")
    speed = np.diff(recorded.hand[-3:], axis=0) / 0.1
    control = shipped("second_order_consensus")(range(1, 7), parameters={"push": 1.0, "seed": 3})
    agreed = control.initial_velocities().mean(axis=0)
    assert np.linalg.norm(agreed) > 0.3
    np.testing.assert_allclose(speed, np.tile(agreed, (2, 6, 1)), atol=1e-3)


# Switching and loss ------------------------------------------------------------------------------


def test_switching_in_numbers():
    topology = Topology(3, [[1, 2, 2.0], [2, 3]], directed=False)
    arcs, weights, edges = arcs_of(topology)
    assert arcs.tolist() == [[0, 1], [1, 2], [1, 0], [2, 1]]
    assert (weights.tolist(), edges.tolist()) == ([2.0, 1.0, 2.0, 1.0], [0, 1, 0, 1])
    p = np.array([[0.0, 0.0], [1.0, 2.0], [4.0, 0.0]])
    all_up = laws.switching_consensus(p, arcs, weights)
    np.testing.assert_allclose(all_up, laws.consensus(p, topology))
    first = laws.switching_consensus(p, arcs, weights * (edges == 0))
    np.testing.assert_allclose(first, [[2.0, 4.0], [-2.0, -4.0], [0.0, 0.0]])


def test_each_set_alone_is_disconnected_and_all_together_agree():
    topology = scenario_of("switching_consensus").topology
    for turn in range(3):
        assert not Topology(6, topology.edges[turn::3], directed=False).has_spanning_tree()
    assert topology.has_spanning_tree()


def test_switching_follows_the_product_of_its_steps(run):
    _, recorded = run("switching_consensus", duration=1.5)
    topology = scenario_of("switching_consensus").topology
    point = recorded.hand[0]
    for turn in range(3):
        L = Topology(6, topology.edges[turn::3], directed=False).laplacian()
        for _ in range(25):
            point = point - 0.02 * L @ point
    np.testing.assert_allclose(recorded.hand[-1], point, atol=1e-12)


def test_without_one_edge_the_union_is_no_longer_connected(run):
    edges = [[1, 2], [2, 3], [4, 5], [5, 6]]
    topology = {"edges": edges, "directed": False}
    verdict, recorded = run("switching_consensus", topology=topology, rate=10)
    assert failed(verdict) == ["jointly a spanning tree"]
    assert extent(recorded.hand)[-1] > 1.0


def test_switching_over_directed_edges_has_the_limit_of_its_round(run):
    edges = [[1, 2], [2, 3, 2.0], [3, 4], [4, 1], [1, 5], [5, 6], [6, 2]]
    verdict, recorded = run(
        "switching_consensus",
        topology={"edges": edges, "directed": True},
        rate=10,
        duration=60.0,
    )
    assert verdict["passed"], verdict["checks"]
    assert not [c for c in verdict["checks"] if "mean" in c["name"]]
    assert check(verdict, "the limit")["measured"] < 1e-3
    assert np.linalg.norm(recorded.hand[-1, 0] - recorded.hand[0].mean(axis=0)) > 0.1


@pytest.mark.parametrize("symmetric", [True, False])
def test_symmetric_loss_alone_keeps_the_mean(run, symmetric):
    verdict, recorded = run("lossy_consensus", parameters={"symmetric": symmetric})
    drift = np.linalg.norm(recorded.hand.mean(axis=1) - recorded.hand[0].mean(axis=0), axis=1).max()
    assert verdict["passed"], verdict["checks"]
    assert (drift < 1e-12) == symmetric
    assert symmetric == any("mean" in c["name"] for c in verdict["checks"])
    if not symmetric:
        assert drift > 0.1


def test_losses_repeat_with_their_seed():
    tracks = [track_of("lossy_consensus", parameters={"seed": s}, duration=5.0) for s in (1, 1, 2)]
    np.testing.assert_array_equal(tracks[0], tracks[1])
    assert np.abs(tracks[0] - tracks[2]).max() > 0.1


def test_edges_are_lost_as_often_as_asked():
    control = shipped("switching_consensus")(
        range(1, 7), Topology.preset("complete", 6), parameters={"loss": 0.7}
    )
    control.begin(None)
    edges = arcs_of(control.topology)[2]
    arrived = np.array([control._arrives(edges) for _ in range(2000)])
    assert arrived.mean() == pytest.approx(0.3, abs=0.01)
    np.testing.assert_array_equal(arrived[:, :15], arrived[:, 15:])


# Event-triggered ---------------------------------------------------------------------------------


def test_event_thresholds_in_numbers():
    path = Topology.preset("path", 3)  # degrees 1, 2, 1: a = 1/4
    p = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 4.0]])
    # sqrt(0.5 * a (1 - a d)/d) |z|, |z| = 5, 5, 0
    expected = [5.0 * np.sqrt(0.5 * 0.25 * 0.75), 5.0 * np.sqrt(0.5 * 0.25 * 0.5 / 2.0), 0.0]
    np.testing.assert_allclose(laws.event_thresholds(p, path, 0.5), expected, atol=1e-12)


@pytest.mark.parametrize("sigma", [0.05, pytest.param(0.5, marks=pytest.mark.release), 0.98])
@pytest.mark.parametrize("preset", ["path", "star", "complete"])
def test_few_broadcasts_suffice_on_other_graphs(run, preset, sigma):
    top = spectral_radius(Topology.preset(preset, 6))
    gain = float(0.09 * np.sqrt(sigma) / (0.01 * top))
    verdict, _ = run(
        "event_triggered_consensus",
        parameters={"sigma": sigma, "gain": gain},
        topology={"preset": preset},
        duration=5.0,
    )
    assert set(failed(verdict)) <= {"distance from the mean [m]"}, verdict["checks"]
    assert check(verdict, "broadcasts")["passed"] and check(verdict, "growth")["passed"]


def test_broadcasts_are_counted_alike_from_the_recording(run):
    verdict, recorded = run("event_triggered_consensus", record_rate=100.0, duration=5.0)
    assert verdict["commands"] == 501
    assert 6 < verdict["broadcasts"] < 0.05 * 6 * 501
    again, _ = judged(recorded, make_control(recorded.scenario))
    assert (again["broadcasts"], again["commands"]) == (verdict["broadcasts"], verdict["commands"])


def test_events_that_come_too_late_let_the_potential_grow(run):
    verdict, _ = run("event_triggered_consensus", law=with_value("sigma", 60.0), duration=10.0)
    assert "growth of p^T L p [-]" in failed(verdict)


def test_the_periodic_law_broadcasts_too_often(run):
    verdict, _ = run("event_triggered_consensus", law=with_value("sigma", 0.0), duration=8.0)
    assert "broadcasts a robot and command [-]" in failed(verdict)
    assert "exact share of events [-]" in failed(verdict)


# Resilient ---------------------------------------------------------------------------------------


def test_resilient_consensus_in_numbers():
    p = np.array([[0.0, 0.0], [1.0, -1.0], [2.0, -2.0], [9.0, -9.0], [-7.0, -3.0]])
    complete = Topology.preset("complete", 5)
    kept = resilient_consensus(p, complete, 1)
    # Robot 1, x: drops 9 and -7; keeps 1 and 2.  y: nothing is above; drops -9.
    np.testing.assert_allclose(kept[0], [3.0, -6.0])
    # Robot 4, x: nothing is above; drops -7; keeps 0, 1, 2.
    np.testing.assert_allclose(kept[3, 0], (0 - 9) + (1 - 9) + (2 - 9))
    np.testing.assert_allclose(resilient_consensus(p, complete, 0), laws.consensus(p, complete))
    np.testing.assert_allclose(resilient_consensus(p, complete, 9), 0.0)
    # A robot that is not heard is never among those dropped.
    weighted = Topology(3, [[1, 2, 2.0], [1, 3]])
    np.testing.assert_allclose(resilient_consensus(p[:3], weighted, 1)[0], [2.0, -2.0])


def test_robustness_in_numbers():
    # K_n is ceil(n/2)-robust, a ring 1-robust and not more, a path over pairs not (2, 2).
    assert is_robust(Topology.preset("complete", 5), 3, 1)
    assert not is_robust(Topology.preset("complete", 5), 4, 1)
    ring = Topology(6, [[i, i % 6 + 1] for i in range(1, 7)], directed=False)
    assert is_robust(ring, 1, 1) and not is_robust(ring, 2, 1) and not is_robust(ring, 2, 2)
    assert is_robust(scenario_of("resilient_consensus").topology, 2, 2)
    # (1, 1)-robust is having a spanning tree.
    assert is_robust(Topology.preset("chain", 4), 1, 1)
    assert not is_robust(Topology(4, [[1, 2], [3, 4]]), 1, 1)
    assert is_robust(Topology.preset("complete", 40), 2, 2)
    assert is_robust(Topology.preset("path", 40), 2, 2) is None


def test_robustness_agrees_with_its_definition():
    draw = np.random.default_rng(0)

    def slow(adjacency, r, s):
        n = len(adjacency)
        sets = [[i for i in range(n) if code >> i & 1] for code in range(1, 2**n)]

        def reached(own):
            return sum(sum(adjacency[i, j] for j in range(n) if j not in own) >= r for i in own)

        for first in sets:
            for second in sets:
                if set(first) & set(second):
                    continue
                x, y = reached(first), reached(second)
                if x < len(first) and y < len(second) and x + y < s:
                    return False
        return True

    for _ in range(12):
        pairs = [[i, j] for i in range(1, 6) for j in range(1, 6) if i != j and draw.random() < 0.7]
        topology = Topology(5, pairs)
        for r, s in ((1, 1), (2, 1), (2, 2), (3, 1)):
            assert is_robust(topology, r, s) == slow(topology.adjacency(), r, s)


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_an_adversary_drags_none_along(run, turn):
    verdict, recorded = run("resilient_consensus", parameters={"turn": turn})
    assert verdict["passed"], verdict["checks"]
    start, end = recorded.hand[0, :7], recorded.hand[-1, :7]
    assert np.all(end >= start.min(axis=0)) and np.all(end <= start.max(axis=0))
    assert np.linalg.norm(recorded.hand[:, 7] - recorded.hand[0, 7], axis=1).max() > 2.0


def test_two_adversaries_are_too_many_for_one_dropped(run):
    verdict, _ = run("resilient_consensus", parameters={"adversaries": 2}, duration=1.0)
    assert verdict["outcome"] == "not_judged" and not failed(verdict)
    assert verdict["reason"].endswith("adversaries <= F does not hold")
    (extent,) = [c for c in verdict["checks"] if c["name"].startswith("final extent")]
    assert extent["passed"] is None and extent["measured"] > 0.0


def test_plain_consensus_is_dragged_out_by_an_adversary(run):
    verdict, _ = run("resilient_consensus", law=with_value("F", 0), parameters={"turn": 0.0})
    assert "way out of the box of their starts [m]" in failed(verdict)
    assert "final extent of the normal robots [m]" in failed(verdict)


def test_all_robots_adversaries_is_said(run):
    verdict, _ = run("resilient_consensus", parameters={"adversaries": 9}, duration=1.0)
    assert verdict["outcome"] == "not_judged" and "a normal robot" in verdict["reason"]


@pytest.mark.parametrize("fidelity, off", (("point_mass", 0), ("kinematic", 2)))
def test_broadcasts_are_counted_from_the_files_of_a_run_too(tmp_path, fidelity, off):
    scenario = scenario_of("event_triggered_consensus", fidelity=fidelity, duration=3.0)
    made, read = simulate(scenario, out=tmp_path), open_run(tmp_path)
    assert made.verdict["commands"] == read.verdict["commands"] == 301
    assert abs(made.verdict["broadcasts"] - read.verdict["broadcasts"]) <= off
    assert made.verdict["outcome"] == read.verdict["outcome"]
