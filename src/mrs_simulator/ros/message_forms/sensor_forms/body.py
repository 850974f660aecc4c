"""What a robot senses of itself: bumpers, wheels, specific force and turn rates, battery."""

import math

import numpy as np
from sensor_msgs.msg import BatteryState, Imu, JointState
from std_msgs.msg import Float32, Float64, Int8

from mrs_simulator.ros.message_forms.defined_types import BumperState
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_forms.form import BASE, Form, diagonal
from mrs_simulator.sensors.types.battery import BatteryReading
from mrs_simulator.sensors.types.bumper import BumperReading
from mrs_simulator.sensors.types.encoders import EncoderReading
from mrs_simulator.sensors.types.inertial import ImuReading


class Bumpers(Form):
    """BumperState of RosAria: the front and the rear sections, from the robot's left to its right."""

    TYPE = "bumper"
    SUFFIX = "_state"
    MESSAGE = BumperState

    def message(self, item, header):
        """Return the ``BumperState`` of the sections that are pressed."""
        return BumperState(header, *(each.tolist() for each in item))

    def reading(self, message, stamp):
        received = message.front_bumpers, message.rear_bumpers
        if tuple(map(len, received)) != tuple(self.mount.settings):
            text = "{} front and {} rear sections, but the mount has {} and {}"
            raise MessageError(text.format(*map(len, received), *self.mount.settings))
        return BumperReading(stamp, *(np.array(each, dtype=bool) for each in received))


class Wheels(Form):
    """JointState: how far each wheel has turned [rad]; what counts no wheels of the model, in metres."""

    TYPE = "encoders"
    FRAME = BASE
    MESSAGE = JointState

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        self.names, self._radius = counted_joints(kind)

    def blank(self):
        """Return wheels that have not turned."""
        return (np.zeros(self.kind.module.ENCODERS),)

    def message(self, item, header):
        """Return the ``JointState`` of the distances rolled, [m]."""
        turned = (np.asarray(item[0]) / self._radius).tolist()
        return JointState(header=header, name=self.names, position=turned)

    def reading(self, message, stamp):
        """Return the ``EncoderReading``; other joints of the message are left out."""
        known = dict(zip(message.name, message.position))
        for name in self.names:
            if name not in known:
                received = ", ".join(message.name) or "none"
                raise MessageError("joints {}, wanted {} too".format(received, name))
        turned = np.array([known[name] for name in self.names])
        return EncoderReading(stamp, turned * self._radius)


def counted_joints(kind):
    """Return the names of the joints that a kind's encoders count, and the radius [m] of the wheels."""
    count, joints = kind.module.ENCODERS, tuple(getattr(kind.numbers, "joints", ()))
    if kind.module.JOINTS or len(joints) < count:  # they are not those of the wheels
        return ["encoder{}".format(k + 1) for k in range(count)], 1.0
    return list(joints[:count]), kind.numbers.radius


class Inertia(Form):
    """Imu without an orientation: specific force and turn rates at the centre, in the robot's axes."""

    TYPE = "imu"
    FRAME = BASE
    MESSAGE = Imu

    def message(self, item, header):
        """Return the ``Imu`` of acceleration and turn rate."""
        message = Imu(header=header)
        message.orientation_covariance[0] = -1.0  # there is none
        force, rate = message.linear_acceleration, message.angular_velocity
        (force.x, force.y, force.z), (rate.x, rate.y, rate.z) = item
        message.linear_acceleration_covariance = diagonal(self.variance("acceleration"))
        message.angular_velocity_covariance = diagonal(self.variance("rate"))
        return message

    def reading(self, message, stamp):
        force, rate = message.linear_acceleration, message.angular_velocity
        values = (force.x, force.y, force.z), (rate.x, rate.y, rate.z)
        return ImuReading(stamp, *map(np.array, values))


class Charge(Form):
    """BatteryState with voltage and charge alone."""

    TYPE = "battery"
    MESSAGE = BatteryState

    def message(self, item, header):
        """Return the ``BatteryState`` at a voltage [V] and a charge [-]."""
        voltage, charge = item
        return BatteryState(
            header=header,
            voltage=voltage,
            percentage=charge,
            current=math.nan,
            capacity=math.nan,
            design_capacity=math.nan,
            present=True,
        )

    def reading(self, message, stamp):
        return BatteryReading(stamp, message.voltage, message.percentage)


class Voltage(Form):
    """The voltage [V] alone, as RosAria publishes it."""

    TYPE = "battery"
    BY_DRIVERS = True
    SUFFIX = "_voltage"
    MESSAGE = Float64
    PROVIDES = ("voltage",)

    def message(self, item, header):
        return self.MESSAGE(dict(zip(BatteryReading.PER_ROBOT, item))[self.PROVIDES[0]])

    def reading(self, message, stamp):
        """Return the ``BatteryReading``, all else unknown."""
        unknown = BatteryReading(stamp, math.nan, math.nan)
        return unknown._replace(**{self.PROVIDES[0]: message.data})


class StateOfCharge(Voltage):
    """The charge alone, from 0 to 1, as RosAria publishes it."""

    SUFFIX = "_state_of_charge"
    MESSAGE = Float32
    PROVIDES = ("charge",)


class Recharging(Form):
    """Whether the battery is charging, as RosAria publishes it: 0 if not, negative if unknown."""

    TYPE = "battery"
    PUBLISHED = False
    BY_DRIVERS = True
    SUFFIX = "_recharge_state"
    MESSAGE = Int8
    PROVIDES = ("charging",)
    SUFFICES = False

    def reading(self, message, stamp):
        """Return the ``BatteryReading``, all else unknown."""
        charging = None if message.data < 0 else message.data > 0
        return BatteryReading(stamp, math.nan, math.nan, charging)
