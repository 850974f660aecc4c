"""The kinematic step compiled by numba, with results equal to the bit.

Worth it on small teams, where numpy's calls cost more than its arithmetic (docs/benchmarks.md).  The
kernels do numpy's operations in numpy's order, without fused or reordered ones; sines and cosines stay
numpy's, whose last bits differ from those of the C library.
"""

import functools

import numpy as np

from mrs_simulator.core.compiled_terms import kept
from mrs_simulator.core.compiling import jit

PI, TURN = np.pi, 2.0 * np.pi


def approach_all(velocity, target, reach, after, mean):
    """Fill ``after`` and ``mean`` (n, a) as ``ramped`` does, robot by robot."""
    for column in range(velocity.shape[1]):
        for row in range(len(velocity)):
            most = reach[row, column]
            change = min(max(target[row, column] - velocity[row, column], -most), most)
            reached = velocity[row, column] + change
            after[row, column] = reached
            mean[row, column] = reached - change * abs(change) / (most + most)


def carry_all(pose, moved, half, sin_half, cos, sin, after):
    """Fill ``after`` (n, 3) as ``moved_along_arcs_wrapped`` does; ``cos``, ``sin`` of the mean headings."""
    slides = moved.shape[1] == 3
    for row in range(len(pose)):
        share = sin_half[row] / half[row] if half[row] != 0.0 else 1.0
        along = moved[row, 0] * share
        x, y = pose[row, 0] + along * cos[row], pose[row, 1] + along * sin[row]
        if slides:
            across = moved[row, 1] * share
            x, y = x - across * sin[row], y + across * cos[row]
        after[row, 0], after[row, 1] = x, y
        angle = pose[row, 2] + half[row] + half[row]
        if angle < -PI or angle >= PI:
            angle = (angle + PI) % TURN - PI
        after[row, 2] = angle


def feel_all(pose, free, before, cos, sin, step, inner):
    """Let unicycles that contacts have put from ``free`` to ``pose`` be as fast as they let them.

    As ``KinematicMotion._feel_contacts`` and ``differential.blocked`` do: ``inner`` (2, n) in place.  Poses
    (3, n); ``cos``, ``sin`` (n,) of the headings ``before`` the step [s].
    """
    for row in range(pose.shape[1]):
        if pose[0, row] != free[0, row] or pose[1, row] != free[1, row]:
            x, y = (pose[0, row] - before[0, row]) / step, (pose[1, row] - before[1, row]) / step
            own, sign = inner[0, row], 0.0
            if own != 0.0:
                sign = 1.0 if own > 0.0 else -1.0
            ahead = sign * (cos[row] * x + sin[row] * y)
            ahead = ahead if ahead > 0.0 else 0.0
            inner[0, row] = sign * (ahead if ahead < abs(own) else abs(own))


def approached_by(compile_):
    """Return the twin of ``kinematics.ramped`` whose kernel went through ``compile_``."""
    kernel = compile_(approach_all)

    def approached(velocity, target, reach):
        after, mean = np.empty_like(velocity), np.empty_like(velocity)
        kernel(velocity, target, reach.up, after, mean)
        return after, mean

    return approached


def carried_by(compile_):
    """Return the twin of ``kinematics.moved_along_arcs_wrapped`` whose kernel went through ``compile_``."""
    kernel = compile_(carry_all)

    def carried_on(pose, moved):
        half = moved[:, -1].copy()
        middle = pose[:, 2] + half
        after = np.empty(pose.shape, order="F")
        kernel(pose, moved, half, np.sin(half), np.cos(middle), np.sin(middle), after)
        return after

    return carried_on


@functools.lru_cache(maxsize=None)
def approach_twin():
    """Return what :func:`approached` calls; ``ValueError`` without numba."""
    return approached_by(jit(cache=True))


@functools.lru_cache(maxsize=None)
def carry_twin():
    """Return what :func:`carried` calls; ``ValueError`` without numba."""
    return carried_by(jit(cache=True))


def approached(velocity, target, reach):
    """As ``kinematics.ramped``, compiled; known by name, so that a motion that keeps it can be copied."""
    return approach_twin()(velocity, target, reach)


def carried(pose, moved):
    """As ``kinematics.moved_along_arcs_wrapped``, compiled, and known by name."""
    return carry_twin()(pose, moved)


def compiled_approached():
    """Return the compiled twin of ``kinematics.ramped``; ``ValueError`` without numba."""
    approach_twin()
    return approached


def compiled_carried():
    """Return the compiled twin of ``kinematics.moved_along_arcs_wrapped``; ``ValueError`` without numba."""
    carry_twin()
    return carried


@functools.lru_cache(maxsize=None)
def compiled_feel():
    """Return the compiled ``feel_all``; ``ValueError`` without numba."""
    return kept(feel_all)
