"""Robots on the ground pushed apart by a loop that numba compiles, with results equal to the bit.

It does numpy's operations of ``collisions`` and ``bodies`` in numpy's order, pair by pair.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit

FAR = -1  # returned where robots went so far that pairs are to be selected anew


def push_all(x, y, axis, ahead, half, first, second, bounds, passes, found):
    """Push overlapping rectangles at ``x``, ``y`` (n,) [m] apart, in place, as ``Bodies.separate`` does.

    ``axis`` (n, 2): their directions; ``ahead`` (n,) and ``half`` (n, 2) [m] as ``Footprints`` has them;
    ``first``, ``second`` (m,): pairs listed; ``bounds``: squares of the distance below which a pair is
    looked at, and of the way after which pairs are to be selected anew [m^2]; ``found`` (m, 5): filled
    with rows, middle and depth of the pairs that overlap at first.  Returns how many of these there are,
    or ``FAR``, with robots moved in part.
    """
    near = within(x, y, first, second, bounds[0])
    first, second = first[near], second[near]
    extents, x0, y0 = projections(axis, half, first, second), x.copy(), y.copy()
    hits, pair, shift = 0, np.empty(len(first), dtype=np.int64), np.empty((len(first), 2))
    for turn in range(passes):
        if turn and farthest(x, y, x0, y0) > bounds[1]:
            return FAR
        count = 0
        for k in range(len(first)):
            a, b = first[k], second[k]
            deep, east, north = overlap(x, y, axis, ahead, extents[k], a, b)
            if not deep > 0.0:
                continue
            pair[count] = k
            shift[count, 0], shift[count, 1] = 0.5 * deep * east, 0.5 * deep * north
            if turn == 0:
                found[count, 0], found[count, 1] = a, b
                found[count, 2], found[count, 3] = 0.5 * (x[a] + x[b]), 0.5 * (y[a] + y[b])
                found[count, 4] = deep
            count += 1
        if turn == 0:
            hits = count
        if count == 0:
            break
        part(x, y, first[pair[:count]], second[pair[:count]], shift)
    return hits


def within(x, y, first, second, bound):
    """Return the rows of pairs whose squared distance [m^2] is below ``bound``."""
    near, m = np.empty(len(first), dtype=np.int64), 0
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        if dx * dx + dy * dy < bound:
            near[m] = k
            m += 1
    return near[:m]


def projections(axis, half, first, second):
    """Return half of both bodies' extents (m, 4) [m] along the four axes of each pair."""
    extents = np.empty((len(first), 4))
    for k in range(len(first)):
        a, b = first[k], second[k]
        cos = abs(axis[a, 0] * axis[b, 0] + axis[a, 1] * axis[b, 1])
        sin = abs(axis[a, 0] * axis[b, 1] - axis[a, 1] * axis[b, 0])
        extents[k, 0] = half[a, 0] + half[b, 0] * cos + half[b, 1] * sin
        extents[k, 1] = half[a, 1] + half[b, 0] * sin + half[b, 1] * cos
        extents[k, 2] = half[b, 0] + half[a, 0] * cos + half[a, 1] * sin
        extents[k, 3] = half[b, 1] + half[a, 0] * sin + half[a, 1] * cos
    return extents


def farthest(x, y, x0, y0):
    """Return the square of the farthest way [m^2] from ``x0``, ``y0``."""
    most = 0.0
    for row in range(len(x)):
        dx, dy = x[row] - x0[row], y[row] - y0[row]
        most = max(most, dx * dx + dy * dy)
    return most


def overlap(x, y, axis, ahead, extents, a, b):
    """Return the overlap [m] of ``a`` and ``b``, and the unit vector toward ``b`` at which it is least."""
    dx = (x[b] + ahead[b] * axis[b, 0]) - (x[a] + ahead[a] * axis[a, 0])
    dy = (y[b] + ahead[b] * axis[b, 1]) - (y[a] + ahead[a] * axis[a, 1])
    deep, east, north = np.inf, 0.0, 0.0
    for side in range(4):
        row = a if side < 2 else b
        u, v = axis[row, 0], axis[row, 1]
        if side % 2:
            u, v = -v, u
        along = u * dx + v * dy
        depth = extents[side] - abs(along)
        if depth < deep:
            sign = -1.0 if along < 0.0 else 1.0
            deep, east, north = depth, sign * u, sign * v
    return deep, east, north


def part(x, y, first, second, shift):
    """Move robots ``first`` by ``-shift``, then ``second`` by ``shift`` (m, 2) [m], in place."""
    for row in range(len(x)):  # np.bincount makes -0.0 to 0.0
        x[row], y[row] = x[row] + 0.0, y[row] + 0.0
    for k in range(len(first)):
        x[first[k]] -= shift[k, 0]
        y[first[k]] -= shift[k, 1]
    for k in range(len(second)):
        x[second[k]] += shift[k, 0]
        y[second[k]] += shift[k, 1]


@functools.lru_cache(maxsize=None)
def compiled_push():
    """Return the compiled ``push_all``; ``ValueError`` without numba."""
    return linked(push_all, jit(cache=True))
