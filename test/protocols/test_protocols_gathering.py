"""Containment, rendezvous, cyclic pursuit and coverage: the laws, their properties, their verdicts."""

import numpy as np
import pytest
from protocol_fixtures import check, ended_early, failed, part_of_shipped, shipped, verdict_of

from mrs_simulator import PioneerControl
from mrs_simulator.core.claims import Claim
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols.gathering import equations as laws
from mrs_simulator.protocols.gathering.energies import coverage_energy, tension_energy
from mrs_simulator.protocols.gathering.law import Containment, Coverage, CyclicPursuit, Rendezvous


@ended_early(
    {
        "containment": 0.75,
        "rendezvous": 0.75,
        "cyclic_pursuit": 0.4,
        "cyclic_pursuit_inwards": 0.5,
        "coverage": None,  # dear; of four robots it is run below
    }
)
def test_the_example_passes_and_every_claim_is_tested(tmp_path, name, share):
    verdict = verdict_of(part_of_shipped(name, share), tmp_path)
    assert all(check["passed"] for check in verdict["checks"]), verdict["checks"]
    if shipped(name).fidelity == "kinematic":
        assert verdict["min_distance"] > 0.6


# Containment


def test_containment_typed_out():
    topology = Topology(3, [(1, 2), (1, 3, 2.0), (2, 1)])
    points = np.array([[1.0, 0.0], [2.0, 2.0], [5.0, -1.0]])
    expected = [[1.0 + 2.0 * 4.0, 2.0 - 2.0], [-1.0, -2.0], [0.0, 0.0]]
    np.testing.assert_allclose(laws.containment_flow(1.0, topology, 1).velocity(points), expected)


def test_the_limit_is_the_weighted_mean_of_the_leaders():
    # The middle of a path: 1 hears 2 and leader 3, 2 hears 1 and leader 4.
    topology = Topology(4, [(1, 2), (1, 3), (2, 1), (2, 4)])
    limit = laws.containment_limit(np.array([[0.0, 0.0], [3.0, 6.0]]), topology)
    np.testing.assert_allclose(limit, [[1.0, 2.0], [2.0, 4.0]])


def test_distance_outside_a_hull():
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    points = np.array([[1.0, 1.0], [3.0, 1.0], [2.5, 2.5], [2.0, 0.5]])
    outside = laws.outside_hull(points, corners)
    np.testing.assert_allclose(outside, [-1.0, 1.0, np.sqrt(0.5), 0.0], atol=1e-4)


def test_a_follower_that_receives_from_no_leader_fails(tmp_path):
    scenario = shipped("containment", duration=2.0)
    edges = [edge for edge in scenario.topology.edges if edge[1] < 6]
    verdict = verdict_of(scenario.changed(topology={"edges": edges}), tmp_path)
    assert failed(verdict) == ["all hear a leader"]


@pytest.mark.parametrize("gain, name", [(-0.03, "gain above 0"), (60.0, "|1 - gain Tc")])
def test_containment_with_an_impossible_gain_fails(tmp_path, gain, name):
    scenario = shipped("containment", {"gain": gain}, fidelity="point_mass", duration=1.0)
    verdict = verdict_of(scenario, tmp_path)
    assert failed(verdict)[0].startswith(name)


class LosesAnEdge(Containment):
    def pointMassLaw(self, hand):
        kept = Topology(len(hand), self.topology.edges[1:])
        return laws.containment_flow(self.gain, kept, self.leaders).velocity(hand)


def test_containment_without_one_edge_misses_its_limit(tmp_path):
    scenario = shipped("containment", fidelity="point_mass", duration=165.0)
    assert check(verdict_of(scenario, tmp_path, LosesAnEdge), "distance from -L")["passed"] is False


def test_more_leaders_than_robots_are_refused():
    with pytest.raises(ValueError, match="leaders = 4"):
        Containment(range(1, 4), parameters={"leaders": 4})


def test_followers_in_a_chain_decay_at_no_simple_rate():
    """``L_ff`` of equal weights is one Jordan block."""
    control = Containment((1, 2, 3, 4), Topology.preset("chain", 4), parameters={"leaders": 1})
    names = [claim.name for claim in control.claims(np.eye(4, 2)) if isinstance(claim, Claim)]
    assert "distance from -L_ff^-1 L_fl p_l [m]" in names
    assert not [name for name in names if "rate" in name]


def test_the_exact_solution_of_containment(tmp_path):
    scenario = shipped("containment", fidelity="point_mass", duration=20.0)
    control = Containment(
        range(1, 10), scenario.topology, parameters=dict(scenario.control.parameters)
    )
    hand = scenario.poses[:, :2].copy()
    track = control.prediction(hand, np.array([0.0, 0.02, 2.0]))
    for step in range(100):
        hand = hand + 0.02 * control.pointMassLaw(hand)
        if step == 0:
            np.testing.assert_allclose(track[1], hand, atol=1e-12)
    np.testing.assert_allclose(track[2], hand, atol=1e-12)


# Rendezvous


def test_rendezvous_typed_out():
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    pairs = laws.pairs_within(points, 2.1)
    np.testing.assert_array_equal(pairs, [[0, 1], [1, 2]])
    # D = 4: w(2) = 6/4, w(1) = 7/9.
    velocity = laws.rendezvous_flow(1.0, pairs, 4.0).velocity(points)
    np.testing.assert_allclose(velocity, [[3.0, 0.0], [-3.0, 7.0 / 9.0], [0.0, -7.0 / 9.0]])


def random_edges():
    points = np.random.default_rng(5).uniform(-2.0, 2.0, (6, 2))
    return points, laws.pairs_within(points, 3.0)


def test_rendezvous_is_minus_the_gradient_of_the_tension():
    points, pairs = random_edges()
    step = 1e-6 * np.eye(12).reshape(12, 6, 2)
    up, down = (tension_energy(pairs, 3.5, 1.0).values(points + s * step) for s in (1, -1))
    gradient = ((up - down) / 2e-6).reshape(6, 2)
    np.testing.assert_allclose(
        laws.rendezvous_flow(1.0, pairs, 3.5).velocity(points), -gradient, atol=1e-5
    )


def test_the_curvature_of_the_tension():
    points, pairs = random_edges()
    step = 1e-6 * np.eye(12).reshape(12, 6, 2)
    velocity = laws.rendezvous_flow(1.0, pairs, 3.5).velocity
    rows = [velocity(points - s) - velocity(points + s) for s in step]
    hessian = np.array(rows).reshape(12, 12) / 2e-6
    largest = np.linalg.eigvalsh(0.5 * (hessian + hessian.T))[-1]
    assert laws.tension_curvature(points, pairs, 3.5) == pytest.approx(largest, rel=1e-6)


def test_rendezvous_keeps_an_edge_that_plain_consensus_breaks():
    # A robot between two groups: the plain mean of four pulls it out of reach of the one.
    points = np.array([[-2.9, 0.0], [0.0, 0.0], [2.9, 0.2], [2.9, 0.0], [2.9, -0.2], [2.8, 0.1]])
    pairs = laws.pairs_within(points, 3.0)
    longest = {}
    for name, radius, step in (("kept", 3.0, 2e-5), ("plain", 1e6, 10.0)):
        hand, longest[name] = points, 0.0
        for _ in range(4000):
            hand = hand + step * laws.rendezvous_flow(1.0, pairs, radius).velocity(hand) * (
                radius / 2.0
            )
            longest[name] = max(longest[name], laws.edge_lengths(hand, pairs).max())
    assert longest["kept"] < 3.0 < longest["plain"]


class PlainConsensus(Rendezvous):
    def pointMassLaw(self, hand):
        super().pointMassLaw(hand)  # finds the pairs
        return self.gain * laws.rendezvous_flow(1.0, self._pairs, 1e3).velocity(hand) * 1e3


class Repels(Rendezvous):
    def pointMassLaw(self, hand):
        return -0.1 * super().pointMassLaw(hand)


@pytest.mark.parametrize("law", [PlainConsensus, Repels])
def test_another_law_than_rendezvous_fails(tmp_path, law):
    assert failed(verdict_of(shipped("rendezvous", duration=4.0), tmp_path, law))


def test_rendezvous_with_too_large_a_step_fails(tmp_path):
    verdict = verdict_of(shipped("rendezvous", {"gain": 2.0}, duration=0.1), tmp_path)
    assert verdict["outcome"] == "not_judged" and "curvature of the tension" in verdict["reason"]


def test_two_groups_do_not_meet(tmp_path):
    verdict = verdict_of(shipped("rendezvous", {"radius": 3.05}, duration=0.1), tmp_path)
    assert "connected at the start" in failed(verdict)


def test_a_new_start_looks_for_its_edges_again():
    control = Rendezvous(range(1, 4), parameters={"radius": 2.0})
    near = np.array([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [3.0, 0.0, 0.0]])
    control.commands(near, 0.0)
    assert len(control.topology.edges) == 2
    control.commands(near * 0.5, 0.1)
    assert len(control.topology.edges) == 2
    control.start()
    control.commands(near * 0.5, 0.0)
    assert len(control.topology.edges) == 3


# Cyclic pursuit


def test_cyclic_pursuit_typed_out():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    ahead = [[1.0, 0.0], [0.0, 2.0], [-1.0, -2.0]]
    np.testing.assert_allclose(laws.cyclic_pursuit(points, 0.0), ahead)
    left = [[0.0, 1.0], [-2.0, 0.0], [2.0, -1.0]]
    np.testing.assert_allclose(laws.cyclic_pursuit(points, np.pi / 2), left, atol=1e-12)


@pytest.mark.parametrize("n", [2, 5, 6])
def test_the_modes_of_cyclic_pursuit(n):
    angle = 0.3
    matrix = np.exp(1j * angle) * (np.roll(np.eye(n), 1, axis=1) - np.eye(n))
    values = laws.pursuit_eigenvalues(n, angle)
    np.testing.assert_allclose(
        np.sort_complex(np.round(np.linalg.eigvals(matrix), 9)),
        np.sort_complex(np.round(values, 9)),
        atol=1e-8,
    )
    slowest = -2.0 * np.sin(np.pi / n) * np.sin(np.pi / n - angle)
    assert values[1:].real.max() == pytest.approx(slowest)
    points = np.random.default_rng(1).normal(size=(n, 2))
    modes = laws.pursuit_modes(points)
    np.testing.assert_allclose(laws.points_of_modes(modes), points, atol=1e-12)
    velocity = laws.points_of_modes(modes * values)
    np.testing.assert_allclose(velocity, laws.cyclic_pursuit(points, angle), atol=1e-12)


@pytest.mark.parametrize("share, sign", [(0.95, -1), (1.0, 0), (1.05, 1)])
def test_the_threshold_is_at_pi_over_n(tmp_path, share, sign):
    scenario = shipped("cyclic_pursuit", {"angle": share * np.pi / 6.0}, duration=35.0)
    verdict = verdict_of(scenario, tmp_path)
    assert not failed(verdict)
    growth = check(verdict, "growth")
    assert (abs(growth["measured"]) < 2e-4) if sign == 0 else sign * growth["measured"] > 2e-3


def far_beyond(duration):
    """Return points at twice the angle of a circle, which 78 s drive a thousand kilometres apart."""
    control = {"protocol": "cyclic_pursuit", "rate": 10, "saturation": "none"}
    control["parameters"] = {"gain": 0.35, "angle": np.pi / 3.0}
    keys = {"fidelity": "point_mass", "limits": "none", "record_rate": 10, "step": 0.1}
    return shipped("cyclic_pursuit")._replace(duration=duration).changed(control=control, **keys)


def test_a_team_that_theory_drives_apart_ends_as_the_theorem_says(tmp_path):
    verdict = verdict_of(far_beyond(100.0), tmp_path)
    assert verdict["ended"].endswith("the team is driven apart")
    ended = check(verdict, "ended")
    assert ended["passed"] is None and ended["note"] == "theory leads it there"
    assert verdict["outcome"] == "passed" and check(verdict, "growth")["measured"] > 0.1


class PursuesInwardsAsPredicted(CyclicPursuit):
    def prediction(self, start, time):
        return 0.0 * super().prediction(start, time)


class PredictsNothing(CyclicPursuit):
    prediction = PioneerControl.prediction


@pytest.mark.parametrize("law", [PursuesInwardsAsPredicted, PredictsNothing])
def test_a_team_that_is_driven_apart_against_theory_fails(tmp_path, law):
    assert "ended" in failed(verdict_of(far_beyond(100.0), tmp_path, law))


class PursuesAtAnotherAngle(CyclicPursuit):
    def pointMassLaw(self, hand):
        return self.gain * laws.cyclic_pursuit(hand, self.angle + 0.1)


class PursuesTheOneBehind(CyclicPursuit):
    def pointMassLaw(self, hand):
        return -super().pointMassLaw(hand)


@pytest.mark.parametrize("law", [PursuesAtAnotherAngle, PursuesTheOneBehind])
def test_another_pursuit_fails(tmp_path, law):
    scenario = shipped("cyclic_pursuit_inwards", rate=10, duration=30.0)
    assert "growth rate of the slowest mode [1/s]" in failed(verdict_of(scenario, tmp_path, law))


# Coverage


def test_coverage_typed_out():
    samples = np.array([[-3.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [3.0, 2.0]])
    density = np.array([1.0, 1.0, 1.0, 3.0])
    points = np.array([[-2.0, 1.0], [2.0, 0.0], [50.0, 0.0]])
    centroids = laws.cell_centroids(points, samples, density)
    np.testing.assert_allclose(centroids, [[-2.0, 0.0], [2.5, 1.5], [50.0, 0.0]])
    velocity = laws.coverage(points, samples, density)
    np.testing.assert_allclose(velocity, [[0.0, -1.0], [0.5, 1.5], [0.0, 0.0]])
    cost = (2.0 + 2.0 + 1.0 + 3.0 * 5.0) / 6.0
    assert coverage_energy(samples, density, 1.0).value(points) == pytest.approx(cost)


def test_the_samples_fill_the_square():
    samples = laws.square_samples(4.0, 2)
    np.testing.assert_allclose(samples, [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
    density = laws.gaussian_density(samples, (1.0, 1.0), 2.0)
    np.testing.assert_allclose(density, np.exp([-1.0, -0.5, -0.5, 0.0]))


def test_four_robots_end_in_the_middles_of_the_quarters(tmp_path):
    poses = [[-4.0, -4.0, 0.0], [-2.0, -4.0, 0.0], [-4.0, -2.0, 0.0], [-2.0, -2.0, 0.0]]
    scenario = shipped("coverage", {"side": 8.0}, rate=10, poses=poses, robots=4, duration=30.0)
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["passed"]
    # The mean of |q - C|^2 over a square of side a is a^2/6.
    assert verdict["cost_at_end"] == pytest.approx(4.0**2 / 6.0, rel=0.01)
    assert verdict["cost_at_start"] > 5.0 * verdict["cost_at_end"]


def test_a_gaussian_density_draws_the_robots():
    gaussian = {"density": "gaussian", "centre_x": 3.0, "centre_y": 2.0, "width": 1.5}
    control = Coverage(range(1, 10), parameters=gaussian)
    hand = shipped("coverage").poses[:, :2]
    costs = [control.cost(hand[np.newaxis])[0]]
    for _ in range(100):
        hand = hand + 0.3 * control.pointMassLaw(hand)
        costs.append(control.cost(hand[np.newaxis])[0])
    assert np.diff(costs).max() <= 1e-12
    np.testing.assert_allclose(hand.mean(axis=0), [3.0, 2.0], atol=1.0)
    assert np.linalg.norm(hand - [3.0, 2.0], axis=1).max() < 5.0


def test_a_density_out_of_reach_is_refused():
    with pytest.raises(ValueError, match="within 5 widths"):
        Coverage([1], parameters={"density": "gaussian", "centre_x": 100.0})


class FleesItsCentroid(Coverage):
    def pointMassLaw(self, hand):
        return -0.1 * super().pointMassLaw(hand)


def test_coverage_with_the_wrong_sign_fails(tmp_path):
    verdict = verdict_of(shipped("coverage", rate=10, duration=3.0), tmp_path, FleesItsCentroid)
    assert "commands off the published law [-]" in failed(verdict)


def test_coverage_with_too_high_a_gain_fails(tmp_path):
    verdict = verdict_of(shipped("coverage", {"gain": 41.0}, duration=0.1), tmp_path)
    assert verdict["outcome"] == "not_judged" and "gain Tc < 2 does not" in verdict["reason"]
