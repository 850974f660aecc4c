"""Steps of robots that roll on two wheels under forces, one or many in one call that numba compiles.

With the bits of ``PlanarMotion``, whose steps these are as long as no robot is in the solver: the loops of
``compiled_rolling`` over its substeps, with the sines of numpy's own loops.
"""

import functools
import math

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_terms import kept as kept_kernel
from mrs_simulator.world.motion.compiled_rolling import (
    AHEAD,
    HALF,
    HEIGHT,
    LOAD,
    MASS,
    SHIFT,
    carry_all,
    hold_all,
    push_all,
    roll_all,
)
from mrs_simulator.world.motion.planar_body import GRAVITY
from mrs_simulator.world.motion.stretch_parts import (
    PI,
    TURN,
    clip,
    excesses,
    keep,
    map_all,
    place_points,
    ramp,
    saturate,
)
from mrs_simulator.world.motion.stretches import DONE, FAR, NEAR, ODD, STALE

FRONT, REAR = 7, 8  # rows of a table of ``Wheels``

term = None  # the law, compiled


def roll_step(wheels, gear, limits, times, pose, twist, inner, command, after):
    """Move m robots by a step under a ``command`` (2, m); return whether none of them tips.

    ``wheels`` (11, m): a table of ``Wheels``; ``gear`` (2, m): track and radius [m]; ``limits`` (8, m) of
    ``stretches``, of commands and their changes; ``times``: a step and a substep [s], and how many of
    these; ``pose`` and ``twist`` (m, 3), ``inner`` (2, m).  Filled: the same ``after`` it, and how far the
    wheels have turned in it, (2, m) [rad].  If one tips, that is not what comes after.
    """
    (step, duration), m = times[:2], len(pose)
    to_pose, to_twist, to_inner, turned = after
    target, spare, rims = np.empty(m), np.empty(m), np.empty((2, m))
    for axis in range(2):
        clip(command[axis], limits[axis], limits[2 + axis], target)
        most, both = limits[4 + axis], limits[6 + axis]
        ramp(target, most, both, inner[axis], to_inner[axis], spare)
    for i in range(m):
        aside = 0.5 * gear[0, i] * to_inner[1, i]
        rims[0, i] = (to_inner[0, i] - aside) / gear[1, i] * gear[1, i]
        rims[1, i] = (to_inner[0, i] + aside) / gear[1, i] * gear[1, i]
        turned[0, i], turned[1, i] = step * rims[0, i], step * rims[1, i]
    angles, cos, sin = np.empty((3, m)), np.empty((3, m)), np.empty((3, m))
    slides, stand = np.empty(m, dtype=np.bool_), True
    hold_all(wheels, pose, twist, rims, step, duration, to_twist, angles)
    for k in range(3):
        cosines(angles[k], cos[k])
        sines(angles[k], sin[k])
    roll = wheels, pose, twist, rims, to_twist, angles, cos, sin, step, duration, to_pose, slides
    if roll_all(*roll):
        rows = np.flatnonzero(slides)
        stand = slide(wheels, times, rows, pose, twist, rims, to_pose, to_twist, turned)
    for i in range(m):
        turned[0, i], turned[1, i] = turned[0, i] / gear[1, i], turned[1, i] / gear[1, i]
    return stand


def slide(wheels, times, rows, pose, twist, rims, to_pose, to_twist, turned):
    """Move those robots in ``rows`` (k,) of which wheels slide, as ``rolling._slid`` does; return whether
    none of them tips.

    ``to_twist`` (m, 3): before, the twists of robots that roll.
    """
    (duration, substeps), k = times[1:], len(rows)
    own, own_rims, held = np.empty((len(wheels), k)), np.empty((2, k)), np.empty((k, 3))
    velocity, place, theta = np.empty((k, 3)), np.empty((k, 2)), pose[:, 2][rows]
    cos, sin, angle = np.empty(k), np.empty(k), np.empty(k)
    cosines(theta, cos)
    sines(theta, sin)
    for i in range(k):
        row = rows[i]
        for column in range(len(wheels)):
            own[column, i] = wheels[column, row]
        ahead = own[AHEAD, i]
        for axis in range(3):
            held[i, axis], velocity[i, axis] = to_twist[row, axis], twist[row, axis]
        held[i, 1] += ahead * to_twist[row, 2]
        velocity[i, 1] += ahead * twist[row, 2]
        own_rims[0, i], own_rims[1, i] = rims[0, row], rims[1, row]
        place[i, 0] = pose[row, 0] + ahead * cos[i]
        place[i, 1] = pose[row, 1] + ahead * sin[i]
    turns, pushes, slides = np.empty((2, k)), np.empty((4, k)), np.empty(k, dtype=np.bool_)
    rolled, pushed = np.zeros((2, k)), np.zeros((2, k))
    for _ in range(substeps):
        for i in range(k):
            angle[i] = duration * velocity[i, 2]
        cosines(angle, turns[0])
        sines(angle, turns[1])
        push_all(own, velocity, held, own_rims, turns, duration, pushes, slides, True)
        for i in range(k):  # ``rolling.ways``
            angle[i] = theta[i] + (1.0 if slides[i] else 0.5) * duration * velocity[i, 2]
        cosines(angle, turns[0])
        sines(angle, turns[1])
        carry_all(own, velocity, own_rims, turns, duration, pushes, place, theta, rolled, pushed)
    cosines(theta, cos)
    sines(theta, sin)
    for i in range(k):
        row, ahead, heading = rows[i], own[AHEAD, i], theta[i]
        if heading < -PI or heading >= PI:
            heading = (heading + PI) % TURN - PI
        to_pose[row, 0] = place[i, 0] - ahead * cos[i]
        to_pose[row, 1] = place[i, 1] - ahead * sin[i]
        to_pose[row, 2], to_twist[row, 0], to_twist[row, 2] = (
            heading,
            velocity[i, 0],
            velocity[i, 2],
        )
        to_twist[row, 1] = velocity[i, 1] - ahead * velocity[i, 2]
        turned[0, row], turned[1, row] = rolled[0, i], rolled[1, i]
    return stand_all(own, pushed, substeps * duration)


def stand_all(wheels, pushed, time):
    """Return whether no robot tips that the ground has ``pushed`` (2, k) [N s] in a ``time`` [s], as
    ``rolling.who_tips`` has it."""
    tips = 0
    for i in range(pushed.shape[1]):
        ahead, aside, height = pushed[0, i] / time, pushed[1, i] / time, wheels[HEIGHT, i]
        centre = -height * ahead / (GRAVITY * wheels[MASS, i])
        both = max(wheels[LOAD, i] - wheels[SHIFT, i] * ahead, 0.0)
        leans = height * abs(aside) > both * wheels[HALF, i]
        tips |= (centre > wheels[FRONT, i]) | (centre < wheels[REAR, i]) | leans
    return tips == 0


def fastest(twist):
    """Return the greatest speed [m/s] of ``twist`` (m, 3)."""
    most = 0.0
    for i in range(len(twist)):
        most = max(most, twist[i, 0] * twist[i, 0] + twist[i, 1] * twist[i, 1])
    return math.sqrt(most)


def rolling_stretch(
    plan,
    pose,
    twist,
    inner,
    angles,
    command,
    limits,
    wheels,
    gear,
    times,
    room,
    kept,
    l,
    scope,
    *given,
):
    """Move robots on two wheels under forces by several steps, in place, as ``stretches.stretch`` does
    unicycles.

    Arguments as there and of ``roll_step``; ``angles`` (m, 2) [rad]: of the wheels; ``room``: how far [m]
    robots may move before they are near anything, how far they may have moved in the last step, and by how
    much faster [m/s] they may become.  Returns steps done, samples kept, the first two of ``room`` and why
    it ended: ``STALE`` where there is no room, ``NEAR`` before a step in which one tips.
    """
    (steps, until, every, ahead, between), (left, way, quicker) = plan, room
    n, filled = len(pose), 0
    after = np.empty((n, 3)), np.empty((n, 3)), np.empty((2, n)), np.empty((2, n))
    seen, wanted, excess = np.empty((3, n)), np.empty((2, n)), np.empty(n)
    cos, sin, points = np.empty(n), np.empty(n), np.empty((n, 2))
    for count in range(1, steps + 1):
        next_way = times[0] * (fastest(twist) + quicker)
        if not left - way > next_way:
            return count - 1, filled, left, way, STALE
        if not roll_step(wheels, gear, limits, times, pose, twist, inner, command, after):
            return count - 1, filled, left, way, NEAR
        left, way = left - way, next_way
        pose[:], twist[:], inner[:] = after[0], after[1], after[2]
        for i in range(n):
            angles[i, 0] += after[3][0, i]
            angles[i, 1] += after[3][1, i]
        commands = count >= until and (count - until) % every == 0
        samples = count >= ahead and (count - ahead) % between == 0
        if commands or samples:
            for axis in range(3):
                for i in range(n):
                    seen[axis, i] = pose[i, axis]
        if commands:
            cosines(seen[2], cos)
            sines(seen[2], sin)
            place_points(seen, l, cos, sin, points)
            if not map_all(term(points, *given), cos, sin, l, wanted):
                return count, filled, left, way, ODD
            excesses(wanted, limits[8:], excess)
            saturate(wanted, excess, scope, command)
        if samples:
            if not keep(seen, command, kept[filled]):
                return count, filled, left, way, FAR
            filled += 1
    return steps, filled, left, way, DONE


@functools.lru_cache(maxsize=None)
def compiled_roll_step():
    """Return the compiled ``roll_step``; ``ValueError`` without numba."""
    return kept_kernel(roll_step)
