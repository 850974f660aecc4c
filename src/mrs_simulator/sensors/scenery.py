"""What stands around sensors, and rays in the plane that meet it.

Obstacles, walls and robots are upright boxes and cylinders; a sensor looks level, at its own height.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.obstacles import Cylinder

NOBODY = -1
MOST = 200000  # [-] pairs of a ray and a shape that are looked at together


class Shapes(NamedTuple):
    """N upright boxes and cylinders, seen from above."""

    centre: np.ndarray  # (N, 2) [m]
    axis: np.ndarray  # (N, 2) [-] along the length of a box
    half: np.ndarray  # (N, 2) [m] half of length and width; of a cylinder its radius, twice
    round: np.ndarray  # (N,) bool
    low: np.ndarray  # (N,) [m] height of the underside
    high: np.ndarray  # (N,) [m] height of the top
    owner: np.ndarray  # (N,) row of the robot whose body it is, NOBODY for an obstacle

    @property
    def reach(self):
        """Return how far they reach from their centres, (N,) [m]."""
        return np.where(self.round, self.half[:, 0], np.hypot(self.half[:, 0], self.half[:, 1]))


class Scenery:
    """The obstacles of a scene and the bodies of a team."""

    def __init__(self, team, obstacles=()):
        """``team``: the ``vehicles.Team``; ``obstacles``: ``Box`` and ``Cylinder``."""
        fixed = [_of_obstacle(each) for each in obstacles]
        self._fixed = _shapes(fixed, [NOBODY] * len(fixed))
        bodies = [kind.body for kind in team.kinds]
        self._ahead = np.array([0.5 * (body.front - body.rear) for body in bodies])
        half = np.array([[0.5 * body.length, 0.5 * body.width] for body in bodies])
        self._body = half, np.array([body.round for body in bodies])
        self._height = np.array([body.height for body in bodies])
        self._seen = None, None

    def at(self, state):
        """Return the ``Shapes`` of obstacles and robots at ``state``."""
        if self._seen[0] is not state:  # several sensors look at the same time
            self._seen = state, self._shapes_at(state)
        return self._seen[1]

    def _shapes_at(self, state):
        cos, sin = cos_sin(state.pose[:, 2])
        axis, low = np.stack([cos, sin], axis=1), state.heights()
        centre = state.pose[:, :2] + self._ahead[:, np.newaxis] * axis
        robots = centre, axis, *self._body, low, low + self._height, np.arange(len(low))
        return Shapes(*map(np.concatenate, zip(self._fixed, robots)))


def _of_obstacle(obstacle):
    if isinstance(obstacle, Cylinder):
        size = [obstacle.radius, obstacle.radius]
        return [obstacle.x, obstacle.y], [1.0, 0.0], size, True, obstacle.height
    axis = [np.cos(obstacle.yaw), np.sin(obstacle.yaw)]
    size = [0.5 * obstacle.length, 0.5 * obstacle.width]
    return [obstacle.x, obstacle.y], axis, size, False, obstacle.height


def _shapes(rows, owner):
    centre, axis, half, is_round, high = zip(*rows) if rows else ([], [], [], [], [])
    return Shapes(
        np.array(centre, dtype=float).reshape(-1, 2),
        np.array(axis, dtype=float).reshape(-1, 2),
        np.array(half, dtype=float).reshape(-1, 2),
        np.array(is_round, dtype=bool),
        np.zeros(len(rows)),
        np.array(high, dtype=float),
        np.array(owner, dtype=int),
    )


class Rays(NamedTuple):
    """K rays of each of m robots, level."""

    origin: np.ndarray  # (m, K, 2) or (m, 1, 2) [m]
    direction: np.ndarray  # (m, K, 2), unit vectors
    height: np.ndarray  # (m,) [m]
    owner: np.ndarray  # (m,) rows of the robots that cast them, whose own bodies they do not meet


def cast(shapes, rays, reach, cone=0.0, unseen=None):
    """Return how far it is to the nearest of ``shapes`` along ``rays``, (m, K) [m], inf beyond ``reach``.

    ``cone`` [rad]: half of an opening angle below pi/2, within which the nearest point counts, as for the
    echo of a sonar.  A shape around the origin is at 0.  ``unseen`` (m,): rows of further robots not met.
    """
    m, k = rays.direction.shape[:2]
    result = np.full((m, k), np.inf)
    ray, shape = _near(shapes, rays, reach, unseen)
    length = max(1, MOST // max(1, k))
    for begin in range(0, len(ray), length):
        part = slice(begin, begin + length)
        _take(result, ray[part], _distances(shapes, rays, ray[part], shape[part], cone))
    result[result > reach] = np.inf
    return result


def _near(shapes, rays, reach, unseen):
    """Return which rows of ``rays`` (p,) may meet which of ``shapes`` (p,), ordered by the rays."""
    hub = rays.origin[:, 0]
    slack = np.abs(rays.origin - hub[:, np.newaxis]).sum(axis=2).max(initial=0.0)
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


def _distances(shapes, rays, ray, shape, cone):
    """Return the distances (p, K) along rows ``ray`` of ``rays`` to the shapes ``shape`` (p,)."""
    axis, half = shapes.axis[shape][:, np.newaxis], shapes.half[shape][:, np.newaxis]
    away = rays.origin[ray] - shapes.centre[shape][:, np.newaxis]
    origin = _turned(away, axis)
    direction = _turned(rays.direction[ray], axis)
    is_round = shapes.round[shape]
    result = np.full(direction.shape[:2], np.inf)
    for which, meet, nearest in (
        (~is_round, _meet_box, _near_box),
        (is_round, _meet_disc, _near_disc),
    ):
        if not which.any():
            continue
        at, size, along = origin[which], half[which], direction[which]
        if not cone:
            result[which] = meet(at, along, size)
            continue
        found = nearest(at, along, size, np.cos(cone))
        for side in (-cone, cone):
            edge = np.array([[[np.cos(side), np.sin(side)]]])
            turned = np.stack(
                [
                    along[..., 0] * edge[..., 0] - along[..., 1] * edge[..., 1],
                    along[..., 0] * edge[..., 1] + along[..., 1] * edge[..., 0],
                ],
                axis=-1,
            )
            found = np.minimum(found, meet(at, turned, size))
        result[which] = found
    return result


def _turned(vectors, axis):
    """Return ``vectors`` (p, K, 2) along and across ``axis`` (p, 1, 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    cos, sin = axis[..., 0], axis[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def _meet_box(origin, direction, half):
    """Return the way (p, K) [m] from ``origin`` to the box of ``half`` sizes about 0, inf if none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (-half - origin) / direction, (half - origin) / direction
    # 0/0, a ray along a face, is that of the other face.
    enter = np.fmin(first, second).max(axis=-1)
    leave = np.fmax(first, second).min(axis=-1)
    return np.where((enter <= leave) & (leave >= 0.0), np.maximum(enter, 0.0), np.inf)


def _meet_disc(origin, direction, half):
    """Return the way (p, K) [m] from ``origin`` to the disc about 0, inf if none."""
    along = (origin * direction).sum(axis=-1)
    inner = along * along - (origin * origin).sum(axis=-1) + half[..., 0] ** 2
    root = np.sqrt(np.maximum(inner, 0.0))
    return np.where((inner >= 0.0) & (root >= along), np.maximum(-along - root, 0.0), np.inf)


def _near_box(origin, direction, half, cos):
    """Return how far the box's nearest point is, (p, K) [m], inf where that is outside the cone."""
    return _within(np.clip(origin, -half, half) - origin, direction, cos)


def _near_disc(origin, direction, half, cos):
    """Return how far the disc's nearest point is, (p, K) [m], inf where that is outside the cone."""
    far = np.sqrt((origin * origin).sum(axis=-1))
    share = np.minimum(half[..., 0] / np.maximum(far, 1e-300), 1.0)
    return _within((share - 1.0)[..., np.newaxis] * origin, direction, cos)


def _within(way, direction, cos):
    far = np.sqrt((way * way).sum(axis=-1))
    return np.where((way * direction).sum(axis=-1) >= cos * far, far, np.inf)
