"""Odometry of robots that no stage reports on: real ones, or simulated ones before the stage starts."""

import re
import threading
import time

import numpy as np
import rospy
from nav_msgs.msg import Odometry

from mrs_simulator.core.kinematics import UNICYCLE_AXES, compose
from mrs_simulator.core.spatial import Spatial, headings, turned
from mrs_simulator.ros.receive.odometry_inbox import lifted, planar
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.state.state_table import StateTable

ROBOT = re.compile(r"^/robot(\d+)/")
ODOMETRY = "nav_msgs/Odometry"


class RobotsConnection:
    """Subscribes to one odometry of each robot; ``follow`` and ``forget`` are called by one thread only."""

    def __init__(self):
        self._lock = threading.Lock()
        self._received, self._subscribers = {}, {}  # by the robot's number
        self._first = 0.0  # [s] stamp of the first message
        self._simulated = frozenset()  # numbers of the robots whose odometry a stage publishes
        self._stages = set()  # names of nodes that were stages
        self._starts, self._in_space = None, False

    def set_starts(self, poses, in_space=False):
        """Set the robots' poses (n, 3) at zero odometry; None: at the origin.

        ``in_space``: whether they leave the ground; of others heights are ignored.
        """
        self._starts, self._in_space = None if poses is None else np.array(poses), in_space

    def topics(self):
        """Return ``{number: topic}`` of the subscribed odometry."""
        return {n: s.resolved_name for n, s in list(self._subscribers.items())}

    def first_stamp(self):
        """Return the stamp [s] of the first message, the zero of real robots' time."""
        return self._first

    def subscribers(self):
        """Return the subscribers."""
        return list(self._subscribers.values())

    def snapshot(self, silence, control=None):
        """Return the ``StateTable`` of the robots that publish odometry, None if there is none.

        One silent for ``silence`` [s] of wall time is stale; ``control``: the controller's status, which
        has the commands.
        """
        with self._lock:
            robots = dict(self._received)
        if not robots:
            return None
        numbers, now = tuple(sorted(robots)), time.monotonic()
        stamps, poses, twists, lifts, received = zip(*(robots[number] for number in numbers))
        poses = self._in_common_frame(numbers, np.array(poses))
        axes, commands = _commands(numbers, control)
        return StateTable(
            # Wall time counts from 1970; a stage's own robots go on with its time.
            max(stamps) - (0.0 if self._simulated.intersection(numbers) else self._first),
            numbers,
            axes=axes,
            pose=poses,
            twist=np.array(twists),
            command=commands,
            joints=np.zeros(len(numbers)),
            fresh=now - np.array(received) < silence,
            real=np.array([number not in self._simulated for number in numbers]),
            spatial=_spatial(np.array(lifts), poses[:, 2]) if self._in_space else None,
        )

    def _in_common_frame(self, numbers, poses):
        starts = self._starts
        if starts is None or max(numbers) > len(starts):
            return poses
        return compose(starts[np.array(numbers) - 1], poses)

    def follow(self, published, subscribed, kinds, stages, controllers):
        """Subscribe to the odometry of every robot that publishes one.

        ``published``, ``subscribed``: the nodes by topic; ``kinds`` of message by topic; ``stages``,
        ``controllers``: names of these nodes, None for none.
        """
        # One that ends may withdraw its state before its robots.
        self._stages.update(stages or ())
        controllers = set(controllers or ())
        topics = [t for t in published if kinds.get(t) == ODOMETRY and ROBOT.match(t)]
        # Of several topics of a robot the controller's comes first, then the default name.
        topics.sort(
            key=lambda t: (bool(controllers & set(subscribed.get(t, ()))), t.endswith("/odom"), t)
        )
        chosen = {int(ROBOT.match(topic).group(1)): topic for topic in topics}
        gone = self._simulated.difference(chosen)  # with their simulation
        for number in gone.intersection(self._subscribers):
            self._forget(number)
        self._simulated = frozenset(
            n for n, t in chosen.items() if self._stages.intersection(published[t])
        )
        for number, topic in chosen.items():
            self._subscribe(number, topic)

    def _subscribe(self, number, topic):
        before = self._subscribers.get(number)
        if before is None or before.resolved_name != topic:
            self._subscribers[number] = rospy.Subscriber(
                topic, Odometry, self._on_odometry, number, queue_size=1
            )
            if before is not None:
                withdraw(before)

    def _on_odometry(self, message, number):
        twist, stamp = message.twist.twist, message.header.stamp.to_sec()
        with self._lock:
            self._first = self._first if self._received else stamp
            self._received[number] = (
                stamp,
                planar(message.pose.pose),
                (twist.linear.x, twist.linear.y, twist.angular.z),
                (*lifted(message.pose.pose)[:5], twist.linear.z, twist.angular.x, twist.angular.y),
                time.monotonic(),
            )

    def forget(self):
        """Unsubscribe from all robots, and drop what they published."""
        for number in list(self._subscribers):
            self._forget(number)
        with self._lock:
            self._received.clear()

    def _forget(self, number):
        withdraw(self._subscribers.pop(number))
        with self._lock:
            self._received.pop(number, None)


def _spatial(lifts, theta):
    """Return the ``Spatial`` of ``lifts`` (n, 8), at headings ``theta`` (n,) in the common frame."""
    own = Spatial(lifts[:, 0], lifts[:, 1:5], lifts[:, 5:])
    return own._replace(orientation=turned(own.orientation, theta - headings(own.orientation)))


def _commands(numbers, control):
    """Return axes and commands (n, a) in the status ``control``, zero where it has none."""
    if control is None:
        return UNICYCLE_AXES, np.zeros((len(numbers), len(UNICYCLE_AXES)))
    result = np.zeros((len(numbers), len(control.axes)))
    rows = [row for row, number in enumerate(numbers) if number <= len(control.command)]
    result[rows] = control.command[[numbers[row] - 1 for row in rows]]
    return control.axes, result
