"""Units of signals and of the numbers that they are compared with."""

import math
from typing import NamedTuple


class Unit(NamedTuple):
    """``factor`` times the unit ``dimension``, in which signals are."""

    dimension: str
    factor: float


UNITS = {
    "m": Unit("m", 1.0),
    "cm": Unit("m", 0.01),
    "mm": Unit("m", 0.001),
    "km": Unit("m", 1000.0),
    "s": Unit("s", 1.0),
    "ms": Unit("s", 0.001),
    "min": Unit("s", 60.0),
    "rad": Unit("rad", 1.0),
    "deg": Unit("rad", math.pi / 180.0),
    "m/s": Unit("m/s", 1.0),
    "cm/s": Unit("m/s", 0.01),
    "mm/s": Unit("m/s", 0.001),
    "rad/s": Unit("rad/s", 1.0),
    "deg/s": Unit("rad/s", math.pi / 180.0),
    "m/s^2": Unit("m/s^2", 1.0),
    "m^2": Unit("m^2", 1.0),
    "1/s": Unit("1/s", 1.0),
    "Hz": Unit("1/s", 1.0),
    "N": Unit("N", 1.0),
    "%": Unit("", 0.01),
}
