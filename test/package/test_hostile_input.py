"""Input that means harm, or is badly broken: a clear error at once, in bounded memory."""

import os
import shutil

import numpy as np
import pytest
import rosbag
import rospy
from memory import peak_of
from std_msgs.msg import String

from mrs_simulator.core.fields import shown, unknown_name
from mrs_simulator.core.graphs import Topology
from mrs_simulator.msg import TeamState
from mrs_simulator.nodes.real import preflight
from mrs_simulator.protocols.marching.law import Marching
from mrs_simulator.record.recording import Recorder, RunError
from mrs_simulator.scenario.reading import ScenarioError, parse_yaml
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.study.results.report import main as report
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.preflight import Check
from mrs_simulator.world.world import World

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

SMALL = 20e6  # [bytes] far less than what these inputs would fill


def bomb(levels=9, width=9):
    """Return YAML whose last value stands for ``width ** levels`` numbers."""
    lines = ["a0: &a0 [{}]".format(", ".join("1" * width))]
    for level in range(1, levels):
        inner = ", ".join(["*a{}".format(level - 1)] * width)
        lines.append("a{0}: &a{0} [{1}]".format(level, inner))
    return "\n".join(lines + ["poses: *a{}".format(levels - 1)])


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

    assert peak_of(refused) < SMALL


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
def test_a_topology_s_own_mistake_is_reported(topology, said):
    poses = [[0, 0, 0], [2, 0, 0], [4, 0, 0]]
    with pytest.raises(ScenarioError, match=said):
        scenario_from_dict({"poses": poses, "topology": topology})


def test_a_proximity_graph_of_many_robots_takes_little_memory():
    points = np.random.default_rng(1).uniform(0.0, 150.0, (1500, 2))
    used = peak_of(lambda: Topology.proximity(points, 3.0))
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


@pytest.mark.parametrize("fidelity", ["kinematic", "point_mass"])
@pytest.mark.parametrize("v, omega", [(1e308, 0.0), (0.0, 1e308), (-1e308, 1e308), (np.nan, 0.0)])
def test_impossible_commands_are_refused(fidelity, v, omega):
    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]], fidelity=fidelity, limits=None)
    world.set_commands([0], np.array([[0.5, 0.0]]))
    world.set_commands([0], np.array([[v, omega]]))
    for _ in range(5):
        world.step()
    assert world.commands.refused.tolist() == [1] and np.isfinite(world.pose).all()
    assert world.pose[0, 0] == pytest.approx(0.05)


def test_a_stopped_march_without_feed_forward_has_no_prediction():
    given = {"gain": 0.0, "feed_forward": False, "path": "line"}
    control = Marching(range(1, 4), Topology.preset("chain", 3), parameters=given)
    start = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert control.prediction(start, np.linspace(0.0, 1.0, 5)) is None
    assert not all(claim.holds for claim in control.claims(start))


# Recordings ----------------------------------------------------------------------------------------


def run_in(directory, robots=2, facts="{}"):
    """Write a run of ``robots`` to ``directory``, with ``facts`` as its run.json; return its path."""
    path = str(directory / "run.csv")
    with Recorder(path, range(1, robots + 1)) as recorder:
        for k in range(5):
            recorder.sample(
                0.1 * k, StateTable(pose=np.zeros((robots, 3)), command=np.zeros((robots, 2)))
            )
    (directory / "run.json").write_text(facts)
    return path


@pytest.mark.parametrize(
    "facts, said",
    [
        ('{"collisions": [], "closest_approach": NaN}', "NaN, wanted a finite number"),
        ('{"collisions": [], "real_time_factor": -Infinity}', "-Infinity, wanted"),
        ('{"collisions": [[NaN, "a", "b", 0, 0]]}', "NaN, wanted a finite number"),
        ('{"collisions": [], "ended": ' + "[" * 500 + "]" * 500 + "}", "ended = "),
        ("[" * 100000, "not the facts of a run"),
    ],
    ids=["nan", "infinite", "nan in a collision", "deep", "too deep"],
)
def test_facts_that_are_none_name_their_file(tmp_path, facts, said):
    with pytest.raises(RunError, match=said) as caught:
        read_run(run_in(tmp_path, facts=facts))
    assert str(tmp_path / "run.json") in str(caught.value) and len(str(caught.value)) < 400


def test_a_run_beside_another_team_s_scenario_is_refused(tmp_path, capsys):
    path = run_in(tmp_path, robots=2, facts='{"collisions": []}')
    scenario = os.path.join(ROOT, "scenarios", "paper_four.yaml")
    shutil.copy(scenario, str(tmp_path / "scenario.yaml"))
    with pytest.raises(SystemExit) as ended:
        report([path, "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert "run.csv: 2 robots, but the scenario" in said and "has 4; wanted the run's own" in said


def test_pipes_are_no_recordings(tmp_path):
    for name in ("run.csv", "run.bag"):
        pipe = str(tmp_path / name)
        os.mkfifo(pipe)
        with pytest.raises(RunError, match="is a pipe or a device, wanted a regular file"):
            read_run(pipe)


def bag_of(path, text=None, poses=((0.0, 0.0, 0.0),)):
    with rosbag.Bag(path, "w") as bag:
        if text is not None:
            bag.write("/stage/scenario", String(data=text), rospy.Time(1))
        for k in range(3):
            x, y, theta = zip(*poses)
            state = TeamState(robot=range(1, len(poses) + 1), x=x, y=y, theta=theta)
            still = [0.0] * len(poses)
            state.vx = state.vy = state.omega = state.command_v = state.command_omega = still
            state.commanded, state.real = [True] * len(poses), [False] * len(poses)
            state.header.stamp = rospy.Time(1 + k)
            bag.write("/stage/state", state, state.header.stamp)
    return path


def test_a_bag_s_scenario_is_bounded_as_a_file_is(tmp_path):
    def refused():
        with pytest.raises(RunError, match="aliases stand for more than") as caught:
            read_run(bag_of(str(tmp_path / "run.bag"), bomb()))
        assert len(str(caught.value)) < 300

    assert peak_of(refused) < SMALL


def test_a_bag_of_impossible_poses_is_refused(tmp_path):
    with pytest.raises(RunError, match="run.bag: at 1.000 s a pose is not finite"):
        read_run(bag_of(str(tmp_path / "run.bag"), poses=[(np.nan, 0.0, 0.0)]))


def test_damaged_bags_are_read_or_refused(tmp_path):
    path = bag_of(str(tmp_path / "run.bag"), poses=[(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
    with open(path, "rb") as file:
        whole = file.read()
    draw = np.random.default_rng(4)
    for _ in range(60):
        damaged = bytearray(whole)
        for place in draw.integers(len(whole), size=draw.integers(1, 20)):
            damaged[place] = draw.integers(256)
        with open(path, "wb") as file:
            file.write(damaged[: len(damaged) - draw.integers(0, 2) * draw.integers(len(damaged))])
        try:
            run = read_run(path)
        except RunError as error:
            assert path in str(error)
        else:
            assert np.isfinite(run.pose).all()


def test_a_preflight_that_cannot_write_its_checks_says_so(monkeypatch, capsys):
    monkeypatch.setattr(preflight.rosgraph, "is_master_online", lambda: True)
    monkeypatch.setattr(preflight, "start_node", lambda name: None)
    monkeypatch.setattr(preflight, "_checked", lambda *given: [Check("distances", True, "")])
    with pytest.raises(SystemExit) as ended:
        preflight.main(["--json", "/dev/full"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == "preflight: /dev/full: No space left on device\n"
