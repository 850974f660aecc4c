"""Robots moved over several steps by loops that numba compiles: law, limits, ramps, motion, room to move.

The numbers are those of ``KinematicMotion``, ``PointMassMotion`` and ``Team``, but for sines and
cosines: they are the C library's at each sample and where a stretch begins, and turned with the robots
from there on, which takes a third of the time.  Trajectories agree to rounding as long as robots do not
touch: tests hold them to 1e-9 m.  How many samples a stretch has changes no bit.
"""

import math

import numpy as np

from mrs_simulator.world.motion.stretch_parts import (
    UNLISTED,
    arc,
    clip,
    copy,
    excesses,
    greatest_of,
    head,
    keep,
    map_all,
    place_points,
    ramp,
    room_around,
    saturate,
)

# Why a stretch ended: complete; bodies may touch; no usable command; pairs are to be listed anew; a robot
# is farther away than a sample may have it.
DONE, NEAR, ODD, STALE, FAR = range(5)
SCOPES = ("none", "robot", "team")  # of saturation
DIAGONAL = math.sqrt(2.0)  # [-] of a velocity by its greatest component, at most

term = None  # the law, compiled


def stretch(plan, pose, inner, command, limits, step, reach, room, around, kept, l, scope, *given):
    """Move unicycles by several steps, in place; return ``(steps done, samples kept, room left, why it
    ended)``.

    ``plan``: how many steps at most; after how many the law, ``term(points, *given)``, is asked, and
    after how many of them again; after how many a sample is kept in ``kept`` (m, 5, n), pose and command,
    and again.  ``pose`` (3, n); ``inner`` (2, n), speeds; ``command`` (2, n), in force.  ``limits``
    (10, n): least and greatest target, most change, twice that, and limit of commands, of v and omega each.
    ``reach`` [m]: the longest way in a step of ``step`` [s]; ``room`` [m]: how far robots may move before
    bodies can touch, and what there is ``around``, see ``room_around``; ``l`` [m]; ``scope``: saturation,
    a row of ``SCOPES``.  A step in which bodies may touch (``NEAR``, ``STALE``) is not made; a command that
    no robot could follow (``ODD``) is not given, and like a place too far away (``FAR``) not kept.
    """
    steps, until, every, ahead, between = plan
    n, filled = pose.shape[1], 0
    after, mean, spare = np.empty((2, n)), np.empty((2, n)), np.empty((4, n))
    cos, sin, points = np.empty(n), np.empty(n), np.empty((n, 2))
    head(pose[2], cos, sin)
    for count in range(1, steps + 1):
        for axis in range(2):
            clip(command[axis], limits[axis], limits[2 + axis], spare[axis])
            most, both = limits[4 + axis], limits[6 + axis]
            ramp(spare[axis], most, both, inner[axis], after[axis], mean[axis])
        travel = min(reach, step * greatest_of(mean[0]))
        if room <= travel:
            room = room_around(pose, around)
            if room <= travel:
                return count - 1, filled, 0.0, STALE if room == UNLISTED else NEAR
        room -= travel
        arc(mean[0], mean[1], step, pose, cos, sin, spare)
        copy(after[0], inner[0])
        copy(after[1], inner[1])
        if count >= until and (count - until) % every == 0:
            place_points(pose, l, cos, sin, points)
            if not map_all(term(points, *given), cos, sin, l, after):
                return count, filled, room, ODD
            excesses(after, limits[8:], spare[0])
            saturate(after, spare[0], scope, command)
        if count >= ahead and (count - ahead) % between == 0:
            if not keep(pose, command, kept[filled]):
                return count, filled, room, FAR
            filled += 1
            head(pose[2], cos, sin)
    return steps, filled, room, DONE


def point_stretch(plan, pose, twist, command, step, kept, l, scope, *given):
    """Move hand points as point masses by several steps, in place; return what ``stretch`` does but room.

    Arguments as there, and ``twist`` (3, n), that of the last step; a point has neither limits nor a body,
    so that ``scope`` means nothing.
    """
    steps, until, every, ahead, between = plan
    n, filled = pose.shape[1], 0
    cos, sin = np.empty(n), np.empty(n)
    points, wanted = np.empty((n, 2)), np.empty((2, n))
    head(pose[2], cos, sin)
    for count in range(1, steps + 1):
        for row in range(n):
            along, across = command[0, row], l * command[1, row]
            pose[0, row] += step * (cos[row] * along - sin[row] * across)
            pose[1, row] += step * (sin[row] * along + cos[row] * across)
        copy(command[0], twist[0])
        for row in range(n):
            twist[1, row] = l * command[1, row]
        if count >= until and (count - until) % every == 0:
            place_points(pose, l, cos, sin, points)
            if not map_all(term(points, *given), cos, sin, l, wanted):
                return count, filled, ODD
            copy(wanted[0], command[0])
            copy(wanted[1], command[1])
        if count >= ahead and (count - ahead) % between == 0:
            if not keep(pose, command, kept[filled]):
                return count, filled, FAR
            filled += 1
    return steps, filled, DONE


def sliding_stretch(
    plan, pose, inner, command, limits, wheels, step, reach, room, around, kept, l, scope, *given
):
    """Move omnidirectional bases, of which none turns, as ``stretch`` does unicycles.

    Arguments as there, but of three axes; ``wheels`` (n, 4, 3) of each robot: what one of its rims does
    at vx and at vy, and the limit of its speed.  Where a robot turns, or is to turn, no step is made.
    """
    steps, until, every, ahead, between = plan
    n, filled = pose.shape[1], 0
    if greatest_of(inner[2]) != 0.0 or greatest_of(command[2]) != 0.0:
        return 0, 0, room, NEAR
    after, mean, spare = np.empty((2, n)), np.empty((2, n)), np.empty((2, n))
    cos, sin, points, excess = np.empty(n), np.empty(n), np.empty((n, 2)), np.empty(n)
    head(pose[2], cos, sin)
    for count in range(1, steps + 1):
        for axis in range(2):
            clip(command[axis], limits[axis], limits[3 + axis], spare[axis])
        rim_excesses(spare, wheels, excess)
        for axis in range(2):
            for row in range(n):
                spare[axis, row] /= excess[row]
            most, both = limits[6 + axis], limits[9 + axis]
            ramp(spare[axis], most, both, inner[axis], after[axis], mean[axis])
        fastest = max(greatest_of(mean[0]), greatest_of(mean[1]))
        travel = min(reach, step * DIAGONAL * fastest)
        if room <= travel:
            room = room_around(pose, around)
            if room <= travel:
                return count - 1, filled, 0.0, STALE if room == UNLISTED else NEAR
        room -= travel
        for row in range(n):
            x, y = step * mean[0, row], step * mean[1, row]
            pose[0, row] += cos[row] * x - sin[row] * y
            pose[1, row] += sin[row] * x + cos[row] * y
        copy(after[0], inner[0])
        copy(after[1], inner[1])
        if count >= until and (count - until) % every == 0:
            place_points(pose, 0.0, cos, sin, points)
            if not map_all(term(points, *given), cos, sin, 1.0, after):
                return count, filled, room, ODD
            rim_excesses(after, wheels, excess)
            for axis in range(2):
                for row in range(n):
                    own = abs(after[axis, row]) / limits[12 + axis, row]
                    excess[row] = max(own, excess[row])
            saturate(after, excess, scope, command)
        if count >= ahead and (count - ahead) % between == 0:
            if not keep(pose, command, kept[filled]):
                return count, filled, room, FAR
            filled += 1
    return steps, filled, room, DONE


def rim_excesses(velocity, wheels, excess):
    """Fill ``excess`` (n,): by which factor rims of ``wheels`` are too fast at ``velocity`` (2, n).

    1 where none is.
    """
    for row in range(len(wheels)):
        excess[row] = 1.0
        for wheel in range(wheels.shape[1]):
            rim = (
                wheels[row, wheel, 0] * velocity[0, row] + wheels[row, wheel, 1] * velocity[1, row]
            )
            excess[row] = max(excess[row], abs(rim) / wheels[row, wheel, 2])
