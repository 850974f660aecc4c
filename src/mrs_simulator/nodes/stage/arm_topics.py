"""Topics of the simulated arms: joint states out, trajectories and rates of joints in."""

import importlib.util
import threading

import numpy as np
import rospy
from sensor_msgs.msg import JointState

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.vehicles.arms.path import JointPath, PathError

STATES, COMMAND = "/robot{}/joint_states", "/robot{}/arm_controller/command"
TRAJECTORIES = "trajectory_msgs"  # the package of the messages in which trajectories come
ACTIONS = "actionlib", "control_msgs"  # those that the action wants besides
BROKEN_OFF = "another trajectory, or other commands, came instead"


class ArmTopics(StagePart):
    """``joint_states`` and ``arm_controller/command`` of each robot with an arm, as ros_controllers name
    them, and the rates of joints in the stage's own ``command``."""

    def __init__(self, world, inbox):
        """``inbox``: the stage's, of commands."""
        self._world, self._inbox = world, inbox
        self._lock, self._open, self._chains = threading.Lock(), [], {}
        self._asked, self._paths = {}, {}  # by row: a message; a path and when [s] it began
        self._can_hear = _are_there(TRAJECTORIES)
        self._outcomes = {}  # by row: None while it goes on, "" when it has ended, else why it did not

    def follow_team(self, scenario):
        for topic in self._open:
            withdraw(topic)
        self._open, self._states, self._paths = [], {}, {}
        team = self._world.team
        groups = team.arms if team.has_arms else ()
        self._chains = {int(row): group.chain for group in groups for row in group.rows}
        for row in self._chains:
            name = STATES.format(row + 1)
            self._states[row] = rospy.Publisher(name, JointState, queue_size=1, tcp_nodelay=True)
            self._open.append(self._states[row])
        if self._chains and not self._can_hear:
            rospy.logwarn("stage: no trajectories of arms: %s is not installed", TRAJECTORIES)
        elif self._chains:
            self._listen()

    def _listen(self):
        from trajectory_msgs.msg import JointTrajectory  # only where it is used: not all have it

        if _are_there(*ACTIONS):
            from mrs_simulator.nodes.stage.arm_actions import ArmAction

            actions = [ArmAction(row, self.put, self._outcomes.get) for row in self._chains]
            self._open.extend(actions)
        for row in self._chains:
            name = COMMAND.format(row + 1)
            self._open.append(
                rospy.Subscriber(name, JointTrajectory, self._on_command, row, queue_size=1)
            )

    def _on_command(self, message, row):
        self.put(row, message)

    def put(self, row, message):
        """Let the arm of robot ``row`` follow a trajectory from the next step on; None stops it."""
        with self._lock:
            self._asked[row], self._outcomes[row] = message, None

    def taken(self, rows, commands):
        """Return ``commands`` (m, a) of the bases of robots ``rows`` with those of their arms, (m, a + k).

        Of arms without a command they are as before.
        """
        team = self._world.team
        if not team.has_arms:
            return commands
        result = np.array(self._world.command[rows])
        result[:, : commands.shape[1]] = commands
        rates = self._inbox.take_arms()
        for place, row in enumerate(rows):
            if row in rates and len(rates[row]) == team.arm_joints:
                result[place, commands.shape[1] :] = rates[row]
                self._break_off(row)
        return result

    def _break_off(self, row):
        """Let the arm of robot ``row`` follow its trajectory no longer."""
        if self._paths.pop(row, None) is not None:
            self._outcomes[row] = BROKEN_OFF

    def advance(self):
        """Let arms that follow trajectories go on, before the world's next step."""
        if not self._chains:
            return
        with self._lock:
            asked, self._asked = self._asked, {}
        for row, message in asked.items():
            self._begin(row, message)
        world = self._world
        for row, (path, begun) in list(self._paths.items()):
            q, k = world.joints[row, 1:], len(self._chains[row].joints)
            since = world.time - begun
            rates = np.zeros(len(q))
            if since < path.end:
                rates[:k] = (path.at(since + world.step_size) - q[:k]) / world.step_size
            else:
                del self._paths[row]
                self._outcomes[row] = ""
            world.commands.set_arm_rates(row, rates)

    def _begin(self, row, message):
        """Let the arm of robot ``row`` follow ``message``; a trajectory without points stops it."""
        chain = self._chains.get(row)
        if chain is None:
            return
        begin = self._world.joints[row, 1 : 1 + len(chain.joints)]
        given = () if message is None else message.points
        points = [point.positions for point in given]
        times = [point.time_from_start.to_sec() for point in given]
        names = chain.joints if message is None else message.joint_names or chain.joints
        try:
            path = JointPath(chain, begin, names, points, times)
        except PathError as error:
            rospy.logerr("stage: refused a trajectory of robot%d's arm: %s", row + 1, error)
            self._outcomes[row] = str(error)
            return
        self._paths[row] = path, self._world.time

    def reset(self):
        """Let no arm follow a trajectory any longer: robots were put elsewhere."""
        for row in list(self._paths):
            self._break_off(row)

    def publish(self, stamp):
        world = self._world
        for row, publisher in self._states.items() if self._chains else ():
            if publisher.get_num_connections():
                names = self._chains[row].joints
                message = JointState(name=list(names))
                message.header.stamp = stamp
                message.position = world.joints[row, 1 : 1 + len(names)].tolist()
                message.velocity = world.team.split(world.command)[1][row, : len(names)].tolist()
                publisher.publish(message)


def _are_there(*packages):
    """Return whether all ``packages`` are installed."""
    return all(importlib.util.find_spec(package) is not None for package in packages)
