"""Safety filter for any law: the nearest velocities with which robots touch nothing.

Nothing: no other robot, and where a scenario says so no obstacle and no border of an arena.
"""

import functools
import heapq
import operator
from typing import NamedTuple

import numpy as np

from mrs_simulator.control.safety import compiled_filter
from mrs_simulator.control.safety.bounds import NO_BOUNDS
from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.neighbours import DENSE, all_pairs, close_pairs, dot, squared, squared_apart

GAMMA = 1.0  # [1/(s m^4)] how fast a pair may use up its margin
FIXED_RATE = 1.0  # [1/s] the same for what stands still, whose margin is a distance [m]
MOVING_RATE = 0.3  # [1/s] the same for what moves: robots take their time to speed up
SWIRL = 0.8  # [rad] by which robots turn aside at most, before others straight ahead
LITTLE = 0.15  # [rad] the same upwards, and before what may have no way round, such as a border
HEEDS = 3.0  # [-] kept distances within which robots turn aside
STEPS = 12  # [-] most steps of the solver by Newton's method
FIRST = 20  # [-] steps by gradients before Newton's method begins anew
SWEEPS = 400  # [-] most steps of the solver by gradients
# [-] of elimination: the least pivot, of 2 of two robots, and the most rows of one set
ELIMINATED = (1e-4, 128)
RESIDUAL = 1e-12  # [-] that is left of linear equations
ASTRAY = 1e6  # [-] up to which it grows at first: beyond, rows contradict each other
NONE = np.empty(0)  # what the compiled loops take for nothing
TOLERANCE = 1e-7  # [-] of a constraint, relative to its size
WORTH = 40000  # [-] robots of all calls that take as long as numba takes to load
UNCHANGED = 1e-9  # [m/s] up to which a velocity is that which was wanted
FASTER = 1.25  # [-] of the greatest speed wanted: pairs too far apart for it are left out at first
LEAST = 5e-11  # [m/s] beyond its limit a constraint asks for no solution: less than any tolerance


def margins(points, distance):
    """Return ``h_ij = |p_i - p_j|^2 - D_s^2`` of all pairs, (m,) [m^2], and their rows (m,), (m,).

    ``distance``: ``D_s`` [m] of all pairs, or of each, (n, n).
    """
    return _margins(points, distance, np.inf)[:3]


def _margins(seen, distance, within):
    """Return ``margins`` of the places ``seen`` (n, d), the pairs' differences of place, (m, d), and their
    ``distance``, (m,) or a number; of pairs up to ``within`` [m] apart alone."""
    first, second = pairs_within(None, seen, within)
    apart = seen.take(first, axis=0) - seen.take(second, axis=0)
    needed = of_pairs(distance, first, second)
    return squared(apart) - needed * needed, first, second, apart, needed


def of_pairs(distance, first, second):
    """Return ``distance`` as it is if it is one number, else (n, n) that of the pairs, (m,)."""
    return distance if np.ndim(distance) == 0 else distance[first, second]


def safe_velocities(
    wanted,
    points,
    distance,
    period,
    gamma=GAMMA,
    swirl=SWIRL,
    bounds=NO_BOUNDS,
    speed=None,
    squash=None,
    brakes=None,
):
    """Return the velocities nearest to ``wanted`` that keep all pairs apart, (n, d) [m/s].

    Minimises ``sum |u_i - wanted_i|^2`` subject to, for every pair,

        -2 p_ij^T u_i + 2 p_ij^T u_j <= min(gamma h_ij^3, h_ij / period),

    ``p_ij = p_i - p_j``, ``h_ij = |p_ij|^2 - distance^2``; ``points`` (n, d) [m].  The second bound is
    for velocities that are held for ``period`` [s]: since ``|p + d|^2 >= |p|^2 + 2 p^T d``, no pair
    that starts with ``h >= 0`` ever has less.  Wang, Ames and Egerstedt, 2017.

    ``bounds``: :class:`Bounds` of single robots, ``-m_k^T u_i <= min(rate g_k, g_k / period) - v_k``, with
    the speed v_k at which it comes, and ``MOVING_RATE``, or ``FIXED_RATE`` of what stands; ``speed`` (n,)
    [m/s]: ``|u_i| <= speed_i``.

    ``squash`` (d,) [-], s: distances are ``|s p|``, factor by factor, so that robots keep an ellipsoid
    apart; ``s^2 p_ij`` stands in the bound then.

    ``brakes``: the ``Brakes`` of robots that do not stop at once; the speed w_ij at which a pair may
    close up then stands in the place of the first bound, ``2 |p_ij| w_ij`` in that of ``gamma h_ij^3``.
    """
    wanted = np.asarray(wanted, dtype=float)
    terms = points, distance, period, gamma, squash, brakes
    fastest = FASTER * float(_lengths(wanted).max(initial=0.0))
    # Where something comes nearer, robots may have to be faster than anybody wanted to be.
    within = np.inf if bounds.comes.any() else _most_distant(fastest, *terms[1:])
    velocity = _among(wanted, terms, within, swirl, bounds, speed)
    if within < np.inf and _breaks(velocity, terms, within, fastest):
        return _among(wanted, terms, np.inf, swirl, bounds, speed)
    return velocity


def _breaks(velocity, terms, within, fastest):
    """Return whether ``velocity`` (n, d) breaks the constraint of a pair that is ``within`` [m] or farther
    apart, which none up to ``fastest`` [m/s] does."""
    faster = float(_lengths(velocity).max())
    if not faster > fastest:
        return False
    points, wider = terms[0], _most_distant(faster, *terms[1:])
    rows = _rows_of(filter_loops(len(velocity)), terms, wider)
    far = squared_apart(points, rows.first, rows.second) >= within * within
    return bool((far & (rows.pressure(velocity) > rows.limit)).any())


def _among(wanted, terms, within, swirl, bounds, speed):
    """Return ``safe_velocities``, pairs that are ``within`` [m] or farther apart left out."""
    points, distance, period, _, squash, _ = terms
    loops = filter_loops(len(wanted))
    pairs = _rows_of(loops, terms, within)
    rows = _joined(pairs, bounds, period)
    seen = points if squash is None else points * squash
    if loops is None:
        # At first only pairs matter that could violate their constraint by heading straight for each other.
        near = rows.reach(_lengths(wanted)) >= rows.limit
        share = _beside(wanted, seen, distance, near, pairs, bounds) if near.any() else None
    else:
        near, share = _looped_shares(loops, wanted, seen, distance, rows, bounds)
    if not near.any():
        return capped(wanted, speed)
    wanted = _turned_aside(wanted, share, swirl)
    solution = _solution if loops is None else functools.partial(_looped_solution, loops)
    velocity, pressure = solution(wanted, rows, near, speed)
    if bounds.comes.any():
        return velocity * _feasible_shares(velocity, rows, pressure)
    share = _feasible_share if loops is None else loops.feasible_share
    return velocity * share(pressure, rows.limit)


def _solution(wanted, rows, near, speed):
    """Return the velocities (n, d) nearest to ``wanted`` under the rows that are ``near``, or that those
    velocities would break, and what they make of all rows, (m,)."""
    velocity, pressure = wanted, rows.pressure(wanted)
    if (near & (pressure > rows.limit + LEAST)).any() or _is_beyond(speed, wanted):
        velocity = _nearest(wanted, rows.part(near), speed)
        pressure = rows.pressure(velocity)
    while True:
        # A robot that is pushed aside may be pushed towards one that it did not head for.
        pushed = ~near & (pressure > rows.limit)
        if not pushed.any():
            return velocity, pressure
        near = near | pushed
        velocity = _nearest(wanted, rows.part(near), speed)
        pressure = rows.pressure(velocity)


def filter_loops(n):
    """Return the ``compiled_filter.Loops`` where they pay in a call for n robots, else None."""
    return same_bits(compiled_filter.compiled_loops, WORTH, n)


def pairs_within(loops, seen, within):
    """Return the rows of all pairs of places closer than ``within`` [m], (m,) and (m,), i < j.

    By the ``loops``, None for none, where all pairs are compared.
    """
    if loops is not None and (len(seen) <= DENSE or within == np.inf):
        return loops.near_pairs(np.ascontiguousarray(seen), within * within)
    return all_pairs(len(seen)) if within == np.inf else close_pairs(seen, within)


def _rows_of(loops, terms, within):
    """Return the ``Rows`` of pairs closer than ``within`` [m], by the ``loops``, or numpy for None."""
    if loops is None:
        return _pair_rows(*terms, within=within)
    return _looped_rows(loops, *terms, within)


def _looped_rows(loops, points, distance, period, gamma, squash, brakes, within):
    """As ``_pair_rows``, by ``compiled_filter.Loops``."""
    points = np.ascontiguousarray(points)
    seen = points if squash is None else points * squash
    first, second = pairs_within(loops, seen, within)
    squash = NONE if squash is None else squash
    slowness, late = (NONE, NONE) if brakes is None else brakes
    given, terms = (first, second, np.atleast_2d(distance)), (float(period), float(gamma))
    side, limit = loops.pair_rows(seen, points, squash, *given, terms, slowness, late)
    return Rows(first, second, -side.T, side.T, limit)


def _looped_shares(loops, wanted, seen, distance, rows, bounds):
    """Return which ``rows`` may matter, (m,) bool, and what ``_beside`` does, by the ``loops``."""
    given = np.ascontiguousarray(wanted), np.ascontiguousarray(seen), np.atleast_2d(distance)
    around = np.ascontiguousarray(bounds.way_out), bounds.gap, bounds.turns
    return loops.heeded(*given, rows.first, rows.second, rows.limit, HEEDS, around, LITTLE / SWIRL)


def _looped_solution(loops, wanted, rows, near, speed):
    """As ``_solution``, by the ``loops``."""
    accuracy = LEAST, TOLERANCE, (RESIDUAL, ASTRAY, ELIMINATED), STEPS, (FIRST, SWEEPS)
    speed = NONE if speed is None else np.array(speed, dtype=float)
    side = np.ascontiguousarray(-rows.of_first.T)
    given = rows.first, rows.second, side, rows.limit, rows.alone, near
    return loops.solve(np.ascontiguousarray(wanted), *given, speed, accuracy)


def _is_beyond(speed, velocity):
    """Return whether any of ``velocity`` (n, d) is beyond the caps ``speed`` (n,) [m/s], None for none."""
    return speed is not None and bool((_lengths(velocity) > speed).any())


def filter_acts(
    velocity,
    points,
    distance,
    period,
    gamma=GAMMA,
    bounds=NO_BOUNDS,
    speed=None,
    squash=None,
    brakes=None,
):
    """Return whether the filter may have changed what was wanted to ``velocity`` (n, d) [m/s].

    A velocity that was changed lies on a bound, or some robot was turned aside.
    """
    pairs = _pair_rows(points, distance, period, gamma, squash, brakes)
    points = points if squash is None else points * squash
    rows = _joined(pairs, bounds, period)
    size = _lengths(velocity)
    if speed is not None and np.any(size >= 0.99 * speed):
        return True
    near = rows.reach(size) >= rows.limit
    used = rows.pressure(velocity) >= np.where(rows.limit > 0.0, 0.99, 1.01) * rows.limit
    return bool(used.any() or _beside(velocity, points, distance, near, pairs, bounds).any())


class Rows(NamedTuple):
    """Constraints ``a_i^T u_i + a_j^T u_j <= limit``, m of them, each of length 1."""

    first: np.ndarray  # (m,) i
    second: np.ndarray  # (m,) j; i itself for constraints of one robot
    of_first: np.ndarray  # (m, d) a_i
    of_second: np.ndarray  # (m, d) a_j, 0 for constraints of one robot
    limit: np.ndarray  # (m,) [m/s]
    alone: int = 0  # [-] how many, at the end, are of one robot

    def pressure(self, velocity):
        """Return ``a_i^T u_i + a_j^T u_j``, (m,) [m/s]."""
        pairs = len(self.limit) - self.alone
        first, second = self.first[:pairs], self.second[:pairs]
        # Of a pair a_i = -a_j.
        used = dot(self.of_second[:pairs], velocity[second] - velocity[first])
        if not self.alone:
            return used
        own = dot(self.of_first[pairs:], velocity[self.first[pairs:]])
        return np.concatenate([used, own])

    def reach(self, size):
        """Return the most that robots of speeds ``size`` (n,) [m/s] can make of each, (m,) [m/s]."""
        both = np.sqrt(2.0) * (size[self.first] + size[self.second])
        if self.alone:
            both[-self.alone :] = size[self.first[-self.alone :]]
        return both

    def part(self, kept):
        """Return the constraints for which ``kept`` (m,) is True."""
        alone = int(np.count_nonzero(kept[len(kept) - self.alone :]))
        return Rows(*(column[kept] for column in self[:5]), alone)


class Brakes(NamedTuple):
    """How robots stop: from a speed v within ``v late + slowness v^2/2``."""

    slowness: np.ndarray  # (n,) [s^2/m]
    late: np.ndarray  # (n,) [s]

    def closing(self, gap, first, second):
        """Return the speeds (m,) [m/s] at which pairs may close up with ``gap`` (m,) [m] left between them.

        Those from which both stop within it, each from half: ``w/2 (t_i + t_j) + w^2/8 (s_i + s_j) = gap``.
        """
        late = 0.5 * (self.late[first] + self.late[second])
        slow = 0.5 * (self.slowness[first] + self.slowness[second])
        gap = np.maximum(gap, 0.0)
        return 2.0 * gap / (late + np.sqrt(late * late + slow * gap))


def _most_distant(speed, distance, period, gamma, squash, brakes):
    """Return what :func:`most_distant` does, inf where nothing is known of it."""
    if squash is not None or brakes is None:
        return np.inf
    ends = float(brakes.late.max()), float(brakes.slowness.max())
    return most_distant(speed, *extremes(distance), period, gamma, *ends)


def extremes(distance):
    """Return the least and the greatest ``distance`` [m] of two robots, (n, n) or one number of all."""
    if np.ndim(distance) == 0:
        return float(distance), float(distance)
    off = ~np.eye(len(distance), dtype=bool)
    return float(distance[off].min()), float(distance.max())


def most_distant(speed, least, largest, period, gamma, late, slowness):
    """Return the distance [m] from which on the bounds of pairs allow two robots at ``speed`` [m/s] each.

    As ``Rows.reach`` has them at half of it, and beyond where robots turn aside.  The least of the three
    bounds, of the largest robots; ``least`` and ``largest``: distances kept [m]; ``late`` [s] and
    ``slowness`` [s^2/m] of those that brake worst.
    """
    most = np.sqrt(2.0) * speed
    closing = np.sqrt(2.0) * most
    gap = closing * late + 0.25 * closing * closing * slowness
    # (x^2 - 1)^3/x is above (x^2 - 1)^2.5/sqrt(2) from x^2 = 2 on.
    wide = np.sqrt(1.0 + max(1.0, (4.0 * most / (gamma * least)) ** 0.4))
    held = 2.0 * np.sqrt(2.0) * period * most
    return 1.001 * max(largest + gap, largest * wide, largest + held, HEEDS * largest)


def _pair_rows(points, distance, period, gamma, squash=None, brakes=None, within=np.inf):
    seen = points if squash is None else points * squash
    margin, first, second, apart, needed = _margins(seen, distance, within)
    if squash is not None:
        apart = (points[first] - points[second]) * squash**2
    # Each row divided by its length.
    far = np.maximum(_lengths(apart), 1e-9)
    size = 2.0 * np.sqrt(2.0) * far
    rows = 2.0 * apart / size[:, np.newaxis]
    if brakes is None:
        most = gamma * (margin * margin * margin)
    else:
        gap = np.sqrt(np.maximum(margin + needed * needed, 0.0)) - needed
        most = 2.0 * far * brakes.closing(gap, first, second)
        # In units of the robots' size, so that the solution scales with it.
        square = needed * needed
        most = np.minimum(most, gamma * (margin * margin * margin) / (square * square))
    limit = np.minimum(most, margin / period) / size
    return Rows(first, second, -rows, rows, limit)


def _fixed_rows(bounds, period):
    rate = np.where(bounds.comes == 0.0, FIXED_RATE, MOVING_RATE)
    limit = np.minimum(rate, 1.0 / period) * bounds.gap - bounds.comes
    nothing = np.zeros_like(bounds.way_out)
    return Rows(bounds.robot, bounds.robot, -bounds.way_out, nothing, limit, len(limit))


def _joined(pairs, bounds, period):
    """Return the rows of ``pairs`` and, after them, those of ``bounds``."""
    if not len(bounds.gap):
        return pairs
    fixed = _fixed_rows(bounds, period)
    columns = [np.concatenate(both) for both in zip(pairs[:5], fixed[:5])]
    return Rows(*columns, fixed.alone)


def _beside(wanted, points, distance, near, pairs, bounds):
    """Return the shares (n,) [-] of the largest angle by which robots turn aside.

    From 0 at ``HEEDS`` kept distances to 1 at one of them, times the cosine between ``wanted`` (n, d) and
    the way to the other.  Nearer than ``bounds.turns`` to what they head for it is ``LITTLE`` at least.
    """
    share, met = np.zeros(len(points)), np.flatnonzero(near[: len(pairs.first)])
    first, second = pairs.first.take(met), pairs.second.take(met)
    size = np.maximum(_lengths(wanted), 1e-300)
    apart = points.take(first, axis=0) - points.take(second, axis=0)
    gap = np.maximum(_lengths(apart), 1e-9)
    close = (HEEDS - gap / of_pairs(distance, first, second)) / (HEEDS - 1.0)
    heeds = np.flatnonzero(close > 0.0)
    first, second, apart = first.take(heeds), second.take(heeds), apart.take(heeds, axis=0)
    close = np.minimum(close.take(heeds), 1.0) / gap.take(heeds)
    for rows, way in ((first, -apart), (second, apart)):
        ahead = dot(way, wanted.take(rows, axis=0)) / size.take(rows)
        np.maximum.at(share, rows, close * ahead)
    if len(bounds.gap):
        ahead = dot(bounds.way_out, wanted[bounds.robot]) < 0.0
        turned = bounds.robot[near[len(pairs.first) :] & ahead & (bounds.gap < bounds.turns)]
        share[turned] = np.maximum(share[turned], LITTLE / SWIRL)
    return share


def _turned_aside(wanted, share, swirl):
    """Turn wanted velocities by ``share`` (n,) [-] of ``swirl`` [rad], all to the same side.

    In space also about the x axis, so that those turn aside, too, that go straight up and down.
    """
    angle = swirl * share
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = wanted.T[:2]
    x, y = cos * x - sin * y, sin * x + cos * y
    if wanted.shape[1] == 2:
        return np.stack([x, y], axis=1)
    angle = np.minimum(angle, LITTLE)
    z, cos, sin = wanted[:, 2], np.cos(angle), np.sin(angle)
    return np.stack([x, cos * y - sin * z, sin * y + cos * z], axis=1)


def capped(velocity, speed):
    """Return ``velocity`` (n, d) with lengths of at most ``speed`` (n,) [m/s], None for no caps."""
    if speed is None:
        return velocity
    size = _lengths(velocity)
    return velocity * np.minimum(1.0, speed / np.maximum(size, 1e-300))[:, np.newaxis]


@np.errstate(over="ignore", invalid="ignore")  # where Newton's method leads astray
def _nearest(wanted, rows, speed=None):
    """Solve the quadratic programme in its dual: by Newton's method, else from where gradients lead."""
    dual = _Dual(wanted, rows)
    scale = max(1e-3, float(np.abs(rows.limit).max()), float(np.abs(wanted).max()))
    force = _by_newton(dual, np.zeros(len(rows.limit)), TOLERANCE * scale)
    if speed is not None:
        dual.cap(speed)
        if force is not None and dual.is_capped(dual.free(force)):
            force = _by_newton(dual, force, TOLERANCE * scale)
    if force is None:
        force = _by_both(dual, rows, TOLERANCE * scale)
    return dual.pushed(dual.free(force)).reshape(wanted.shape)


class _Dual:
    """The dual of the quadratic programme: forces (m,) that push the robots of each row apart."""

    def __init__(self, wanted, rows, speed=None):
        (n, d), (first, second) = wanted.shape, rows[:2]
        self.n = n
        self._place = np.stack([d * robot + axis for robot in (first, second) for axis in range(d)])
        self._share = np.concatenate([rows.of_first.T, rows.of_second.T])  # a_k, at its 2 d places
        self._begun, self._places = wanted.ravel(), self._place.ravel()
        self._limit, self._speed, self._rows = rows.limit, speed, rows

    def cap(self, speed):
        """Let velocities be at most ``speed`` (n,) [m/s]."""
        self._speed = speed

    def is_capped(self, free):
        """Return whether caps change any of the velocities ``free`` (n d,)."""
        return bool((_lengths(free.reshape(self.n, -1)) > self._speed).any())

    def free(self, force):
        """Return ``u - A^T lambda``, (n d,)."""
        pushes = (self._share * force).ravel()
        return self._begun - np.bincount(self._places, pushes, len(self._begun))

    def pushed(self, free):
        """Return velocities ``free`` (n d,) within the caps."""
        if self._speed is None:
            return free
        return capped(free.reshape(self.n, -1), self._speed).ravel()

    def excess(self, free):
        """Return by how much velocities ``free`` (n d,) are beyond the limits within the caps, (m,)."""
        return (self._share * self.pushed(free).take(self._place)).sum(axis=0) - self._limit

    def slope(self, rows, free):
        """Return how changes (k,) of the forces of ``rows`` (k,) lower their excess (k,), as a function."""
        place, share = self._place.take(rows, axis=1), self._share.take(rows, axis=1)
        turned = self._slope_of_caps(free)
        places = place.ravel()

        def fallen(change):
            pushes = np.bincount(places, (share * change).ravel(), len(free))
            return (share * turned(pushes).take(place)).sum(axis=0)

        return fallen

    def eliminated(self, rows, excess):
        """Return the changes (k,) of the forces of ``rows`` (k,) that take away their ``excess`` (k,), by
        elimination.

        None where velocities have caps, too many rows are joined by robots, or one depends on others.
        """
        if self._speed is not None:
            return None
        own = self._rows
        single = rows >= len(own.limit) - own.alone
        first, second = own.first[rows].tolist(), np.where(single, -1, own.second[rows]).tolist()
        if _largest_set(first, second) > ELIMINATED[1]:
            return None
        side = (-own.of_first[rows]).tolist()
        change = _eliminated(list(zip(first, second)), side, excess.tolist())
        return None if change is None else np.array(change)

    def _slope_of_caps(self, free):
        """Return a function of changes (n d,) of velocities ``free``: those within the caps.

        On its cap a velocity only turns.
        """
        if self._speed is None:
            return lambda change: change
        free = free.reshape(self.n, -1)
        size = np.maximum(_lengths(free), 1e-300)
        factor = np.minimum(1.0, self._speed / size)[:, np.newaxis]
        ahead = np.where(factor < 1.0, free / size[:, np.newaxis], 0.0)

        def turned(change):
            own = change.reshape(free.shape)
            along = dot(own, ahead)[:, np.newaxis]
            return (factor * (own - along * ahead)).ravel()

        return turned


def _by_newton(dual, force, tolerance):
    """Return forces with ``force = max(0, force + excess)``, (m,), None where these are not found soon.

    ``force``: those to begin with.  Far beyond caps small forces change nothing: begin with those without.
    Each step takes for active what pushes, or is beyond its limit (Bergounioux, Ito and Kunisch, 1999).
    """
    free = dual.free(force)
    excess = dual.excess(free)
    for _ in range(STEPS):
        ahead = np.maximum(0.0, force + excess)
        if (np.abs(ahead - force) < tolerance).all():
            return force
        active = np.flatnonzero(ahead)
        if (force[ahead == 0.0] != 0.0).any():
            force = np.where(ahead > 0.0, force, 0.0)
            free = dual.free(force)
            excess = dual.excess(free)
        if not len(active):
            continue
        change = _solved(dual, active, free, excess[active])
        if change is None:
            return None
        force = force.copy()
        force[active] += change
        free = dual.free(force)
        excess = dual.excess(free)
    return None


def _summed(values):
    """Return the sum of ``values`` (k,), one after the other, as the compiled loops add."""
    return values.cumsum()[-1]


def _lengths(a):
    """Return the lengths (m,) of vectors a (m, d), of squares added one after the other."""
    return np.sqrt(squared(a))


def _solved(dual, active, free, excess):
    """Return the changes (k,) of the forces of rows ``active`` (k,) that take away their ``excess`` (k,) at
    velocities ``free`` (n d,); None where none do."""
    change = dual.eliminated(active, excess)
    if change is not None:
        return change
    return _by_conjugate_gradients(dual.slope(active, free), excess)


def _largest_set(first, second):
    """Return how many rows of robots ``first`` and ``second`` (k), -1 for none, robots join at most."""
    least, counts = {}, {}

    def origin(robot):
        while least.setdefault(robot, robot) != robot:
            robot = least[robot]
        return robot

    for i, j in zip(first, second):
        i = origin(i)
        j = i if j < 0 else origin(j)
        least[max(i, j)] = min(i, j)
    for i in map(origin, first):
        counts[i] = counts.get(i, 0) + 1
    return max(counts.values(), default=0)


def _eliminated(ends, side, right):
    """Return x (k) with ``A A^T x = right`` (k), in lists; None for a pivot that is too small.

    ``A`` has, of two robots (k, 2), ``-side`` (k, d) of the first and ``side`` of the second, -1 for none.
    Few of the products of rows are not 0, and numpy would take longer for each of so few.
    """
    by_robot, columns = {}, [[] for _ in right]  # rows so far, and what is below each pivot
    shares, pivots, x = [], [], []
    for a, (first, second) in enumerate(ends):
        row, own, value, size = {}, [], right[a], _product(side[a], side[a])
        for robot, sign in ((first, 1.0), (second, -1.0))[: 1 if second < 0 else 2]:
            for b, other in by_robot.setdefault(robot, []):
                row[b] = row.get(b, 0.0) + sign * other * _product(side[a], side[b])
            by_robot[robot].append((a, sign))
        pivot, waiting = size if second < 0 else size + size, sorted(row)
        while waiting:
            b = heapq.heappop(waiting)
            product = row[b]
            if product == 0.0:
                continue
            share = product / pivots[b]
            for c, below in columns[b]:
                if c not in row:
                    heapq.heappush(waiting, c)
                row[c] = row.get(c, 0.0) - share * below
            pivot, value = pivot - share * product, value - share * x[b]
            columns[b].append((a, product))
            own.append((b, share))
        if not pivot > ELIMINATED[0]:
            return None
        shares.append(own)
        pivots.append(pivot)
        x.append(value)
    x = [value / pivot for value, pivot in zip(x, pivots)]
    for a in range(len(x) - 1, 0, -1):
        for b, share in shares[a]:
            x[b] -= share * x[a]
    return x


def _product(a, b):
    """Return the inner product of a and b (d)."""
    return sum(map(operator.mul, a, b))


def _by_conjugate_gradients(matrix, right):
    """Return x (k,) with ``matrix(x) = right``, linear and semi-definite, by conjugate gradients.

    None where no x has: then what is left grows without end.  They need no LAPACK, whose threads cost more
    than so few rows.
    """
    x, left = np.zeros(len(right)), right
    along, size = left, _summed(left * left)
    least, most = RESIDUAL * RESIDUAL * size, ASTRAY * ASTRAY * size
    for _ in range(2 * len(right)):
        moved = matrix(along)
        curved = _summed(along * moved)
        if size <= least or curved <= 0.0:
            break
        x = x + size / curved * along
        left = left - size / curved * moved
        before, size = size, _summed(left * left)
        if size > most:
            return None
        along = left + size / before * along
    return x


def _by_both(dual, rows, tolerance):
    """Return the forces (m,) by Newton's method from where gradients lead, or those of gradients alone.

    In a crowd more pairs touch than hold, and it may choose some that cannot all be kept at their limits:
    from near the solution it goes there.
    """
    force, step, spent, done = np.zeros(len(rows.limit)), _gains(rows, dual.n), 0, False
    while spent < SWEEPS and not done:
        more = min(max(spent, FIRST), SWEEPS - spent)
        force, done = _by_gradients(dual, force, step, more, tolerance)
        spent += more
        found = _by_newton(dual, force, tolerance)
        if found is not None:
            return found
    return force


def _gains(rows, n):
    """Return the steps (m,) of projected gradients.

    A force pushes each pair apart; its step is 1 over the sum of what all forces do to its pair: 1
    itself, and at most half for each other pair of one of the two robots.  With constraints of single
    robots, which share all of their robot, that sum is bounded by 1 for each of both robots'.
    """
    first, second = rows[:2]
    if rows.alone:
        pairs = len(first) - rows.alone
        counts = np.bincount(np.concatenate([first, second[:pairs]]), minlength=n)
        return 1.0 / (counts[first] + np.where(first == second, 0, counts[second] - 1))
    pairs = np.bincount(np.concatenate([first, second]), minlength=n)
    return 1.0 / (1.0 + 0.5 * (pairs[first] + pairs[second] - 2))


def _by_gradients(dual, force, step, sweeps, tolerance):
    """Return forces (m,) after accelerated projected gradients from ``force``, and whether they rest."""
    ahead, momentum = force, 1.0
    for _ in range(sweeps):
        excess = dual.excess(dual.free(ahead))
        new = np.maximum(0.0, ahead + step * excess)
        change = new - force
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        if _summed(change * excess) < 0.0:
            following = momentum = 1.0  # start the acceleration anew where it leads astray
        ahead = new + (momentum - 1.0) / following * change
        force, momentum = new, following
        if (np.abs(change) < tolerance).all():
            return force, True
    return force, False


def _feasible_shares(velocity, rows, pressure):
    """Return the largest factors (n, 1) up to 1 by which robots may move, where something comes closer.

    One for each set of robots that ``rows`` join at this ``velocity`` (n, d): a robot that can avoid a
    moving obstacle need not stop with one that cannot.  Obstacles that come closer even to robots at rest
    are left out.
    """
    joins = rows.reach(_lengths(velocity)) >= rows.limit
    sets, first, second = np.arange(len(velocity)), rows.first[joins], rows.second[joins]
    while (sets[first] != sets[second]).any():
        least = np.minimum(sets[first], sets[second])
        np.minimum.at(sets, first, least)
        np.minimum.at(sets, second, least)
    counted = (rows.first != rows.second) | (rows.limit >= 0.0)
    shares = np.ones(len(velocity))
    for label in np.unique(sets):
        own = counted & (sets[rows.first] == label)
        shares[sets == label] = _feasible_share(pressure[own], rows.limit[own])
    return shares[:, np.newaxis]


def _feasible_share(pressure, limit):
    """Return the largest factor up to 1 by which all may move: standing still is always allowed."""
    over = pressure > np.maximum(limit, 0.0)
    if not over.any():
        return 1.0
    return float(np.clip(np.min(np.maximum(limit[over], 0.0) / pressure[over]), 0.0, 1.0))
