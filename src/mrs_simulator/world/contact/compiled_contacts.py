"""Robots on the ground pushed apart, and their contacts noted, by loops that numba compiles.

With results equal to the bit: they do numpy's operations of ``collisions``, ``bodies`` and ``contacts`` in
numpy's order, pair by pair.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kept as kept_kernel

STALE = -1  # returned where robots went so far that pairs are to be listed anew
APART = -2  # returned where no two bodies can have come together since they were looked at
UNSORTED = -1  # returned where pairs do not ascend


def push_all(pose, cos, sin, outlines, listed, kept, bounds, passes, rows, found):
    """Push overlapping rectangles at ``pose`` (3, n) apart, in place, as ``Bodies.separate`` does.

    ``cos``, ``sin`` (n,): of their headings; ``outlines``: ``ahead`` (n,) and ``half`` (n, 2) [m] as
    ``Footprints`` has them; ``listed``: rows of the pairs listed (m,), (m,), and where robots were then
    (2, n); ``kept``: those of them that are looked at, rows (2, m + 1), where robots were when they were
    selected (2, n), and how many they are, (1,), -1 before; ``bounds``: squares [m^2] of the way for which
    the list is whole, of the distance below which a pair is looked at, of the way for which that is
    enough, of the distance below which bodies can touch, of the way for which those that are close
    within a step are enough, and of the distance below which they are.  Filled: ``rows`` (2, m), and
    middle and depth, ``found`` (3, m), of the pairs that overlap at first.

    Returns how many these are, the square of the least distance of pairs listed, and that of the farthest
    way from where they were listed, both afterwards; ``STALE`` with nothing changed.
    """
    (first, second, origin), (near, places, known) = listed, kept
    x, y, hits, moved = pose[0].copy(), pose[1].copy(), 0, np.ones(pose.shape[1], dtype=np.bool_)
    if farthest(x, y, origin[0], origin[1]) > bounds[0]:
        return STALE, 0.0, 0.0
    if known[0] < 0 or farthest(x, y, places[0], places[1]) > bounds[2]:
        select(x, y, listed, kept, bounds[1])
    a, b, x0, y0 = close_ones(x, y, kept, bounds[5])
    hit, shift, deep = spare_of(len(a))
    for turn in range(passes):
        lost = turn > 0 and farthest(x, y, places[0], places[1]) > bounds[2]
        if lost:
            if farthest(x, y, origin[0], origin[1]) > bounds[0]:
                return STALE, 0.0, 0.0
            select(x, y, listed, kept, bounds[1])
        if lost or turn > 0 and farthest(x, y, x0, y0) > bounds[4]:
            a, b, x0, y0 = close_ones(x, y, kept, bounds[5])
            hit, shift, deep = spare_of(len(a))
        count = overlaps(x, y, cos, sin, *outlines, a, b, moved, hit, shift, deep)
        if count == 0:
            break
        if turn == 0:
            hits = count
            for k in range(hits):
                i, j = a[hit[k]], b[hit[k]]
                rows[0, k], rows[1, k] = i, j
                found[0, k], found[1, k] = 0.5 * (x[i] + x[j]), 0.5 * (y[i] + y[j])
                found[2, k] = deep[k]
        part(x, y, a, b, hit[:count], shift, moved)
    if hits:
        pose[0], pose[1] = x, y
    m = known[0]
    nearest = least(x, y, near[0, :m], near[1, :m])
    # That of another pair may be less.
    if nearest >= bounds[3] or farthest(x, y, places[0], places[1]) > bounds[2]:
        nearest = least(x, y, first, second)
    return hits, nearest, farthest(x, y, origin[0], origin[1])


def spare_of(m):
    """Return what ``overlaps`` fills of m pairs."""
    return np.empty(m + 1, np.int64), np.empty((2, m)), np.empty(m)


def select(x, y, listed, kept, bound):
    """Fill in ``kept`` of ``push_all``: which of the pairs ``listed`` are looked at, and from where."""
    (first, second, _), (near, places, known) = listed, kept
    places[0], places[1] = x, y
    known[0] = looked_at(x, y, first, second, bound, near[0], near[1])


def close_ones(x, y, kept, bound):
    """Return those of the pairs ``kept`` that are closer than the square root of ``bound`` [m^2], and x and
    y now."""
    near, m = kept[0], kept[2][0]
    a, b = np.empty(m + 1, np.int64), np.empty(m + 1, np.int64)
    count = looked_at(x, y, near[0, :m], near[1, :m], bound, a, b)
    return a[:count], b[:count], x.copy(), y.copy()


def least(x, y, first, second):
    """Return the square of the least distance [m^2] of the pairs, inf of none."""
    nearest = np.inf
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        nearest = min(nearest, dx * dx + dy * dy)
    return nearest


def looked_at(x, y, first, second, bound, a, b):
    """Return how many pairs are closer than the square root of ``bound`` [m^2]; ``a``, ``b``: filled with
    these."""
    m = 0
    for k in range(len(first)):
        dx, dy = x[second[k]] - x[first[k]], y[second[k]] - y[first[k]]
        a[m], b[m] = first[k], second[k]
        m += dx * dx + dy * dy < bound
    return m


def overlaps(x, y, cos, sin, ahead, half, a, b, moved, hit, shift, deep):
    """Return how many of the pairs ``a``, ``b`` (k,) overlap, and fill in which, ``hit`` (k,), their shifts
    (2, k) and how ``deep`` (k,) [m].

    Only pairs of which one has ``moved`` (n,) since they were last looked at.  By separating axes, as
    ``collisions.rectangle_overlap``.
    """
    count = near = 0
    for k in range(len(a)):
        hit[near] = k
        near += moved[a[k]] | moved[b[k]]
    for k in hit[:near]:
        i, j = a[k], b[k]
        (u, v), (p, q) = (cos[i], sin[i]), (cos[j], sin[j])
        turn, across = abs(u * p + v * q), abs(u * q - v * p)
        dx = (x[j] + ahead[j] * p) - (x[i] + ahead[i] * u)
        dy = (y[j] + ahead[j] * q) - (y[i] + ahead[i] * v)
        ways = u * dx + v * dy, -v * dx + u * dy, p * dx + q * dy, -q * dx + p * dy
        own = half[i, 0] + half[j, 0] * turn + half[j, 1] * across - abs(ways[0])
        left = half[i, 1] + half[j, 0] * across + half[j, 1] * turn - abs(ways[1])
        other = half[j, 0] + half[i, 0] * turn + half[i, 1] * across - abs(ways[2])
        beside = half[j, 1] + half[i, 0] * across + half[i, 1] * turn - abs(ways[3])
        least_deep = min(min(own, left), min(other, beside))
        if not least_deep > 0.0:
            continue
        if own == least_deep:  # the first of those at which it is least
            along = ways[0]
        elif left == least_deep:
            along, u, v = ways[1], -v, u
        elif other == least_deep:
            along, u, v = ways[2], p, q
        else:
            along, u, v = ways[3], -q, p
        sign = -1.0 if along < 0.0 else 1.0
        hit[count], deep[count] = k, least_deep
        shift[0, count] = 0.5 * least_deep * (sign * u)
        shift[1, count] = 0.5 * least_deep * (sign * v)
        count += 1
    return count


def farthest(x, y, x0, y0):
    """Return the square of the farthest way [m^2] from ``x0``, ``y0``."""
    most = 0.0
    for row in range(len(x)):
        dx, dy = x[row] - x0[row], y[row] - y0[row]
        most = max(most, dx * dx + dy * dy)
    return most


def part(x, y, a, b, hit, shift, moved):
    """Move the robots ``a`` and ``b`` of the pairs ``hit`` (m,) by ``shift`` (2, m) [m], the first ones
    back, in place; fill in which have ``moved`` (n,)."""
    for row in range(len(x)):  # np.bincount makes -0.0 to 0.0
        x[row], y[row], moved[row] = x[row] + 0.0, y[row] + 0.0, False
    for k in range(len(hit)):
        x[a[hit[k]]] -= shift[0, k]
        y[a[hit[k]]] -= shift[1, k]
        moved[a[hit[k]]] = moved[b[hit[k]]] = True
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
    return kept_kernel(push_all)


@functools.lru_cache(maxsize=None)
def compiled_note():
    """Return the compiled ``note_all``; ``ValueError`` without numba."""
    return kept_kernel(note_all)
