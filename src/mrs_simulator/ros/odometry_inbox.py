"""Newest pose of each robot: written by subscriber threads, read by the control loop."""

import math
import threading
import time

import numpy as np
import rospy

from mrs_simulator.core.guards import Tracks
from mrs_simulator.core.kinematics import yaw
from mrs_simulator.msg import TeamOdometry
from mrs_simulator.ros.parameters import pattern_parameter
from mrs_simulator.ros.planar_messages import PlanarOdometry
from mrs_simulator.ros.team_topics import ODOMETRY, team_topics_wanted

MOST_NAMED = 8  # robots named in one line
NEVER = -1  # [ns] the stamp of what was not heard yet


def make_inbox(numbers, bounds=None, real=()):
    """Return the inbox of the robots' odometry: from one topic for all, or from one for each."""
    kind = TeamInbox if team_topics_wanted(len(numbers)) else OdometryInbox
    return kind(numbers, bounds, real)


class Inbox:
    """The newest poses; how they come in is the subclasses' business."""

    def __init__(self, numbers, bounds=None, real=()):
        """``numbers``: the robots' numbers; ``bounds``: ``JumpBounds`` or None.

        ``real``: rows of the real robots, whose silence is measured in wall time: simulated time
        may be slow, or stand.
        """
        self._numbers = list(numbers)
        n = len(self._numbers)
        self._real = np.isin(np.arange(n), real)
        self._tracks = Tracks(n, bounds)
        self._stamp = np.full(n, NEVER)  # [ns]
        self._received = np.full(n, -math.inf)
        self._repeated = set()
        self._changed = threading.Condition()
        self.arrived = -math.inf  # [s] of wall time, when the newest came
        self._fresh = np.zeros(n, dtype=bool)
        self._news = False

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

        ``now`` [s] in ROS time; a robot that was never heard has age ``inf``.
        """
        with self._changed:
            ages = self._times(now) - self._received
        return {
            number: float(age) for number, age in zip(self._numbers, ages) if not age <= timeout
        }

    def _times(self, now):
        """Return the time [s] that holds for each robot at ``now`` in ROS time, (n,)."""
        return np.where(self._real, time.monotonic(), now)

    def _note_arrival(self, rows):
        self.arrived = time.monotonic()
        self._fresh[rows] = True
        self._tell()

    def used(self):
        """To be called when commands are made of the poses."""
        with self._changed:
            self._fresh[:] = False

    def all_fresh(self, rows):
        """Return whether all robots ``rows`` were heard since their poses were ``used``."""
        with self._changed:
            return bool(self._fresh[rows].all())

    def wake(self):
        """Have ``wait`` return: time has gone on."""
        with self._changed:
            self._tell()

    def _tell(self):
        self._news = True
        self._changed.notify()

    def wait(self, seconds):
        """Return once something has come since the last call, or after ``seconds`` of wall time."""
        with self._changed:
            if not self._news:
                self._changed.wait(seconds)
            self._news = False

    def complete(self):
        """Return the stamp that the newest odometry of all robots bears, or None."""
        with self._changed:
            first = int(self._stamp[0])
            same = first != NEVER and bool((self._stamp == first).all())
        return rospy.Time(*divmod(first, 10**9)) if same else None

    def take_repeated(self):
        """Return the rows whose odometry came again with the same stamp, and forget them."""
        with self._changed:
            taken, self._repeated = self._repeated, set()
        return sorted(taken)


class OdometryInbox(Inbox):
    """Subscribes to ``/robotN/odom`` of every robot, or to another topic of poses."""

    def __init__(self, numbers, bounds=None, real=(), topic="", kind=PlanarOdometry):
        """``numbers``, ``bounds``, ``real``: as of ``Inbox``.

        ``topic``: its pattern, ``{}`` for the robot's number, by default the parameter
        ``~odom_topic``; ``kind`` of message: PlanarOdometry or PoseStamped.
        """
        super().__init__(numbers, bounds, real)
        self.topic = topic or pattern_parameter("~odom_topic", "/robot{}/odom")
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
        if not all(map(math.isfinite, pose)):
            return
        now = time.monotonic() if self._real[row] else rospy.get_time()
        stamped = stamp.to_nsec()
        with self._changed:
            if self._stamp[row] == stamped:
                self._repeated.add(row)
            self._stamp[row], self._received[row] = stamped, now
            self._tracks.take(row, pose, (now, stamp.to_sec()))
            self._note_arrival(row)

    def names(self):
        """Return the names of the robots' topics, remappings applied."""
        return [rospy.resolve_name(self.topic.replace("{}", str(n))) for n in self._numbers]


class TeamInbox(Inbox):
    """Subscribes to one topic with the odometry of all robots."""

    def __init__(self, numbers, bounds=None, real=()):
        """``numbers``, ``bounds``, ``real``: as of ``Inbox``."""
        super().__init__(numbers, bounds, real)
        self._rows = {number: row for row, number in enumerate(self._numbers)}
        self._subscriber = rospy.Subscriber(
            ODOMETRY, TeamOdometry, self.put, queue_size=1, tcp_nodelay=True
        )

    def put(self, message):
        """Keep the poses of the team's robots; what is not finite is refused and so grows stale."""
        if not len(message.robot) == len(message.x) == len(message.y) == len(message.theta):
            return
        poses = np.array([message.x, message.y, message.theta]).T
        rows = np.array([self._rows.get(number, -1) for number in message.robot], dtype=int)
        good = (rows >= 0) & np.isfinite(poses).all(axis=1)
        rows, poses = rows[good], poses[good]
        now, stamp = rospy.get_time(), message.header.stamp
        with self._changed:
            self._repeated.update(rows[self._stamp[rows] == stamp.to_nsec()].tolist())
            self._stamp[rows], self._received[rows] = stamp.to_nsec(), self._times(now)[rows]
            self._tracks.take_all(rows, poses, (now, stamp.to_sec()))
            self._note_arrival(rows)

    def names(self):
        """Return the name of the topic, once for each robot."""
        return [self._subscriber.resolved_name] * len(self._numbers)


def planar(pose):
    """Return ``(x, y, theta)`` [m, m, rad] of a geometry_msgs/Pose."""
    turn = pose.orientation
    return pose.position.x, pose.position.y, yaw(turn.x, turn.y, turn.z, turn.w)


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
