"""Claims measured in large teams: memory grows with the run, not with its pairs of robots."""

import numpy as np
import pytest
from memory import peak_of

from mrs_simulator.core.claims import (
    Claim,
    Condition,
    centroid,
    converges_to,
    disagreement,
    distance_to,
    extent,
    invariant,
    listed,
    rate,
)
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import shipped
from mrs_simulator.protocols.common import all_hold
from mrs_simulator.protocols.consensus.over_links import Linear, linear_claims
from mrs_simulator.protocols.energies import laplacian_energy
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.network.links import Links, PerEdge, Switching

ROBOTS, SAMPLES = 30, 600


@pytest.mark.parametrize(
    "protocol, parameters",
    [
        ("displacement_formation", {"shape": "grid"}),
        ("distance_formation", {"shape": "grid", "gain": 1e-4}),
        ("bearing_formation", {"shape": "grid"}),
        ("marching", {"shape": "grid"}),
        ("rendezvous", {"radius": 40.0}),
    ],
)
def test_on_complete_graphs_claims_hold_no_pairs_of_all_samples(protocol, parameters):
    control = shipped(protocol)(
        range(1, ROBOTS + 1), Topology.preset("complete", ROBOTS), parameters=parameters
    )
    time = 0.1 * np.arange(SAMPLES)
    start = np.random.default_rng(0).uniform(-5.0, 5.0, (ROBOTS, 2))
    hand = start * np.exp(-0.05 * time)[:, np.newaxis, np.newaxis]
    run = Run(time, np.arange(1, ROBOTS + 1), None, hand, None)
    claims = [claim for claim in control.claims(start) if isinstance(claim, Claim)]
    assert claims, control.claims(start)
    pairs = ROBOTS * (ROBOTS - 1) // 2
    for claim in claims:
        # One number for each pair of robots in each sample is too much.
        assert peak_of(lambda c=claim: c.measure(run)) < 8 * SAMPLES * pairs, claim.name


def test_the_maps_of_many_turns_are_not_held_at_once():
    n, depth = 12, 11
    complete = Topology.preset("complete", n)
    turns = len(complete.edges)
    links = Links(delay=PerEdge(0.2), switching=Switching(sets=turns, dwell=0.02))
    start = np.random.default_rng(0).uniform(-5.0, 5.0, (n, 2))
    law = Linear(complete, 1.0, np.zeros((n, 2)), 0.02, links, 0.02, 0.05)

    def predicted():
        assert all_hold(
            claim for claim in linear_claims(law, start) if isinstance(claim, Condition)
        )
        law.track(start, np.array([0.0, 1.0]))

    assert peak_of(predicted) < turns * 8 * (n * depth) ** 2 / 4


TWO = np.array([[[0.0, 0.0, 0.0], [2.0, 3.0, 6.0]]])  # 7 m apart in space


def test_quantities_in_space_typed_out():
    assert disagreement(TWO) == pytest.approx([7.0 / np.sqrt(2.0)])
    assert extent(TWO) == pytest.approx([6.0])
    np.testing.assert_allclose(centroid(TWO), [[1.0, 1.5, 3.0]])
    assert distance_to([0.0, 0.0, 0.0])(TWO) == pytest.approx([7.0])


def test_two_points_in_space_agree_as_in_closed_form():
    """``p_1 - p_2`` falls like ``exp(-2 k t)``, ``V = |p_1 - p_2|^2/2`` at ``2 k |p_1 - p_2|^2``."""
    time, middle = 0.05 * np.arange(300.0), TWO.mean(axis=1, keepdims=True)
    hand = middle + np.exp(-time)[:, np.newaxis, np.newaxis] * (TWO - middle)
    run = Run(time, np.array([1, 2]), None, hand, None)
    assert rate(1.0, disagreement).measure(run) == pytest.approx(1.0, rel=1e-9)
    assert invariant(centroid).measure(run) < 1e-12
    assert converges_to(middle[0, 0]).measure(run) == pytest.approx(3.5 * np.exp(-time[-1]))
    energy = laplacian_energy(Topology(2, [(1, 2)], directed=False), 0.5)
    assert energy.of(TWO[0], None, 0.0) == pytest.approx(24.5)
    assert energy.spent(TWO[0], None, 0.0) == pytest.approx(49.0)


def test_rates_the_wrong_way_round_and_single_claims():
    with pytest.raises(TypeError, match="wanted a number .1/s., and then a function"):
        rate(lambda hand: hand[:, 0, 0], 0.5)
    with pytest.raises(TypeError, match="1, wanted points .n, d. or one point .d,."):
        converges_to(1.0)
    alone = converges_to([0.0, 0.0])
    assert listed(alone) == [alone] and listed((alone, alone)) == [alone, alone]
