"""The preset ``crazyswarm``: Crazyflies as its ROS 1 server shows them, robot N as ``/cfN``."""

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from std_msgs.msg import Empty
from std_srvs.srv import Empty as EmptyService
from tf2_msgs.msg import TFMessage

from mrs_simulator.core.spatial import headings
from mrs_simulator.nodes.stage.driver_presets.preset_drivers import PresetDrivers, refuse_without
from mrs_simulator.nodes.stage.robot_topics import fill, lifts, transform
from mrs_simulator.ros.message_forms.optional_messages import Offer
from mrs_simulator.vehicles.firmware.crazyflie import COEFFICIENTS, Commander, Piece

NAME, WORLD = "crazyswarm", "world"
# Services of one robot, and of all, with their types.
FLIGHTS = {
    "takeoff": "Takeoff",
    "land": "Land",
    "go_to": "GoTo",
    "start_trajectory": "StartTrajectory",
}


def behind(scenario):
    """Return ``scenario``, whose Crazyflies obey crazyswarm; ``ValueError`` where there are none."""
    refuse_without(scenario, NAME, "quadrotor", "crazyflie2", ("kinematic", "dynamic"))
    return scenario


class Drivers(PresetDrivers):
    """crazyswarm's server and the firmware of its robots.

    A robot obeys ``/robotN/cmd_vel`` until it is commanded by its own topics and services.
    """

    NAME, DRIVE = NAME, "quadrotor"
    OFFERS = (
        Offer(NAME, "msg", ("FullState", "VelocityWorld", "Hover", "Position"),
              ("cmd_full_state", "cmd_velocity_world", "cmd_hover", "cmd_position")),
        Offer(NAME, "srv", ("Takeoff", "Land", "GoTo", "UploadTrajectory", "StartTrajectory",
        "SetGroupMask",
                            "NotifySetpointsStop", "Stop"),
              (*FLIGHTS, "upload_trajectory", "set_group_mask", "notify_setpoints_stop", "stop")),
    )  # fmt: skip

    def __init__(self, world, requests, absent=()):
        """As ``PresetDrivers``."""
        super().__init__(world, requests, absent)
        self._commanders = {}
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._all = [self.service("/emergency", EmptyService, self._emergency)]
        for name, kind in FLIGHTS.items() if "Takeoff" in self.types else ():
            self._all.append(self.service("/" + name, self.types[kind], self._broadcast(name)))

    def begin(self, rows):
        """Begin anew with the robots ``rows``: they have no command yet."""
        kinds, step = self.world.team.kinds, self.world.step_size
        self._commanders = {row: Commander(kinds[row], step) for row in rows}

    def open_robot(self, row):
        name, one = "/cf{}/".format(row + 1), self._commanders[row]
        opened = [
            rospy.Publisher(name + "pose", PoseStamped, queue_size=1),
            self.subscribe(name + "cmd_vel", Twist, lambda m: self._attitude(row, m)),
            self.subscribe(name + "cmd_stop", Empty, lambda _: self._stop(row)),
        ]
        for topic, kind, read in (
            ("cmd_full_state", "FullState", _full_state),
            ("cmd_velocity_world", "VelocityWorld", _velocity_world),
            ("cmd_hover", "Hover", _hover),
            ("cmd_position", "Position", _position),
        ):
            if kind in self.types:
                streamed = self._streamed(row, read)
                opened.append(self.subscribe(name + topic, self.types[kind], streamed))
        if "Takeoff" in self.types:
            opened += self._services(row, name, one)
        return opened

    def _services(self, row, name, one):
        types = self.types

        def flight(which):
            return lambda request: self._fly(which, request, [row], request.groupMask)

        return [
            *(
                self.service(name + each, types[kind], flight(each))
                for each, kind in FLIGHTS.items()
            ),
            self.service(
                name + "upload_trajectory",
                types["UploadTrajectory"],
                lambda r: one.upload(r.trajectoryId, r.pieceOffset, list(map(_piece, r.pieces))),
            ),
            self.service(
                name + "set_group_mask",
                types["SetGroupMask"],
                lambda r: setattr(one, "group", r.groupMask),
            ),
            self.service(
                name + "notify_setpoints_stop",
                types["NotifySetpointsStop"],
                lambda _: one.release(),
            ),
            self.service(name + "stop", types["Stop"], lambda _: self._stop(row)),
        ]

    # What it receives ----------------------------------------------------------------------------

    def _broadcast(self, name):
        def act(request):
            if name == "go_to":
                request.relative = True  # as the firmware takes what is sent to all
            self._fly(name, request, list(self._commanders), request.groupMask)

        return act

    def _fly(self, name, request, rows, mask):
        """Let those robots of ``rows`` that belong to a group of ``mask`` begin the flight ``name``."""
        now, rows = self.world.time, [row for row in rows if self._commanders[row].is_in(mask)]
        for row in rows:
            if self._commanders[row].is_streaming(now):
                text = "cf{} obeys setpoints: wanted none for 0.5 s, or notify_setpoints_stop"
                raise ValueError(text.format(row + 1))
        for row, state in zip(rows, self.states(rows)):
            one = self._commanders[row]
            if name == "takeoff":
                one.take_off(now, state, request.height, request.duration.to_sec())
            elif name == "land":
                one.land(now, state, request.height, request.duration.to_sec())
            elif name == "go_to":
                goal = request.goal.x, request.goal.y, request.goal.z
                duration = request.duration.to_sec()
                one.go_to(now, state, goal, request.yaw, duration, request.relative)
            else:
                started = (
                    request.trajectoryId,
                    request.timescale,
                    request.reversed,
                    request.relative,
                )
                one.start(now, state, *started)
            self.world.flights.power([row])

    def _streamed(self, row, read):
        def streamed(message):
            made, *numbers = read(self._commanders[row], message)
            if self.fits(row, *numbers):
                self._stream(row, made)

        return streamed

    def _stream(self, row, setpoint):
        self._commanders[row].stream(self.world.time, setpoint)
        self.world.flights.power([row])

    def _attitude(self, row, message):
        attitude = message.linear.x, message.linear.y, message.angular.z, message.linear.z
        if self.fits(row, *attitude):
            self._stream(row, self._commanders[row].attitude(*attitude))

    def _stop(self, row):
        """Cut the motors, as the firmware does when commanded to stop, in the air too."""
        self._commanders[row].stop()
        if self.world.flights.states()[row] != "motors off":
            self.world.flights.cut_motors([row], falls=True)

    def _emergency(self, _):
        for row in self._commanders:
            self._stop(row)

    # What follows --------------------------------------------------------------------------------

    def command(self, rows, commands):
        """Give the world's robots ``rows`` (m,) the commands (m, a) that came by ``/robotN/cmd_vel``."""
        own = [
            index
            for index, row in enumerate(rows)
            if row not in self._commanders or not self._commanders[row].active
        ]
        if own:
            self.world.set_commands(np.asarray(rows)[own], commands[own])

    def advance(self):
        super().advance()
        rows = [row for row, one in self._commanders.items() if one.active and not one.stopped]
        for row, state in zip(rows, self.states(rows) if rows else ()):
            command = self._commanders[row].command(self.world.time, state)
            if command is not None:
                self.give(row, command)

    def report(self, stamp, rows):
        """Publish poses and transforms of robots ``rows`` at ``stamp``."""
        world, own = self.world, [row for row in rows if row in self._commanders]
        if not own:
            return
        raised = dict(zip(own, lifts(world.spatial.of(own), len(own))))
        poses = dict(zip(own, world.pose[own].tolist()))
        for row in own:
            publisher = self._open[row][0]
            if publisher.get_num_connections():
                message = PoseStamped()
                message.header.stamp, message.header.frame_id = stamp, WORLD
                fill(message.pose.position, message.pose.orientation, poses[row], raised[row])
                publisher.publish(message)
        if self._tf.get_num_connections():
            names = [(row, "cf{}".format(row + 1)) for row in own]
            transforms = [
                transform(stamp, WORLD, name, poses[row], raised[row]) for row, name in names
            ]
            self._tf.publish(TFMessage(transforms=transforms))


def _full_state(one, message):
    place, velocity, turn = message.pose.position, message.twist.linear, message.pose.orientation
    quaternion = np.array([turn.x, turn.y, turn.z, turn.w])
    yaw, rate = float(headings(quaternion)), message.twist.angular.z
    parts = [[v.x, v.y, v.z] for v in (place, velocity, message.acc)]
    return (one.full_state(*parts, yaw, rate), *sum(parts, []), yaw, rate)


def _velocity_world(one, message):
    velocity = [message.vel.x, message.vel.y, message.vel.z]
    return (one.velocity_world(velocity, message.yawRate), *velocity, message.yawRate)


def _hover(one, message):
    setpoint = message.vx, message.vy, message.yawrate, message.zDistance
    return (one.hover(*setpoint), *setpoint)


def _position(one, message):
    place = [message.x, message.y, message.z]
    return (one.position(place, message.yaw), *place, message.yaw)


def _piece(message):
    columns = [message.poly_x, message.poly_y, message.poly_z, message.poly_yaw]
    if {len(column) for column in columns} != {COEFFICIENTS}:
        text = "a piece with {} coefficients: wanted 8 of x, y, z and yaw each"
        raise ValueError(text.format(", ".join(str(len(column)) for column in columns)))
    return Piece(np.array(columns, dtype=float), message.duration.to_sec())
