"""Rays in the plane compiled by numba, with results equal to those of ``scenery`` to the bit.

The kernel does numpy's operations in numpy's order, for one ray and one shape after the other.
"""

import functools
from types import FunctionType
from typing import Callable, NamedTuple

import numpy as np

from mrs_simulator.core.compiling import jit

TINY = 1e-300  # [-] as in ``scenery``
TURN = 2.0 * np.pi  # [rad]
MARGIN = 1e-6  # [rad, -] of directions and distances, far more than their rounding
WIDE = 3.0  # [rad] beyond which the cosine no longer tells directions apart by the margin
NONE = -2  # row of no robot
FEW = 2  # [-] rays that are not worth looking which of them can meet a shape


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


def spread_of(far, reach, cone):
    """Return beyond which angle [rad] from the way to a centre, ``far`` [m] away, no ray meets what is
    within ``reach`` [m] of it, pi where there is none; a ray meets what is within ``cone`` [rad] of it."""
    return np.arcsin(reach / far) + cone + MARGIN if far > reach * (1.0 + MARGIN) else np.pi


def lower(origin, direction, begin, end, way, least, shape, cos, sin, result):
    """Lower ``result`` to the distances to a ``shape`` of the rays from ``begin`` to before ``end``.

    Those with less than ``least`` along the ``way`` to it do not meet it.
    """
    centre_x, centre_y, c, s, length, width, is_round = shape
    for k in range(begin, end):
        u, v = direction[k, 0], direction[k, 1]
        if way[0] * u + way[1] * v < least:
            continue
        of = k if origin.shape[0] > 1 else 0
        x, y = origin[of, 0] - centre_x, origin[of, 1] - centre_y
        x, y = c * x + s * y, c * y - s * x
        u, v = c * u + s * v, c * v - s * u
        if sin == 0.0:
            found = meet(x, y, u, v, length, width, is_round)
        else:
            found = nearest(x, y, u, v, length, width, is_round, cos)
            for side in (-sin, sin):
                edge_u, edge_v = cos * u - side * v, cos * v + side * u
                found = min(found, meet(x, y, edge_u, edge_v, length, width, is_round))
        if found < result[k]:
            result[k] = found


def lower_fan(origin, direction, step, way, spread, shape, result):
    """Do as ``lower`` for rays ``step`` [rad] apart: those within ``spread`` [rad] of the ``way``."""
    first = np.arctan2(way[1], way[0]) - np.arctan2(direction[0, 1], direction[0, 0]) - spread
    first += TURN * np.ceil(-(first + 2.0 * spread) / TURN)
    count = direction.shape[0]
    while first <= count * step:
        begin = max(0, int(np.ceil(first / step)))
        end = min(count, int(np.floor((first + 2.0 * spread) / step)) + 1)
        lower(origin, direction, begin, end, way, -np.inf, shape, 1.0, 0.0, result)
        first += TURN


def cast_row(shapes, origin, direction, row, lens, result):
    """Fill ``result`` (K,) with the distances along the rays of one robot.

    ``row``: its height, its own row, and that of a robot not met; ``lens`` as of ``cast_all``.
    """
    centre, axis, half, is_round, low, high, owner, reach = shapes
    height, own, unseen = row
    most, slack, cone, cos, sin, step = lens
    count = direction.shape[0]
    result[:] = np.inf
    for each in range(centre.shape[0]):
        if owner[each] == own or owner[each] == unseen:
            continue
        if not low[each] <= height < high[each]:
            continue
        x, y = centre[each, 0] - origin[0, 0], centre[each, 1] - origin[0, 1]
        wide = slack + reach[each]
        square, far = x * x + y * y, most + slack + reach[each]
        if not square < far * far:
            continue
        shape = (
            centre[each, 0],
            centre[each, 1],
            axis[each, 0],
            axis[each, 1],
            half[each, 0],
            half[each, 1],
            is_round[each],
        )
        far, least = np.sqrt(square), -np.inf
        spread = spread_of(far, wide, cone) if count > FEW else np.pi
        if step > 0.0 and spread < np.pi:
            lower_fan(origin, direction, step, (x, y), spread, shape, result)
            continue
        if spread < WIDE:
            least = far * np.cos(spread)
        lower(origin, direction, 0, count, (x, y), least, shape, cos, sin, result)
    for k in range(count):
        if result[k] > most:
            result[k] = np.inf


def cast_all(shapes, origin, direction, rows, lens, result):
    """Fill ``result`` (m, K) with the distances along ``direction`` (m, K, 2) from ``origin``.

    ``rows``: heights, own rows, and those of robots not met, (m,) each; ``lens``: the greatest distance,
    how far origins lie from the first one, half of the cone, its cosine and sine, and the angle from ray
    to ray, 0: any.
    """
    for k in range(direction.shape[0]):
        row = rows[0][k], rows[1][k], rows[2][k]
        cast_row(shapes, origin[k], direction[k], row, lens, result[k])


def cast_turned(shapes, poses, places, along, rows, lens, result):
    """Do as ``cast_all`` of robots with the same rays: ``places`` and ``along`` (K, 2) in their frames.

    ``poses`` (m, 4): x, y [m], cosine and sine of the heading.
    """
    origin, direction = np.empty(places.shape), np.empty(along.shape)
    for k in range(poses.shape[0]):
        x, y, cos, sin = poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3]
        for j in range(places.shape[0]):
            origin[j, 0] = x + cos * places[j, 0] - sin * places[j, 1]
            origin[j, 1] = y + sin * places[j, 0] + cos * places[j, 1]
        for j in range(along.shape[0]):
            direction[j, 0] = cos * along[j, 0] - sin * along[j, 1]
            direction[j, 1] = sin * along[j, 0] + cos * along[j, 1]
        row = rows[0][k], rows[1][k], rows[2][k]
        cast_row(shapes, origin, direction, row, lens, result[k])


class Loops(NamedTuple):
    """The compiled functions."""

    cast_all: Callable
    cast_turned: Callable


def make_loops(compile_):
    """Return ``Loops``, they and their helpers compiled by ``compile_``.

    The compiled functions are copies with globals of their own: numba's cache on disk does not hold
    functions that refer to each other by closures.
    """
    scope = dict(globals())
    helpers = meet_box, meet_disc, nearest, meet, spread_of, lower, lower_fan, cast_row
    for function in (*helpers, cast_all, cast_turned):
        scope[function.__name__] = compile_(FunctionType(function.__code__, scope))
    return Loops(scope["cast_all"], scope["cast_turned"])


@functools.lru_cache(maxsize=None)
def compiled_loops():
    """Return the compiled ``Loops``; ``NotInstalled`` without numba."""
    return make_loops(jit(cache=True))


def slack_of(origin):
    """Return how far the origins (m, K, 2) [m] of a robot's rays lie from its first one at most, [m]."""
    if origin.shape[1] == 1:
        return 0.0
    return float(np.abs(origin - origin[:, :1]).sum(axis=2).max(initial=0.0))


def cast_by(loops, shapes, rays, most, cone, unseen):
    """Return what ``scenery.cast`` does, (m, K) [m], by the ``loops``."""
    result = np.empty(rays.shape)
    unseen = np.full(len(result), NONE) if unseen is None else np.asarray(unseen, dtype=int)
    rows = _contiguous(rays.height, rays.owner, unseen)
    loop, given, slack, step = rays.given(loops)
    cos, sin = (float(np.cos(cone)), float(np.sin(cone))) if cone else (1.0, 0.0)
    lens = float(most), slack, float(cone), cos, sin, step
    loop(_contiguous(*shapes), *_contiguous(*given), rows, lens, result)
    return result


def _contiguous(*arrays):
    return tuple(map(np.ascontiguousarray, arrays))
