"""Noise gain: measured variances beside theory's, over the level of each noise and over the gain."""

import csv

import numpy as np
import pytest
from protocol_fixtures import shipped

from mrs_simulator.core.graphs import Topology
from mrs_simulator.study.analyses import noise_gain
from mrs_simulator.study.analyses.noise_gain import (
    NoiseError,
    Point,
    noise_figure,
    noise_gain_study,
)

# Six runs.
SMALL = {"seeds": 1, "levels": (1.0,), "gains": (0.75,)}


@pytest.fixture(scope="module")
def points():
    return noise_gain_study(shipped("noisy_consensus", {"gain": 2.0}), **SMALL)


def test_each_kind_has_the_variance_of_theory(points):
    assert [(p.kind, p.swept) for p in points] == [
        (kind, swept) for kind in ("velocity", "robot", "listener") for swept in ("level", "gain")
    ]
    # Ring of 6, lambda_max = 4, Tc = 0.1: the largest gain is 5.
    assert {round(p.gain, 9) for p in points} == {2.0, 3.75}
    for point in points:
        assert point.agrees and point.error < 0.1 * point.predicted, point
    names = [axes.get_xlabel() for axes in noise_figure(shipped("noisy_consensus"), points).axes]
    assert names[1:3] == ["robot noise [m]", "listener noise [m]"]


def test_another_kind_or_level_would_not_agree(points):
    robot, listener = (next(p for p in points if p.kind == kind) for kind in ("robot", "listener"))
    assert not robot._replace(predicted=listener.predicted).agrees
    assert not robot._replace(predicted=1.3 * robot.predicted).agrees


def test_what_is_not_known_is_refused():
    scenario = shipped("noisy_consensus")
    directed = scenario._replace(topology=Topology.preset("cycle", scenario.n))
    for changed, said in (
        (shipped("consensus"), "control.protocol: noisy_consensus"),
        (scenario._replace(fidelity="kinematic"), "fidelity: point_mass"),
        (directed, "undirected"),
    ):
        with pytest.raises(NoiseError, match=said):
            noise_gain_study(changed)


def test_the_command_tells_who_is_off(tmp_path, capsys, monkeypatch):
    right = Point("robot", "level", 0.1, 1.0, 0.007, 0.0071, 1e-4)
    wrong = Point("listener", "gain", 0.1, 2.5, 0.02, 0.03, 1e-3)
    monkeypatch.setattr(noise_gain, "noise_gain_study", lambda scenario, seeds: [right, wrong])
    monkeypatch.setattr(noise_gain, "noise_figure", lambda scenario, points: small_figure())
    with pytest.raises(SystemExit) as ended:
        noise_gain.main(["noisy_consensus.yaml", "--out", str(tmp_path)])
    said = capsys.readouterr().out
    assert ended.value.code == 1 and said.startswith("FAILED: 1 of 2")
    assert "listener noise 0.1, gain 2.5: 0.03, theory 0.02" in said
    rows = list(csv.DictReader((tmp_path / "noise_gain.csv").open()))
    assert [row["agrees"] for row in rows] == ["True", "False"]
    assert np.isclose(float(rows[0]["measured"]), 0.0071)


def small_figure():
    from mrs_simulator.study.draw.canvas import new_figure

    return new_figure(2.0, 2.0)
