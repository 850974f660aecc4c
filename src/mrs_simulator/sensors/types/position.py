"""Sensors of positions: motion capture, and satellites."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.scenario.reading import number, unwanted
from mrs_simulator.sensors.number_texts import DEGREE, degrees
from mrs_simulator.sensors.number_texts import number as number_text
from mrs_simulator.sensors.placing import carried
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.vehicles.quantities import quantity

# The ellipsoid of WGS 84.
EQUATOR = 6378137.0  # [m] semi-major axis
FLATTENING = 1.0 / 298.257223563
SQUARE = FLATTENING * (2.0 - FLATTENING)  # of the eccentricity


class PoseReading(NamedTuple):
    """A pose in the common frame."""

    stamp: float  # [s]
    x: float  # (...) [m]
    y: float  # (...) [m]
    theta: float  # (...) [rad]

    PER_ROBOT = ("x", "y", "theta")

    def text(self):
        """Return the values with their units."""
        x, y = (number_text(value, 3, " m") for value in self[1:3])
        return "x = {}, y = {}, \u03b8 = {}".format(x, y, degrees(self.theta))


class MotionCapture(Sensor):
    """The pose in the common frame, as cameras in the room measure it."""

    TYPE = "motion_capture"
    QUANTITIES = {"position": "m", "heading": "rad"}
    COLUMNS = {"x": 1, "y": 1, "theta": 1}
    RATE = 100.0

    def read(self, state, environment, rng):
        pose = state.pose[self._rows]
        x, y = rng.noisy(pose[:, :2], "position").T
        return PoseReading(state.time, x, y, wrap_angle(rng.noisy(pose[:, 2], "heading")))


class GpsSettings(NamedTuple):
    """Place of the common frame on the earth."""

    origin: Tuple[float, float, float]  # latitude, longitude [rad], altitude [m]


class GpsReading(NamedTuple):
    """A place on the ellipsoid of WGS 84."""

    stamp: float  # [s]
    latitude: float  # (...) [deg]
    longitude: float  # (...) [deg]
    altitude: float  # (...) [m]

    PER_ROBOT = ("latitude", "longitude", "altitude")

    def text(self):
        """Return the values with their units."""
        if not all(map(math.isfinite, self[1:4])):
            return "no fix"
        latitude, longitude = (number_text(value, 6, DEGREE) for value in self[1:3])
        return "{}, {}, {}".format(latitude, longitude, number_text(self.altitude, 2, " m"))


class Gps(Sensor):
    """The antenna's place; x of the common frame points east, y north.

    Degrees are by the ellipsoid's radii of curvature at the origin: for scenes of a few kilometres.
    """

    TYPE = "gps"
    QUANTITIES = {"": "m"}
    COLUMNS = {"latitude": 1, "longitude": 1, "altitude": 1}
    RATE = 5.0

    @staticmethod
    def settings(section):
        given, where = section.take("origin", [0.0, 0.0, 0.0]), section.at("origin")
        if not isinstance(given, list) or len(given) != 3:
            raise unwanted(where, given, "[latitude, longitude, altitude], deg and m")
        high = math.radians(89.0), math.pi, 1e5
        degrees = [each if isinstance(each, str) else None for each in given[:2]]
        for k, most in enumerate((89.0, 180.0)):
            if degrees[k] is None:
                degrees[k] = "{!r} deg".format(number(given[k], where, low=-most, high=most))
        units = "rad", "rad", "m"
        return GpsSettings(
            tuple(
                quantity(value, unit, where, low=-most, high=most)
                for value, unit, most in zip((*degrees, given[2]), units, high)
            )
        )

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self._place, self._height = np.array([mount.place[:2]]), mount.place[2]
        self._origin = mount.settings.origin

    def read(self, state, environment, rng):
        place = carried(state.pose[self._rows], self._place)[:, 0]
        up = state.heights[self._rows] + self._height
        return GpsReading(
            state.time, *geodetic(rng.noisy(np.column_stack([place, up])), self._origin)
        )


def geodetic(place, origin):
    """Return latitudes, longitudes [deg] and altitudes [m], (m,) each, of ``place`` (m, 3) [m].

    ``place`` is east, north, up from the ``origin``: latitude, longitude [rad], altitude [m].
    """
    north, east = radii(origin[0])
    latitude = np.degrees(origin[0] + place[:, 1] / north)
    longitude = np.degrees(origin[1] + place[:, 0] / (east * math.cos(origin[0])))
    beyond = np.abs(longitude) > 180.0
    if beyond.any():
        longitude = np.where(beyond, longitude - np.copysign(360.0, longitude), longitude)
    return latitude, longitude, origin[2] + place[:, 2]


def local_place(reading, origin):
    """Return east, north, up [m] of a ``GpsReading`` from the ``origin``: undoes :func:`geodetic`."""
    north, east = radii(origin[0])
    eastwards = math.radians(reading.longitude) - origin[1]
    if abs(eastwards) > math.pi:  # on the other side of the antimeridian
        eastwards -= math.copysign(2.0 * math.pi, eastwards)
    return (
        east * math.cos(origin[0]) * eastwards,
        north * (math.radians(reading.latitude) - origin[0]),
        reading.altitude - origin[2],
    )


def radii(latitude):
    """Return the radii of curvature [m] of the ellipsoid along the meridian and across it."""
    inner = 1.0 - SQUARE * math.sin(latitude) ** 2
    return EQUATOR * (1.0 - SQUARE) / inner**1.5, EQUATOR / math.sqrt(inner)
