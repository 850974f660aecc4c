"""Every way in, as a function of bytes: it returns, or raises what a user may be told."""

import io
import json
import os
import shlex
import tempfile

import genpy
import numpy as np
import yaml

from mrs_simulator.record.recording import RunError
from mrs_simulator.ros.message_forms import messages
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry, QuickTwist
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.scenario.scenario import scenario_from_yaml
from mrs_simulator.srv import SetTeamRequest
from mrs_simulator.study.results.report import judged, read_run
from mrs_simulator.study.run.experiment import Experiment, LawFailed
from mrs_simulator.vehicles import kind
from mrs_simulator.world.world import World

MOST_ROBOTS = 40  # [-] of a scenario that is also run
MOST_WITH_FORCES = 5  # [-] the same with forces, of which a step costs more
ALL_AXES = [part + "." + axis for part in ("linear", "angular") for axis in "xyz"]
STEPS = 3  # [-] of such a run
LONGEST_SAID = 2000  # [characters] of an error's message
HERE = os.path.dirname(os.path.abspath(__file__))
DATA = os.path.join(os.path.dirname(HERE), "data", "first_version")


class Wrong(AssertionError):
    """What the product must never do with an input."""


def scenario(content):
    """Read a scenario, write it, read it again, and run its first steps."""
    # Protocols by name run code: a fuzzer may make names, but no files.
    read = scenario_from_yaml(content.decode("utf-8", "replace"), "file.yaml")
    again = scenario_from_yaml(read.to_yaml(), "again.yaml")
    if again.to_dict() != read.to_dict():
        raise Wrong("written and read again it is another scenario")
    if read.n > (MOST_WITH_FORCES if read.fidelity == "dynamic" else MOST_ROBOTS):
        return
    experiment = Experiment(read._replace(duration=STEPS * read.step))
    try:
        for _, pose, command in experiment.samples():
            _wanted_finite(pose, command)
    except LawFailed as error:
        _wanted_short(error)


def robot_kind(content):
    """Read a kind file and move such a robot."""
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "mine.yaml")
        _write(path, content)
        kind(path)
        _moved((path,), np.ones(6))


def urdf(content):
    """Import a description as a robot of one's own."""
    with tempfile.TemporaryDirectory() as directory:
        _write(os.path.join(directory, "robot.urdf"), content)
        path = os.path.join(directory, "mine.yaml")
        limits = {"linear.x": {"max": 0.5}, "angular.z": {"max": 1.0}}
        described = {"import": {"urdf": "robot.urdf"}, "limits": {"firmware": limits}}
        _write(path, yaml.safe_dump(described).encode())
        kind(path)


def run_csv(content):
    """Read a run and judge it by what needs no theory."""
    _judge({"run.csv": content, "run.json": b'{"collisions": []}'})


def run_json(content):
    """Read the facts beside a run."""
    _judge({"run.csv": _read(os.path.join(DATA, "run.csv")), "run.json": content})


def bag(content):
    """Read a run from a bag."""
    _judge({"run.bag": content})


def argument(content):
    """Parse a command line, of which the characters of a shell are taken away."""
    try:
        words = shlex.split(content.decode("utf-8", "replace"))
    except ValueError:
        return
    words = [word for word in words if "\0" not in word and not word.startswith(("--dir", "--h"))]
    try:
        # File names of the fuzzer's making would be opened wherever they lead.
        scenario_from(parse("", {**RUN_ARGUMENTS, "scenario": ""}, words))
    except SystemExit as ended:
        if ended.code != 2:
            raise Wrong("exit code {}".format(ended.code)) from ended


def odometry(content):
    """Read the bytes of a nav_msgs/Odometry."""
    _deserialize(PlanarOdometry(), content)


def twist(content):
    """Read the bytes of a geometry_msgs/Twist, and obey it on the ground, in the air and in the water."""
    message = QuickTwist()
    _deserialize(message, content)
    for name in ("pioneer3dx", "crazyflie2", "heron"):
        _moved((name,), np.array(message.values), limits=None)
    for name in ("ardrone2", "otter"):
        _moved((name,), np.array(message.values), fidelity="dynamic")


def message(content):
    """Read the bytes of one of the package's messages, named by the first of them."""
    kinds = list(READERS)
    received = kinds[content[0] % len(kinds)]() if content else kinds[0]()
    _deserialize(received, content[1:])
    READERS[type(received)](received)


def _team_asked(request):
    kinds, poses, z = messages.read_robot_specs(request.robots, "pioneer3dx")
    if not set(kinds) <= {"pioneer3dx", "crazyflie2"} or len(kinds) > MOST_ROBOTS:
        return
    world = World(kinds, poses, z=z)
    world.step()
    _wanted_finite(world.pose, world.twist)


def _team_told(command):
    messages.read_answered(command)
    messages.read_team_command(command)


READERS = {
    messages.TeamOdometry: messages.read_odometry,
    messages.TeamCommand: _team_told,
    messages.TeamState: messages.read_state,
    messages.StageStatus: messages.read_stage_status,
    messages.ControlStatus: messages.read_control_status,
    messages.Collision: messages.read_collision,
    SetTeamRequest: _team_asked,
}


INPUTS = {
    "scenario": scenario,
    "kind": robot_kind,
    "urdf": urdf,
    "run_csv": run_csv,
    "run_json": run_json,
    "bag": bag,
    "argument": argument,
    "odometry": odometry,
    "twist": twist,
    "message": message,
}


def check(name, content):
    """Give ``content`` to the input called ``name``; raises whatever a user must never meet."""
    try:
        INPUTS[name](content)
    except (ValueError, OSError) as error:  # ScenarioError, RunError, WorldError and their like
        if isinstance(error, UnicodeError) or not str(error):
            raise
        _wanted_short(error)
    except genpy.DeserializationError:  # rospy drops such a message and says so
        pass


def _moved(kinds, values, **given):
    """Tell a robot the six ``values`` of a Twist, in the middle of the air where it can be there."""
    world = World(kinds, [[0.0, 0.0, 0.0]], z=[0.0], **given)
    if world.team.airborne.any():
        world = World(kinds, [[0.0, 0.0, 0.0]], z=[5.0], **given)
    columns = [ALL_AXES.index(axis) for axis in world.team.axes]
    world.set_commands([0], values[np.newaxis, columns])
    for _ in range(STEPS):
        world.step()
    _wanted_finite(world.pose, world.twist)
    if world.spatial is not None:
        _wanted_finite(*world.spatial)


def _deserialize(message, content):
    try:
        message.deserialize(content)
    except (genpy.DeserializationError, UnicodeDecodeError):
        raise genpy.DeserializationError("refused") from None


def _judge(files):
    with tempfile.TemporaryDirectory() as directory:
        for name, content in files.items():
            _write(os.path.join(directory, name), content)
        path = os.path.join(directory, next(iter(files)))
        try:
            run = read_run(path)
        except RunError as error:
            if directory not in str(error):
                raise Wrong("the error names no file: {}".format(error)) from error
            raise
        verdict, _ = judged(run)
        json.dump(verdict, io.StringIO(), allow_nan=False)


def _write(path, content):
    with open(path, "wb") as file:
        file.write(content)


def _read(path):
    with open(path, "rb") as file:
        return file.read()


def _wanted_finite(*arrays):
    if not all(np.isfinite(array).all() for array in arrays):
        raise Wrong("a value that is not finite")


def _wanted_short(error):
    if len(str(error)) > LONGEST_SAID:
        raise Wrong("a message of {} characters".format(len(str(error))))


def seeds(name):
    """Return what the fuzzer begins with: the kept corpus, and files of the product."""
    folder = os.path.join(HERE, "corpus", name)
    paths = [os.path.join(folder, file) for file in sorted(os.listdir(folder))]
    root = os.path.dirname(os.path.dirname(HERE))
    more = {
        "scenario": os.path.join(root, "scenarios"),
        "kind": os.path.join(root, "src", "mrs_simulator", "vehicles", "kinds"),
        "urdf": os.path.join(root, "src", "mrs_simulator", "vehicles", "kinds"),
        "bag": DATA,
        "run_csv": DATA,
        "run_json": DATA,
    }.get(name)
    ending = {"run_csv": ".csv", "run_json": "run.json", "urdf": ".urdf", "bag": ".bag"}
    if more:
        wanted = ending.get(name, ".yaml")
        paths += [
            os.path.join(more, file) for file in sorted(os.listdir(more)) if file.endswith(wanted)
        ]
    return [_read(path) for path in paths]


def keep(name, content, label):
    """Keep ``content`` in the corpus, so that it is tried again with every test; return its path."""
    path = os.path.join(HERE, "corpus", name, label)
    _write(path, content)
    return path
