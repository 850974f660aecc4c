"""Robots behind p2os and TurtleBot3 drivers, brought up by the launch files, stopped as they can be."""

import os
import re
import signal
import stat
import sys
import time
import xml.etree.ElementTree as ElementTree
import xmlrpc.client

import numpy as np
import pytest
from p2os_robot import Commands
from ros_fixtures import log_of, wait_until
from turtlebot3_robot import obeyed

from mrs_simulator.control.guards import stilled
from mrs_simulator.nodes.control.guards import Guards
from mrs_simulator.nodes.control.motors import split_topic

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LAUNCH = os.path.join(os.path.dirname(HERE), "launch")
MOTORS_OFF = """
import sys
import rospy
sys.path.append(sys.argv[1])
from p2os_robot import MotorState
rospy.init_node("button", anonymous=True)
out = rospy.Publisher("/robot2/cmd_motor_state", MotorState, queue_size=1)
while rospy.wait_for_message("/robot2/motor_state", MotorState).state != 0:
    out.publish(MotorState(0))
"""
START, STOP = ("call('/pioneer_control/{}', Trigger)".format(name) for name in ("start", "stop"))
SCENARIO = """
poses: [[2.6, 0.2, 0.0], [1.5, -0.3, 0.0]]
control: {protocol: formation, rate: 20, parameters: {k: 0.1, T: 0.1, l: 0.2, c: 0.8}}
duration: 10
"""
FORWARD = """
from mrs_simulator import PioneerControl, make_twist

class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.15, 0.0) for i in pos_map}
"""
PATIENT = ("stuck_time:=30", "frozen_time:=30")  # [s] for drivers that a busy machine holds up
NOISE = "what a driver complains of"
PACKAGE = (
    "<package><name>{}</name><version>1.0.0</version><description>-</description>"
    "<maintainer email='a@b.c'>-</maintainer><license>BSD</license></package>"
)
# Package, program, what stands for it (neither is installed where the tests run), odometry, node.
DRIVERS = {
    "p2os": ("p2os_driver", "p2os_driver", "p2os_robot.py", "pose", "p2os_driver"),
    "turtlebot3": (
        "rosserial_python",
        "serial_node.py",
        "turtlebot3_robot.py",
        "odom",
        "turtlebot3_core",
    ),
}


class Bench:
    """Two robots, brought up by a launch file with what stands for their drivers."""

    def __init__(self, ros, directory, name):
        package, program, robot, self.topic, self.node = DRIVERS[name]
        self.ros, self.directory, self.name = ros, directory, name
        home = directory / package
        home.mkdir()
        (home / "package.xml").write_text(PACKAGE.format(package))
        start = '#!/bin/sh\necho {} >&2\nexec {} {} "$@"\n'.format(
            NOISE, sys.executable, os.path.join(HERE, robot)
        )
        (home / program).write_text(start)
        (home / program).chmod(stat.S_IRWXU)
        (directory / "lab.yaml").write_text(SCENARIO)
        (directory / "law.py").write_text(FORWARD)
        paths = ros.environment.get("ROS_PACKAGE_PATH", os.environ["ROS_PACKAGE_PATH"])
        ros.environment["ROS_PACKAGE_PATH"] = "{}:{}".format(directory, paths)
        xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/use_sim_time", False)

    def launch(self, *arguments):
        """Start the launch file; return when the controller waits for its start."""
        given = ["{}:={}".format(key, self.directory / file) for key, file in FILES.items()]
        command = "mrs_simulator", self.name + ".launch", "robots:=2", "odom_timeout:=3", *PATIENT
        self.process = self.ros.launch(*command, *given, *arguments)
        self.probe = self.ros.probe()
        for number in (1, 2):
            self.probe.ask("listen('/robot{}/{}', Odometry)".format(number, self.topic))
        heard = "all('/robot%d/{}' % n in newest for n in (1, 2))".format(self.topic)
        self.probe.wait("control('trouble') == 'not started' and " + heard)

    def start(self):
        """Start the controller, which refuses as long as it hears not all."""
        said = self.probe.wait("[said for done, said in [{}] if done]".format(START))[0]
        assert said == "running"

    def x(self, number):
        """Return how far the driver says that robot ``number`` has gone [m]."""
        name = "/robot{}/{}".format(number, self.topic)
        return self.probe.ask("newest[{!r}].pose.pose.position.x".format(name))

    def far(self, distance):
        """Wait until both robots have gone so far [m]."""
        wait_until(lambda: min(self.x(1), self.x(2)) > distance)

    def where(self):
        """Return how far [m] each robot has gone, by its number."""
        return {number: self.x(number) for number in (1, 2)}

    def are_beyond(self, where, distance):
        """Wait until each robot has gone so far [m] from ``where`` it was."""
        wait_until(lambda: all(self.x(n) > x + distance for n, x in where.items()))

    def stand(self, *numbers):
        """Wait until robots say for a while that they are where they were."""

        def still():
            before = [self.x(number) for number in numbers]
            time.sleep(0.5)
            return all(abs(self.x(n) - x) < 2e-3 for n, x in zip(numbers, before))

        wait_until(still)

    def pid(self, node):
        """Return the number of the process of ``node``."""
        uri = xmlrpc.client.ServerProxy(self.ros.uri).lookupNode("/test", node)[2]
        return xmlrpc.client.ServerProxy(uri).getPid("/test")[2]


FILES = {"scenario": "lab.yaml", "protocol": "law.py"}


@pytest.fixture(params=sorted(DRIVERS))
def bench(request, ros, tmp_path):
    return Bench(ros, tmp_path, request.param)


def test_the_launch_file_drives_them_and_their_watchdog_is_what_stops_them(bench):
    bench.launch()
    assert bench.x(1) == 0.0
    bench.start()
    bench.far(0.05)
    if bench.name == "p2os":
        switch_motors_off_and_on(bench)
    frame = "newest['/robot2/{}'].header.frame_id".format(bench.topic)
    assert bench.probe.ask(frame).lstrip("/") == "robot2/odom"
    assert bench.probe.ask(STOP)[0]
    bench.stand(1, 2)
    control = bench.pid("/pioneer_control")
    where = bench.where()
    bench.start()
    # Each by itself: one may be far behind. p2os repeats a command after 2 s only, and this is before.
    bench.are_beyond(where, 0.05)
    where = bench.where()
    os.kill(control, signal.SIGSTOP)
    try:
        if bench.name == "p2os":  # which has no watchdog; the robot's own waits for 2 s
            bench.are_beyond(where, 0.1)
        bench.stand(1)  # a TurtleBot3's board waits for 0.5 s
    finally:
        os.kill(control, signal.SIGCONT)
    # What drivers print goes to the log, and what stopped a robot stays on the screen.
    assert NOISE not in log_of(bench.process)
    # A driver that loses its robot is silent, and all stop.
    assert bench.probe.ask("switch('/robot2/{}/lose_link')".format(bench.node))
    bench.probe.wait("control('stale') == [2] and not control('running')")
    bench.stand(1)


def switch_motors_off_and_on(bench):
    """Switch them off as by an emergency button, and on by a start of the controller."""
    bench.ros.python(MOTORS_OFF, HERE)
    bench.probe.wait("'robot2 stopped: its motors are off' in (control('trouble') or '')")
    bench.stand(2)
    assert bench.probe.ask("control('running')")
    bench.start()
    bench.far(bench.x(2) + 0.05)


@pytest.mark.parametrize("deadband, stops", [(0.0, False), (0.01, True)])
def test_zeros_stop_a_p2os_robot_only_where_smaller_commands_are_never_sent(deadband, stops):
    commands = Commands()
    for step, v in enumerate((0.2, 0.1, 0.05, 0.02, 0.008, 0.004, 0.0)):
        sent = stilled(np.array([[v, 0.1 * v]]), deadband)[0].tolist()
        commands.take(*sent, now=0.05 * step)
        commands.sent()
    for step in range(100):  # zeros, again and again
        commands.take(0.0, 0.0, now=1.0 + 0.05 * step)
    assert (commands.sent() == (0.0, 0.0)) is stops


def test_a_board_cuts_what_its_wheels_cannot():
    v, omega = obeyed(0.22, 0.0)
    assert (v, omega) == (pytest.approx(0.2097, abs=1e-4), 0.0)
    v, omega = obeyed(0.2, 1.0)  # the outer wheel alone is cut, so that it turns less
    assert v == pytest.approx(0.1645, abs=1e-3) and omega == pytest.approx(0.565, abs=1e-2)
    assert obeyed(0.0, 2.0) == (0.0, pytest.approx(2.0, abs=0.02))
    assert obeyed(7e-4, 0.0) == (0.0, 0.0)  # less than a unit


def test_what_moves_in_any_component_is_sent_whole():
    command = np.array([[0.009, 0.0101], [-0.0101, 0.0], [0.01, -0.01], [0.0, 0.0]])
    expected = [[0.009, 0.0101], [-0.0101, 0.0], [0.0, 0.0], [0.0, 0.0]]
    assert stilled(command, 0.01).tolist() == expected
    assert stilled(command, 0.0) is command


def test_the_controller_sends_no_smaller_command_than_its_dead_band(monkeypatch):
    given = {"~deadband": 0.01, "~v_max": 0.1}
    monkeypatch.setattr("rospy.get_param", lambda name, default=None: given.get(name, default))
    guards = Guards((1, 2), "robot")
    pose, changed = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]), np.full(2, np.inf)
    # Slowing comes first: what it makes too small is zero as well.
    sent = guards.passed(np.array([[0.2, 0.018], [0.01, 0.0]]), pose, 0.0, changed)
    assert sent.tolist() == [[0.1, 0.009], [0.0, 0.0]]
    sent = guards.passed(np.array([[0.3, 0.0], [0.0101, 0.0]]), pose, 0.1, changed)
    assert sent.tolist() == [[0.1, 0.0], [0.0101, 0.0]]


def test_a_topic_of_motors_may_name_its_type():
    assert split_topic("/robot{}/on", 3) == ("/robot3/on", "")
    assert split_topic("/robot{}/on", 3, "std_msgs/Bool") == ("/robot3/on", "std_msgs/Bool")
    assert split_topic("/r{}/on p2os_msgs/MotorState", 3) == ("/r3/on", "p2os_msgs/MotorState")
    with pytest.raises(ValueError, match="unknown type of message 'os/system', wanted one of"):
        split_topic("/robot{}/on os/system", 3)


def test_what_any_driver_prints_goes_to_the_log():
    for name in ("rosaria", *DRIVERS):
        tree = ElementTree.parse(os.path.join(LAUNCH, name + "_robot.launch"))
        (node,) = tree.getroot().iter("node")
        assert node.get("output") == "log" and "2>&1" in node.get("launch-prefix"), name


def test_the_launch_files_of_real_robots_have_the_same_arguments():
    declared = {}
    for name in ("rosaria", *DRIVERS):
        tree = ElementTree.parse(os.path.join(LAUNCH, name + ".launch"))
        declared[name] = {arg.get("name"): arg for arg in tree.getroot().iter("arg")}
    common = ElementTree.parse(os.path.join(LAUNCH, "real_robots.launch")).getroot()
    wanted = {arg.get("name") for arg in common.findall("arg") if arg.get("value") is None}
    for name, arguments in declared.items():
        assert set(arguments) == wanted, name
        for key, arg in arguments.items():
            if arg.get("value") is None and key in declared["rosaria"]:
                ours, theirs = (
                    re.split("[;,]", x[key].get("doc") or "")[0]
                    for x in (arguments, declared["rosaria"])
                )
                assert ours == theirs or key in ("ports", "deadband"), (name, key)
