"""The paper's law agrees with its closed forms."""

import tracemalloc
from math import comb

import numpy as np
import pytest

from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import shipped
from mrs_simulator.protocols.formation import equations as formation
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import played
from mrs_simulator.verdict.judging import judged

K, C = 0.02, 2.0
PRINTED = np.array([[10.0, -5.0], [5.0, -2.0], [2.0, 8.0], [-5.0, 12.3]])
SEVEN = np.vstack([PRINTED, [[-1.0, 6.0], [0.0, -5.0], [-10.0, 4.0]]])


def law(closure, hand):
    return formation.line_offsets(len(hand), C), formation.closure_topology(closure, len(hand))


@pytest.mark.parametrize(
    "closure, alpha_1, final_y, steps",
    [
        ("chain", (1.0, 12.3), 12.3, (287, 348, 393)),
        ("cycle", (6.0, 3.325), 3.325, (126, 178, 210)),
        ("path", (6.0 + 1.0 / 6.0, 3.0 + 1.3 / 6.0), 3.0 + 1.3 / 6.0, (268, 359, 428)),
    ],
)
def test_printed_robots_end_and_settle_as_typed_out(closure, alpha_1, final_y, steps):
    offsets, topology = law(closure, PRINTED)
    final = formation.limit(PRINTED, offsets, topology)
    np.testing.assert_allclose(final[0], alpha_1, atol=1e-9)
    np.testing.assert_allclose(final[:, 1], final_y, atol=1e-9)
    np.testing.assert_allclose(formation.line_gaps(final), C, atol=1e-9)
    found = [
        formation.predicted_settling(PRINTED, offsets, topology, K, share)
        for share in (0.05, 0.02, 0.01)
    ]
    assert tuple(found) == steps


def test_a_verdict_predicts_once_when_robots_settle(monkeypatch):
    predict, asked = formation.predicted_settling, []
    monkeypatch.setattr(
        formation, "predicted_settling", lambda *of: asked.append(of) or predict(*of)
    )
    content = {"poses": [[6, 1, 0], [3, 0, 0], [0, -1, 0]], "duration": 1}
    run, control = played(scenario_from_dict(dict(content, control={"protocol": "formation"})))
    judged(run, control)
    assert len(asked) == 1
    start = asked[0][0]

    def claimed(start):
        (claim,) = [each for each in control.claims(start) if each.name == "settling time [s]"]
        return claim.predicted

    first, other = claimed(start), start + [[0.0, 0.0], [0.0, 5.0], [0.0, 0.0]]
    assert len(asked) == 1 and claimed(other) != first and len(asked) == 2
    slower = claimed(other)
    control.set_parameters(dict(control.parameters, k=2.0 * control.k))
    assert claimed(other) < slower and len(asked) == 3


def test_chain_follows_the_binomial_law():
    offsets, topology = law("chain", SEVEN)
    track = formation.predict(SEVEN, offsets, topology, K, 300)
    start = formation.target_errors(SEVEN, offsets, topology)
    for t in (0, 1, 17, 300):
        for i in range(6):
            binomial = sum(
                comb(t, j) * K**j * (1.0 - K) ** (t - j) * start[i + j] for j in range(6 - i)
            )
            error = formation.target_errors(track[t], offsets, topology)[i]
            np.testing.assert_allclose(error, binomial, atol=1e-12)


def test_cycle_keeps_the_centroid_and_contracts_at_its_rate():
    offsets, topology = law("cycle", SEVEN)
    track = formation.predict(SEVEN, offsets, topology, K, 3000)
    np.testing.assert_allclose(track[-1].mean(axis=0), SEVEN.mean(axis=0), atol=1e-9)
    errors = [formation.error_norm(hand, offsets, topology) for hand in track[2000:]]
    rate = (errors[-1] / errors[0]) ** (1.0 / (len(errors) - 1))
    expected = np.sqrt(1.0 - 2.0 * K * (1.0 - K) * (1.0 - np.cos(2.0 * np.pi / 7.0)))
    assert rate == pytest.approx(expected, rel=1e-4)


def test_path_keeps_its_weighted_mean_and_contracts_at_its_rate():
    offsets, topology = law("path", SEVEN)
    weights = np.array([1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0]) / 12.0
    track = formation.predict(SEVEN, offsets, topology, K, 3000)
    np.testing.assert_allclose(weights @ (track[-1] - SEVEN), 0.0, atol=1e-9)
    errors = [formation.error_norm(hand, offsets, topology) for hand in track[2000:]]
    rate = (errors[-1] / errors[0]) ** (1.0 / (len(errors) - 1))
    assert rate == pytest.approx(1.0 - K * (1.0 - np.cos(np.pi / 6.0)), rel=1e-5)


@pytest.mark.parametrize(
    "topology",
    [
        Topology.preset("star", 4),
        Topology(4, [(1, 2), (2, 3, 0.5), (2, 1), (3, 1, 2.0), (4, 3)]),
        Topology(4, [(1, 2), (1, 3), (2, 3), (3, 4, 3.0)]),
        Topology(4, []),
    ],
    ids=["star", "directed", "one that receives from none", "no edges"],
)
def test_the_limit_is_where_the_steps_lead(topology):
    offsets = formation.line_offsets(4, C)
    track = formation.predict(PRINTED, offsets, topology, 0.5, 2000)
    final = formation.limit(PRINTED, offsets, topology)
    np.testing.assert_allclose(final, track[-1], atol=1e-9)


@pytest.mark.parametrize("closure", ["chain", "cycle", "path"])
def test_the_prediction_for_many_robots_needs_no_square_matrix(closure):
    n = 4000
    hand = np.random.default_rng(0).uniform(-100.0, 100.0, (n, 2))
    offsets, topology = law(closure, hand)
    tracemalloc.start()
    try:
        final = formation.limit(hand, offsets, topology)
        steps = formation.predicted_settling(hand, offsets, topology, K, 0.9)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8 * n * n / 10  # one matrix of n by n holds 8 n^2 bytes
    assert steps > 0
    np.testing.assert_allclose(formation.error_norm(final, offsets, topology), 0.0, atol=1e-8)


def test_target_of_the_chain_is_the_next_robot_plus_c():
    offsets, topology = law("chain", PRINTED)
    errors = formation.target_errors(PRINTED, offsets, topology)
    expected = [[3.0, -3.0], [1.0, -10.0], [5.0, -4.3], [0.0, 0.0]]
    np.testing.assert_allclose(errors, expected, atol=1e-12)
    u = formation.formation_flow(offsets, topology, K, 0.1).velocity(PRINTED)
    np.testing.assert_allclose(u, -0.2 * np.array(expected), atol=1e-12)


def test_a_topology_of_ones_own_replaces_the_closure():
    star = Topology.preset("star", 4)
    assert formation.closure_topology("topology", 4, star) is star
    with pytest.raises(ValueError, match="no topology"):
        formation.closure_topology("topology", 4, None)


def test_longest_safe_period():
    # l/(kappa e_max) = 0.05/(0.2 * 10) = 0.025 s
    assert formation.largest_stable_period(0.02, 0.1, 0.05, 10.0, np.inf) == pytest.approx(0.025)
    assert formation.largest_stable_period(0.02, 0.1, 0.05, 10.0, 2.0) == pytest.approx(0.5)


def test_one_robot_has_nothing_to_do():
    hand = np.array([[1.0, 2.0]])
    offsets, topology = law("cycle", hand)
    np.testing.assert_array_equal(formation.target_errors(hand, offsets, topology), [[0.0, 0.0]])
    np.testing.assert_array_equal(formation.limit(hand, offsets, topology), hand)


@pytest.mark.parametrize("closure", ["chain", "cycle", "path"])
def test_the_sampling_rule_is_a_condition(closure):
    """With commands at each T it is k < 1 or wider; held five times as long, k = 0.5 is too much."""
    start = np.array([[6.0, 1.0], [3.0, 0.0], [0.0, -1.0], [-3.0, 0.5]])
    for period, holds in ((0.1, True), (0.5, False)):
        parameters = {"k": 0.5, "T": 0.1, "closure": closure}
        control = shipped("formation")(range(1, 5), parameters=parameters, period=period)
        found = control.claims(start)[0]
        assert found.name == "(k/T) Tc < 2/lambda_max" and found.holds is holds, found


@pytest.mark.parametrize("closure", ["chain", "cycle", "path"])
@pytest.mark.parametrize("steps", [range(0, 400, 5), [9, 3, 3, 6], [4], [7, 0, 3, 3, 40]])
def test_all_steps_at_once_are_those_one_after_the_other(closure, steps, monkeypatch):
    given = SEVEN, *law(closure, SEVEN), 0.3
    with monkeypatch.context() as patched:
        if len(np.unique(np.diff(np.unique(steps)))) <= 1:
            patched.setattr(formation, "target_errors", None)
        found = formation.predicted_after(steps, *given)
    monkeypatch.setattr(formation, "FEW", 0)
    expected = formation.predicted_after(steps, *given)
    assert found.shape == expected.shape == (len(steps), 7, 2)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_grows_beyond_all_numbers_is_followed_as_far_as_there_are_any():
    """The powers of a matrix overflow before a start near its target does."""
    offsets, topology = law("chain", SEVEN)
    near = offsets + 1e-300 * SEVEN
    track = formation.predict(near - offsets, 0.0 * offsets, topology, 10.0, 600)
    assert np.isfinite(track).all() and np.abs(track[-1]).max() > 1e100


def test_nothing_is_predicted_of_no_samples():
    given = np.zeros((3, 2)), np.zeros((3, 2)), formation.closure_topology("chain", 3), 0.02
    assert formation.predicted_after(np.array([], dtype=int), *given).shape == (0, 3, 2)
