"""Imports keep to the direction of the rooms."""

import ast
import os

import pytest
from rooms import ROOMS, imported, imported_modules

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
# Neighbours in that order that know nothing of each other.
APART = {
    ("sensors", "pictures"),
    ("world", "pictures"),
    ("control", "pictures"),
    ("world", "control"),
    ("control", "world"),
    ("nodes", "rqt_plugin"),
    ("rqt_plugin", "nodes"),
}
# Outside packages that a room may not import.
FORBIDDEN = {
    "core": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "state": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "scenario": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "record": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "vehicles": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "sensors": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "pictures": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "world": ROS | MESSAGES | QT | {"matplotlib"},
    "control": ROS | QT | {"pybullet", "matplotlib"},
    "verdict": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "protocols": ROS | MESSAGES | QT | {"pybullet", "matplotlib"},
    "study": (ROS - {"rosbag"}) | MESSAGES | QT | {"pybullet"},
    "ros": QT | {"pybullet", "matplotlib"},
    "nodes": QT | {"pybullet", "matplotlib"},
    "rqt_plugin": {"pybullet"},
    "": ROS | MESSAGES | QT | {"pybullet", "matplotlib", "numpy"},  # the package itself
}
# Fields that no other thing is called like: whoever names one takes a message apart.
OWN_FIELDS = {
    "TeamState": ("command_v", "command_omega", "command_vy"),
    "ControlStatus": ("target_x", "target_y"),
    "StageStatus": ("round_trip_median", "round_trip_p99"),
}
ROS_SIDE = {"ros_side", "plugin.py", "standalone.py"}  # of the GUI: the only ones that know ROS


def modules(room):
    top = os.path.join(ROOT, room) if room else ROOT
    for directory, inner, files in os.walk(top):
        if not room:
            inner.clear()
        for name in files:
            if name.endswith(".py"):
                yield os.path.join(directory, name)


def found_imports(room):
    found = [(path, name) for path in modules(room) for name in imported(path)]
    assert found, "no module of {} was read".format(room or "the package itself")
    return found


def test_every_directory_is_a_room_with_rules():
    held = {
        name for name in os.listdir(ROOT) if os.path.exists(os.path.join(ROOT, name, "__init__.py"))
    }
    assert held == set(ROOMS) and set(FORBIDDEN) == set(ROOMS) | {""}


@pytest.mark.parametrize("room", sorted(FORBIDDEN))
def test_a_room_imports_no_package_that_it_may_not(room):
    for path, name in found_imports(room):
        assert name.split(".")[0] not in FORBIDDEN[room], "{} imports {}".format(path, name)


@pytest.mark.parametrize("room", ROOMS)
def test_imports_keep_to_the_order_of_the_rooms(room):
    for path, name in found_imports(room):
        parts = name.split(".")
        if parts[0] == "mrs_simulator" and len(parts) > 1 and parts[1] in ROOMS:
            other = parts[1]
            wrong = ROOMS.index(other) > ROOMS.index(room) or (room, other) in APART
            assert not wrong, "{} imports {}".format(path, name)


def test_no_modules_import_each_other_in_a_circle():
    within = {}
    for room in ROOMS:
        for path in modules(room):
            name = os.path.relpath(path, os.path.dirname(ROOT))[: -len(".py")].replace(os.sep, ".")
            within[name[: -len(".__init__")] if name.endswith(".__init__") else name] = path
    left = {name: set(imported_modules(path)) & set(within) for name, path in within.items()}
    while left:
        free = [name for name, others in left.items() if not others & set(left) - {name}]
        assert free, "in a circle: {}".format(", ".join(sorted(left)))
        for name in free:
            del left[name]


def test_the_widgets_of_the_gui_know_no_ros():
    for path, name in found_imports("rqt_plugin"):
        part = os.path.relpath(path, os.path.join(ROOT, "rqt_plugin")).split(os.sep)[0]
        if part not in ROS_SIDE:
            package = name.split(".")[0]
            known = package in ROS | MESSAGES or name.startswith(
                ("mrs_simulator.msg", "mrs_simulator.srv")
            )
            assert not known, "{} imports {}".format(path, name)


def test_one_module_alone_knows_the_binding_of_qt():
    for path, name in found_imports("rqt_plugin"):
        own = os.path.relpath(path, ROOT) == os.path.join("rqt_plugin", "qt", "__init__.py")
        assert own or name.split(".")[0] not in QT, "{} imports {}".format(path, name)


def test_one_module_alone_knows_the_fields_of_messages():
    fields = {field for name in OWN_FIELDS for field in OWN_FIELDS[name]}
    for room in ROOMS:
        for path in modules(room):
            if os.path.relpath(path, ROOT) in ("ros/message_forms/messages.py",):
                continue
            for name in imported(path):
                assert name != "mrs_simulator.msg", "{} imports {}".format(path, name)
            with open(path, encoding="utf-8") as file:
                text = file.read()
            for node in ast.walk(ast.parse(text)) if any(map(text.__contains__, fields)) else ():
                named = getattr(node, "attr", None) or getattr(node, "arg", None)
                assert named not in fields, "{}, line {}: {}".format(path, node.lineno, named)


def test_core_imports_without_ros_or_pybullet():
    import subprocess
    import sys

    hidden = sorted(ROS | MESSAGES | QT | {"pybullet", "matplotlib"})
    code = (
        "import sys; hidden = {!r}\n"
        "for name in hidden: sys.modules[name] = None\n"
        "import mrs_simulator.verdict.verdict, mrs_simulator.scenario.team.layouts\n"
        "import mrs_simulator.record.recording"
    ).format(hidden)
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_the_list_of_slow_tests_names_tests_that_are_there():
    folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    with open(os.path.join(folder, "slow_tests.txt"), encoding="utf-8") as file:
        listed = [line.strip().split("::") for line in file]
    assert listed == sorted(listed)
    for path, name in listed:
        with open(os.path.join(folder, path), encoding="utf-8") as file:
            assert "def {}(".format(name) in file.read(), "{}::{}".format(path, name)
