"""Laws for points in space: held against their theorems, and against themselves in the plane."""

import numpy as np
import pytest
from space_fixtures import Flyers, flown, flying, wrong_claims

from mrs_simulator import PioneerControl, make_twist
from mrs_simulator.control.twists import ControlError
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.neighbours import close_pairs, closest_pair
from mrs_simulator.core.spectra import (
    is_infinitesimally_bearing_rigid,
    is_infinitesimally_rigid,
    rigidity_matrix,
)
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.protocols.formation.equations import y_spread
from mrs_simulator.protocols.gathering.equations import outside_hull
from mrs_simulator.protocols.published.laws import exact_motion
from mrs_simulator.protocols.shapes import equations as formations
from mrs_simulator.scenario.team.load import Load

PLANAR = {
    "coverage",
    "cyclic_pursuit",
    "exploration",
    "leader_follower",
    "limited_visibility",
    "line_of_sight",
    "sensed_following",
    "station_keeping",
    "vicsek",
    "wall_following",
}
SPATIAL = sorted(set(HOMES) - PLANAR)
LOAD = Load(6.0, (0.3, 3.0, 0.1), ((-0.1, 1.4, 0.0), (0.2, 0.0, 0.0), (-0.1, -1.4, 0.0)))
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_EDGES = [(i, j) for i in range(8) for j in range(i) if np.abs(CUBE[i] - CUBE[j]).sum() == 1.0]


def anywhere(n, size=4.0, seed=1):
    return size * np.random.default_rng(seed).uniform(-0.5, 0.5, (n, 3))


def graph(n, seed=0):
    return Topology.random(n, 0.4, seed)


def complete(n):
    return Topology.preset("complete", n)


def cube(n):
    """Return the edges of a cube and one diagonal: bearings fix it, lengths would not."""
    places, (first, second) = formations.shape_places("grid", n, 1.0, 3), np.triu_indices(n, 1)
    length = np.linalg.norm(places[first] - places[second], axis=1)
    chosen = (length < 1.1) | (first == 0) & (length > 1.7)
    pairs = np.column_stack([first, second])[chosen] + 1
    return Topology(n, pairs.tolist(), directed=False)


def shape(control, off=0.1):
    """Return the control's shape, somewhere else, with each point ``off`` [m] its place or less."""
    return control.places() + [1.0, 2.0, 3.0] + anywhere(len(control.numbers), 2.0 * off)


def tetrahedron_of_leaders(n):
    corners = 3.0 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    return np.concatenate([anywhere(n - 4), corners])


# Of each law: the team, its graph and parameters, its start, and how long theory wants to see it [s].
FLIGHTS = {
    "consensus": (6, graph, {}, anywhere, 20.0),
    "discrete_consensus": (6, graph, {"eps": 0.02}, anywhere, 20.0),
    "delayed_consensus": (6, graph, {"tau": 0.2}, anywhere, 20.0),
    "second_order_consensus": (5, complete, {"push": 0.3}, anywhere, 20.0),
    "switching_consensus": (6, graph, {"sets": 2, "loss": 0.3}, anywhere, 30.0),
    "event_triggered_consensus": (6, complete, {"gain": 0.2}, anywhere, 20.0),
    "noisy_consensus": (4, complete, {"robot_noise": 0.05, "listener_noise": 0.05}, anywhere, 120.0),
    "platoon": (3, complete, {"tau": 0.1}, anywhere, 40.0),
    "resilient_consensus": (5, complete, {}, anywhere, 20.0),
    "formation": (4, graph, {"k": 0.02}, anywhere, 60.0),
    "displacement_formation": (8, graph, {"shape": "grid", "size": 2.0}, anywhere, 30.0),
    "distance_formation": (8, complete, {"shape": "grid", "size": 2.0, "gain": 0.05}, shape, 10.0),
    "bearing_formation": (8, cube, {"shape": "grid", "size": 2.0}, shape, 30.0),
    "bearing_leaders": (8, cube, {"shape": "grid", "gain": 2.0}, None, 30.0),
    "marching": (8, graph, {"shape": "grid", "swing": 0.2}, anywhere, 30.0),
    "containment": (7, complete, {"leaders": 4}, tetrahedron_of_leaders, 10.0),
    "rendezvous": (6, complete, {"radius": 6.0}, anywhere, 40.0),
    "flocking": (6, complete, {}, anywhere, 25.0),
    "cucker_smale": (6, complete, {}, anywhere, 20.0),
    "reynolds": (6, complete, {}, anywhere, 10.0),
    "trajectory": (3, complete, {"waypoints": "0 0 1, 2 1 2, 1 3 1.5"}, anywhere, 25.0),
    "carrying": (3, complete, {"waypoints": "0 0 1 0, 2 1 2 1", "speed": 0.2}, None, 25.0),
}  # fmt: skip


def flight(name):
    """Return the control and the start of a law's flight."""
    n, edges, parameters, start, _ = FLIGHTS[name]
    control = flying(name, n, edges(n), **parameters)
    if name == "carrying":
        control.carry(LOAD)
        return control, np.array(LOAD.grasps) + [0.0, 0.0, 1.0] + anywhere(n, 0.1)
    if name == "bearing_leaders":
        points = 1.5 * control.places()  # whose leaders are seen as wanted
        points[2:] += anywhere(n - 2, 1.0)
        return control, points
    return control, start(control) if start is shape else start(n)


def test_every_law_says_where_it_is_at_home():
    said = {name: shipped(name).DIMENSIONS for name in HOMES}
    assert said == {name: (2,) if name in PLANAR else (2, 3) for name in HOMES}
    assert set(FLIGHTS) == set(SPATIAL)


@pytest.mark.parametrize("name", sorted(PLANAR))
def test_a_law_of_the_plane_is_refused_in_space(name):
    text = "{}: a law for points of 2 dimensions, while those of the robots have 3"
    with pytest.raises(ControlError, match=text.format(shipped(name).__name__)):
        flying(name, 4, complete(4))


@pytest.mark.parametrize("name", SPATIAL)
def test_theory_holds_in_space(name):
    control, start = flight(name)
    run = flown(control, start, FLIGHTS[name][-1])
    assert run.hand.shape[2] == 3 and np.ptp(run.hand[:, :, 2]) > 0.1  # they use the room
    assert wrong_claims(control, run) == []


@pytest.mark.parametrize("name", SPATIAL)
def test_the_published_law_moves_points_in_space_alike(name):
    control, start = flight(name)
    run = flown(control, start, 2.0)
    points, velocities = exact_motion(control.published(), start, control.period, run.time)
    np.testing.assert_allclose(run.hand, points, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run.command, velocities, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("name", SPATIAL)
def test_a_prediction_is_the_motion_in_space(name):
    control, start = flight(name)
    run = flown(control, start, 2.0)
    track = control.prediction(start, run.time)
    if track is not None:
        steps = slice(None) if name != "formation" else slice(0, 1)  # which reckons in steps of T
        np.testing.assert_allclose(run.hand[steps], track[steps], rtol=0.0, atol=1e-9)


# Random starts of velocities are drawn in space, not in the plane; a cubic grid is none.
LEVEL = {
    name: dict(FLIGHTS[name][2], **changed)
    for name, changed in {
        **{name: {} for name in SPATIAL},
        "second_order_consensus": {"push": 0.0},
        "noisy_consensus": {"velocity_noise": 0.0, "robot_noise": 0.0, "listener_noise": 0.0},
        "flocking": {"start_speed": 0.0},
        "cucker_smale": {"start_speed": 0.0, "drift": 0.3},
        "reynolds": {"speed": 0.5},
        **{
            name: {"shape": "circle"}
            for name in SPATIAL
            if "shape" in [parameter.name for parameter in shipped(name).PARAMETERS]
        },
    }.items()
}


# A waypoint has as many numbers as points have coordinates.
@pytest.mark.parametrize("name", sorted(set(SPATIAL) - {"carrying", "reynolds", "trajectory"}))
def test_in_a_plane_it_is_the_law_of_the_plane(name):
    n, edges = FLIGHTS[name][:2]
    start = tetrahedron_of_leaders(n) if name == "containment" else anywhere(n, 8.0)
    start[:, 2] = 0.0
    control = flying(name, n, edges(n), **LEVEL[name])
    flat = shipped(name)(
        range(1, n + 1), edges(n), saturation="none", parameters=LEVEL[name], fidelity="point_mass"
    )
    run, planar = flown(control, start, 1.0), flown(flat, start[:, :2], 1.0)
    np.testing.assert_array_equal(run.hand[:, :, 2], 0.0)
    np.testing.assert_allclose(run.hand[:, :, :2], planar.hand, rtol=0.0, atol=1e-12)


def test_reynolds_in_a_plane_from_equal_velocities():
    control = flying("reynolds", 5, complete(5))
    flat = shipped("reynolds")(range(1, 6), complete(5))
    start, velocity = anywhere(5), np.zeros((5, 3))
    start[:, 2], velocity[:, 0] = 0.0, 0.4
    given = control.accelerations(start, velocity)
    np.testing.assert_array_equal(given[:, 2], 0.0)
    wanted = flat.accelerations(start[:, :2], velocity[:, :2])
    np.testing.assert_allclose(given[:, :2], wanted, atol=1e-12)


# Closed forms ------------------------------------------------------------------------------------


def integrated(law, start, duration, steps=200):
    """Return where ``p' = law(p)`` goes from ``start``, by Runge and Kutta's fourth-order rule."""
    point, step = start, duration / steps
    for _ in range(steps):
        a = law(point)
        b = law(point + 0.5 * step * a)
        c = law(point + 0.5 * step * b)
        point = point + step / 6.0 * (a + 2.0 * b + 2.0 * c + law(point + step * c))
    return point


def exponential(matrix):
    """Return ``e^matrix`` of a symmetric ``matrix`` by its eigenvalues."""
    values, vectors = np.linalg.eigh(matrix)
    return vectors @ np.diag(np.exp(values)) @ vectors.T


def test_consensus_in_space_is_the_matrix_exponential():
    control, start = flying("consensus", 6, graph(6), gain=0.7), anywhere(6)
    wanted = exponential(-0.7 * 3.0 * graph(6).laplacian()) @ start
    np.testing.assert_allclose(integrated(control.pointMassLaw, start, 3.0), wanted, atol=1e-9)


def test_a_displacement_formation_in_space_is_the_matrix_exponential():
    control, start = flying("displacement_formation", 8, graph(8), shape="grid"), anywhere(8)
    places = control.places()
    assert np.ptp(places, axis=0).tolist() == [3.0, 3.0, 3.0]  # a cube
    away = exponential(-0.5 * 2.0 * graph(8).laplacian()) @ (start - places)
    found = integrated(control.pointMassLaw, start, 2.0)
    np.testing.assert_allclose(found, places + away, atol=1e-9)


def test_two_robots_at_a_distance_in_space():
    """``s = |p_12|^2`` obeys ``s' = -4 gain (s - w) s``: ``s = w/(1 - (1 - w/s_0) e^(-4 gain w t))``."""
    control = flying("distance_formation", 2, complete(2), shape="line", size=2.0, gain=0.05)
    start, w = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 2.0]]), 4.0
    found = integrated(control.pointMassLaw, start, 3.0)
    squared = w / (1.0 - (1.0 - w / 9.0) * np.exp(-4.0 * 0.05 * w * 3.0))
    apart = found[1] - found[0]
    assert apart @ apart == pytest.approx(squared, rel=1e-9)
    np.testing.assert_allclose(np.cross(apart, start[1]), 0.0, atol=1e-12)  # along the same line
    np.testing.assert_allclose(found.mean(axis=0), start.mean(axis=0), atol=1e-12)


@pytest.mark.parametrize("name", ["consensus", "distance_formation", "rendezvous", "flocking"])
def test_a_law_of_differences_turns_with_the_space(name):
    control, start = flight(name)
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    other, _ = flight(name)
    if name == "flocking":
        for each in (control, other):
            each.set_parameters({"start_speed": 0.0, "leader_vx": 0.0})
    turned = other.pointMassLaw(start @ turn.T)
    np.testing.assert_allclose(turned, control.pointMassLaw(start) @ turn.T, atol=1e-12)


ENERGIES = {"consensus", "discrete_consensus", "containment", "rendezvous"}
ENERGIES |= {"displacement_formation", "distance_formation"}


@pytest.mark.parametrize("name", sorted(ENERGIES))
def test_an_energy_falls_in_space_as_it_says(name):
    control, point = flight(name)
    energy, u, step = control.energy(point), control.pointMassLaw(point), 1e-5
    if name == "containment":  # whose leaders stay
        assert not u[-control.leaders :].any()
    slope = (energy.value(point + step * u) - energy.value(point - step * u)) / (2.0 * step)
    assert slope < 0.0 and slope == pytest.approx(-energy.dissipation(point), rel=1e-6)


@pytest.mark.parametrize("name", SPATIAL)
def test_what_else_a_law_tells_of_a_run_in_space(name):
    control, start = flight(name)
    run = flown(control, start, 3.0)
    targets = control.targets(run.hand[-1])
    assert targets is None or targets.shape == start.shape
    measures = control.measures(run).values()
    assert all(value is None or np.isfinite(value).all() for value in measures)
    graph = control.graph_at(start, run.hand[-1])
    assert graph is None or graph.n == len(start)


def test_three_axes_measure_a_variance_better_than_two():
    """Each axis is one trial: the tolerance falls with the square root of their number."""
    flat = shipped("noisy_consensus")(range(1, 5), complete(4), fidelity="point_mass")
    found = [
        control.claims(anywhere(4))[-2]
        for control in (flat, flying("noisy_consensus", 4, complete(4)))
    ]
    assert found[0].predicted == found[1].predicted  # per axis
    assert found[1].tolerance == pytest.approx(found[0].tolerance * np.sqrt(2.0 / 3.0))


def test_a_line_in_space_is_left_to_both_sides():
    assert y_spread(np.array([[0.0, 1.0, 5.0], [2.0, 1.5, 3.0]])) == 2.0
    assert y_spread(np.array([[0.0, 1.0, 5.0], [2.0, 7.0, 3.0]])) == 6.0


# Rigidity ----------------------------------------------------------------------------------------


def test_rigidity_in_space():
    octahedron = np.concatenate([np.eye(3), -np.eye(3)])
    edges = [(i, j) for i in range(6) for j in range(i) if i - j != 3]
    assert len(edges) == 3 * 6 - 6
    assert is_infinitesimally_rigid(octahedron, edges)
    assert not is_infinitesimally_rigid(octahedron, edges[:-1])
    assert not is_infinitesimally_rigid(CUBE, CUBE_EDGES)  # 12 edges of the 18 that it takes
    every = [(i, j) for i in range(8) for j in range(i)]
    assert is_infinitesimally_rigid(CUBE, every)
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    assert not is_infinitesimally_rigid(square, [(i, j) for i in range(4) for j in range(i)])
    assert is_infinitesimally_rigid(square[:3], [(0, 1), (1, 2), (0, 2)])  # a triangle is
    row = [-1, -1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0]
    np.testing.assert_array_equal(rigidity_matrix(square, [(0, 2)]), [row])


def test_bearings_of_a_cube_fix_a_box_and_one_diagonal_the_cube():
    assert not is_infinitesimally_bearing_rigid(CUBE, CUBE_EDGES)
    assert is_infinitesimally_bearing_rigid(CUBE, CUBE_EDGES + [(7, 0)])
    assert not is_infinitesimally_rigid(CUBE, CUBE_EDGES + [(7, 0)])  # not by lengths


@pytest.mark.parametrize("seed", range(4))
def test_in_the_plane_bearings_fix_what_lengths_fix(seed):
    draw = np.random.default_rng(seed)
    points = draw.uniform(-1.0, 1.0, (6, 2))
    every = [(i, j) for i in range(6) for j in range(i)]
    for count in (8, 9, 10):
        pairs = [every[k] for k in sorted(draw.permutation(15)[:count])]
        by_lengths = is_infinitesimally_rigid(points, pairs)
        assert by_lengths == is_infinitesimally_bearing_rigid(points, pairs)


def test_a_flat_start_stays_flat_and_is_said_to():
    control = flying("distance_formation", 8, complete(8), shape="grid", size=2.0, gain=0.05)
    start = anywhere(8)
    start[:, 2] = 1.0
    run = flown(control, start, 2.0)
    np.testing.assert_array_equal(run.hand[:, :, 2], 1.0)
    assert wrong_claims(control, run) == ["start not in one plane"]


def test_a_flat_shape_bends_in_space():
    control = flying("distance_formation", 4, complete(4), shape="circle")
    assert wrong_claims(control, flown(control, anywhere(4), 0.1)) == ["rigid target"]


def test_a_cubic_grid():
    places = formations.shape_places("grid", 9, 2.0, 3)
    assert np.unique(places[:, 0]).size == 3 and np.ptp(places[:, 2]) == 0.0
    places = formations.shape_places("grid", 27, 2.0, 3)
    np.testing.assert_allclose(np.ptp(places, axis=0), 4.0)
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=1e-12)
    assert closest_pair(places)[2] == pytest.approx(2.0)


# Around the laws ---------------------------------------------------------------------------------


def test_a_hull_in_space():
    points = [[0.5, 0.5, 0.5], [0.5, 0.5, 1.25], [0.5, 1.0, 0.5], [2.0, 2.0, 0.5]]
    outside = outside_hull(points, CUBE)
    np.testing.assert_allclose(outside[:3], [-0.5, 0.25, 0.0], atol=1e-12)
    assert 1.0 <= outside[3] <= np.sqrt(2.0)  # beyond an edge: a lower bound


def test_a_hull_that_is_turned_is_as_far():
    angle = 0.371
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    points = np.array([[5.0, -0.01], [5.0, 0.01], [-3.0, -4.0]])
    outside = outside_hull(points @ turn.T, corners @ turn.T)
    np.testing.assert_allclose(outside, [0.01, -0.01, 5.0], atol=1e-4)


@pytest.mark.parametrize("n", [50, 600])
def test_neighbours_in_space(n):
    points = anywhere(n, 10.0)
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    first, second = close_pairs(points, 1.1)
    wanted = np.argwhere(np.triu(apart < 1.1, 1))
    np.testing.assert_array_equal(np.column_stack([first, second]), wanted)
    np.fill_diagonal(apart, np.inf)
    assert closest_pair(points)[2] == pytest.approx(apart.min())
    edges = {edge[:2] for edge in Topology.proximity(points, 1.1).edges}
    assert edges == {(i + 1, j + 1) for i, j in wanted.tolist()}


class Level(PioneerControl):
    """Forgets the height."""

    DIMENSIONS = (2, 3)

    def pointMassLaw(self, points):
        return -points[:, :2]


def test_a_result_of_another_shape_is_reported_in_space():
    control, pose = flying(Level, 3), anywhere(3)
    with pytest.raises(ControlError, match=r"shape \(3, 2\), wanted \(3, 3\): a velocity for each"):
        control.commands(pose)
    Level.pointMassLaw, flat = lambda self, points: None, Level.pointMassLaw
    try:
        with pytest.raises(ControlError, match=r"NoneType, wanted an array \(3, 3\) of velocities"):
            control.commands(pose)
    finally:
        Level.pointMassLaw = flat


def test_commands_of_points_in_space_are_the_laws_velocities():
    control, pose = flying("consensus", 3, complete(3)), anywhere(3)
    np.testing.assert_array_equal(control.commands(pose), control.pointMassLaw(pose))


def test_twists_of_the_hook_in_space():
    class Up(PioneerControl):
        DIMENSIONS = (2, 3)

        def calculateControlLaw(self, pos_map):
            twists = {number: make_twist(0.1, 0.0) for number in pos_map}
            for number, twist in twists.items():
                twist.linear.z = float(number)
            return twists

    wanted = [[0.1, 0.0, 1.0], [0.1, 0.0, 2.0]]
    np.testing.assert_array_equal(flying(Up, 2).commands(anywhere(2)), wanted)


def test_a_law_that_says_nothing_is_planar():
    class Quiet(PioneerControl):
        def pointMassLaw(self, hand):
            return 0.0 * hand

    with pytest.raises(ControlError, match="Quiet: a law for points of 2 dimensions"):
        Quiet([1, 2], team=Flyers(2))
