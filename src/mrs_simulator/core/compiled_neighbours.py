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
    for i in range(n):
        if count + n > len(first):
            first, second = np.append(first, first), np.append(second, second)
        own = count
        for row in range(len(rows)):
            for at in range(begin[row, i], end[row, i]):
                j = order[at]
                if j > i and squared(position, i, j) < bound:
                    first[count], place = i, count
                    while place > own and second[place - 1] > j:  # few, in order
                        second[place] = second[place - 1]
                        place -= 1
                    second[place] = j
                    count += 1
    return first[:count], second[:count]


def squared(position, i, j):
    """Return the squared distance [m^2] of points ``i`` and ``j``."""
    total = 0.0
    for axis in range(position.shape[1]):
        apart = position[j, axis] - position[i, axis]
        total += apart * apart
    return total


@functools.lru_cache(maxsize=None)
def compiled_pairs():
    """Return the compiled ``pairs_in_cells``; ``ValueError`` without numba."""
    return kept(pairs_in_cells)
