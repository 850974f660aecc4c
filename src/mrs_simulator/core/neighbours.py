"""Neighbour search among points (n, d), d = 2 or 3, without comparing all pairs."""

import functools
import itertools

import numpy as np

from mrs_simulator.core.sample_blocks import AT_ONCE, blocks, note_seen

DENSE = 256  # [-] points up to which all pairs are compared
# [-] points of a track, all pairs of which are compared sooner than those that are near are found
FEW = 24
# [-] of the least distance, by which points may move before pairs are selected again
MOST_MOVED = 1.0


def dot(a, b):
    """Return the inner products (...) of vectors a and b (..., d), to the bit however they lie in memory.

    By columns: numpy takes ten times as long to reduce rows of two numbers.
    """
    total = a[..., 0] * b[..., 0]
    for column in range(1, a.shape[-1]):
        total = total + a[..., column] * b[..., column]
    return total


def squared(a):
    """Return the squared lengths (...) of vectors a (..., d)."""
    return dot(a, a)


def lengths(a):
    """Return the lengths (...) of vectors a (..., d).

    To the bit ``np.linalg.norm(a, axis=-1)``, in less time.
    """
    if a.shape[-1] == 2:
        x, y = a[..., 0], a[..., 1]
        return np.sqrt(x * x + y * y)
    return np.sqrt((a * a).sum(axis=-1))


def all_pairs(n):
    """Return the rows of all pairs of n points, (m,) and (m,), i < j; not to be written to."""
    return _kept_pairs(n) if n <= DENSE else np.triu_indices(n, 1)


@functools.lru_cache(maxsize=8)
def _kept_pairs(n):
    pairs = np.triu_indices(n, 1)
    for rows in pairs:
        rows.setflags(write=False)
    return pairs


def close_pairs(position, distance, loop=None):
    """Return the rows of all pairs of points closer than ``distance`` [m], (m,) and (m,), i < j.

    ``loop``: of ``compiled_neighbours``, ``near_pairs`` for up to ``DENSE`` points; None: by numpy.
    """
    if len(position) <= DENSE:
        if loop is not None:
            return loop(np.ascontiguousarray(position), distance * distance)
        first, second = all_pairs(len(position))
    else:
        if loop is not None:
            return _pairs_by_loop(loop, position, distance)
        first, second = _grid_pairs(position, distance)
    near = np.flatnonzero(squared_apart(position, first, second) < distance * distance)
    return first.take(near), second.take(near)


def squared_apart(position, first, second):
    """Return the squared distances (m,) of pairs of points: rows ``first`` and ``second``, (m,)."""
    total = 0.0
    for column in position.T:  # by columns: a row of two numbers is slow to fetch
        apart = column.take(second) - column.take(first)
        total = total + apart * apart
    return total


def least_distances(apart):
    """Return the least distances (k, p) of pairs of points on each of k straight moves at constant speed.

    ``apart`` (k + 1, p, d): from one point of each pair to the other, before and after each move.
    """
    if apart.shape[2] == 2:
        return _least_in_the_plane(apart[..., 0], apart[..., 1])
    begin, move = apart[:-1], apart[1:] - apart[:-1]
    size = np.maximum((move * move).sum(axis=2), 1e-300)
    share = np.minimum(np.maximum(-(begin * move).sum(axis=2) / size, 0.0), 1.0)
    return lengths(begin + share[:, :, np.newaxis] * move)


def _least_in_the_plane(x, y):
    """As :func:`least_distances`, of coordinates (k + 1, p): rows of two numbers are slow to sum."""
    begin_x, begin_y, move_x, move_y = x[:-1], y[:-1], x[1:] - x[:-1], y[1:] - y[:-1]
    size = np.maximum(move_x * move_x + move_y * move_y, 1e-300)
    share = np.minimum(np.maximum(-(begin_x * move_x + begin_y * move_y) / size, 0.0), 1.0)
    x, y = begin_x + share * move_x, begin_y + share * move_y
    return np.sqrt(x * x + y * y)


def _cells(position, size):
    """Return the numbers (n,) of the cells of ``size`` [m] in which points are, what sorts them, (n,), and
    what a number grows by along each axis, a list.

    By columns: rows of two numbers are slow to reduce.
    """
    columns = np.ascontiguousarray(position.T)
    cells = [np.floor((own - own.min()) / size).astype(np.int64) + 1 for own in columns]
    # A cell's number: one more than its column, in rows that leave room for neighbours on both sides.
    strides, key = [1], cells[-1]
    for before, own in zip(cells[:0:-1], cells[-2::-1]):
        strides.insert(0, strides[0] * (int(before.max()) + 2))
        key = key + own * strides[0]
    return key, np.argsort(key, kind="stable"), strides


def _pairs_by_loop(loop, position, distance):
    """As :func:`close_pairs`, by a compiled ``loop``."""
    key, order, strides = _cells(position, distance)
    middles = np.zeros(1, dtype=np.int64)  # of each three that differ in the last axis
    for stride in strides[:-1]:
        middles = np.add.outer(middles, (-stride, 0, stride)).ravel()
    return loop(np.ascontiguousarray(position), key, order, middles, distance * distance)


def _grid_pairs(position, size):
    key, order, strides = _cells(position, size)
    ordered = key[order]
    pairs = []
    for step in _neighbour_cells(position.shape[1]):
        wanted = key + np.dot(step, strides)
        begin = np.searchsorted(ordered, wanted, "left")
        count = np.searchsorted(ordered, wanted, "right") - begin
        first = np.repeat(np.arange(len(position)), count)
        offset = np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
        second = order[np.repeat(begin, count) + offset]
        keep = slice(None) if any(step) else first < second
        pairs.append(np.stack([first[keep], second[keep]]))
    first, second = np.concatenate(pairs, axis=1)
    low, high = np.minimum(first, second), np.maximum(first, second)
    # In ascending order the result does not depend on the way it was found.
    sequence = np.lexsort((high, low))
    return low[sequence], high[sequence]


@functools.lru_cache(maxsize=None)
def _neighbour_cells(dimension):
    """Return the steps to a cell itself and to half of those around it: each pair of cells once."""
    steps = itertools.product((-1, 0, 1), repeat=dimension)
    return [step for step in steps if step >= (0,) * dimension]


def least_distance(position):
    """Return the least distance [m] between two of the points ``position`` (n, d); inf for one."""
    return closest_pair(position)[2] if len(position) > 1 else np.inf


def least_distance_over(track):
    """Return the least distance [m] between two of the points at any time, ``track`` (m, n, d).

    Of ``FEW`` points all pairs are compared.  Of more, as long as none is farther than ``MOST_MOVED`` of
    the least distance so far from where it was, only pairs that were close then are compared.
    """
    if track.shape[1] < 2:
        return np.inf
    least, row, size = least_distance(track[0]), 1, 1
    if track.shape[1] <= FEW:
        pairs = all_pairs(track.shape[1])
        for rows in blocks(len(track), len(pairs[0])):
            least = min(least, _least_of(track[rows], *pairs))
            note_seen(track[rows, :, 0].size)
        return float(least)
    while row < len(track) and least > 0.0:
        part = track[row : row + size]
        moved = _farthest(part, part[0])
        stirred = np.flatnonzero(moved > MOST_MOVED * least)
        part = part[: stirred[0] if len(stirred) else None]
        reach = least + 2.0 * moved[: len(part)].max()
        # Not so little that cells of that size could not be numbered.
        near = close_pairs(part[0], max(reach, 1e-6 * np.ptp(part[0], axis=0).max()))
        least = min(least, _least_of(part, *near))
        note_seen(part[..., 0].size)
        row += len(part)
        size = max(2, min(2 * len(part), AT_ONCE // track.shape[1]))
    return float(least)


def _farthest(track, places):
    """Return how far [m] some point of ``track`` (m, n, d) is from its place, ``places`` (n, d), (m,)."""
    total = 0.0
    for axis in range(track.shape[2]):
        total = total + (track[:, :, axis] - places[:, axis]) ** 2
    return np.sqrt(total.max(axis=1))


def _least_of(track, first, second):
    """Return the least distance [m] between rows ``first`` and ``second`` (k,) of ``track`` (m, n, d)."""
    total = np.full((len(track), len(first)), 0.0)
    for axis in range(track.shape[2]):
        column = track[:, :, axis]
        apart = column.take(second, axis=1) - column.take(first, axis=1)
        total += apart * apart
    return np.sqrt(total.min(initial=np.inf))


def closest_pair(position):
    """Return ``(i, j, distance)``, i < j, of two points (n, d) that are nearest to each other [m]."""
    if len(position) <= DENSE:
        first, second = all_pairs(len(position))
    else:
        first, second = close_pairs(position, _no_nearer(position))
    apart = squared_apart(position, first, second)
    k = int(np.argmin(apart))
    return int(first[k]), int(second[k]), float(np.sqrt(apart[k]))


def _no_nearer(position):
    """Return a little more than the distance of some pair [m], above 0 even where points coincide."""
    least = np.inf
    for column in range(position.shape[1]):
        ordered = position[np.argsort(position[:, column], kind="stable")]
        least = min(least, squared(ordered[1:] - ordered[:-1]).min())
    # Not so little that cells of that size could not be numbered.
    return 1.001 * np.sqrt(least) + (1e-6 * np.ptp(position, axis=0).max() or 1.0)
