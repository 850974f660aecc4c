"""Draws the obstacle being edited, with its handles."""

import numpy as np

from mrs_simulator.pictures.plan import obstacle_outline
from mrs_simulator.rqt_plugin.map.geometry import REACH
from mrs_simulator.rqt_plugin.map.marks import ALARM
from mrs_simulator.rqt_plugin.map.obstacle_shapes import TURN, handles
from mrs_simulator.rqt_plugin.map.style import faded, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPen

MARK = 3.5  # [px] half of a mark's side
ABOVE = 3.0 * REACH + 8.0  # [px] from an obstacle to its name


def draw_edited(painter, style, frame, obstacle, refused):
    """Draw ``obstacle`` and its marks; in red where it is ``refused``."""
    shade = QColor(ALARM) if refused else style.highlight
    painter.setPen(QPen(shade, 2.0 * style.unit))
    painter.setBrush(faded(shade, 0.25))
    painter.drawPolygon(polygon(frame.to_screen(obstacle_outline(obstacle))))
    places = handles(obstacle, REACH * style.unit / frame.scale)
    screen = {name: frame.to_screen(place) for name, place in places.items()}
    painter.setBrush(style.base)
    if TURN in screen:
        ahead = 0.5 * obstacle.length * np.array([np.cos(obstacle.yaw), np.sin(obstacle.yaw)])
        front = frame.to_screen(ahead + [obstacle.x, obstacle.y])
        painter.drawLine(QLineF(*front, *screen[TURN]))
    half = MARK * style.unit
    painter.setPen(QPen(shade, 1.5 * style.unit, Qt.SolidLine))
    for name, (x, y) in screen.items():
        if name == TURN:
            painter.drawEllipse(QPointF(x, y), 1.3 * half, 1.3 * half)
        else:
            painter.drawRect(QRectF(x - half, y - half, 2.0 * half, 2.0 * half))
    _draw_size(painter, style, frame, obstacle)


def _draw_size(painter, style, frame, obstacle):
    """Write the obstacle's name and size above it."""
    if hasattr(obstacle, "radius"):
        text = "{}  r = {:g} m".format(obstacle.name, obstacle.radius)
        top = obstacle.radius
    else:
        text = "{}  {:g} \u00d7 {:g} m".format(obstacle.name, obstacle.length, obstacle.width)
        along = 0.5 * obstacle.length * np.abs(np.sin(obstacle.yaw))
        top = along + 0.5 * obstacle.width * np.abs(np.cos(obstacle.yaw))
    x, y = frame.to_screen((obstacle.x, obstacle.y + top))
    width = painter.fontMetrics().horizontalAdvance(text) + 0.8 * style.line
    box = QRectF(x - 0.5 * width, y - ABOVE * style.unit - style.line, width, 1.2 * style.line)
    area = frame.area
    box.moveTop(min(max(box.top(), area.top()), area.bottom() - box.height()))
    painter.fillRect(box, faded(style.base, 0.85))
    painter.setPen(style.text)
    painter.drawText(box, Qt.AlignCenter, text)
