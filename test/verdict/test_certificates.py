"""Energies with typed-out values and slopes, their balance in runs, connectivity, and their figure."""

import os

import numpy as np
import pytest
from protocol_fixtures import check, shipped, verdict_of

from mrs_simulator.core import sample_blocks
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.protocols import energies
from mrs_simulator.protocols import shipped as law_of
from mrs_simulator.protocols.consensus.energies import second_order_energy
from mrs_simulator.protocols.curves import Curve, Energy, dissipated, integral
from mrs_simulator.protocols.energies import error_energy
from mrs_simulator.protocols.flocking.energies import agreement_energy
from mrs_simulator.protocols.gathering import equations as gathering_equations
from mrs_simulator.protocols.gathering.energies import coverage_energy, tension_energy
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.shapes.energies import bearing_energy, length_energy
from mrs_simulator.record.recording import Run, read_run_csv
from mrs_simulator.study.draw.canvas import save
from mrs_simulator.study.draw.certificate_figure import certificate_figure
from mrs_simulator.verdict import energy_balance

BALANCE = "energy off its predicted change"
PATH = Topology.preset("path", 3)
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]])


def test_energies_typed_out():
    energy = energies.laplacian_energy(PATH, 0.5)
    # (1 + 4)/2; L p = (-1, -1, 2), squared 6, times 0.5.
    assert (energy.value(POINTS), energy.dissipation(POINTS)) == (2.5, 3.0)
    # The last one stands: (1 + 1)/2.
    assert energies.laplacian_energy(PATH, 0.5, standing=1).dissipation(POINTS) == 1.0
    tension = tension_energy(np.array([[0, 1], [1, 2]]), 4.0, 0.2)
    # 1/3 + 4/2; slopes 7/9 and 12/4: pulls 0.7778, 2.2222, 3.
    assert tension.value(POINTS) == pytest.approx(7.0 / 3.0)
    assert tension.dissipation(POINTS) == pytest.approx(0.2 * (49.0 + 400.0 + 729.0) / 81.0)
    lengths = length_energy(PATH, 2.0 * POINTS, 0.1)
    # (1 - 4)^2/4 + (4 - 16)^2/4; slopes -3 and -24: pulls 3, 21, 24.
    assert lengths.value(POINTS) == 38.25
    assert lengths.dissipation(POINTS) == pytest.approx(0.1 * (9.0 + 441.0 + 576.0))
    samples = np.array([[0.0, 0.0], [2.0, 0.0], [10.0, 0.0]])
    cost = coverage_energy(samples, np.ones(3), 0.5)
    two = np.array([[0.5, 0.0], [9.0, 0.0]])
    # (0.25 + 2.25 + 1)/3; 2 * 0.5 (2/3 * 0.25 + 1/3 * 1).
    assert cost.value(two) == pytest.approx(3.5 / 3.0)
    assert cost.dissipation(two) == pytest.approx(0.5)


def test_energies_of_edges_are_the_same_numbers_over_many_states(monkeypatch):
    """Of a dozen pairs, so that the order of their sum shows, in several blocks of states."""
    monkeypatch.setattr(sample_blocks, "AT_ONCE", 30)
    graph, random = Topology.preset("ring", 12), np.random.default_rng(0)
    places, states = random.uniform(0.0, 1.0, (12, 2)), random.uniform(0.0, 1.0, (9, 12, 2))
    pairs = np.stack([np.arange(11), np.arange(1, 12)], axis=1)
    for energy in (tension_energy(pairs, 4.0, 0.2), length_energy(graph, places, 0.1)):
        values = [energy.of(state, None, 0.0) for state in states]
        assert energy.values(states).tolist() == values
        losses = [energy.spent(state, None, 0.0) for state in states]
        assert energy.losses(states, None, None).tolist() == losses


def test_energies_of_bearings_and_errors_typed_out():
    pair = Topology.preset("path", 2)
    goal, hand = np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0.0, 0.0], [3.0, 4.0]])
    bearings = bearing_energy(pair, goal, 0.5)
    # (1 + 16)/2; 0.5 * 2 * (1 - 0.36).
    assert bearings.value(hand) == 8.5 and bearings.dissipation(hand) == pytest.approx(0.64)
    # z = (e_1 - e_2)/sqrt 2 decays at 0.5 * 1, so that P = 1/2, and |z|^2 = 12.5.
    leader = error_energy(np.array([[1.0, -1.0], [0.0, 0.0]]), 0.5, lambda p: p)
    assert leader.value(hand) == pytest.approx(6.25) and leader.dissipation(hand) == pytest.approx(
        6.25
    )
    moving = second_order_energy(pair, 0.5)
    velocity = np.array([[1.0, 0.0], [-1.0, 0.0]])
    # 25/2 + 2/2; 0.5 * 4.
    assert moving.of(hand, velocity, 0.0) == 13.5 and moving.spent(hand, velocity, 0.0) == 2.0
    agreeing = agreement_energy(2.0, 1.0, 5.0)
    # 2/2; 2/2 * (1 + 25/25)^-1 * 4.
    assert agreeing.of(hand, velocity, 0.0) == 1.0 and agreeing.spent(hand, velocity, 0.0) == 2.0


def test_the_weight_of_a_matrix_typed_out():
    # 2 * 0.5 P = 1, and a chain: [[1, -1], [0, 1]].
    np.testing.assert_allclose(energies.lyapunov(np.array([[0.5]])), [[1.0]])
    matrix = np.array([[1.0, -1.0], [0.0, 1.0]])
    weight = energies.lyapunov(matrix)
    np.testing.assert_allclose(weight, [[0.5, 0.25], [0.25, 0.75]])
    np.testing.assert_allclose(matrix.T @ weight + weight @ matrix, np.eye(2), atol=1e-12)


OF_PLACES = (
    "consensus consensus_directed discrete_consensus displacement_formation distance_formation "
    "bearing_formation bearing_leaders containment rendezvous coverage paper"
)
OF_STATES = "second_order_consensus flocking cucker_smale marching marching_lag"


@pytest.mark.parametrize("name", OF_PLACES.split())
def test_energies_fall_along_the_law_as_fast_as_they_say(name):
    control, hand = begun(name)
    energy = control.energy(hand)
    step = 1e-6 * control.pointMassLaw(hand)
    slope = (energy.value(hand + step) - energy.value(hand - step)) / 2e-6
    assert slope == pytest.approx(-energy.dissipation(hand), rel=2e-3) and slope < 0.0


@pytest.mark.parametrize("name", OF_STATES.split())
def test_energies_of_states_fall_as_fast_as_they_say(name):
    """Over a period so short that held commands and their steps cost nothing."""
    control, hand = begun(name)
    law, energy, dt = control.published(), control.energy(hand), control.period
    memory = law.begin(hand)
    velocity, memory = law.velocity(hand, 0.0, memory)
    after = hand + dt * velocity
    then, _ = law.velocity(after, dt, memory)
    slope = (energy.of(after, then, dt) - energy.of(hand, velocity, 0.0)) / dt
    spent = energy.spent(hand, velocity, 0.0)
    assert slope == pytest.approx(-spent, rel=0.02) and spent > 0.0


def begun(name):
    """Return the control of a shipped scenario with commands every 0.1 ms, and its hand points."""
    scenario = shipped(name)
    parameters = dict(scenario.control.parameters)
    if name == "second_order_consensus":
        parameters["push"] = 0.5
    rate = 2.0 if name == "discrete_consensus" else 1e4  # whose step is a command's
    own = scenario.control._replace(rate=rate, parameters=parameters)
    control = make_control(scenario._replace(fidelity="point_mass", limits=None, control=own))
    draw = np.random.default_rng(3).uniform(-0.5, 0.5, (scenario.n, 2))
    hand = hand_points(scenario.poses, control.l) + draw * (name in ("marching", "marching_lag"))
    control.start()
    return control, hand


def test_the_residual_of_a_decay_typed_out():
    time = np.arange(0.0, 5.0, 0.01)
    hand = np.exp(-0.5 * time)[:, np.newaxis, np.newaxis] * np.array([[[1.0, 0.0]]])
    run = Run(time, np.array([1]), None, hand, None)
    energy = Energy("V", lambda p: float((p**2).sum()), lambda p: float((p**2).sum()))
    balance = balanced(energy, run)
    assert balance.residual < 1e-4 and 0.009 < balance.allowed < 0.011
    late = balance.since(100)
    assert late.measured[0] == late.predicted[0] == pytest.approx(np.exp(-1.0))
    wrong = Energy("V", energy.value, lambda p: 1.1 * float((p**2).sum()))
    assert balanced(wrong, run).residual == pytest.approx(0.1, abs=0.01)
    nothing = Energy("V", lambda p: 0.0, lambda p: 0.0)
    assert balanced(nothing, run).residual is None
    np.testing.assert_allclose(
        integral(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0])), [0, 1, 7]
    )


def balanced(energy, run):
    states = run.hand, np.zeros_like(run.hand), run.time
    return dissipated(run.time, energy.values(*states), energy.losses(*states), 0.01)


def test_a_law_that_loses_a_tenth_is_off_its_balance(tmp_path):
    class Weak(law_of("consensus")):
        def pointMassLaw(self, hand):
            return 0.9 * super().pointMassLaw(hand)

    right = verdict_of(shipped("consensus", duration=10.0), tmp_path / "right")
    assert check(right, BALANCE)["passed"]
    wrong = verdict_of(shipped("consensus", duration=10.0), tmp_path / "wrong", Weak)
    found = check(wrong, BALANCE)
    assert found["passed"] is False and found["measured"] == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    "name",
    ["containment", pytest.param("distance_formation", marks=pytest.mark.release), "marching"],
)
def test_robots_keep_the_balance_of_a_right_law_and_miss_that_of_a_weak_one(name, tmp_path):
    class Weak(law_of(name)):
        def wanted_commands(self, pose):
            return 0.8 * super().wanted_commands(pose)

    scenario = shipped(name, duration=3.0)
    right = check(verdict_of(scenario, tmp_path / "right"), BALANCE)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Weak), BALANCE)
    assert right["passed"] and right["measured"] < 0.005, right
    assert wrong["passed"] is False and wrong["measured"] > 4.0 * wrong["tolerance"], wrong


@pytest.mark.parametrize(
    "name",
    ["second_order_consensus", "event_triggered_consensus", "discrete_consensus", "flocking"],
)
def test_points_keep_the_balance_to_rounding(name, tmp_path):
    class Weak(law_of(name)):
        def pointMassLaw(self, hand):
            return 0.99 * super().pointMassLaw(hand)

    scenario = shipped(name, duration=3.0)._replace(fidelity="point_mass", limits=None)
    right = check(verdict_of(scenario, tmp_path / "right"), BALANCE)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Weak), BALANCE)
    assert right["passed"] and right["measured"] < 1e-9, right
    assert wrong["passed"] is False and wrong["measured"] > 1e-4, wrong


def test_a_team_that_is_slowed_is_judged_between_its_limits(tmp_path):
    """What limits make of the energy is no theorem's; the rest is held to theory from where it begins."""

    class Weak(law_of("displacement_formation")):
        def pointMassLaw(self, hand):
            return 0.95 * super().pointMassLaw(hand)

    scenario = shipped("displacement_formation", duration=6.0)
    right = check(verdict_of(scenario, tmp_path / "right"), BALANCE)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Weak), BALANCE)
    assert right["passed"] and right["tolerance"] < 2e-3, right
    assert wrong["passed"] is False and wrong["measured"] > 10.0 * wrong["tolerance"], wrong


@pytest.mark.parametrize(
    "name", ["displacement_formation", pytest.param("coverage", marks=pytest.mark.release)]
)
def test_cars_are_judged_where_neither_steering_nor_its_rate_holds_them_back(name, tmp_path):
    """At the start their wheels turn as fast as they can, which no recorded command tells."""

    class Weak(law_of(name)):
        def pointMassLaw(self, hand):
            return 0.9 * super().pointMassLaw(hand)

    scenario = shipped(name, duration=4.0)
    cars = {"kinds": ("f1tenth",) * scenario.n, "limits": "firmware"}
    scenario = scenario._replace(odometry="world", **cars)
    right = check(verdict_of(scenario, tmp_path / "right"), BALANCE)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Weak), BALANCE)
    assert right["passed"] and right["tolerance"] < 5e-3, right
    assert wrong["passed"] is False, wrong


def test_cars_under_a_law_with_velocities_are_judged_between_their_limits(tmp_path):
    """No command tells a steering rate, and behind one the law remembers another velocity than that."""

    class Weak(law_of("cucker_smale")):
        def accelerations(self, hand, velocity):
            return 0.95 * super().accelerations(hand, velocity)

    scenario = shipped("cucker_smale", duration=4.0, fidelity="kinematic", odometry="world")
    scenario = scenario._replace(kinds=("f1tenth",) * scenario.n, limits="firmware")
    right = verdict_of(scenario, tmp_path / "right")
    wrong = verdict_of(scenario, tmp_path / "wrong", Weak)
    drift = check(right, "drift of the mean velocity")
    assert right["outcome"] == "passed", right["checks"]
    assert drift["passed"] and drift["measured"] < 1e-12 and "s on, after" in drift["note"], drift
    assert check(right, BALANCE)["measured"] < 1e-5
    assert check(wrong, BALANCE)["passed"] is False


def test_how_far_boats_are_behind_is_known_without_a_law_at_hand(tmp_path, monkeypatch):
    monkeypatch.setattr(energy_balance, "MOST_PAIRS", 0.0)
    fast = {"v_max": 20.0, "omega_max": 20.0}
    scenario = shipped("formation_boats", duration=12.0, fidelity="kinematic", limits=fast)
    verdict_of(scenario, tmp_path)
    run, control = read_run_csv(str(tmp_path / "run.csv")), make_control(scenario)
    balance = energy_balance.balance_of(control, control.energy(run.hand[0]), run)
    assert 0.01 < balance.residual < balance.allowed < 0.15


@pytest.mark.parametrize("at_hand", [True, False])
def test_without_a_law_at_hand_the_balance_is_that_of_the_rest(at_hand, tmp_path, monkeypatch):
    if not at_hand:
        monkeypatch.setattr(energy_balance, "MOST_PAIRS", 0.0)
    scenario = shipped("displacement_formation", duration=20.0, fidelity="kinematic")
    balance = check(verdict_of(scenario, tmp_path), BALANCE)
    assert balance["passed"], balance
    assert ("s on, after" in balance["note"]) is not at_hand, balance


def test_a_team_that_is_at_its_limits_throughout_is_not_judged(tmp_path):
    slow = {"v_max": 0.05, "omega_max": 1.0}
    scenario = shipped("displacement_formation", duration=1.0, limits=slow)
    balance = check(verdict_of(scenario, tmp_path), BALANCE)
    assert balance["passed"] is None and "at a limit all the time" in balance["note"]


@pytest.mark.parametrize("fidelity", ["kinematic", "dynamic"])
def test_robots_that_ramp_are_judged_by_their_commands(fidelity, tmp_path):
    """They are behind their commands, by what is known from the record, and no more is allowed."""

    class Weak(law_of("formation")):
        def pointMassLaw(self, hand):
            return 0.95 * super().pointMassLaw(hand)

    ramps = {"v_max": 1.5, "omega_max": 6.28, "v_accel": 1.0, "omega_accel": 6.0}
    changes = {"fidelity": fidelity, "odometry": "world", "limits": ramps}
    scenario = shipped("lab_four", duration=5.0, **changes)
    right = check(verdict_of(scenario, tmp_path / "right"), BALANCE)
    wrong = check(verdict_of(scenario, tmp_path / "wrong", Weak), BALANCE)
    assert right["passed"] and 1e-4 < right["measured"] < right["tolerance"], right
    assert wrong["passed"] is False, wrong


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


def test_a_march_that_goes_on_has_the_energy_of_that_time():
    control, hand = begun("marching")
    whole, later = control.energy(hand), control.resumed(2.0, None).energy(hand)
    velocity = np.zeros_like(hand)
    assert later.of(hand, velocity, 1.0) == pytest.approx(whole.of(hand, velocity, 3.0))
    assert whole.of(hand, velocity, 1.0) != pytest.approx(whole.of(hand, velocity, 3.0))


@pytest.mark.parametrize("name", [*OF_PLACES.split(), *OF_STATES.split()])
def test_one_robot_has_an_energy_or_none(name):
    scenario = shipped(name)
    if scenario.topology is not None:
        scenario = scenario._replace(topology=Topology(scenario.n, [], scenario.topology.directed))
    scenario = scenario.with_robots(1)
    try:
        control = make_control(scenario)
    except ValueError:  # of a law that is of more
        return
    hand = hand_points(scenario.poses, control.l)
    energy = control.energy(hand)
    if energy is not None:
        assert np.isfinite(energy.of(hand, 0.0 * hand, 0.0))
        assert np.isfinite(energy.spent(hand, 0.0 * hand, 0.0))


def test_directed_bearings_lose_the_energy_that_their_matrix_says():
    edges = [[i, j] for i in range(3, 7) for j in range(1, 7) if i != j and j < i]
    scenario = shipped("bearing_leaders", topology={"edges": edges, "directed": True})
    control = make_control(scenario)
    hand, h = np.array(scenario.poses)[:, :2], 1e-6
    energy, u = control.energy(hand), control.pointMassLaw(hand)
    fall = (energy.value(hand - h * u) - energy.value(hand + h * u)) / (2.0 * h)
    assert energy.dissipation(hand) > 1.0
    assert fall == pytest.approx(energy.dissipation(hand), rel=1e-6)
