"""Rays in the plane compiled by numba, with results equal to those of ``scenery`` to the bit.

The kernel does numpy's operations in numpy's order, for one ray and one shape after the other.
"""

import functools
from types import FunctionType

import numpy as np

from mrs_simulator.core.compiling import jit

TINY = 1e-300  # [-] as in ``scenery``


def meet_box(x, y, u, v, length, width):
    """Return the distance along the ray (u, v) from (x, y) to a box around the origin, inf if none."""
    slope = 1.0 / (u + TINY)
    middle, span = x * slope, length * abs(slope)
    enter, leave = max(0.0, -middle - span), min(np.inf, span - middle)
    slope = 1.0 / (v + TINY)
    middle, span = y * slope, width * abs(slope)
    enter, leave = max(enter, -middle - span), min(leave, span - middle)
    return enter if enter <= leave else np.inf


def meet_disc(x, y, u, v, radius):
    """Return the distance along the ray (u, v) from (x, y) to a disc around the origin, inf if none."""
    along = x * u + y * v
    inner = along * along - (x * x + y * y - radius * radius)
    root = np.sqrt(max(inner, 0.0))
    return max(-along - root, 0.0) if inner >= 0.0 and root >= along else np.inf


def nearest(x, y, u, v, length, width, is_round, cos):
    """Return the distance to the nearest point of the shape, inf where it is not in the cone."""
    if is_round:
        share = min(length / max(np.sqrt(x * x + y * y), TINY), 1.0) - 1.0
        x, y = share * x, share * y
    else:
        x = min(max(x, -length), length) - x
        y = min(max(y, -width), width) - y
    far = np.sqrt(x * x + y * y)
    return far if x * u + y * v >= cos * far else np.inf


def meet(x, y, u, v, length, width, is_round):
    """Return the distance along the ray (u, v) from (x, y) to a box or a disc, inf if none."""
    if is_round:
        return meet_disc(x, y, u, v, length)
    return meet_box(x, y, u, v, length, width)


def cast_all(shapes, rays, most, slack, reach, cos, sin, unseen, result):
    """Fill ``result`` (m, K) with the distances; ``sin`` 0 for rays, else of half the cone."""
    centre, axis, half, is_round, low, high, owner = shapes
    origin, direction, height, own = rays
    for row in range(direction.shape[0]):
        hub_x, hub_y = origin[row, 0, 0], origin[row, 0, 1]
        for each in range(centre.shape[0]):
            if owner[each] == own[row] or owner[each] == unseen[row]:
                continue
            if not low[each] <= height[row] < high[each]:
                continue
            away_x, away_y = hub_x - centre[each, 0], hub_y - centre[each, 1]
            far = most + slack + reach[each]
            if not away_x * away_x + away_y * away_y < far * far:
                continue
            c, s = axis[each, 0], axis[each, 1]
            length, width = half[each, 0], half[each, 1]
            for k in range(direction.shape[1]):
                of = k if origin.shape[1] > 1 else 0
                x, y = (origin[row, of, 0] - centre[each, 0], origin[row, of, 1] - centre[each, 1])
                x, y = c * x + s * y, c * y - s * x
                u, v = direction[row, k, 0], direction[row, k, 1]
                u, v = c * u + s * v, c * v - s * u
                if sin == 0.0:
                    found = meet(x, y, u, v, length, width, is_round[each])
                else:
                    found = nearest(x, y, u, v, length, width, is_round[each], cos)
                    for side in (-sin, sin):
                        edge_u, edge_v = cos * u - side * v, cos * v + side * u
                        met = meet(x, y, edge_u, edge_v, length, width, is_round[each])
                        found = min(found, met)
                if found < result[row, k]:
                    result[row, k] = found
        for k in range(direction.shape[1]):
            if result[row, k] > most:
                result[row, k] = np.inf


def make_kernel(compile_):
    """Return ``cast_all``, it and its helpers compiled by ``compile_``.

    The compiled functions are copies with globals of their own: numba's cache on disk does not hold
    functions that refer to each other by closures.
    """
    scope = dict(globals())
    for function in (meet_box, meet_disc, nearest, meet, cast_all):
        scope[function.__name__] = compile_(FunctionType(function.__code__, scope))
    return scope["cast_all"]


@functools.lru_cache(maxsize=None)
def compiled_kernel():
    """Return the compiled function; ``ValueError`` without numba."""
    return make_kernel(jit(cache=True))


def cast_by(kernel, shapes, rays, most, cone, unseen):
    """Return what ``scenery.cast`` does, (m, K) [m], by the ``kernel``."""
    result = np.full(rays.direction.shape[:2], np.inf)
    slack = np.abs(rays.origin - rays.origin[:, :1]).sum(axis=2).max(initial=0.0)
    unseen = np.full(len(result), -2) if unseen is None else np.asarray(unseen, dtype=int)
    cos, sin = (np.cos(cone), np.sin(cone)) if cone else (1.0, 0.0)
    arrays = tuple(map(np.ascontiguousarray, shapes)), tuple(map(np.ascontiguousarray, rays))
    kernel(*arrays, float(most), float(slack), shapes.reach, cos, sin, unseen, result)
    return result
