"""Sonar: transducers that each measure the nearest echo within a cone."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.sensors.noise import Noise
from mrs_simulator.sensors.types.ranging import Ranging, read_range
from mrs_simulator.vehicles.quantities import quantity

FARTHEST = 100.0  # [m] from the mount
MOST = 64  # [-] transducers of one ring
CYCLE = 0.04  # [s] of Pioneers
ROUNDING = 1e-6  # [-] of a turn


class SonarSettings(NamedTuple):
    """Settings of a ring of transducers."""

    transducers: Tuple[Tuple[float, ...], ...]  # x, y [m], direction [rad] from the mount
    least: float  # [m]
    most: float  # [m]
    cone: float  # [rad] from one side to the other
    turns: int = 1  # [-] in which an array fires
    cycle: float = 0.0  # [s] from one turn to the next


class Sonar(Ranging):
    """The distance of a transducer is that to the nearest point of any body within its cone.

    Every surface echoes, however it is turned, and there is no crosstalk between transducers.  All fire at
    once, or in ``turns``: the k-th transducer in the turn k modulo ``turns``, one turn every ``cycle``.  A
    sample then has the newest echo of each, as measured at the first sample after it had fired, in the
    axes of the robot then; all fire at the first.
    """

    TYPE = "sonar"
    NOISE = {"": Noise(stddev=0.0005 / math.sqrt(3.0))}

    @staticmethod
    def settings(section):
        least, most = read_range(section, 0.1, 5.0)
        cone = section.quantity(
            "cone", "rad", math.radians(30.0), low=0.0, high=math.radians(170.0)
        )
        turns = section.whole("turns", 1, low=1, high=MOST)
        cycle = section.quantity("cycle", "s", CYCLE, above=0.0)
        return SonarSettings(_read_transducers(section), least, most, cone, turns, cycle)

    @staticmethod
    def columns(settings, kind):
        """Return the number of transducers."""
        return {"range": len(settings.transducers)}

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        settings = mount.settings
        super().__init__(mount, rows, np.array(settings.transducers), 0.5 * settings.cone)
        self._turn = np.arange(len(settings.transducers)) % settings.turns
        self.begin()

    def begin(self):
        """Let all transducers fire at the next sample."""
        self._fired, self._ranges = None, None

    def read(self, state, environment, rng):
        reading, settings = super().read(state, environment, rng), self._settings
        if settings.turns == 1:
            return reading
        fired, before = math.floor(state.time / settings.cycle + ROUNDING), self._fired
        if before is not None:
            new = np.isin(self._turn, np.arange(before + 1, fired + 1) % settings.turns)
            reading = reading._replace(ranges=np.where(new, reading.ranges, self._ranges))
        self._fired, self._ranges = fired, reading.ranges
        return reading


def _read_transducers(section):
    given, where = section.take("transducers"), section.at("transducers")
    if not isinstance(given, list) or not 0 < len(given) <= MOST:
        raise unwanted(where, given, "a list of up to {} [x, y, direction]".format(MOST))
    result = []
    for index, each in enumerate(given):
        own = "{}[{}]".format(where, index)
        if not isinstance(each, list) or len(each) != 3:
            raise unwanted(own, each, "[x, y, direction]")
        units = ("m", FARTHEST), ("m", FARTHEST), ("rad", 2.0 * math.pi)
        result.append(
            tuple(
                quantity(value, unit, own, low=-most, high=most)
                for value, (unit, most) in zip(each, units)
            )
        )
    return tuple(result)
