"""Inertial sensors, compass and altimeter."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.core.spatial import turned_about_z
from mrs_simulator.sensors.number_texts import degrees, number
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.state.columns import ORIENTATION, OUT_OF_PLANE

GRAVITY = 9.80665  # [m/s^2] standard


class ImuReading(NamedTuple):
    """Readings of an accelerometer and a gyroscope at a robot's centre, in its axes."""

    stamp: float  # [s]
    acceleration: np.ndarray  # (..., 3) [m/s^2] specific force: g upwards at rest
    rate: np.ndarray  # (..., 3) [rad/s]

    PER_ROBOT = ("acceleration", "rate")

    def text(self):
        """Return the values with their units."""
        force, rate = ("({})".format(", ".join(number(v, 2) for v in each)) for each in self[1:3])
        return "a = {} m/s\u00b2, \u03c9 = {} rad/s".format(force, rate)


class Imu(Sensor):
    """Specific force ``dv/dt + omega x v - g`` in the body's axes, over the last step, and turn rates.

    The sensor is taken to be at the robot's centre, and its axes to be the robot's.
    """

    TYPE = "imu"
    QUANTITIES = {"acceleration": "m/s^2", "rate": "rad/s"}
    COLUMNS = {"acceleration": 3, "rate": 3}
    RATE = 50.0
    LOOKS_BACK = True  # its reading needs the state one step before

    def read(self, state, environment, rng, before):
        """Return the ``ImuReading`` of all robots in ``rows``; ``before``: the state one step earlier."""
        velocity, rate = body_twist(state, self._rows)
        earlier, _ = body_twist(before, self._rows)
        force = (velocity - earlier) / (state.time - before.time) + np.cross(rate, velocity)
        force += GRAVITY * upwards(state, self._rows)
        acceleration = rng.noisy(force, "acceleration")
        return ImuReading(state.time, acceleration, rng.noisy(rate, "rate"))


def body_twist(state, rows):
    """Return the velocities and turn rates (m, 3) each of robots ``rows``, in their axes."""
    velocity, rate = np.zeros((len(rows), 3)), np.zeros((len(rows), 3))
    velocity[:, :2], rate[:, 2] = state.twist[rows, :2], state.twist[rows, 2]
    if state.has(OUT_OF_PLANE):
        velocity[:, 2], rate[:, :2] = state.out_of_plane[rows, 0], state.out_of_plane[rows, 1:]
    return velocity, rate


def upwards(state, rows):
    """Return the vertical's direction (m, 3) in the axes of robots ``rows``."""
    is_level = not state.has(ORIENTATION)
    turn = turned_about_z(state.pose[rows, 2]) if is_level else state.orientation[rows]
    x, y, z, w = turn.T
    # The last row of the rotation from the body's axes to the common frame.
    return np.stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], axis=1
    )


class CompassReading(NamedTuple):
    """A heading."""

    stamp: float  # [s]
    heading: float  # (...) [rad] from the x axis of the common frame, counterclockwise

    PER_ROBOT = ("heading",)

    def text(self):
        """Return the heading with its unit."""
        return "heading {}".format(degrees(self.heading))


class Compass(Sensor):
    """The heading in the common frame."""

    TYPE = "compass"
    QUANTITIES = {"": "rad"}
    COLUMNS = {"heading": 1}

    def read(self, state, environment, rng):
        return CompassReading(state.time, wrap_angle(rng.noisy(state.pose[self._rows, 2])))


class AltimeterReading(NamedTuple):
    """A height."""

    stamp: float  # [s]
    height: float  # (...) [m] of the robot's underside above the ground

    PER_ROBOT = ("height",)

    def text(self):
        """Return the height with its unit."""
        return "z = {}".format(number(self.height, 3, " m"))


class Altimeter(Sensor):
    """The height above the ground."""

    TYPE = "altimeter"
    QUANTITIES = {"": "m"}
    COLUMNS = {"height": 1}

    def read(self, state, environment, rng):
        return AltimeterReading(state.time, rng.noisy(state.heights[self._rows]))
