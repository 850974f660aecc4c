"""The GUI's connection with servers that hang, masters that go, and others who press the emergency stop."""

import sys

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from mrs_simulator.core.spatial import headings
from mrs_simulator.ros.message_forms.messages import team_state
from mrs_simulator.rqt_plugin.ros_side import master as master_module
from mrs_simulator.rqt_plugin.ros_side import robots as robots_module
from mrs_simulator.rqt_plugin.ros_side.diagnostics import DiagnosticsConnection
from mrs_simulator.rqt_plugin.ros_side.emergency_stop import StopTopic
from mrs_simulator.rqt_plugin.ros_side.inbox import Inbox
from mrs_simulator.rqt_plugin.ros_side.master import MasterWatch
from mrs_simulator.rqt_plugin.ros_side.robots import RobotsConnection
from mrs_simulator.rqt_plugin.ros_side.sensors import SensorsConnection
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.state.columns import SPATIAL
from mrs_simulator.world.world import EVERY, World

HUNG = """
import rospy, threading
from std_srvs.srv import Trigger
rospy.init_node("pioneer_control")
rospy.Service("pioneer_control/start", Trigger, lambda _: threading.Event().wait())
rospy.spin()
"""


class Publisher:
    """Takes what is published."""

    def __init__(self):
        self.sent = []

    def publish(self, message):
        self.sent.append(message.data)


def published(stop):
    """Return what a new subscriber receives."""
    received = []
    stop.peer_subscribe("emergency_stop", None, received.append)
    return received


def test_a_press_is_repeated_to_later_subscribers_and_a_release_is_not():
    stop, stop_publisher = StopTopic(), Publisher()
    stop.set(True)  # there is no master yet
    stop.publisher = stop_publisher
    assert published(stop) == [Bool(data=True)]
    stop.set(False)
    assert stop_publisher.sent == [False] and published(stop) == []
    stop.set(True)
    assert stop_publisher.sent == [False, True] and published(stop) == [Bool(data=True)]


def odometry(stamp, x, turn):
    message = Odometry()
    message.header.stamp = rospy.Time.from_sec(stamp)
    message.pose.pose = Pose(Point(x, 0.0, 0.0), Quaternion(*turn))
    return message


def test_a_run_begins_with_its_first_command_though_the_one_before_ended_in_motion():
    world = World.from_scenario(load_scenario(scenario_path("paper_four.yaml")))
    world.set_commands(EVERY, np.full((world.n, 2), 0.3))
    inbox = Inbox()
    for time, run in ((1.00, 0), (1.10, 0), (1.12, 1), (1.14, 1), (1.22, 1)):
        inbox.keep_state(team_state(world, rospy.Time(time), "world", (1, run)))
    taken = [sample if sample is None else round(sample.time, 2) for sample in inbox.take_samples()]
    assert taken == [1.0, 1.1, None, 1.12, 1.22]
    inbox.begin_run()  # by another controller, while the robots go on
    inbox.keep_state(team_state(world, rospy.Time(1.26), "world", (1, 1)))
    assert [sample and sample.time for sample in inbox.take_samples()] == [None, 1.26]


def test_the_last_state_of_a_run_is_a_sample_once_time_stands():
    world = World.from_scenario(load_scenario(scenario_path("paper_four.yaml")))
    world.set_commands(EVERY, np.full((world.n, 2), 0.3))
    inbox = Inbox()
    for time in (1.00, 1.06, 1.08, 1.08, 1.08, 1.08):
        inbox.keep_state(team_state(world, rospy.Time(time), "world", (1, 0)))
    assert [round(sample.time, 2) for sample in inbox.take_samples()] == [1.0, 1.06, 1.08]


def test_the_time_of_real_robots_counts_from_the_first_message():
    robots = RobotsConnection()
    robots._on_odometry(odometry(1.7e9, 0.0, (0.0, 0.0, 0.0, 1.0)), 1)
    # 3 rad, of a robot that rolls, as the quaternion of the other sign
    turn = -0.0140533125, -0.1981716615, -0.9776114979, -0.0693271672
    robots._on_odometry(odometry(1.7e9 + 2.5, 4.0, turn), 2)
    received = robots.snapshot(60.0)
    assert received.time == 2.5 and received.robots == (1, 2)
    assert received.pose[1].tolist() == pytest.approx([4.0, 0.0, 3.0], abs=1e-6)
    robots.forget()
    robots._on_odometry(odometry(1.7e9 + 100.0, 0.0, (0.0, 0.0, 0.0, 1.0)), 1)
    assert robots.snapshot(60.0).time == 0.0


class Subscriber:
    """In the place of ``rospy.Subscriber``."""

    def __init__(self, name, *_, **__):
        self.resolved_name = name

    def unregister(self):
        pass


def test_robots_of_a_simulation_that_has_ended_are_no_real_ones(monkeypatch):
    monkeypatch.setattr(robots_module.rospy, "Subscriber", Subscriber)
    robots = RobotsConnection()
    kinds = {"/robot{}/odom".format(number): "nav_msgs/Odometry" for number in (1, 2)}
    simulated, real = {"/robot1/odom": ["/stage"]}, {"/robot2/odom": ["/driver"]}
    robots.follow({**simulated, **real}, {}, kinds, ["/stage"], None)
    for number in (1, 2):
        robots._on_odometry(odometry(1.7e9, 0.0, (0.0, 0.0, 0.0, 1.0)), number)
    assert robots.snapshot(60.0).real.tolist() == [False, True]
    robots.follow({**simulated, **real}, {}, kinds, None, None)  # its state is withdrawn first
    assert robots.snapshot(60.0).real.tolist() == [False, True]
    robots.follow({}, {}, {}, None, None)  # the real one's driver has ended, too
    assert robots.snapshot(60.0).robots == (2,) and robots.snapshot(60.0).real.tolist() == [True]


def test_a_smaller_simulation_after_a_larger_one_is_followed(monkeypatch):
    monkeypatch.setattr(robots_module.rospy, "Subscriber", Subscriber)
    robots, topic = RobotsConnection(), "/robot{}/odom"
    kinds = {topic.format(number): "nav_msgs/Odometry" for number in (1, 2, 3)}
    larger = {topic.format(number): ["/stage"] for number in (1, 2, 3)}
    robots.follow(larger, {}, kinds, ["/stage"], None)
    robots.forget()  # the stage says itself where they are
    smaller = {topic.format(number): ["/stage"] for number in (1, 2)}
    robots.follow(smaller, {}, kinds, ["/stage"], None)
    assert robots.topics() == {1: "/robot1/odom", 2: "/robot2/odom"}


def test_heights_of_real_robots_are_believed_of_teams_that_fly():
    robots, message = RobotsConnection(), Odometry()
    message.pose.pose.position.z, message.twist.twist.linear.z = 1.5, 0.25
    message.pose.pose.orientation.x, message.pose.pose.orientation.w = 0.6, 0.8
    robots._on_odometry(message, 1)
    assert not robots.snapshot(1.0).has(SPATIAL)
    robots.set_starts(np.array([[1.0, 2.0, np.pi]]), in_space=True)
    published = robots.snapshot(1.0)
    assert published.spatial.z.tolist() == [1.5] and published.spatial.twist.tolist() == [
        [0.25, 0.0, 0.0]
    ]
    # Of the two quaternions of a turn either may be published.
    np.testing.assert_allclose(
        abs(published.spatial.orientation), [[0.0, 0.6, 0.8, 0.0]], atol=1e-15
    )
    np.testing.assert_allclose(headings(published.spatial.orientation), published.pose[:, 2])


def test_a_release_does_not_let_go_what_another_has_stopped_since(gui, ros):
    ros.node("stage", "--robots", 4)
    gui(
        """
import shutil
def started(script, *words):
    log = os.path.join(gui.study.processes.directory, "started.log")
    return programs.start(script, words, dict(os.environ), log, log)
def controller():
    script = os.path.join(os.environ["FORKED_PROGRAMS"], "pioneer_control")
    return started(script, "--robots", "4")
def stopped():
    control = gui.connection.newest("control")
    return gui.connection.is_fresh("control") and control.trouble == "emergency stop"
first = controller()
until(lambda: gui.study.is_controlled())
click("emergency")
until(stopped)
until(lambda: gui.study.state.is_emergency() and gui.bar.is_emergency())
click("emergency")
until(lambda: not gui.study.state.is_emergency())
other = started(shutil.which("rostopic"), "pub", "/emergency_stop", "std_msgs/Bool", "true")
until(lambda: gui.study.state.is_emergency())
first.terminate()
first.wait()
until(lambda: not gui.connection.is_fresh("control"))
listening = gui.connection._emergency.publisher.get_num_connections()
second = controller()
until(lambda: gui.connection._emergency.publisher.get_num_connections() > listening)
until(stopped)
gui.connection.ask("start")
refused = "the controller was not started: emergency stop: release it first"
until(lambda: refused in gui.messages.toPlainText())
for process in (second, other):
    process.terminate()
    process.wait()
"""
    )


def test_a_hung_controller_keeps_no_stage_waiting_nor_the_close(gui, ros):
    ros.node("stage", "--robots", 4)
    ros.start("hung", [sys.executable, "-c", HUNG])
    gui(
        """
from mrs_simulator.rqt_plugin.ros_side import service_calls
service_calls.SLOW = 0.3
until(lambda: gui.connection.is_fresh("stage"))
gui.connection.ask("start")
click("pause")
until(lambda: gui.connection.newest("stage").paused)
until(lambda: "start: the controller has not answered yet" in gui.messages.toPlainText())
gui.connection.restore_simulated_time(False)
gui.close_study()
gui.close_study = lambda: None  # it would wait for the answer once more
assert rospy.get_param("/use_sim_time") is False
import rosgraph
master = rosgraph.Master("/gui")
until(lambda: [t for t, nodes in master.getSystemState()[1] if "/gui" in nodes] == ["/clock"])
"""
    )


def test_without_a_master_the_gui_opens_and_joins_one_that_comes(gui, ros):
    gui(
        """
until(lambda: gui.connection.newest("emergency") is None and gui.connection.master_online)
gui.close_study()
os.kill(int(sys.argv[2]), 9)
import rosgraph
until(lambda: not rosgraph.is_master_online())
# A listener of its own would share the GUI's connection, and miss what came before it.
from mrs_simulator.rqt_plugin.ros_side.inbox import Inbox
keep, received = Inbox.keep, []
def keep_and_note(inbox, message, name):
    keep(inbox, message, name)
    if name == "emergency":
        received.append(message.data)
Inbox.keep = keep_and_note
gui = StudyWidget(RosConnection(), Processes(), load_scenario(sys.argv[1]))
gui.connection.set_emergency(True)
until(lambda: "no master" in gui.status["master"].text())
start = gui.bar.button("control")
assert not start.isEnabled() and "no ROS master" in start.toolTip()
import subprocess
port = os.environ["ROS_MASTER_URI"].rpartition(":")[2]
master = subprocess.Popen(["rosmaster", "--core", "-p", port])
until(lambda: received)
assert received[0] is True and gui.study.state.is_emergency()
gui.close_study()
master.terminate()
master.wait()
""",
        ros.master.pid,
    )


def test_the_watch_of_the_master_starts_and_ends_without_one(monkeypatch):
    monkeypatch.setattr(master_module.rosgraph, "is_master_online", lambda: False)
    robots, sensors, diagnostics = RobotsConnection(), SensorsConnection(), DiagnosticsConnection()
    watch = MasterWatch(Inbox(), robots, sensors, diagnostics, StopTopic())
    watch.thread.start()
    watch.end()
    watch.thread.join(20.0)
    assert not watch.thread.is_alive() and not watch.online
