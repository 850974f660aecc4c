"""A parameter that is misspelt on a node's command line, or on the server, does not go unnoticed."""

import glob
import os
import re

import pytest
from ros_fixtures import log_of, wait_until

from mrs_simulator.ros import unknown_parameters

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
READ = re.compile(r'(?:_parameter|get_param|param_name)\(\s*"~([a-z_]+)"|in \("~(\w+)", "~(\w+)"\)')


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


def test_all_that_the_nodes_read_is_known():
    read = set()
    sources = [
        path
        for room in ("nodes", "ros")
        for path in glob.glob(
            os.path.join(ROOT, "src", "mrs_simulator", room, "**", "*.py"), recursive=True
        )
    ]
    for path in sources:
        with open(path, encoding="utf-8") as file:
            read.update(name for found in READ.findall(file.read()) for name in found if name)
    assert {"v_max", "omega_max", "geofence", "odom_topic"} <= read <= unknown_parameters.PARAMETERS


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
