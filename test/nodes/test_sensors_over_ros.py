"""A law hears the same over ROS in lockstep as without ROS, from every type of sensor."""

import json
import os
import re

import numpy as np
import pytest
import yaml
from protocol_fixtures import shipped
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.study.run.sensor_files import FILE

FLOAT32 = {"sonar": 4e-7, "front": 4e-7, "laser": 4e-7, "camera": 4e-6}  # [m], as far as each sees
SHORT = 3.0  # [s] in which the first columns are seen and heeded
COMMANDS = 26  # [-] that are compared: half a second
MOUNTS = {
    "laser": {"range": [0.1, 5.0], "rays": 31},
    "seen": {"type": "range_bearing", "noise": {"range": {"stddev": 0.02, "dropout": 0.3}}},
    "bumper": {"type": "bumper"},
    "encoders": {"type": "encoders", "noise": {"quantum": "1 mm"}},
    "imu": {"type": "imu", "noise": {"rate": {"stddev": 0.01, "bias_walk": 0.1}}},
    "compass": {"type": "compass", "noise": {"stddev": "1 deg"}},
    "altimeter": {"type": "altimeter", "noise": {"dropout": 0.3}},
    "gps": {"type": "gps", "origin": [49.1, 12.3, 400.0], "noise": {"stddev": 1.0}},
    "mocap": {"type": "motion_capture", "noise": {"position": {"latency": 0.1}}},
    "camera": {
        "type": "camera",
        "place": [0.3, 0.0, 0.4],
        "width": 24,
        "height": 18,
        "noise": {"depth": {"stddev": 0.01, "dropout": 0.1, "latency": 0.06}},
    },
    "front": {"type": "sonar", "transducers": [["0.1 m", 0.0, 0.0]]},
}
LAW = """
import json
import numpy as np
from mrs_simulator import PioneerControl

class Tells(PioneerControl):
    \"\"\"Writes down what it hears, and drives towards what is ahead.\"\"\"

    SENSORS = {names!r}

    def start(self):
        self.file = open(FILE, "w")

    def pointMassLaw(self, hand):
        heard = [self.readings[number] for number in self.numbers]
        told = [{{name: plain(getattr(each, name)) for name in self.SENSORS}} for each in heard]
        self.file.write(json.dumps([self.time, told]) + "\\n")
        self.file.flush()
        ahead = [round(each.sonar.ranges[3:5].min(), 3) for each in heard]  # nor how it is told
        return np.array([[0.1 * far, 0.0] for far in ahead])

def plain(reading):
    return None if reading is None else [np.asarray(value, float).tolist() for value in reading]

FILE = {file!r}
"""


ROBOT = re.compile(r"/robot\d+/")
TOPICS = "Topic", "Marker Topic", "Image Topic", "Depth Map Topic", "Color Image Topic"
# What the displays of RViz subscribe to.
SHOWN = {
    "rviz/LaserScan": "sensor_msgs/LaserScan",
    "rviz/DepthCloud": "sensor_msgs/Image",
    "rviz/Image": "sensor_msgs/Image",
    "rviz/Map": "nav_msgs/OccupancyGrid",
    "rviz/MarkerArray": "visualization_msgs/MarkerArray",
    "rviz/PointCloud": "sensor_msgs/PointCloud",
}


def rviz_displays():
    """Return the fixed frame, and the type of message by topic, of the shipped file of RViz."""
    path = os.path.join(os.path.dirname(__file__), "..", "..", "rviz", "mrs_simulator.rviz")
    with open(path, encoding="utf-8") as file:
        manager = yaml.safe_load(file)["Visualization Manager"]
    found, waiting = {}, list(manager["Displays"])
    while waiting:
        display = waiting.pop()
        waiting += display.get("Displays", [])
        for topic in (display[key] for key in TOPICS if key in display):
            found[topic] = SHOWN[display["Class"]]
            if display["Class"] == "rviz/DepthCloud":  # as image_transport has it, beside either
                found[topic.rpartition("/")[0] + "/camera_info"] = "sensor_msgs/CameraInfo"
    return manager["Global Options"]["Fixed Frame"], found


@pytest.fixture
def scenario(tmp_path):
    wall = {"type": "box", "name": "wall", "center": [1.0, 0.0], "size": [0.2, 9.0]}
    content = {
        "poses": [[0.0, 0.0, 0.0], [-2.0, 0.3, 0.4]],
        "obstacles": [wall],
        "sensors": [{"mounts": MOUNTS}],
        "limits": "top",
        "record": ["laser", "gps"],
        "duration": 0.02 * (COMMANDS - 1),
    }
    path = tmp_path / "scenario.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


def law(directory, name):
    """Return a file of a law that writes to the file ``name``."""
    path = directory / (name + ".py")
    text = LAW.format(names=("sonar", *MOUNTS), file=str(directory / (name + ".txt")))
    path.write_text(text)
    return path, directory / (name + ".txt")


def lines(path):
    """Return what is in the whole lines of a file that may still grow."""
    whole = path.read_text().rpartition("\n")[0] if path.exists() else ""
    return [json.loads(line) for line in whole.splitlines()]


def test_readings_over_ros_are_those_without(ros, scenario, tmp_path):
    file, wanted = law(tmp_path, "without")
    law_alone = load_protocol("{}:Tells".format(file))
    perform(load_scenario(str(scenario)), str(tmp_path / "alone"), law_alone)
    file, heard = law(tmp_path, "over_ros")
    given = ["--scenario", scenario, "_lockstep:=true"]
    waits = "_wait_for_control:=true", "_wait_for_recorders:=1"
    stage = ros.node("stage", *given, "_speed:=0", *waits)
    law_there = "--protocol", "{}:Tells".format(file)
    control = ros.node("pioneer_control", *given, *law_there)
    record = ros.node("record", "--scenario", scenario, *law_there, "--out", tmp_path / "over")
    wait_until(lambda: len(lines(heard)) > COMMANDS)
    assert len(lines(wanted)) == COMMANDS
    for (time, robots), (said, over_ros) in zip(lines(wanted), lines(heard)):
        assert said == pytest.approx(time, abs=1e-9)
        for one, other in zip(robots, over_ros):
            for name, reading in one.items():
                assert (reading is None) == (other[name] is None), (time, name)
                for a, b in zip(reading or (), other[name] or ()):
                    error = "{} at {}".format(name, time)
                    within = FLOAT32.get(name, 1e-12)
                    np.testing.assert_allclose(b, a, rtol=0.0, atol=within, err_msg=error)
    assert "Traceback" not in log_of(stage) + log_of(control)
    # What the scenario has recorded is the same, too.
    ros.judged(record, tmp_path / "over")
    for name, within in (("laser", 4e-7), ("gps", 1e-9)):
        found, alone = (
            np.genfromtxt(tmp_path / out / FILE.format(name), delimiter=",", skip_header=1)
            for out in ("over", "alone")
        )
        found = found[np.lexsort((found[:, 1], found[:, 0]))]
        np.testing.assert_allclose(found, alone, rtol=0.0, atol=within, err_msg=name)
    assert "sensor_laser.csv: 2 robots, 31 values at 10 Hz" in log_of(record)
    # Each sensor has a frame of its own, and what nobody asks for is not published.
    probe = ros.probe()
    probe.ask("watch_diagnostics()")
    probe.ask("listen('/map', OccupancyGrid) and listen('/map_metadata', MapMetaData)")
    probe.wait("'robot2/laser' in transforms and 'robot1/gps' in transforms")
    laser = probe.ask("transforms['robot2/laser'].transform.translation.x")
    assert laser == pytest.approx(0.021)
    # A rate that the world's steps cannot keep is said.
    said = "robot1: mocap at 50 Hz, every 1 steps of 0.02 s; wanted 100 Hz"
    probe.wait("{!r} in (status('slow_sensors') or ())".format(said))
    # The wall, of 0.2 m by 9 m with its middle 1 m ahead, is on the map that is told once.
    data = probe.wait("'/map' in newest and sum(v == 100 for v in newest['/map'].data)")
    assert data == 4 * 180
    info = probe.wait("'/map_metadata' in newest and str(newest['/map_metadata'])")
    assert "resolution: 0.05000000074505806" in info
    assert probe.ask("newest['/map'].header.frame_id") == "world"
    # RViz's displays of these robots find topics of their types, in frames that lead to theirs.
    ros.node("markers")
    probe.wait("'/stage/markers' in dict(rospy.get_published_topics())")
    told = dict(probe.ask("rospy.get_published_topics()"))
    fixed, displays = rviz_displays()
    near = {topic: kind for topic, kind in displays.items() if not ROBOT.match(topic)}
    near.update((t, k) for t, k in displays.items() if ROBOT.match(t) and int(t[6]) <= 2)
    assert {"/robot1/sonar", "/robot2/laser", "/map", "/robot2/camera_depth"} <= set(near)
    assert near["/stage/markers"] == told["/stage/markers"] == "visualization_msgs/MarkerArray"
    assert {topic: told.get(topic) for topic in near} == near
    for topic, kind in near.items():
        probe.ask("listen({!r}, {})".format(topic, kind.partition("/")[2]))
        head = "markers[0].header" if kind.endswith("MarkerArray") else "header"
        frame = probe.wait("{0!r} in newest and newest[{0!r}].{1}.frame_id".format(topic, head))
        while frame != fixed:
            frame = probe.wait("parents().get({!r})".format(frame))
    # Rates, lateness and faults of both nodes.
    probe.wait("(diagnostics.get('pioneer_control') or [])[:2] == [0, 'running']")
    probe.wait("(diagnostics.get('stage: sensors') or [])[:2] == [1, {!r}]".format(said))
    assert {"sonar [Hz]", "laser [Hz]"} <= set(probe.ask("diagnostics['stage: sensors']")[2])
    assert probe.ask("diagnostics['stage'][2]['robots']") == "2"
    assert len(probe.wait("diagnostics.get('pioneer_control: sensors')")[2]) >= 2 * len(MOUNTS)


def test_burgers_read_their_lasers_over_ros_as_without(ros, tmp_path):
    """The shipped scenario goes the same way, its safety filter told by what the stage publishes."""
    path = tmp_path / "burgers.yaml"
    path.write_text(yaml.safe_dump(shipped("burgers_by_laser", duration=SHORT).to_dict()))
    perform(load_scenario(str(path)), str(tmp_path / "alone"))
    given = ["--scenario", path, "_lockstep:=true"]
    waits = "_speed:=0", "_wait_for_control:=true", "_wait_for_recorders:=1"
    stage = ros.node("stage", *given, *waits)
    control = ros.node("pioneer_control", *given)
    record = ros.node("record", "--scenario", path, "--out", tmp_path / "over")
    ros.judged(record, tmp_path / "over", 3 * PATIENCE)
    over, alone = (read_run_csv(str(tmp_path / out / "run.csv")) for out in ("over", "alone"))
    assert len(over.time) == len(alone.time)
    # Lasers are told in float32, and the filter brakes by them.
    for name in ("time", "pose", "command"):
        ours, theirs = getattr(over, name), getattr(alone, name)
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-5, err_msg=name)
    blind = shipped("burgers_by_laser", duration=SHORT)
    blind = blind.changed(control=dict(blind.control.to_plain(), safety=False))
    perform(blind, str(tmp_path / "blind"))
    unseen = read_run_csv(str(tmp_path / "blind" / "run.csv"))
    assert np.abs(over.pose - unseen.pose)[..., :2].max() > 1e-3
    assert "Traceback" not in log_of(stage) + log_of(control) + log_of(record)
