"""Pairs of points that are close, by a loop that numba compiles: those of ``neighbours``, in order."""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kept

BEGIN = 8  # [-] pairs of a point for which there is room at first


def pairs_in_cells(position, key, order, rows, bound):
    """Return the rows (m,) and (m,), i < j and ascending, of points of squared distance below ``bound``
    [m^2].

    ``position`` (n, d) [m]; ``key`` (n,): numbers of the cells in which they are, and ``order`` (n,) that
    sorts these; ``rows`` (k,): what is added to a cell's number for the middle ones of three neighbours.
    """
    n, ordered = len(key), key[order]
    begin, end = np.empty((len(rows), n), np.int64), np.empty((len(rows), n), np.int64)
    for row in range(len(rows)):
        low, high = 0, 0
        for at in range(n):  # keys ascend, and so do those of their neighbours
            while low < n and ordered[low] < ordered[at] + rows[row] - 1:
                low += 1
            while high < n and ordered[high] <= ordered[at] + rows[row] + 1:
                high += 1
            begin[row, order[at]], end[row, order[at]] = low, high
    first, second, count = np.empty(BEGIN * n, np.int64), np.empty(BEGIN * n, np.int64), 0
    places = np.empty((position.shape[1], n))
    for axis in range(len(places)):
        for at in range(n):
            places[axis, at] = position[order[at], axis]
    for i in range(n):
        if count + n > len(first):
            first, second = np.append(first, first), np.append(second, second)
        own = count
        for row in range(len(rows)):
            low, high = begin[row, i], end[row, i]
            count = near_ones(places, position[i], order, low, high, i, bound, second, count)
        for at in range(own, count):
            first[at], j, place = i, second[at], at
            while place > own and second[place - 1] > j:  # few, in order
                second[place] = second[place - 1]
                place -= 1
            second[place] = j
    return first[:count], second[:count]


def near_ones(places, own, order, low, high, i, bound, found, count):
    """Put into ``found``, from ``count`` on, the rows beyond ``i`` of points of squared distance below
    ``bound`` [m^2] of ``own`` (d,); return how many are found then.

    ``places`` (d, n) [m]: of the points in ``order`` (n,), of which those from ``low`` up to ``high`` are
    looked at.
    """
    x, y = places[0], places[1]
    for at in range(low, high):
        east, north = x[at] - own[0], y[at] - own[1]
        total = east * east + north * north
        for axis in range(2, len(places)):
            apart = places[axis, at] - own[axis]
            total += apart * apart
        found[count] = order[at]  # without a branch, which would be guessed wrong
        count += (total < bound) & (order[at] > i)
    return count


def near_pairs(seen, bound):
    """Return the rows of pairs whose squared distance is below ``bound`` [m^2], (m,) and (m,)."""
    n, d = seen.shape
    first = np.empty(n * (n - 1) // 2 + 8, dtype=np.int64)
    second, m, all_are, columns = np.empty_like(first), 0, bound == np.inf, np.zeros((3, n))
    columns[:d] = seen.T
    x, y, z = columns[0], columns[1], columns[2]
    close = np.zeros((n + 7) // 8 * 8, dtype=np.uint8)
    eights = close.view(np.uint64)  # few of them have one that is near
    for i in range(n):
        own, other, high = x[i], y[i], z[i]
        for j in range(n):
            east, north, up = x[j] - own, y[j] - other, z[j] - high
            close[j] = (east * east + north * north + up * up < bound) | all_are
        close[: i + 1] = 0
        for k in range((i + 1) // 8, len(eights)):
            if eights[k]:
                for j in range(8 * k, 8 * k + 8):
                    first[m], second[m] = i, j  # without a branch, which would be guessed wrong
                    m += close[j]
    return first[:m], second[:m]


@functools.lru_cache(maxsize=None)
def compiled_near():
    """Return the compiled ``near_pairs``; ``ValueError`` without numba."""
    return kept(near_pairs)


@functools.lru_cache(maxsize=None)
def compiled_pairs():
    """Return the compiled ``pairs_in_cells``; ``ValueError`` without numba."""
    return kept(pairs_in_cells)
