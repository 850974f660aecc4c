"""Draws the edges of the topology, and the one that is being added."""

import numpy as np

from mrs_simulator.pictures import signs
from mrs_simulator.rqt_plugin.map.style import faded
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPen
from mrs_simulator.rqt_plugin.view.painting import draw_layer, fill

SOME_EDGES = 30  # [-] in view; beyond, they are paler
MANY_EDGES = 400  # [-] in view; beyond, they are drawn without smoothing
MOST_EDGES = 4000  # [-] drawn


def draw_edges(painter, style, segments, directed):
    """Draw the ``segments``, wide by weight, with a head at the receiver.

    Of very many only one in k is drawn; return k.
    """
    stride = max(1, -(-len(segments.place) // MOST_EDGES))
    _, weight, begin, end = (values[::stride] for values in segments)
    many = len(weight) > MANY_EDGES
    shade = style.mixed(0.5 if len(weight) <= SOME_EDGES else 0.3)
    weight = np.zeros(len(weight)) if many else weight
    painter.setRenderHint(painter.Antialiasing, not many)
    for layer in signs.edges(begin, end, weight, shade.getRgbF(), directed, style.unit):
        draw_layer(painter, layer)
    painter.setRenderHint(painter.Antialiasing, True)
    return stride


def draw_head(painter, style, begin, end, width):
    """Draw the head at ``end`` of a highlighted edge from ``begin``, (2,) [px], of ``width`` [px]."""
    ends = np.array([begin]), np.array([end]), np.array([width])
    fill(painter, signs.heads(*ends, style.highlight.getRgbF(), style.unit))


def draw_hovered(painter, style, area, segment, directed, at, text):
    """Draw the edge under the mouse, from ``segment[0]`` to ``segment[1]`` [px].

    The lines of ``text`` stand in the corner of ``area`` that is farthest from the mouse ``at`` (2,) [px].
    """
    begin, end = segment
    painter.setPen(QPen(style.highlight, 3.0 * style.unit))
    painter.drawLine(QLineF(*begin, *end))
    if directed:
        draw_head(painter, style, begin, end, 3.0 * style.unit)
    if not text:
        return
    metrics, lines, gap = painter.fontMetrics(), text.split("\n"), 0.4 * style.line
    box = QRectF(0.0, 0.0, max(map(metrics.horizontalAdvance, lines)), len(lines) * style.line)
    box.adjust(-gap, -gap, gap, gap)
    left, top = at[0] > area.center().x(), at[1] > area.center().y()
    box.moveLeft(area.left() + gap if left else area.right() - gap - box.width())
    box.moveTop(area.top() + gap if top else area.bottom() - gap - box.height())
    painter.setPen(QPen(style.mixed(0.3), style.unit))
    painter.setBrush(faded(style.base, 0.92))
    painter.drawRect(box)
    painter.setPen(style.text)
    painter.drawText(box.adjusted(gap, gap, -gap, -gap), Qt.AlignLeft, text)


def draw_band(painter, style, begin, end, reached, text):
    """Draw the edge being drawn from ``begin`` to ``end`` [px], with its head there, and ``text``.

    It is solid once it has ``reached`` a robot.
    """
    pen = QPen(style.highlight, 2.0 * style.unit, Qt.SolidLine if reached else Qt.DashLine)
    painter.setPen(pen)
    painter.drawLine(QLineF(*begin, *end))
    draw_head(painter, style, begin, end, 2.0 * style.unit)
    width = painter.fontMetrics().horizontalAdvance(text) + 0.8 * style.line
    box = QRectF(end[0] + 0.8 * style.line, end[1] - 1.6 * style.line, width, 1.3 * style.line)
    painter.fillRect(box, faded(style.base, 0.9))
    painter.setPen(style.text)
    painter.drawText(box, Qt.AlignCenter, text)
