"""Range and bearing to other robots."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import direction_of, wrap_angle
from mrs_simulator.sensors.number_texts import listed_text
from mrs_simulator.sensors.placing import carried
from mrs_simulator.sensors.scenery import Rays, cast
from mrs_simulator.sensors.types.sensor import Sensor

TOUCH = 1e-9  # [m] by which a body before the other robot must be nearer to hide it


class RangeBearingSettings(NamedTuple):
    """Settings of a sensor of ranges and bearings."""

    most: float  # [m]
    view: float  # [rad] field of view, from one side to the other
    occlusion: bool  # whether bodies hide what is behind them


class RangeBearingReading(NamedTuple):
    """The K other robots that are seen, in the order of their numbers."""

    stamp: float  # [s]
    numbers: np.ndarray  # (K,)
    ranges: np.ndarray  # (K,) [m] from the sensor to the robots' centres, in the plane
    bearings: np.ndarray  # (K,) [rad] from the robot's heading
    place: Tuple[float, float] = (0.0, 0.0)  # [m] of the sensor in the robot's frame

    PER_ROBOT = ("ranges", "bearings")

    def of(self, k):
        """Return the reading of the k-th robot from rows of all, where nan stands for those not seen."""
        ranges, bearings = self.ranges[k], self.bearings[k]
        (seen,) = (np.isfinite(ranges) & np.isfinite(bearings)).nonzero()
        own = self.numbers[seen], ranges[seen], bearings[seen]
        return RangeBearingReading(self.stamp, *own, self.place)

    def text(self):
        """Return the robots seen, with units."""
        return listed_text("robot", self)

    @property
    def points(self):
        """Return their positions in the robot's frame, (K, 2) [m]."""
        way = np.empty((*self.bearings.shape, 2))
        way[..., 0], way[..., 1] = np.cos(self.bearings), np.sin(self.bearings)
        return np.array(self.place) + self.ranges[..., np.newaxis] * way


class RangeBearing(Sensor):
    """Others are seen by their centres, whose numbers are known, as far as nothing stands before them.

    ``dropout`` of a range or a bearing loses the other robot for that sample.
    """

    TYPE = "range_bearing"
    QUANTITIES = {"range": "m", "bearing": "rad"}
    COLUMNS = {"range": 1, "bearing": 1}
    SEES_ROBOTS = True
    LISTS = "seen"
    VARIES = True

    @staticmethod
    def settings(section):
        return RangeBearingSettings(
            section.quantity("range", "m", 5.0, above=0.0),
            section.quantity("view", "rad", 2.0 * math.pi, above=0.0, high=2.0 * math.pi),
            section.flag("occlusion", True),
        )

    @staticmethod
    def most(settings, n):
        """Return how many others there are, at least 1."""
        return max(1, n - 1)

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self._place, self._height, self._yaw = np.array([mount.place[:2]]), *mount.place[2:]
        self._names = np.arange(1, team.n + 1)

    def read(self, state, environment, rng):
        """Return the ``RangeBearingReading`` of all robots in ``rows``, with a row for each."""
        pose, settings = state.pose[self._rows], self._settings
        origin = carried(pose, self._place)  # (m, 1, 2)
        way = state.pose[:, :2] - origin  # (m, n, 2)
        far = np.hypot(way[..., 0], way[..., 1])
        bearing = wrap_angle(direction_of(way) - pose[:, 2:])
        seen = far <= settings.most
        seen[np.arange(len(pose)), self._rows] = False
        if settings.view < 2.0 * math.pi:
            seen &= np.abs(wrap_angle(bearing - self._yaw)) <= 0.5 * settings.view
        if settings.occlusion:
            self._hide(seen, state, environment, origin, way, far)
        ranges = np.maximum(rng.noisy(np.where(seen, far, np.nan), "range"), 0.0)
        bearings = wrap_angle(rng.noisy(np.where(seen, bearing, np.nan), "bearing"))
        place = tuple(self._place[0].tolist())
        return RangeBearingReading(state.time, self._names, ranges, bearings, place)

    def _hide(self, seen, state, environment, origin, way, far):
        """Clear in ``seen`` (m, n) the robots before which another body stands."""
        k, other = np.nonzero(seen & (far > 0.0))
        distance = far[k, other]
        rays = Rays(
            origin[k],
            (way[k, other] / distance[:, np.newaxis])[:, np.newaxis],
            state.heights[self._rows[k]] + self._height,
            self._rows[k],
        )
        met = cast(environment.at(state), rays, self._settings.most, unseen=other)[:, 0]
        hidden = met < distance - TOUCH
        seen[k[hidden], other[hidden]] = False
