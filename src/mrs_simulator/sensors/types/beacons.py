"""Ranges, and bearings, of beacons at known places."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import direction_of, wrap_angle
from mrs_simulator.scenario.reading import ScenarioError, shown, unwanted
from mrs_simulator.sensors.number_texts import listed_text
from mrs_simulator.sensors.placing import carried
from mrs_simulator.sensors.scenery import Rays, cast
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.vehicles.quantities import quantity

# [m] by which a body before a beacon must be nearer to hide it, not that which bears it
TOUCH = 1e-9
MOST = 1000  # [-] beacons of one sensor
FARTHEST = 1e6  # [m] from the common frame's origin


class BeaconSettings(NamedTuple):
    """Settings of a sensor of beacons."""

    points: Tuple[Tuple[float, float], ...]  # [m] in the common frame, of beacons 1, 2, ...
    most: float  # [m]
    view: float  # [rad] field of view, from one side to the other
    bearing: bool  # whether directions are measured too
    occlusion: bool  # whether bodies hide what is behind them


class BeaconReading(NamedTuple):
    """The K beacons that are received, in the order of their numbers."""

    stamp: float  # [s]
    numbers: np.ndarray  # (K,) from 1 on
    ranges: np.ndarray  # (K,) [m] from the sensor, in the plane
    bearings: np.ndarray  # (K,) [rad] from the robot's heading; nan where only ranges are measured

    PER_ROBOT = ("ranges", "bearings")

    def of(self, k):
        """Return the reading of the k-th robot from rows of all, where nan stands for none."""
        here = np.flatnonzero(np.isfinite(self.ranges[k]))
        return BeaconReading(
            self.stamp, self.numbers[here], self.ranges[k, here], self.bearings[k, here]
        )

    def text(self):
        """Return the beacons received, with units."""
        return listed_text("beacon", self)


class Beacons(Sensor):
    """Beacons whose numbers are known, as far as nothing stands before them at the sensor's height.

    ``dropout`` of a range loses the beacon for that sample, of a bearing the bearing alone.
    """

    TYPE = "beacons"
    QUANTITIES = {"range": "m", "bearing": "rad"}
    COLUMNS = {"range": 1, "bearing": 1}
    LISTS = "beacon"
    VARIES = True

    @staticmethod
    def settings(section):
        return BeaconSettings(
            _read_points(section),
            section.quantity("range", "m", 30.0, above=0.0),
            section.quantity("view", "rad", 2.0 * math.pi, above=0.0, high=2.0 * math.pi),
            section.flag("bearing", False),
            section.flag("occlusion", True),
        )

    @staticmethod
    def most(settings, n):
        """Return how many beacons there are."""
        return len(settings.points)

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self._points = np.array(mount.settings.points)
        self._place, self._height, self._yaw = np.array([mount.place[:2]]), *mount.place[2:]
        self._names = np.arange(1, len(self._points) + 1)

    def read(self, state, environment, rng):
        """Return the ``BeaconReading`` of all robots in ``rows``, with a row for each."""
        pose, settings = state.pose[self._rows], self._settings
        origin = carried(pose, self._place)  # (m, 1, 2)
        way = self._points - origin  # (m, K, 2)
        far = np.hypot(way[..., 0], way[..., 1])
        bearing = wrap_angle(direction_of(way) - pose[:, 2:])
        received = far <= settings.most
        if settings.view < 2.0 * math.pi:
            received &= np.abs(wrap_angle(bearing - self._yaw)) <= 0.5 * settings.view
        if settings.occlusion:
            received &= self._is_open(state, environment, origin, way, far)
        ranges = np.maximum(rng.noisy(np.where(received, far, np.nan), "range"), 0.0)
        bearings = np.full_like(ranges, np.nan)
        if settings.bearing:
            bearings = wrap_angle(rng.noisy(np.where(received, bearing, np.nan), "bearing"))
        return BeaconReading(state.time, self._names, ranges, bearings)

    def _is_open(self, state, environment, origin, way, far):
        """Return where nothing stands between the sensors and the beacons, (m, K) bool."""
        length = np.where(far > 0.0, far, 1.0)[..., np.newaxis]
        height = state.heights[self._rows] + self._height
        rays = Rays(origin, way / length, height, self._rows)
        return cast(environment.at(state), rays, self._settings.most) >= far - TOUCH


def _read_points(section):
    """Return the places of the beacons, ((x, y), ...) [m]."""
    given, where = section.take("points"), section.at("points")
    if not isinstance(given, list) or not 0 < len(given) <= MOST:
        raise unwanted(
            where, given, "places of 1 to {} beacons, such as [[5.0, 0.0], [0.0, 5.0]]".format(MOST)
        )
    for k, point in enumerate(given):
        if not isinstance(point, list) or len(point) != 2:
            raise ScenarioError("{}[{}]: {}, wanted [x, y]".format(where, k, shown(point)))
    bounds = {"low": -FARTHEST, "high": FARTHEST}
    return tuple(
        tuple(quantity(each, "m", "{}[{}]".format(where, k), **bounds) for each in point)
        for k, point in enumerate(given)
    )
