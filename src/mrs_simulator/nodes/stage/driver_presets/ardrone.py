"""The preset ``ardrone``: AR.Drones as ardrone_autonomy shows them, each in its namespace ``/robotN``."""

import math

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu
from std_msgs.msg import Empty

from mrs_simulator.core.spatial import rotated
from mrs_simulator.nodes.stage.driver_presets.preset_drivers import PresetDrivers, refuse_without
from mrs_simulator.nodes.stage.robot_topics import fill, lifts
from mrs_simulator.ros.message_forms.optional_messages import Offer
from mrs_simulator.vehicles.drives.rotors import GRAVITY
from mrs_simulator.vehicles.firmware import ardrone as firmware
from mrs_simulator.vehicles.firmware import flying

NAME = "ardrone"
HEIGHT = 1.0  # [m] of a take-off; from memory of the robot
TWIST = slice(0, 6)


def behind(scenario):
    """Return ``scenario``, whose quadrotors obey ardrone_autonomy; ``ValueError`` where there are none."""
    refuse_without(scenario, NAME, "quadrotor", "ardrone2", ("kinematic", "dynamic"))
    return scenario


class Drivers(PresetDrivers):
    """The driver node of each robot, and the robot's own controllers."""

    NAME, DRIVE = NAME, "quadrotor"
    OFFERS = (Offer("ardrone_autonomy", "msg", ("Navdata",), ("ardrone/navdata",)),)

    def begin(self, rows):
        world = self.world
        kinds, step = world.team.kinds, world.step_size
        self._response = {row: flying.response(kinds[row], step) for row in rows}
        self._goals = {}  # shares (6,), and when [s], by row
        self._emergency = set()
        self._velocity = {}  # (3,) [m/s] when it was published last, and when [s], by row

    def open_robot(self, row):
        """Return the publishers and subscribers of robot ``row``."""
        name = "/robot{}/ardrone/".format(row + 1)
        opened = [
            rospy.Publisher(name + "odometry", Odometry, queue_size=1),
            rospy.Publisher(name + "imu", Imu, queue_size=1),
            self.subscribe(name + "takeoff", Empty, lambda _: self._take_off(row)),
            self.subscribe(name + "land", Empty, lambda _: self._land(row)),
            self.subscribe(name + "reset", Empty, lambda _: self._reset(row)),
        ]
        if "Navdata" in self.types:
            opened.append(rospy.Publisher(name + "navdata", self.types["Navdata"], queue_size=1))
        return opened

    def _take_off(self, row):
        if self.world.flights.states()[row] != "landed":
            rospy.logwarn("stage: robot%d does not take off: it is not landed and ready", row + 1)
            return
        self.world.flights.take_off([row], HEIGHT)

    def _land(self, row):
        self.world.flights.land([row])

    def _reset(self, row):
        """Toggle the emergency state, in which the motors stand, in the air too."""
        if row in self._emergency:
            self._emergency.discard(row)
            self.world.flights.power([row])
            return
        self._emergency.add(row)
        if self.world.flights.states()[row] != "motors off":
            self.world.flights.cut_motors([row], falls=True)

    def taken(self, rows, twists):
        """Return the Twists (m, 6) of other robots; shares of these are kept."""
        twists = np.array(twists)
        for index, row in enumerate(rows):
            if row in self._response:
                if not np.isfinite(twists[index]).all():
                    self.world.commands.refused[row] += 1
                else:
                    self._goals[row] = firmware.shares(twists[index]), self.world.time
                twists[index] = 0.0
        return twists

    def command(self, rows, commands):
        """Give the world's robots ``rows`` (m,) the commands (m, a); those behind this interface obey
        shares."""
        others = [index for index, row in enumerate(rows) if row not in self._response]
        if others:
            self.world.set_commands(np.asarray(rows)[others], commands[others])

    def advance(self):
        super().advance()
        world = self.world
        rows = [
            row
            for row, (_, since) in self._goals.items()
            if row < world.n and world.time - since <= world.commands.timeouts[row]
        ]
        flying_now = world.flights.states()
        rows = [row for row in rows if flying_now[row] in ("flying", "hovering")]
        for row, state in zip(rows, self.states(rows) if rows else ()):
            kind = world.team.kinds[row]
            top = world.team.limits.of([row]).top[0]
            axes = [world.team.axes.index(axis) for axis in kind.axes]
            given = self._goals[row][0], state.velocity, state.heading
            self.give(row, firmware.command(*given, kind, top[axes], self._response[row]))

    def report(self, stamp, rows):
        """Publish odometry, inertial and navigation data of robots ``rows`` at ``stamp``."""
        own = [row for row in rows if row in self._response]
        followed = [row for row in own if any(map(_has_subscribers, self._open[row]))]
        if not followed:
            return
        raised = lifts(self.world.spatial.of(followed), len(followed))
        flights = self.world.flights.states()
        for row, state, lift in zip(followed, self.states(followed), raised):
            pose, twist = self.world.pose[row].tolist(), self.world.twist[row].tolist()
            base = "robot{}/base_link".format(row + 1)
            odometry, inertial, *more = (
                each for each in self._open[row] if isinstance(each, rospy.Publisher)
            )
            force = self._specific_force(row, state, lift)
            odometry.publish(_odometry(stamp, row, base, pose, twist, lift))
            inertial.publish(_inertial(stamp, base, pose, twist, lift, force))
            for publisher in more:
                publisher.publish(self._navdata(stamp, base, row, state, lift, force, flights[row]))

    def _specific_force(self, row, state, lift):
        """Return what an accelerometer reads, (3,) [m/s^2], body frame, on average since it was published
        last."""
        now = self.world.time
        before, since = self._velocity.get(row, (state.velocity, now))
        self._velocity[row] = state.velocity, now
        gained = (state.velocity - before) / (now - since) if now > since else np.zeros(3)
        turn = np.array(lift[1:5]) * [-1.0, -1.0, -1.0, 1.0]
        return rotated(turn, gained + [0.0, 0.0, GRAVITY])

    def _navdata(self, stamp, base, row, state, lift, force, doing):
        x, y, z, w = lift[1:5]
        message = self.types["Navdata"]()
        message.header.stamp, message.header.frame_id = stamp, base
        message.batteryPercent = 100.0
        message.state = firmware.STATES.get(doing, firmware.UNKNOWN)
        message.rotX = math.degrees(math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)))
        message.rotY = math.degrees(math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))))
        message.rotZ = math.degrees(state.heading)
        message.altd = int(round(1000.0 * lift[0]))
        cos, sin = math.cos(state.heading), math.sin(state.heading)
        vx, vy, vz = (1000.0 * state.velocity).tolist()
        message.vx, message.vy, message.vz = cos * vx + sin * vy, cos * vy - sin * vx, vz
        message.ax, message.ay, message.az = (force / GRAVITY).tolist()
        message.tm = 1e6 * self.world.time
        return message


def _has_subscribers(opened):
    return isinstance(opened, rospy.Publisher) and opened.get_num_connections() > 0


def _odometry(stamp, row, base, pose, twist, lift):
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = "robot{}/odom".format(row + 1), base
    fill(message.pose.pose.position, message.pose.pose.orientation, pose, lift)
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, angular.z = twist
    linear.z, angular.x, angular.y = lift[5:]
    return message


def _inertial(stamp, base, pose, twist, lift, force):
    message = Imu()
    message.header.stamp, message.header.frame_id = stamp, base
    turn = message.orientation
    turn.x, turn.y, turn.z, turn.w = lift[1:5]
    rate, felt = message.angular_velocity, message.linear_acceleration
    rate.x, rate.y, rate.z = lift[6], lift[7], twist[2]
    felt.x, felt.y, felt.z = force.tolist()
    return message
