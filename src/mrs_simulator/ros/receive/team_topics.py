"""The control node's end of the topics of whole teams, for teams of hundreds.

A topic of its own for each robot costs rospy a thread and some system calls per robot and message;
the contents are the same.
"""

import time

import rosgraph
import rospy

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.ros.message_forms.messages import TeamCommand, team_command
from mrs_simulator.ros.node.node_parameters import CMD_VEL_TOPIC, ODOM_TOPIC, TEAM_TOPICS
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.nonblocking_publisher import prompt_publisher

ODOMETRY, COMMAND = "stage/odometry", "stage/command"  # names as the control node resolves them
ANSWERS = "stage/answers"
TEAM_FROM = 50  # [-] robots from which on the control node uses them by itself
PATIENCE = 15.0  # [s] of wall time to wait for a simulator before each robot gets its own topics
NAP = 0.2  # [s] of wall time between two looks


def team_topics_wanted(n, together=False):
    """Return whether the control of n robots is to use them: ``~team_topics``: auto, always or never.

    auto: from ``TEAM_FROM`` simulated robots on, if a stage offers them; without any simulator for
    ``PATIENCE`` [s] of wall time it does not.  ``together``: whether commands of some robots are more
    than a Twist, so that a stage is always commanded all at once.
    """
    choice = read(TEAM_TOPICS)
    if choice != "auto":
        return choice == "always"
    named = is_given(ODOM_TOPIC) or is_given(CMD_VEL_TOPIC)
    simulated = rospy.get_param("/use_sim_time", False) and not named
    return bool(simulated) and (together or n >= TEAM_FROM) and _stage_offers()


def _stage_offers():
    command, clock = rospy.resolve_name(COMMAND), rospy.resolve_name("/clock")
    rospy.loginfo("looking for a simulator that offers %s", command)
    end, simulators_seen = time.monotonic() + PATIENCE, 0
    # The stage opens /clock shortly before its own topics: a clock seen twice is one without them.
    while time.monotonic() < end and simulators_seen < 2 and not rospy.is_shutdown():
        published, subscribed, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        if command in dict(subscribed):
            return True
        simulators_seen += clock in dict(published)
        time.sleep(NAP)
    rospy.loginfo("none found: each robot has its own topics")
    return False


class TeamCommands:
    """Publishes the commands of all robots in one message."""

    def __init__(self, numbers, axes=UNICYCLE_AXES):
        """``numbers``: the robots' numbers; ``axes`` of their commands."""
        self._numbers, self._axes = list(numbers), axes
        self._publisher = rospy.Publisher(COMMAND, TeamCommand, queue_size=1, tcp_nodelay=True)

    def publish(self, command, answered=None):
        """Publish ``command`` (n, a) [m/s, rad/s], which answers odometry stamped ``answered`` (n,) [s]."""
        self._publisher.publish(team_command(self._numbers, command, self._axes, answered))


class AnswerPublisher:
    """Publishes which odometry the commands on robots' own topics answer: a Twist has no stamp."""

    def __init__(self, numbers, axes=UNICYCLE_AXES):
        """``numbers``: the robots' numbers; ``axes`` of their commands."""
        self._numbers, self._axes = list(numbers), axes
        self._publisher = prompt_publisher(ANSWERS, TeamCommand)

    def publish(self, command, answered=None):
        """Publish what ``TeamCommands`` would, if a stage subscribes."""
        if self._publisher.get_num_connections():
            self._publisher.publish(team_command(self._numbers, command, self._axes, answered))
