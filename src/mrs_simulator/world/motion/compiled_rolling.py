"""``rolling.rolled`` by loops that numba compiles, robot by robot, with results equal to the bit.

They do numpy's operations in numpy's order; sines and cosines stay numpy's, whose last bits differ from
those of the C library.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_terms import kept
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.world.motion import rolling
from mrs_simulator.world.motion.compiled import carry_all as carry_along
from mrs_simulator.world.motion.planar_body import TINY
from mrs_simulator.world.motion.rolling import ROLLS, SWEEPS

MASS, INERTIA, AHEAD, HEIGHT, HALF, LOAD, SHIFT = range(7)  # rows of a table of ``Wheels``
FRICTION, FORCE = 9, 10
TABLES = 16  # [-] of wheels that are kept


def circles(wheels, i, ahead, aside, duration):
    """Return the greatest impulses [N s] of the ground at both wheels of robot ``i``, as ``_circles``."""
    rate = 1.0 / duration
    both = max(wheels[LOAD, i] - wheels[SHIFT, i] * (rate * ahead), 0.0)
    left = 0.5 * both - 0.5 * wheels[HEIGHT, i] / wheels[HALF, i] * (rate * aside)
    left = min(max(left, 0.0), both)
    most = duration * wheels[FRICTION, i]
    return most * left, most * (both - left)


def bounded(p, q, most, circle):
    """Return impulses of a wheel brought back to what its motor and ``circle`` allow, as ``_bounded``."""
    p = min(max(p, -most), most)
    share = circle / max(max(math.hypot(p, q), circle), TINY)
    return share * p, share * q


def projected(wheels, i, free, left_rim, right_rim, pushes, duration):
    """Return velocity and impulses p, q of robot ``i`` in a substep, (7,), as ``_projected``.

    ``free`` (3,): its velocity without them; ``pushes`` (4,): those to begin with.
    """
    mass, inertia = wheels[MASS, i], wheels[INERTIA, i]
    x, y = -wheels[AHEAD, i], wheels[HALF, i]
    along = max(2.0 / mass, 2.0 * y * y / inertia)
    across = 2.0 / mass + 2.0 * x * x / inertia
    gain = 1.0 / (max(along, across) + 2.0 * (abs(x) * y / inertia))
    most = duration * wheels[FORCE, i]
    left, right = circles(wheels, i, 0.0, 0.0, duration)
    p0, q0 = bounded(pushes[0], pushes[2], most, left)
    p1, q1 = bounded(pushes[1], pushes[3], most, right)
    for sweep in range(SWEEPS + 1):
        ahead, aside = p0 + p1, q0 + q1
        vx, vy = free[0] + ahead / mass, free[1] + aside / mass
        omega = free[2] + (y * (p1 - p0) - wheels[AHEAD, i] * aside) / inertia
        if sweep == SWEEPS:
            break
        left, right = circles(wheels, i, ahead, aside, duration)
        turn, drift = y * omega, gain * (vy + x * omega)
        p0, q0 = bounded(p0 - gain * (vx - left_rim - turn), q0 - drift, most, left)
        p1, q1 = bounded(p1 - gain * (vx - right_rim + turn), q1 - drift, most, right)
    return vx, vy, omega, p0, p1, q0, q1


def push_all(wheels, velocity, held, rims, turns, duration, pushes, slides, moves):
    """Find out which of m robots slide in a substep: fills ``slides`` (m,) and, the impulses p and q,
    ``pushes`` (4, m).

    ``wheels`` (11, m); ``velocity`` (m, 3) of the centres of mass, which becomes that afterwards if
    ``moves``; ``held`` (m, 3): those of robots that roll; ``rims`` (2, m); ``turns`` (2, m): cosine and
    sine of how far robots turn.
    """
    free, own = np.empty(3), np.empty(4)
    for i in range(len(velocity)):
        cos, sin, mass = turns[0, i], turns[1, i], wheels[MASS, i]
        free[0] = cos * velocity[i, 0] + sin * velocity[i, 1]
        free[1] = cos * velocity[i, 1] - sin * velocity[i, 0]
        free[2] = velocity[i, 2]
        along, across = 0.5 * mass * (held[i, 0] - free[0]), 0.5 * mass * (held[i, 1] - free[1])
        turn = wheels[INERTIA, i] * (held[i, 2] - free[2]) + 2.0 * wheels[AHEAD, i] * across
        turn *= 0.5 / wheels[HALF, i]
        own[0], own[1], own[2], own[3] = along - turn, along + turn, across, across
        left, right = circles(wheels, i, own[0] + own[1], across + across, duration)
        most, square = wheels[FORCE, i] * duration, across * across
        rolls = own[0] * own[0] + square <= left * left and abs(own[0]) <= most
        rolls = rolls and own[1] * own[1] + square <= right * right and abs(own[1]) <= most
        slides[i] = not rolls
        for axis in range(3 if moves else 0):
            velocity[i, axis] = held[i, axis]
        if moves and not rolls:
            moved = projected(wheels, i, free, rims[0, i], rims[1, i], own, duration)
            velocity[i, 0], velocity[i, 1], velocity[i, 2], own[0], own[1], own[2], own[3] = moved
        for k in range(4):
            pushes[k, i] = own[k]


def carry_all(wheels, velocity, rims, turns, duration, pushes, place, theta, turned, pushed):
    """Move m robots for a substep, in place: ``place`` (m, 2) and ``theta`` (m,).

    ``turns`` (2, m): cosine and sine of their ways; added to: how far rims ``turned``, and what ``pushed``
    ahead and aside, (2, m) each.
    """
    for i in range(len(velocity)):
        cos, sin, vx, vy = turns[0, i], turns[1, i], velocity[i, 0], velocity[i, 1]
        place[i, 0] += duration * (cos * vx - sin * vy)
        place[i, 1] += duration * (sin * vx + cos * vy)
        theta[i] = theta[i] + duration * velocity[i, 2]
        most, turn = ROLLS * wheels[FORCE, i] * duration, wheels[HALF, i] * velocity[i, 2]
        turned[0, i] += duration * (vx - turn if abs(pushes[0, i]) >= most else rims[0, i])
        turned[1, i] += duration * (vx + turn if abs(pushes[1, i]) >= most else rims[1, i])
        pushed[0, i] += pushes[0, i] + pushes[1, i]
        pushed[1, i] += pushes[2, i] + pushes[3, i]


def hold_all(wheels, pose, twist, rims, step, duration, held, angles):
    """Fill ``held`` (m, 3) as ``rolling.held_twists``, and ``angles`` (3, m): how far robots turn in a
    substep, half of how far they turn in a step if they roll, and their mean headings then."""
    for i in range(len(pose)):
        held[i, 0], held[i, 1] = 0.5 * (rims[0, i] + rims[1, i]), 0.0
        held[i, 2] = 0.5 * (rims[1, i] - rims[0, i]) / wheels[HALF, i]
        half = 0.5 * (step * held[i, 2])
        angles[0, i], angles[1, i], angles[2, i] = duration * twist[i, 2], half, pose[i, 2] + half


def roll_all(wheels, pose, twist, rims, held, angles, cos, sin, step, duration, after, slides):
    """Fill ``after`` (m, 3) with the poses of robots that roll, and find out which slide, ``slides`` (m,).

    ``held`` and ``angles`` as of ``hold_all``; ``cos``, ``sin`` (3, m) of these.  Returns how many slide.
    """
    velocity, wanted, moved = twist.copy(), held.copy(), np.empty_like(held)
    turns, pushes, sliding = np.empty((2, len(pose))), np.empty((4, len(pose))), 0
    for i in range(len(pose)):
        velocity[i, 1] += wheels[AHEAD, i] * twist[i, 2]
        wanted[i, 1] += wheels[AHEAD, i] * held[i, 2]
        turns[0, i], turns[1, i] = cos[0, i], sin[0, i]
        moved[i, 0], moved[i, 1] = step * held[i, 0], step * held[i, 1]
    push_all(wheels, velocity, wanted, rims, turns, duration, pushes, slides, False)
    carry_along(pose, moved, angles[1], sin[1], cos[2], sin[2], after)
    for i in range(len(pose)):
        sliding += slides[i]
    return sliding


class Loops(NamedTuple):
    """The loops that :func:`rolled_by` calls, compiled or not."""

    hold: Any
    roll: Any
    push: Any
    carry: Any


@functools.lru_cache(maxsize=None)
def kernels():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(kept(each) for each in plain_loops()))


def plain_loops():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(hold_all, roll_all, push_all, carry_all)


def compiled_rolled():
    """Return the compiled twin of ``rolling.rolled``; ``ValueError`` without numba."""
    return functools.partial(rolled_by, kernels())


def rolled_by(loops, wheels, pose, twist, rims, step, substeps):
    """As ``rolling.rolled``, by the :class:`Loops`."""
    duration, m, rims = step / substeps, len(pose), np.ascontiguousarray(rims)
    held, after, angles = np.empty((m, 3)), np.empty((m, 3)), np.empty((3, m))
    slides, tips, table = np.empty(m, dtype=bool), np.zeros(m, dtype=bool), _table(wheels)
    loops.hold(table, pose, twist, rims, step, duration, held, angles)
    turned, times = step * rims, (step, duration)
    given = table, pose, twist, rims, held, angles, *cos_sin(angles)
    if loops.roll(*given, *times, after, slides):
        rows = np.flatnonzero(slides)
        own = wheels.of(rows), pose[rows], twist[rows], held[rows], rims[:, rows]
        moved = _slid(loops, *own, duration, substeps)
        after[rows], held[rows], turned[:, rows], tips[rows] = moved
    return after, held, turned, tips


_tables = {}  # by identity of the wheels, which are kept, too


def _table(wheels):
    """Return ``wheels`` as an array (11, m), kept for as long as robots are the same."""
    if id(wheels) not in _tables:
        if len(_tables) >= TABLES:
            _tables.clear()
        _tables[id(wheels)] = wheels, np.array(wheels)
    return _tables[id(wheels)][1]


def _slid(loops, wheels, pose, twist, held, rims, duration, substeps):
    """As ``rolling._slid``, by the :class:`Loops`."""
    held, velocity = rolling.at_mass(wheels, held), rolling.at_mass(wheels, twist)
    place, theta, m = rolling.mass_centre(wheels, pose), pose[:, 2].copy(), len(pose)
    turned, pushed, slides = np.zeros((2, m)), np.zeros((2, m)), np.empty(m, dtype=bool)
    table, pushes, rims = np.array(wheels), np.empty((4, m)), np.ascontiguousarray(rims)
    for _ in range(substeps):
        turns = _turns(velocity, duration)
        loops.push(table, velocity, held, rims, turns, duration, pushes, slides, True)
        ways = np.stack(cos_sin(rolling.ways(theta, slides, velocity, duration)))
        loops.carry(table, velocity, rims, ways, duration, pushes, place, theta, turned, pushed)
    pose, twist = rolling.of_axle(wheels, place, theta, velocity)
    return pose, twist, turned, rolling.who_tips(wheels, *(pushed / (substeps * duration)))


def _turns(velocity, duration):
    """Return cosine and sine, (2, m), of how far robots turn at ``velocity`` (m, 3) in ``duration``."""
    return np.stack(cos_sin(duration * velocity[:, 2]))
