"""Collisions in the plane between robots' rectangular footprints, boxes and cylinders.

The broad phase is a Verlet list: pairs closer than their reach plus a skin are listed once and used
until some robot has moved half the skin, so that no pair can have met unlisted: the result is
that of testing all pairs.
"""

from typing import NamedTuple

import numpy as np

SKIN = 1.0  # [m] beyond reach, for which a pair is listed
DENSE = 256  # [-] robots up to which all pairs are looked at when listing
NEIGHBOUR_CELLS = ((0, 0), (1, 0), (0, 1), (1, 1), (1, -1))  # half of them: each pair once


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
    axis = np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)
    return Rectangles(pose[:, :2] + footprint.ahead * axis, axis, footprint.half)


def rectangle_overlap(a, b):
    """Return how deep rectangles a and b overlap, (m,) [m], and the direction from a to b, (m, 2).

    Separating axes: the least overlap over the four sides' directions; negative where apart (then
    at most the distance).  Pushing b by depth along the direction separates the pair.
    """
    apart = b.middle - a.middle
    least, direction = None, None
    for axis, own, other in (
        (a.axis, a, b),
        (_left(a.axis), a, b),
        (b.axis, b, a),
        (_left(b.axis), b, a),
    ):
        along = np.einsum("ij,ij->i", apart, axis)
        overlap = _extent(own, axis) + _extent(other, axis) - np.abs(along)
        outward = axis * np.where(along < 0.0, -1.0, 1.0)[:, np.newaxis]
        if least is None:
            least, direction = overlap, outward
            continue
        better = overlap < least
        least = np.where(better, overlap, least)
        direction = np.where(better[:, np.newaxis], outward, direction)
    return least, direction


def circle_overlap(a, middle, radius):
    """Return how deep circles overlap rectangles a, (m,), and the direction to the circle, (m, 2)."""
    apart = middle - a.middle
    side = _left(a.axis)
    local = np.stack([np.einsum("ij,ij->i", apart, a.axis), np.einsum("ij,ij->i", apart, side)], 1)
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
    return np.stack([-axis[:, 1], axis[:, 0]], axis=1)


def _extent(rectangles, axis):
    along = np.abs(np.einsum("ij,ij->i", rectangles.axis, axis))
    across = np.abs(np.einsum("ij,ij->i", _left(rectangles.axis), axis))
    half = np.broadcast_to(rectangles.half, (len(along), 2))
    return half[:, 0] * along + half[:, 1] * across


def close_pairs(position, distance):
    """Return the rows of all pairs of points closer than ``distance`` [m], (m,) and (m,), i < j."""
    if len(position) <= DENSE:
        first, second = np.triu_indices(len(position), 1)
    else:
        first, second = _grid_pairs(position, distance)
    apart = position[second] - position[first]
    near = np.einsum("ij,ij->i", apart, apart) < distance * distance
    return first[near], second[near]


def _grid_pairs(position, size):
    cell = np.floor((position - position.min(axis=0)) / size).astype(np.int64)
    width = cell[:, 1].max() + 3
    key = cell[:, 0] * width + cell[:, 1] + 1
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    pairs = []
    for dx, dy in NEIGHBOUR_CELLS:
        wanted = key + dx * width + dy
        begin = np.searchsorted(ordered, wanted, "left")
        count = np.searchsorted(ordered, wanted, "right") - begin
        first = np.repeat(np.arange(len(position)), count)
        offset = np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
        second = order[np.repeat(begin, count) + offset]
        keep = first < second if (dx, dy) == (0, 0) else slice(None)
        pairs.append(np.stack([first[keep], second[keep]]))
    first, second = np.concatenate(pairs, axis=1)
    low, high = np.minimum(first, second), np.maximum(first, second)
    # In ascending order the result does not depend on the way it was found.
    sequence = np.lexsort((high, low))
    return low[sequence], high[sequence]


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

    def _moved_far(self, position):
        moved = position - self._origin
        return np.einsum("ij,ij->i", moved, moved).max() > (0.5 * SKIN) ** 2

    def clear(self):
        """Forget the list, after robots were put elsewhere."""
        self._origin = None
