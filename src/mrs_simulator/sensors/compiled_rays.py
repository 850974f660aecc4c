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
ROUGH = 1e-3  # [rad] by which two bearings together are wrong at most, and by a margin
MARGIN = 1e-6  # [rad, -] of directions and distances, far more than their rounding
NONE, NOBODY = -2, np.empty(0, dtype=int)  # row of no robot, and rows of none


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


def least_along(share, cos, sin):
    """Return the least cosine between the way to a centre and a ray that meets what is about it.

    ``share``: sine of half the angle that the latter takes up; a ray meets what is within its cone.
    """
    return np.sqrt(1.0 - share * share) * cos - share * sin - MARGIN


def spread_of(share):
    """Return no less than the arc sine [rad] of ``share``, from 0 to 1, and what bearings are wrong by.

    Too much by 0.2 rad at most, and by less where bodies are farther away.
    """
    return share + (0.5 * np.pi - 1.0) * share * share * share + ROUGH


def bearing_of(x, y):
    """Return the direction [rad] of (x, y) to within half of ``ROUGH``."""
    side, along = abs(y), abs(x)
    slope = min(side, along) / max(side, along)
    square = slope * slope
    angle = ((-0.0464964749 * square + 0.15931422) * square - 0.327622764) * square * slope + slope
    if side > along:
        angle = 0.5 * np.pi - angle
    if x < 0.0:
        angle = np.pi - angle
    return -angle if y < 0.0 else angle


def lower(origin, direction, way, least, shape, cos, sin, result):
    """Lower ``result`` to the distances of all rays to a ``shape``.

    Those with less than ``least`` along the ``way`` to it do not meet it.
    """
    centre_x, centre_y, c, s, length, width, is_round = shape
    for k in range(direction.shape[1]):
        u, v = direction[0, k], direction[1, k]
        if way[0] * u + way[1] * v < least:
            continue
        of = k if origin.shape[1] > 1 else 0
        x, y = origin[0, of] - centre_x, origin[1, of] - centre_y
        x, y = c * x + s * y, c * y - s * x
        u, v = c * u + s * v, c * v - s * u
        if sin == 0.0:
            found = meet(x, y, u, v, length, width, is_round)
        else:
            found = nearest(x, y, u, v, length, width, is_round, cos)
            for side in (-sin, sin):
                edge_u, edge_v = cos * u - side * v, cos * v + side * u
                found = min(found, meet(x, y, edge_u, edge_v, length, width, is_round))
        result[k] = min(result[k], found)


def lower_part(origin, direction, begin, end, shape, result):
    """Do as ``lower`` for the rays from ``begin`` to before ``end``, which have one origin and no cone.

    In loops without branches, which make use of the processor's vectors.
    """
    centre_x, centre_y, c, s, length, width, is_round = shape
    x, y = origin[0, 0] - centre_x, origin[1, 0] - centre_y
    x, y = c * x + s * y, c * y - s * x
    u, v, found = direction[0, begin:end], direction[1, begin:end], result[begin:end]
    if is_round:
        for k in range(len(found)):
            across = c * u[k] + s * v[k], c * v[k] - s * u[k]
            found[k] = min(found[k], meet_disc(x, y, across[0], across[1], length))
    else:
        for k in range(len(found)):
            across = c * u[k] + s * v[k], c * v[k] - s * u[k]
            found[k] = min(found[k], meet_box(x, y, across[0], across[1], length, width))


def lower_fan(origin, direction, fan, way, spread, shape, result):
    """Do as ``lower_part`` for rays within ``spread`` [rad] of the ``way``.

    ``fan``: the angle [rad] of the first one, and that from ray to ray.
    """
    start, step = fan
    first, count = bearing_of(way[0], way[1]) - start - spread, direction.shape[1]
    first += TURN * np.ceil(-(first + 2.0 * spread) / TURN)
    while first <= count * step:
        begin = max(0, int(np.ceil(first / step)))
        end = min(count, int(np.floor((first + 2.0 * spread) / step)) + 1)
        if begin < end:
            lower_part(origin, direction, begin, end, shape, result)
        first += TURN


def cast_row(shapes, origin, direction, row, lens, result):
    """Fill ``result`` (K,) with the distances along the rays of one robot.

    ``origin`` and ``direction``: (2, K); ``row``: its height, its own row, and that of a robot not met;
    ``lens`` as of ``cast_all``.
    """
    centre, axis, half, is_round, low, high, owner, reach = shapes
    height, own, unseen = row
    most, slack, cos, sin, step = lens
    fan = bearing_of(direction[0, 0], direction[1, 0]), step
    result[:] = np.inf
    for each in range(centre.shape[0]):
        x, y = centre[each, 0] - origin[0, 0], centre[each, 1] - origin[1, 0]
        square, far = x * x + y * y, most + slack + reach[each]
        if not square < far * far:
            continue
        if owner[each] == own or owner[each] == unseen:
            continue
        if not low[each] <= height < high[each]:
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
        far, wide = np.sqrt(square), slack + reach[each]
        if far <= wide * (1.0 + MARGIN):
            lower(origin, direction, (x, y), -np.inf, shape, cos, sin, result)
        elif step > 0.0:
            lower_fan(origin, direction, fan, (x, y), spread_of(wide / far), shape, result)
        else:
            least = far * least_along(wide / far, cos, sin)
            lower(origin, direction, (x, y), least, shape, cos, sin, result)
    for k in range(len(result)):
        if result[k] > most:
            result[k] = np.inf


def cast_all(shapes, origin, direction, rows, lens, result):
    """Fill ``result`` (m, K) with the distances along ``direction`` (m, K, 2) from ``origin``.

    ``rows``: heights, own rows, and those of robots not met, (m,) each, the last for none empty; ``lens``:
    the greatest distance, how far origins lie from the first one, cosine and sine of half the cone, and the
    angle from ray to ray, 0: any.
    """
    places, along = np.empty((2, origin.shape[1])), np.empty((2, direction.shape[1]))
    for k in range(direction.shape[0]):
        for j in range(places.shape[1]):
            places[0, j], places[1, j] = origin[k, j, 0], origin[k, j, 1]
        for j in range(along.shape[1]):
            along[0, j], along[1, j] = direction[k, j, 0], direction[k, j, 1]
        row = rows[0][k], rows[1][k], rows[2][k] if len(rows[2]) else NONE
        cast_row(shapes, places, along, row, lens, result[k])


def cast_turned(shapes, pose, cosines, sines, places, along, rows, lens, result):
    """Do as ``cast_all`` of robots with the same rays: ``places`` and ``along`` (K, 2) in their frames.

    ``pose`` (m, 3); ``cosines`` and ``sines`` (m,) of the headings.
    """
    places, along = places.T.copy(), along.T.copy()
    origin, direction = np.empty(places.shape), np.empty(along.shape)
    for k in range(pose.shape[0]):
        x, y, cos, sin = pose[k, 0], pose[k, 1], cosines[k], sines[k]
        for j in range(places.shape[1]):
            origin[0, j] = x + cos * places[0, j] - sin * places[1, j]
            origin[1, j] = y + sin * places[0, j] + cos * places[1, j]
        for j in range(along.shape[1]):
            direction[0, j] = cos * along[0, j] - sin * along[1, j]
            direction[1, j] = sin * along[0, j] + cos * along[1, j]
        row = rows[0][k], rows[1][k], rows[2][k] if len(rows[2]) else NONE
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
    solid = meet_box, meet_disc, meet, nearest
    helpers = *solid, least_along, spread_of, bearing_of, lower, lower_part, lower_fan, cast_row
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
    rows = _contiguous(rays.height, rays.owner, NOBODY if unseen is None else unseen)
    loop, given, slack, step = rays.given(loops)
    cos, sin = (float(np.cos(cone)), float(np.sin(cone))) if cone else (1.0, 0.0)
    lens = float(most), slack, cos, sin, step
    loop(tuple(shapes), *_contiguous(*given), rows, lens, result)
    return result


def _contiguous(*arrays):
    return tuple(map(np.ascontiguousarray, arrays))
