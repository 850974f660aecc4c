"""Puts several robots in order: poses (k, 3) [m, m, rad] in, poses (k, 3) out."""

import functools

import numpy as np

GRID = 0.5  # [m] to whose multiples robots snap
X, Y = 0, 1  # columns of poses


def aligned(poses, axis):
    """Return ``poses`` with the same x (``axis`` 0) or y (1), the mean of theirs."""
    result = poses.copy()
    result[:, axis] = poses[:, axis].mean()
    return result


def distributed(poses, axis):
    """Return ``poses`` evenly spaced along x or y between the first and the last, in their order."""
    result, order = poses.copy(), np.argsort(poses[:, axis], kind="stable")
    ends = poses[order[[0, -1]], axis]
    result[order, axis] = np.linspace(*ends, len(poses))
    return result


def snapped(poses, step=GRID):
    """Return ``poses`` at the nearest multiples of ``step`` [m]; headings stay."""
    result = poses.copy()
    result[:, :2] = np.round(poses[:, :2] / step) * step
    return result


def parallel(poses):
    """Return ``poses`` that all head the way of the first."""
    result = poses.copy()
    result[:, 2] = poses[0, 2]
    return result


# text, least number of robots, what it makes of their poses
ARRANGEMENTS = (
    ("Align: same x", 2, functools.partial(aligned, axis=X)),
    ("Align: same y", 2, functools.partial(aligned, axis=Y)),
    ("Align: same heading", 2, parallel),
    ("Distribute along x", 3, functools.partial(distributed, axis=X)),
    ("Distribute along y", 3, functools.partial(distributed, axis=Y)),
    ("Snap to 0.5 m", 1, snapped),
)
