"""Draws the map's legend."""

import math

import numpy as np

from mrs_simulator.pictures import signs
from mrs_simulator.pictures.scene import END_SHOWN, PATH_SHOWN
from mrs_simulator.rqt_plugin.map.forecast import WIDTH
from mrs_simulator.rqt_plugin.map.last_run import FAINT
from mrs_simulator.rqt_plugin.map.marks import ALARM, SHADE
from mrs_simulator.rqt_plugin.map.sensor_drawing import FELT, HIT
from mrs_simulator.rqt_plugin.map.style import faded
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPixmap
from mrs_simulator.rqt_plugin.view.painting import draw_layer, draw_lines, fill

HIGHEST = 0.5  # [-] of the area's height that the legend takes at most
WIDEST = 0.4, 0.6  # [-] of its width, in one column and in more
LINES = {"trail": 0.8, "last run": 0.8 * FAINT}  # [-] of the text's colour
LEGEND = {  # in the order of the map's words
    "start": "start",
    "trail": "trail",
    "last run": "the last run",
    "forecast": "predicted, to its end",
    "ahead": "what if, to its end",
    "target": "target",
    "directed edge": "edge to its receiver",
    "edge": "undirected edge",
    "real": "real robot",
    "stale": "no recent data",
    "aloft": "airborne, above its shadow",
    "cone": "sonar cone, arc at the echo",
    "rays": "laser scan, points at hits",
    "seen": "detected robot",
    "pressed": "bumper pressed",
}


def draw_legend(painter, style, frame, shown, kept):
    """Draw the legend of the signs ``shown``, names, in the lower left corner; ``kept``: a dict for it."""
    area, line = frame.area, style.line
    entries = [name for name in LEGEND if name in shown]
    columns = _columns(entries, int((HIGHEST * area.height() / line - 0.3) / 1.2))
    metrics = painter.fontMetrics()
    widths = [
        2.6 * line + max(metrics.horizontalAdvance(LEGEND[name]) for name in column)
        for column in columns
    ]
    if not columns or sum(widths) > WIDEST[len(columns) > 1] * area.width():
        return  # there is no room for words
    height = (1.2 * len(columns[0]) + 0.3) * line
    left, top = area.left() + 0.4 * line, area.bottom() - 0.4 * line - height
    ratio = painter.device().devicePixelRatioF()
    hues = style.base.rgba(), style.text.rgba(), style.highlight.rgba()
    look = hues, line, painter.font().key(), ratio, columns, widths
    if kept.get("look") != look:
        size = QSize(*(math.ceil(ratio * (side + 2.0)) for side in (sum(widths), height)))
        picture = QPixmap(size)
        picture.setDevicePixelRatio(ratio)
        picture.fill(Qt.transparent)
        on = QPainter(picture)
        on.setRenderHint(QPainter.Antialiasing)
        on.setFont(painter.font())
        _draw_entries(on, style, columns, widths, height)
        on.end()
        kept.update(look=look, picture=picture)
    painter.drawPixmap(QPointF(round(left), round(top)), kept["picture"])


def _draw_entries(painter, style, columns, widths, height):
    """Draw a box with the ``columns`` of entries, of these ``widths`` and ``height`` [px], at (1, 1)."""
    line, left, top = style.line, 1.0, 1.0
    painter.setPen(QPen(style.mixed(0.25), 1))
    painter.setBrush(faded(style.base, 0.85))
    painter.drawRect(QRectF(left, top, sum(widths), height))
    for column, width in zip(columns, widths):
        for place, name in enumerate(column):
            y = top + (1.2 * place + 0.75) * line
            _draw_sign(painter, style, name, QPointF(left + 1.1 * line, y))
            painter.setPen(style.text)
            box = QRectF(left + 2.1 * line, y - line, width, 2.0 * line)
            painter.drawText(box, Qt.AlignLeft | Qt.AlignVCenter, LEGEND[name])
        left += width


def _columns(entries, most):
    """Return ``entries`` in as few columns of about the same length as have at most ``most`` each."""
    if most < 1:
        return []
    each = math.ceil(len(entries) / max(1, math.ceil(len(entries) / most)))
    return [entries[begin : begin + each] for begin in range(0, len(entries), max(1, each))]


def _draw_sign(painter, style, name, at):
    """Draw the sign called ``name`` about the point ``at``."""
    unit, reach = style.unit, 0.65 * style.line
    x, y = at.x(), at.y()
    painter.setBrush(Qt.NoBrush)
    if name == "start":
        fill(painter, signs.starts(np.array([[x, y]]), 1, unit))
    elif name == "target":
        shade, place = style.mixed(0.8).getRgbF()[:3], np.array([[x, y]])
        draw_lines(painter, signs.crosses(place, [shade], shade, 1, unit))
    elif name in ("forecast", "ahead"):
        painter.setPen(QPen(style.mixed(PATH_SHOWN), WIDTH * unit))
        painter.drawLine(QLineF(x - reach, y, x, y))
        place, shade = np.array([[x + 0.5 * reach, y]]), style.mixed(END_SHOWN).getRgbF()
        draw_layer(painter, signs.rings(place, [shade], 1, unit))
    elif name in ("trail", "last run"):
        painter.setPen(QPen(style.mixed(LINES[name]), 1.4 * unit, Qt.DashLine))
        painter.drawLine(QLineF(x - reach, y, x + reach, y))
    elif name in ("directed edge", "edge"):
        ends = np.array([[x - reach, y]]), np.array([[x + reach, y]]), [1.0]
        shade = style.mixed(0.5).getRgbF()
        for layer in signs.edges(*ends, shade, name == "directed edge", unit):
            draw_layer(painter, layer)
    elif name == "real":
        painter.setPen(QPen(style.text, 2.0 * unit))
        painter.drawEllipse(at, 0.45 * style.line, 0.45 * style.line)
    elif name == "aloft":
        painter.setPen(Qt.NoPen)
        for shade, shift in ((faded(style.text, SHADE), 5.0 * unit), (style.mixed(0.6), 0.0)):
            painter.setBrush(shade)
            painter.drawEllipse(QPointF(x + shift, y + shift), 4.0 * unit, 4.0 * unit)
    elif name in ("cone", "rays", "seen", "pressed"):
        _draw_sensed(painter, style, name, x, y)
    elif name == "stale":
        painter.setPen(Qt.NoPen)
        painter.setBrush(QBrush(style.mixed(0.5), Qt.BDiagPattern))
        painter.drawRect(QRectF(x - 0.5 * reach, y - 0.5 * reach, reach, reach))


def _draw_sensed(painter, style, name, x, y):
    """Draw the sign ``name`` of a sensor's readings about the point (x, y) [px]."""
    unit, reach, shade = style.unit, 0.65 * style.line, style.mixed(0.6)
    box = QRectF(x - 3.0 * reach, y - 2.0 * reach, 4.0 * reach, 4.0 * reach)
    painter.setPen(QPen(shade, 1.6 * unit))
    if name == "cone":
        cone = QPainterPath(box.center())
        cone.arcTo(box, -17.0, 34.0)
        cone.closeSubpath()
        painter.fillPath(cone, faded(shade, 2.0 * FELT))
        painter.drawArc(box, -17 * 16, 34 * 16)
    elif name == "rays":
        painter.fillRect(
            QRectF(x - reach, y - 0.6 * reach, 2.0 * reach, 1.2 * reach), faded(shade, FELT)
        )
        painter.setPen(Qt.NoPen)
        painter.setBrush(shade)
        for place in (-0.5, 0.0, 0.5):
            painter.drawEllipse(QPointF(x + reach, y + place * reach), HIT * unit, HIT * unit)
    elif name == "seen":
        painter.setPen(QPen(shade, 1.2 * unit, Qt.DotLine))
        painter.drawLine(QLineF(x - reach, y, x + reach - 3.0 * unit, y))
        painter.drawEllipse(QPointF(x + reach, y), 3.0 * unit, 3.0 * unit)
    else:
        pen = QPen(QColor(ALARM), 3.5 * unit)
        pen.setCapStyle(Qt.FlatCap)
        painter.setPen(pen)
        painter.drawArc(box, -17 * 16, 34 * 16)
