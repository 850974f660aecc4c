"""Graphs: typed-out matrices, neighbour sums and refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrs_simulator.core.graphs import PRESETS, Topology


def test_path_laplacian_typed_out():
    expected = [[1, -1, 0], [-1, 2, -1], [0, -1, 1]]
    np.testing.assert_array_equal(Topology.preset("path", 3).laplacian(), expected)


def test_rows_hear_columns():
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
        ((1, 1), "does not hear itself"),
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
