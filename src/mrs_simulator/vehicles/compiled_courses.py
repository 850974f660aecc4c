"""Predicted courses by loops that numba compiles, robot by robot, with results equal to the bit.

They do numpy's operations of ``courses`` in numpy's order; sines and cosines are numpy's own loops'.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_terms import kept
from mrs_simulator.core.compiling import inlined


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

    Instant by instant, all r robots at each, so that loops use the processor's vectors.
    """
    inner, target, held, still = states
    first, then, steps = times
    east, north, aside, fastest = found
    rows = np.flatnonzero(renewed)
    holding, count, r = len(first), len(steps), len(rows)
    mean, ends = np.zeros((3, count, r)), np.zeros((3, count + 1, r))
    angles, column = np.empty((6, count, r)), np.empty((3, r))
    for axis in range(len(columns)):
        at = columns[axis]
        gather(inner, target, rates, rows, axis, column)
        ends[at, 0] = column[0]
        ramp(column, first, mean[at], ends[at, 1:])
        gather(held, still, rates, rows, axis, column)
        ramp(column, then, mean[at, holding:], ends[at, holding + 1 :])
    turn(mean[2], heading[rows], steps, angles)
    move(mean, steps, angles, start, rows, east, north)
    bend(ends, steps, angles[0], holding, rows, aside, fastest)


@inlined
def gather(begin, end, rates, rows, axis, column):
    """Fill ``column`` (3, r) with what the robots ``rows`` (r,) have along an ``axis``."""
    for k in range(len(rows)):
        column[0, k], column[1, k] = begin[rows[k], axis], end[rows[k], axis]
        column[2, k] = rates[rows[k], axis]


def ramp(column, times, mean, after):
    """Fill ``mean`` and ``after`` (k, r) along one axis as ``courses.ramps`` returns them.

    ``column`` (3, r): inner states, those aimed at, and rates.
    """
    ways, before = np.zeros(column.shape[1]), 0.0
    for k in range(len(times)):
        reach(column[0], column[1], column[2], times[k], after[k])
        travel(column[0], column[1], column[2], times[k], times[k] - before, ways, mean[k])
        before = times[k]


@inlined
def reach(inner, target, rate, time, after):
    """Fill ``after`` (r,) with the states at ``time`` [s]."""
    for r in range(len(inner)):
        change = target[r] - inner[r]
        after[r] = inner[r] + np.copysign(np.minimum(rate[r] * time, np.abs(change)), change)


@inlined
def travel(inner, target, rate, time, step, ways, mean):
    """Fill ``mean`` (r,) over the ``step`` [s] up to ``time`` [s]; ``ways`` (r,) are those to its end."""
    for r in range(len(inner)):
        change = target[r] - inner[r]
        size = np.abs(change)
        spent = np.minimum(time, size / rate[r])
        area = size * spent - 0.5 * (0.0 if np.isinf(rate[r]) else rate[r]) * spent * spent
        way = target[r] * time - np.copysign(area, change)
        mean[r] = (way - ways[r]) / step
        ways[r] = way


def turn(omega, heading, steps, angles):
    """Fill ``angles`` (6, k, r): turns, middle headings, what sines are taken of for shorter ways, [rad],
    and cosine and sine of the second, sine of the third."""
    total, of, size, turned = np.zeros(len(heading)), angles.reshape(-1), angles[0].size, 0
    for k in range(len(steps)):
        turns, middle, short, odd = angles[0, k], angles[1, k], angles[2, k], 0
        for r in range(len(heading)):
            own = omega[k, r] * steps[k]
            total[r] += own
            share = own / (2.0 * np.pi)
            turns[r], middle[r] = own, heading[r] + total[r] - 0.5 * own
            short[r] = np.pi * (1e-20 if share == 0.0 else share)
            odd += share != 0.0
        turned = k + 1 if odd else turned
    last = min(turned, len(steps) - 1)  # from where on angles stay the same
    some = (last + 1) * len(heading)
    cosines(of[size : size + some], of[3 * size : 3 * size + some])
    sines(of[size : size + some], of[4 * size : 4 * size + some])
    sines(of[2 * size : 2 * size + some], of[5 * size : 5 * size + some])
    for k in range(last + 1, len(steps)):
        for axis in range(3, 6):
            angles[axis, k] = angles[axis, last]


def move(mean, steps, angles, start, rows, east, north):
    """Fill ``east`` and ``north`` (m, k + 1) [m] of ``rows`` (r,) with places from ``start`` (m, 2) on."""
    way = np.zeros((2, len(rows)))
    for r in range(len(rows)):
        east[rows[r], 0], north[rows[r], 0] = start[rows[r], 0], start[rows[r], 1]
    for k in range(len(steps)):
        go(mean[0, k], mean[1, k], angles, k, steps[k], way[0], way[1])
        for r in range(len(rows)):
            i = rows[r]
            east[i, k + 1], north[i, k + 1] = start[i, 0] + way[0, r], start[i, 1] + way[1, r]


@inlined
def go(ahead, across, angles, k, step, along, up):
    """Let ``along`` and ``up`` (r,) [m] grow by the ways of the k-th ``step`` [s]."""
    short, cos, sin, sines = angles[2, k], angles[3, k], angles[4, k], angles[5, k]
    for r in range(len(along)):
        shrink = sines[r] / short[r] * step
        along[r] += shrink * (cos[r] * ahead[r] - sin[r] * across[r])
        up[r] += shrink * (sin[r] * ahead[r] + cos[r] * across[r])


def bend(ends, steps, turns, holding, rows, aside, fastest):
    """Fill ``aside`` (m, k) [m] of ``rows`` (r,) as ``courses._rolled`` does, and ``fastest`` (m,) with the
    top speeds under the command.

    ``ends`` (3, k + 1, r): velocities at the ends of intervals, ``holding`` of which are the command's.
    """
    speed, wrong, own = (
        np.empty((len(steps) + 1, len(rows))),
        np.zeros(len(rows)),
        np.empty(len(rows)),
    )
    for k in range(len(speed)):
        level(ends[0, k], ends[1, k], speed[k])
    for k in range(len(steps)):
        stray(ends, speed, k, turns[k], steps[k], wrong, own)
        for r in range(len(rows)):
            aside[rows[r], k] = own[r]
    for r in range(len(rows)):
        most = speed[0, r]
        for k in range(holding):
            most = np.maximum(most, speed[k + 1, r])
        fastest[rows[r]] = most


@inlined
def level(ahead, across, speed):
    """Fill ``speed`` (r,) [m/s] with that in the plane of velocities ``ahead`` and ``across``."""
    for r in range(len(speed)):
        speed[r] = np.sqrt(ahead[r] * ahead[r] + across[r] * across[r])


@inlined
def stray(ends, speed, k, turns, step, wrong, aside):
    """Fill ``aside`` (r,) [m] over the k-th ``step`` [s]; let ``wrong`` (r,) [m] grow by what chords take
    for granted."""
    before, after = speed[k], speed[k + 1]
    ahead, across, spin = ends[0, k], ends[1, k], ends[2, k]
    next_ahead, next_across, next_spin = ends[0, k + 1], ends[1, k + 1], ends[2, k + 1]
    for r in range(len(aside)):
        east, north = next_ahead[r] - ahead[r], next_across[r] - across[r]
        slower, bent = np.sqrt(east * east + north * north), np.abs(turns[r])
        most, change = np.maximum(after[r], before[r]), np.abs(next_spin[r] - spin[r])
        wrong[r] += step * (0.25 * slower * bent + 0.125 * step * most * change)
        aside[r] = 0.25 * step * (slower + most * bent) + wrong[r]


@functools.lru_cache(maxsize=None)
def compiled_courses():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(kept(each) for each in plain_courses()))


def plain_courses():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(followed, longest, roll)
