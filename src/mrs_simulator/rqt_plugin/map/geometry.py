"""Robots on the screen: their outlines, the room about them, and the one under the mouse."""

import numpy as np

from mrs_simulator.study.draw.plane_figure import ROBOT_SHAPE

LEAST_ROBOT = 10.0  # [px]; a smaller one is drawn as an arrow of ARROW
ARROW = 13.0  # [px]
REACH = 6.0  # [px] about a robot or an edge within which the mouse hits it


def placed(shape, pose, frame):
    """Return the ``shape`` (k, 2) [m] of the robots' frame at each pose on the screen, (n, k, 2)."""
    return frame.to_screen(pose[:, np.newaxis, :2] + _turned(shape, pose[:, 2]))


def _turned(shape, theta):
    shape, cos, sin = np.asarray(shape), np.cos(theta), np.sin(theta)
    x = np.outer(cos, shape[:, 0]) - np.outer(sin, shape[:, 1])
    return np.stack([x, np.outer(sin, shape[:, 0]) + np.outer(cos, shape[:, 1])], axis=2)


def outlines(pose, frame, unit, shapes):
    """Return the outline of each robot on the screen: its footprint, or an arrow; (k, 2) each."""
    result, small = [None] * len(pose), are_arrows(frame, unit, shapes)
    for rows, footprint in shapes.by_kind():
        arrow = ARROW * unit / frame.scale * np.array(ROBOT_SHAPE)
        outline = arrow if len(rows) and small[rows[0]] else footprint
        for row, points in zip(rows.tolist(), placed(outline, pose[rows], frame)):
            result[row] = points
    return result


def are_arrows(frame, unit, shapes):
    """Return which robots (n,) are too small to be drawn to scale."""
    return shapes.length * frame.scale < LEAST_ROBOT * unit


def clearance(pose, toward, frame, unit, shapes):
    """Return how far [px] each robot's body reaches ``toward`` (n, 2), unit vectors of the plane."""
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    along = cos * toward[:, 0] + sin * toward[:, 1]
    across = cos * toward[:, 1] - sin * toward[:, 0]
    ends = np.where(along > 0.0, shapes.front, shapes.rear)
    with np.errstate(divide="ignore"):
        reach = np.minimum(ends / np.abs(along), shapes.half / np.abs(across))
    reach = np.where(shapes.round, shapes.front, reach) * frame.scale + unit
    return np.where(are_arrows(frame, unit, shapes), 0.55 * ARROW * unit, reach)


def apart(places, width, height):
    """Return rows of ``places`` (n, 2) [px] about which boxes of that size do not touch, by order."""
    taken, rows = {}, []
    for row, (x, y) in enumerate(places.tolist()):
        column, line = int(x // width), int(y // height)
        near = [(column + i, line + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        others = [taken[cell] for cell in near if cell in taken]
        if all(abs(x - u) >= width or abs(y - v) >= height for u, v in others):
            taken[column, line] = x, y
            rows.append(row)
    return rows


def robot_at(pose, frame, unit, at, shapes):
    """Return the row of the robot of ``pose`` (n, 3) at ``at`` (2,) [px], -1 for none."""
    apart = frame.to_plane(at) - pose[:, :2]
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    along = cos * apart[:, 0] + sin * apart[:, 1]
    across = np.abs(cos * apart[:, 1] - sin * apart[:, 0])
    pad, away = REACH * unit / frame.scale, np.hypot(along, across)
    # A comparison with nan, a pose that is not known, is false.
    with np.errstate(invalid="ignore"):
        within = (along < shapes.front + pad) & (along > -shapes.rear - pad)
        within &= across < shapes.half + pad
        within |= away * frame.scale < ARROW * unit
    return int(np.argmin(np.where(within, away, np.inf))) if within.any() else -1
