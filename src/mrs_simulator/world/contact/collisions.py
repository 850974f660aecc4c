"""Collisions in the plane between robots' footprints (rectangles, circles), boxes and cylinders.

The broad phase is a Verlet list: pairs closer than their reach plus a skin are listed once and used
until some robot has moved half the skin, so that no pair can have met unlisted: the result is
that of testing all pairs.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.compiled_neighbours import compiled_pairs
from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import DENSE, close_pairs, dot, squared, squared_apart

EVERY = slice(None)
WORTH = (
    200  # [-] lists of more than ``DENSE`` robots that take numpy as long as numba takes to load
)
SKIN = 1.0  # [m] beyond reach, for which a pair is listed


class Footprints:
    """The footprints of a team, one robot per row.

    ``half`` (2,) or (n, 2) [m], half of the length and of the width; ``ahead`` [m], how far the
    rectangle's middle lies ahead of the centre; ``reach`` [m]; ``round`` (n,) bool: a circle of that
    reach, or None where no robot is round.
    """

    def __init__(self, bodies):
        """``bodies``: a ``vehicles.kind.Body`` for each robot."""
        self.half = _shared([[0.5 * body.length, 0.5 * body.width] for body in bodies], 2)
        self.ahead = _shared([0.5 * (body.front - body.rear) for body in bodies], 1)
        self.reach = _shared([body.reach for body in bodies], 1)
        self.farthest = float(np.max(self.reach, initial=0.0))
        self.round = np.array([body.round for body in bodies], dtype=bool)
        self.round = self.round if self.round.any() else None

    def of_all(self, n):
        """Return ``half`` (n, 2) and ``ahead`` (n,) of n robots, each with its own row."""
        return np.broadcast_to(self.half, (n, 2)).copy(), np.broadcast_to(self.ahead, (n,)).copy()

    def at(self, pose, rows=EVERY):
        """Return the ``Rectangles`` of the robots in ``rows``, which are at ``pose`` (m, 3)."""
        axis = np.empty((len(pose), 2), order="F")
        axis[:, 0], axis[:, 1] = cos_sin(pose[:, 2])
        half = self.half if self.half.ndim == 1 else self.half[rows]
        ahead = self.ahead if self.ahead.ndim == 0 else self.ahead[rows][:, np.newaxis]
        return Rectangles(pose[:, :2] + ahead * axis, axis, half)


class Pairs:
    """Pairs of robots, rows ``first`` and ``second`` (m,), that keep their headings for now."""

    def __init__(self, footprints, pose, first, second):
        """``footprints`` of robots at ``pose`` (n, 3)."""
        self.first, self.second, self._begun = first, second, pose[:, :2].copy()
        self._round = footprints.round
        each = footprints.at(pose)
        self._ahead = np.multiply(np.reshape(footprints.ahead, (-1, 1)), each.axis)
        self._a, self._b = each.of(first), each.of(second)
        if self._round is None:
            self._sides = _sides(self._a.axis, self._b.axis)
            self._extents = _extents(self._a, self._b)

    def left(self, pose, most):
        """Return whether a robot at ``pose`` (n, 3) now is more than ``most`` [m] from where it was."""
        return squared(pose[:, :2] - self._begun).max() > most**2

    def overlaps(self, pose):
        """Return which pairs overlap, (k,), how deep, (k,) [m], and the directions, (k, 2).

        With robots at ``pose`` (n, 3) now; depth and direction as of :func:`rectangle_overlap`.
        """
        middle = pose[:, :2] + self._ahead
        if self._round is None:
            apart = _taken(middle, self.second) - _taken(middle, self.first)
            return _deepest(apart, self._sides, self._extents)
        a = self._a._replace(middle=middle[self.first])
        b = self._b._replace(middle=middle[self.second])
        round_a, round_b = self._round[self.first], self._round[self.second]
        depth, direction = outline_overlap(a, b, round_a, round_b)
        hit = np.flatnonzero(depth > 0.0)
        return hit, depth[hit], direction[hit]


def _shared(values, dimensions):
    """Return ``values`` as an array, or only the first of them where all are the same."""
    values = np.array(values, dtype=float)
    if len(values) and (values == values[0]).all():
        return values[0]
    return values.reshape((len(values), 2)[:dimensions])


class Rectangles(NamedTuple):
    """m rectangles: middle (m, 2) [m], axis along their length (m, 2), half sides (2,) or (m, 2)."""

    middle: np.ndarray
    axis: np.ndarray
    half: np.ndarray

    def of(self, rows):
        """Return the rectangles in ``rows``."""
        half = self.half if self.half.ndim == 1 else self.half[rows]
        return Rectangles(_taken(self.middle, rows), _taken(self.axis, rows), half)

    @property
    def radius(self):
        """Return half of their lengths, () or (m,) [m]: the radius of those that are circles."""
        return self.half[..., 0]


def outline_overlap(a, b, round_a, round_b):
    """Return depth (m,) and direction (m, 2), as ``rectangle_overlap`` does, of any outlines.

    ``round_a``, ``round_b`` (m,) bool: those are circles with half of their length as radius.
    """
    depth, direction = np.empty(len(round_a)), np.empty((len(round_a), 2))
    for which, overlap in (
        (~round_a & ~round_b, rectangle_overlap),
        (~round_a & round_b, _overlap_with_circle),
        (round_a & ~round_b, _overlap_of_circle),
        (round_a & round_b, _overlap_of_circles),
    ):
        if which.any():
            depth[which], direction[which] = overlap(a.of(which), b.of(which))
    return depth, direction


def _overlap_with_circle(a, b):
    return circle_overlap(a, b.middle, b.radius)


def _overlap_of_circle(a, b):
    depth, toward = circle_overlap(b, a.middle, a.radius)
    return depth, -toward


def _overlap_of_circles(a, b):
    apart = b.middle - a.middle
    distance = np.sqrt(squared(apart))
    # Two centres in one place are pushed apart along the first one's axis.
    safe = np.where(distance > 0.0, distance, 1.0)[:, np.newaxis]
    direction = np.where(distance[:, np.newaxis] > 0.0, apart / safe, a.axis)
    return a.radius + b.radius - distance, direction


def rectangle_overlap(a, b):
    """Return how deep rectangles a and b overlap, (m,) [m], and the direction from a to b, (m, 2).

    Separating axes: the least overlap over the four sides' directions; negative where apart (then
    at most the distance).  Pushing b by depth along the direction separates the pair.
    """
    sides = _sides(a.axis, b.axis)
    along, overlap = _along(b.middle - a.middle, sides, _extents(a, b))
    least = np.argmin(overlap, axis=0)
    every = np.arange(len(least))
    return overlap[least, every], _outward(along, sides, least, every)


def _deepest(apart, sides, extents):
    """Return :func:`rectangle_overlap` of those pairs, (k,), that overlap: which, depth and direction."""
    along, overlap = _along(apart, sides, extents)
    hit = np.flatnonzero(overlap.min(axis=0) > 0.0)
    overlap = overlap.take(hit, axis=1)
    least = np.argmin(overlap, axis=0)
    depth = overlap[least, np.arange(len(hit))]
    return hit, depth, _outward(along, sides, least, hit)


def _sides(axis, other_axis):
    """Return the directions of the lengths and widths of pairs of rectangles, (2, 4, m)."""
    every = axis, _left(axis), other_axis, _left(other_axis)
    return np.stack([each.T for each in every], axis=1)


def _along(apart, sides, extents):
    """Return how far rectangles are ``apart`` along their sides, and overlap there, (4, m) [m] both."""
    along = sides[0] * apart[:, 0]
    along += sides[1] * apart[:, 1]
    return along, extents - np.abs(along)


def _outward(along, sides, least, rows):
    """Return the directions (k, 2) of the ``least`` overlap, (k,), of the pairs in ``rows`` (k,)."""
    at = least * along.shape[1] + rows
    sign = np.where(along.take(at) < 0.0, -1.0, 1.0)
    return (sign * sides.reshape(2, -1).take(at, axis=1)).T


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


def _taken(columns, rows):
    """Return the ``rows``, (k,) or (m,) bool, of ``columns`` (m, 2), column by column in memory."""
    return columns.T[:, rows].T if rows.dtype == bool else columns.T.take(rows, axis=1).T


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
        self.loop = None  # the compiled ``near_pairs``, where they are listed by it
        self._origin = self._pairs = self._kept = None

    def pairs(self, position):
        """Return the rows of the listed pairs for robots at ``position`` (n, 2)."""
        if self._origin is None or self._farthest_moved(position) > (0.5 * SKIN) ** 2:
            loop = None
            if len(position) <= DENSE:
                loop = self.loop
            elif self._pairs is not None:  # not the first time
                loop = same_bits(compiled_pairs, WORTH)
            self._origin = position.copy()
            self._pairs = close_pairs(position, self.reach + SKIN, loop)
        return self._pairs

    def listed(self, position):
        """Return the rows of the listed pairs, and where robots were then, (2, n) [m]."""
        pairs = self.pairs(position)
        if self._kept is None or self._kept[0] is not pairs:
            columns = np.ascontiguousarray(self._origin.T)
            self._kept = pairs, (*map(np.ascontiguousarray, pairs), columns)
        return self._kept[1]

    def listed_last(self):
        """Return what :meth:`listed` returned last, robots wherever they are by now; None before."""
        kept = self._kept
        listed = self._origin is not None and kept is not None and kept[0] is self._pairs
        return kept[1] if listed else None

    def room(self, position):
        """Return a distance [m] that all robots may move from ``position`` and none comes into reach."""
        first, second = self.pairs(position)
        unlisted = self.unlisted(position)
        if not len(first):
            return unlisted
        nearest = np.sqrt(squared_apart(position, first, second).min())
        return min(unlisted, 0.5 * (nearest - self.reach))

    def unlisted(self, position):
        """Return a distance [m] that all robots may move before other pairs are to be listed."""
        return 0.5 * SKIN - np.sqrt(self._farthest_moved(position))

    def _farthest_moved(self, position):
        return squared(position - self._origin).max()

    def clear(self):
        """Forget the list, after robots were put elsewhere."""
        self._origin = None
