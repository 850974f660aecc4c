"""The newest odometry of each robot, put by subscriber threads, taken by the control loop."""

import math
import threading
import time

import numpy as np
import rospy
from nav_msgs.msg import Odometry


class OdometryInbox:
    """Subscribes to ``/robotN/odom`` of every robot."""

    def __init__(self, numbers, clock=time.monotonic):
        """``numbers``: the robots' numbers; ``clock`` gives wall time in s."""
        self._numbers = list(numbers)
        self._clock = clock
        n = len(self._numbers)
        self._pose = np.full((n, 3), np.nan)
        self._stamp = [None] * n
        self._received = np.full(n, -math.inf)
        self._refused = np.zeros(n, dtype=int)
        self._repeated = set()
        self._changed = threading.Condition()
        self._subscribers = [
            rospy.Subscriber(
                "/robot{}/odom".format(number),
                Odometry,
                self.put,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for row, number in enumerate(self._numbers)
        ]

    def put(self, message, row):
        """Keep the pose of robot ``row``; one that is not finite is refused and so grows stale."""
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        theta = math.atan2(
            2.0 * (turn.w * turn.z + turn.x * turn.y),
            1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z),
        )
        pose = position.x, position.y, theta
        with self._changed:
            if not all(map(math.isfinite, pose)):
                self._refused[row] += 1
                return
            if self._stamp[row] == message.header.stamp:
                self._repeated.add(row)
            self._pose[row] = pose
            self._stamp[row] = message.header.stamp
            self._received[row] = rospy.get_time()
            self._changed.notify()

    def pose(self):
        """Return the newest poses, shape (n, 3), NaN for a robot that has not been heard."""
        with self._changed:
            return self._pose.copy()

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
