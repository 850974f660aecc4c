"""The safety filter's constraints and their solution by loops that numba compiles, equal to the bit.

They do numpy's operations of ``nearest_velocities`` in numpy's order, row by row, with its names.

``rows`` (first, second, side, alone) are those of ``Rows`` in columns: ``side`` (d, m) times the velocity
of ``second`` (m,), but for the ``alone`` last ones, less that of ``first`` (m,).  Velocities of the solver
are columns, too, (d, n).  Few loops have a branch, so that they use the processor's vectors.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_neighbours import near_pairs
from mrs_simulator.core.compiled_terms import kept
from mrs_simulator.core.compiling import inlined

NEVER = 1e300  # [m/s] that no row reaches: with infinity its product with 0 would be no number


class Loops(NamedTuple):
    """The loops that ``nearest_velocities`` calls, compiled or not."""

    near_pairs: Any
    pair_rows: Any
    heeded: Any
    solve: Any
    feasible_share: Any
    meet: Any


def pair_rows(seen, points, squash, first, second, distance, terms, slowness, late):
    """Return ``side`` (d, m) and ``limit`` (m,) of pairs, as ``_pair_rows``.

    ``squash`` (d,), or (0,) for none; ``distance`` (n, n), or (1, 1) for one of all; ``terms``: ``period``
    and ``gamma``; ``slowness`` and ``late`` (n,), or (0,), of ``Brakes``.
    """
    m, d, braking = len(first), seen.shape[1], len(slowness) > 0
    side, apart, length, needed = np.empty((d, m)), np.zeros(m), np.zeros(m), np.empty(m)
    waits, slow = np.empty(m), np.empty(m)
    for k in range(m):
        i, j = first[k], second[k]
        needed[k] = distance[i, j] if len(distance) > 1 else distance[0, 0]
        if braking:
            waits[k] = 0.5 * (late[i] + late[j])
            slow[k] = 0.5 * (slowness[i] + slowness[j])
    for axis in range(d):
        own = side[axis]
        for k in range(m):
            i, j = first[k], second[k]
            way = seen[i, axis] - seen[j, axis]
            apart[k] += way * way
            if len(squash):
                way = (points[i, axis] - points[j, axis]) * (squash[axis] * squash[axis])
            length[k] += way * way
            own[k] = way
    size, limit = limits_of(apart, length, needed, terms, braking, waits, slow)
    for axis in range(d):
        own = side[axis]
        for k in range(m):
            own[k] = 2.0 * own[k] / size[k]
    return side, limit


def limits_of(apart, length, needed, terms, braking, waits, slow):
    """Return the lengths (m,) by which rows of pairs are divided, and their limits, as ``_pair_rows``.

    ``apart`` and ``length`` (m,): squares of what is seen of distances, and of rows; no loop has a branch,
    so that they use the processor's vectors.
    """
    (period, gamma), m = terms, len(apart)
    size, most, limit = np.empty(m), np.empty(m), np.empty(m)
    for k in range(m):
        root, square = np.sqrt(length[k]), needed[k] * needed[k]
        far = root if root > 1e-9 else 1e-9
        size[k] = 2.0 * np.sqrt(2.0) * far
        margin = apart[k] - square
        limit[k] = margin / period
        most[k] = gamma * (margin * margin * margin)
        if braking:
            whole = margin + square
            gap = np.sqrt(whole if whole > 0.0 else 0.0) - needed[k]
            gap = gap if gap > 0.0 else 0.0
            closing = 2.0 * gap / (waits[k] + np.sqrt(waits[k] * waits[k] + slow[k] * gap))
            closing, held = 2.0 * far * closing, most[k] / (square * square)
            most[k] = closing if closing < held else held
    for k in range(m):
        limit[k] = (most[k] if most[k] < limit[k] else limit[k]) / size[k]
    return size, limit


@inlined
def square(a, k):
    """Return the squared length of row ``k`` of ``a`` (m, d)."""
    total = 0.0
    for axis in range(a.shape[1]):
        total += a[k, axis] * a[k, axis]
    return total


def product(a, b, i, j):
    """Return the inner product of rows ``i`` of ``a`` and ``j`` of ``b``."""
    total = 0.0
    for axis in range(a.shape[1]):
        total += a[i, axis] * b[j, axis]
    return total


def heeded(wanted, seen, distance, first, second, limit, heeds, bounds, turned):
    """Return which constraints may matter, (m,) bool, and ``_beside``'s shares (n,) [-].

    Rows of ``bounds`` come last; ``bounds``: ``way_out``, ``gap`` and ``turns`` of k;
    ``heeds``: kept distances within which robots turn aside; ``turned``: the least share before bounds.
    """
    (way_out, gap, turns), n = bounds, len(wanted)
    size, share = np.empty(n), np.zeros(n)
    for i in range(n):
        size[i] = np.sqrt(square(wanted, i))
    m, pairs = len(limit), len(limit) - len(gap)
    near, met, count = np.empty(m, dtype=np.bool_), np.empty(pairs, dtype=np.int64), 0
    for k in range(pairs):
        near[k] = np.sqrt(2.0) * (size[first[k]] + size[second[k]]) >= limit[k]
    for own in range(len(gap)):
        k, i = pairs + own, first[pairs + own]
        near[k] = size[i] >= limit[k]
        if near[k] and product(way_out, wanted, own, i) < 0.0 and gap[own] < turns[own]:
            share[i] = np.maximum(share[i], turned)
    squares = np.zeros(pairs)
    for axis in range(seen.shape[1]):
        for k in range(pairs):
            apart = seen[first[k], axis] - seen[second[k], axis]
            squares[k] += apart * apart
    for k in range(pairs):
        needed = distance[first[k], second[k]] if len(distance) > 1 else distance[0, 0]
        needed *= heeds
        met[count] = k
        count += near[k] & (squares[k] <= 1.001 * needed * needed)  # few are near enough for a root
    turn_aside(wanted, seen, distance, first, second, heeds, squares, met[:count], size, share)
    return near, share


def turn_aside(wanted, seen, distance, first, second, heeds, squares, met, size, share):
    """Raise the ``share`` (n,) [-] by which robots turn aside for those of the pairs ``met`` (k,).

    ``squares`` (m,) [m^2]: of distances of all pairs; ``size`` (n,) [m/s]: of wanted velocities.
    """
    for a in range(len(met)):
        i, j = first[met[a]], second[met[a]]
        x, y = seen[i, 0] - seen[j, 0], seen[i, 1] - seen[j, 1]
        towards = -x * wanted[i, 0] + -y * wanted[i, 1]
        back = x * wanted[j, 0] + y * wanted[j, 1]
        for axis in range(2, seen.shape[1]):  # in space
            z = seen[i, axis] - seen[j, axis]
            towards, back = towards + -z * wanted[i, axis], back + z * wanted[j, axis]
        needed = distance[i, j] if len(distance) > 1 else distance[0, 0]
        far = np.sqrt(squares[met[a]])
        far = far if far > 1e-9 else 1e-9
        close = (heeds - far / needed) / (heeds - 1.0)
        close = close if close > 0.0 else 0.0
        close = (close if close < 1.0 else 1.0) / far
        own = size[i] if size[i] > 1e-300 else 1e-300
        other = size[j] if size[j] > 1e-300 else 1e-300
        towards, back = close * (towards / own), close * (back / other)
        share[i] = towards if towards > share[i] else share[i]
        share[j] = back if back > share[j] else share[j]


def solve(wanted, first, second, side, limit, alone, near, speed, accuracy):
    """Return the velocities (n, d) nearest to ``wanted``, and what they make of all rows, (m,).

    As ``_among`` from where wanted velocities are turned aside.  ``near`` (m,) grows by rows that robots
    are pushed towards; ``speed`` (n,), or (0,) for no caps; ``accuracy``: ``LEAST``, ``TOLERANCE``; then
    ``RESIDUAL``, ``ASTRAY`` and ``ELIMINATED``; ``STEPS``; and ``FIRST`` and ``SWEEPS``.
    """
    rows = first.astype(np.uint64), second.astype(np.uint64), side, alone
    begun, velocity, pressure = wanted.T.copy(), wanted, np.empty(len(limit))
    press(begun, rows, pressure)
    begins = 0
    for k in range(len(limit)):
        begins += near[k] & (pressure[k] > limit[k] + accuracy[0])
    for i in range(len(speed)):
        begins += np.sqrt(square(wanted, i)) > speed[i]
    while True:
        pushed = 0
        for k in range(len(limit)):
            beyond = (begins == 0) & (not near[k]) & (pressure[k] > limit[k])
            pushed += beyond
            near[k] |= beyond
        if begins + pushed == 0:
            return velocity, pressure
        begins = 0
        found = nearest(begun, rows, limit, near, speed, accuracy)
        press(found, rows, pressure)
        velocity = found.T.copy()


def press(velocity, rows, pressure):
    """Fill ``pressure`` (m,) as ``Rows.pressure`` returns it of ``velocity`` (d, n)."""
    first, second, side, alone = rows
    pairs = len(pressure) - alone
    for axis in range(len(velocity)):
        own, values = side[axis], velocity[axis]
        for k in range(len(pressure)):
            before = pressure[k] if axis else 0.0
            other = values[second[k]] if k < pairs else 0.0
            pressure[k] = before + own[k] * (other - values[first[k]])


def nearest(begun, rows, limit, near, speed, accuracy):
    """Return the velocities (d, n) nearest to ``begun`` under rows that are ``near``, as ``_nearest``."""
    m, most, largest = len(limit), np.empty(len(limit)), 0.0
    for k in range(m):
        most[k] = limit[k] if near[k] else NEVER
        size = np.abs(limit[k]) if near[k] else 0.0
        largest = size if size > largest else largest
    _, tolerance, exactness, steps, sweeps = accuracy
    scale = max(1e-3, largest, np.abs(begun).max())
    limits, force, free = (tolerance * scale, *exactness), np.zeros(m), np.empty(begun.shape)
    uncapped, found = speed[:0], False
    for caps in (uncapped, speed):
        found = by_newton(begun, rows, most, caps, force, free, steps, limits)
        if not found or not len(speed) or not is_capped(free, speed):
            break
    if not found:
        gain = gains(rows, near, begun.shape[1])
        by_both(begun, rows, most, speed, gain, force, free, (steps, *sweeps), limits)
    push(begun, rows, force, acting(force), free)
    return within_caps(free, speed) if len(speed) else free


@inlined
def acting(force):
    """Return where ``force`` (m,) is not 0, which are few."""
    found, count = np.empty(len(force), dtype=np.int64), 0
    for k in range(len(force)):
        found[count] = k
        count += force[k] != 0.0
    return found[:count]


def push(begun, rows, force, acts, free):
    """Fill ``free`` (d, n) with what ``_Dual.free`` returns of ``force`` (m,), 0 but where it ``acts``."""
    (first, second, side, alone), free[:] = rows, 0.0
    pairs = len(force) - alone
    for axis in range(len(free)):
        own, values = side[axis], free[axis]
        for k in acts:
            values[first[k]] += -own[k] * force[k]
        for k in acts:
            if k < pairs:
                values[second[k]] += own[k] * force[k]
        for i in range(len(values)):
            values[i] = begun[axis, i] - values[i]


@inlined
def velocitys_length(free, i):
    """Return the length of the velocity of robot ``i`` in ``free`` (d, n)."""
    total = 0.0
    for axis in range(len(free)):
        total += free[axis, i] * free[axis, i]
    return np.sqrt(total)


def is_capped(free, speed):
    """Return whether caps change any of the velocities ``free`` (d, n)."""
    found = False
    for i in range(len(speed)):
        found |= velocitys_length(free, i) > speed[i]
    return found


def within_caps(free, speed):
    """Return velocities ``free`` (d, n) within the caps ``speed`` (n,)."""
    capped = np.empty(free.shape)
    for i in range(len(speed)):
        factor = np.minimum(1.0, speed[i] / np.maximum(velocitys_length(free, i), 1e-300))
        for axis in range(len(free)):
            capped[axis, i] = free[axis, i] * factor
    return capped


def exceed(free, rows, most, speed, excess):
    """Fill ``excess`` (m,) with what ``_Dual.excess`` returns of velocities ``free`` (d, n)."""
    press_all(rows, within_caps(free, speed) if len(speed) else free, excess)
    for k in range(len(excess)):
        excess[k] -= most[k]


def press_all(rows, values, pressed):
    """Fill ``pressed`` (m,) with what rows make of ``values`` (d, n), as sums over robots one by one."""
    first, second, side, alone = rows
    pairs = len(pressed) - alone
    ahead, across, x, y = side[0], side[1], values[0], values[1]
    for k in range(len(pressed)):
        pressed[k] = -ahead[k] * x[first[k]] - across[k] * y[first[k]]
    for axis in range(2, len(values)):  # in space
        own, value = side[axis], values[axis]
        for k in range(len(pressed)):
            pressed[k] -= own[k] * value[first[k]]
    for k in range(pairs):
        pressed[k] = pressed[k] + ahead[k] * x[second[k]] + across[k] * y[second[k]]
    for axis in range(2, len(values)):
        own, value = side[axis], values[axis]
        for k in range(pairs):
            pressed[k] += own[k] * value[second[k]]


def by_newton(begun, rows, most, speed, force, free, steps, limits):
    """Let ``force`` (m,) be that of ``_by_newton``, from what it is, and ``free`` (d, n) what it leaves;
    return whether it was found."""
    m, excess = len(force), np.empty(len(force))
    active = np.empty(m, dtype=np.int64)
    push(begun, rows, force, acting(force), free)
    exceed(free, rows, most, speed, excess)
    for _ in range(steps):
        changed, dropped, count = 0, 0, 0
        for k in range(m):
            ahead = force[k] + excess[k]
            ahead = 0.0 if ahead <= 0.0 else ahead
            changed += not np.abs(ahead - force[k]) < limits[0]
            dropped += (ahead == 0.0) & (force[k] != 0.0)
        if not changed:
            return True
        for k in range(m):
            active[count] = k
            count += not force[k] + excess[k] <= 0.0
        acts = active[:count]
        if dropped:
            for k in range(m):
                force[k] = force[k] if force[k] + excess[k] > 0.0 else 0.0
            push(begun, rows, force, acts, free)
            exceed(free, rows, most, speed, excess)
        if count == 0:
            continue
        change, consistent = solved(rows, acts, free, speed, excess[acts], limits)
        if not consistent:
            return False
        for a in range(count):
            force[acts[a]] += change[a]
        push(begun, rows, force, acts, free)
        exceed(free, rows, most, speed, excess)
    return False


@inlined
def summed(a, b):
    """Return the sum of the products of ``a`` and ``b`` (k,), one after the other."""
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total += a[k] * b[k]
    return total


def solved(rows, active, free, speed, right, limits):
    """Return what ``_solved`` returns of the rows ``active`` (k,), and whether that is not None."""
    (first, second, side, alone), k = rows, len(active)
    own = np.empty((len(side), k))
    for axis in range(len(side)):
        for a in range(k):
            own[axis, a] = side[axis, active[a]]
    of_one = np.count_nonzero(active >= len(first) - alone)
    if not len(speed):
        robots = first[active].astype(np.int64), second[active].astype(np.int64)
        x = np.empty(k)
        if eliminated(robots, own, of_one, right, free.shape[1], limits[3], x):
            return x, True
    own_rows = first[active], second[active], own, of_one
    factor, ahead = slopes_of_caps(free, speed)
    x, left, along = np.zeros(k), right.copy(), right.copy()
    moved, pushes = np.empty(k), np.empty(free.shape)
    size = summed(left, left)
    least, most = limits[1] * limits[1] * size, limits[2] * limits[2] * size
    for _ in range(2 * k):
        fall(own_rows, along, factor, ahead, pushes, moved)
        curved = summed(along, moved)
        if size <= least or curved <= 0.0:
            break
        step = size / curved
        for a in range(k):
            x[a] = x[a] + step * along[a]
            left[a] = left[a] - step * moved[a]
        before, size = size, summed(left, left)
        if size > most:
            return x, False
        again = size / before
        for a in range(k):
            along[a] = left[a] + again * along[a]
    return x, True


def eliminated(robots, own, alone, right, n, limits, x):
    """Fill ``x`` (k,) as ``_Dual.eliminated`` returns it; return whether that is not None.

    ``robots``: the ``first`` and ``second`` (k,) of n; ``own`` (d, k): sides; ``limits``: ``ELIMINATED``.
    """
    (first, second), (pivot, most) = robots, limits
    k, pairs, rest = len(first), len(first) - alone, 0
    counts, joined = np.zeros(n, np.int64), np.empty(k, np.int64)
    for a in range(k):
        counts[first[a]] += 1
        counts[second[a]] += 1 if a < pairs else 0
    for a in range(k):
        joined[rest] = a
        rest += (counts[first[a]] > 1) | (counts[second[a]] > 1)
        size = along(own, a, a)
        x[a] = right[a] / (size + size if a < pairs else size)
    joined = joined[:rest]
    order, ends = in_sets(first[joined], second[joined], n)
    largest, begin = 0, 0
    for c in range(len(ends)):
        largest, begin = max(largest, ends[c] - begin), ends[c]
    if largest > most:
        return False
    work = (
        np.empty((2, largest, largest)),
        np.empty((3 + len(own), largest)),
        np.empty((2, largest), np.int64),
    )
    begin, joined = 0, joined[order]
    for c in range(len(ends)):
        if not eliminate(joined[begin : ends[c]], robots, own, pairs, right, pivot, work, x):
            return False
        begin = ends[c]
    return True


def in_sets(first, second, n):
    """Return the order (k,) of rows by sets that share robots, and where each set ends in it, (c,)."""
    k, count, begin = len(first), 0, 0
    work = np.empty((2, n), np.int64), np.empty((3, k), np.int64)
    (least, number), (of, ends, order) = work
    for i in range(n):
        least[i], number[i] = i, -1
    for a in range(k):
        i, j = origin(least, first[a]), origin(least, second[a])
        least[max(i, j)] = min(i, j)
    for a in range(k):
        i = origin(least, first[a])
        if number[i] < 0:
            number[i], ends[count] = count, 0
            count += 1
        of[a] = number[i]
        ends[of[a]] += 1
    for c in range(count):
        ends[c], begin = begin, begin + ends[c]
    for a in range(k):
        order[ends[of[a]]] = a
        ends[of[a]] += 1
    return order, ends[:count]


@inlined
def origin(least, i):
    """Return the least robot that is joined to robot ``i``; ``least`` (n,) leads there."""
    while least[i] != i:
        least[i] = least[least[i]]
        i = least[i]
    return i


def eliminate(its, robots, own, pairs, right, pivot, work, x):
    """Fill what of ``x`` (k,) the rows ``its`` of one set have, as ``_eliminated``; return whether that is
    not None."""
    (upper, lower), columns, (first, second) = work
    row, y, diagonal, sides, k = columns[0], columns[1], columns[2], columns[3:], len(its)
    for a in range(k):
        rank = its[a]
        first[a], second[a] = robots[0][rank], robots[1][rank] if rank < pairs else -1
        y[a] = right[rank]
        for axis in range(len(own)):
            sides[axis, a] = own[axis, rank]
    for a in range(k):
        start = products(a, first, second, sides, row)
        lower[a, :start] = upper[:start, a] = 0.0
        for b in range(start, a):
            upper[b, a], lower[a, b] = row[b], 0.0
            if row[b] != 0.0:
                share = lower[a, b] = row[b] / diagonal[b]
                for c in range(b + 1, a):
                    row[c] -= share * upper[b, c]
                row[a] -= share * row[b]
                y[a] -= share * y[b]
        diagonal[a] = row[a]
        if not row[a] > pivot:
            return False
    for a in range(k):
        y[a] /= diagonal[a]
    for a in range(k - 1, -1, -1):
        x[its[a]] = y[a]
        for b in range(a):
            y[b] -= lower[a, b] * y[a]
    return True


@inlined
def products(a, first, second, sides, row):
    """Fill ``row`` (k,) up to ``a`` with the products of row ``a`` with these; return the first that is
    not 0."""
    i, j, x, y = first[a], second[a], sides[0], sides[1]
    j = -2 if j < 0 else j  # nobody is the same
    for b in range(a + 1):
        row[b] = x[a] * x[b] + y[a] * y[b]
    for axis in range(2, len(sides)):
        own = sides[axis]
        for b in range(a + 1):
            row[b] += own[a] * own[b]
    for b in range(a + 1):
        row[b] *= (
            int(first[b] == i) + int(second[b] == j) - int(first[b] == j) - int(second[b] == i)
        )
    start = 0
    while row[start] == 0.0 and start < a:
        start += 1
    return start


@inlined
def along(own, a, b):
    """Return the inner product of columns ``a`` and ``b`` of ``own`` (d, k)."""
    total = 0.0
    for axis in range(len(own)):
        total += own[axis, a] * own[axis, b]
    return total


def slopes_of_caps(free, speed):
    """Return ``factor`` (n,) and ``ahead`` (d, n) as ``_Dual._slope_of_caps`` computes them."""
    factor, ahead = np.empty(len(speed)), np.zeros((len(free), len(speed)))
    for i in range(len(speed)):
        size = np.maximum(velocitys_length(free, i), 1e-300)
        factor[i] = np.minimum(1.0, speed[i] / size)
        for axis in range(len(free)):
            ahead[axis, i] = free[axis, i] / size if factor[i] < 1.0 else 0.0
    return factor, ahead


def fall(rows, change, factor, ahead, pushes, fallen):
    """Fill ``fallen`` (k,): how changes (k,) of forces lower the excess of their ``rows``."""
    (first, second, side, alone), pushes[:] = rows, 0.0
    for axis in range(len(pushes)):
        own, values = side[axis], pushes[axis]
        for a in range(len(change)):
            values[first[a]] -= own[a] * change[a]
        for a in range(len(change) - alone):
            values[second[a]] += own[a] * change[a]
    for i in range(len(factor)):
        along = 0.0
        for axis in range(len(pushes)):
            along += pushes[axis, i] * ahead[axis, i]
        for axis in range(len(pushes)):
            pushes[axis, i] = factor[i] * (pushes[axis, i] - along * ahead[axis, i])
    press_all(rows, pushes, fallen)


def gains(rows, near, n):
    """Return the steps (m,) of ``_by_gradients`` of the rows that are ``near``, 0 of the others."""
    first, second, _, alone = rows
    counts, gain, pairs = np.zeros(n), np.zeros(len(near)), len(near) - alone
    for k in range(len(near)):
        if near[k]:
            counts[first[k]] += 1.0
            counts[second[k]] += 1.0 if k < pairs else 0.0
    any_alone = near[pairs:].any()
    for k in np.flatnonzero(near):
        i, j = first[k], second[k]
        if any_alone:
            gain[k] = 1.0 / (counts[i] + (0.0 if i == j else counts[j] - 1.0))
        else:
            gain[k] = 1.0 / (1.0 + 0.5 * (counts[i] + counts[j] - 2.0))
    return gain


def by_both(begun, rows, most, speed, gain, force, free, counts, limits):
    """Let ``force`` (m,) be that of ``_by_both``, and ``free`` (d, n) what it leaves.

    ``counts``: ``STEPS``, ``FIRST`` and ``SWEEPS``.
    """
    (steps, first, sweeps), spent, done = counts, 0, False
    force[:] = 0.0
    while spent < sweeps and not done:
        more = min(max(spent, first), sweeps - spent)
        done = by_gradients(begun, rows, most, speed, gain, force, free, more, limits[0])
        spent += more
        found = force.copy()
        if by_newton(begun, rows, most, speed, found, free, steps, limits):
            force[:] = found
            return
    push(begun, rows, force, acting(force), free)


def by_gradients(begun, rows, most, speed, gain, force, free, sweeps, tolerance):
    """Let ``force`` (m,) be that of ``_by_gradients``, from what it is; return whether it was found."""
    m, ahead, momentum = len(force), force.copy(), 1.0
    excess, change = np.empty(m), np.empty(m)
    for _ in range(sweeps):
        push(begun, rows, ahead, acting(ahead), free)
        exceed(free, rows, most, speed, excess)
        changed = 0
        for k in range(m):
            following = ahead[k] + gain[k] * excess[k]
            ahead[k] = 0.0 if following <= 0.0 else following
            change[k] = ahead[k] - force[k]
            changed += not np.abs(change[k]) < tolerance
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        if summed(change, excess) < 0.0:
            following = momentum = 1.0
        factor = (momentum - 1.0) / following
        for k in range(m):
            force[k] = ahead[k]
            ahead[k] = force[k] + factor * change[k]
        momentum = following
        if not changed:
            return True
    return False


def feasible_share(pressure, limit):
    """Return the factor that ``_feasible_share`` does."""
    share = 1.0
    for k in range(len(limit)):
        most = np.maximum(limit[k], 0.0)
        if pressure[k] > most:
            share = np.minimum(share, most / pressure[k])
    return share


def meet(east, north, room, first, second):
    """Return which pairs may touch, (p,) bool, as ``braking_certificate.WayOut`` finds out in the plane.

    ``east`` and ``north`` (n, k + 1) [m]: places of courses; ``room`` (n, k) [m]: what robots fill beside
    them.
    """
    hit = np.empty(len(first), dtype=np.bool_)
    for p in range(len(first)):
        hit[p] = touch(east, north, room, first[p], second[p])
    return hit


@inlined
def touch(east, north, room, i, j):
    """Return whether robots i and j may touch on their courses, as ``meet`` has them."""
    count = 0
    for k in range(room.shape[1]):  # all: as vectors they take less than those up to the first
        x, y = east[i, k] - east[j, k], north[i, k] - north[j, k]
        move_x = east[i, k + 1] - east[j, k + 1] - x
        move_y = north[i, k + 1] - north[j, k + 1] - y
        size = move_x * move_x + move_y * move_y
        share = -(x * move_x + y * move_y) / (size if size > 1e-300 else 1e-300)
        share = share if share > 0.0 else 0.0
        share = share if share < 1.0 else 1.0
        x, y = x + share * move_x, y + share * move_y
        count += 1 if np.sqrt(x * x + y * y) < room[i, k] + room[j, k] else 0
    return count > 0


@functools.lru_cache(maxsize=None)
def compiled_loops():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(kept(each) for each in plain_loops()))


def plain_loops():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(near_pairs, pair_rows, heeded, solve, feasible_share, meet)
