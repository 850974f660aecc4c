"""Sonar: transducers that each hear the nearest echo within a cone."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.reading import ScenarioError, shown
from mrs_simulator.sensors.noise import Noise
from mrs_simulator.sensors.types.ranging import Ranging, read_range
from mrs_simulator.vehicles.quantities import quantity

MOST = 64  # [-] transducers of one ring


class Numbers(NamedTuple):
    """Of a ring."""

    transducers: Tuple[Tuple[float, ...], ...]  # x, y [m], direction [rad] from the mount
    least: float  # [m]
    most: float  # [m]
    cone: float  # [rad] from one side to the other


class Sonar(Ranging):
    """The distance of a transducer is that to the nearest point of any body within its cone.

    Echoes are heard from every surface, however it is turned, and from no other transducer; all fire at
    once.
    """

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
        numbers = mount.numbers
        super().__init__(mount, rows, np.array(numbers.transducers), 0.5 * numbers.cone)


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
