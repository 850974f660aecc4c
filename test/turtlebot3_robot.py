"""A robot for tests that behaves as rosserial and a TurtleBot3 Burger's board do.

Topics are the namespace's: ``odom`` at 30 Hz, ``cmd_vel`` and ``motor_power``; frames begin with the
parameter ``~tf_prefix``.  As the board's source has it, commands are cut to the robot's limits and then
each wheel's to its motor's, 0.21 m/s, in whole units; they hold for 0.5 s; odometry is reckoned in single
precision, with the heading of the inertial sensor, and begins at zero when the board is connected; motors
are on from the start.  Without the board there is silence.
"""

import math
import random
import threading
import time

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosaria_robot import Robot
from std_msgs.msg import Bool
from std_srvs.srv import Empty

HEADING_NOISE = 1e-4  # [rad]
TOP = 0.22, 2.84  # [m/s, rad/s]
HALF_TRACK, UNIT = 0.08, 0.033 / 41.69988758  # [m], [m/s] of a rim, of one unit of the motors
MOST_UNITS = 265  # [-]


def obeyed(v, omega):
    """Return what the board makes of a command, [m/s, rad/s]."""
    v, omega = np.clip([v, omega], np.negative(TOP), TOP)
    rims = np.array([v - HALF_TRACK * omega, v + HALF_TRACK * omega]) / UNIT
    left, right = UNIT * np.trunc(np.clip(rims, -MOST_UNITS, MOST_UNITS))
    return 0.5 * (left + right), 0.5 * (right - left) / HALF_TRACK


class TurtleBot3(Robot):
    """One robot, its board, and the node that speaks with it."""

    RAMP = np.full(2, math.inf)  # its firmware has none
    WATCHDOG = 0.5  # [s]
    RATE = 30.0  # [Hz]

    def _open_topics(self):
        prefix = rospy.get_param("~tf_prefix", "")
        self._frames = tuple(
            "{}/{}".format(prefix, name) if prefix else name for name in ("odom", "base_footprint")
        )
        self._lost = threading.Event()
        self._publisher = rospy.Publisher("odom", Odometry, queue_size=1)
        self._kept = [
            rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1),
            rospy.Subscriber("motor_power", Bool, self._on_power, queue_size=1),
            rospy.Service("~lose_link", Empty, self._on_lose_link),
        ]

    def _on_command(self, twist):
        if not self._lost.is_set():
            self.target = np.array([obeyed(twist.linear.x, twist.angular.z)])
            self._commanded = time.monotonic()

    def _on_power(self, message):
        self.motors = message.data

    def _on_lose_link(self, request):
        self._lost.set()
        return super()._on_lose_link(request)

    def publish(self):
        """Publish pose and transform, while the board is there."""
        if self._lost.is_set():
            return
        exact = self.pose
        self.pose = exact.astype(np.float32).astype(float)
        self.pose[0, 2] += HEADING_NOISE * math.sin(random.uniform(-1.0, 1.0))
        super().publish()
        self.pose = exact


if __name__ == "__main__":
    rospy.init_node("turtlebot3_core")
    TurtleBot3().spin()
