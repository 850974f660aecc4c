"""What sonar and laser have in common: distances along directions from places on a robot."""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.sensors.number_texts import degrees, number
from mrs_simulator.sensors.placing import echoes
from mrs_simulator.sensors.scenery import CarriedRays, cast
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.vehicles.quantities import quantity


class RangeReading(NamedTuple):
    """Distances [m] along K directions: inf where nothing is, nan if lost."""

    stamp: float  # [s]
    ranges: np.ndarray  # (..., K) [m]
    places: np.ndarray  # (K, 3): x, y [m] of each origin, direction [rad], in the robot's frame
    most: float  # [m] the greatest distance that is measured
    cone: float = 0.0  # [rad] half of the angle within which the nearest point is met; 0 for rays

    PER_ROBOT = ("ranges",)

    def text(self):
        """Return the nearest distance, and how many there are."""
        ranges = np.asarray(self.ranges)
        known = np.isfinite(ranges)
        counts = ["{} of {} within {:g} m".format(int(known.sum()), len(ranges), self.most)]
        lost = int(np.isnan(ranges).sum())
        if lost:
            counts.append("{} lost".format(lost))
        if known.any():
            first = int(np.argmin(np.where(known, ranges, np.inf)))
            near = number(ranges[first], 2, " m")
            way = degrees(math.remainder(float(self.places[first, 2]), 2.0 * math.pi))
            counts.insert(0, "nearest {} at {}".format(near, way))
        return ", ".join(counts)

    @property
    def points(self):
        """Return the points that were met, in the robot's frame, (..., K, 2) [m]; not finite where none."""
        return echoes(self.ranges, self.places)


class Ranging(Sensor):
    """A sensor of distances, whose settings have ``least`` and ``most`` [m].

    Shorter distances than the least read as the least.
    """

    QUANTITIES = {"": "m"}
    DIGITS = 9
    VARIES = True

    def __init__(self, mount, rows, inner, cone=0.0, step=0.0):
        """``rows`` (m,) of robots with this ``mount``; ``inner`` (K, 3): x, y, direction from the mount.

        ``cone`` [rad]: half of an opening angle; ``step`` [rad] as of ``CarriedRays``.
        """
        super().__init__(mount, rows, None)
        self._step = step
        self._height = np.full(len(rows), mount.place[2])
        self.places, self._cone = on_robot(mount.place, inner), cone
        # One origin for all rays that begin at the same place costs less.
        shared = (inner[:, :2] == inner[0, :2]).all()
        self._origins = self.places[: 1 if shared else None, :2]
        self._along = np.stack(cos_sin(self.places[:, 2]), axis=-1)

    def read(self, state, environment, rng):
        pose, (least, most) = state.pose[self._rows], (self._settings.least, self._settings.most)
        height = self._height + state.heights[self._rows] if "z" in vars(state) else self._height
        rays = CarriedRays(pose, self._origins, self._along, height, self._rows, self._step)
        ranges = rng.noisy(cast(environment.at(state), rays, most, self._cone))
        limit(ranges, least, most)
        return RangeReading(state.time, ranges, self.places, most, self._cone)


def read_range(section, least, most):
    """Return the least and the greatest distance [m], ``range`` of a mount, by default these."""
    given, where = section.take("range", [least, most]), section.at("range")
    if not isinstance(given, list) or len(given) != 2:
        raise unwanted(where, given, "[least, most]")
    least, most = (quantity(each, "m", where, low=0.0) for each in given)
    if not least < most:
        raise unwanted(where, given, "the least first")
    return least, most


def limit(ranges, least, most):
    """Raise ``ranges`` to ``least`` [m], and make those beyond ``most`` [m] inf; nan stays."""
    np.maximum(ranges, least, out=ranges)
    np.copyto(ranges, np.inf, where=ranges > most)


def on_robot(place, inner):
    """Return ``inner`` (K, 3), x, y, direction from a mount at ``place``, in the robot's frame."""
    cos, sin = math.cos(place[3]), math.sin(place[3])
    x, y = inner[:, 0], inner[:, 1]
    turned = place[0] + cos * x - sin * y, place[1] + sin * x + cos * y, place[3] + inner[:, 2]
    return np.stack(turned, axis=1)
