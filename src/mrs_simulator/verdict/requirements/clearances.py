"""Clearances of bodies: the distances of upright prisms over the outlines of robots and obstacles.

Independent of how the world finds contacts, and of how the safety filter keeps bodies apart.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.scenario.surroundings.moving_obstacles import moves, obstacles_at
from mrs_simulator.scenario.surroundings.obstacles import Cylinder


class Prism(NamedTuple):
    """An upright prism on its way: corners (m, c, 2) [m], rounded by ``radius``, heights (m,)."""

    corners: np.ndarray
    radius: float
    low: np.ndarray
    high: np.ndarray

    @property
    def middle(self):
        """Return the middles, (m, 2) [m], and the distance [m] from them to the farthest point."""
        middle = self.corners.mean(axis=1)
        far = np.linalg.norm(self.corners - middle[:, np.newaxis], axis=2).max()
        return middle, far + self.radius

    def at(self, times):
        """Return the prism at the ``times``, rows of its arrays."""
        return Prism(self.corners[times], self.radius, self.low[times], self.high[times])


def of_robot(body, pose, z):
    """Return the ``Prism`` of a robot of outline ``body`` at ``pose`` (m, 3), heights ``z`` (m,)."""
    if body.round:
        return Prism(pose[:, np.newaxis, :2], body.front, z, z + body.height)
    x = np.array([body.front, body.front, -body.rear, -body.rear])
    y = 0.5 * body.width * np.array([-1.0, 1.0, 1.0, -1.0])
    return Prism(turned(pose[:, :2], pose[:, 2], x, y), 0.0, z, z + body.height)


def of_obstacle(obstacle, times):
    """Return the ``Prism`` of an obstacle, standing or on its track, at ``times`` (m,) [s]."""
    now = [obstacles_at((obstacle,), stamp)[0] for stamp in times] if moves(obstacle) else None
    places = [(each.x, each.y) for each in now] if now else [(obstacle.x, obstacle.y)] * len(times)
    places, low = np.array(places), np.zeros(len(times))
    if isinstance(obstacle, Cylinder):
        return Prism(places[:, np.newaxis], obstacle.radius, low, low + obstacle.height)
    x = 0.5 * obstacle.length * np.array([1.0, 1.0, -1.0, -1.0])
    y = 0.5 * obstacle.width * np.array([-1.0, 1.0, 1.0, -1.0])
    corners = turned(places, np.full(len(times), obstacle.yaw), x, y)
    return Prism(corners, 0.0, low, low + obstacle.height)


def turned(place, yaw, x, y):
    """Return the points (x, y), c of them, in frames at ``place`` (m, 2) and ``yaw`` (m,): (m, c, 2)."""
    cos, sin = np.cos(yaw)[:, np.newaxis], np.sin(yaw)[:, np.newaxis]
    return place[:, np.newaxis] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)


def to_segments(points, corners):
    """Return the least distance (m,) of ``points`` (m, p, 2) from the edges of ``corners`` (m, c, 2)."""
    begin, along = corners[:, np.newaxis], np.roll(corners, -1, axis=1) - corners
    along = along[:, np.newaxis]
    away = points[:, :, np.newaxis] - begin
    length = np.maximum((along**2).sum(axis=3), 1e-300)
    share = np.clip((away * along).sum(axis=3) / length, 0.0, 1.0)
    return np.linalg.norm(away - share[..., np.newaxis] * along, axis=3).min(axis=(1, 2))


def beyond_edges(points, corners):
    """Return how far all ``points`` are beyond that edge of ``corners`` beyond which they are farthest."""
    if corners.shape[1] == 1:
        return np.full(len(corners), -np.inf)
    along = np.roll(corners, -1, axis=1) - corners
    normal = np.stack([along[..., 1], -along[..., 0]], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    away = points[:, :, np.newaxis] - corners[:, np.newaxis]
    return (away * normal[:, np.newaxis]).sum(axis=3).min(axis=1).max(axis=1)


def clearance(a, b):
    """Return the distance (m,) [m] of two prisms, below 0 by how deep they are in each other."""
    # corners go round anticlockwise
    beyond = np.maximum(beyond_edges(a.corners, b.corners), beyond_edges(b.corners, a.corners))
    far = np.minimum(to_segments(a.corners, b.corners), to_segments(b.corners, a.corners))
    points = a.corners.shape[1] == b.corners.shape[1] == 1
    across = np.where((beyond > 0.0) | points, far, beyond) - a.radius - b.radius
    up = np.maximum(a.low - b.high, b.low - a.high)
    outside = np.hypot(np.maximum(across, 0.0), np.maximum(up, 0.0))
    return np.where(outside > 0.0, outside, np.maximum(across, up))
