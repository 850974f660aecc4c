"""Predicted courses by loops that numba compiles, robot by robot, with results equal to the bit.

They do numpy's operations of ``courses`` in numpy's order; sines and cosines stay numpy's.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit


class Loops(NamedTuple):
    """The loops, compiled or not."""

    ramp: Any
    longest: Any
    turn: Any
    roll: Any


def ramp(inner, target, rates, times, columns, mean, after):
    """Fill ``mean`` and ``after`` (k, m, 3) as ``Courses._phase``, along the PLANAR axes ``columns`` (a,).

    ``inner``, ``target``, ``rates`` (m, a).  Returns the inner states (m, a) at the last of ``times`` (k,).
    """
    last, ways, before = np.empty_like(inner), np.zeros(inner.shape), 0.0
    mean[:], after[:] = 0.0, 0.0
    for k in range(len(times)):
        step = times[k] - before
        for i in range(len(inner)):
            for axis in range(len(columns)):
                change, rate = target[i, axis] - inner[i, axis], rates[i, axis]
                size = np.abs(change)
                reach = np.copysign(np.minimum(rate * times[k], size), change)
                last[i, axis] = inner[i, axis] + reach
                spent = np.minimum(times[k], size / rate)
                area = size * spent - 0.5 * (0.0 if np.isinf(rate) else rate) * spent * spent
                way = target[i, axis] * times[k] - np.copysign(area, change)
                mean[k, i, columns[axis]] = (way - ways[i, axis]) / step
                after[k, i, columns[axis]] = last[i, axis]
                ways[i, axis] = way
        before = times[k]
    return last


def longest(inner, still, rates):
    """Return the greatest time [s] from ``inner`` to ``still`` (m, a) at ``rates``."""
    most = 0.0
    for i in range(len(inner)):
        for axis in range(inner.shape[1]):
            most = np.maximum(most, np.abs(inner[i, axis] - still[i, axis]) / rates[i, axis])
    return most


def turn(mean, heading, steps):
    """Return turns, middle headings and what sines are taken of for shorter ways, (3, k, m) [rad]."""
    angles = np.empty((3,) + mean.shape[:2])
    for i in range(mean.shape[1]):
        total = 0.0
        for k in range(len(steps)):
            own = mean[k, i, 2] * steps[k]
            total += own
            share = own / (2.0 * np.pi)
            angles[0, k, i], angles[1, k, i] = own, heading[i] + total - 0.5 * own
            angles[2, k, i] = np.pi * (1e-20 if share == 0.0 else share)
    return angles


def roll(mean, ends, steps, angles, turned, start, holding):
    """Return places (k + 1, m, 2) [m], how far motion is aside (k, m) [m] and top speeds (m,) [m/s].

    As ``courses._rolled`` and ``Courses.course``; ``angles`` as ``turn`` returns them, ``turned``
    (3, k, m): cosine and sine of the second, sine of the third; ``holding``: intervals of the command.
    """
    place, aside = np.empty((len(steps) + 1, len(start), 2)), np.empty(mean.shape[:2])
    fastest = np.empty(len(start))
    for i in range(len(start)):
        wrong, x, y, fast = 0.0, 0.0, 0.0, level(ends, 0, i)
        place[0, i, 0], place[0, i, 1] = start[i, 0], start[i, 1]
        fastest[i] = fast
        for k in range(len(steps)):
            shrink = turned[2, k, i] / angles[2, k, i] * steps[k]
            cos, sin, ahead, across = turned[0, k, i], turned[1, k, i], mean[k, i, 0], mean[k, i, 1]
            x += shrink * (cos * ahead - sin * across)
            y += shrink * (sin * ahead + cos * across)
            place[k + 1, i, 0], place[k + 1, i, 1] = start[i, 0] + x, start[i, 1] + y
            east, north = ends[k + 1, i, 0] - ends[k, i, 0], ends[k + 1, i, 1] - ends[k, i, 1]
            slower, bent = np.sqrt(east * east + north * north), np.abs(angles[0, k, i])
            before, fast = fast, level(ends, k + 1, i)
            most = np.maximum(fast, before)
            change = np.abs(ends[k + 1, i, 2] - ends[k, i, 2])
            wrong += steps[k] * (0.25 * slower * bent + 0.125 * steps[k] * most * change)
            aside[k, i] = 0.25 * steps[k] * (slower + most * bent) + wrong
            if k < holding:
                fastest[i] = np.maximum(fastest[i], fast)
    return place, aside, fastest


def level(ends, k, i):
    """Return the speed [m/s] in the plane of robot ``i`` at the k-th of ``ends`` (k, m, 3)."""
    return np.sqrt(ends[k, i, 0] * ends[k, i, 0] + ends[k, i, 1] * ends[k, i, 1])


@functools.lru_cache(maxsize=None)
def compiled_courses():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(linked(each, jit(cache=True)) for each in plain_courses()))


def plain_courses():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(ramp, longest, turn, roll)
