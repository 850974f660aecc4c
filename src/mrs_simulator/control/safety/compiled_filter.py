"""The safety filter's constraints and their solution by loops that numba compiles, equal to the bit.

They do numpy's operations of ``nearest_velocities`` in numpy's order, row by row, with its names.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_terms import kept


class Loops(NamedTuple):
    """The loops that ``nearest_velocities`` calls, compiled or not."""

    near_pairs: Any
    pair_rows: Any
    heeded: Any
    solve: Any
    feasible_share: Any
    meet: Any


def near_pairs(seen, bound):
    """Return the rows of pairs whose squared distance is below ``bound`` [m^2], (m,) and (m,)."""
    n, d = seen.shape
    first = np.empty(n * (n - 1) // 2, dtype=np.int64)
    second, m, all_are = np.empty_like(first), 0, bound == np.inf
    for i in range(n):
        for j in range(i + 1, n):
            total = 0.0
            for axis in range(d):
                apart = seen[j, axis] - seen[i, axis]
                total += apart * apart
            first[m], second[m] = i, j  # without a branch, which would be guessed wrong
            m += (total < bound) | all_are
    return first[:m], second[:m]


def pair_rows(seen, points, squash, first, second, distance, terms, slowness, late):
    """Return ``of_second`` (m, d) and ``limit`` (m,) of pairs, as ``_pair_rows``.

    ``squash`` (d,), or (0,) for none; ``distance`` (n, n), or (1, 1) for one of all; ``terms``: ``period``
    and ``gamma``; ``slowness`` and ``late`` (n,), or (0,), of ``Brakes``.
    """
    m, d, braking = len(first), seen.shape[1], len(slowness) > 0
    rows, apart, length, needed = np.empty((m, d)), np.zeros(m), np.zeros(m), np.empty(m)
    waits, slow = np.empty(m), np.empty(m)
    for k in range(m):
        i, j = first[k], second[k]
        needed[k] = distance[i, j] if len(distance) > 1 else distance[0, 0]
        if braking:
            waits[k] = 0.5 * (late[i] + late[j])
            slow[k] = 0.5 * (slowness[i] + slowness[j])
    for axis in range(d):
        for k in range(m):
            i, j = first[k], second[k]
            way = seen[i, axis] - seen[j, axis]
            apart[k] += way * way
            if len(squash):
                way = (points[i, axis] - points[j, axis]) * (squash[axis] * squash[axis])
            length[k] += way * way
            rows[k, axis] = way
    size, limit = limits_of(apart, length, needed, terms, braking, waits, slow)
    for axis in range(d):
        for k in range(m):
            rows[k, axis] = 2.0 * rows[k, axis] / size[k]
    return rows, limit


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


def inner(a, b, i, j):
    """Return the squared distance of rows ``i`` of ``a`` and ``j`` of ``b``."""
    total = 0.0
    for axis in range(a.shape[1]):
        apart = a[i, axis] - b[j, axis]
        total += apart * apart
    return total


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
    (way_out, gap, turns), (n, d) = bounds, wanted.shape
    size, share = np.empty(n), np.zeros(n)
    for i in range(n):
        size[i] = np.sqrt(square(wanted, i))
    m, pairs = len(limit), len(limit) - len(gap)
    near = np.empty(m, dtype=np.bool_)
    for k in range(m):
        i, j = first[k], second[k]
        reach = np.sqrt(2.0) * (size[i] + size[j]) if k < pairs else size[i]
        near[k] = reach >= limit[k]
    for k in range(m):
        if not near[k]:
            continue
        i, j = first[k], second[k]
        if k >= pairs:
            own = k - pairs
            if product(way_out, wanted, own, i) < 0.0 and gap[own] < turns[own]:
                share[i] = np.maximum(share[i], turned)
            continue
        needed = distance[i, j] if len(distance) > 1 else distance[0, 0]
        squared, heeded = inner(seen, seen, i, j), heeds * needed
        if squared > 1.001 * heeded * heeded:  # few are near enough for a root
            continue
        far = np.maximum(np.sqrt(squared), 1e-9)
        close = (heeds - far / needed) / (heeds - 1.0)
        if not close > 0.0:
            continue
        close = np.minimum(close, 1.0) / far
        towards, back = 0.0, 0.0
        for axis in range(d):
            apart = seen[i, axis] - seen[j, axis]
            towards += -apart * wanted[i, axis]
            back += apart * wanted[j, axis]
        share[i] = np.maximum(share[i], close * (towards / np.maximum(size[i], 1e-300)))
        share[j] = np.maximum(share[j], close * (back / np.maximum(size[j], 1e-300)))
    return near, share


def solve(wanted, first, second, of_first, of_second, limit, alone, near, speed, accuracy):
    """Return the velocities (n, d) nearest to ``wanted``, and what they make of all rows, (m,).

    As ``_among`` from where wanted velocities are turned aside.  ``near`` (m,) grows by rows that robots
    are pushed towards; ``speed`` (n,), or (0,) for no caps; ``accuracy``: ``LEAST``, ``TOLERANCE``,
    ``RESIDUAL``, ``ASTRAY``, ``STEPS``, and ``FIRST`` and ``SWEEPS``.
    """
    velocity, pressure = wanted, np.empty(len(limit))
    press(velocity, first, second, of_first, of_second, alone, pressure)
    begins = False
    for k in range(len(limit)):
        begins |= near[k] and pressure[k] > limit[k] + accuracy[0]
    for i in range(len(speed)):
        begins |= np.sqrt(square(wanted, i)) > speed[i]
    while True:
        pushed = False
        for k in range(len(limit)):
            if not begins and not near[k] and pressure[k] > limit[k]:
                near[k] = pushed = True
        if not (begins or pushed):
            return velocity, pressure
        begins = False
        kept = np.flatnonzero(near)
        velocity = nearest(
            wanted, first, second, of_first, of_second, limit, alone, kept, speed, accuracy
        )
        press(velocity, first, second, of_first, of_second, alone, pressure)


def press(velocity, first, second, of_first, of_second, alone, pressure):
    """Fill ``pressure`` (m,) as ``Rows.pressure`` returns it."""
    pairs = len(pressure) - alone
    for k in range(len(pressure)):
        i, j, total = first[k], second[k], 0.0
        for axis in range(velocity.shape[1]):
            if k < pairs:
                total += of_second[k, axis] * (velocity[j, axis] - velocity[i, axis])
            else:
                total += of_first[k, axis] * velocity[i, axis]
        pressure[k] = total


def nearest(wanted, first, second, of_first, of_second, limit, alone, kept, speed, accuracy):
    """Return the velocities (n, d) nearest to ``wanted`` under the rows ``kept``, as ``_nearest``."""
    (n, d), m = wanted.shape, len(kept)
    place, share, most = np.empty((2 * d, m), dtype=np.uint64), np.empty((2 * d, m)), np.empty(m)
    for k in range(m):
        most[k] = limit[kept[k]]
        for axis in range(d):
            place[axis, k] = d * first[kept[k]] + axis
            place[d + axis, k] = d * second[kept[k]] + axis
            share[axis, k] = of_first[kept[k], axis]
            share[d + axis, k] = of_second[kept[k], axis]
    begun, uncapped = wanted.copy().reshape(n * d), speed[:0]
    _, tolerance, residual, astray, steps, sweeps = accuracy
    scale = max(1e-3, np.abs(most).max(), np.abs(begun).max())
    limits, force, free = (tolerance * scale, residual, astray), np.zeros(m), np.empty(n * d)
    found = False
    for caps in (uncapped, speed):
        found = by_newton(begun, place, share, most, caps, force, free, steps, limits)
        push(begun, place, share, force, free)
        if not found or not len(speed) or not is_capped(free, speed):
            break
    if not found:
        alone_kept = np.count_nonzero(kept >= len(limit) - alone)
        gain = gains(first, second, kept, alone_kept, n)
        by_both(begun, place, share, most, speed, gain, force, free, (steps, *sweeps), limits)
    push(begun, place, share, force, free)
    if len(speed):
        free = within_caps(free, speed)
    return free.reshape(n, d)


def push(begun, place, share, force, free):
    """Fill ``free`` (n d,) with what ``_Dual.free`` returns of ``force`` (m,)."""
    for at in range(len(free)):
        free[at] = 0.0
    acting, count = np.empty(len(force), dtype=np.int64), 0
    for k in range(len(force)):
        if force[k] != 0.0:  # few of them: the others add nothing
            acting[count] = k
            count += 1
    for row in range(len(place)):
        places, shares = place[row], share[row]
        for a in range(count):
            k = acting[a]
            free[places[k]] += shares[k] * force[k]
    for at in range(len(free)):
        free[at] = begun[at] - free[at]


def robots_length(free, i, d):
    """Return the length of the velocity of robot ``i`` in ``free`` (n d,)."""
    total = 0.0
    for axis in range(d):
        total += free[d * i + axis] * free[d * i + axis]
    return np.sqrt(total)


def is_capped(free, speed):
    """Return whether caps change any of the velocities ``free`` (n d,)."""
    d, found = len(free) // len(speed), False
    for i in range(len(speed)):
        found |= robots_length(free, i, d) > speed[i]
    return found


def within_caps(free, speed):
    """Return velocities ``free`` (n d,) within the caps ``speed`` (n,)."""
    d, capped = len(free) // len(speed), np.empty(len(free))
    for i in range(len(speed)):
        factor = np.minimum(1.0, speed[i] / np.maximum(robots_length(free, i, d), 1e-300))
        for axis in range(d):
            capped[d * i + axis] = free[d * i + axis] * factor
    return capped


def exceed(free, place, share, most, speed, excess):
    """Fill ``excess`` (m,) with what ``_Dual.excess`` returns of velocities ``free`` (n d,)."""
    pushed = within_caps(free, speed) if len(speed) else free
    press_all(place, share, pushed, excess)
    for k in range(len(excess)):
        excess[k] -= most[k]


def press_all(place, share, values, pressed):
    """Fill ``pressed`` (m,) with what rows make of ``values`` (n d,) at their places (2 d, m).

    Column by column, which is several times as fast as by both indices.
    """
    first, second, third, fourth = place[0], place[1], place[2], place[3]
    a, b, c, d = share[0], share[1], share[2], share[3]
    for k in range(len(pressed)):
        total = a[k] * values[first[k]] + b[k] * values[second[k]]
        pressed[k] = total + c[k] * values[third[k]] + d[k] * values[fourth[k]]
    for row in range(4, len(place)):  # in space
        places, shares = place[row], share[row]
        for k in range(len(pressed)):
            pressed[k] += shares[k] * values[places[k]]


def by_newton(begun, place, share, most, speed, force, free, steps, limits):
    """Let ``force`` (m,) be that of ``_by_newton``, from what it is; return whether it was found."""
    m, excess = len(force), np.empty(len(force))
    active, right = np.empty(m, dtype=np.int64), np.empty(m)
    push(begun, place, share, force, free)
    exceed(free, place, share, most, speed, excess)
    for _ in range(steps):
        done, dropped, count = True, False, 0
        for k in range(m):
            ahead = np.maximum(0.0, force[k] + excess[k])
            done &= np.abs(ahead - force[k]) < limits[0]
            if ahead == 0.0:
                dropped |= force[k] != 0.0
            else:
                active[count] = k
                count += 1
        if done:
            return True
        if dropped:
            for k in range(m):
                if not np.maximum(0.0, force[k] + excess[k]) > 0.0:
                    force[k] = 0.0
            push(begun, place, share, force, free)
            exceed(free, place, share, most, speed, excess)
        if count == 0:
            continue
        for a in range(count):
            right[a] = excess[active[a]]
        change, consistent = solved(
            place, share, active[:count], free, speed, right[:count], limits
        )
        if not consistent:
            return False
        for a in range(count):
            force[active[a]] += change[a]
        push(begun, place, share, force, free)
        exceed(free, place, share, most, speed, excess)
    return False


def summed(a, b):
    """Return the sum of the products of ``a`` and ``b`` (k,), one after the other."""
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total += a[k] * b[k]
    return total


def solved(place, share, active, free, speed, right, limits):
    """Return what ``_solved`` returns of ``_Dual.slope`` of the rows ``active`` (k,), and whether that is
    not None."""
    k, factor, ahead = len(active), np.empty(len(speed)), np.empty(len(free) if len(speed) else 0)
    own_place, own_share = np.empty((len(place), k), dtype=np.uint64), np.empty((len(place), k))
    for row in range(len(place)):
        for a in range(k):
            own_place[row, a], own_share[row, a] = place[row, active[a]], share[row, active[a]]
    slopes_of_caps(free, speed, factor, ahead)
    x, left, along = np.zeros(k), right.copy(), right.copy()
    moved, pushes = np.empty(k), np.empty(len(free))
    size = summed(left, left)
    least, most = limits[1] * limits[1] * size, limits[2] * limits[2] * size
    for _ in range(2 * k):
        fall(own_place, own_share, along, factor, ahead, pushes, moved)
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


def slopes_of_caps(free, speed, factor, ahead):
    """Fill ``factor`` (n,) and ``ahead`` (n d,) as ``_Dual._slope_of_caps`` computes them."""
    for i in range(len(speed)):
        d = len(free) // len(speed)
        size = np.maximum(robots_length(free, i, d), 1e-300)
        factor[i] = np.minimum(1.0, speed[i] / size)
        for axis in range(d):
            ahead[d * i + axis] = free[d * i + axis] / size if factor[i] < 1.0 else 0.0


def fall(place, share, change, factor, ahead, pushes, fallen):
    """Fill ``fallen`` (k,): how changes (k,) of forces lower the excess of their rows."""
    for at in range(len(pushes)):
        pushes[at] = 0.0
    for row in range(len(place)):
        places, shares = place[row], share[row]
        for a in range(len(change)):
            pushes[places[a]] += shares[a] * change[a]
    for i in range(len(factor)):
        d, along = len(pushes) // len(factor), 0.0
        for axis in range(d):
            along += pushes[d * i + axis] * ahead[d * i + axis]
        for axis in range(d):
            at = d * i + axis
            pushes[at] = factor[i] * (pushes[at] - along * ahead[at])
    press_all(place, share, pushes, fallen)


def gains(first, second, kept, alone, n):
    """Return the steps (m,) of ``_by_gradients`` of the rows ``kept``, ``alone`` of single robots last."""
    counts, pairs = np.zeros(n), len(kept) - alone
    for a in range(len(kept)):
        counts[first[kept[a]]] += 1.0
        if a < pairs:
            counts[second[kept[a]]] += 1.0
    gain = np.empty(len(kept))
    for a in range(len(kept)):
        i, j = first[kept[a]], second[kept[a]]
        if alone:
            gain[a] = 1.0 / (counts[i] + (0.0 if i == j else counts[j] - 1.0))
        else:
            gain[a] = 1.0 / (1.0 + 0.5 * (counts[i] + counts[j] - 2.0))
    return gain


def by_both(begun, place, share, most, speed, gain, force, free, counts, limits):
    """Let ``force`` (m,) be that of ``_by_both``; ``counts``: ``STEPS``, ``FIRST`` and ``SWEEPS``."""
    (steps, first, sweeps), spent, done = counts, 0, False
    for k in range(len(force)):
        force[k] = 0.0
    while spent < sweeps and not done:
        more = min(max(spent, first), sweeps - spent)
        done = by_gradients(begun, place, share, most, speed, gain, force, free, more, limits[0])
        spent += more
        found = force.copy()
        if by_newton(begun, place, share, most, speed, found, free, steps, limits):
            for k in range(len(force)):
                force[k] = found[k]
            return


def by_gradients(begun, place, share, most, speed, gain, force, free, sweeps, tolerance):
    """Let ``force`` (m,) be that of ``_by_gradients``, from what it is; return whether it was found."""
    m, ahead, momentum = len(force), force.copy(), 1.0
    excess, change = np.empty(m), np.empty(m)
    for _ in range(sweeps):
        push(begun, place, share, ahead, free)
        exceed(free, place, share, most, speed, excess)
        done = True
        for k in range(m):
            change[k] = np.maximum(0.0, ahead[k] + gain[k] * excess[k])
            ahead[k] = change[k]
            change[k] -= force[k]
            done &= np.abs(change[k]) < tolerance
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        if summed(change, excess) < 0.0:
            following = momentum = 1.0
        factor = (momentum - 1.0) / following
        for k in range(m):
            force[k] = ahead[k]
            ahead[k] = force[k] + factor * change[k]
        momentum = following
        if done:
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
        i, j = first[p], second[p]
        hit[p] = touch(east[i], north[i], room[i], east[j], north[j], room[j])
    return hit


def touch(east, north, room, other_east, other_north, other_room):
    """Return whether two robots may touch on their courses, of which arguments are rows of ``meet``'s."""
    count = 0
    for k in range(len(room)):  # all: as vectors they take less than those up to the first
        x, y = east[k] - other_east[k], north[k] - other_north[k]
        move_x, move_y = east[k + 1] - other_east[k + 1] - x, north[k + 1] - other_north[k + 1] - y
        size = move_x * move_x + move_y * move_y
        share = -(x * move_x + y * move_y) / (size if size > 1e-300 else 1e-300)
        share = share if share > 0.0 else 0.0
        share = share if share < 1.0 else 1.0
        x, y = x + share * move_x, y + share * move_y
        count += 1 if np.sqrt(x * x + y * y) < room[k] + other_room[k] else 0
    return count > 0


@functools.lru_cache(maxsize=None)
def compiled_loops():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(kept(each) for each in plain_loops()))


def plain_loops():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(near_pairs, pair_rows, heeded, solve, feasible_share, meet)
