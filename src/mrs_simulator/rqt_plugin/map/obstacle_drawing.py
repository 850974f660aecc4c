"""Draws the obstacle under the user's hands, with the marks by which it is gripped."""

import numpy as np
from python_qt_binding.QtCore import QLineF, QPointF, QRectF, Qt
from python_qt_binding.QtGui import QColor, QPen

from mrs_simulator.rqt_plugin.map import axes
from mrs_simulator.rqt_plugin.map.geometry import GRIP
from mrs_simulator.rqt_plugin.map.look import faded
from mrs_simulator.rqt_plugin.map.marks import ALARM
from mrs_simulator.rqt_plugin.map.obstacle_shapes import TURN, grips

MARK = 3.5  # [px] half of a mark's side
ABOVE = 3.0 * GRIP + 8.0  # [px] from an obstacle to its name


def draw_edited(painter, look, frame, obstacle, refused):
    """Draw ``obstacle`` and its marks; in red where it is ``refused``."""
    shade = QColor(ALARM) if refused else look.highlight
    painter.setPen(QPen(shade, 2.0 * look.unit))
    painter.setBrush(faded(shade, 0.25))
    axes.draw_outline(painter, frame, obstacle)
    places = grips(obstacle, GRIP * look.unit / frame.scale)
    screen = {name: frame.to_screen(place) for name, place in places.items()}
    painter.setBrush(look.base)
    if TURN in screen:
        ahead = 0.5 * obstacle.length * np.array([np.cos(obstacle.yaw), np.sin(obstacle.yaw)])
        front = frame.to_screen(ahead + [obstacle.x, obstacle.y])
        painter.drawLine(QLineF(*front, *screen[TURN]))
    half = MARK * look.unit
    painter.setPen(QPen(shade, 1.5 * look.unit, Qt.SolidLine))
    for name, (x, y) in screen.items():
        if name == TURN:
            painter.drawEllipse(QPointF(x, y), 1.3 * half, 1.3 * half)
        else:
            painter.drawRect(QRectF(x - half, y - half, 2.0 * half, 2.0 * half))
    _draw_size(painter, look, frame, obstacle, shade)


def _draw_size(painter, look, frame, obstacle, shade):
    """Write the obstacle's name and size above it."""
    if hasattr(obstacle, "radius"):
        text = "{}  r = {:g} m".format(obstacle.name, obstacle.radius)
        top = obstacle.radius
    else:
        text = "{}  {:g} \u00d7 {:g} m".format(obstacle.name, obstacle.length, obstacle.width)
        along = 0.5 * obstacle.length * np.abs(np.sin(obstacle.yaw))
        top = along + 0.5 * obstacle.width * np.abs(np.cos(obstacle.yaw))
    x, y = frame.to_screen((obstacle.x, obstacle.y + top))
    width = painter.fontMetrics().horizontalAdvance(text) + 0.8 * look.line
    box = QRectF(x - 0.5 * width, y - ABOVE * look.unit - look.line, width, 1.2 * look.line)
    area = frame.area
    box.moveTop(min(max(box.top(), area.top()), area.bottom() - box.height()))
    painter.fillRect(box, faded(look.base, 0.85))
    painter.setPen(look.text)
    painter.drawText(box, Qt.AlignCenter, text)
