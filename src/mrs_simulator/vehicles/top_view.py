"""A kind of robot from above: polygons about its centre, x ahead, in metres."""

import functools
from typing import Any, NamedTuple, Tuple

import numpy as np

CORNERS = 32  # [-] of the polygon of a round robot
TYRE = 0.5  # [-] width of a wheel over its radius
NOSE_TIP, NOSE_LENGTH, NOSE_WIDTH = 0.83, 0.57, 0.44  # [-] of front, of length ahead, of width


class TopView(NamedTuple):
    """One kind's polygons, (k, 2) each."""

    outline: Any
    nose: Any  # which shows where the robot is heading
    wheels: Tuple[Any, ...]


@functools.lru_cache(maxsize=64)
def top_view(kind):
    """Return the ``TopView`` of a ``Kind``."""
    numbers = kind.numbers
    half, radius = 0.5 * TYRE * getattr(numbers, "radius", 0.0), getattr(numbers, "radius", 0.0)
    corners = np.array([(radius, half), (-radius, half), (-radius, -half), (radius, -half)])
    wheels = tuple(corners + place for place in wheel_places(kind))
    return TopView(_outline(kind.body), _nose(kind.body), wheels)


def _outline(body):
    if body.round:
        turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
        return body.front * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    side = 0.5 * body.width
    return np.array(
        [(body.front, side), (-body.rear, side), (-body.rear, -side), (body.front, -side)]
    )


def _nose(body):
    tip = NOSE_TIP * body.front
    # A body that hardly reaches ahead of its centre has its nose farther back.
    back = tip - NOSE_LENGTH * max(body.front, 0.5 * body.length)
    side = 0.5 * NOSE_WIDTH * body.width
    return np.array([(tip, 0.0), (back, side), (back, -side)])


def wheel_places(kind):
    """Return the centre (x, y) of each wheel, a list; empty where the drive has none."""
    numbers = kind.numbers
    across = getattr(numbers, "spacing", 0.0) or getattr(numbers, "track", 0.0)
    base = getattr(numbers, "wheelbase", 0.0)
    if not across:
        return []
    # Skid steers have the centre between their axles, cars on the rear one.
    skid = hasattr(numbers, "spacing")
    axles = (0.0,) if not base else (-0.5 * base, 0.5 * base) if skid else (0.0, base)
    return [(x, side * across) for x in axles for side in (0.5, -0.5)]
