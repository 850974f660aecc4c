"""Robots on the ground pushed apart by a loop that numba compiles, with results equal to the bit.

It does numpy's operations of ``collisions`` and ``bodies`` in numpy's order, pair by pair.
"""

import functools

import numpy as np

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
    near = np.empty(len(first), dtype=np.int64)
    m = 0
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        if dx * dx + dy * dy < bounds[0]:
            near[m] = k
            m += 1
    x0, y0 = x.copy(), y.copy()
    extents = np.empty((m, 4))
    for k in range(m):
        a, b = first[near[k]], second[near[k]]
        cos = abs(axis[a, 0] * axis[b, 0] + axis[a, 1] * axis[b, 1])
        sin = abs(axis[a, 0] * axis[b, 1] - axis[a, 1] * axis[b, 0])
        extents[k, 0] = half[a, 0] + half[b, 0] * cos + half[b, 1] * sin
        extents[k, 1] = half[a, 1] + half[b, 0] * sin + half[b, 1] * cos
        extents[k, 2] = half[b, 0] + half[a, 0] * cos + half[a, 1] * sin
        extents[k, 3] = half[b, 1] + half[a, 0] * sin + half[a, 1] * cos
    hits, sides, along = 0, np.empty((4, 2)), np.empty(4)
    pair, shift = np.empty(m, dtype=np.int64), np.empty((m, 2))
    for turn in range(passes):
        if turn:
            for row in range(len(x)):
                dx, dy = x[row] - x0[row], y[row] - y0[row]
                if dx * dx + dy * dy > bounds[1]:
                    return FAR
        count = 0
        for k in range(m):
            a, b = first[near[k]], second[near[k]]
            dx = (x[b] + ahead[b] * axis[b, 0]) - (x[a] + ahead[a] * axis[a, 0])
            dy = (y[b] + ahead[b] * axis[b, 1]) - (y[a] + ahead[a] * axis[a, 1])
            sides[0, 0], sides[0, 1] = axis[a, 0], axis[a, 1]
            sides[1, 0], sides[1, 1] = -axis[a, 1], axis[a, 0]
            sides[2, 0], sides[2, 1] = axis[b, 0], axis[b, 1]
            sides[3, 0], sides[3, 1] = -axis[b, 1], axis[b, 0]
            least, deep = 0, np.inf
            for side in range(4):
                along[side] = sides[side, 0] * dx + sides[side, 1] * dy
                overlap = extents[k, side] - abs(along[side])
                if overlap < deep:
                    least, deep = side, overlap
            if not deep > 0.0:
                continue
            sign = -1.0 if along[least] < 0.0 else 1.0
            pair[count] = near[k]
            shift[count, 0] = 0.5 * deep * (sign * sides[least, 0])
            shift[count, 1] = 0.5 * deep * (sign * sides[least, 1])
            if turn == 0:
                found[count, 0], found[count, 1] = a, b
                found[count, 2], found[count, 3] = 0.5 * (x[a] + x[b]), 0.5 * (y[a] + y[b])
                found[count, 4] = deep
            count += 1
        if turn == 0:
            hits = count
        if count == 0:
            break
        for row in range(len(x)):  # np.bincount makes -0.0 to 0.0
            x[row], y[row] = x[row] + 0.0, y[row] + 0.0
        for k in range(count):
            x[first[pair[k]]] -= shift[k, 0]
            y[first[pair[k]]] -= shift[k, 1]
        for k in range(count):
            x[second[pair[k]]] += shift[k, 0]
            y[second[pair[k]]] += shift[k, 1]
    return hits


@functools.lru_cache(maxsize=None)
def compiled_push():
    """Return the compiled ``push_all``; ``ValueError`` without numba."""
    return jit(cache=True)(push_all)
