"""Scenario files: what is read, and what is refused with file, key path, came and wanted."""

import contextlib
import glob
import os

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.scenario import (
    Scenario,
    ScenarioError,
    load_scenario,
    scenario_from_dict,
    scenario_from_yaml,
)
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder
from mrs_simulator.scenario.team.layouts import make_layout

SHIPPED = sorted(
    glob.glob(
        os.path.join(
            os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))),
            "scenarios",
            "*.yaml",
        )
    )
)
SMALL = {"poses": [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]}


def with_keys(**keys):
    return scenario_from_dict(dict(SMALL, **keys), "file.yaml")


@pytest.mark.parametrize("path", SHIPPED, ids=os.path.basename)
def test_shipped_scenarios_survive_writing_and_reading(path):
    scenario = load_scenario(path)
    faster = scenario.changed(duration=scenario.duration + 1.0)
    for each in (scenario, faster, scenario):  # which keeps texts of keys that are the same
        whole = yaml.safe_dump(each.to_dict(), sort_keys=False, default_flow_style=None)
        assert each.to_yaml() == whole
    again = scenario_from_yaml(whole)
    assert again.to_dict() == scenario.to_dict()
    np.testing.assert_array_equal(again.poses, scenario.poses)


def test_paper_poses_are_its_hand_points_less_l():
    paper = load_scenario([path for path in SHIPPED if path.endswith("paper.yaml")][0])
    np.testing.assert_allclose(
        paper.poses[:, 0] + 0.05, [10.0, 5.0, 2.0, -5.0, -1.0, 0.0, -10.0], atol=1e-12
    )
    np.testing.assert_allclose(paper.poses[:, 1], [-5.0, -2.0, 8.0, 12.3, 6.0, -5.0, 4.0])
    assert (paper.control.parameters["closure"], paper.fidelity) == ("chain", "kinematic")


def test_everything_that_can_be_said():
    scenario = with_keys(
        title="all",
        robots=2,
        model=["pioneer3dx", "pioneer3dx"],
        fidelity="dynamic",
        limits={"v_max": 1.0, "omega_max": 2.0, "v_accel": 0.5, "omega_accel": 1.0},
        odometry="wheel",
        control={"protocol": "a:B", "rate": 25, "saturation": "team", "parameters": {"gain": 1}},
        topology={"edges": [[1, 2, 0.5]], "directed": False},
        obstacles=[
            {"type": "box", "center": [5, 0], "size": [1, 2], "yaw": 0.5},
            {"type": "cylinder", "center": [0, 5], "radius": 0.3, "name": "tree"},
            {"type": "wall", "from": [-3, -3], "to": [3, -3]},
        ],
        duration=5,
        seed=7,
        speed=0,
        record_rate=25,
        cmd_vel_timeout=1.0,
        step=0.01,
    )
    assert scenario.limits == Limits(1.0, 2.0, 0.5, 1.0)
    assert scenario.topology.adjacency().tolist() == [[0.0, 0.5], [0.5, 0.0]]
    assert scenario.obstacles[0] == Box("box1", 5.0, 0.0, 0.5, 1.0, 2.0, 0.5)
    assert scenario.obstacles[1] == Cylinder("tree", 0.0, 5.0, 0.3, 0.5)
    assert scenario.obstacles[2][1:7] == (0.0, -3.0, 0.0, 6.0, 0.1, 0.5)
    assert (scenario.steps_per_command, scenario.steps_per_record) == (4, 4)
    assert scenario_from_dict(scenario.to_dict()).to_dict() == scenario.to_dict()


@pytest.mark.parametrize(
    "keys, said",
    [
        ({"durration": 5}, r"file.yaml: unknown 'durration'; did you mean 'duration'\?"),
        ({"duration": -1}, r"file.yaml: duration: -1, wanted a number above 0"),
        ({"duration": "long"}, r"duration: 'long', wanted a number"),
        ({"duration": True}, r"duration: True, wanted a number"),
        ({"duration": float("nan")}, r"duration: nan, wanted"),
        ({"duration": 10**400}, r"duration: 1000.*wanted"),
        ({"seed": 1.5}, r"seed: 1.5, wanted a whole number"),
        ({"speed": -1}, r"speed: -1, wanted a number of at least 0"),
        ({"poses": [[0, 0]]}, r"poses\[0\]: \[0, 0\], wanted a list of 3 numbers"),
        ({"poses": [[0, 0, None]]}, r"poses\[0\]\[2\]: nothing given, wanted a number"),
        ({"poses": [[0, 0, 0], [1e9, 0, 0]]}, r"poses\[1\]: .*wanted within 1e\+06 m"),
        ({"poses": []}, r"poses: \[\], wanted a list"),
        ({"robots": 3}, r"robots: 3, but poses has 2"),
        ({"model": ["pioneer3dx"]}, r"model: .*wanted one kind or a list of 2"),
        ({"fidelity": "exact"}, r"fidelity: 'exact', wanted one of kinematic, dynamic, point_mass"),
        (
            {"odometry": "wheel", "fidelity": "point_mass"},
            "odometry: wheel, but point masses have no",
        ),
        ({"limits": "slow"}, r"limits: 'slow', wanted one of firmware, top, none"),
        ({"limits": {"v_max": 1}}, r"limits.omega_max: nothing given, wanted a number above 0"),
        ({"control": {"rate": 0}}, r"control.rate: 0, wanted a number from 0.1 to 1000"),
        ({"control": {"gain": 1}}, r"control: unknown 'gain'"),
        ({"control": {"parameters": {"k": [1]}}}, r"control.parameters.k: \[1\], wanted"),
        (
            {"control": {"parameters": {"l": 0}}},
            r"control.parameters.l: 0, wanted a number above 0",
        ),
        ({"control": []}, r"control: \[\], wanted a mapping"),
        ({"step": 0.03}, r"step: 0.03 s, wanted the command period"),
        ({"topology": {"edges": [[1, 3]]}}, r"topology: edge \[1, 3\]: robot 3"),
        ({"topology": {"preset": "rung"}}, r"topology.preset: 'rung', wanted one of"),
        (
            {"obstacles": [{"type": "box", "name": "robot2", "center": [5, 5], "size": [1, 1]}]},
            r"obstacles\[0\].name: 'robot2' is a robot's",
        ),
        ({"obstacles": [{"type": "ball"}]}, r"obstacles\[0\].type: 'ball', wanted one of"),
        (
            {"obstacles": [{"type": "box", "center": [0, 0], "size": [0, 1]}]},
            r"size\[0\]: 0, wanted a number above 0",
        ),
        ({"obstacles": [{"type": "wall", "from": [0, 0], "to": [0, 0]}]}, r"the same point"),
    ],
)
def test_mistakes_are_named(keys, said):
    with pytest.raises(ScenarioError, match=said):
        with_keys(**keys)


@pytest.mark.parametrize(
    "text, said",
    [
        ("poses: [[0, 0, 0]\ntitle: x", "line 2: not valid YAML"),
        ("seed: 1\nseed: 2", "line 2: not valid YAML: key 'seed' is given twice"),
        ("- 1", "wanted a mapping of keys"),
        ("", "wanted a mapping"),
        ("poses: !!python/object/apply:os.system ['true']", "not valid YAML"),
        ("? [1, 2]\n: 3", "not valid YAML"),
        ("a: *b", "not valid YAML"),
    ],
)
def test_files_that_are_no_scenario(tmp_path, text, said):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError, match=said) as caught:
        load_scenario(str(path))
    assert str(path) in str(caught.value)


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(ScenarioError, match="missing.yaml: cannot be read: No such file"):
        load_scenario(str(tmp_path / "missing.yaml"))
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_scenario(str(tmp_path / "binary.yaml"))
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_scenario(str(tmp_path))


def test_exponents_without_a_point_are_numbers():
    assert scenario_from_yaml("poses: [[0, 0, 0]]\nduration: 1e2").duration == 100.0


def test_number_of_robots_changes_the_poses():
    scenario = with_keys()
    assert scenario.with_robots(1).poses.tolist() == [[0.0, 0.0, 0.0]]
    more = scenario.with_robots(60)
    assert more.n == len(more.kinds) == 60
    apart = np.linalg.norm(more.poses[:, None, :2] - more.poses[None, :, :2], axis=2)
    assert apart[np.triu_indices(60, 1)].min() >= 1.5
    np.testing.assert_array_equal(more.poses, scenario.with_robots(60).poses)
    with pytest.raises(ScenarioError, match="robots = 0"):
        scenario.with_robots(0)


def test_layouts():
    np.testing.assert_allclose(make_layout("line", 3, spacing=2.0)[:, 0], [2.0, 0.0, -2.0])
    circle = make_layout("circle", 4, radius=3.0)
    np.testing.assert_allclose(circle[1], [0.0, 3.0, -np.pi], atol=1e-12)
    assert circle[0, 2] == pytest.approx(np.pi / 2.0)
    assert len(make_layout("grid", 200)) == 200
    scenario = scenario_from_yaml("robots: 5\nposes: {layout: random, min_distance: 2}\nseed: 3")
    assert scenario.n == 5
    with pytest.raises(ScenarioError, match="poses: random layout: no room for robot"):
        scenario_from_yaml("robots: 50\nposes: {layout: random, size: 2}")
    with pytest.raises(ScenarioError, match="unknown 'radios'; did you mean 'radius'"):
        scenario_from_yaml("robots: 5\nposes: {layout: circle, radios: 2}")


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(sorted(Scenario._fields) + ["robots", "rate", "edges", "type"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)
KEYS = st.sampled_from(sorted(set(Scenario._fields) - {"path", "kinds"}) + ["robots", "model"])
QUICK = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@QUICK
@given(KEYS, plain)
def test_any_value_of_any_key_is_read_or_refused(key, value):
    try:
        scenario = with_keys(**{key: value})
    except ScenarioError as error:
        assert str(error).startswith("file.yaml")
    else:
        assert scenario_from_dict(scenario.to_dict()).to_dict() == scenario.to_dict()


@QUICK
@given(plain)
def test_any_content_is_read_or_refused(content):
    text = yaml.safe_dump(content)
    with contextlib.suppress(ScenarioError):
        scenario_from_yaml(text, "file.yaml")


@QUICK
@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(text):
    with contextlib.suppress(ScenarioError):
        scenario_from_yaml(text, "file.yaml")


def test_random_and_proximity_topologies_are_made_from_seed_and_poses():
    content = {"poses": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], "seed": 3}
    near = scenario_from_dict(dict(content, topology={"preset": "proximity", "radius": 1.5}))
    assert [edge[:2] for edge in near.topology.edges] == [(1, 2), (2, 3)]
    random = dict(content, topology={"preset": "random", "probability": 0.1})
    first, second = scenario_from_dict(random), scenario_from_dict(random)
    assert first.topology.edges == second.topology.edges and first.topology.has_spanning_tree()
    with pytest.raises(ScenarioError, match="topology.radius"):
        scenario_from_dict(dict(content, topology={"preset": "proximity", "radius": -1}))
    again = scenario_from_dict(first.to_dict())
    assert again.topology.edges == first.topology.edges


@pytest.mark.parametrize(
    "given, directed, count",
    [
        ({"preset": "ring"}, False, 4),
        ({"preset": "cycle", "directed": False}, False, 4),
        ({"preset": "lattice"}, False, 4),
        ({"preset": "star", "directed": True}, True, 3),
        ({"preset": "k_nearest", "k": 2}, True, 8),
        ({"preset": "k_nearest", "k": 1, "directed": False}, False, 3),
        ({"preset": "erdos_renyi", "probability": 1.0}, False, 6),
        ({"preset": "erdos_renyi", "probability": 1.0, "directed": True}, True, 12),
    ],
)
def test_graphs_by_name_directed_or_not(given, directed, count):
    poses = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.1, 0.0, 0.0], [6.3, 0.0, 0.0]]
    found = scenario_from_dict({"poses": poses, "topology": given}).topology
    assert (found.directed, len(found.edges)) == (directed, count)


@pytest.mark.parametrize(
    "given, said",
    [
        ({"preset": "random", "directed": True}, "directed: true, but random is undirected"),
        ({"preset": "k_nearest"}, "k: nothing given, wanted a whole number"),
        ({"preset": "k_nearest", "k": 2}, "k = 2: wanted from 1 to 1"),
        ({"preset": "ring", "k": 2}, "unknown 'k'"),
    ],
)
def test_graphs_that_cannot_be_are_refused(given, said):
    with pytest.raises(ScenarioError, match=said):
        scenario_from_dict({"poses": [[0, 0, 0], [2, 0, 0]], "topology": given})
