"""Planar laser scanners."""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, unwanted
from mrs_simulator.sensors.types.ranging import Ranging, read_range
from mrs_simulator.vehicles.quantities import quantity

MOST = 10000  # [-] rays


class LaserSettings(NamedTuple):
    """Settings of a scanner."""

    rays: int
    first: float  # [rad] direction of the first ray, from the mount's
    last: float  # [rad] of the last ray
    least: float  # [m]
    most: float  # [m]


class Laser(Ranging):
    """Rays from one place, from the right to the left; a scan is taken at one time."""

    TYPE = "laser"
    # Bounds of a uniform error as a standard deviation, a / sqrt(3); of the scanner itself where known.
    MODELS = {
        "lms200": {  # as MobileSim has it: 32 m, 5 mm uniform
            "rays": 181,
            "angles": ["-90 deg", "90 deg"],
            "range": [0.1, 32.767],
            "rate": 10.0,
            "noise": {"stddev": 0.005 / math.sqrt(3.0)},
        },
        "urg04lx": {
            "rays": 683,
            "angles": ["-120 deg", "120 deg"],
            "range": [0.05, 5.6],
            "rate": 10.0,
            "noise": {"stddev": 0.005},
        },
        "lds01": {  # one ray for each degree, the first one ahead of the mount's back
            "rays": 360,
            "angles": ["-180 deg", "179 deg"],
            "range": [0.12, 3.5],
            "rate": 5.0,
            "noise": {"stddev": 0.01},
        },
    }

    @staticmethod
    def settings(section):
        least, most = read_range(section, 0.1, 10.0)
        rays = section.whole("rays", 181, low=1, high=MOST)
        first, last = _read_angles(section)
        if rays > 1 and last <= first:
            raise ScenarioError("{}: the last is not beyond the first".format(section.at("angles")))
        return LaserSettings(rays, first, last, least, most)

    @staticmethod
    def columns(settings, kind):
        """Return the number of rays."""
        return {"range": settings.rays}

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots with this ``mount``."""
        settings = mount.settings
        inner = np.zeros((settings.rays, 3))
        inner[:, 2] = np.linspace(settings.first, settings.last, settings.rays)
        step = (settings.last - settings.first) / max(1, settings.rays - 1)
        super().__init__(mount, rows, inner, step=step if settings.rays > 1 else 0.0)


def _read_angles(section):
    """Return the directions [rad] of the first and the last ray."""
    given = section.take("angles", [-0.5 * math.pi, 0.5 * math.pi])
    where = section.at("angles")
    if not isinstance(given, list) or len(given) != 2:
        raise unwanted(where, given, "[first, last]")
    return tuple(quantity(v, "rad", where, low=-2.0 * math.pi, high=2.0 * math.pi) for v in given)
