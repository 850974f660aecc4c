"""Real robots in the stage's world: bodies where the robots' own odometry says that they are."""

import math
import threading
import time

import numpy as np
import rospy
from nav_msgs.msg import Odometry

from mrs_simulator.core.kinematics import compose
from mrs_simulator.core.scenario import FARTHEST
from mrs_simulator.nodes.odometry_inbox import planar
from mrs_simulator.nodes.wire import PlanarTwist

SILENCE = 0.5  # [s] of wall time after which a real robot counts as silent


class Mirror:
    """The newest odometry of each real robot, put by subscriber threads, taken by the main loop."""

    def __init__(self, rows, clock=time.monotonic):
        """``rows``: the real robots'; ``clock`` gives wall time in s."""
        self.rows = frozenset(rows)
        self._clock = clock
        self._lock = threading.Lock()
        self._heard = {}  # row: (time of reception, pose, body twist)

    def put(self, message, row):
        """Keep the odometry of robot ``row``; one that cannot be true counts as silence."""
        pose, twist = planar(message.pose.pose), message.twist.twist
        twist = twist.linear.x, twist.linear.y, twist.angular.z
        if not all(map(math.isfinite, pose + twist)) or max(map(abs, pose)) > FARTHEST:
            return
        with self._lock:
            self._heard[row] = self._clock(), pose, twist

    def place(self, world):
        """Put the real robots of ``world`` where they were heard to be; a silent one at rest."""
        with self._lock:
            rows = sorted(self._heard)
            heard = [self._heard[row] for row in rows]
        if not rows:
            return
        late = self._clock() - SILENCE
        twists = np.array([twist if when >= late else (0.0,) * 3 for when, _, twist in heard])
        poses = np.array([pose for _, pose, _ in heard])
        # Wheel odometry begins where the scenario says that the robot stood.
        poses = compose(world.odometry_origins()[rows], poses)
        fits = (np.abs(poses) <= FARTHEST).all(axis=1)
        world.place(np.array(rows)[fits], poses[fits], twists[fits])

    def silent(self):
        """Return the rows, ascending, of the real robots that were not heard for ``SILENCE``."""
        late = self._clock() - SILENCE
        with self._lock:
            heard = {row for row, (when, _, _) in self._heard.items() if when >= late}
        return sorted(self.rows - heard)


class RealLink:
    """``/robotN/odom`` and ``/robotN/cmd_vel`` of a real robot: the stage listens to both."""

    # Nobody waits for a real robot.
    listened_to = commanded = True

    def __init__(self, row, inbox, mirror):
        """Commands go to ``inbox`` as those of other robots, to be shown; odometry to ``mirror``."""
        self._subscribers = [
            rospy.Subscriber(
                "/robot{}/{}".format(row + 1, topic),
                kind,
                put,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for topic, kind, put in (
                ("odom", Odometry, mirror.put),
                ("cmd_vel", PlanarTwist, inbox.put),
            )
        ]

    def publish(self, stamp, pose, twist):
        """Publish nothing: the robot does."""

    def close(self):
        """Withdraw both topics."""
        for subscriber in self._subscribers:
            subscriber.unregister()
