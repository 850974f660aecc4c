"""What ``SafetyFilter.passed`` does for unicycles that know places, in one call that numba compiles.

With numpy's bits: ``nearest_velocities``' constraints and their solution, ``braking_certificate``'s way out
and ``deadlock_detector``'s robots that are held, one after the other, with numpy's operations in its order.
"""

import functools

import numpy as np

from mrs_simulator.control.safety.braking_certificate import BRAKES, EXACT, LATE, SHARES
from mrs_simulator.control.safety.compiled_filter import (
    feasible_share,
    heeded,
    pair_rows,
    press,
    solve,
    square,
    touch,
)
from mrs_simulator.control.safety.deadlock_detector import HELD, MOVES, NEARBY
from mrs_simulator.control.safety.nearest_velocities import (
    ASTRAY,
    ELIMINATED,
    FASTER,
    FIRST,
    FIXED_RATE,
    GAMMA,
    HEEDS,
    LEAST,
    LITTLE,
    NONE,
    RESIDUAL,
    STEPS,
    SWEEPS,
    SWIRL,
    TOLERANCE,
    UNCHANGED,
    most_distant,
)
from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_neighbours import near_pairs
from mrs_simulator.core.compiled_terms import kept
from mrs_simulator.scenario.control import SATURATIONS
from mrs_simulator.vehicles.compiled_courses import followed, longest, roll
from mrs_simulator.vehicles.courses import LEAST as SHORTEST

# STAND: obstacles may be in a robot's way, and whether it can brake is not known; ODD: no usable command.
FREE, STAND, ODD = range(3)
# Whose limits slow down a robot, rows of SATURATIONS; GIVEN: commands are within limits.
ROBOT, TEAM, GIVEN = SATURATIONS.index("robot"), SATURATIONS.index("team"), -1
ROUNDED = 1e-6  # [m] more than rounding adds to how far robots are from each other
SLOWER = np.array(SHARES)  # of a tuple the compiled loop would make another at each index


def pass_all(pose, command, unlimited, known, robots, kept_apart, bounds, scope, limits, passed):
    """Fill ``passed`` (2, n) with the ``command`` (2, n) as the filter lets it pass at ``pose`` (3, n).

    ``unlimited`` (n, 2) [m/s], or (0, 2) for None; ``known``: what was before, inner states (n, 2), command
    (2, n) and speeds (n,), and for how many seconds, below 0 for robots at rest; since when robots are held
    still, (n,), as ``DeadlockDetector`` has it, which is noted, and the time [s];
    ``robots``: as ``OneCall`` lists them; ``kept_apart``: distances (n, n), or (1, 1) for one of all, what
    ``most_distant`` takes of them, caps (n,) [m/s], or (0,) for none, and these or limits, whichever is
    less; ``bounds``: those of ``Bounds`` that stand; ``scope``: the points' lead l [m], the period [s], and
    columns, instants and shares of courses; ``limits``: ``GIVEN``, or else which of ``SATURATIONS`` limit
    the ``command``, which is filled, then, from ``unlimited``.

    Returns ``ODD``, ``STAND``, or ``FREE`` if the command leaves a way out, the inner states and the
    speeds.
    """
    n, (lead, period, columns, instants, brakes) = pose.shape[1], scope
    top, rates, fastest, radii, slowness, late, waits = robots
    distance, ends, speed, most = kept_apart
    cos, sin = np.empty(n), np.empty(n)
    cosines(pose[2], cos)
    sines(pose[2], sin)
    if limits != GIVEN and not limit(unlimited, cos, sin, lead, top, limits, command):
        return ODD, known[0], known[2]
    points, given = np.empty((n, 2)), velocities(command, cos, sin, lead)
    for i in range(n):
        points[i, 0], points[i, 1] = pose[0, i] + lead * cos[i], pose[1, i] + lead * sin[i]
    wanted = given
    if len(unlimited):
        wanted = capped(unlimited, most)
    terms = distance, ends, period, slowness, waits
    velocity, pairs = nearest(wanted, points, terms, bounds, speed)
    turned_away(command, given, wanted, velocity, speed, cos, sin, lead, top, passed)
    inner, speeds = foreseen(known, top, rates)
    ways = braking_ways(passed, speeds, fastest, period, slowness, late)
    for k in range(len(bounds[0])):
        if bounds[2][k] < ways[bounds[0][k]]:
            return STAND, inner, speeds
    first, second = meeting(pose, radii, ways, lead, pairs)
    if len(first):
        states, times = (inner, top, rates), (period, columns, instants, brakes)
        spread = spreads(passed, states, radii, times)
        first, second = approaching(pose, cos, sin, spread, first, second)
    if len(first):
        let(passed, pose, states, radii, times, first, second)
    done = velocities(passed, cos, sin, lead)
    note_held(held_still(given, done, points, distance), *known[4:])
    return FREE, inner, speeds


def limit(velocity, cos, sin, lead, top, scope, command):
    """Fill ``command`` (2, n) with what gives points ``velocity`` (n, 2), as ``LawRunner.limited``.

    Return whether it is finite.  ``scope``: which of ``SATURATIONS``.
    """
    n, worst, odd, factor = len(velocity), 1.0, 0, np.empty(len(velocity))
    for i in range(n):
        x, y = velocity[i, 0], velocity[i, 1]
        ahead, turn = cos[i] * x + sin[i] * y, (cos[i] * y - sin[i] * x) / lead
        own = max(np.abs(ahead) / top[i, 0], np.abs(turn) / top[i, 1], 1.0)
        odd += not (np.isfinite(ahead) and np.isfinite(turn) and np.isfinite(own))
        command[0, i], command[1, i], factor[i], worst = ahead, turn, own, max(worst, own)
    for i in range(n):
        share = factor[i] if scope == ROBOT else worst if scope == TEAM else 1.0
        command[0, i], command[1, i] = command[0, i] / share, command[1, i] / share
    return odd == 0


def velocities(command, cos, sin, lead):
    """Return the velocities (n, 2) [m/s] of the points under ``command`` (2, n), as ``Team.velocity``."""
    result = np.empty((command.shape[1], 2))
    for i in range(len(result)):
        along, across = command[0, i], lead * command[1, i]
        result[i, 0] = cos[i] * along - sin[i] * across
        result[i, 1] = sin[i] * along + cos[i] * across
    return result


def capped(velocity, speed):
    """Return ``velocity`` (n, 2) with lengths of at most ``speed`` (n,) [m/s]."""
    result = np.empty(velocity.shape)
    for i in range(len(velocity)):
        size = np.maximum(np.sqrt(square(velocity, i)), 1e-300)
        share = np.minimum(1.0, speed[i] / size)
        result[i, 0], result[i, 1] = velocity[i, 0] * share, velocity[i, 1] * share
    return result


def greatest(velocity):
    """Return the greatest length [m/s] of ``velocity`` (n, 2), 0 for none."""
    most = 0.0
    for i in range(len(velocity)):
        most = np.maximum(most, np.sqrt(square(velocity, i)))
    return most


def nearest(wanted, points, terms, bounds, speed):
    """Return the velocities (n, 2) nearest to ``wanted``, as ``safe_velocities`` does.

    And the rows of all pairs of points that are closer than so many metres, (m,) and (m,), and these.
    """
    distance, (least, largest, latest, slowest), period, slowness, waits = terms
    accuracy = LEAST, TOLERANCE, (RESIDUAL, ASTRAY, ELIMINATED), STEPS, (FIRST, SWEEPS)
    fastest, n = FASTER * greatest(wanted), len(wanted)
    within = most_distant(fastest, least, largest, period, GAMMA, latest, slowest)
    while True:
        given = distance, period, slowness, waits
        first, second, side, limit = constraints(points, given, within, bounds)
        around = bounds[1], bounds[2], bounds[3]
        seen = wanted, points, distance, first, second, limit
        near, share = heeded(*seen, HEEDS, around, LITTLE / SWIRL)
        if near.any():
            aside, rows = turned_aside(wanted, share), (first, second, side, limit)
            velocity, pressure = solve(aside, *rows, len(bounds[2]), near, speed, accuracy)
            velocity = scaled(velocity, feasible_share(pressure, limit))
        else:
            velocity = capped(wanted, speed) if len(speed) else wanted
        m = len(limit) - len(bounds[2])
        within = np.inf if m == n * (n - 1) // 2 else within  # all pairs
        if within == np.inf or not breaks(velocity, points, given, within, fastest, terms[1]):
            return velocity, (first[:m], second[:m], within)
        within = np.inf


def breaks(velocity, points, terms, within, fastest, ends):
    """Return what ``nearest_velocities._breaks`` does of ``velocity`` (n, 2)."""
    faster, (least, largest, latest, slowest) = greatest(velocity), ends
    if not faster > fastest:
        return False
    (distance, period, slowness, waits), count = terms, 0
    wider = most_distant(faster, least, largest, period, GAMMA, latest, slowest)
    first, second = near_pairs(points, wider * wider)
    rows = first, second, distance, (period, GAMMA), slowness, waits
    side, limit = pair_rows(points, points, NONE, *rows)
    pressure = np.empty(len(first))
    press(velocity.T, (first, second, side, 0), pressure)
    for k in range(len(first)):
        i, j = first[k], second[k]
        x, y = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
        count += (x * x + y * y >= within * within) & (pressure[k] > limit[k])
    return count > 0


def constraints(points, terms, within, bounds):
    """Return the columns of rows of pairs closer than ``within`` [m], and of ``bounds`` after them."""
    distance, period, slowness, waits = terms
    robot, way_out, gap, _ = bounds
    first, second = near_pairs(points, within * within)
    times = period, GAMMA
    side, limit = pair_rows(points, points, NONE, first, second, distance, times, slowness, waits)
    if not len(gap):
        return first, second, side, limit
    pairs, m, rate = len(first), len(first) + len(gap), min(FIXED_RATE, 1.0 / period)
    i, j = np.empty(m, np.int64), np.empty(m, np.int64)
    sides, limits = np.empty((2, m)), np.empty(m)
    i[:pairs], j[:pairs], sides[:, :pairs], limits[:pairs] = first, second, side, limit
    i[pairs:], j[pairs:], sides[:, pairs:], limits[pairs:] = robot, robot, way_out.T, rate * gap
    return i, j, sides, limits


def scaled(velocity, share):
    """Return ``velocity`` (n, 2) times ``share``."""
    result = np.empty(velocity.shape)
    for i in range(len(velocity)):
        result[i, 0], result[i, 1] = velocity[i, 0] * share, velocity[i, 1] * share
    return result


def turned_aside(wanted, share):
    """Return ``wanted`` (n, 2) turned by ``share`` (n,) [-] of ``SWIRL``."""
    angle, cos, sin = np.empty(len(share)), np.empty(len(share)), np.empty(len(share))
    for i in range(len(share)):
        angle[i] = SWIRL * share[i]
    cosines(angle, cos)
    sines(angle, sin)
    result = np.empty(wanted.shape)
    for i in range(len(share)):
        result[i, 0] = cos[i] * wanted[i, 0] - sin[i] * wanted[i, 1]
        result[i, 1] = sin[i] * wanted[i, 0] + cos[i] * wanted[i, 1]
    return result


def turned_away(command, given, wanted, velocity, speed, cos, sin, lead, top, passed):
    """Fill ``passed`` (2, n) as ``SafetyFilter._turned_away`` returns it.

    ``given``: the velocities of the ``command``; ``velocity``: what is safe of those ``wanted``, (n, 2).
    """
    for i in range(len(wanted)):
        passed[0, i], passed[1, i] = command[0, i], command[1, i]
        x, y = velocity[i, 0], velocity[i, 1]
        changed = abs(x - wanted[i, 0]) > UNCHANGED or abs(y - wanted[i, 1]) > UNCHANGED
        if not changed and not (len(speed) and np.sqrt(square(given, i)) > speed[i]):
            continue
        along, across = cos[i] * x + sin[i] * y, (cos[i] * y - sin[i] * x) / lead
        factor = np.maximum(np.abs(along) / top[i, 0], np.abs(across) / top[i, 1])
        factor = np.maximum(factor, 1.0)
        passed[0, i], passed[1, i] = along / factor, across / factor


def foreseen(known, top, rates):
    """Return the inner states (n, 2) and the speeds (n,) [m/s] now, as ``WayOut`` knows them."""
    inner, command, speeds, seconds = known[:4]
    if seconds < 0.0:
        return np.zeros(inner.shape), np.zeros(len(speeds))
    if seconds == 0.0:
        return inner, speeds
    target = aimed(command, top)
    after, faster = followed(inner, target, rates, seconds), np.empty(len(inner))
    for i in range(len(inner)):
        faster[i] = np.sqrt(after[i, 0] * after[i, 0])
    return after, faster


def aimed(command, top):
    """Return the ``command`` (2, n) clipped, as the firmware does, (n, 2)."""
    target = np.empty(top.shape)
    for axis in range(len(command)):
        for i in range(len(top)):
            value, most = command[axis, i], top[i, axis]
            value = -most if value < -most else value
            target[i, axis] = most if value > most else value
    return target


def braking_ways(command, speeds, fastest, period, slowness, late):
    """Return how far (n,) [m] robots get until they stand, as ``WayOut._ways``."""
    ways = np.empty(len(speeds))
    for i in range(len(ways)):
        v = np.minimum(np.maximum(speeds[i], np.sqrt(command[0, i] * command[0, i])), fastest[i])
        way = v * (period + late[i]) + 0.5 * v * v * slowness[i]
        ways[i] = way + EXACT + LATE * period * v
    return ways


def meeting(pose, radii, ways, lead, pairs):
    """Return the rows of pairs that may meet, (p,) and (p,), as ``WayOut._near``.

    Among ``pairs``, those of points a ``lead`` [m] before the centres, where no other may meet.
    """
    (first, second, within), reach, count = pairs, radii + ways, 0
    if 2.0 * (reach.max() + np.abs(lead)) + EXACT > within:
        bound = 2.0 * reach.max() + EXACT
        first, second = near_pairs(pose[:2].T, bound * bound)
    i, j = np.empty_like(first), np.empty_like(first)
    for p in range(len(first)):
        i[count], j[count] = first[p], second[p]
        x, y = pose[0, first[p]] - pose[0, second[p]], pose[1, first[p]] - pose[1, second[p]]
        own = reach[first[p]] + reach[second[p]]
        count += x * x + y * y < 1.001 * own * own  # few are near enough for a root
    close, count = count, 0
    for p in range(close):
        x, y = pose[0, i[p]] - pose[0, j[p]], pose[1, i[p]] - pose[1, j[p]]
        i[count], j[count] = i[p], j[p]
        count += np.sqrt(x * x + y * y) < reach[i[p]] + reach[j[p]]
    return i[:count], j[:count]


def spreads(command, states, radii, times):
    """Return how far (3, n) [m] robots may get ahead, back, and beside the line on which they stand.

    Whatever of a ``command`` (2, n) they obey before they brake, and with the room that ``let`` gives them:
    bounds of what ``roll`` finds, by the greatest speeds, turns and intervals.
    """
    inner, top, rates = states
    period, _, instants, brakes = times
    n, most, held = len(radii), 0.0, np.empty((2, len(radii)))
    target, found = aimed(command, top), np.empty((3, n))
    for i in range(n):
        for axis in range(2):
            held[axis, i] = max(abs(inner[i, axis]), abs(target[i, axis]))
            most = max(most, held[axis, i] / rates[i, axis])
    longest_step = period / len(instants)
    for k in range(len(brakes)):
        longest_step = max(longest_step, most * (brakes[k] - (brakes[k - 1] if k else 0.0)))
    for i in range(n):
        v, omega = held[0, i], held[1, i]
        way = v * period + 0.5 * v * v / rates[i, 0]
        bent = omega * period + 0.5 * omega * omega / rates[i, 1]
        slower = min(rates[i, 0] * longest_step, 2.0 * v)
        aside = 0.25 * longest_step * (slower + v * bent + slower * bent)
        aside += 0.375 * longest_step * longest_step * v * omega
        found[0, i] = way if inner[i, 0] > 0.0 or target[i, 0] > 0.0 else 0.0
        found[1, i] = way if inner[i, 0] < 0.0 or target[i, 0] < 0.0 else 0.0
        found[2, i] = radii[i] + aside + EXACT + LATE * period * v + way * bent + ROUNDED
    return found


def approaching(pose, cos, sin, spread, first, second):
    """Return those of the pairs ``first`` and ``second`` (p,) that may come near enough to touch.

    Others stay apart along the line through their centres, by ``spread`` (3, n) of :func:`spreads`.
    """
    i, j, count = np.empty_like(first), np.empty_like(second), 0
    for p in range(len(first)):
        a, b = first[p], second[p]
        x, y = pose[0, a] - pose[0, b], pose[1, a] - pose[1, b]
        own, other = (
            -(x * cos[a] + y * sin[a]),
            x * cos[b] + y * sin[b],
        )  # cosines, times the distance
        own = max(own * spread[0, a], -own * spread[1, a])
        other = max(other * spread[0, b], -other * spread[1, b])
        square, beside = x * x + y * y, spread[2, a] + spread[2, b]
        i[count], j[count] = a, b
        count += square - own - other <= beside * np.sqrt(square)
    return i[:count], j[:count]


def let(command, pose, states, radii, times, first, second):
    """Let ``command`` (2, n) be what of it leaves a way out, as ``WayOut._let`` does without obstacles.

    Courses that stay the same are not computed again, nor is whether robots on two of these touch.
    """
    inner, top, rates = states
    period, columns, instants, brakes = times
    n, before, count = len(radii), -1.0, len(instants) + len(brakes)
    level, renewed, near = np.zeros(n, np.int64), np.ones(n, np.bool_), np.zeros(n, np.bool_)
    for p in range(len(first)):
        near[first[p]] = near[second[p]] = True
    given, still = command.copy(), np.zeros((n, 2))
    east, north = np.empty((n, count + 1)), np.empty((n, count + 1))
    room, fast, start = np.empty((n, count)), np.empty(n), np.ascontiguousarray(pose[:2].T)
    reach = np.empty((n, count))
    while True:
        slow_down(given, level, renewed, command)
        target = aimed(command, top)
        held = followed(inner, target, rates, period)
        most = max(longest(held, still, rates), SHORTEST)
        if most != before:  # which all courses' instants hang on
            for i in range(n):
                renewed[i] = near[i]
        before = most
        then, steps = braking(instants, period, most, brakes)
        own, found = (inner, target, held, still), (east, north, room, fast)
        roll(own, rates, columns, pose[2], start, (instants, then, steps), renewed, found)
        widen(room, radii, fast, period, renewed)
        surround(east, north, room, renewed, reach)
        if not stop(level, renewed, east, north, room, reach, first, second):
            return


def slow_down(given, level, renewed, command):
    """Let ``command`` (2, n) of robots that are ``renewed`` be the ``given`` one at their ``level``."""
    for i in range(len(level)):
        if renewed[i] and level[i] == BRAKES:
            command[0, i] = command[1, i] = 0.0
        elif renewed[i]:
            command[0, i] = given[0, i] * SLOWER[level[i]]


def braking(instants, period, most, brakes):
    """Return the instants (b,) [s] of braking for ``most`` [s], by ``brakes`` (b,), and all intervals.

    These, (k,) [s], lead up to ``instants`` and, from the ``period`` on, to those of braking.
    """
    before, steps, held = 0.0, np.empty(len(instants) + len(brakes)), len(instants)
    then = np.empty(len(brakes))
    for k in range(len(steps)):
        time = instants[k] if k < held else period + most * brakes[k - held]
        if k >= held:
            then[k - held] = most * brakes[k - held]
        steps[k], before = time - before, time
    return then, steps


def widen(aside, radii, fast, period, renewed):
    """Let ``aside`` (n, k) [m] be what robots fill beside their courses, of those that are ``renewed``."""
    for i in range(len(radii)):
        if renewed[i]:
            for k in range(aside.shape[1]):
                aside[i, k] = radii[i] + (aside[i, k] + EXACT + LATE * period * fast[i])


def surround(east, north, room, renewed, reach):
    """Let ``reach`` (n, k) [m] be how far robots that are ``renewed`` get from where intervals begin."""
    for i in range(len(room)):
        if renewed[i]:
            x, y, own = east[i], north[i], reach[i]
            for k in range(len(own)):
                move_x, move_y = x[k + 1] - x[k], y[k + 1] - y[k]
                own[k] = room[i, k] + np.sqrt(move_x * move_x + move_y * move_y) + ROUNDED


def stop(level, renewed, east, north, room, reach, first, second):
    """Raise the ``level`` (n,) of robots of pairs that may touch; return whether any was raised.

    ``renewed`` (n,): robots whose pairs are looked at, and on return those whose level was raised;
    ``reach`` (n, k) [m]: as :func:`surround` has it.
    """
    n = len(level)
    stops = np.zeros(n, np.bool_)
    for p in range(len(first)):
        i, j = first[p], second[p]
        if not (renewed[i] or renewed[j]) or (level[i] == BRAKES and level[j] == BRAKES):
            continue
        if stops[i] and stops[j]:
            continue
        near = 0
        for k in range(reach.shape[1]):
            x, y, both = (
                east[i, k] - east[j, k],
                north[i, k] - north[j, k],
                reach[i, k] + reach[j, k],
            )
            near += x * x + y * y < both * both
        if near and touch(east, north, room, i, j):  # only then may they touch
            stops[i] = stops[j] = True
    raised = False
    for i in range(n):
        renewed[i] = stops[i] and level[i] < BRAKES
        if renewed[i]:
            level[i] += 1
        raised |= stops[i]
    return raised


def held_still(wanted, done, points, distance):
    """Return which robots are held, (n,) bool, as ``deadlock_detector.held_still``."""
    n = len(wanted)
    held, goes = np.empty(n, np.bool_), np.empty(n, np.bool_)
    for i in range(n):
        asked, left = np.sqrt(square(wanted, i)), np.sqrt(square(done, i))
        held[i] = asked >= MOVES and left < HELD * asked
        goes[i] = left >= np.maximum(MOVES, HELD * asked)
    for i in range(n):
        if not held[i]:
            continue
        for j in range(n):
            x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            kept = distance[i, j] if len(distance) > 1 else distance[0, 0]
            if goes[j] and np.sqrt(x * x + y * y) < NEARBY * kept:
                held[i] = False
                break
    return held


def note_held(held, since, time):
    """Note in ``since`` (n,) which robots are ``held`` still, (n,) bool, at ``time`` [s], as
    ``DeadlockDetector.note``."""
    for i in range(len(held)):
        known = since[i] <= time  # else it was not held, or time went back
        since[i] = (since[i] if known else time) if held[i] else np.nan


@functools.lru_cache(maxsize=None)
def compiled_passing():
    """Return ``pass_all``, compiled; ``ValueError`` without numba."""
    return kept(pass_all)
