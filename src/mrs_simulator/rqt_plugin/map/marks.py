"""Draws marks about robots and places: starts, targets, rings, alarms and collisions.

Each ``draw_`` function gets a painter, the ``MapStyle`` of the widget and the ``Frame``; positions are
arrays, one point per row, in metres.
"""

import numpy as np

from mrs_simulator.pictures import signs
from mrs_simulator.pictures.signs import SOME_ROBOTS
from mrs_simulator.rqt_plugin.map.geometry import ARROW, outlines
from mrs_simulator.rqt_plugin.map.style import faded, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPen
from mrs_simulator.rqt_plugin.view.painting import draw_lines, fill

FLASH = 2.0  # [s], how long a collision's ring is seen
SHADE = 0.25  # opacity of what lies below a robot in the air
LEAST_SHIFT, SHIFT, MOST_SHIFT = 3.0, 7.0, 45.0  # [px], of that: at least, times root z, at most
ALARM = "#e01b24"


def draw_starts(painter, style, frame, starts, team=None):
    """Draw red points where the robots began, of the size that suits all ``team``, if given."""
    screen = frame.to_screen(starts)
    count = len(starts if team is None else team)
    fill(painter, signs.starts(screen[frame.sees(screen, 9.0)], count, style.unit))


def draw_targets(painter, style, frame, targets, numbers):
    """Draw a small cross at each desired position, in the colour of its robot."""
    screen, text = frame.to_screen(targets), np.array(style.text.getRgbF()[:3])
    rows = np.flatnonzero(frame.sees(screen, style.line))
    shades = np.tile(text, (len(rows), 1))
    if len(numbers) == len(targets):
        shades = style.shades_of(np.array(numbers)[rows], True)
    draw_lines(painter, signs.crosses(screen[rows], shades, text, len(targets), style.unit))


def draw_shadows(painter, style, frame, pose, shapes, z):
    """Draw a shade below each of the robots of ``pose`` (n, 3) at heights ``z`` (n,) [m] above the ground.

    It lies the farther to the lower right, the higher its robot is, by as much at any scale.
    """
    painter.setPen(Qt.NoPen)
    painter.setBrush(faded(style.text, SHADE))
    shift = np.minimum(LEAST_SHIFT + SHIFT * np.sqrt(z), MOST_SHIFT) * style.unit
    radii = np.maximum(shapes.reach * frame.scale, 0.5 * ARROW * style.unit)
    middles = frame.to_screen(pose) + shift[:, np.newaxis]
    for (x, y), radius in zip(middles.tolist(), radii.tolist()):
        painter.drawEllipse(QPointF(x, y), radius, radius)


def draw_selection(painter, style, frame, pose, shapes):
    """Draw a disc under the robots of ``pose`` (n, 3)."""
    painter.setPen(QPen(style.highlight, 2.0 * style.unit))
    painter.setBrush(faded(style.highlight, 0.25))
    _draw_rings(painter, frame, pose, shapes, 1.35, 12.0 * style.unit)


def draw_real(painter, style, frame, pose, shapes):
    """Draw a ring about the robots of ``pose`` (n, 3), which are real ones."""
    painter.setPen(QPen(style.text, 2.0 * style.unit))
    painter.setBrush(Qt.NoBrush)
    _draw_rings(painter, frame, pose, shapes, 1.15, 10.0 * style.unit)


def _draw_rings(painter, frame, pose, shapes, factor, least):
    """Draw a circle of ``factor`` times its reach, at least ``least`` [px], about each robot's middle."""
    heading = np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)
    ahead = 0.5 * (shapes.front - shapes.rear)
    middles = frame.to_screen(pose[:, :2] + ahead[:, np.newaxis] * heading)
    radii = np.maximum(factor * shapes.reach * frame.scale, least)
    for (x, y), radius in zip(middles.tolist(), radii.tolist()):
        painter.drawEllipse(QPointF(x, y), radius, radius)


def draw_alarms(painter, style, frame, pose, shapes):
    """Outline in red the robots of ``pose`` (n, 3)."""
    pen = QPen(QColor(ALARM), 3.0 * style.unit)
    pen.setJoinStyle(Qt.MiterJoin)
    painter.setPen(pen)
    painter.setBrush(Qt.NoBrush)
    for shape in outlines(pose, frame, style.unit, shapes):
        painter.drawPolygon(polygon(shape))


def draw_flash(painter, style, frame, place, age):
    """Draw the ring of a collision ``age`` [s] ago at ``place`` (2,); of many robots a small, thin one."""
    share, few = age / FLASH, style.count <= SOME_ROBOTS
    least, width = (10.0, 4.0) if few else (5.0, 1.5)
    radius = max((0.35 if few else 0.2) * frame.scale, least * style.unit) * (0.7 + 0.8 * share)
    painter.setPen(QPen(faded(QColor(ALARM), 1.0 - share), width * style.unit))
    painter.setBrush(Qt.NoBrush)
    painter.drawEllipse(QPointF(*frame.to_screen(place)), radius, radius)
