"""Robots with arms over ROS: a load carried in lockstep, joint states and trajectories."""

import importlib.util
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from ros_fixtures import log_of, ros  # noqa: F401  a fixture
from test_carrying import scenario

from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.results.bag_reading import read_bag
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles.arms.models import PANDA, chain_of
from mrs_simulator.vehicles.arms.path import JointPath, PathError

BEND = """
import json, sys, rospy
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rospy.init_node("bend")
names = json.loads(sys.argv[1])
wanted = [0.1, 0.4, 0.0, -1.8, 0.0, 2.2, 0.785]
out = rospy.Publisher("/robot2/arm_controller/command", JointTrajectory, queue_size=1)
heard, told = [], []
rospy.Subscriber("/robot2/joint_states", JointState, heard.append)
log = rospy.Subscriber("/rosout", Log, lambda message: told.append(message.msg))
while not out.get_num_connections() or not heard or not log.get_num_connections():
    rospy.rostime.wallsleep(0.01)
wrong = JointTrajectory(joint_names=names[:3])
out.publish(wrong)
while not any("refused a trajectory" in each for each in told):
    rospy.rostime.wallsleep(0.01)
point = JointTrajectoryPoint(positions=wanted[::-1], time_from_start=rospy.Duration(1.0))
out.publish(JointTrajectory(joint_names=names[::-1], points=[point]))
while True:
    last = dict(zip(heard[-1].name, heard[-1].position))
    if max(abs(last[n] - w) for n, w in zip(names, wanted)) < 1e-6:
        break
    rospy.rostime.wallsleep(0.01)
print(json.dumps([list(heard[0].position), [last[n] for n in names]]))
"""


def test_a_path_is_passed_on_straight_lines_and_refused_where_it_cannot_be():
    chain, begin = chain_of(PANDA), np.array(PANDA.home)
    path = JointPath(chain, begin, chain.joints, [begin + 0.2, begin + 0.1], [1.0, 3.0])
    assert path.end == 3.0
    np.testing.assert_allclose(path.at(0.5), begin + 0.1)
    np.testing.assert_allclose(path.at(2.0), begin + 0.15)
    np.testing.assert_allclose(path.at(9.0), begin + 0.1)
    turned = JointPath(chain, begin, chain.joints[::-1], [(begin + 0.2)[::-1]], [1.0])
    np.testing.assert_allclose(turned.at(1.0), begin + 0.2)
    assert JointPath(chain, begin, chain.joints, [], []).end == 0.0
    for names, points, times, words in (
        (chain.joints[:2], [begin[:2]], [1.0], "joints panda_joint1, panda_joint2, wanted"),
        (chain.joints, [begin[:3]], [1.0], "wanted 7 positions each"),
        (chain.joints, [begin + 9.0], [1.0], "beyond an end"),
        (chain.joints, [begin * np.nan], [1.0], "beyond an end"),
        (chain.joints, [begin, begin], [1.0, 1.0], "wanted ascending"),
    ):
        with pytest.raises(PathError, match=words):
            JointPath(chain, begin, names, points, times)


LISTEN = """
import json, rospy
from geometry_msgs.msg import PoseStamped, WrenchStamped
rospy.init_node("listen")
pose = rospy.wait_for_message("/load/pose", PoseStamped, 60.0)
wrench = rospy.wait_for_message("/robot2/grasp/wrench", WrenchStamped, 60.0)
at, force = pose.pose.position, wrench.wrench.force
print(json.dumps([pose.header.frame_id, at.x, at.y, at.z, force.x, force.y, force.z]))
"""


def test_a_load_is_carried_and_dropped_alike_over_ros(ros, tmp_path):  # noqa: F811
    content = scenario(speed=0.0)
    content["duration"] = 1.2
    content["control"]["parameters"].update(gain=-0.6, coupling=0.0)  # pulls ever harder
    content["load"]["grip"] = 45.0
    given = scenario_from_dict(content)
    path = tmp_path / "team.yaml"
    path.write_text(given.to_yaml())
    ros.node("stage", "--scenario", path, "_lockstep:=true", "_wait_for_recorders:=2")
    bag = ros.start("bag", ["rosbag", "record", "-O", str(tmp_path / "run.bag"), "/stage/state"])
    record = ros.node("record", "--scenario", path, "--out", tmp_path / "out")
    ros.node("pioneer_control", "--scenario", path, "_lockstep:=true")
    ros.judged(record, tmp_path / "out")
    ros.stop(bag)
    frame, *told = json.loads(ros.python(LISTEN))
    run_experiment(given, str(tmp_path / "headless"), formats=())
    runs = [read_run_csv(str(tmp_path / name / "run.csv"), given) for name in ("out", "headless")]
    runs.append(read_bag(str(tmp_path / "run.bag"), given))
    samples = min(len(run.time) for run in runs)
    assert samples > 10 and runs[0].axes == runs[1].axes
    assert np.abs(np.diff(runs[0].joints[:samples, :, 1:], axis=0)).max() > 1e-3
    for name in ("points", "joints", "command", "pose"):
        mine, theirs, bagged = (getattr(run, name)[:samples] for run in runs)
        np.testing.assert_allclose(mine, theirs, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(bagged, theirs, atol=1e-6, err_msg=name)
    dropped = np.flatnonzero(~runs[1].load.force.any(axis=(1, 2)))[0]
    assert 3 < dropped < samples - 1
    for mine, theirs, bagged in zip(*(run.load.at(slice(samples)) for run in runs)):
        np.testing.assert_allclose(mine, theirs, atol=1e-6)
        np.testing.assert_allclose(bagged, theirs, atol=1e-6)
    assert [(i.robot, i.what) for i in runs[0].meta["incidents"]] == [("robot2", "load_fell")]
    checks = json.loads((tmp_path / "out" / "verdict.json").read_text())["checks"]
    (gone,) = [check for check in checks if check["name"] == "robots that let go"]
    assert gone["measured"] == 3
    assert frame == "world" and told[2] == 0.05 and told[3:] == [0.0, 0.0, 0.0]


@pytest.mark.skipif(
    importlib.util.find_spec("trajectory_msgs") is None, reason="trajectory_msgs is not installed"
)
def test_an_arm_follows_a_trajectory_and_tells_its_joints(ros, tmp_path):  # noqa: F811
    content = scenario()
    del content["load"]
    content["control"] = {"protocol": "consensus", "rate": 20}
    path = tmp_path / "team.yaml"
    path.write_text(scenario_from_dict(content).to_yaml())
    stage = ros.node("stage", "--scenario", path, "_speed:=5", "_wait_for_control:=false")
    first, last = json.loads(ros.python(BEND, json.dumps(PANDA.joints)))
    np.testing.assert_allclose(first, PANDA.home)
    np.testing.assert_allclose(last, [0.1, 0.4, 0.0, -1.8, 0.0, 2.2, 0.785], atol=1e-6)
    assert "refused a trajectory of robot2's arm: joints panda_joint1" in log_of(stage)


# Messages of the action as control_msgs has them, which few systems have: made here where genpy is.
GENERATOR = "/usr/lib/genpy/genmsg_py.py"
PARTS = {
    "trajectory_msgs": {
        "JointTrajectoryPoint": "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\n"
        "float64[] effort\nduration time_from_start",
        "JointTrajectory": "Header header\nstring[] joint_names\nJointTrajectoryPoint[] points",
    },
    "control_msgs": {
        "JointTolerance": "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration",
        "FollowJointTrajectoryGoal": "trajectory_msgs/JointTrajectory trajectory\n"
        "JointTolerance[] path_tolerance\nJointTolerance[] goal_tolerance\nduration goal_time_tolerance",
        "FollowJointTrajectoryResult": "int32 error_code\nint32 SUCCESSFUL=0\nint32 INVALID_GOAL=-1\n"
        "string error_string",
        "FollowJointTrajectoryFeedback": "Header header\nstring[] joint_names\n"
        "trajectory_msgs/JointTrajectoryPoint desired\ntrajectory_msgs/JointTrajectoryPoint actual\n"
        "trajectory_msgs/JointTrajectoryPoint error",
        "FollowJointTrajectoryActionGoal": "Header header\nactionlib_msgs/GoalID goal_id\n"
        "FollowJointTrajectoryGoal goal",
        "FollowJointTrajectoryActionResult": "Header header\nactionlib_msgs/GoalStatus status\n"
        "FollowJointTrajectoryResult result",
        "FollowJointTrajectoryActionFeedback": "Header header\nactionlib_msgs/GoalStatus status\n"
        "FollowJointTrajectoryFeedback feedback",
        "FollowJointTrajectoryAction": "FollowJointTrajectoryActionGoal action_goal\n"
        "FollowJointTrajectoryActionResult action_result\n"
        "FollowJointTrajectoryActionFeedback action_feedback",
    },
}
WANTED = ("actionlib", "actionlib_msgs", "trajectory_msgs")
GOALS = """
import json, sys, actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rospy.init_node("goals")
names = json.loads(sys.argv[1])
name = "/robot1/arm_controller/follow_joint_trajectory"
client = actionlib.SimpleActionClient(name, FollowJointTrajectoryAction)
client.wait_for_server()
said = []
for positions in ([0.1, 0.3, 0.0, -1.9, 0.0, 2.2, 0.785], [9.0] * 7):
    point = JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(0.5))
    goal = FollowJointTrajectoryGoal(trajectory=JointTrajectory(joint_names=names, points=[point]))
    client.send_goal(goal)
    client.wait_for_result()
    said.append([client.get_state(), client.get_result().error_code, client.get_result().error_string])
print(json.dumps(said))
"""


def made_messages(directory):
    """Make a package control_msgs in ``directory``."""
    places = ["-I{0}:/usr/share/{0}/msg".format(name) for name in ("std_msgs", "actionlib_msgs")]
    for package, parts in PARTS.items():
        source = directory / "source" / package
        source.mkdir(parents=True)
        places.append("-I{}:{}".format(package, source))
        for name, text in parts.items():
            (source / (name + ".msg")).write_text(text + "\n")
    out = directory / "made" / "control_msgs" / "msg"
    out.mkdir(parents=True)
    (out.parent / "__init__.py").write_text("")
    sources = sorted(map(str, (directory / "source" / "control_msgs").iterdir()))
    command = [sys.executable, GENERATOR, *places, "-p", "control_msgs", "-o", str(out)]
    subprocess.run(command + sources, check=True)
    lines = ["from ._{0} import {0}".format(name) for name in PARTS["control_msgs"]]
    (out / "__init__.py").write_text("\n".join(lines) + "\n")
    return str(directory / "made")


@pytest.mark.skipif(
    not os.path.exists(GENERATOR) or not all(map(importlib.util.find_spec, WANTED)),
    reason="the action's packages, or genpy, are not installed",
)
def test_an_arm_follows_the_goals_of_an_action(ros, tmp_path):  # noqa: F811
    made = made_messages(tmp_path)
    ros.paths.append(made)
    content = scenario()
    del content["load"]
    content["control"] = {"protocol": "consensus", "rate": 20}
    path = tmp_path / "team.yaml"
    path.write_text(scenario_from_dict(content).to_yaml())
    ros.node("stage", "--scenario", path, "_speed:=5", "_wait_for_control:=false")
    reached, refused = json.loads(ros.python(GOALS, json.dumps(PANDA.joints)))
    assert reached == [3, 0, ""]  # succeeded
    assert refused[:2] == [4, -1] and "beyond an end of its joint" in refused[2]  # aborted


def test_a_history_keeps_the_joints_of_arms():
    from snapshots import snapshot_of

    from mrs_simulator.rqt_plugin.run.history import History
    from mrs_simulator.state.columns import SPATIAL, arm_axes

    history, axes = History(), ("linear.x", "angular.z", *arm_axes(3))
    joints = np.arange(8.0).reshape(2, 4)
    command = np.arange(10.0).reshape(2, 5)
    for time in (0.0, 0.1):
        here = np.zeros((2, 3)), np.zeros((2, 3)), command + time, np.ones(2, dtype=bool)
        history.append(snapshot_of(time, (1, 2), *here, axes=axes, joints=joints + time))
    np.testing.assert_array_equal(history.state.joints, [joints, joints + 0.1])
    np.testing.assert_array_equal(history.state.command[0], command)
    assert not history.state.has(SPATIAL)
