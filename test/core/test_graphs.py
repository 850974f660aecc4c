"""Graphs: typed-out matrices, neighbour sums and refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrs_simulator.core.graphs import PRESETS, Topology
from mrs_simulator.core.spectra import (
    algebraic_connectivity,
    is_balanced,
    is_infinitesimally_rigid,
    laplacian_eigenvalues,
    left_null_vector,
    rigidity_matrix,
    spectral_radius,
)


def test_path_laplacian_typed_out():
    expected = [[1, -1, 0], [-1, 2, -1], [0, -1, 1]]
    np.testing.assert_array_equal(Topology.preset("path", 3).laplacian(), expected)


def test_rows_receive_from_columns():
    graph = Topology(3, [(1, 2), (3, 1, 2.5)])
    np.testing.assert_array_equal(graph.adjacency(), [[0, 1, 0], [0, 0, 0], [2.5, 0, 0]])
    assert graph.neighbours(3) == [1]
    assert graph.neighbours(2) == []
    np.testing.assert_array_equal(graph.in_degree(), [1.0, 0.0, 2.5])


@pytest.mark.parametrize("name, edges", [("chain", 4), ("cycle", 5), ("path", 8), ("star", 8)])
def test_presets_of_five_robots(name, edges):
    assert np.count_nonzero(Topology.preset(name, 5).adjacency()) == edges


def test_complete_preset():
    expected = np.ones((4, 4)) - np.eye(4)
    np.testing.assert_array_equal(Topology.preset("complete", 4).adjacency(), expected)


@pytest.mark.parametrize("name", PRESETS)
def test_one_robot_alone(name):
    np.testing.assert_array_equal(Topology.preset(name, 1).laplacian(), [[0.0]])


@given(st.data(), st.integers(1, 8))
def test_neighbour_sum_is_the_product_with_the_adjacency(data, n):
    pairs = st.tuples(st.integers(1, n), st.integers(1, n), st.floats(0.1, 10.0))
    found = data.draw(st.lists(pairs, max_size=20, unique_by=lambda edge: edge[:2]))
    graph = Topology(n, [edge for edge in found if edge[0] != edge[1]])
    values = np.arange(2.0 * n).reshape(n, 2) - 3.0
    np.testing.assert_allclose(graph.neighbour_sum(values), graph.adjacency() @ values, atol=1e-9)
    np.testing.assert_allclose(graph.laplacian().sum(axis=1), 0.0, atol=1e-9)


@pytest.mark.parametrize(
    "edge, said",
    [
        ((1, 5), "robot 5, wanted a whole number from 1 to 3"),
        ((1, 1), "no neighbour of its own"),
        ((1, 2, -1.0), "weight -1.0, wanted above 0"),
        ((1, 2, float("nan")), "weight nan"),
        ((1,), "wanted \\[i, j\\]"),
        ("12", "wanted \\[i, j\\]"),
        ((True, 2), "robot True"),
    ],
)
def test_bad_edges_are_named(edge, said):
    with pytest.raises(ValueError, match=said):
        Topology(3, [edge])


def test_an_edge_twice_is_refused():
    with pytest.raises(ValueError, match="edge 2-1: given twice"):
        Topology(3, [(1, 2), (2, 1)], directed=False)


def test_the_mean_of_what_is_received():
    values = np.array([[1.0, 0.0], [2.0, 4.0], [6.0, 8.0]])
    chain = Topology.preset("chain", 3)
    np.testing.assert_array_equal(chain.neighbour_mean(values), values[[1, 2, 2]])
    # Robot 1 receives from 2 and, with thrice the weight, from 3; robot 3 from none.
    weighted = Topology(3, [(1, 2), (1, 3, 3.0), (2, 1, 0.5)])
    np.testing.assert_allclose(
        weighted.neighbour_mean(values), [[5.0, 7.0], [1.0, 0.0], [6.0, 8.0]], atol=1e-12
    )


# Quantities of theorems, typed out.


@pytest.mark.parametrize(
    "name, n, slowest, largest",
    [
        ("path", 3, 1.0, 3.0),
        ("path", 4, 2.0 - 2.0**0.5, 2.0 + 2.0**0.5),  # 2 (1 - cos(k pi/4))
        ("star", 5, 1.0, 5.0),
        ("complete", 4, 4.0, 4.0),
        ("cycle", 4, 1.0, 2.0),  # directed: 1 - i, 2, 1 + i
        ("cycle", 6, 0.5, 2.0),  # 1 - cos(pi/3)
        ("chain", 3, 1.0, 1.0),
        ("path", 1, 0.0, 0.0),
    ],
)
def test_lambda_2_and_lambda_max(name, n, slowest, largest):
    graph = Topology.preset(name, n)
    assert algebraic_connectivity(graph) == pytest.approx(slowest, abs=1e-7)
    assert spectral_radius(graph) == pytest.approx(largest, abs=1e-7)


def test_the_left_null_vector():
    np.testing.assert_allclose(left_null_vector(Topology.preset("chain", 3)), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(left_null_vector(Topology.preset("star", 4)), [0.25] * 4, atol=1e-12)
    # Robot 1 hears 2 with weight 1, 2 hears 1 with weight 3: w_1 = 3 w_2; robot 3 decides nothing.
    weighted = Topology(3, [(1, 2), (2, 1, 3.0), (3, 1)])
    np.testing.assert_allclose(left_null_vector(weighted), [0.75, 0.25, 0.0], atol=1e-12)
    assert not is_balanced(weighted) and is_balanced(Topology.preset("cycle", 5))
    with pytest.raises(ValueError, match="no spanning tree"):
        left_null_vector(Topology(3, [(1, 2)]))


@pytest.mark.parametrize(
    "n, edges, holds",
    [
        (1, [], True),
        (3, [(1, 2), (2, 3)], True),
        (3, [(1, 2), (1, 3)], False),  # neither of those heard hears the other
        (3, [(2, 1), (3, 1)], True),
        (3, [(1, 2)], False),
        (4, [(1, 2), (2, 1), (3, 4), (4, 3)], False),
        (3, [(1, 2), (3, 2), (2, 3)], True),
    ],
)
def test_spanning_trees(n, edges, holds):
    assert Topology(n, edges).has_spanning_tree() is holds


def test_rigidity():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    sides = [(0, 1), (1, 2), (2, 3), (3, 0)]
    expected = [-2, 0, 2, 0, 0, 0, 0, 0]
    np.testing.assert_array_equal(rigidity_matrix(square, sides)[0], expected)
    assert not is_infinitesimally_rigid(square, sides)
    assert is_infinitesimally_rigid(square, sides + [(0, 2)])  # 2n - 3 = 5 edges
    # As many edges, and one robot can turn about another.
    assert not is_infinitesimally_rigid(square[[0, 1, 2, 3]], [(0, 1), (1, 2), (0, 2), (2, 3)])
    # Three robots on one line: rigid, but not to first order.
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert not is_infinitesimally_rigid(line, [(0, 1), (1, 2), (0, 2)])


def test_quantities_are_computed_once():
    graph = Topology.preset("path", 5)
    assert laplacian_eigenvalues(graph) is laplacian_eigenvalues(graph)
    with pytest.raises(ValueError):
        left_null_vector(graph)[0] = 1.0


def arcs(graph):
    """Return who hears whom, (i, j) from 1, sorted."""
    return [(int(i) + 1, int(j) + 1) for i, j in zip(*graph.arcs[:2])]


@pytest.mark.parametrize(
    "name, n, directed, expected",
    [
        ("ring", 3, None, [(1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 2)]),
        ("ring", 2, None, [(1, 2), (2, 1)]),
        ("cycle", 2, None, [(1, 2), (2, 1)]),
        ("ring", 3, True, [(1, 2), (2, 3), (3, 1)]),
        ("cycle", 3, False, [(1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 2)]),
        ("path", 3, True, [(1, 2), (2, 3)]),
        ("star", 3, True, [(2, 1), (3, 1)]),
        ("complete", 3, True, [(1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 2)]),
        # 1 2 3 / 4 5
        ("lattice", 5, True, [(1, 2), (1, 4), (2, 3), (2, 5), (4, 5)]),
    ],
)
def test_presets_typed_out_directed_or_not(name, n, directed, expected):
    assert arcs(Topology.preset(name, n, directed)) == expected


def test_a_ring_of_six_has_the_eigenvalues_of_the_circulant():
    values = laplacian_eigenvalues(Topology.preset("ring", 6))
    np.testing.assert_allclose(values, [0.0, 1.0, 1.0, 3.0, 3.0, 4.0], atol=1e-12)
    # Three by three: sums of 0, 1, 3, those of a path of three.
    values = laplacian_eigenvalues(Topology.preset("lattice", 9))
    np.testing.assert_allclose(values, [0, 1, 1, 2, 3, 3, 4, 4, 6], atol=1e-12)


def test_each_receives_from_its_nearest_typed_out():
    points = [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [3.5, 0.0]]
    graph = Topology.k_nearest(points, 1)
    assert arcs(graph) == [(1, 2), (2, 1), (3, 4), (4, 3)] and graph.directed
    assert arcs(Topology.k_nearest(points, 2))[2:4] == [(2, 1), (2, 3)]
    undirected = Topology.k_nearest(points, 2, directed=False)
    assert [edge[:2] for edge in undirected.edges] == [(1, 2), (1, 3), (2, 3), (2, 4), (3, 4)]
    with pytest.raises(ValueError, match="k = 4: wanted from 1 to 3"):
        Topology.k_nearest(points, 4)


def test_erdos_renyi_has_its_share_of_the_pairs():
    for directed, pairs in ((True, 40 * 39), (False, 40 * 39 // 2)):
        graph = Topology.erdos_renyi(40, 0.3, 5, directed)
        assert graph.directed is directed
        assert abs(len(graph.edges) / pairs - 0.3) < 0.05
    assert (
        Topology.erdos_renyi(5, 0.0).edges == [] and len(Topology.erdos_renyi(5, 1.0).edges) == 10
    )


def test_the_former_name_of_weighted_neighbours_warns():
    graph = Topology(3, [[1, 2, 0.5], [1, 3, 2.0]])
    assert graph.weighted_neighbours(0) == [(1, 0.5), (2, 2.0)]
    with pytest.warns(FutureWarning, match="weighted_neighbours"):
        assert graph.heard_by(0) == [(1, 0.5), (2, 2.0)]
