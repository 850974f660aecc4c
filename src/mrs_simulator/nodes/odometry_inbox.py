"""The newest pose of each robot, put by subscriber threads, taken by the control loop."""

import math
import threading

import numpy as np
import rospy

from mrs_simulator.core.guards import Tracks
from mrs_simulator.nodes.parameters import pattern_parameter
from mrs_simulator.nodes.wire import PlanarOdometry

MOST_NAMED = 8  # robots named in one line


class OdometryInbox:
    """Subscribes to ``/robotN/odom`` of every robot, or to another topic of poses."""

    def __init__(self, numbers, bounds=None, topic="", kind=PlanarOdometry):
        """``numbers``: the robots' numbers; ``bounds``: ``JumpBounds`` or None.

        ``topic``: its pattern, ``{}`` for the robot's number, by default the parameter
        ``~odom_topic``; ``kind`` of message: PlanarOdometry or PoseStamped.
        """
        self._numbers = list(numbers)
        self.topic = topic or pattern_parameter("~odom_topic", "/robot{}/odom")
        n = len(self._numbers)
        self._tracks = Tracks(n, bounds)
        self._stamp = [None] * n
        self._received = np.full(n, -math.inf)
        self._refused = np.zeros(n, dtype=int)
        self._repeated = set()
        self._changed = threading.Condition()
        self._subscribers = [
            rospy.Subscriber(
                self.topic.replace("{}", str(number)),
                kind,
                self.put,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for row, number in enumerate(self._numbers)
        ]

    def put(self, message, row):
        """Keep the pose of robot ``row``; one that is not finite is refused and so grows stale."""
        if isinstance(message, PlanarOdometry):
            pose, stamp = message.planar, message.stamp
        else:
            pose, stamp = planar(message.pose), message.header.stamp
        with self._changed:
            if not all(map(math.isfinite, pose)):
                self._refused[row] += 1
                return
            if self._stamp[row] == stamp:
                self._repeated.add(row)
            self._stamp[row] = stamp
            self._received[row] = rospy.get_time()
            self._tracks.take(row, pose, (self._received[row], stamp.to_sec()))
            self._changed.notify()

    def names(self):
        """Return the names of the robots' topics, remappings applied."""
        return [rospy.resolve_name(self.topic.replace("{}", str(n))) for n in self._numbers]

    def pose(self):
        """Return the newest poses, shape (n, 3), NaN for a robot that has not been heard."""
        with self._changed:
            return self._tracks.pose.copy()

    def first(self):
        """Return the poses that were heard first, shape (n, 3)."""
        with self._changed:
            return self._tracks.first.copy()

    def jumps(self):
        """Return ``{row: text}`` of the robots whose pose jumped and is no longer followed."""
        with self._changed:
            return dict(self._tracks.jumps)

    def accept(self):
        """Follow the robots that jumped from where they are now."""
        with self._changed:
            self._tracks.accept()

    def stale(self, now, timeout):
        """Return ``{number: age}`` [s] of the robots silent for more than ``timeout`` [s].

        Ages are in ROS time; one that was never heard has age ``inf``.
        """
        with self._changed:
            ages = now - self._received
        return {
            number: float(age) for number, age in zip(self._numbers, ages) if not age <= timeout
        }

    def wait(self, seconds):
        """Return once something arrives, or after ``seconds`` of wall time."""
        with self._changed:
            self._changed.wait(seconds)

    def complete(self):
        """Return the stamp that the newest odometry of all robots bears, or None."""
        with self._changed:
            first = self._stamp[0]
            return first if all(stamp == first for stamp in self._stamp) else None

    def take_repeated(self):
        """Return the rows whose odometry came again with the same stamp, and forget them."""
        with self._changed:
            taken, self._repeated = self._repeated, set()
        return sorted(taken)


def planar(pose):
    """Return ``(x, y, theta)`` [m, m, rad] of a geometry_msgs/Pose."""
    turn = pose.orientation
    theta = math.atan2(
        2.0 * (turn.w * turn.z + turn.x * turn.y),
        1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z),
    )
    return pose.position.x, pose.position.y, theta


def silence(stale, what="odometry"):
    """Return the text that names the robots in ``stale`` ``{number: age}``, "" if there is none."""
    if not stale:
        return ""
    shown = ", ".join(
        "robot{} ({})".format(number, "never heard" if age == np.inf else "{:.1f} s".format(age))
        for number, age in list(stale.items())[:MOST_NAMED]
    )
    more = ", and {} more".format(len(stale) - MOST_NAMED) if len(stale) > MOST_NAMED else ""
    return "no fresh {} of {}{}".format(what, shown, more)
