"""Parameters of the nodes: declared once, documented, checked; misspelt ones do not go unnoticed."""

import glob
import os
import re
import xml.etree.ElementTree as ElementTree

import pytest
from ros_fixtures import log_of, wait_until

from mrs_simulator.core.fields import Field
from mrs_simulator.nodes.control import common_frame
from mrs_simulator.ros.node import node_parameters, unknown_parameters
from mrs_simulator.ros.node.arguments import parse
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.study.run import preflight

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


@pytest.mark.parametrize(
    "argument, said",
    [
        ("_v_mx:=0.2", "unknown 'v_mx'; did you mean 'v_max'?"),
        ("_geofense:=[0, 0, 1, 1]", "did you mean 'geofence'?"),
        ("_colour:=red", "unknown 'colour' [(]known: autostart, "),
        ("_gian:=1", "did you mean 'gain'?"),
        ("scenaro:=x.yaml", "would rename a topic; for the parameter wanted _scenario:=x.yaml"),
        ("v_max:=0.2", "wanted _v_max:=0.2"),
    ],
)
def test_a_name_that_nothing_reads_is_refused(monkeypatch, argument, said):
    monkeypatch.setattr("sys.argv", ["node", "--robots", "4", argument])
    with pytest.raises(ValueError, match=said):
        unknown_parameters.refuse_unknown(["gain"])


def test_a_law_of_ones_own_may_read_more(monkeypatch):
    monkeypatch.setattr("sys.argv", ["node", "_colour:=red"])
    unknown_parameters.refuse_unknown(["gain"], foreign=True)
    monkeypatch.setattr("sys.argv", ["node", "_v_mx:=0.2"])
    with pytest.raises(ValueError, match="did you mean 'v_max'"):
        unknown_parameters.refuse_unknown(["gain"], foreign=True)


def test_parameters_remappings_and_what_roslaunch_adds_are_taken(monkeypatch):
    given = (
        "__name:=n __log:=l _v_max:=0.2 _gain:=1 _scenario:=x robot1/odom:=/a /b:=/c odom:=d tf:=e"
    )
    monkeypatch.setattr("sys.argv", ["node", *given.split()])
    unknown_parameters.refuse_unknown(["gain"])


def sources():
    """Yield path and text of each module of the nodes."""
    for room in ("nodes", "ros"):
        pattern = os.path.join(ROOT, "src", "mrs_simulator", room, "**", "*.py")
        for path in glob.glob(pattern, recursive=True):
            with open(path, encoding="utf-8") as file:
                yield os.path.relpath(path, ROOT), file.read()


def test_every_parameter_is_declared_and_every_declared_one_is_read():
    declared = {
        name: value for name, value in vars(node_parameters).items() if isinstance(value, Field)
    }
    listed = [parameter for node in node_parameters.NODES.values() for parameter in node]
    for name, parameter in declared.items():
        assert any(parameter is each for each in listed), name
    texts = {path: text for path, text in sources() if not path.endswith("node_parameters.py")}
    for name in set(declared) - {"ONE_FOR_EACH"}:  # LOCKSTEP in other words
        assert any(re.search(r"\b{}\b".format(name), text) for text in texts.values()), name
    for path, text in texts.items():
        assert not re.search(r'_param\(\s*"~\w', text), path


def test_launch_files_set_what_their_nodes_read():
    for path in glob.glob(os.path.join(ROOT, "launch", "*.launch")):
        for node in ElementTree.parse(path).getroot().iter("node"):
            if node.get("pkg") == "mrs_simulator" and node.get("type") in node_parameters.NODES:
                names = {parameter.name for parameter in node_parameters.NODES[node.get("type")]}
                given = {param.get("name") for param in node.iter("param")}
                # The stage reads where real robots are as the controller does.
                assert given <= names | {"frame_source"}, (path, node.get("type"))


def test_defaults_and_choices_are_those_of_what_reads_them():
    assert set(node_parameters.FRAME_SOURCE.choices) == set(common_frame.SOURCES)
    assert node_parameters.PLACE_TOLERANCE.default == preflight.PLACE_TOLERANCE
    assert node_parameters.LEAST_DISTANCE.default == preflight.MIN_DISTANCE


def test_help_tells_arguments_and_parameters(capsys):
    with pytest.raises(SystemExit):
        parse("The stage.", {"scenario": "a file"}, ["--help"], "stage")
    said = capsys.readouterr().out
    assert "--scenario SCENARIO" in said and "  odom_rate: a number above 0 [Hz]\n" in said
    assert "lockstep: true or false, or auto" in said and "`" not in said


@pytest.mark.parametrize(
    "parameter, given, value",
    [
        (node_parameters.ODOM_TIMEOUT, None, 0.5),
        (node_parameters.ODOM_TIMEOUT, "", 0.5),
        (node_parameters.ODOM_TIMEOUT, 2, 2.0),
        (node_parameters.LOCKSTEP, "auto", "auto"),
        (node_parameters.GEOFENCE, "0, 1, 2, 3", (0.0, 1.0, 2.0, 3.0)),
        (node_parameters.POSE_TOPIC, "/r{}/p", "/r{}/p"),
        (node_parameters.REAL, 2, "2"),
    ],
)
def test_values_are_read_as_they_are_declared(monkeypatch, parameter, given, value):
    monkeypatch.setattr(
        "rospy.get_param", lambda name, default=None: default if given is None else given
    )
    assert read(parameter) == value


@pytest.mark.parametrize(
    "parameter, given, wanted",
    [
        (node_parameters.RATE, 1e9, "wanted a number from 0.1 to 1000 [Hz]"),
        (node_parameters.ODOM_TIMEOUT, 0, "wanted a number above 0 [s]"),
        (node_parameters.DEADBAND, True, "wanted a number of at least 0 [m/s, rad/s]"),
        (node_parameters.DRY_RUN, "auto", "wanted true or false"),
        (node_parameters.LOCKSTEP, "maybe", "wanted true or false, or auto"),
        (node_parameters.FRAME_SOURCE, "gps", "wanted one of odometry, scenario, first, tf"),
        (node_parameters.ODOM_TOPIC, "/odom", "wanted one {} for the robot's number"),
        (node_parameters.GEOFENCE, [1, 2, 3], "wanted a list of 4 or 6 numbers [m]"),
        (node_parameters.GEOFENCE, 3, "wanted a list of 4 or 6 numbers [m]"),
    ],
)
def test_values_that_cannot_be_are_refused_by_name(monkeypatch, parameter, given, wanted):
    monkeypatch.setattr("rospy.get_param", lambda name, default=None: given)
    monkeypatch.setattr("rospy.resolve_name", lambda name: name.replace("~", "/node/"))
    text = "parameter /node/{} = {!r}: {}".format(parameter.name, given, wanted)
    with pytest.raises(ValueError, match=re.escape(text)):
        read(parameter)


def test_the_control_node_refuses_and_warns(ros):
    misspelt = ros.node("pioneer_control", "_v_mx:=0.2")
    assert misspelt.wait(60) == 2
    assert "pioneer_control: _v_mx:=0.2: unknown 'v_mx'" in log_of(misspelt)
    ros.call("rosparam", "set", "/pioneer_control/geofense", "1")
    ros.call("rosparam", "set", "/pioneer_control/gain", "1")
    control = ros.node("pioneer_control", "_k:=0.03")
    warning = "parameter /pioneer_control/geofense: nothing reads it; did you mean geofence?"
    wait_until(lambda: warning in log_of(control))
    assert "/gain" not in log_of(control)
