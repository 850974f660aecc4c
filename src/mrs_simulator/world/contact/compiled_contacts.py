"""Robots on the ground pushed apart, and their contacts noted, by loops that numba compiles.

With results equal to the bit: they do numpy's operations of ``collisions``, ``bodies`` and ``contacts`` in
numpy's order, pair by pair.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit

STALE = -1  # returned where robots went so far that pairs are to be listed anew
UNSORTED = -1  # returned where pairs do not ascend


def push_all(pose, cos, sin, ahead, half, listed, bounds, passes, rows, found):
    """Push overlapping rectangles at ``pose`` (3, n) apart, in place, as ``Bodies.separate`` does.

    ``cos``, ``sin`` (n,): of their headings; ``ahead`` (n,) and ``half`` (n, 2) [m] as ``Footprints`` has
    them; ``listed``: rows of the pairs listed (m,), (m,), and where robots were then (2, n); ``bounds``:
    squares [m^2] of the way for which the list is whole, of the distance below which a pair is looked at,
    of the way for which that is enough, and of the distance below which bodies can touch.  Filled:
    ``rows`` (2, m), and middle and depth, ``found`` (3, m), of the pairs that overlap at first.

    Returns how many these are, the square of the least distance of pairs listed, and that of the farthest
    way from where they were listed, both afterwards; ``STALE`` with nothing changed.
    """
    first, second, origin = listed
    x, y = pose[0].copy(), pose[1].copy()
    if farthest(x, y, origin[0], origin[1]) > bounds[0]:
        return STALE, 0.0, 0.0
    a, b, terms = looked_at(x, y, cos, sin, half, first, second, bounds[1])
    x0, y0, hits = x.copy(), y.copy(), 0
    for turn in range(passes):
        if turn and farthest(x, y, x0, y0) > bounds[2]:
            if farthest(x, y, origin[0], origin[1]) > bounds[0]:
                return STALE, 0.0, 0.0
            a, b, terms = looked_at(x, y, cos, sin, half, first, second, bounds[1])
            x0, y0 = x.copy(), y.copy()
        hit, shift, deep = overlaps(x, y, cos, sin, ahead, a, b, terms)
        if len(hit) == 0:
            break
        if turn == 0:
            hits = len(hit)
            for k in range(hits):
                i, j = a[hit[k]], b[hit[k]]
                rows[0, k], rows[1, k] = i, j
                found[0, k], found[1, k] = 0.5 * (x[i] + x[j]), 0.5 * (y[i] + y[j])
                found[2, k] = deep[hit[k]]
        part(x, y, a, b, hit, shift)
    if hits:
        pose[0], pose[1] = x, y
    nearest = least(x, y, a, b)
    if nearest >= bounds[3]:  # that of another pair may be less
        nearest = least(x, y, first, second)
    return hits, nearest, farthest(x, y, origin[0], origin[1])


def least(x, y, first, second):
    """Return the square of the least distance [m^2] of the pairs, inf of none."""
    nearest = np.inf
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        nearest = min(nearest, dx * dx + dy * dy)
    return nearest


def looked_at(x, y, cos, sin, half, first, second, bound):
    """Return which pairs are closer than the square root of ``bound`` [m^2], rows (k,) and (k,).

    And, (8, k), what of them stays while they keep their headings: cosine and sine of both, and half of
    both bodies' extents [m] along their four axes.
    """
    near, m = np.empty(len(first) + 1, dtype=np.int64), 0
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        near[m] = k
        m += dx * dx + dy * dy < bound
    near = near[:m]
    a, b, terms = first[near], second[near], np.empty((8, m))
    for k in range(m):
        i, j = a[k], b[k]
        turn = abs(cos[i] * cos[j] + sin[i] * sin[j])
        across = abs(cos[i] * sin[j] - sin[i] * cos[j])
        terms[0, k], terms[1, k], terms[2, k], terms[3, k] = cos[i], sin[i], cos[j], sin[j]
        terms[4, k] = half[i, 0] + half[j, 0] * turn + half[j, 1] * across
        terms[5, k] = half[i, 1] + half[j, 0] * across + half[j, 1] * turn
        terms[6, k] = half[j, 0] + half[i, 0] * turn + half[i, 1] * across
        terms[7, k] = half[j, 1] + half[i, 0] * across + half[i, 1] * turn
    return a, b, terms


def overlaps(x, y, cos, sin, ahead, a, b, terms):
    """Return which of the pairs ``a``, ``b`` (k,) overlap, (m,), their shifts (2, m) and depths (k,) [m].

    By separating axes, as ``collisions.rectangle_overlap``; ``terms`` (8, k) as of ``looked_at``.
    """
    m, middle_x, middle_y = len(a), np.empty(len(x)), np.empty(len(x))
    dx, dy, deep, hit, count = np.empty(m), np.empty(m), np.empty(m), np.empty(m + 1, np.int64), 0
    for row in range(len(x)):
        middle_x[row], middle_y[row] = (
            x[row] + ahead[row] * cos[row],
            y[row] + ahead[row] * sin[row],
        )
    for k in range(m):
        dx[k], dy[k] = middle_x[b[k]] - middle_x[a[k]], middle_y[b[k]] - middle_y[a[k]]
    for k in range(m):
        own = terms[4, k] - abs(terms[0, k] * dx[k] + terms[1, k] * dy[k])
        left = terms[5, k] - abs(-terms[1, k] * dx[k] + terms[0, k] * dy[k])
        other = terms[6, k] - abs(terms[2, k] * dx[k] + terms[3, k] * dy[k])
        beside = terms[7, k] - abs(-terms[3, k] * dx[k] + terms[2, k] * dy[k])
        deep[k] = min(min(own, left), min(other, beside))
    for k in range(m):
        hit[count] = k
        count += deep[k] > 0.0
    hit, shift = hit[:count], np.empty((2, count))
    for k in range(count):
        pair = hit[k]
        for side in range(4):  # the first of those at which it is least
            u, v = terms[side - side % 2, pair], terms[side - side % 2 + 1, pair]
            if side % 2:
                u, v = -v, u
            along = u * dx[pair] + v * dy[pair]
            if terms[4 + side, pair] - abs(along) == deep[pair]:
                break
        sign = -1.0 if along < 0.0 else 1.0
        shift[0, k] = 0.5 * deep[pair] * (sign * u)
        shift[1, k] = 0.5 * deep[pair] * (sign * v)
    return hit, shift, deep


def farthest(x, y, x0, y0):
    """Return the square of the farthest way [m^2] from ``x0``, ``y0``."""
    most = 0.0
    for row in range(len(x)):
        dx, dy = x[row] - x0[row], y[row] - y0[row]
        most = max(most, dx * dx + dy * dy)
    return most


def part(x, y, a, b, hit, shift):
    """Move the robots ``a`` and ``b`` of the pairs ``hit`` (m,) by ``shift`` (2, m) [m], the first ones
    back, in place."""
    for row in range(len(x)):  # np.bincount makes -0.0 to 0.0
        x[row], y[row] = x[row] + 0.0, y[row] + 0.0
    for k in range(len(hit)):
        x[a[hit[k]]] -= shift[0, k]
        y[a[hit[k]]] -= shift[1, k]
    for k in range(len(hit)):
        x[b[hit[k]]] += shift[0, k]
        y[b[hit[k]]] += shift[1, k]


def note_all(rows, most, pairs, steps, now, size, forget, fresh, to_pairs, to_steps):
    """Note pairs ``rows``, (k,) and (k,), that touch at step ``now``, as ``Contacts`` does; return how many
    pairs are known then, or ``UNSORTED`` where nothing is done.

    ``pairs`` and ``steps`` (m,): those known, ascending, ``first * most + second``, and the steps of their
    last contacts; the last one is none.  After more than ``forget`` [s] of steps of ``size`` [s] they are
    forgotten.  Filled: ``fresh`` (k,) bool, which collide anew; ``to_pairs`` and ``to_steps`` (m + k,).
    """
    first, second = rows
    for k in range(1, len(first)):
        if first[k] * most + second[k] <= first[k - 1] * most + second[k - 1]:
            return UNSORTED
    count, old = 0, 0
    for k in range(len(first)):
        pair = first[k] * most + second[k]
        while pairs[old] < pair:
            if not (now - steps[old]) * size > forget:
                to_pairs[count], to_steps[count] = pairs[old], steps[old]
                count += 1
            old += 1
        fresh[k] = True
        if pairs[old] == pair:
            fresh[k] = (now - steps[old]) * size > forget
            old += 1
        to_pairs[count], to_steps[count] = pair, now
        count += 1
    while old < len(pairs):
        if old == len(pairs) - 1 or not (now - steps[old]) * size > forget:
            to_pairs[count], to_steps[count] = pairs[old], steps[old]
            count += 1
        old += 1
    return count


@functools.lru_cache(maxsize=None)
def compiled_push():
    """Return the compiled ``push_all``; ``ValueError`` without numba."""
    return linked(push_all, jit(cache=True))


@functools.lru_cache(maxsize=None)
def compiled_note():
    """Return the compiled ``note_all``; ``ValueError`` without numba."""
    return linked(note_all, jit(cache=True))
