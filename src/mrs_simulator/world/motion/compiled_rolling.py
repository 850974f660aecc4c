"""``rolling.rolled`` by loops that numba compiles, robot by robot, with results equal to the bit.

They do numpy's operations in numpy's order; sines and cosines stay numpy's, whose last bits differ from
those of the C library.
"""

import functools
import math

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit
from mrs_simulator.core.kinematics import cos_sin, displaced
from mrs_simulator.world.motion import rolling
from mrs_simulator.world.motion.planar_body import TINY
from mrs_simulator.world.motion.rolling import ROLLS, SWEEPS

MASS, INERTIA, AHEAD, HEIGHT, HALF, LOAD, SHIFT = range(7)  # rows of a table of ``Wheels``
FRICTION, FORCE = 9, 10


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


@functools.lru_cache(maxsize=None)
def kernels():
    """Return ``push_all`` and ``carry_all``, compiled; ``ValueError`` without numba."""
    return linked(push_all, jit(cache=True)), linked(carry_all, jit(cache=True))


def compiled_rolled():
    """Return the compiled twin of ``rolling.rolled``; ``ValueError`` without numba."""
    return functools.partial(rolled_by, kernels())


def rolled_by(loops, wheels, pose, twist, rims, step, substeps):
    """As ``rolling.rolled``, by the ``loops`` ``push_all`` and ``carry_all``."""
    duration, m = step / substeps, len(pose)
    held = rolling.held_twists(wheels, rims)
    slides, tips = np.empty(m, dtype=bool), np.zeros(m, dtype=bool)
    given = np.array(wheels), rolling.at_mass(wheels, twist), rolling.at_mass(wheels, held), rims
    loops[0](*given, _turns(given[1], duration), duration, np.empty((4, m)), slides, False)
    turned, after = step * rims, displaced(pose, held, step)
    if slides.any():
        rows = np.flatnonzero(slides)
        own = wheels.of(rows), pose[rows], twist[rows], held[rows], rims[:, rows]
        moved = _slid(loops, *own, duration, substeps)
        after[rows], held[rows], turned[:, rows], tips[rows] = moved
    return after, held, turned, tips


def _slid(loops, wheels, pose, twist, held, rims, duration, substeps):
    """As ``rolling._slid``, by the ``loops``."""
    push, carry = loops
    held, velocity = rolling.at_mass(wheels, held), rolling.at_mass(wheels, twist)
    place, theta, m = rolling.mass_centre(wheels, pose), pose[:, 2].copy(), len(pose)
    turned, pushed, slides = np.zeros((2, m)), np.zeros((2, m)), np.empty(m, dtype=bool)
    table, pushes, rims = np.array(wheels), np.empty((4, m)), np.ascontiguousarray(rims)
    for _ in range(substeps):
        turns = _turns(velocity, duration)
        push(table, velocity, held, rims, turns, duration, pushes, slides, True)
        ways = np.stack(cos_sin(rolling.ways(theta, slides, velocity, duration)))
        carry(table, velocity, rims, ways, duration, pushes, place, theta, turned, pushed)
    pose, twist = rolling.of_axle(wheels, place, theta, velocity)
    return pose, twist, turned, rolling.who_tips(wheels, *(pushed / (substeps * duration)))


def _turns(velocity, duration):
    """Return cosine and sine, (2, m), of how far robots turn at ``velocity`` (m, 3) in ``duration``."""
    return np.stack(cos_sin(duration * velocity[:, 2]))
