"""A robot for tests with the interface of the RosAria driver, and its habits, on a unicycle.

The pose begins at zero where the robot stands, at 10 Hz and with wall stamps; commands are rounded
to whole mm/s and deg/s and clipped; after 0.6 s without one the robot stops.  Private parameters:
``~rate`` [Hz] of the pose, and the driver's own ``odom_frame`` and ``base_link_frame``.

Its sonar hears a wall across the x axis, ``~wall`` [m] ahead of where the robot began: echoes in whole
millimetres, 5 m where there is none, with each pose while somebody listens; none after ``~lose_sonar``.
"""

import math
import time

import numpy as np
import rospy
from geometry_msgs.msg import Point32, TransformStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud
from std_msgs.msg import Bool
from std_srvs.srv import Empty, EmptyResponse
from tf2_msgs.msg import TFMessage

from mrs_simulator.core.kinematics import Limits, arc, ramp
from mrs_simulator.nodes.stage.driver_presets.rosaria import driver_commands

# Factory settings of the Pioneer's firmware, in m and rad.
FIRMWARE_LIMITS = Limits(0.75, math.radians(100.0), 0.3, math.radians(100.0))

# Of a P3-DX: x, y [mm] and direction [deg] of each transducer, and the greatest distance [mm].
TRANSDUCERS = """69 136 90, 114 119 50, 148 78 30, 166 27 10, 166 -27 -10, 148 -78 -30, 114 -119 -50,
69 -136 -90, -157 -136 -90, -203 -119 -130, -237 -78 -150, -255 -27 -170, -255 27 170, -237 78 150,
-203 119 130, -157 136 90"""
FARTHEST = 5000.0

STEP = 0.01  # [s] of wall time
LATEST = 0.1  # [s] that one step may stand for if the machine is busy


class Robot:
    """One robot and its driver."""

    LIMITS = FIRMWARE_LIMITS
    RAMP = np.array(FIRMWARE_LIMITS[2:])  # (2,) [m/s^2, rad/s^2]
    WATCHDOG = 0.6  # [s]
    RATE = 10.0  # [Hz] of the pose
    _sonar = None  # other drivers have none, or another one
    last_heard = None  # (pose, velocity) at the loss of the link, repeated for ever

    def __init__(self):
        self.pose = np.zeros((1, 3))
        self.velocity, self.target = np.zeros((1, 2)), np.zeros((1, 2))
        self.motors = True
        self._commanded = time.monotonic()
        self._frames = (
            rospy.get_param("~odom_frame", "odom"),
            rospy.get_param("~base_link_frame", "base_link"),
        )
        self._transforms = rospy.Publisher("/tf", TFMessage, queue_size=100)
        self._open_topics()

    def _open_topics(self):
        self._publisher = rospy.Publisher("~pose", Odometry, queue_size=1000)
        self._state = rospy.Publisher("~motors_state", Bool, queue_size=5, latch=True)
        self._state.publish(True)
        self._kept = [
            rospy.Subscriber("~cmd_vel", Twist, self._on_command, queue_size=1),
            rospy.Service("~enable_motors", Empty, self._on_enable),
            rospy.Service("~disable_motors", Empty, self._on_disable),
            rospy.Service("~lose_link", Empty, self._on_lose_link),
        ]

        self._sonar = rospy.Publisher("~sonar", PointCloud, queue_size=50)
        self._wall = rospy.get_param("~wall", math.inf)
        self._kept.append(rospy.Service("~lose_sonar", Empty, self._on_lose_sonar))

    def _on_lose_sonar(self, _):
        self._sonar.unregister()
        self._sonar = None
        return EmptyResponse()

    def heard(self):
        """Return x, y [mm], direction [rad] of each transducer, and the whole mm that it hears."""
        (x, _, theta), result = self.pose[0], []
        for text in TRANSDUCERS.split(","):
            ahead, left, degrees = map(float, text.split())
            turn = math.radians(degrees)
            place = 1000.0 * x + ahead * math.cos(theta) - left * math.sin(theta)
            along = math.cos(theta + turn)
            far = (1000.0 * self._wall - place) / along if along > 1e-6 else FARTHEST
            result.append((ahead, left, turn, round(min(max(far, 0.0), FARTHEST))))
        return result

    def echoes(self):
        """Return the echoes of the wall in the robot's axes, points."""
        points = []
        for ahead, left, turn, heard in self.heard():
            echo = ahead + heard * math.cos(turn), left + heard * math.sin(turn)
            points.append(Point32(0.001 * echo[0], 0.001 * echo[1], 0.0))
        return points

    def _on_command(self, twist):
        given = np.array([[twist.linear.x, twist.angular.z]])
        self.target = driver_commands(given, np.array(self.LIMITS[:2]))
        self._commanded = time.monotonic()

    def _on_enable(self, _):
        return self._switch(True)

    def _on_disable(self, _):
        return self._switch(False)

    def _on_lose_link(self, _):
        self.last_heard = self.pose.copy(), self.velocity.copy()
        return EmptyResponse()

    def _switch(self, on):
        if on != self.motors:
            self._state.publish(on)
        self.motors = on
        return EmptyResponse()

    def step(self, duration):
        """Move on by ``duration`` [s]."""
        silent = time.monotonic() - self._commanded > self.WATCHDOG
        self.target = np.zeros((1, 2)) if silent else self.target
        wanted = self.target if self.motors else np.zeros((1, 2))
        self.velocity, mean = ramp(self.velocity, wanted, self.RAMP, duration)
        self.pose = arc(self.pose, mean, duration)

    def publish(self):
        """Publish pose and transform as the driver does: no covariance, wall stamps."""
        pose, velocity = self.last_heard or (self.pose, self.velocity)
        (x, y, theta), (v, omega) = pose[0], velocity[0]
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(time.time())
        message.header.frame_id, message.child_frame_id = self._frames
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z = math.sin(0.5 * theta)
        message.pose.pose.orientation.w = math.cos(0.5 * theta)
        message.twist.twist.linear.x, message.twist.twist.angular.z = v, omega
        self._publisher.publish(message)
        if self._sonar is not None and self._sonar.get_num_connections():
            cloud = PointCloud(points=self.echoes())
            cloud.header.stamp, cloud.header.frame_id = message.header.stamp, "sonar"
            self._sonar.publish(cloud)
        move = TransformStamped(header=message.header, child_frame_id=message.child_frame_id)
        move.transform.translation.x, move.transform.translation.y = x, y
        move.transform.rotation = message.pose.pose.orientation
        self._transforms.publish(TFMessage([move]))

    def spin(self):
        """Run until ROS shuts down."""
        period, following = 1.0 / rospy.get_param("~rate", self.RATE), time.monotonic()
        last = following
        while not rospy.is_shutdown():
            now = time.monotonic()
            self.step(max(1e-4, min(now - last, LATEST)))
            last = now
            if now >= following:
                following = max(following + period, now)
                self.publish()
            time.sleep(STEP)


if __name__ == "__main__":
    rospy.init_node("RosAria")
    Robot().spin()
