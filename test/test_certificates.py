"""Energies with typed-out values and slopes, their balance in runs, connectivity, and their figure."""

import os

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.control.laws import energies, gathering_equations
from mrs_simulator.control.laws import shipped as law_of
from mrs_simulator.control.making import make_control
from mrs_simulator.core.curves import Curve, Energy, energy_residual, integral
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.recording import Run
from mrs_simulator.study.certificate_figure import certificate_figure
from mrs_simulator.study.figures import save

BALANCE = "energy off its predicted change"
PATH = Topology.preset("path", 3)
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]])


def test_energies_typed_out():
    energy = energies.laplacian_energy(PATH, 0.5)
    # (1 + 4)/2; L p = (-1, -1, 2), squared 6, times 0.5.
    assert (energy.value(POINTS), energy.dissipation(POINTS)) == (2.5, 3.0)
    # The last one stands: (1 + 1)/2.
    assert energies.laplacian_energy(PATH, 0.5, standing=1).dissipation(POINTS) == 1.0
    tension = energies.tension_energy(np.array([[0, 1], [1, 2]]), 4.0, 0.2)
    # 1/3 + 4/2; slopes 7/9 and 12/4: pulls 0.7778, 2.2222, 3.
    assert tension.value(POINTS) == pytest.approx(7.0 / 3.0)
    assert tension.dissipation(POINTS) == pytest.approx(0.2 * (49.0 + 400.0 + 729.0) / 81.0)
    lengths = energies.length_energy(PATH, 2.0 * POINTS, 0.1)
    # (1 - 4)^2/4 + (4 - 16)^2/4; slopes -3 and -24: pulls 3, 21, 24.
    assert lengths.value(POINTS) == 38.25
    assert lengths.dissipation(POINTS) == pytest.approx(0.1 * (9.0 + 441.0 + 576.0))
    samples = np.array([[0.0, 0.0], [2.0, 0.0], [10.0, 0.0]])
    cost = energies.coverage_energy(samples, np.ones(3), 0.5)
    two = np.array([[0.5, 0.0], [9.0, 0.0]])
    # (0.25 + 2.25 + 1)/3; 2 * 0.5 (2/3 * 0.25 + 1/3 * 1).
    assert cost.value(two) == pytest.approx(3.5 / 3.0)
    assert cost.dissipation(two) == pytest.approx(0.5)


@pytest.mark.parametrize(
    "name", ["consensus", "displacement_formation", "distance_formation", "rendezvous", "coverage"]
)
def test_energies_fall_along_the_law_as_fast_as_they_say(name):
    scenario = shipped(name)
    if scenario.topology is not None:
        scenario = scenario._replace(topology=Topology(scenario.n, scenario.topology.edges, False))
    control = make_control(scenario)
    hand = hand_points(scenario.poses, control.l)
    energy = control.energy(hand)
    control.start()
    step = 1e-6 * control.pointMassLaw(hand)
    slope = (energy.value(hand + step) - energy.value(hand - step)) / 2e-6
    assert slope == pytest.approx(-energy.dissipation(hand), rel=2e-3)


def test_the_residual_of_a_decay_typed_out():
    time = np.arange(0.0, 5.0, 0.01)
    hand = np.exp(-0.5 * time)[:, np.newaxis, np.newaxis] * np.array([[[1.0, 0.0]]])
    run = Run(time, np.array([1]), None, hand, None)
    energy = Energy("V", lambda p: float((p**2).sum()), lambda p: float((p**2).sum()))
    residual, allowed = energy_residual(energy, run, 0.01)
    assert residual < 1e-4 and 0.009 < allowed < 0.011
    wrong = Energy("V", energy.value, lambda p: 1.1 * float((p**2).sum()))
    assert energy_residual(wrong, run, 0.01)[0] == pytest.approx(0.1, abs=0.01)
    np.testing.assert_allclose(
        integral(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0])), [0, 1, 7]
    )


def test_a_law_that_loses_a_tenth_is_off_its_balance(tmp_path):
    class Weak(law_of("consensus")):
        def pointMassLaw(self, hand):
            return 0.9 * super().pointMassLaw(hand)

    right = verdict_of(shipped("consensus", duration=10.0), tmp_path / "right")
    assert check(right, BALANCE)["passed"]
    wrong = verdict_of(shipped("consensus", duration=10.0), tmp_path / "wrong", Weak)
    found = check(wrong, BALANCE)
    assert found["passed"] is False and found["measured"] == pytest.approx(0.1, abs=0.02)


def test_a_graph_that_falls_apart_is_noticed(tmp_path):
    class Torn(law_of("rendezvous")):
        def pointMassLaw(self, hand):
            super().pointMassLaw(hand)
            return [[-2.0, 0.0]] * (np.arange(len(hand)) == np.argmin(hand[:, 0]))[:, np.newaxis]

    name = "least connectivity"
    whole = verdict_of(shipped("rendezvous", duration=3.0), tmp_path / "whole")
    assert check(whole, name)["passed"] and check(whole, name)["measured"] > 0.1
    torn = verdict_of(shipped("rendezvous", duration=3.0), tmp_path / "torn", Torn)
    assert check(torn, name)["passed"] is False and check(torn, name)["measured"] < 1e-9


def test_the_graph_of_rendezvous_loses_edges_that_are_too_long():
    control = law_of("rendezvous")(range(1, 4), parameters={"radius": 2.5})
    assert len(control.graph_at(POINTS, POINTS).edges) == 2
    apart = POINTS + [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]
    assert [edge[:2] for edge in control.graph_at(POINTS, apart).edges] == [(1, 2)]
    assert len(gathering_equations.pairs_within(POINTS, 2.5)) == 2


def test_the_figure_shows_measured_theory_and_bound(tmp_path):
    time = np.linspace(0.0, 1.0, 5)
    curves = [
        Curve("V [m]", time, 1.0 - time, 1.0 - time),
        Curve("peak [m]", [1, 2], [0.2, 0.1], [0.2, 0.1], across="Robot", points=True),
        Curve("gain [-]", [1.0], [0.9], time, bound=1.0, points=True, predicted_at=2.0 * time),
    ]
    figure = certificate_figure(curves)
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names == ["Measured", "Theory", "Bound"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["time [s]", "Robot", "time [s]"]
    assert os.path.getsize(save(figure, str(tmp_path / "certificates.pdf"))) > 1000


def test_a_run_draws_its_certificates(tmp_path):
    from mrs_simulator import run_experiment

    run_experiment(shipped("consensus", duration=1.0), str(tmp_path), formats=("png",))
    assert (tmp_path / "certificates.png").exists()
