"""Bounds of single robots that the safety filter keeps: obstacles, an arena's border, caps of speed."""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.scenario.surroundings.moving_obstacles import advance, moves, obstacles_at
from mrs_simulator.scenario.surroundings.obstacles import clearance, is_flat


class Bounds(NamedTuple):
    """Half-planes, or half-spaces, that robots' controlled points stay in, k of them."""

    robot: np.ndarray  # (k,) rows of the robots
    way_out: np.ndarray  # (k, d) unit vectors into the free half-plane
    gap: np.ndarray  # (k,) [m] how far inside the point is
    turns: np.ndarray  # (k,) [m] gaps from which on the robot turns aside
    comes: np.ndarray  # (k,) [m/s] how fast the border of the half-plane comes, 0 for what stands

    def least(self, n):
        """Return the least gap of each of n robots, (n,) [m]; inf for those without bounds."""
        least = np.full(n, np.inf)
        if len(self.gap):
            np.minimum.at(least, self.robot, self.gap)
        return least


NO_BOUNDS = Bounds(np.empty(0, dtype=int), np.empty((0, 2)), *np.empty((3, 0)))


class Surroundings(NamedTuple):
    """What the safety filter keeps a team from, besides other robots."""

    obstacles: Tuple = ()  # of scenario.surroundings.obstacles
    arena: Tuple[float, ...] = ()  # (x_min, y_min, x_max, y_max) [m], or ()
    speed: Optional[np.ndarray] = None  # (n,) [m/s] of the controlled points at most
    sensed: Tuple[str, ...] = ()  # sensors of other robots and obstacles; () where these are known
    sees: bool = False  # whether robots are seen one by one, by one of these sensors
    afloat: Optional[np.ndarray] = None  # (n,) bool, robots that land keeps off; None: all

    @property
    def fastest(self):
        """Return the top speed [m/s] of obstacles that move, 0 where none does."""
        return max((each.track.speed for each in self.obstacles if moves(each)), default=0.0)

    def standing(self):
        """Return the surroundings without obstacles that move."""
        still = tuple(each for each in self.obstacles if not moves(each))
        return self._replace(obstacles=still)

    def bounds(self, points, reach, time=0.0, period=0.0):
        """Return the :class:`Bounds` of robots whose ``points`` (n, d) stay ``reach`` (n,) [m] away.

        An obstacle is convex: it lies behind the line through its point nearest to a robot, across the
        way there, so that no robot in front of that line touches it.  Points in space, (n, 3), also
        pass over it; the arena's border has no upper edge.  ``time`` [s] gives where obstacles on tracks
        are, and how fast their lines come while velocities are held for ``period`` [s].
        """
        if not (self.obstacles or self.arena):
            return NO_BOUNDS
        found = self._found(points, time)
        gap = np.concatenate([far - reach for far, _ in found])
        way_out = np.concatenate([out for _, out in found])
        robot = np.concatenate([np.arange(len(points))] * len(found))
        comes = self._coming(found, time, period)
        bounds = Bounds(robot, way_out, gap, np.concatenate([reach] * len(found)), comes)
        land = self._land(found)
        if self.afloat is None or not any(land):
            return bounds
        kept = ~land[:, np.newaxis] | self.afloat
        return Bounds(*(each[kept.ravel()] for each in bounds))

    def least_gaps(self, points, reach):
        """Return the least gaps (n,) of :meth:`bounds` as it begins, inf without any."""
        if not (self.obstacles or self.arena):
            return np.full(len(points), np.inf)
        found = self._found(points)
        gap = np.array([far for far, _ in found]) - reach
        if self.afloat is not None:
            gap[self._land(found)[:, np.newaxis] & ~self.afloat] = np.inf
        return gap.min(axis=0)

    def gaps(self, points, reach, rows):
        """Return the gaps (b, k, m) [m] of robots ``rows`` (m,) at places ``points`` (k, m, d) from each
        obstacle, as it begins, and border, and the unit vectors out of them, (b, k, m, d).

        ``reach`` (m,) [m] is kept; inf from land for those on land.
        """
        shape, found = points.shape, self._found(points.reshape(-1, points.shape[-1]))
        gap = np.array([far for far, _ in found]).reshape((-1,) + shape[:2]) - reach
        if self.afloat is not None:
            free = self._land(found)[:, np.newaxis] & ~self.afloat[rows]
            gap = np.where(free[:, np.newaxis], np.inf, gap)
        return gap, np.array([out for _, out in found]).reshape((-1,) + shape)

    def _found(self, points, time=0.0):
        """Return distances (n,) of ``points`` (n, d) from each obstacle and border, and ways out (n, d)."""
        places = points[:, :2]
        found = [clearance(obstacle, places) for obstacle in obstacles_at(self.obstacles, time)]
        borders = _borders(self.arena, places) if self.arena else []
        if points.shape[1] == 3:
            heights = [obstacle.height for obstacle in self.obstacles]
            found = [_with_top(*each, points[:, 2], top) for each, top in zip(found, heights)]
            borders = [(far, np.column_stack([out, np.zeros(len(out))])) for far, out in borders]
        return found + borders

    def _land(self, found):
        """Return which of the obstacles and borders ``found`` are land, (b,) bool."""
        land = [is_flat(obstacle) for obstacle in self.obstacles]
        return np.array(land + [False] * (len(found) - len(land)), dtype=bool)

    def _coming(self, found, time, period):
        """Return how fast the borders ``found``, obstacles' first, come towards points, (k,) [m/s]."""
        if not (period and self.fastest):
            return np.zeros(sum(len(far) for far, _ in found))
        still = [np.zeros(len(far)) for far, _ in found[len(self.obstacles) :]]
        coming = [
            advance(obstacle, time, period, out[:, :2])
            for obstacle, (_, out) in zip(self.obstacles, found)
        ]
        return np.concatenate(coming + still)


def _with_top(far, out, z, top):
    """Return the distances (n,) and ways out (n, 3) of points at heights ``z`` (n,) from a prism.

    ``far`` (n,) and ``out`` (n, 2): those in the plane; ``top`` [m]: the prism's height.
    """
    above = z - top
    over, beside = np.maximum(above, 0.0), np.maximum(far, 0.0)
    distance = np.hypot(over, beside)
    # Over it the nearest face is the top; beside it what is nearer of edge and side.
    share = np.where(distance > 0.0, [over, beside], [[0.0], [1.0]]) / np.where(
        distance > 0.0, distance, 1.0
    )
    climbs = (distance == 0.0) & (above > far)
    share = np.where(climbs, [[1.0], [0.0]], share)
    gap = np.where(distance > 0.0, distance, np.maximum(above, far))
    return gap, np.column_stack([out * share[1][:, np.newaxis], share[0]])


def _borders(arena, points):
    """Return the distances (n,) and inward normals (n, 2) of the arena's four sides."""
    x_min, y_min, x_max, y_max = arena
    (x, y), n = points.T, len(points)
    sides = (x - x_min, (1.0, 0.0)), (x_max - x, (-1.0, 0.0))
    sides += (y - y_min, (0.0, 1.0)), (y_max - y, (0.0, -1.0))
    return [(far, np.full((n, 2), normal)) for far, normal in sides]
