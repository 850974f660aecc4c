"""A robot for tests with the names and habits of the p2os driver, on the same unicycle as RosAria's.

Topics are the namespace's, ``pose``, ``cmd_vel``, ``motor_state`` and ``cmd_motor_state``; the motors
are off until told otherwise, and a command holds until the next one, for ever.
"""

import math

import rospy
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosaria_robot import FIRMWARE_LIMITS, Robot

# The driver's own message package is not installed where the tests run.
MotorState = generate_dynamic("p2os_msgs/MotorState", "uint32 state\n")["p2os_msgs/MotorState"]


class P2osRobot(Robot):
    """One robot and its driver."""

    LIMITS = FIRMWARE_LIMITS._replace(v_max=0.5)  # [m/s] the driver's
    WATCHDOG = math.inf  # [s]

    def _open_topics(self):
        self.motors = False
        self._publisher = rospy.Publisher("pose", Odometry, queue_size=1000)
        self._state = rospy.Publisher("motor_state", MotorState, queue_size=1000)
        self._kept = [
            rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1),
            rospy.Subscriber("cmd_motor_state", MotorState, self._on_motor_state, queue_size=1),
        ]

    def _on_motor_state(self, message):
        self.motors = message.state != 0

    def publish(self):
        """Publish pose and transform, and the state of the motors with them."""
        super().publish()
        self._state.publish(MotorState(int(self.motors)))


if __name__ == "__main__":
    rospy.init_node("p2os_driver")
    P2osRobot().spin()
