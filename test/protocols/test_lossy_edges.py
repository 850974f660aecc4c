"""Lossy edges: the second moment against all cases written out, and against many seeds."""

import itertools

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.protocols.consensus.mean_square import (
    confidence,
    mean_square_rate,
    mean_squares,
    second_moment_step,
)
from mrs_simulator.scenario.network.links import Links, PerEdge
from mrs_simulator.study.analyses.lossy_edges import (
    LossyError,
    agrees,
    deviations,
    lossy_figure,
    lossy_study,
    main,
)


def test_two_robots_typed_out():
    pair = Topology.preset("path", 2)
    # Lost together: the difference is multiplied by 1 - 2 * 0.25 = 0.5, or, one in five, kept.
    assert mean_square_rate(pair, 0.25, 0.2, symmetric=True) == pytest.approx(0.8 * 0.25 + 0.2)
    # Each by itself: by 0.5, 0.75, 0.75 or 1.
    each = 0.64 * 0.25 + 0.32 * 0.5625 + 0.04
    assert mean_square_rate(pair, 0.25, 0.2) == pytest.approx(each)
    start = np.array([[0.0, 0.0], [2.0, 0.0]])
    np.testing.assert_allclose(
        mean_squares(start, pair, 0.25, 0.2, 3), [2.0, 2.0 * each, 2.0 * each**2]
    )


@pytest.mark.parametrize("symmetric", [True, False])
def test_the_second_moment_is_the_mean_over_all_cases(symmetric):
    graph = Topology(3, [(1, 2, 0.5), (2, 3, 1.5)], directed=False)
    draw = np.random.default_rng(0).standard_normal((3, 3))
    moment, share = draw @ draw.T, 0.2
    loss = np.array([[0.0, 0.1, 0.0], [0.1, 0.0, 0.4], [0.0, 0.4, 0.0]])
    arcs = [(0, 1), (1, 0), (1, 2), (2, 1)]
    groups = [arcs[:2], arcs[2:]] if symmetric else [[arc] for arc in arcs]
    expected = np.zeros((3, 3))
    for case in itertools.product((0, 1), repeat=len(groups)):
        chance, adjacency = 1.0, np.zeros((3, 3))
        for up, group in zip(case, groups):
            lost = loss[group[0]]
            chance *= 1.0 - lost if up else lost
            for arc in group if up else ():
                adjacency[arc] = graph.adjacency()[arc]
        step = np.eye(3) - share * (np.diag(adjacency.sum(axis=1)) - adjacency)
        expected += chance * step @ moment @ step.T
    found = second_moment_step(moment, graph, share, loss, symmetric)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def lossy(loss=0.4, symmetric=False, **changes):
    links = Links(loss=PerEdge(loss), on_loss="drop", symmetric=symmetric)
    scenario = shipped("consensus", {"gain": 1.0}, rate=5, duration=2.0, **changes)
    scenario = scenario._replace(fidelity="point_mass", limits=None, step=0.2)
    return scenario._replace(topology=Topology.preset("ring", scenario.n), links=links)


@pytest.mark.parametrize("symmetric", [pytest.param(True, marks=pytest.mark.release), False])
def test_eighty_seeds_have_the_expected_mean_square(symmetric):
    scenario = lossy(symmetric=symmetric)
    study = lossy_study(scenario, 80)
    assert agrees(study), study["off"]
    assert study["typical"] < study["rate"] < 1.0  # one run decays faster than the mean of squares
    # Theory that is told of less loss does not agree.
    start = hand_points(scenario.poses, scenario.hand_length)
    wrong = mean_squares(start, scenario.topology, 0.2, 0.3, len(study["time"]), symmetric)
    off = deviations(study["mean"], study["half"], wrong)[1:].max()
    assert not agrees({"off": off})


def test_the_interval_typed_out():
    mean, half = confidence(np.array([[1.0], [2.0], [3.0], [4.0]]))
    assert mean == pytest.approx([2.5]) and half == pytest.approx([1.96 * 1.2909944 / 2.0])


def test_scenarios_of_which_nothing_is_known_are_refused():
    for changed, said in (
        (lossy()._replace(links=Links()), "on_loss: drop"),
        (lossy()._replace(fidelity="kinematic"), "fidelity: point_mass"),
        (shipped("rendezvous"), "control.protocol: consensus"),
    ):
        with pytest.raises(LossyError, match=said):
            lossy_study(changed, 2)


def test_the_figure_names_its_curves():
    axes = lossy_figure(lossy_study(lossy(), 3)).axes[0]
    names = {text.get_text() for text in axes.get_legend().get_texts()}
    assert names == {"one run", "its 95 % interval", "mean of all runs", "Theory"}


def test_the_shipped_scenario_by_the_command(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["consensus_drops.yaml", "--out", str(tmp_path), "--seeds", "4"])
    assert ended.value.code == 0 and "PASSED" in capsys.readouterr().out
    assert (tmp_path / "mean_square.png").exists()
