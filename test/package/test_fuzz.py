"""Whatever comes in by file or parameter: a clear error or a valid run, never a traceback."""

import os

import numpy as np
import rospy
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mrs_simulator.control.twists import ControlError
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.record.recording import RunError, read_run_csv
from mrs_simulator.ros.node.arguments import parse, scenario_from
from mrs_simulator.ros.node.node_parameters import NODES
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.world.world import World, WorldError

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
QUICK = settings(
    max_examples=60,  # of each; campaigns are begun by test/fuzz/fuzz.py
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
NUMBERS = st.one_of(st.integers(), st.floats(), st.sampled_from([0, -1, 1e-9, 1e300, 2**70]))
PLAIN = st.one_of(st.none(), st.booleans(), NUMBERS, st.text(max_size=8))
VALUES = st.recursive(
    PLAIN,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=6,
)


def valid():
    with open(os.path.join(ROOT, "scenarios", "paper_four.yaml")) as file:
        content = yaml.safe_load(file)
    content["obstacles"] = [
        {"type": "box", "center": [3.0, 3.0], "size": [1.0, 1.0]},
        {"type": "cylinder", "center": [-3.0, 3.0], "radius": 0.5},
        {"type": "wall", "from": [-9.0, -9.0], "to": [9.0, -9.0]},
    ]
    content["topology"] = {"edges": [[1, 2], [2, 3, 0.5]], "directed": True}
    content.update(duration=0.1, seed=1, record_rate=10.0, cmd_vel_timeout=0.6)
    return content


def places(value, path=()):
    """Yield the path of every value inside ``value``."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield path + (key,)
        if isinstance(inner, (dict, list)):
            yield from places(inner, path + (key,))


PLACES = sorted(places(valid()), key=str)


def put(content, path, value):
    for key in path[:-1]:
        content = content[key]
    content[path[-1]] = value


@QUICK
@given(st.sampled_from(PLACES), VALUES)
def test_a_scenario_with_one_value_changed_runs_or_is_refused(path, value):
    content = valid()
    put(content, path, value)
    try:
        scenario = scenario_from_dict(content, "file.yaml")
        if scenario.n > 50:
            return
        experiment = Experiment(
            scenario._replace(duration=min(scenario.duration, 3 * scenario.step))
        )
    except (ScenarioError, WorldError, ValueError) as error:
        assert str(error)
        return
    try:
        for _, pose, command in experiment.samples():
            assert np.isfinite(pose).all() and np.isfinite(command).all()
    except LawFailed as error:
        assert str(error)  # said, with the robots stopped


@QUICK
@given(
    st.dictionaries(st.sampled_from(["k", "T", "l", "c", "closure", "K", ""]), VALUES, max_size=4)
)
def test_parameters_are_taken_or_refused_by_name(values):
    control = Formation(range(1, 4))
    before = control.parameters
    try:
        control.set_parameters(values)
    except ValueError as error:
        assert any(name in str(error) for name in values)
        assert control.parameters == before
        return
    try:
        command = control.commands(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 1.0], [4.0, 1.0, 2.0]]))
    except ControlError as error:  # 1/l and k/T of the smallest numbers are none
        assert "wanted finite numbers" in str(error)
        return
    assert command.shape == (3, 2) and np.isfinite(command).all()


@QUICK
@given(st.lists(st.lists(NUMBERS, max_size=4), max_size=4))
def test_a_team_is_set_or_refused(poses):
    world = World(("pioneer3dx",), [[0.0, 0.0, 0.0]])
    try:
        world.set_team(("pioneer3dx",) * len(poses), poses)
    except (WorldError, ValueError, OverflowError) as error:
        assert str(error)
        assert world.n == 1
        return
    world.step()
    assert world.n == len(poses)


@QUICK
@given(st.lists(st.tuples(st.floats(), st.floats()), min_size=2, max_size=2))
def test_no_command_makes_a_pose_that_is_not_finite(commands):
    world = World(("pioneer3dx",) * 2, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    world.set_commands([0, 1], np.array(commands))
    for _ in range(3):
        world.step()
    assert np.isfinite(world.pose).all() and np.isfinite(world.twist).all()


HEADER = "time,robot,x,y,theta,alpha_x,alpha_y,v,omega\n"
ROWS = st.lists(st.lists(NUMBERS.map(repr), min_size=8, max_size=10).map(",".join), max_size=6)


@QUICK
@given(st.one_of(st.text(max_size=100), ROWS.map(lambda rows: HEADER + "\n".join(rows))))
def test_a_table_is_read_or_refused(tmp_path, text):
    path = tmp_path / "run.csv"
    path.write_bytes(text.encode("utf-8", "replace"))
    try:
        run = read_run_csv(str(path))
    except RunError as error:
        assert "run.csv" in str(error)
        return
    assert run.pose.shape == (len(run.time), len(run.robots), 3)


@QUICK
@given(VALUES)
def test_ros_parameters_are_read_or_refused_by_name(value):
    given_value = rospy.get_param
    rospy.get_param = lambda name, default=None: value
    try:
        for parameter in {each for node in NODES.values() for each in node}:
            try:
                read(parameter, 1.0, n=3)
            except ValueError as error:
                assert parameter.name in str(error)
    finally:
        rospy.get_param = given_value


@QUICK
@given(
    st.dictionaries(
        st.sampled_from(["scenario", "robots", "fidelity", "odometry", "duration"]),
        st.one_of(st.text(max_size=6), NUMBERS.map(str)),
        max_size=2,
    )
)
def test_arguments_are_taken_or_refused(arguments):
    names = dict.fromkeys(("scenario", "robots", "fidelity", "odometry", "duration"), "")
    argv = ["_{}:={}".format(name, value) for name, value in arguments.items()]
    try:
        scenario = scenario_from(parse("", names, argv))
    except (ValueError, OSError) as error:
        assert str(error)
    except SystemExit as ended:  # argparse has said it
        assert ended.code == 2
    else:
        assert scenario.n >= 1
