"""What the robots of a team look like from above, each as its kind is.  No painting.

Lengths are in metres; x points ahead, the origin is the robot's centre.
"""

import functools
from typing import Any, NamedTuple, Tuple

import numpy as np

CORNERS = 32  # [-] of the polygon that is drawn for a round robot
TYRE = 0.5  # [-] width of a wheel over its radius
NOSE_AHEAD, NOSE_BEHIND, NOSE_WIDE = 0.83, 0.26, 0.22  # [-] of front, of front, of width


class Shape(NamedTuple):
    """One kind's polygons, (k, 2) each."""

    outline: Any
    nose: Any  # which shows where the robot is heading
    wheels: Tuple[Any, ...]


@functools.lru_cache(maxsize=64)
def shape_of(kind):
    """Return the ``Shape`` of a ``Kind``."""
    body = kind.body
    ahead, side = body.front, 0.5 * body.width
    if body.round:
        turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
        outline = body.front * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        outline = np.array([(ahead, side), (-body.rear, side), (-body.rear, -side), (ahead, -side)])
    # A body that hardly reaches ahead of its centre has its nose in the middle.
    length = max(ahead, 0.5 * body.length)
    tip = NOSE_AHEAD * ahead
    nose = [(tip, 0.0)] + [
        (tip - (NOSE_AHEAD - NOSE_BEHIND) * length, y * NOSE_WIDE * body.width) for y in (1.0, -1.0)
    ]
    return Shape(outline, np.array(nose), tuple(_wheels(kind.numbers)))


def _wheels(numbers):
    """Yield the rectangle of each wheel whose place the drive's ``numbers`` tell."""
    across = getattr(numbers, "spacing", 0.0) or getattr(numbers, "track", 0.0)
    base, radius = getattr(numbers, "wheelbase", 0.0), getattr(numbers, "radius", 0.0)
    if not across or not radius:
        return
    skid = hasattr(numbers, "spacing")  # about the middle, where a car's rear axle is the centre
    axles = (-0.5 * base, 0.5 * base) if base and skid else (0.0, base) if base else (0.0,)
    half = 0.5 * TYRE * radius
    corners = np.array([(radius, half), (-radius, half), (-radius, -half), (radius, -half)])
    for x in axles:
        for y in (0.5 * across, -0.5 * across):
            yield corners + (x, y)


class Shapes(NamedTuple):
    """The shapes of a team's robots: the distinct kinds, and measures [m] by row, (n,) each."""

    distinct: Tuple[Any, ...]  # ``Kind``s
    which: Any  # of them each robot is
    front: Any
    rear: Any
    half: Any  # of the width
    reach: Any
    length: Any
    round: Any  # bool

    @classmethod
    def of_kinds(cls, kinds):
        """Return the ``Shapes`` of robots of these ``Kind``s."""
        place = {kind: row for row, kind in enumerate(dict.fromkeys(kinds))}
        which = np.array([place[kind] for kind in kinds], dtype=int)
        table = np.array(
            [
                (b.front, b.rear, 0.5 * b.width, b.reach, b.length, b.round)
                for b in (kind.body for kind in place)
            ]
        ).reshape(-1, 6)
        *measures, is_round = table[which].T
        return cls(tuple(place), which, *measures, is_round.astype(bool))

    def of(self, rows):
        """Return the ``Shapes`` of the robots in ``rows``."""
        return Shapes(self.distinct, *(values[rows] for values in self[1:]))

    def by_kind(self):
        """Yield the rows of each kind that there is, and its ``Shape``."""
        for place, kind in enumerate(self.distinct):
            rows = np.flatnonzero(self.which == place)
            if len(rows):
                yield rows, shape_of(kind)

    @property
    def farthest(self):
        """Return the greatest reach [m], 0 without robots."""
        return float(self.reach.max(initial=0.0))
