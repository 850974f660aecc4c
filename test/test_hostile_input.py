"""Input that means harm, or is badly broken: a clear error at once, in bounded memory."""

import os
import tracemalloc

import numpy as np
import pytest

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.parameters import shown, unknown_name
from mrs_simulator.core.reading import ScenarioError, parse_yaml
from mrs_simulator.core.scenario import load_scenario, scenario_from_dict

SMALL = 20e6  # [bytes] far less than what these inputs would fill


def bomb(levels=9, width=9):
    """Return YAML whose last value stands for ``width ** levels`` numbers."""
    lines = ["a0: &a0 [{}]".format(", ".join("1" * width))]
    for level in range(1, levels):
        inner = ", ".join(["*a{}".format(level - 1)] * width)
        lines.append("a{0}: &a{0} [{1}]".format(level, inner))
    return "\n".join(lines + ["poses: *a{}".format(levels - 1)])


def in_little_memory(function):
    tracemalloc.start()
    try:
        function()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "text, said",
    [
        (bomb(), "aliases stand for more than"),
        (bomb(levels=40), "aliases stand for more than"),
        ("a: &a [*a]", "stands for itself"),
        ("a: &a {b: *a}", "stands for itself"),
        ("{}: 1\n{}: 2".format("k" * 500, "k" * 500), "given twice"),
    ],
    ids=["wide", "deep", "list of itself", "mapping of itself", "long key"],
)
def test_aliases_are_bounded(text, said):
    def refused():
        with pytest.raises(ScenarioError, match=said) as caught:
            parse_yaml(text, "file.yaml")
        assert len(str(caught.value)) < 200

    assert in_little_memory(refused) < SMALL


def test_aliases_that_spare_typing_are_read():
    content = parse_yaml("a: &a [1, 2]\nb: [*a, *a]\nc: {y: *a}", "file.yaml")
    assert content == {"a": [1, 2], "b": [[1, 2], [1, 2]], "c": {"y": [1, 2]}}


def test_text_from_elsewhere_is_bounded():
    with pytest.raises(ScenarioError, match="larger than"):
        parse_yaml(" " * 5000000, "stage/scenario")


@pytest.mark.parametrize(
    "value, text",
    [
        ([1, "a", None, {"b": (2.5,)}], "[1, 'a', None, {'b': (2.5,)}]"),
        ([], "[]"),
        ({}, "{}"),
        (None, "nothing given"),
        ("x" * 100, "'" + "x" * 56 + "..."),
    ],
)
def test_values_are_shown_as_they_are_written_and_cut(value, text):
    assert shown(value) == text


def test_no_more_is_made_of_a_value_than_is_shown():
    inner = ["x" * 100000]
    for _ in range(60):
        inner = [inner] * 60
    assert len(shown(inner)) == 60
    assert shown(2**100000) == "a whole number of 100001 bits"
    assert len(unknown_name("file", "k" * 100000, ["a", "b"])) < 200


@pytest.mark.parametrize(
    "topology, said",
    [
        ({"edges": [[1, 9]], "directed": False}, "robot 9, wanted a whole number from 1 to 3"),
        ({"edges": 5, "directed": False}, "edges 5: wanted a list"),
        ({"preset": "random", "probability": 2}, "topology.probability: 2, wanted a number"),
        ({"edges": [[1, 2]], "directd": False}, "unknown 'directd'; did you mean 'directed'"),
    ],
)
def test_a_topology_s_own_mistake_is_told(topology, said):
    poses = [[0, 0, 0], [2, 0, 0], [4, 0, 0]]
    with pytest.raises(ScenarioError, match=said):
        scenario_from_dict({"poses": poses, "topology": topology})


def test_a_proximity_graph_of_many_robots_takes_little_memory():
    points = np.random.default_rng(1).uniform(0.0, 150.0, (1500, 2))
    used = in_little_memory(lambda: Topology.proximity(points, 3.0))
    assert used < SMALL
    near = np.linalg.norm(points[:, np.newaxis] - points[np.newaxis], axis=2) <= 3.0
    pairs = [(i + 1, j + 1) for i, j in np.argwhere(np.triu(near, 1)).tolist()]
    assert [edge[:2] for edge in Topology.proximity(points, 3.0).edges] == pairs


@pytest.mark.parametrize("radius", [1e-300, 1.0, 1e300])
def test_a_proximity_graph_takes_any_radius(radius):
    points = np.array([[0.0, 0.0], [0.0, 1.0], [1e6, 0.0]] * 100)
    points[:, 1] += np.repeat(np.arange(100.0), 3)
    apart = np.linalg.norm(points[:, np.newaxis] - points[np.newaxis], axis=2)
    pairs = np.argwhere(np.triu(apart <= radius, 1)) + 1
    assert [edge[:2] for edge in Topology.proximity(points, radius).edges] == [*map(tuple, pairs)]


@pytest.mark.parametrize("preset", ["complete", "random"])
def test_graphs_of_too_many_pairs_are_refused(preset):
    content = {"robots": 20000, "poses": {"layout": "grid"}, "topology": {"preset": preset}}
    with pytest.raises(ScenarioError, match="topology: 199990000 pairs of robots: wanted at most"):
        scenario_from_dict(content)


@pytest.mark.parametrize(
    "layout",
    [
        {"layout": "random", "min_distance": 1e200},
        {"layout": "random", "size": 1e308},
        {"layout": "grid", "spacing": 1e308},
        {"layout": "line", "spacing": 9e5},
        {"layout": "circle", "radius": 1e300},
    ],
)
def test_a_layout_of_impossible_size_is_refused(layout):
    with pytest.raises(ScenarioError, match="file.yaml: poses"):
        scenario_from_dict({"robots": 5, "poses": layout}, "file.yaml")


def test_pipes_and_devices_are_refused_at_once(tmp_path):
    pipe = str(tmp_path / "pipe.yaml")
    os.mkfifo(pipe)
    for path in (pipe, "/dev/zero"):
        with pytest.raises(ScenarioError, match="is a pipe or a device, wanted a regular file"):
            load_scenario(path)
