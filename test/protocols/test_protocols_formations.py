"""Formations by displacements, distances and bearings: the equations, their theorems, their scenarios."""

import numpy as np
import pytest
from protocol_fixtures import (
    as_points,
    check,
    ended_early,
    failed,
    part_of_shipped,
    shipped,
    verdict_of,
)

from mrs_simulator.core.fields import checked_values
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.protocols.making import make_control
from mrs_simulator.protocols.shapes import equations as laws
from mrs_simulator.protocols.shapes import law as library
from mrs_simulator.protocols.shapes.energies import length_energy
from mrs_simulator.study.results.report import judged
from mrs_simulator.study.run.experiment import played
from mrs_simulator.study.run.simulating import simulate

SHIPPED = {
    "displacement_formation": library.DisplacementFormation,
    "distance_formation": library.DistanceFormation,
    "bearing_formation": library.BearingFormation,
    "bearing_leaders": library.BearingLeaders,
}
PAIR = Topology(2, [(1, 2)], directed=False)


# Shapes and equations, typed out.


def test_shapes():
    near = lambda shape, n, wanted: np.testing.assert_allclose(  # noqa: E731
        laws.shape_places(shape, n, 2.0), wanted, atol=1e-12
    )
    near("line", 3, [[2, 0], [0, 0], [-2, 0]])
    near("grid", 4, [[1, 1], [1, -1], [-1, 1], [-1, -1]])
    near("circle", 4, [[2**0.5, 0], [0, 2**0.5], [-(2**0.5), 0], [0, -(2**0.5)]])
    a = 2**0.5
    near("vee", 3, [[2 * a / 3, 0], [-a / 3, a], [-a / 3, -a]])
    near("circle", 1, [[0, 0]])
    with pytest.raises(ValueError, match="wanted one of line, circle, vee, grid"):
        laws.shape_places("star", 3, 1.0)


@pytest.mark.parametrize("shape", laws.SHAPES)
def test_neighbours_in_a_shape_are_a_size_apart(shape):
    places = laws.shape_places(shape, 9, 1.5)
    apart = np.linalg.norm(places[:, np.newaxis] - places, axis=2) + 99.0 * np.eye(9)
    assert apart.min() == pytest.approx(1.5)
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=1e-12)


def test_displacement_formation():
    points = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])
    places = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    star = Topology(3, [(1, 2), (1, 3, 2.0)], directed=False)
    u = laws.displacement_flow(1.0, places, star).velocity(points)
    np.testing.assert_allclose(u, [[3.0, 4.0], [-3.0, 0.0], [0.0, -4.0]])


def test_distance_formation():
    points = np.array([[0.0, 0.0], [2.0, 0.0]])
    places = np.array([[0.0, 5.0], [0.0, 6.0]])
    u = laws.distance_flow(1.0, places, PAIR).velocity(points)  # |p_12|^2 - d_12^2 = 4 - 1
    np.testing.assert_allclose(u, [[6.0, 0.0], [-6.0, 0.0]])
    assert length_energy(PAIR, places, 1.0).value(points) == pytest.approx(9.0 / 4.0)


def test_distance_formation_descends_its_potential():
    draw = np.random.default_rng(4)
    points, places = draw.normal(size=(2, 5, 2))
    graph = Topology(5, [(1, 2), (2, 3, 0.5), (3, 4), (4, 5, 2.0), (1, 3)], directed=False)
    slope = np.empty((5, 2))
    for i, d in np.ndindex(5, 2):
        ahead, behind = points.copy(), points.copy()
        ahead[i, d] += 1e-6
        behind[i, d] -= 1e-6
        high, low = length_energy(graph, places, 1.0).values(np.array([ahead, behind]))
        slope[i, d] = (high - low) / 2e-6
    np.testing.assert_allclose(
        laws.distance_flow(1.0, places, graph).velocity(points), -slope, atol=1e-6
    )


def test_distance_hessian():
    places = laws.shape_places("circle", 4, 2.0)
    graph = Topology(4, [(1, 2), (2, 3), (3, 4), (4, 1), (1, 3)], directed=False)
    matrix, step = laws.distance_hessian(places, graph), 1e-6
    for column in range(8):
        away = np.zeros(8)
        away[column] = step
        u = laws.distance_flow(1.0, places, graph).velocity(places + away.reshape(4, 2))
        np.testing.assert_allclose(-u.ravel() / step, matrix[:, column], atol=1e-4)


def test_bearing_formation():
    points, places = np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([[0.0, 0.0], [2.0, 0.0]])
    # g = (1, 1)/sqrt 2, g* = (1, 0): P(g) g* = (1/2, -1/2).
    u = laws.bearing_flow(1.0, places, PAIR).velocity(points)
    np.testing.assert_allclose(u, [[-0.5, 0.5], [0.5, -0.5]])
    together = laws.bearing_flow(1.0, places, PAIR).velocity(np.zeros((2, 2)))
    assert np.isfinite(together).all()


def test_bearing_leaders():
    places = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]])
    points = np.array([[0.0, 0.0], [4.0, 0.0], [1.0, 1.0]])
    graph = Topology(3, [(1, 2), (2, 3), (1, 3)], directed=False)
    # P(g*_31) = diag(1, 0), P(g*_32) = [[1, 2], [2, 4]]/5.
    u = laws.leaders_flow(1.0, places, graph).velocity(points)
    np.testing.assert_allclose(u, [[0.0, 0.0], [0.0, 0.0], [-0.8, 0.4]])
    fitted = laws.fitted_to_leaders(points, places, graph)
    np.testing.assert_allclose(fitted, 2.0 * places, atol=1e-12)


# Properties, on random starts.


@pytest.fixture(params=range(3))
def start(request):
    draw = np.random.default_rng(request.param)
    return laws.shape_places("circle", 6, 3.0) + draw.uniform(-1.5, 1.5, (6, 2)) + [2.0, -1.0]


def held(law, points, gain, period, steps):
    for _ in range(steps):
        points = points + gain * period * law(points)
    return points


RING = [(i, i % 6 + 1) for i in range(1, 7)]
BRACED = Topology(6, RING + [(1, 3), (1, 4), (1, 5)], directed=False)


def test_distances_are_reached_and_the_centroid_stays(start):
    places = laws.shape_places("circle", 6, 3.0)
    end = held(
        lambda p: laws.distance_flow(1.0, places, BRACED).velocity(p), start, 0.05, 0.02, 4000
    )
    np.testing.assert_allclose(end.mean(axis=0), start.mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(laws.length_excess(end[np.newaxis], places, BRACED), 0.0, atol=1e-6)


def elsewhere():
    """Return a scenario from whose start lengths rest at others: an equilibrium far from the shape."""
    places = [(-1.623688, -7.033273), (-0.982692, -1.258332), (-6.258586, 7.157187)]
    places += [(5.835228, 6.54722), (-7.681236, 3.489533), (5.872762, 0.530648)]
    edges = [(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1), (1, 4), (1, 5), (2, 6)]
    pose = np.array([[x - 0.1, y, 0.0] for x, y in places])
    scenario = as_points(shipped("distance_formation", rate=10))
    return scenario._replace(poses=pose, topology=Topology(6, edges, directed=False), duration=60.0)


def test_where_lengths_rest_elsewhere_the_local_theorem_is_not_judged():
    (check,) = [c for c in simulate(elsewhere()).verdict["checks"] if "worst length" in c["name"]]
    assert check["passed"] is None
    assert "the theorem is local, and from this start the law rests" in check["note"]


def test_other_lengths_than_those_that_are_reached_are_false():
    class Longer(library.DistanceFormation):
        def _worst_length(self, hand):
            return super()._worst_length(hand) + 0.05

    verdict = simulate(as_points(shipped("distance_formation", rate=10)), protocol=Longer).verdict
    (check,) = [c for c in verdict["checks"] if "worst length" in c["name"]]
    assert check["passed"] is False and "false of the law itself" in check["note"]


def test_terms_that_cancel_are_a_rest():
    graph = Topology(3, [(1, 2), (2, 3), (1, 3)], directed=False)
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    places = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]]) * (14.0 / 6.0) ** 0.5
    # d^2 = 7/3: terms 4/3 of lengths 1 (four), 10/3 of length 2 (two); robots 1 and 3 are left with 2.
    assert laws.imbalance(line, places, graph) == pytest.approx(4.0 / 12.0)
    places = np.array([[0.0, 0.0], [3.0**0.5, 0.0], [0.75**0.5, 1.5]])
    assert laws.imbalance(line, places, graph) < 1e-15  # 1 (1 - 3) + 2 (4 - 3) = 0


def test_bearings_are_reached_and_centroid_and_scale_stay(start):
    places = laws.shape_places("circle", 6, 3.0)
    end = held(
        lambda p: laws.bearing_flow(1.0, places, BRACED).velocity(p), start, 10.0, 0.005, 4800
    )
    wanted = start.mean(axis=0) + places * laws.scale(start) / laws.scale(places)
    np.testing.assert_allclose(end, wanted, atol=1e-2)
    np.testing.assert_allclose(laws.bearings(end, BRACED), laws.bearings(places, BRACED), atol=1e-6)


@pytest.mark.parametrize("share, settles", [(0.95, True), (1.05, False)])
def test_the_bound_on_the_gain_is_sharp(start, share, settles):
    """gain Tc lambda_max = 2, with lambda_max = 4 on the ring of six."""
    places, ring = laws.shape_places("circle", 6, 3.0), Topology(6, RING, directed=False)
    gain = share * 2.0 / (0.02 * 4.0)
    end = held(
        lambda p: laws.displacement_flow(1.0, places, ring).velocity(p), start, gain, 0.02, 600
    )
    assert (laws.scale(end - places) < 1e-6) == settles


def test_the_scale_grows_by_held_commands_within_the_bound():
    """From a start far from the shape it grows by over 1 %, of which the claim knows."""
    control = make_control(as_points(shipped("bearing_formation")))
    points = begun = np.random.default_rng(4).uniform(-6.0, 6.0, (6, 2))
    for _ in range(3000):
        points = points + control.period * control.pointMassLaw(points)
    grown = laws.scale(points) / laws.scale(begun) - 1.0
    (claim,) = [c for c in control.claims(begun) if c.name.startswith("drift of the scale")]
    assert 0.01 < grown < claim.tolerance < 0.06


def test_bearings_decay_at_the_rate_of_the_scale_that_was_reached():
    """At 10 Hz held commands make the scale grow by 3 %, and the rate is as much lower."""
    scenario = as_points(shipped("bearing_formation"))
    control = scenario.control._replace(rate=10.0)
    places = np.random.default_rng(0).uniform(-6.0, 6.0, (6, 2))
    poses = np.column_stack([places, np.zeros(6)])
    run = simulate(scenario.changed(control=control.to_plain(), poses=poses.tolist(), step=0.1))
    rate = check(run.verdict, "decay rate of the bearings' error [1/s]")
    assert rate["passed"] and rate["measured"] == pytest.approx(rate["predicted"], rel=2e-3)
    assert check(run.verdict, "drift of the scale [-]")["measured"] > 0.02


@pytest.mark.parametrize("seed", [6, 20])
def test_lengths_decay_at_the_rate_of_their_slowest_mode(seed):
    """From a start of which other modes are larger for most of the run."""
    scenario = as_points(shipped("distance_formation", rate=10))
    random = np.random.default_rng(seed)
    scenario = scenario._replace(
        poses=np.column_stack([random.uniform(-7, 7, (6, 2)), np.zeros(6)])
    )
    run = simulate(scenario.changed(duration=120.0))
    rate = check(run.verdict, "decay rate over theory's [-]")
    assert rate["passed"] and rate["measured"] == pytest.approx(1.0, abs=0.01)


def test_a_point_mass_formation_follows_its_exact_prediction(tmp_path):
    for name in ("displacement_formation", "bearing_leaders"):
        given = as_points(shipped(name, duration=8.0))
        control = make_control(given)
        hand = given.poses[:, :2] + 0.1 * np.stack(
            [np.cos(given.poses[:, 2]), np.sin(given.poses[:, 2])], axis=1
        )
        expected = control.prediction(hand, [0.0, 4.0, 8.0])
        np.testing.assert_allclose(expected[0], hand, atol=1e-12)
        for step in range(400):
            hand = hand + 0.02 * control.pointMassLaw(hand)
            if step == 199:
                np.testing.assert_allclose(hand, expected[1], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(hand, expected[2], rtol=0.0, atol=1e-9)
        wanted = control.targets(hand)
        assert wanted.shape == (6, 2)


# The scenarios pass, on robots and on points.


@ended_early(
    {
        "displacement_formation": 0.6,
        "distance_formation": 0.95,
        "bearing_formation": 0.5,
        "bearing_leaders": 0.5,
    }
)
def test_the_shipped_scenario_passes(tmp_path, name, share):
    verdict = verdict_of(part_of_shipped(name, share), tmp_path)
    assert verdict["passed"], failed(verdict)
    # Nothing was left out: theory speaks of the whole run.
    assert all(check["passed"] for check in verdict["checks"])
    assert verdict["min_distance"] > 1.0


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_points_agree_closely(tmp_path, name):
    verdict = verdict_of(as_points(shipped(name, rate=10)), tmp_path)
    assert verdict["passed"], failed(verdict)
    assert all(check["passed"] for check in verdict["checks"])


def test_displacement_rate_is_lambda_2(tmp_path):
    """lambda_2 of a ring of six is 2 (1 - cos(pi/3)) = 1."""
    verdict = verdict_of(as_points(shipped("displacement_formation")), tmp_path)
    measured = check(verdict, "decay rate of the error [1/s]")["measured"]
    assert measured == pytest.approx(-np.log(1.0 - 0.3 * 0.02) / 0.02, rel=1e-6)


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_who_starts_in_the_shape_passes_without_a_rate(tmp_path, name):
    given = shipped(name, duration=3.0)
    places = make_control(given).places() - [given.hand_length, 0.0]
    poses = np.column_stack([places, np.zeros(given.n)])
    verdict = verdict_of(given._replace(poses=poses), tmp_path)
    assert verdict["passed"], failed(verdict)
    rate = check(verdict, "decay rate")
    assert (rate["passed"], rate["measured"]) == (None, None)
    assert rate["note"] == "does not apply: there is nothing to decay from this start"


def test_a_directed_chain_ends_where_its_root_stands(tmp_path):
    chain = {"edges": [[i, i + 1] for i in range(1, 6)]}
    given = as_points(shipped("displacement_formation", topology=chain, duration=70.0))
    control = make_control(given)
    start = given.poses[:, :2].copy()
    np.testing.assert_allclose(control.targets(start)[5], start[5], atol=1e-9)
    verdict = verdict_of(given, tmp_path)
    assert verdict["passed"], failed(verdict)


def test_on_wheels_nothing_is_said_of_rates(tmp_path):
    given = shipped("distance_formation", fidelity="dynamic", duration=8.0)
    verdict = verdict_of(given, tmp_path)
    assert verdict["passed"], failed(verdict)
    assert not [check for check in verdict["checks"] if check["name"].startswith("decay")]


def potentials(start, share):
    """Return the potential before each of 40 commands, held ``share`` times as long as it surely falls."""
    scenario = shipped("distance_formation")
    places, topology = laws.shape_places("circle", 6, 3.0), scenario.topology
    begin = laws.length_potential(start, places, topology)
    period = share * 2.0 / laws.potential_curvature(begin, places, topology)
    points, values = start, []
    for _ in range(40):
        values.append(laws.length_potential(points, places, topology))
        if values[-1] > 1e6 * begin:
            break
        points = points + period * laws.distance_flow(1.0, places, topology).velocity(points)
    return np.array(values) / begin


@pytest.mark.parametrize("size", [1.0, pytest.param(3.0, marks=pytest.mark.release), 6.0, 20.0])
def test_held_commands_never_raise_the_potential_below_its_curvature(size):
    starts = np.random.default_rng(5).uniform(-size, size, (30, 6, 2))
    assert max(np.diff(potentials(start, 0.99)).max() for start in starts) < 1e-12
    # The bound is no more than a few times what a start bears.
    risen = [np.diff(potentials(start, 6.0)).max() > 1e-3 for start in starts]
    assert np.mean(risen) > 0.5


def test_the_curvature_of_the_potential_is_bounded_where_it_is_lower():
    scenario, places = shipped("distance_formation"), laws.shape_places("circle", 6, 3.0)
    draw, topology = np.random.default_rng(3), scenario.topology
    receiver, sender, weight = topology.arcs
    for size in (0.5, 2.0, 8.0):
        points = draw.uniform(-size, size, (6, 2))
        bound = laws.potential_curvature(
            laws.length_potential(points, places, topology), places, topology
        )
        x = draw.standard_normal((200, 6, 2))
        x /= np.linalg.norm(x, axis=(1, 2), keepdims=True)
        h = 1e-4 * size
        value = [
            laws.length_potential(points + k * h * each, places, topology)
            for each in x
            for k in (-1.0, 0.0, 1.0)
        ]
        curved = np.diff(np.reshape(value, (-1, 3)), 2).ravel() / h**2
        assert curved.max() < bound


def test_a_law_that_is_wrong_does_not_rule_its_theorem_out(tmp_path, monkeypatch):
    spring = laws.spring
    monkeypatch.setattr(laws, "spring", lambda *given: -spring(*given))
    scenario = as_points(shipped("distance_formation", rate=10, duration=2.0))
    verdict = verdict_of(scenario, tmp_path)
    assert check(verdict, "gain Tc curvature of the potential < 2")["passed"]
    assert "growth of the potential [-]" in failed(verdict)


def test_lengths_from_too_far_away_are_outside_the_theorem(tmp_path):
    name = "gain Tc curvature of the potential < 2"
    for gain, holds in ((0.01, True), (0.05, False)):
        scenario = as_points(shipped("distance_formation", {"gain": gain}, rate=10, duration=2.0))
        verdict = verdict_of(scenario, tmp_path / str(gain))
        assert check(verdict, name)["passed"] is (True if holds else None), gain
        growth = check(verdict, "growth of the potential")
        assert growth["passed"] is (True if holds else None)


# Broken variants fail.


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_the_wrong_sign_fails(tmp_path, name):
    class Wrong(SHIPPED[name]):
        def pointMassLaw(self, hand):
            return -super().pointMassLaw(hand)

    verdict = verdict_of(shipped(name, duration=4.0), tmp_path, Wrong)
    assert "commands off the published law [-]" in failed(verdict)


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_a_gain_below_0_or_above_its_bound_fails(tmp_path, name):
    # The law of distances grows with their third power: beyond what a world takes as a command.
    above = 0.5 if name == "distance_formation" else 90.0
    for gain, said in ((-0.01, "gain above 0"), (above, "gain Tc < 2/lambda_max")):
        given = as_points(shipped(name, {"gain": gain}, rate=10, duration=0.2))
        assert said in failed(verdict_of(given, tmp_path))


@pytest.mark.parametrize(
    "name, said",
    [
        ("displacement_formation", "spanning tree"),
        ("distance_formation", "rigid target"),
        ("bearing_formation", "rigid target"),
        ("bearing_leaders", "unique target"),
    ],
)
def test_too_few_edges_are_said(tmp_path, name, said):
    few = [[1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 1], [1, 3], [1, 4]]
    few = few if name != "displacement_formation" else [[1, 2], [2, 3], [4, 5], [5, 6]]
    given = shipped(name, topology={"edges": few, "directed": False}, duration=1.0)
    verdict = verdict_of(given, tmp_path)
    # Without a spanning tree theory says that the shape is missed, of the others it says nothing.
    assert failed(verdict) == ([said] if said == "spanning tree" else [])
    assert verdict["outcome"] == ("failed" if said == "spanning tree" else "not_judged")
    assert check(verdict, said)["note"]


def test_a_shape_that_bends_is_said_to(tmp_path):
    verdict = verdict_of(shipped("distance_formation", {"shape": "line"}, duration=1.0), tmp_path)
    assert "still bends" in check(verdict, "rigid target")["note"]


def test_directed_distances_and_collinear_starts_are_outside_the_theorem(tmp_path):
    edges = [list(edge[:2]) for edge in BRACED.edges]
    given = shipped("distance_formation", topology={"edges": edges}, duration=1.0)
    verdict = verdict_of(given, tmp_path)
    assert verdict["outcome"] == "not_judged" and "undirected graph does not" in verdict["reason"]
    row = [[2.0 * i, 0.0, 0.0] for i in range(6)]
    given = shipped("distance_formation", poses=row, duration=1.0)
    assert failed(verdict_of(given, tmp_path)) == ["start not on one line"]


def test_leaders_that_do_not_fit_the_shape_are_named(tmp_path):
    poses = shipped("bearing_leaders").poses.tolist()
    poses[1][0] += 1.0
    verdict = verdict_of(shipped("bearing_leaders", poses=poses, duration=1.0), tmp_path)
    assert verdict["outcome"] == "not_judged" and "leaders fit the shape" in verdict["reason"]
    limit = check(verdict, "distance from the unique target")
    assert limit["passed"] is None and limit["measured"] > 0.1


def test_distance_targets_are_the_shape_turned_onto_the_robots():
    control = make_control(shipped("distance_formation"))
    cos, sin = np.cos(0.7), np.sin(0.7)
    for flip in (1.0, -1.0):
        turn = np.array([[cos, -sin], [sin, cos]]) @ np.diag([1.0, flip])
        hand = control.places() @ turn.T + [3.0, 4.0]
        np.testing.assert_allclose(control.targets(hand), hand, atol=1e-9)


@pytest.mark.parametrize("protocol", list(SHIPPED.values()))
def test_parameters_are_checked(protocol):
    values = checked_values(protocol.PARAMETERS, {})
    assert {"gain", "shape", "size", "l"} <= set(values)
    for wrong in ({"shape": "star"}, {"size": 0.0}, {"gain": "much"}):
        with pytest.raises(ValueError):
            checked_values(protocol.PARAMETERS, wrong)


# The paper's law.


class Away(Formation):
    def pointMassLaw(self, hand):
        return -super().pointMassLaw(hand)


class TooWide(Formation):
    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand * [1.02, 1.0])


class LosesAnEdge(Formation):
    def pointMassLaw(self, hand):
        return super().pointMassLaw(hand) * (np.arange(len(hand)) != 2)[:, np.newaxis]


class TooSlow(Formation):
    def pointMassLaw(self, hand):
        return 0.8 * super().pointMassLaw(hand)


@pytest.mark.parametrize(
    "law, said",
    [
        (Away, "commands off the published law [-]"),
        (TooWide, "final gap, the worst [m]"),
        (LosesAnEdge, "y spread [m]"),
        (TooSlow, "settling time [s]"),
    ],
)
def test_a_broken_paper_law_fails(tmp_path, law, said):
    assert said in failed(verdict_of(shipped("paper_theory"), tmp_path, law))


def test_where_only_the_end_is_known_it_is_drawn_over_the_last_samples():
    """Dashes at the place, where no whole track is predicted; none where theory does not apply."""
    given = shipped("bearing_formation", duration=2.0)
    run, control = played(given)
    _, drawn = judged(run, control)
    np.testing.assert_allclose(drawn["time"], [1.6, 2.0])
    places = drawn["hand"][0] - drawn["hand"][0].mean(axis=0)
    shape = laws.shape_places("grid", 6, 1.0)
    np.testing.assert_allclose(places, shape * laws.scale(places) / laws.scale(shape), atol=1e-9)
    few = shipped("bearing_formation", topology={"preset": "path"}, duration=2.0)
    assert judged(run._replace(scenario=few), make_control(few))[1] is None
