"""Sonar: transducers that each hear the nearest echo within a cone."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.reading import ScenarioError, shown
from mrs_simulator.sensors.noise import Noise
from mrs_simulator.sensors.scenery import Rays, cast
from mrs_simulator.sensors.types.placing import carried, directions, echoes
from mrs_simulator.vehicles.quantities import quantity

MOST = 64  # [-] transducers of one ring


class Numbers(NamedTuple):
    """Of a ring."""

    transducers: Tuple[Tuple[float, ...], ...]  # x, y [m], direction [rad] from the mount
    least: float  # [m]
    most: float  # [m]
    cone: float  # [rad] from one side to the other


class SonarReading(NamedTuple):
    """Distances [m] of the K transducers: inf without an echo, nan if lost."""

    stamp: float  # [s]
    ranges: np.ndarray  # (..., K) [m]
    places: np.ndarray  # (K, 3): x, y [m], direction [rad] in the robot's frame
    most: float  # [m] the greatest distance that is heard

    PER_ROBOT = ("ranges",)

    @property
    def points(self):
        """Return the echoes in the robot's frame, (..., K, 2) [m]; not finite without one."""
        return echoes(self.ranges, self.places)


class Sonar:
    """The distance of a transducer is that to the nearest point of any body within its cone.

    Echoes are heard from every surface, however it is turned, and from no other transducer; all fire at
    once.  What is nearer than the least range reads as that.
    """

    QUANTITIES = {"": "m"}
    RATE = 10.0
    NOISE = {"": Noise(stddev=0.0005 / math.sqrt(3.0))}

    @staticmethod
    def settings(section):
        """Return the ``Numbers`` in a mount's ``section``."""
        least, most = read_range(section, 0.1, 5.0)
        cone = section.quantity(
            "cone", "rad", math.radians(30.0), low=0.0, high=math.radians(170.0)
        )
        return Numbers(_read_transducers(section), least, most, cone)

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        self._numbers, self._rows, self._height = mount.numbers, rows, mount.place[2]
        self._places = on_robot(mount.place, np.array(mount.numbers.transducers))

    def read(self, state, environment, rng):
        """Return the ``SonarReading`` of all robots in ``rows``."""
        pose, numbers = state.pose[self._rows], self._numbers
        rays = Rays(
            carried(pose, self._places[:, :2]),
            directions(pose[:, 2], self._places[:, 2]),
            state.heights()[self._rows] + self._height,
            self._rows,
        )
        ranges = rng.noisy(cast(environment.at(state), rays, numbers.most, 0.5 * numbers.cone))
        return SonarReading(
            state.time, limited(ranges, numbers.least, numbers.most), self._places, numbers.most
        )


def read_range(section, least, most):
    """Return the least and the greatest distance [m], ``range`` of a mount, by default these."""
    given, where = section.take("range", [least, most]), section.at("range")
    if not isinstance(given, list) or len(given) != 2:
        raise ScenarioError("{}: {}, wanted [least, most]".format(where, shown(given)))
    least, most = (quantity(each, "m", where, low=0.0) for each in given)
    if not least < most:
        raise ScenarioError("{}: {}, wanted the least first".format(where, shown(given)))
    return least, most


def limited(ranges, least, most):
    """Return ``ranges`` no less than ``least`` [m], and inf beyond ``most`` [m]; nan stays."""
    return np.where(ranges > most, np.inf, np.maximum(ranges, least))


def on_robot(place, inner):
    """Return ``inner`` (K, 3), x, y, direction from a mount at ``place``, in the robot's frame."""
    cos, sin = math.cos(place[3]), math.sin(place[3])
    x, y = inner[:, 0], inner[:, 1]
    turned = place[0] + cos * x - sin * y, place[1] + sin * x + cos * y, place[3] + inner[:, 2]
    return np.stack(turned, axis=1)


def _read_transducers(section):
    given, where = section.take("transducers"), section.at("transducers")
    if not isinstance(given, list) or not 0 < len(given) <= MOST:
        raise ScenarioError(
            "{}: {}, wanted a list of up to {} [x, y, direction]".format(where, shown(given), MOST)
        )
    result = []
    for index, each in enumerate(given):
        own = "{}[{}]".format(where, index)
        if not isinstance(each, list) or len(each) != 3:
            raise ScenarioError("{}: {}, wanted [x, y, direction]".format(own, shown(each)))
        units = ("m", "m", "rad")
        result.append(tuple(quantity(value, unit, own) for value, unit in zip(each, units)))
    return tuple(result)
