"""A robot for tests that behaves as p2os_driver and a Pioneer do, on the same unicycle as RosAria's.

Topics are the namespace's: ``pose``, ``cmd_vel``, ``motor_state`` and ``cmd_motor_state``.  As the
driver's source has it, one thread reads the robot's packets, ten a second, and does all else between two
of them: it publishes the pose of each, in whole millimetres and degrees, sends what is new of a command
in two packets, for each of which it awaits one of the robot's, and only then takes messages again.  A
command that differs by no more than 0.01 m/s and 0.01 rad/s from the one in force is none: zeros do not
stop a robot that creeps.  It has no watchdog; the robot's firmware stops 2 s after the last packet that
was sent to it, and goes on at the next.  Speeds are told as those of the wheels, in whole mm/s.  The
motors are off until told otherwise.  Without its robot the driver waits in its read for ever, and says
nothing.  Its sonar hears what RosAria's does here, where ``~use_sonar`` is true; else it tells no distance.
"""

import math
import threading
import time

import numpy as np
import rospy
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosaria_robot import STEP, Robot
from std_srvs.srv import Empty

# The driver's own message package is not installed where the tests run.
SONARS = """Header header
int32 ranges_count
float64[] ranges
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""
SonarArray = generate_dynamic("p2os_msgs/SonarArray", SONARS)["p2os_msgs/SonarArray"]
MotorState = generate_dynamic("p2os_msgs/MotorState", "int32 state\n")["p2os_msgs/MotorState"]
PACKET = 0.1  # [s] between two of the robot's packets
CHANGE = 0.01  # [m/s], [rad/s] by which a command must differ
REMINDER = 2.0  # [s] after which one that does not is sent again, if it moves the robot
FIRMWARE = 2.0  # [s] without a packet after which the robot stands, as it leaves the factory
TURN_UNIT = 0.0028  # [rad/s] that the driver makes of 1 mm/s between the wheels of a Pioneer 3-DX
MAX_SPEED, MAX_TURN = 0.5, math.radians(100.0)  # [m/s, rad/s] defaults


class Commands:
    """What of the commands that come is sent to the robot."""

    def __init__(self, max_speed=MAX_SPEED, max_turn=MAX_TURN):
        """``max_speed`` [m/s] and ``max_turn`` [rad/s]: to which commands are cut."""
        self._most = round(1e3 * max_speed), round(math.degrees(max_turn))
        self._taken, self._since = (0.0, 0.0), 0.0
        self.is_new = False

    def take(self, v, omega, now):
        """Take in a command [m/s, rad/s] at ``now`` [s]."""
        last_v, last_omega = self._taken
        if abs(v - last_v) > CHANGE or abs(omega - last_omega) > CHANGE:
            self._taken, self._since, self.is_new = (v, omega), now, True
        elif now - self._since > REMINDER and max(abs(last_v), abs(last_omega)) > CHANGE:
            self._since, self.is_new = now, True

    def sent(self):
        """Return speed and turn rate [m/s, rad/s] as they are sent, whole mm/s and degrees/s."""
        self.is_new = False
        v, turn = int(1e3 * self._taken[0]), round(math.degrees(self._taken[1]))
        v, turn = (max(-most, min(most, x)) for x, most in zip((v, turn), self._most))
        return 1e-3 * v, math.radians(turn)


class P2osRobot(Robot):
    """One robot and its driver."""

    WATCHDOG = math.inf  # [s]

    def _open_topics(self):
        self.motors = False
        self._frames = (
            rospy.get_param("~odom_frame_id", "odom"),
            rospy.get_param("~base_link_frame_id", "base_link"),
        )
        most = rospy.get_param("~max_xspeed", MAX_SPEED), rospy.get_param("~max_yawspeed", MAX_TURN)
        self._commands, self._inbox, self._lock = Commands(*most), {}, threading.Lock()
        self._due = time.monotonic()
        self._silence = 0.0  # [s] of the robot's own time, which a busy machine slows down
        self._lost = threading.Event()
        self._wall = rospy.get_param("~wall", math.inf)
        self._fires = rospy.get_param("~use_sonar", False)
        self._distances = rospy.Publisher("sonar", SonarArray, queue_size=1000)
        self._publisher = rospy.Publisher("pose", Odometry, queue_size=1000)
        self._state = rospy.Publisher("motor_state", MotorState, queue_size=1000)
        self._kept = [
            rospy.Subscriber("cmd_vel", Twist, self._keep, "cmd_vel", queue_size=1),
            rospy.Subscriber("cmd_motor_state", MotorState, self._keep, "motors", queue_size=1),
            rospy.Service("~lose_link", Empty, self._on_lose_link),
        ]

    def _on_lose_link(self, request):
        self._lost.set()
        return super()._on_lose_link(request)

    def _keep(self, message, name):
        with self._lock:
            self._inbox[name] = message

    def publish(self):
        """Publish pose and transform, and the state of the motors with them."""
        exact, velocity = self.pose.copy(), self.velocity
        self.pose[0, :2] = np.round(1e3 * exact[0, :2]) * 1e-3
        self.pose[0, 2] = math.radians(round(math.degrees(exact[0, 2])))
        half = 0.5 * velocity[0, 1] / TURN_UNIT
        left, right = (round(1e3 * velocity[0, 0] + side * half) for side in (-1.0, 1.0))
        # Whole numbers, of which the halves are lost.
        self.velocity = np.array([[1e-3 * int(0.5 * (left + right)), TURN_UNIT * (right - left)]])
        super().publish()
        self.pose, self.velocity = exact, velocity
        self._state.publish(MotorState(int(self.motors)))
        told = [1e-3 * heard for *_, heard in self.heard()] if self._fires else []
        distances = SonarArray(ranges_count=len(told), ranges=told)
        distances.header.stamp = rospy.Time.from_sec(time.time())
        self._distances.publish(distances)

    def step(self, duration):
        """Move on by ``duration`` [s], as the firmware lets it."""
        told = self.target
        self._silence += duration
        if self._silence > FIRMWARE:
            self.target = np.zeros((1, 2))
        super().step(duration)
        self.target = told

    def spin(self):
        """Run as the driver's main loop does."""
        while not rospy.is_shutdown():
            if self._commands.is_new:
                v, omega = self._commands.sent()
                self._send(0, v)
                self._send(1, omega)
            self._await_packet()
            with self._lock:
                inbox, self._inbox = self._inbox, {}
            if "cmd_vel" in inbox:
                twist = inbox["cmd_vel"]
                self._commands.take(twist.linear.x, twist.angular.z, time.monotonic())
            if "motors" in inbox:
                self.motors = inbox["motors"].state != 0
                self._silence = 0.0
                self._await_packet(publish=False)

    def _send(self, column, value):
        self.target[0, column], self._silence = value, 0.0
        self._await_packet()

    def _await_packet(self, publish=True):
        while not rospy.is_shutdown() and (time.monotonic() < self._due or self._lost.is_set()):
            self.step(STEP)
            time.sleep(STEP)
        self._due = max(self._due + PACKET, time.monotonic())
        if publish:
            self.publish()


if __name__ == "__main__":
    rospy.init_node("p2os_driver")
    P2osRobot().spin()
