"""A step of unicycles that touch each other, in one call that numba compiles, with numpy's bits.

What ``KinematicMotion`` and ``Bodies`` do one after the other in such a step, in the same order: robots
follow their commands, bodies that overlap are pushed apart, and robots are as fast as contacts let them.
"""

import functools
import math

import numpy as np

from mrs_simulator.core.compiled_cos_sin import cosines, sines
from mrs_simulator.core.compiled_terms import kept as kept_kernel
from mrs_simulator.world.contact.compiled_contacts import APART, STALE, farthest, push_all
from mrs_simulator.world.motion.compiled import feel_all
from mrs_simulator.world.motion.stretch_parts import PI, TURN, clip, greatest_of, ramp


def step_all(state, given, step, reach, after, room, *pairs):
    """Move unicycles by a step; return what ``push_all`` does, and the ``room`` left [m].

    ``state``: pose (3, n), inner velocities (2, n), and cosine and sine of the headings, (n,) each;
    ``given``: the command (2, n) and the ``limits`` (10, n) of ``stretches``; ``reach``: the longest way
    [m] in a ``step`` [s], and the share by which the greatest velocity is one, 0 where only the former
    counts; ``room``: how far [m] each may still move, how far it could have where robots were last looked
    at, and these places (2, n); ``pairs``: what ``push_all`` takes after the headings.

    Filled: the state ``after`` it; without headings where nothing is looked at, ``APART``.  With ``STALE``
    the poses are those before robots are pushed apart, and pairs are to be listed anew, or without passes
    bodies to be looked at elsewhere.
    """
    pose, inner, turned = state
    to_pose, to_inner, to_turned = after
    left, free, looked = room
    travel = follow(pose, inner, given[0], given[1], step, reach, to_pose, to_inner)
    left -= travel
    if left <= 0.0 < free:
        left = free - math.sqrt(farthest(to_pose[0], to_pose[1], looked[0], looked[1]))
    if left > 0.0:
        return APART, 0.0, 0.0, left
    if pairs[4] == 0:
        return STALE, 0.0, 0.0, left
    cosines(to_pose[2], to_turned[0])
    sines(to_pose[2], to_turned[1])
    unpushed = to_pose[:2].copy()
    hits, nearest, moved = push_all(to_pose, to_turned[0], to_turned[1], *pairs)
    if hits > 0:
        feel_all(to_pose, unpushed, pose, turned[0], turned[1], step, to_inner)
    return hits, nearest, moved, left


def follow(pose, inner, command, limits, step, reach, to_pose, to_inner):
    """Fill ``to_pose`` and ``to_inner`` with what robots under a ``command`` are after a ``step`` [s], if
    nothing is in their way; return how far [m] none of them moved farther.

    As ``KinematicMotion._moved`` and ``_farthest`` do; arguments as of ``step_all``.
    """
    n = pose.shape[1]
    v, omega, target = np.empty(n), np.empty(n), np.empty(n)
    middle, share = np.empty(n), np.empty(n)
    cos, sin = np.empty(n), np.empty(n)
    for axis, mean in enumerate((v, omega)):
        clip(command[axis], limits[axis], limits[2 + axis], target)
        ramp(target, limits[4 + axis], limits[6 + axis], inner[axis], to_inner[axis], mean)
    travel, rate = reach
    if rate > 0.0:
        travel = min(travel, rate * max(greatest_of(v), greatest_of(omega)))
    half, (x, y, theta) = target, (pose[0], pose[1], pose[2])
    for row in range(n):
        half[row] = omega[row] * (0.5 * step)
    for row in range(n):
        middle[row] = theta[row] + half[row]
    sines(half, share)
    cosines(middle, cos)
    sines(middle, sin)
    for row in range(n):
        share[row] = share[row] / half[row] if half[row] != 0.0 else 1.0
    for row in range(n):
        v[row] = v[row] * step * share[row]
    to_x, to_y, to_theta = to_pose[0], to_pose[1], to_pose[2]
    for row in range(n):
        to_x[row] = x[row] + v[row] * cos[row]
    for row in range(n):
        to_y[row] = y[row] + v[row] * sin[row]
    for row in range(n):
        to_theta[row] = middle[row] + half[row]
    beyond = 0
    for row in range(n):
        beyond |= (to_theta[row] < -PI) | (to_theta[row] >= PI)
    if beyond:
        for row in range(n):
            if to_theta[row] < -PI or to_theta[row] >= PI:
                to_theta[row] = (to_theta[row] + PI) % TURN - PI
    return travel


@functools.lru_cache(maxsize=None)
def compiled_step():
    """Return the compiled ``step_all``; ``ValueError`` without numba."""
    return kept_kernel(step_all)
