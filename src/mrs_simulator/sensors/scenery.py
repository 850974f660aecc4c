"""The surroundings of sensors as shapes, and ray casting in the plane.

Obstacles, walls and robots are upright boxes and cylinders; a sensor looks level, at its own height.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core import compiling
from mrs_simulator.core.kinematics import cos_sin, direction_of
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import Cylinder
from mrs_simulator.sensors.compiled_rays import (
    MARGIN,
    TURN,
    cast_by,
    compiled_loops,
    slack_of,
    spread_of,
)
from mrs_simulator.sensors.placing import carried, turned

NO_ROBOT = -1
TINY = 1e-300  # [-] instead of 0, of a ray along a face
CAST = 500  # [-] rays that numpy casts in 0.1 ms, about
MOST = 16000  # [-] pairs of a ray and a shape that are looked at together: what a cache holds


class Shapes(NamedTuple):
    """N upright boxes and cylinders, seen from above."""

    centre: np.ndarray  # (N, 2) [m]
    axis: np.ndarray  # (N, 2) [-] along the length of a box
    half: np.ndarray  # (N, 2) [m] half of length and width; of a cylinder its radius, twice
    round: np.ndarray  # (N,) bool
    low: np.ndarray  # (N,) [m] height of the underside
    high: np.ndarray  # (N,) [m] height of the top
    owner: np.ndarray  # (N,) row of the robot whose body it is, NO_ROBOT for an obstacle
    reach: np.ndarray  # (N,) [m] from the centres


class Scenery:
    """The obstacles of a scene and the bodies of a team."""

    def __init__(self, team, obstacles=(), picture=None):
        """``team``: the ``vehicles.Team``; ``obstacles``: ``Box`` and ``Cylinder``.

        ``picture(state, eye, ahead, settings)``: image and depth of a camera at ``eye`` (3,) that looks
        along ``ahead`` (3,).
        """
        self.picture = picture
        self._moving = [(row, each) for row, each in enumerate(obstacles) if moves(each)]
        fixed = [_of_obstacle(each) for each in obstacles]
        bodies = [_of_body(kind.body) for kind in team.kinds]
        owner = [NO_ROBOT] * len(fixed) + list(range(len(bodies)))
        self._shapes, self._first = _shapes(fixed + bodies, owner), len(fixed)
        self._ahead = np.array([0.5 * (kind.body.front - kind.body.rear) for kind in team.kinds])
        self._seen = None, None

    def at(self, state):
        """Return the ``Shapes`` of obstacles and robots at ``state``."""
        if self._seen[0] is not state:  # several sensors look at the same time
            self._seen = state, self._shapes_at(state)
        return self._seen[1]

    def _shapes_at(self, state):
        shapes, robots = self._shapes, slice(self._first, None)
        centre, axis = shapes.centre.copy(), shapes.axis.copy()
        for row, each in self._moving:
            centre[row] = each.track.place((each.x, each.y), state.time)
        axis[robots, 0], axis[robots, 1] = cos_sin(state.pose[:, 2])
        centre[robots] = state.pose[:, :2] + self._ahead[:, np.newaxis] * axis[robots]
        if "z" in vars(state):
            low, high = shapes.low.copy(), shapes.high.copy()
            low[robots] += state.heights
            high[robots] += state.heights
            shapes = shapes._replace(low=low, high=high)
        return shapes._replace(centre=centre, axis=axis)


def _of_obstacle(obstacle):
    if isinstance(obstacle, Cylinder):
        size = [obstacle.radius, obstacle.radius]
        return [obstacle.x, obstacle.y], [1.0, 0.0], size, True, obstacle.height
    axis = [np.cos(obstacle.yaw), np.sin(obstacle.yaw)]
    size = [0.5 * obstacle.length, 0.5 * obstacle.width]
    return [obstacle.x, obstacle.y], axis, size, False, obstacle.height


def _of_body(body):
    size = [0.5 * body.length, 0.5 * body.width]
    return [0.0, 0.0], [1.0, 0.0], size, body.round, body.height


def _shapes(rows, owner):
    centre, axis, half, is_round, high = zip(*rows) if rows else ([], [], [], [], [])
    half = np.array(half, dtype=float).reshape(-1, 2)
    is_round = np.array(is_round, dtype=bool)
    return Shapes(
        np.array(centre, dtype=float).reshape(-1, 2),
        np.array(axis, dtype=float).reshape(-1, 2),
        half,
        is_round,
        np.zeros(len(rows)),
        np.array(high, dtype=float),
        np.array(owner, dtype=int),
        np.where(is_round, half[:, 0], np.hypot(half[:, 0], half[:, 1])),
    )


class Rays(NamedTuple):
    """K rays of each of m robots, level."""

    origin: np.ndarray  # (m, K, 2) or (m, 1, 2) [m]
    direction: np.ndarray  # (m, K, 2), unit vectors
    height: np.ndarray  # (m,) [m]
    owner: np.ndarray  # (m,) rows of the robots that cast them, whose own bodies they do not meet

    @property
    def shape(self):
        """Return (m, K)."""
        return self.direction.shape[:2]

    def given(self, loops):
        """Return which of the compiled ``loops`` casts them, from what, how far apart they begin at most
        [m], and the angle [rad] between two of them, 0: any."""
        return loops.cast_all, (self.origin, self.direction), slack_of(self.origin), 0.0


class CarriedRays(NamedTuple):
    """K level rays that are the same in the frames of m robots."""

    pose: np.ndarray  # (m, 3) [m, m, rad]
    place: np.ndarray  # (K, 2) or (1, 2) [m] of their origins on the robots
    along: np.ndarray  # (K, 2), unit vectors
    height: np.ndarray  # (m,) [m]
    owner: np.ndarray  # (m,) as of ``Rays``
    step: float = 0.0  # [rad] from each ray to the next, from one origin; 0: in no order

    @property
    def shape(self):
        """Return (m, K)."""
        return len(self.pose), len(self.along)

    def given(self, loops):
        """Return what ``Rays.given`` does."""
        given = self.pose, *cos_sin(self.pose[:, 2]), self.place, self.along
        return loops.cast_turned, given, slack_of(self.place[np.newaxis]), self.step

    def rays(self):
        """Return the ``Rays`` in the common frame."""
        origin, direction = carried(self.pose, self.place), turned(self.pose[:, 2], self.along)
        return Rays(origin, direction, self.height, self.owner)


def cast(shapes, rays, reach, cone=0.0, unseen=None):
    """Return the distances along ``rays`` to the nearest of ``shapes``, (m, K) [m], inf beyond ``reach``.

    ``rays``: ``Rays`` or ``CarriedRays``; ``cone`` [rad]: half of an opening angle below pi/2, within which
    the nearest point counts, as for the echo of a sonar.  A shape around the origin is at 0.  ``unseen``
    (m,): rows of further robots not met.  Loops that numba compiles do the same where they pay.
    """
    m, k = rays.shape
    loops = compiling.same_bits(compiled_loops, size=1 + m * k // CAST)
    if loops is not None:
        return cast_by(loops, shapes, rays, reach, cone, unseen)
    step = rays.step if isinstance(rays, CarriedRays) else 0.0
    rays = rays.rays() if isinstance(rays, CarriedRays) else rays
    result = np.full((m, k), np.inf)
    ray, shape = _near(shapes, rays, reach, unseen)
    if step and len(ray) * k > MOST:
        _cast_fans(result, shapes, rays, ray, shape, step)
        ray = ray[:0]
    length = max(1, MOST // max(1, k))
    for begin in range(0, len(ray), length):
        part = slice(begin, begin + length)
        _take(result, ray[part], _distances(shapes, rays, ray[part], shape[part], cone))
    result[result > reach] = np.inf
    return result


def _near(shapes, rays, reach, unseen):
    """Return pairs of rows of ``rays`` (p,) and ``shapes`` (p,) that may meet, ordered by the rays."""
    hub, slack = rays.origin[:, 0], slack_of(rays.origin)
    apart = hub[:, np.newaxis] - shapes.centre
    far = reach + slack + shapes.reach
    near = np.einsum("ijk,ijk->ij", apart, apart) < far * far
    near &= rays.owner[:, np.newaxis] != shapes.owner
    if unseen is not None:
        near &= unseen[:, np.newaxis] != shapes.owner
    height = rays.height[:, np.newaxis]
    near &= (shapes.low <= height) & (height < shapes.high)
    return np.nonzero(near)


def _take(result, ray, distance):
    """Lower ``result`` (m, K) at the rows ``ray`` (p,), ascending, to the least of ``distance`` (p, K)."""
    first = np.flatnonzero(np.concatenate([[True], ray[1:] != ray[:-1]]))
    rows = ray[first]
    result[rows] = np.minimum(result[rows], np.minimum.reduceat(distance, first, axis=0))


def _cast_fans(result, shapes, rays, ray, shape, step):
    """Lower ``result`` (m, K) to the distances to the shapes ``shape`` (p,) along rows ``ray`` of ``rays``,
    which are ``step`` [rad] apart and have one origin: along those that may meet them."""
    way = shapes.centre[shape] - rays.origin[ray, 0]
    far, wide, count = np.hypot(way[:, 0], way[:, 1]), shapes.reach[shape], result.shape[1]
    out = far > wide * (1.0 + MARGIN)
    spread = np.where(out, spread_of(wide / np.maximum(far, wide)), np.pi)
    first = direction_of(way) - direction_of(rays.direction[:, 0])[ray] - spread
    first += TURN * np.ceil(-(first + 2.0 * spread) / TURN)
    while (first <= count * step).any():
        begin, end = np.ceil(first / step), np.floor((first + 2.0 * spread) / step) + 1.0
        begin, end = (np.clip(each, 0, count).astype(int) for each in (begin, end))
        met = np.maximum(end - begin, 0)
        pair = np.repeat(np.arange(len(ray)), met)
        k = np.arange(len(pair)) - np.repeat(np.cumsum(met) - met - begin, met)
        alone = Rays(
            rays.origin[ray[pair]], rays.direction[ray[pair], k][:, np.newaxis], None, None
        )
        distance = _distances(shapes, alone, np.arange(len(pair)), shape[pair], 0.0)
        np.minimum.at(result, (ray[pair], k), distance[:, 0])
        first += TURN


def _distances(shapes, rays, ray, shape, cone):
    """Return the distances (p, K) along rows ``ray`` of ``rays`` to the shapes ``shape`` (p,)."""
    origin, direction = rays.origin[ray], rays.direction[ray]
    centre, axis, half = (
        each[shape][:, np.newaxis] for each in (shapes.centre, shapes.axis, shapes.half)
    )
    is_round = shapes.round[shape]
    if not is_round.any():
        return _to_shapes(_BOX, origin, direction, centre, axis, half, cone)
    if is_round.all():
        return _to_shapes(_DISC, origin, direction, centre, axis, half, cone)
    result = np.empty(direction.shape[:2])
    for which, form in ((~is_round, _BOX), (is_round, _DISC)):
        own = (each[which] for each in (origin, direction, centre, axis, half))
        result[which] = _to_shapes(form, *own, cone)
    return result


def _to_shapes(form, origin, direction, centre, axis, half, cone):
    """Return the distances (p, K) to shapes of one ``form``, each ray in the axes of its shape."""
    meet, nearest = form
    at = _turned(origin - centre, axis)
    along = _turned(direction, axis)
    half = half[..., 0], half[..., 1]
    if not cone:
        return meet(at, along, half)
    cos, sin = np.cos(cone), np.sin(cone)
    x, y = along
    found = _within(nearest(at, half), along, cos)
    for side in (-sin, sin):
        edge = cos * x - side * y, cos * y + side * x
        np.minimum(found, meet(at, edge, half), out=found)
    return found


def _turned(vectors, axis):
    """Return the components of ``vectors`` (p, K, 2) along and across ``axis`` (p, 1, 2)."""
    # Without gaps in memory numpy is faster.
    x, y = (np.ascontiguousarray(vectors[..., k]) for k in (0, 1))
    cos, sin = axis[..., 0], axis[..., 1]
    return cos * x + sin * y, cos * y - sin * x


def _meet_box(origin, direction, half):
    """Return the distances (p, K) [m] from ``origin`` to the box of ``half`` sizes about 0, inf if none."""
    enter, leave = 0.0, np.inf
    for at, along, size in zip(origin, direction, half):
        slope = 1.0 / (along + TINY)
        middle, span = at * slope, size * np.abs(slope)
        enter = np.maximum(enter, -middle - span)
        leave = np.minimum(leave, span - middle)
    return np.where(enter <= leave, enter, np.inf)


def _meet_disc(origin, direction, half):
    """Return the distances (p, K) [m] from ``origin`` to the disc about 0, inf if none."""
    (x, y), (u, v) = origin, direction
    along = x * u + y * v
    inner = along * along - (x * x + y * y - half[0] ** 2)
    root = np.sqrt(np.maximum(inner, 0.0))
    return np.where((inner >= 0.0) & (root >= along), np.maximum(-along - root, 0.0), np.inf)


def _near_box(origin, half):
    """Return the vector (x, y) from ``origin`` to the nearest point of the box."""
    return tuple(np.clip(at, -size, size) - at for at, size in zip(origin, half))


def _near_disc(origin, half):
    """Return the vector (x, y) from ``origin`` to the nearest point of the disc."""
    x, y = origin
    share = np.minimum(half[0] / np.maximum(np.sqrt(x * x + y * y), TINY), 1.0) - 1.0
    return share * x, share * y


def _within(way, direction, cos):
    """Return the length of ``way``, inf where it is not within the cone about ``direction``."""
    (x, y), (u, v) = way, direction
    far = np.sqrt(x * x + y * y)
    return np.where(x * u + y * v >= cos * far, far, np.inf)


_BOX, _DISC = (_meet_box, _near_box), (_meet_disc, _near_disc)
