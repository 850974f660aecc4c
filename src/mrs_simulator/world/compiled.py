"""``differential.move`` compiled by numba, with results equal to the bit.

Worth it on small teams, where numpy's calls cost more than its arithmetic (docs/benchmarks.md).  The
kernels do numpy's operations in numpy's order, without fused or reordered ones; sines and cosines stay
numpy's, whose last bits differ from those of the C library.
"""

import functools

import numpy as np

PI, TURN = np.pi, 2.0 * np.pi


def ramp_all(velocity, command, top, acceleration, step, after, mean):
    """Fill ``after`` and ``mean`` (n, 2) as ``clip_commands`` and ``ramp`` do, robot by robot."""
    for column in range(2):
        for row in range(len(velocity)):
            most, reach = top[row, column], acceleration[row, column] * step
            target = min(max(command[row, column], -most), most)
            change = min(max(target - velocity[row, column], -reach), reach)
            reached = velocity[row, column] + change
            after[row, column] = reached
            mean[row, column] = reached - change * abs(change) / (2.0 * reach)


def move_all(pose, mean, step, half, sin_half, cos, sin, after):
    """Fill ``after`` (n, 3) as ``arc`` and ``wrap_angle`` do; ``cos``, ``sin`` of the mean headings."""
    for row in range(len(pose)):
        share = sin_half[row] / half[row] if half[row] != 0.0 else 1.0
        chord = step * mean[row, 0] * share
        after[row, 0] = pose[row, 0] + chord * cos[row]
        after[row, 1] = pose[row, 1] + chord * sin[row]
        angle = pose[row, 2] + half[row] + half[row]
        if angle < -PI or angle >= PI:
            angle = (angle + PI) % TURN - PI
        after[row, 2] = angle


def driver(compile_):
    """Return the twin of ``differential.move`` whose kernels went through ``compile_``."""
    ramp_kernel, move_kernel = compile_(ramp_all), compile_(move_all)

    def move(pose, velocity, joints, command, limits, numbers, step):
        n = len(pose)
        top, acceleration = (np.broadcast_to(each, (n, 2)) for each in limits)
        reached, mean = np.empty((n, 2), order="F"), np.empty((n, 2), order="F")
        ramp_kernel(velocity, command, top, acceleration, step, reached, mean)
        half = 0.5 * step * mean[:, 1]
        middle = pose[:, 2] + half
        after = np.empty((n, 3), order="F")
        move_kernel(pose, mean, step, half, np.sin(half), np.cos(middle), np.sin(middle), after)
        return reached, joints, mean, after

    return move


@functools.lru_cache(maxsize=None)
def compiled_move():
    """Return the compiled twin; ``ValueError`` where numba is not installed."""
    try:
        import numba  # optional
    except ImportError:
        raise ValueError(
            "MRS_SIMULATOR_COMPILED=1: numba is not installed, wanted `pip install numba`"
        ) from None
    return driver(numba.njit(cache=True, fastmath=False, error_model="numpy"))
