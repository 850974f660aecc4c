"""Predicted courses by loops that numba compiles, robot by robot, with results equal to the bit.

They do numpy's operations of ``courses`` in numpy's order; sines and cosines are numpy's own loops'.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_terms import kept


class Loops(NamedTuple):
    """The loops, compiled or not."""

    followed: Any
    longest: Any
    roll: Any


def followed(inner, target, rates, seconds):
    """Return the inner states (m, a) after ``seconds`` from ``inner`` to ``target`` at ``rates``."""
    after = np.empty(inner.shape)
    for i in range(len(inner)):
        for axis in range(inner.shape[1]):
            change = target[i, axis] - inner[i, axis]
            reach = np.minimum(rates[i, axis] * seconds, np.abs(change))
            after[i, axis] = inner[i, axis] + np.copysign(reach, change)
    return after


def longest(inner, still, rates):
    """Return the greatest time [s] from ``inner`` to ``still`` (m, a) at ``rates``."""
    most = 0.0
    for i in range(len(inner)):
        for axis in range(inner.shape[1]):
            most = np.maximum(most, np.abs(inner[i, axis] - still[i, axis]) / rates[i, axis])
    return most


def roll(states, rates, columns, heading, start, times, renewed, found):
    """Fill ``found`` with the courses of the robots that are ``renewed``, (m,) bool.

    ``states``: inner ones (m, a) at first, those aimed at, those when the command ends, and at rest;
    ``columns`` (a,): which of ``PLANAR`` their axes are; ``heading`` (m,) [rad] and ``start`` (m, 2) [m];
    ``times``: instants of the command, those of braking after it, and all intervals, [s].
    ``found``: x and y (m, k + 1) [m], how far motion is aside (m, k) [m], and top speeds (m,) [m/s] under
    the command, as ``Courses.course`` has them.
    """
    inner, target, held, still = states
    first, then, steps = times
    east, north, aside, fastest = found
    holding, count = len(first), len(steps)
    mean, ends, angles = np.zeros((3, count)), np.zeros((3, count + 1)), np.empty((6, count))
    for i in range(len(heading)):
        if not renewed[i]:
            continue
        for axis in range(len(columns)):
            at, rate = columns[axis], rates[i, axis]
            ends[at, 0] = inner[i, axis]
            ramp(inner[i, axis], target[i, axis], rate, first, mean[at], ends[at, 1:])
            braking = mean[at, holding:], ends[at, holding + 1 :]
            ramp(held[i, axis], still[i, axis], rate, then, *braking)
        turn(mean[2], heading[i], steps, angles)
        move(mean, steps, angles, start[i, 0], start[i, 1], east[i], north[i])
        fastest[i] = bend(ends, steps, angles[0], holding, aside[i])


def ramp(inner, target, rate, times, mean, after):
    """Fill ``mean`` and ``after`` (k,) along one axis as ``courses.ramps`` returns them."""
    change = target - inner
    size, ways, before = np.abs(change), 0.0, 0.0
    for k in range(len(times)):
        after[k] = inner + np.copysign(np.minimum(rate * times[k], size), change)
        spent = np.minimum(times[k], size / rate)
        area = size * spent - 0.5 * (0.0 if np.isinf(rate) else rate) * spent * spent
        way = target * times[k] - np.copysign(area, change)
        mean[k] = (way - ways) / (times[k] - before)
        ways, before = way, times[k]


def turn(omega, heading, steps, angles):
    """Fill ``angles`` (6, k): turns, middle headings, what sines are taken of for shorter ways, [rad], and
    cosine and sine of the second, sine of the third."""
    total = 0.0
    for k in range(len(steps)):
        own = omega[k] * steps[k]
        total += own
        share = own / (2.0 * np.pi)
        angles[0, k], angles[1, k] = own, heading + total - 0.5 * own
        angles[2, k] = np.pi * (1e-20 if share == 0.0 else share)
    of, count = angles.reshape(-1), len(steps)
    cosines(angles[1], angles[3])
    sines(of[count : 3 * count], of[4 * count :])


def move(mean, steps, angles, x, y, east, north):
    """Fill ``east`` and ``north`` (k + 1,) [m] with the places at which a robot gets from (x, y)."""
    along, up = 0.0, 0.0
    east[0], north[0] = x, y
    for k in range(len(steps)):
        shrink = angles[5, k] / angles[2, k] * steps[k]
        cos, sin, ahead, across = angles[3, k], angles[4, k], mean[0, k], mean[1, k]
        along += shrink * (cos * ahead - sin * across)
        up += shrink * (sin * ahead + cos * across)
        east[k + 1], north[k + 1] = x + along, y + up


def bend(ends, steps, turns, holding, aside):
    """Fill ``aside`` (k,) [m] as ``courses._rolled`` does; return the top speed [m/s] under the command.

    ``ends`` (3, k + 1): velocities at the ends of intervals, ``holding`` of which are the command's.
    """
    wrong, fast = 0.0, level(ends, 0)
    fastest = fast
    for k in range(len(steps)):
        east, north = ends[0, k + 1] - ends[0, k], ends[1, k + 1] - ends[1, k]
        slower, bent = np.sqrt(east * east + north * north), np.abs(turns[k])
        before, fast = fast, level(ends, k + 1)
        most, change = np.maximum(fast, before), np.abs(ends[2, k + 1] - ends[2, k])
        wrong += steps[k] * (0.25 * slower * bent + 0.125 * steps[k] * most * change)
        aside[k] = 0.25 * steps[k] * (slower + most * bent) + wrong
        if k < holding:
            fastest = np.maximum(fastest, fast)
    return fastest


def level(ends, k):
    """Return the speed [m/s] in the plane at the k-th of ``ends`` (3, k)."""
    return np.sqrt(ends[0, k] * ends[0, k] + ends[1, k] * ends[1, k])


@functools.lru_cache(maxsize=None)
def compiled_courses():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(kept(each) for each in plain_courses()))


def plain_courses():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(followed, longest, roll)
