"""The control node on robots whose driver behaves as RosAria does."""

import json
import os
import signal
import sys
import time
import xmlrpc.client

import numpy as np
import pytest
import yaml
from ros_fixtures import PATIENCE, log_of, wait_until

from mrs_simulator.nodes.control.common_frame import RESTART
from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.team.limits import LoweredLimits
from mrs_simulator.study.results.provenance import ROBOTS, read_provenance
from mrs_simulator.study.results.reproduce import reproduce
from mrs_simulator.study.results.stamp import stamp_of

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ROBOT, P2OS = (os.path.join(HERE, name + "_robot.py") for name in ("rosaria", "p2os"))
SCENARIO = """
poses:
  - [2.6, 0.2, 0.0]
  - [1.5, -0.3, 0.0]
  - [1.0, 0.4, 0.0]
  - [0.0, 0.0, 0.0]
control: {protocol: formation, rate: 20, parameters: {k: 0.1, T: 0.1, l: 0.2, c: 0.8}}
duration: 10
"""
READY = "record: waiting for the robots' first command"
STARTS = np.array([[2.6, 0.2, 0.0], [1.5, -0.3, 0.0], [1.0, 0.4, 0.0], [0.0, 0.0, 0.0]])
FORWARD = """
from mrs_simulator import PioneerControl, make_twist

class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {i: make_twist(0.2, 0.0) for i in pos_map}
"""
STOPS = """
import numpy as np
from mrs_simulator import PioneerControl

class StopsBefore(PioneerControl):
    \"\"\"Drives on until the sonar's foremost echoes are near.\"\"\"

    SENSORS = ("sonar",)

    def pointMassLaw(self, hand):
        near = [np.nanmin(self.readings[n].sonar.ranges[3:5]) < 0.5 for n in self.numbers]
        return np.where(np.array(near)[:, np.newaxis], 0.0, [0.3, 0.0])
"""
ENABLE = "_enable_motors:=/robot{}/RosAria/enable_motors"
HELD = "_enable_motors:=/robot{}/held"  # by the probe, until its gate is set
AT_ONCE = "_autostart:=true"
STALLS = "_odom_timeout:=5"  # where silence is not the matter: a busy machine's stall is none
# Where it is the matter, and that stall is none all the same; silence is named before standstill.
SILENCE = "_odom_timeout:=2", "_frozen_time:=8", "_stuck_time:=8"
JOYSTICK = ["rostopic", "pub", "-r", "10", "/robot1/RosAria/cmd_vel", "geometry_msgs/Twist"]
JOYSTICK += ["{linear: {x: 0.3}}"]
START = "call('/pioneer_control/start', Trigger)"


class Team:
    """Robots, their control node, and a probe that listens to both."""

    def __init__(self, ros, directory):
        self.ros = ros
        self.scenario = directory / "lab.yaml"
        self.scenario.write_text(SCENARIO)
        self.law = directory / "law.py"
        self.law.write_text(FORWARD)
        self.robots = {}
        xmlrpc.client.ServerProxy(ros.uri).setParam("/test", "/use_sim_time", False)
        self._probe = None

    def robot(self, number, *arguments, name=""):
        """Start robot ``number``; the arguments are its driver's parameters."""
        command = [sys.executable, ROBOT, "__name:=RosAria", "__ns:=/robot{}".format(number)]
        process = self.ros.start(name or "robot{}".format(number), command + list(arguments))
        self.robots[number] = process
        return process

    def node(self, script, *arguments, n=4, name=None):
        """Start a node for the first n robots, remapped to the drivers' names."""
        remaps = [
            "/robot{0}/{1}:=/robot{0}/RosAria/{2}".format(number, ours, theirs)
            for number in range(1, n + 1)
            for ours, theirs in (("odom", "pose"), ("cmd_vel", "cmd_vel"))
        ]
        known = ["--scenario", self.scenario, "--robots", n, "--odometry", "wheel"]
        return self.ros.node(script, *known, *remaps, *arguments, name=name)

    @property
    def probe(self):
        if self._probe is None:
            self._probe = self.ros.probe()
            for n in self.robots:
                self._probe.ask("listen('/robot{}/RosAria/pose', Odometry)".format(n))
                self._probe.ask("listen('/robot{}/RosAria/cmd_vel', Twist)".format(n))
                self._probe.ask("listen('/robot{}/RosAria/motors_state', Bool)".format(n))
        return self._probe

    def odometry(self, number):
        """Return the pose that the driver of a robot tells, None before the first."""
        name = "newest['/robot{}/RosAria/pose'].pose.pose".format(number)
        parts = "{0}.position.x, {0}.position.y, {0}.orientation.z, {0}.orientation.w".format(name)
        if not self.probe.ask("'/robot{}/RosAria/pose' in newest".format(number)):
            return None
        x, y, z, w = self.probe.ask("[{}]".format(parts))
        return np.array([x, y, 2.0 * np.arctan2(z, w)])

    def hands(self):
        """Return the hand points in the scenario's frame, (4, 2); all robots head along x."""
        poses = [self.odometry(n) for n in (1, 2, 3, 4)]
        if any(pose is None for pose in poses):
            return None
        pose = STARTS + np.array(poses)
        return pose[:, :2] + 0.2 * np.array([np.cos(pose[:, 2]), np.sin(pose[:, 2])]).T

    def in_line(self):
        """Tell whether neighbours stand 0.8 m apart on a line along x."""
        hand = self.hands()
        if hand is None:
            return False
        steps = hand[:-1] - hand[1:]
        return bool(np.abs(steps - [0.8, 0.0]).max() < 0.04)

    def sent(self, number):
        """Return the command that a robot got last, None before the first."""
        name = "newest['/robot{}/RosAria/cmd_vel']".format(number)
        known = "'/robot{}/RosAria/cmd_vel' in newest".format(number)
        return self.probe.ask("[{0}.linear.x, {0}.angular.z] if {1} else None".format(name, known))

    def at_rest(self, numbers=(1, 2, 3, 4)):
        """Wait until the robots were told to stop."""
        wait_until(lambda: all(self.sent(n) == [0.0, 0.0] for n in numbers))

    def trouble(self, text):
        """Wait until the control node's trouble holds ``text``; return it."""
        said = "[said for said in [control('trouble') or ''] if {!r} in said]"
        return self.probe.wait(said.format(text))[0]

    def drives(self, numbers=(1, 2, 3, 4), distance=0.05):
        """Wait until the robots have gone some way."""

        def far():
            poses = [self.odometry(n) for n in numbers]
            return all(p is not None and np.hypot(p[0], p[1]) > distance for p in poses)

        wait_until(far)

    def go(self):
        """Start the controller, which refuses as long as it hears not all; return what it says."""
        return self.probe.wait("[said for done, said in [{}] if done]".format(START))[0]

    def forward(self, *arguments, n=4):
        """Start the control node with a law that drives all straight on, at once unless told not to."""
        if not any("_autostart" in str(argument) for argument in arguments):
            arguments = (AT_ONCE, *arguments)
        return self.node("pioneer_control", "--protocol", self.law, *arguments, n=n)


@pytest.fixture
def team(ros, tmp_path):
    return Team(ros, tmp_path)


def test_one_disabled_and_one_late(team):
    for number in (1, 2, 3, 4):
        team.robot(number, "_rate:={}".format(5 if number == 3 else 10))
    for number in (1, 2, 3, 4):
        wait_until(lambda number=number: team.odometry(number) is not None)
    off = "bool(rospy.ServiceProxy('/robot2/RosAria/disable_motors', Empty)())"
    assert team.probe.ask(off)
    team.probe.wait("newest['/robot2/RosAria/motors_state'].data is False")
    team.node("pioneer_control", AT_ONCE, ENABLE, STALLS)
    team.probe.wait("newest['/robot2/RosAria/motors_state'].data")
    wait_until(team.in_line, 60)


def test_a_dead_robot_is_named_and_all_stop(team):
    for number in (1, 2, 3, 4):
        team.robot(number)
    control = team.forward(*SILENCE)
    team.drives()
    team.robots[2].kill()
    team.at_rest((1, 3, 4))
    assert "robot2" in team.trouble("no fresh odometry of robot2")
    team.probe.wait("control('stale') == [2]")
    wait_until(lambda: "robots stopped: no fresh odometry of robot2" in log_of(control))


@pytest.mark.parametrize("source, said", [("scenario", "restart its driver"), ("first", "count")])
def test_a_restarted_driver_is_noticed_and_not_followed(team, source, said):
    for number in (1, 2):
        team.robot(number)
    control = team.forward("_frame_source:=" + source, *SILENCE, n=2)
    team.drives((1, 2))
    team.robots[2].kill()
    team.trouble("no fresh odometry of robot2")
    team.robot(2, name="again")
    trouble = team.trouble("robot2: the odometry jumped by")
    assert said in trouble and "/pioneer_control/start" in trouble
    assert "initial pose (1.50, -0.30, 0.00)" in trouble
    wait_until(lambda: "robots stopped: robot2: the odometry jumped" in log_of(control))
    team.at_rest((1, 2))
    assert team.probe.ask("control('running')") is False
    team.go()
    wait_until(lambda: team.sent(1) == [0.2, 0.0] and team.sent(2) == [0.2, 0.0])


def test_drivers_left_running_count_from_their_first_message(team):
    team.robot(1)
    before = team.forward(STALLS, n=1)
    team.drives((1,), 0.15)
    team.ros.stop(before)
    team.forward("_frame_source:=first", "_geofence:=[-1, -1, 2.5, 1]", STALLS, n=1)
    # By the scenario it stands at (2.6, 0.2), by its driver 0.15 m farther on.
    team.trouble("robot1 stopped: outside the geofence at (2.6")


def test_a_jump_in_the_simulator_is_noticed_where_that_is_asked_for(ros):
    ros.node("stage", "--robots", 2, "_speed:=3")
    control = ros.node("pioneer_control", "--robots", 2, "_max_jump:=0.3", "_speed:=3")
    probe = ros.probe()
    start = probe.wait("state('x')")
    probe.wait("abs(state('x')[0] - {}) + abs(state('y')[0] + 5.0) > 1.5".format(start[0]), 60)
    assert probe.ask("call('/stage/reset', Trigger)")[0]
    probe.wait("'robot1: the odometry jumped by' in (control('trouble') or '')")
    assert "see where it stands" in probe.ask("control('trouble')")
    wait_until(lambda: "robots stopped: robot1" in log_of(control))


def test_a_dry_run_moves_nothing(team):
    team.robot(1)
    team.robot(2)
    control = team.forward("_dry_run:=true", ENABLE, n=2)
    wait_until(lambda: team.odometry(1) is not None and team.odometry(2) is not None)
    assert team.probe.ask("bool(rospy.ServiceProxy('/robot1/RosAria/disable_motors', Empty)())")
    team.probe.wait("control('command_v') == [0.2, 0.2]")
    assert team.probe.ask("control('dry_run') and control('command_omega') == [0.0, 0.0]")
    assert team.sent(1) is None and team.sent(2) is None
    assert team.probe.wait("newest['/robot1/RosAria/motors_state'].data is False")
    wait_until(lambda: "in a dry run" in log_of(control))


def test_a_missing_motor_service_is_reported_and_no_robot_moves(team):
    team.robot(1)
    control = team.forward("_enable_motors:=/robot{}/motors_on", n=1)
    team.trouble("motors: /robot1/motors_on is missing")
    wait_until(lambda: "/robot1/motors_on is missing" in log_of(control))
    assert team.sent(1) is None


@pytest.mark.parametrize("autostart", ["true", "false"])
def test_a_start_that_waits_for_motors_does_not_survive_a_silence(team, autostart):
    robot = team.robot(1)
    team.probe.ask("offer('/robot1/held')")
    team.forward(HELD, "_autostart:=" + autostart, *SILENCE, n=1)
    if autostart == "false":
        team.trouble("not started")
        wait_until(lambda: team.odometry(1) is not None)
        assert "motors: /robot1/held" in team.go()
    team.trouble("motors: /robot1/held has not answered yet")
    robot.send_signal(signal.SIGSTOP)
    team.trouble("then call the service /pioneer_control/start")
    robot.send_signal(signal.SIGCONT)
    team.probe.ask("gates['/robot1/held'].set()")
    team.probe.wait("control('stale') == []")
    team.at_rest((1,))
    assert team.probe.ask("control('running')") is False
    team.go()
    wait_until(lambda: team.sent(1) == [0.2, 0.0])


def test_the_others_go_on_when_all_motors_have_answered_again(team):
    team.robot(1)
    team.robot(2)
    for number in (1, 2):
        team.probe.ask("offer('/robot{0}/held') and gates['/robot{0}/held'].set()".format(number))
    team.forward(HELD, "_geofence:=[-5, -5, 2.65, 5]", "_v_max:=0.06", STALLS, n=2)
    team.trouble("robot1 stopped: would leave the geofence")
    team.probe.ask("gates['/robot2/held'].clear()")
    assert "motors: /robot" in team.go()
    team.at_rest((1, 2))
    team.probe.ask("gates['/robot2/held'].set()")
    wait_until(lambda: team.sent(1) == [0.0, 0.0] and team.sent(2) == [0.06, 0.0])
    team.probe.wait("control('running') and control('stopped') == [1]")
    team.trouble("robot1 stopped: would leave the geofence")


def test_a_robot_that_leaves_the_fence_stands_and_the_others_go_on(team):
    team.robot(1)
    team.robot(2)
    team.forward("_geofence:=[-5, -5, 2.9, 5]", "_v_max:=0.15", STALLS, n=2)
    team.trouble("robot1 stopped: would leave the geofence")
    wait_until(lambda: team.sent(1) == [0.0, 0.0] and team.sent(2) == [0.15, 0.0])
    assert team.probe.wait("control('stopped')") == [1]
    assert team.probe.ask("control('running')")
    # It stands inside: starting lets it go on, and it is stopped again at once.
    team.go()
    team.trouble("robot1 stopped: would leave the geofence")
    wait_until(lambda: team.sent(1) == [0.0, 0.0] and team.sent(2) == [0.15, 0.0])


def test_each_robot_has_its_own_top_speed(team):
    team.robot(1)
    team.robot(2)
    team.forward("_v_max:=0.1, 0.15", "_omega_max:=[0.5, 1]", STALLS, n=2)
    wait_until(lambda: team.sent(1) == [0.1, 0.0] and team.sent(2) == [0.15, 0.0])


@pytest.mark.parametrize(
    "given, said",
    [
        (
            "[0.1, 0.2, 0.3]",
            "v_max = [0.1, 0.2, 0.3]: wanted a number above 0 [m/s], or 2 such numbers",
        ),
        ("[0.1, 0]", "v_max = [0.1, 0]: wanted a number above 0 [m/s], or 2 such"),
        ("0", "v_max = 0: wanted a number above 0"),
    ],
)
def test_top_speeds_that_cannot_be_are_said(team, given, said):
    control = team.forward("_v_max:=" + given, n=2)
    assert control.wait(PATIENCE) == 2
    assert said in log_of(control) and "Traceback" not in log_of(control)


def test_robots_too_near_stand_both(team):
    for number in (1, 2, 3):
        team.robot(number)
    # Robot 2 and 3 begin 0.86 m apart.
    team.forward("_min_distance:=1.0", STALLS, n=3)
    trouble = team.trouble("robot2 stopped: 0.8")
    assert "robot3 stopped: 0.8" in trouble and "robot1" not in trouble
    wait_until(lambda: team.sent(1) == [0.2, 0.0])
    team.at_rest((2, 3))


def test_external_poses_and_their_silence(team):
    team.robot(1)
    # Its pose never changes, whatever it is told.
    control = team.forward(
        "_frame_source:=external",
        *SILENCE,
        "_pose_timeout:=2",
        "_odom_timeout:=8",
        "_stuck_time:=0",
        n=1,
    )
    team.trouble("no fresh pose on /robot{}/pose of robot1 (never received)")
    camera = (
        "import rospy; from geometry_msgs.msg import PoseStamped; rospy.init_node('camera')\n"
        "out = rospy.Publisher('/robot1/pose', PoseStamped, queue_size=1); m = PoseStamped()\n"
        "m.pose.position.x, m.pose.orientation.w = 7.0, 1.0\n"
        "while not rospy.is_shutdown():\n"
        "    m.header.stamp = rospy.get_rostime(); out.publish(m); rospy.sleep(0.05)"
    )
    process = team.ros.start("camera", [sys.executable, "-c", camera])
    team.drives((1,), 0.02)
    process.kill()
    team.trouble("no fresh pose on /robot{}/pose of robot1")
    team.at_rest((1,))
    wait_until(lambda: "robots stopped: no fresh pose" in log_of(control))


def test_poses_from_tf(team):
    # One driver whose frames are its own: its odometry is the world.
    team.robot(1, "_odom_frame:=world", "_base_link_frame:=robot1/base_link")
    team.forward(
        "_frame_source:=tf", "_geofence:=[-1, -1, 0.2, 1]", *SILENCE, "_pose_timeout:=8", n=1
    )
    team.trouble("robot1 stopped: would leave the geofence before it stands, at (0.")
    team.robots[1].kill()
    team.trouble("no fresh odometry of robot1")


def test_a_missing_transform_is_named(team):
    team.robot(1)  # its frames are odom and base_link, of which nobody knows where they are
    control = team.forward("_frame_source:=tf", n=1)
    team.trouble(
        "no fresh transform on /tf from world to robot{}/base_link of robot1 (never received)"
    )
    # tf's own reason is told too.
    wait_until(lambda: "/tf from world to robot1/base_link: " in log_of(control))


def begin_preflight(team, *arguments, limit=20, name="preflight", **given):
    """Start the preflight as the node ``name``, which waits ``limit`` [s] for robots."""
    asked = "_time_limit:={}".format(limit), "__name:=" + name
    return team.node("preflight", *asked, *arguments, name=name, **given)


def end_preflight(process):
    """Return the exit code of a preflight and what it printed, once it has ended."""
    code = process.wait(60)
    text = log_of(process)
    os.truncate(process.log, 0)
    return code, text


def preflight(team, *arguments, **given):
    """Run the preflight; return its exit code and what it printed."""
    return end_preflight(begin_preflight(team, *arguments, **given))


def axis(key, nominal, breaks):
    """Return an axis as margins.json has it."""
    end = breaks + breaks - nominal
    plain = {"key": key, "unit": "", "nominal": nominal, "end": end}
    return {**plain, "breaks": {"kept": [breaks, breaks]}}


def test_preflight_of_robots_that_stand_ready(team, tmp_path):
    for number in (1, 2, 3, 4):
        team.robot(number)
    for number in (1, 2, 3, 4):
        wait_until(lambda number=number: team.odometry(number) is not None)
    bounds = "_min_distance:=0.6", "_geofence:=[-2, -2, 5, 2]", STALLS
    # They publish every 0.1 s; a law that breaks below 40 Hz has no margin of 1.5 left, nor has its delay.
    axes = [axis("control.rate", 50.0, 40.0), axis("mismatch.delay", 0.0, 0.21)]
    slowed = load_scenario(team.scenario)._replace(limits=LoweredLimits("firmware", 0.2))
    stamp = stamp_of(slowed)
    (tmp_path / "margins.json").write_text(json.dumps({"axes": axes, "stamp": stamp}))
    (tmp_path / "compare.json").write_text('{"mismatch": {"delay": 0.155}}')
    given = "--margins", str(tmp_path), "--measured", str(tmp_path / "compare.json")
    other = tmp_path / "other.yaml"
    other.write_text(SCENARIO.replace("k: 0.1", "k: 0.2"))
    # At the same time: each listens for some seconds.
    ready = begin_preflight(team, *bounds, "_v_max:=0.2")
    fast = begin_preflight(team, *bounds, "_v_max:=0.75", name="fast")
    near = begin_preflight(team, *bounds, "_v_max:=0.2", *given, name="near")
    moved = "--scenario", other, *bounds, "_v_max:=0.2", *given
    moved = begin_preflight(team, *moved, name="moved")
    code, text = end_preflight(ready)
    assert code == 0 and "NOT OK" not in text and "\nready" in text, text
    code, text = end_preflight(fast)
    assert code == 1 and "NOT OK  stopping way" in text and "0.21 m/s would hold" in text, text
    assert "robot4 is fresh" in text and "predicted geofence" in text
    code, text = end_preflight(near)
    assert code == 1 and "NOT OK  margin of control.rate" in text, text
    assert "0.155 measured, kept breaks at 0.21, wanted 1.5 times" in text, text
    assert "\nOK      margins " in text
    code, text = end_preflight(moved)
    assert code == 1 and "NOT OK  margins " in text and "of another scenario" in text, text
    # The same robots, asked for more.
    code, text = preflight(team, "_frame_source:=odometry", "_geofence:=[-2, -2, 2, 2]")
    assert code == 1, text
    assert "NOT OK  robot1 stands in place" in text and "2.61 m" in text
    assert "NOT OK  distances" in text and "robot1 and robot2 0.00 m apart" in text
    assert ", wanted 1 m" in text  # what the run before was given is forgotten
    assert "not predicted" in text


def test_preflight_names_who_is_missing_and_bad_input(team):
    team.robot(1)
    team.probe.ask("watch_diagnostics()")
    wait_until(lambda: team.odometry(1) is not None)
    code, text = preflight(team, n_robots(2), limit=2)
    assert code == 1 and "NOT OK  robot2 publishes" in text, text
    level, message, values = team.probe.wait("diagnostics.get('preflight')")
    assert "checks not OK" in message and values["not OK 1"] == "robot2 publishes"
    assert level == 2 and values["silent_robots"] == "1"
    assert "never received on /robot2/RosAria/pose" in text
    assert "OK      robot1 publishes" in text and "not all poses are known" in text
    code, text = preflight(team, "_geofence:=[1, 2, 0, 4]")
    assert code == 2 and "x_min < x_max" in text and "Traceback" not in text


def test_a_later_preflight_counts_from_where_the_running_controller_began(team):
    team.robot(1)
    first = "_frame_source:=first"
    control = team.forward(first, STALLS, n=1)
    team.drives((1,), 0.3)
    assert team.probe.ask("call('/pioneer_control/stop', Trigger)")[0]
    team.at_rest((1,))
    near = "NOT OK  geofence"
    fence = "_geofence:=[-1, -1, 2.8, 1]"
    code, text = preflight(team, n_robots(1), first, fence, STALLS)
    # The scenario has it at (2.6, 0.2); it has gone on since.
    assert code == 1 and near in text, text
    team.ros.stop(control)
    _, text = preflight(team, n_robots(1), first, fence, STALLS)
    assert near not in text, text


@pytest.mark.parametrize("resume", [False, True])
def test_after_a_silence_they_go_on_when_asked_to(team, resume):
    robot = team.robot(1)
    team.forward(*SILENCE, *["_resume:=true"] * resume, n=1)
    team.drives((1,))
    robot.send_signal(signal.SIGSTOP)
    trouble = team.trouble("no fresh odometry of robot1")
    assert ("then call the service /pioneer_control/start" in trouble) is not resume
    team.at_rest((1,))
    if not resume:
        done, said = team.probe.ask(START)
        assert not done and said.startswith("no fresh odometry of robot1")
    robot.send_signal(signal.SIGCONT)
    if not resume:
        team.probe.wait("control('stale') == []")
        assert team.probe.ask("control('running')") is False
        assert team.sent(1) == [0.0, 0.0]
        team.go()
    wait_until(lambda: team.sent(1) == [0.2, 0.0])


def test_a_robot_that_is_commanded_to_move_and_does_not_stands_alone(team):
    team.robot(1)
    team.robot(2)
    wait_until(lambda: team.odometry(1) is not None and team.odometry(2) is not None)
    assert team.probe.ask("switch('/robot2/RosAria/disable_motors')")
    control = team.forward("_frozen_time:=2", "_stuck_time:=0", STALLS, n=2)
    stuck = (
        "robot2 stopped: commanded to move at 0.20 m/s, 0.00 rad/s, and for 2 s its odometry says"
    )
    team.trouble(stuck)
    wait_until(lambda: stuck in log_of(control))
    wait_until(lambda: team.sent(2) == [0.0, 0.0] and team.sent(1) == [0.2, 0.0])
    assert team.probe.wait("control('stopped')") == [2]
    assert team.probe.ask("switch('/robot2/RosAria/enable_motors')")
    assert team.go() == "running"
    team.drives((2,))
    assert team.probe.wait("control('trouble') == ''")


def test_an_emergency_button_is_published_at_once_and_a_lost_link_soon(team):
    team.robot(1)
    team.robot(2)
    wait_until(lambda: team.odometry(1) is not None and team.odometry(2) is not None)
    state, slow = "_motors_state:=/robot{}/RosAria/motors_state", "_frozen_time:=3"
    team.forward(ENABLE, state, slow, "_stuck_time:=0", STALLS, n=2)
    team.drives((1, 2))
    assert team.probe.ask("switch('/robot2/RosAria/disable_motors')")
    team.trouble("robot2 stopped: its motors are off (motors_state)")
    wait_until(lambda: team.sent(2) == [0.0, 0.0] and team.sent(1) == [0.2, 0.0])
    team.go()  # which switches them on
    team.drives((1, 2), 0.05)
    # The driver repeats its last pose, as it does without its robot.
    assert team.probe.ask("switch('/robot2/RosAria/lose_link')")
    team.trouble(
        "robot2 stopped: commanded to move at 0.20 m/s, 0.00 rad/s, and for 3 s its odometry"
    )
    wait_until(lambda: team.sent(2) == [0.0, 0.0] and team.sent(1) == [0.2, 0.0])


def test_a_record_begins_with_the_first_motion_and_ends_with_a_jump(team, tmp_path):
    team.robot(1)
    team.robot(2)
    out = tmp_path / "run"
    record = team.node("record", "--protocol", team.law, "--out", out, n=2)
    team.forward("_autostart:=false", *SILENCE, n=2)
    team.probe.wait("control('trouble') == 'not started'")
    wait_until(lambda: team.odometry(1) is not None and team.odometry(2) is not None)
    wait_until(lambda: READY in log_of(record))
    # Zeros, which are told before the start too, are no beginning.
    assert team.probe.ask("call('/pioneer_control/stop', Trigger)")[0]
    team.at_rest((1, 2))
    assert READY in log_of(record) and "recording" not in log_of(record)
    team.go()
    team.drives((1, 2))
    team.robots[2].kill()
    team.trouble("no fresh odometry of robot2")
    team.robot(2, name="again")
    verdict = team.ros.judged(record, out)
    run = read_run_csv(str(out / "run.csv"))
    told = run.command[run.command.any(axis=2).all(axis=1)]  # they are told one after the other
    assert run.command[0].any() and told[0].tolist() == [[0.2, 0.0]] * 2
    np.testing.assert_allclose(run.pose[0], STARTS[:2], atol=0.05)
    assert not verdict["passed"]
    assert verdict["ended"].startswith("robot2: the odometry jumped by")


@pytest.mark.parametrize("frame", ["scenario", "first"])
def test_what_comes_before_the_start_is_no_part_of_a_record(team, tmp_path, frame):
    team.robot(1)
    out, source = tmp_path / "run", "_frame_source:=" + frame
    record = team.node("record", "--protocol", team.law, "--out", out, "--duration", 1, source, n=1)
    control = team.forward("_autostart:=false", source, STALLS, n=1)
    # It knows where the robot stands: what it never received cannot jump.
    team.probe.wait("control('trouble') == 'not started' and control('stale') == []")
    wait_until(lambda: READY in log_of(record))
    joystick = team.ros.start("joystick", JOYSTICK)
    team.drives((1,), 0.05)
    # Put back on its mark, with its driver started again.
    team.ros.stop(joystick)
    team.ros.stop(team.robots[1])
    time.sleep(RESTART)
    team.robot(1, name="again")
    wait_until(lambda: "robot1: the odometry jumped" in log_of(control))
    assert "recording" not in log_of(record)
    team.go()
    team.ros.judged(record, out)
    run = read_run_csv(str(out / "run.csv"))
    np.testing.assert_allclose(run.pose[0], STARTS[:1], atol=0.05)
    assert run.command[0].tolist() == [[0.2, 0.0]]
    with open(str(out / "verdict.json")) as file:
        assert json.load(file)["ended"] == "complete"


def test_a_record_of_a_dry_run_says_that_there_is_nothing(team, tmp_path):
    team.robot(1)
    record = team.node("record", "--out", tmp_path / "run", n=1)
    wait_until(lambda: READY in log_of(record))
    team.forward("_dry_run:=true", n=1)
    team.probe.wait("control('command_v') == [0.2]")
    record.send_signal(signal.SIGINT)
    assert record.wait(PATIENCE) == 1
    assert "nothing was recorded: no command reached the robots" in log_of(record)


def test_a_start_waits_for_motors_that_answer(team):
    team.robot(1)
    wait_until(lambda: team.odometry(1) is not None)
    state = "_motors_state:=/robot{}/RosAria/motors_state"
    team.forward(ENABLE, state, "_autostart:=false", STALLS, n=1)
    assert team.probe.ask("switch('/robot1/RosAria/disable_motors')")
    team.trouble("not started")
    assert team.go() == "running"
    team.drives((1,))
    assert team.go() == "running already"


def n_robots(n):
    return "_robots:={}".format(n)


def test_the_launch_file_drives_them(team, tmp_path):
    # Of 15 poses a second samples at 10 Hz leave out every third: a difference would be 0.27 m/s.
    for number in (1, 2, 3, 4):
        team.robot(number, "_rate:=15")
    wanted = "\nrecord_rate: 10\nrequirements: {slow: always(each robot(speed < 0.22 m/s))}\n"
    team.scenario.write_text(SCENARIO + wanted)
    left = {"lockstep": True, "rate": 0.1}  # by a launch before, on this master
    xmlrpc.client.ServerProxy(team.ros.uri).setParam("/test", "/pioneer_control", left)
    given = "scenario:={}".format(team.scenario), "out:={}".format(tmp_path / "run"), "duration:=11"
    command = "mrs_simulator", "rosaria.launch", "drivers:=false", "v_max:=0.2", *given, STALLS[1:]
    launch = team.ros.launch(*command)
    team.probe.wait("control('trouble') == 'not started'", 60)
    wait_until((tmp_path / "run" / "run.bag.active").exists)
    wait_until(lambda: READY in log_of(launch))
    assert team.sent(1) is None
    team.go()
    wait_until(team.in_line, 60)
    assert len(team.probe.wait("control('command_v')")) == 4
    assert team.probe.ask("control('stopped')") == []
    wait_until(lambda: launch.poll() is not None, 3 * PATIENCE)
    assert (tmp_path / "run" / "run.bag").exists(), log_of(launch)
    with open(str(tmp_path / "run" / "verdict.json")) as file:
        verdict = json.load(file)
    run = read_run_csv(str(tmp_path / "run" / "run.csv"))
    assert "law failed" not in log_of(launch)
    # From where the scenario says that they stood, with the commands that moved them.
    np.testing.assert_allclose(run.pose[0], STARTS, atol=0.05)
    assert verdict["ended"] == "complete" and verdict["robots"] == 4
    assert run.command[0].any() and run.time[-1] >= 11.0
    checks = {check["name"]: check for check in verdict["checks"]}
    assert checks["collisions"]["passed"] is None
    assert checks["final gap, the worst [m]"]["passed"], verdict
    # Commands follow from poses of some time before, and keep to the law all the same.
    commands = checks["commands off the published law [-]"]
    assert commands["passed"] and commands["tolerance"] == 0.05, commands
    assert 0.0 <= verdict["command_delay"] < 0.5
    (slow,) = verdict["requirements"]
    assert slow["met"] and slow["margin"] == pytest.approx(0.02), slow
    assert read_provenance(str(tmp_path / "run"))["recorded_of"] == ROBOTS
    assert reproduce(str(tmp_path / "run")) == 0  # its figures, of run.csv
    files = set(os.listdir(str(tmp_path / "run")))
    assert {"scenario.yaml", "trajectories.png", "inputs.pdf"} <= files


def test_the_launch_file_starts_a_driver_for_each_of_any_number_of_robots(ros, tmp_path):
    # The driver's own package is not installed where the tests run.
    (tmp_path / "package.xml").write_text(
        "<package><name>rosaria</name><version>1.0.0</version><description>-</description>"
        "<maintainer email='a@b.c'>-</maintainer><license>BSD</license></package>"
    )
    paths = os.environ["ROS_PACKAGE_PATH"]
    ros.environment["ROS_PACKAGE_PATH"] = "{}:{}".format(tmp_path, paths)
    command = "roslaunch", "--dump-params", "mrs_simulator", "rosaria.launch", "out:=run"
    given = yaml.safe_load(ros.call(*command, "robots:=6", "ports:=/dev/a, 10.0.0.2:8101,,/dev/d"))
    ports = ["/dev/a", "10.0.0.2:8101", "/dev/ttyUSB2", "/dev/d", "/dev/ttyUSB4", "/dev/ttyUSB5"]
    names = ["/robot{}/RosAria/".format(number) for number in range(1, 7)]
    assert [given[name + "port"] for name in names] == ports
    assert given["/robot6/RosAria/odom_frame"] == "robot6/odom"
    assert "/robot7/RosAria/port" not in given
    for node in ("pioneer_control", "record"):
        assert given["/{}/odom_topic".format(node)] == "/robot{}/RosAria/pose"
        assert given["/{}/cmd_vel_topic".format(node)] == "/robot{}/RosAria/cmd_vel"


def test_a_law_stops_by_rosarias_sonar_and_never_moves_on_a_stale_one(team):
    team.robot(1, "_wall:=1.0")
    team.robot(2, "_wall:=6.0")
    team.law.write_text(STOPS)
    sonars = "_sensor_topic:=/robot{}/RosAria/*"
    given = AT_ONCE, sonars, STALLS, "_sensor_timeout:=2", "_frozen_time:=8", "_stuck_time:=8"
    control = team.node("pioneer_control", "--protocol", team.law, *given, n=2)
    team.drives((1, 2), 0.1)
    wait_until(lambda: team.sent(1) == [0.0, 0.0] and team.sent(2) == [0.3, 0.0])
    # 0.5 m before the transducers at 166 mm, a packet late, and 0.15 m on by the firmware's ramp.
    team.probe.wait("newest['/robot1/RosAria/pose'].twist.twist.linear.x == 0.0")
    assert 0.33 < team.odometry(1)[0] < 0.7
    team.probe.ask("bool(rospy.ServiceProxy('/robot2/RosAria/lose_sonar', Empty)())")
    check = begin_preflight(team, "--protocol", team.law, sonars, limit=1, n=2)
    assert "robot1" not in team.trouble("no fresh sonar of robot2 (2.")
    team.at_rest((1, 2))
    assert team.probe.ask("control('stale')") == [2]
    assert team.probe.ask("control('running')") is False  # real robots go on when they are told to
    code, text = end_preflight(check)
    assert code == 1 and "sensors heard" in text and "no fresh sonar of robot2" in text
    wait_until(lambda: "robots stopped: no fresh sonar of robot2" in log_of(control))


def test_the_same_law_stops_by_p2os_sonar(ros, team):
    for number, sonar in ((1, "true"), (2, "false")):
        names = "__name:=p2os_driver", "__ns:=/robot{}".format(number), "_use_sonar:=" + sonar
        ros.start("p2os{}".format(number), [sys.executable, P2OS, *names, "_wall:=1.0"])
    team.law.write_text(STOPS)
    topics = "_odom_topic:=/robot{}/pose", "_cmd_vel_topic:=/robot{}/cmd_vel"
    motors = "_enable_motors:=/robot{}/cmd_motor_state p2os_msgs/MotorState"
    known = "--scenario", team.scenario, "--protocol", team.law, "--odometry", "wheel"
    for number in (1, 2):
        team.probe.ask("listen('/robot{}/pose', Odometry)".format(number))
    team.probe.wait("all('/robot%d/pose' % n in newest for n in (1, 2))")
    second = ros.node("preflight", *known, "--robots", 2, *topics, "_time_limit:=5", name="check")
    ros.node("pioneer_control", *known, "--robots", 1, AT_ONCE, *topics, motors)
    team.probe.ask("listen('/robot1/cmd_vel', Twist)")
    driven = "newest['/robot1/pose'].pose.pose.position.x"
    team.probe.wait("'/robot1/pose' in newest and {} > 0.1".format(driven))
    team.probe.wait("newest['/robot1/cmd_vel'].linear.x == 0.0")
    team.probe.wait("newest['/robot1/pose'].twist.twist.linear.x == 0.0")
    assert 0.33 < team.probe.ask(driven) < 0.7
    assert second.wait(PATIENCE) == 1
    assert (
        "robot2 (never received, refused: no distances: is the driver's parameter use_sonar true?)"
        in (log_of(second))
    )
    assert "robot1 (never" not in log_of(second)
