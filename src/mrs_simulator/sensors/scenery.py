"""The surroundings of sensors as shapes, and ray casting in the plane.

Obstacles, walls and robots are upright boxes and cylinders; a sensor looks level, at its own height.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core import compiling
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.scenario.surroundings.moving_obstacles import moves
from mrs_simulator.scenario.surroundings.obstacles import Cylinder

NO_ROBOT = -1
TINY = 1e-300  # [-] instead of 0, of a ray along a face
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

    @property
    def reach(self):
        """Return how far they reach from their centres, (N,) [m]."""
        return np.where(self.round, self.half[:, 0], np.hypot(self.half[:, 0], self.half[:, 1]))


class Scenery:
    """The obstacles of a scene and the bodies of a team."""

    def __init__(self, team, obstacles=(), picture=None):
        """``team``: the ``vehicles.Team``; ``obstacles``: ``Box`` and ``Cylinder``.

        ``picture(state, eye, ahead, settings)``: image and depth of a camera at ``eye`` (3,) that looks
        along ``ahead`` (3,).
        """
        self.picture = picture
        fixed = [_of_obstacle(each) for each in obstacles]
        self._moving = [(row, each) for row, each in enumerate(obstacles) if moves(each)]
        self._fixed = _shapes(fixed, [NO_ROBOT] * len(fixed))
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
        axis, low = np.stack([cos, sin], axis=1), state.heights
        centre = state.pose[:, :2] + self._ahead[:, np.newaxis] * axis
        robots = centre, axis, *self._body, low, low + self._height, np.arange(len(low))
        return Shapes(*map(np.concatenate, zip(self._fixed_at(state.time), robots)))

    def _fixed_at(self, time):
        """Return the ``Shapes`` of the obstacles at ``time`` [s]."""
        if not self._moving:
            return self._fixed
        centre = self._fixed.centre.copy()
        for row, each in self._moving:
            centre[row] = each.track.place((each.x, each.y), time)
        return self._fixed._replace(centre=centre)


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
    """Return the distances along ``rays`` to the nearest of ``shapes``, (m, K) [m], inf beyond ``reach``.

    ``cone`` [rad]: half of an opening angle below pi/2, within which the nearest point counts, as for the
    echo of a sonar.  A shape around the origin is at 0.  ``unseen`` (m,): rows of further robots not met.
    With ``MRS_SIMULATOR_COMPILED=1`` loops that numba compiles do the same.
    """
    if compiling.is_wanted():
        from mrs_simulator.sensors.compiled_rays import (  # numba is optional
            cast_by,
            compiled_kernel,
        )

        return cast_by(compiled_kernel(), shapes, rays, reach, cone, unseen)
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
    """Return pairs of rows of ``rays`` (p,) and ``shapes`` (p,) that may meet, ordered by the rays."""
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
