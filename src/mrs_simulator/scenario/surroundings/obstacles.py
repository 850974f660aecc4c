"""Obstacles of a scene: boxes and upright cylinders; a wall is a long thin box, land a flat one."""

import math
from typing import Any, NamedTuple

import numpy as np


class Box(NamedTuple):
    """An upright box: centre (x, y) [m], ``yaw`` [rad], length along and width across it [m]."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    height: float
    track: Any = None  # ``moving_obstacles.Track`` on which it moves, None for one that stands


class Cylinder(NamedTuple):
    """An upright cylinder: centre (x, y), radius, height [m]."""

    name: str
    x: float
    y: float
    radius: float
    height: float
    track: Any = None  # ``moving_obstacles.Track`` on which it moves, None for one that stands


def is_flat(obstacle):
    """Return whether an ``obstacle`` lies level with the ground: land, on which only boats run aground."""
    return obstacle.height == 0.0


def corners(obstacle):
    """Return the four corners of a box, or of a square around a cylinder, shape (4, 2) [m]."""
    if isinstance(obstacle, Cylinder):
        yaw, length, width = 0.0, 2.0 * obstacle.radius, 2.0 * obstacle.radius
    else:
        yaw, length, width = obstacle.yaw, obstacle.length, obstacle.width
    along = 0.5 * length * np.array([np.cos(yaw), np.sin(yaw)])
    across = 0.5 * width * np.array([-np.sin(yaw), np.cos(yaw)])
    centre = np.array([obstacle.x, obstacle.y])
    return centre + [along + across, across - along, -along - across, along - across]


def with_obstacles(low, high, obstacles, reach):
    """Return the bounds ``low`` and ``high`` (2,) [m] of a drawing, widened to show ``obstacles``.

    Those farther than ``reach`` [m], the far parts of large ones, and land, which may go on for long,
    are left out: the team keeps its scale.
    """
    least, most = low - reach, high + reach
    for each in (corners(obstacle) for obstacle in obstacles if not is_flat(obstacle)):
        if np.all(each.max(axis=0) >= least) and np.all(each.min(axis=0) <= most):
            low = np.minimum(low, np.maximum(each.min(axis=0), least))
            high = np.maximum(high, np.minimum(each.max(axis=0), most))
    return low, high


def wall(name, start, end, thickness, height):
    """Return the ``Box`` that stands on the segment from ``start`` to ``end``, (x, y) [m] each."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        raise ValueError("wall {}: from and to are the same point {}".format(name, list(start)))
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    return Box(name, middle[0], middle[1], math.atan2(dy, dx), length, thickness, height)


def clearance(obstacle, points):
    """Return how far ``points`` (n, 2) are from ``obstacle``, (n,) [m], and the way out, (n, 2) [-].

    Negative inside, where the way out leads to the nearest face.  The obstacle lies in the half-plane
    behind the point nearest to each, across its way out: it is convex.
    """
    away = np.asarray(points, dtype=float) - [obstacle.x, obstacle.y]
    if isinstance(obstacle, Cylinder):
        far = np.hypot(*away.T)
        return far - obstacle.radius, _directions(away, far)
    cos, sin = math.cos(obstacle.yaw), math.sin(obstacle.yaw)
    turn = np.array([[cos, sin], [-sin, cos]])  # rows: the box's axes in the common frame
    own = away @ turn.T
    beyond = np.abs(own) - 0.5 * np.array([obstacle.length, obstacle.width])
    side = np.where(own < 0.0, -1.0, 1.0)
    outside = np.maximum(beyond, 0.0)
    far = np.hypot(*outside.T)
    within = far == 0.0
    # Inside, or on an edge, the nearest face is the one that is least far behind.
    face = np.eye(2)[np.argmax(beyond, axis=1)]
    out = np.where(within[:, np.newaxis], face, _directions(outside, far))
    return np.where(within, beyond.max(axis=1), far), (side * out) @ turn


def least_clearance(obstacles, points):
    """Return how far ``points`` (n, 2) are from the nearest of ``obstacles``, (n,) [m]; negative inside."""
    return np.min([clearance(each, points)[0] for each in obstacles], axis=0)


def _directions(vectors, length):
    """Return ``vectors`` (n, 2) over their ``length`` (n,); the x axis for those without one."""
    known = (length > 0.0)[:, np.newaxis]
    return np.where(known, vectors / np.where(known, length[:, np.newaxis], 1.0), [1.0, 0.0])
