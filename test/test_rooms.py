"""Imports keep to the direction of the rooms."""

import ast
import os

import pytest

import mrs_simulator.core

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(mrs_simulator.core.__file__)))

ROS = {
    "rospy",
    "rosbag",
    "rosgraph",
    "rosgraph_msgs",
    "rospkg",
    "dynamic_reconfigure",
    "tf2_msgs",
    "tf2_ros",
}
MESSAGES = {"geometry_msgs", "nav_msgs", "std_msgs", "std_srvs"}
QT = {"python_qt_binding", "PyQt5"}
# What a room may not import: outside packages, and rooms of this package.
FORBIDDEN = {
    "core": (
        ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
        {"world", "control", "report", "nodes"},
    ),
    "world": (ROS | MESSAGES | QT | {"matplotlib"}, {"control", "report", "nodes"}),
    "control": (ROS | QT | {"pybullet", "matplotlib"}, {"world", "report", "nodes"}),
    "report": ((ROS - {"rosbag"}) | MESSAGES | QT | {"pybullet"}, {"world", "control", "nodes"}),
    "nodes": (QT | {"pybullet", "matplotlib"}, {"rqt_plugin"}),
}


def modules(room):
    for directory, _, files in os.walk(os.path.join(ROOT, room)):
        for name in files:
            if name.endswith(".py"):
                yield os.path.join(directory, name)


def imported(path):
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


@pytest.mark.parametrize("room", sorted(FORBIDDEN))
def test_imports_stay_in_their_direction(room):
    packages, rooms = FORBIDDEN[room]
    found = [(path, name) for path in modules(room) for name in imported(path)]
    assert found, "no module of {} was read".format(room)
    for path, name in found:
        parts = name.split(".")
        assert parts[0] not in packages, "{} imports {}".format(path, name)
        if parts[0] == "mrs_simulator" and len(parts) > 1:
            assert parts[1] not in rooms, "{} imports {}".format(path, name)


def test_core_imports_without_ros_or_pybullet():
    import subprocess
    import sys

    hidden = sorted(ROS | MESSAGES | QT | {"pybullet", "matplotlib"})
    code = (
        "import sys; hidden = {!r}\n"
        "for name in hidden: sys.modules[name] = None\n"
        "import mrs_simulator.core.verdict, mrs_simulator.core.layouts, mrs_simulator.core.recording"
    ).format(hidden)
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
