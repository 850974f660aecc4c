"""Fixed obstacles of a scene: boxes and upright cylinders; a wall is a long thin box."""

import math
from typing import NamedTuple


class Box(NamedTuple):
    """An upright box: centre (x, y) [m], ``yaw`` [rad], length along and width across it [m]."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    height: float


class Cylinder(NamedTuple):
    """An upright cylinder: centre (x, y), radius, height [m]."""

    name: str
    x: float
    y: float
    radius: float
    height: float


def wall(name, start, end, thickness, height):
    """Return the ``Box`` that stands on the segment from ``start`` to ``end``, (x, y) [m] each."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        raise ValueError("wall {}: from and to are the same point {}".format(name, list(start)))
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    return Box(name, middle[0], middle[1], math.atan2(dy, dx), length, thickness, height)
