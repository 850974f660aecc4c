"""Collisions in the plane between robots' rectangular footprints, boxes and cylinders.

The broad phase is a Verlet list: pairs closer than their reach plus a skin are listed once and used
until some robot has moved half the skin, so that no pair can have met unlisted: the result is
that of testing all pairs.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import close_pairs, dot, squared

SKIN = 1.0  # [m] beyond reach, for which a pair is listed


class Footprint(NamedTuple):
    """A rectangle about a robot's wheel-axle centre: how far it reaches, [m]."""

    front: float
    rear: float
    width: float

    @property
    def half(self):
        """Return half of the length and half of the width."""
        return np.array([0.5 * (self.front + self.rear), 0.5 * self.width])

    @property
    def ahead(self):
        """Return how far the rectangle's middle lies ahead of the axle centre."""
        return 0.5 * (self.front - self.rear)

    @property
    def reach(self):
        """Return the distance from the axle centre to the farthest corner."""
        return float(np.hypot(max(self.front, self.rear), 0.5 * self.width))


class Rectangles(NamedTuple):
    """m rectangles: middle (m, 2) [m], axis along their length (m, 2), half sides (2,) or (m, 2)."""

    middle: np.ndarray
    axis: np.ndarray
    half: np.ndarray


def footprints_at(pose, footprint):
    """Return the ``Rectangles`` of robots at ``pose`` (n, 3)."""
    axis = np.empty((len(pose), 2), order="F")
    axis[:, 0], axis[:, 1] = cos_sin(pose[:, 2])
    return Rectangles(pose[:, :2] + footprint.ahead * axis, axis, footprint.half)


def rectangle_overlap(a, b):
    """Return how deep rectangles a and b overlap, (m,) [m], and the direction from a to b, (m, 2).

    Separating axes: the least overlap over the four sides' directions; negative where apart (then
    at most the distance).  Pushing b by depth along the direction separates the pair.
    """
    apart, rows = b.middle - a.middle, np.arange(len(a.middle))
    along = np.empty((4, len(rows)))
    along[0], along[1] = dot(apart, a.axis), _cross(a.axis, apart)
    along[2], along[3] = dot(apart, b.axis), _cross(b.axis, apart)
    overlap = _extents(a, b) - np.abs(along)
    least = np.argmin(overlap, axis=0)
    axis = np.where((least < 2)[:, np.newaxis], a.axis, b.axis)
    axis = np.where((least % 2 == 1)[:, np.newaxis], _left(axis), axis)
    sign = np.where(along[least, rows] < 0.0, -1.0, 1.0)
    return overlap[least, rows], sign[:, np.newaxis] * axis


def _extents(a, b):
    """Return how far a and b together reach along a's length and width and b's, (4, m) [m]."""
    cos, sin = np.abs(dot(a.axis, b.axis)), np.abs(_cross(a.axis, b.axis))
    extents = np.empty((4, len(cos)))
    for row, own, other in ((0, a, b), (2, b, a)):
        length, width = other.half[..., 0], other.half[..., 1]
        extents[row] = own.half[..., 0] + length * cos + width * sin
        extents[row + 1] = own.half[..., 1] + length * sin + width * cos
    return extents


def circle_overlap(a, middle, radius):
    """Return how deep circles overlap rectangles a, (m,), and the direction to the circle, (m, 2)."""
    apart = middle - a.middle
    side = _left(a.axis)
    local = np.stack([dot(apart, a.axis), dot(apart, side)], axis=1)
    nearest = np.clip(local, -a.half, a.half)
    gap = local - nearest
    distance = np.linalg.norm(gap, axis=1)
    inside = distance == 0.0
    # A centre inside the rectangle leaves it through the nearest side.
    room = a.half - np.abs(local)
    through = np.argmin(room, axis=1)
    outward = np.zeros_like(local)
    rows = np.arange(len(local))
    outward[rows, through] = np.where(local[rows, through] < 0.0, -1.0, 1.0)
    unit = np.where(
        inside[:, np.newaxis], outward, gap / np.where(inside, 1.0, distance)[:, np.newaxis]
    )
    depth = radius - np.where(inside, -room[rows, through], distance)
    return depth, unit[:, :1] * a.axis + unit[:, 1:] * side


def _left(axis):
    left = np.empty(axis.shape, order="F")
    left[:, 0], left[:, 1] = -axis[:, 1], axis[:, 0]
    return left


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


class VerletList:
    """The pairs of robots that may touch before any has moved half of ``SKIN``."""

    def __init__(self, reach):
        """``reach`` [m]: robots with centres closer than this may touch."""
        self.reach = reach
        self._origin = None

    def pairs(self, position):
        """Return the rows of the listed pairs for robots at ``position`` (n, 2)."""
        if self._origin is None or self._moved_far(position):
            self._origin = position.copy()
            self._pairs = close_pairs(position, self.reach + SKIN)
        return self._pairs

    def room(self, position):
        """Return a distance [m] that all robots may move from ``position`` and none comes into reach."""
        first, second = self.pairs(position)
        unlisted = 0.5 * SKIN - np.sqrt(self._farthest_moved(position))
        if not len(first):
            return unlisted
        nearest = np.sqrt(squared(position[second] - position[first]).min())
        return min(unlisted, 0.5 * (nearest - self.reach))

    def _moved_far(self, position):
        return self._farthest_moved(position) > (0.5 * SKIN) ** 2

    def _farthest_moved(self, position):
        return squared(position - self._origin).max()

    def clear(self):
        """Forget the list, after robots were put elsewhere."""
        self._origin = None
