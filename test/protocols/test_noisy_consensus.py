"""Consensus under noise: typed-out variances, exact covariances, and runs with each kind of noise."""

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols.consensus.noise_equations import (
    mean_variance_rate,
    mode_variances,
    modes,
    sampling_error,
)

QUIET = {"velocity_noise": 0.0, "robot_noise": 0.0, "listener_noise": 0.0}
SOON = {"gain": 2.0}, 110.0  # twice the gain that ships, half the time [s] that a variance needs
STEADY = "steady variance"


def test_variances_typed_out():
    two = Topology.preset("path", 2)  # lambda_2 = 2
    # Velocities, sigma = 0.2: 0.04/(2 * 0.5 * 2 (1 - 0.5 * 2 * 0.1/2)) = 0.04/1.9.
    assert mode_variances(two, 0.5, 0.1, velocity=0.2) == pytest.approx([0.04 / 1.9])
    # Positions, r = 0.2, a = 0.1: 0.04 * 0.1/1.9; both robots feel both noises.
    assert mode_variances(two, 0.5, 0.1, robot=0.2) == pytest.approx([0.004 / 1.9])
    # Relative positions: each robot one of its own, Q = 1: 0.04 * 0.05/(2 (2 - 0.1)), half of that.
    assert mode_variances(two, 0.5, 0.1, listener=0.2) == pytest.approx([0.002 / 3.8])
    assert np.isinf(mode_variances(two, 10.0, 0.1, velocity=0.2)).all()


@pytest.mark.parametrize("kind", ["velocity", "robot", "listener"])
@pytest.mark.parametrize("name", ["star", "lattice"])
def test_variances_are_those_of_the_whole_covariance(kind, name):
    """P = A P A^T + noise, solved without modes, weights other than 1."""
    edges = [(i, j, 0.5 + 0.25 * (i + j)) for i, j, _ in Topology.preset(name, 5).edges]
    graph, gain, period, size = Topology(5, edges, directed=False), 0.3, 0.2, 0.7
    laplacian = graph.laplacian()
    entering = {
        "velocity": size**2 * period * np.eye(5),
        "robot": (gain * period * size) ** 2 * laplacian @ laplacian.T,
        "listener": (gain * period * size) ** 2 * np.diag((graph.adjacency() ** 2).sum(axis=1)),
    }[kind]
    step, away = np.eye(5) - gain * period * laplacian, np.eye(5) - 0.2
    covariance = np.zeros((5, 5))
    for _ in range(4000):
        covariance = away @ (step @ covariance @ step.T + entering) @ away
    found = mode_variances(graph, gain, period, **{kind: size})
    assert found.sum() == pytest.approx(np.trace(covariance), rel=1e-9)


def test_only_noise_of_robots_leaves_the_mean_alone():
    ring = Topology.preset("ring", 4)
    assert mean_variance_rate(ring, 0.5, velocity=0.2) == pytest.approx(0.01)
    # 0.25 * 0.1 * 0.04 * 8 arcs / 16.
    assert mean_variance_rate(ring, 0.5, listener=0.2, period=0.1) == pytest.approx(0.0005)


def test_the_error_of_a_measured_variance():
    draw, kept = np.random.default_rng(0), 0.9
    x = np.zeros((400, 2000))
    push = draw.standard_normal(x.shape) * np.sqrt(1.0 - kept**2)
    for k in range(1, x.shape[1]):
        x[:, k] = kept * x[:, k - 1] + push[:, k]
    spread = (x[:, 200:] ** 2).mean(axis=1).std()
    assert sampling_error(np.array([1.0]), np.array([kept]), 1800) == pytest.approx(spread, rel=0.1)
    assert len(modes(Topology.preset("ring", 4))[0]) == 3


@pytest.mark.parametrize(
    "noise", [{"velocity_noise": 0.1}, {"robot_noise": 0.1}, {"listener_noise": 0.1}]
)
def test_each_noise_has_its_gain_and_no_other(noise, tmp_path):
    scenario = shipped("noisy_consensus", {**QUIET, **SOON[0], **noise}, duration=SOON[1])
    verdict = verdict_of(scenario, tmp_path)
    assert verdict["passed"], verdict["checks"]
    steady = check(verdict, STEADY)
    assert steady["tolerance"] < 0.25 * steady["predicted"]
    if "robot_noise" in noise:
        assert check(verdict, "drift of the mean [m]")["measured"] < 1e-9


def test_noise_of_half_the_variance_more_is_noticed(tmp_path):
    from mrs_simulator.protocols.consensus.noisy import NoisyConsensus

    class Louder(NoisyConsensus):
        def law(self, hand):
            return super().law(hand) + 0.1 * np.random.default_rng(
                int(50 * self.time)
            ).standard_normal(hand.shape) / np.sqrt(2.0 * self.period)

    scenario = shipped("noisy_consensus", SOON[0], duration=SOON[1])
    verdict = verdict_of(scenario, tmp_path, Louder)
    assert check(verdict, STEADY)["passed"] is False


def test_a_short_run_is_not_judged(tmp_path):
    verdict = verdict_of(shipped("noisy_consensus", duration=5.0), tmp_path)
    steady = check(verdict, STEADY)
    assert steady["passed"] is None and "too short for a variance: wanted 196 s" in steady["note"]
