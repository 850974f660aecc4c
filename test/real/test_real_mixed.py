"""A semi-physical team of three kinds: a real Pioneer among simulated robots of other drives."""

import sys
import xmlrpc.client

import numpy as np
import pytest
from ros_fixtures import PATIENCE, wait_until
from test_rosaria import ROBOT, START

from mrs_simulator.study.results.report import read_run
from mrs_simulator.verdict.requirements.results import evaluated

# Robot 1 is real and behind a driver; its line is 0.8 m apart, to the left of the last robot.
TEAM = """
model: [pioneer3dx, turtlebot3_burger, robotino3, robotino3]
poses:
  - [3.0, 0.6, 0.0]
  - [1.9, -0.5, 0.0]
  - [0.6, 1.0, 0.0]
  - [0.0, 0.0, 0.0]
odometry: wheel
control: {protocol: formation, rate: 20, parameters: {k: 0.1, T: 0.1, l: 0.1, c: 0.8}}
"""
PLACES = np.array([[2.4, 0.0], [1.6, 0.0], [0.8, 0.0], [0.0, 0.0]])
TO_STAGE = "/robot1/RosAria/pose:=/robot1/odom", "/robot1/RosAria/cmd_vel:=/robot1/cmd_vel"


def test_one_protocol_drives_real_and_simulated_robots_of_three_kinds(ros, tmp_path):
    master = xmlrpc.client.ServerProxy(ros.uri)
    master.setParam("/test", "/use_sim_time", False)
    driver = [sys.executable, ROBOT, "__name:=RosAria", "__ns:=/robot1", *TO_STAGE]
    ros.start("driver", driver)
    scenario = tmp_path / "team.yaml"
    scenario.write_text(TEAM)
    ros.node("stage", "--scenario", scenario, "--real", 1)
    own = "_real:=1", "_v_max:=[0.3, 1, 1, 1]", "_odom_timeout:=5", "_max_jump:=0"
    ros.node("pioneer_control", "--scenario", scenario, *own, "_autostart:=false")
    probe = ros.probe()
    probe.ask("listen('/robot1/cmd_vel', Twist)")
    probe.wait("control('running') is False")
    probe.wait("state('real') == [True, False, False, False] and status('real_silent') == []")

    def columns(*keys):
        return np.array(probe.ask("[state(key) for key in {!r}]".format(keys)))

    # Each within its own limits: the real one within those for first trials, the Burger within its
    # firmware's, the Robotino, which is told to go aside as well, within its rims'.
    probe.ask("watch_commands()")
    probe.wait("len(greatest) == 4")
    wait_until(lambda: probe.ask(START)[0])

    def all_have_hurried():
        top, aside = np.array(probe.ask("[greatest[number] for number in (1, 2, 3, 4)]")).T
        assert (top <= np.array([0.3, 0.22, 0.69, 0.69]) + 1e-9).all(), top
        assert not aside[:2].any()
        return (top[:3] > [0.3 - 1e-6, 0.22 - 1e-6, 0.3]).all() and aside[2] > 0.2

    wait_until(all_have_hurried)
    probe.wait("sent(1)[0] > 0.0")

    # The real one's motors go off: it stands alone, the others go on.
    probe.ask("switch('/robot1/RosAria/disable_motors')")
    probe.wait("'robot1 stopped: commanded to move' in control('trouble')", limit=PATIENCE)
    assert probe.ask("[control('stopped'), control('running')]") == [[1], True]
    wait_until(lambda: probe.ask("sent(1)") == [0.0, 0.0])

    # With motors, and after another start, they form the line all the same.
    probe.ask("switch('/robot1/RosAria/enable_motors')")
    wait_until(lambda: probe.ask(START)[0] and probe.ask("control('stopped')") == [])

    def is_formed():
        x, y, theta = columns("x", "y", "theta")
        l = np.array([0.1, 0.1, 0.0, 0.0])  # of the hand points; a Robotino's point is its centre
        points = np.stack([x + l * np.cos(theta), y + l * np.sin(theta)], axis=1)
        gaps = points - points[3] - PLACES + PLACES[3]
        return np.abs(gaps).max() < 0.05

    wait_until(is_formed)


TWO = """
poses: [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
odometry: wheel
record_rate: 10
control: {protocol: law.py, rate: 20}
requirements: {slow: always(each robot(speed < 0.22 m/s))}
"""
FORWARD = """
from mrs_simulator import PioneerControl, make_twist

class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.2, 0.0) for i in pos_map}
"""


def start_driver(ros, number, rate):
    """Start a driver of robot ``number`` on the stage's topics, which tells ``rate`` [Hz] poses."""
    ours = "/robot{}".format(number)
    names = (
        "{0}/RosAria/{1}:={0}/{2}".format(ours, their, our)
        for their, our in (("pose", "odom"), ("cmd_vel", "cmd_vel"))
    )
    driver = [sys.executable, ROBOT, "__name:=RosAria", "__ns:=" + ours, *names]
    ros.start("driver{}".format(number), [*driver, "_rate:={}".format(rate)])


@pytest.mark.parametrize("real", [(), (1,), (1, 2)], ids=["simulated", "mixed", "real"])
def test_a_killed_recorder_leaves_who_is_real_and_how_fast_they_are(ros, tmp_path, real):
    master = xmlrpc.client.ServerProxy(ros.uri)
    master.setParam("/test", "/use_sim_time", False)  # which drivers look at once
    for number in real:
        start_driver(ros, number, rate=15)  # of which samples at 10 Hz leave out every third
        odom = ["/robot{}/odom".format(number), "nav_msgs/Odometry"]
        wait_until(lambda odom=odom: odom in master.getPublishedTopics("/test", "")[2])
    master.setParam("/test", "/use_sim_time", real != (1, 2))
    (tmp_path / "law.py").write_text(FORWARD)
    scenario, out = tmp_path / "two.yaml", tmp_path / "out"
    scenario.write_text(TWO)
    if real != (1, 2):
        # Whose drivers tell 15 poses a second of wall time goes at its pace.
        ros.node("stage", "--scenario", scenario, *(["--real", 1] if real else ["_speed:=4"]))
    record = ros.node("record", "--scenario", scenario, "--out", out)
    own = ["_odom_timeout:=5", "_max_jump:=0"] + ["_real:=1"] * (real == (1,))
    ros.node("pioneer_control", "--scenario", scenario, *own, "_autostart:=true")
    table = out / "run.csv"
    wait_until(lambda: table.exists() and table.read_bytes().count(b"\n") > 30)
    record.kill()
    record.wait(PATIENCE)
    run = read_run(str(out))
    assert run.are_real.any(axis=0).tolist() == [number in real for number in (1, 2)]
    (slow,) = evaluated(None, run)
    assert slow["met"], slow
    assert ("twist.linear.x" in table.read_text()) == bool(real)
