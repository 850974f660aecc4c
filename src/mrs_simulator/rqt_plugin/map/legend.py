"""Draws what the signs of the map mean."""

import numpy as np
from python_qt_binding.QtCore import QLineF, QPointF, QRectF, Qt
from python_qt_binding.QtGui import QBrush, QColor, QPen

from mrs_simulator.rqt_plugin.map.edge_drawing import EDGE_WIDTH, draw_heads
from mrs_simulator.rqt_plugin.map.look import faded
from mrs_simulator.rqt_plugin.map.marks import SHADE
from mrs_simulator.study.figure_parts import START_COLOUR

LEGEND = {  # in the order of the map's words
    "start": "start",
    "trail": "path so far",
    "target": "wanted place",
    "hears": "to the robot that hears",
    "edge": "robots that hear each other",
    "real": "real robot",
    "stale": "not heard lately",
    "aloft": "in the air, above its shade",
}


def draw_legend(painter, look, frame, shown):
    """Say in the lower left corner what the signs of the map mean: those in ``shown``, names."""
    area, line = frame.area, look.line
    entries = [name for name in LEGEND if name in shown]
    width = 2.6 * line + max(
        [painter.fontMetrics().horizontalAdvance(LEGEND[name]) for name in entries] + [0]
    )
    height = (1.2 * len(entries) + 0.3) * line
    if not entries or 2.5 * width > area.width() or 2.0 * height > area.height():
        return  # there is no room for words
    left, top = area.left() + 0.4 * line, area.bottom() - 0.4 * line - height
    painter.setPen(QPen(look.mixed(0.25), 1))
    painter.setBrush(faded(look.base, 0.85))
    painter.drawRect(QRectF(left, top, width, height))
    for place, name in enumerate(entries):
        y = top + (1.2 * place + 0.75) * line
        _draw_sign(painter, look, name, QPointF(left + 1.1 * line, y))
        painter.setPen(look.text)
        box = QRectF(left + 2.1 * line, y - line, width, 2.0 * line)
        painter.drawText(box, Qt.AlignLeft | Qt.AlignVCenter, LEGEND[name])


def _draw_sign(painter, look, name, at):
    """Draw the sign called ``name`` about the point ``at``."""
    unit, reach = look.unit, 0.65 * look.line
    x, y = at.x(), at.y()
    painter.setBrush(Qt.NoBrush)
    if name == "start":
        painter.setPen(Qt.NoPen)
        painter.setBrush(QColor(START_COLOUR))
        painter.drawEllipse(at, 3.0 * unit, 3.0 * unit)
    elif name == "target":
        painter.setPen(QPen(look.mixed(0.8), 1.8 * unit))
        size = 4.0 * unit
        painter.drawLine(QLineF(x - size, y - size, x + size, y + size))
        painter.drawLine(QLineF(x - size, y + size, x + size, y - size))
    elif name == "trail":
        painter.setPen(QPen(look.mixed(0.8), 1.4 * unit, Qt.DashLine))
        painter.drawLine(QLineF(x - reach, y, x + reach, y))
    elif name in ("hears", "edge"):
        begin, end = np.array([[x - reach, y]]), np.array([[x + reach, y]])
        painter.setPen(QPen(look.mixed(0.5), EDGE_WIDTH * unit))
        painter.drawLine(QLineF(x - reach, y, x + reach, y))
        if name == "hears":
            width = np.array([EDGE_WIDTH * unit])
            draw_heads(painter, look, begin, end, width, look.mixed(0.5))
    elif name == "real":
        painter.setPen(QPen(look.text, 2.0 * unit))
        painter.drawEllipse(at, 0.45 * look.line, 0.45 * look.line)
    elif name == "aloft":
        painter.setPen(Qt.NoPen)
        for shade, shift in ((faded(look.text, SHADE), 5.0 * unit), (look.mixed(0.6), 0.0)):
            painter.setBrush(shade)
            painter.drawEllipse(QPointF(x + shift, y + shift), 4.0 * unit, 4.0 * unit)
    elif name == "stale":
        painter.setPen(Qt.NoPen)
        painter.setBrush(QBrush(look.mixed(0.5), Qt.BDiagPattern))
        painter.drawRect(QRectF(x - 0.5 * reach, y - 0.5 * reach, reach, reach))
