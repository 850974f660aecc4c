"""Background of the map: plane, grid, axes and labels.

Each ``draw_`` function gets a painter, the ``MapStyle`` of the widget and the ``Frame``.
"""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map.frame import nice_step
from mrs_simulator.rqt_plugin.map.style import faded
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QFont, QPen

FEWEST_TICKS = 4  # [-] on an axis, where there is room


def plot_area(widget):
    """Return the part of ``widget`` that shows the plane; about it are axes and labels."""
    metrics, line = widget.fontMetrics(), widget.fontMetrics().height()
    left = metrics.horizontalAdvance("\u221200.0") + 1.6 * line
    area = QRectF(widget.rect()).adjusted(left, 0.7 * line, -0.9 * line, -2.7 * line)
    return QRectF(area.x(), area.y(), max(1.0, area.width()), max(1.0, area.height()))


def draw_grid(painter, style, frame):
    """Draw the lines of the grid, those through the origin a little stronger."""
    step, ticks = _ticks(frame, style, painter.fontMetrics())
    area = frame.area
    painter.setRenderHint(painter.Antialiasing, False)
    for axis in (0, 1):
        for tick in ticks[axis]:
            at = frame.to_screen(np.full(2, tick * step))[axis]
            painter.setPen(QPen(style.mixed(0.11 if tick else 0.3), 1))
            if axis:
                painter.drawLine(QLineF(area.left(), at, area.right(), at))
            else:
                painter.drawLine(QLineF(at, area.top(), at, area.bottom()))
    painter.setRenderHint(painter.Antialiasing, True)


def _ticks(frame, style, metrics):
    """Return the step [m] and the ticks on either axis, whole multiples of it.

    Steps are wide, unless an axis would have fewer than ``FEWEST_TICKS`` and there is room for more.
    """
    step = nice_step(4.2 * style.line / frame.scale)
    finer = nice_step(0.4 * step)
    labels = [_label(end, _digits(finer)) for end in np.ravel(frame.bounds())]
    room = frame.scale * finer - max(map(metrics.horizontalAdvance, labels)) - 0.5 * style.line
    if min(map(len, _multiples(frame, step))) < FEWEST_TICKS and room >= 0.0:
        step = finer
    return step, _multiples(frame, step)


def _multiples(frame, step):
    low, high = frame.bounds()
    return [
        range(math.ceil(begin / step), math.floor(end / step) + 1) for begin, end in zip(low, high)
    ]


def _digits(step):
    """Return the decimals that multiples of ``step`` need."""
    return max(0, -math.floor(math.log10(step) + 1e-9))


def draw_axes(painter, style, frame):
    """Draw the frame about the area, its labels and the axes' names."""
    area, line = frame.area, style.line
    step, ticks = _ticks(frame, style, painter.fontMetrics())
    digits = _digits(step)
    painter.setPen(QPen(style.mixed(0.6), 1))
    painter.setBrush(Qt.NoBrush)
    painter.drawRect(QRectF(area.toRect()))
    painter.setPen(style.mixed(0.85))
    for tick in ticks[0]:
        x = frame.to_screen(np.full(2, tick * step))[0]
        box = QRectF(x - 4 * line, area.bottom() + 0.2 * line, 8 * line, line)
        painter.drawText(box, Qt.AlignCenter, _label(tick * step, digits))
    for tick in ticks[1]:
        y = frame.to_screen(np.full(2, tick * step))[1]
        box = QRectF(1.3 * line, y - 0.5 * line, area.left() - 1.65 * line, line)
        _draw_fitted(painter, box, _label(tick * step, digits))
    below = QRectF(area.left(), area.bottom() + 1.3 * line, area.width(), 1.2 * line)
    painter.drawText(below, Qt.AlignCenter, "x [m]")
    painter.save()
    painter.translate(0.25 * line, area.center().y())
    painter.rotate(-90.0)
    painter.drawText(QRectF(-4 * line, 0.0, 8 * line, 1.2 * line), Qt.AlignCenter, "y [m]")
    painter.restore()


def _label(value, digits):
    return "{:.{}f}".format(value, digits).replace("-", "\u2212")


def _draw_fitted(painter, box, text):
    """Draw ``text`` at the right of ``box``, in smaller letters where it is too long."""
    needed = painter.fontMetrics().horizontalAdvance(text)
    usual = painter.font()
    if needed > box.width():
        smaller = QFont(usual)
        smaller.setPointSizeF(max(1.0, painter.fontInfo().pointSizeF() * box.width() / needed))
        painter.setFont(smaller)
    painter.drawText(box, Qt.AlignRight | Qt.AlignVCenter, text)
    painter.setFont(usual)


def draw_scale_bar(painter, style, frame):
    """Draw a bar of a round length in the lower right corner."""
    area, line = frame.area, style.line
    length = nice_step(0.08 * area.width() / frame.scale)
    width, right, bottom = length * frame.scale, area.right() - 0.8 * line, area.bottom() - line
    label = "{:g} m".format(length) if length < 1e3 else "{:g} km".format(length / 1000.0)
    box = QRectF(right - width, bottom - 1.5 * line, width, 1.4 * line)
    painter.fillRect(box.adjusted(-0.4 * line, 0.0, 0.4 * line, 0.5 * line), faded(style.base, 0.8))
    painter.setPen(QPen(style.text, 1.5 * style.unit))
    painter.drawLine(QLineF(right - width, bottom, right, bottom))
    for x in (right - width, right):
        painter.drawLine(QLineF(x, bottom - 0.25 * line, x, bottom + 0.25 * line))
    painter.drawText(box.adjusted(-3 * line, 0, 3 * line, 0), Qt.AlignCenter, label)


def draw_remark(painter, style, frame, remark):
    """Draw ``remark`` in the upper left corner."""
    line = style.line
    box = QRectF(frame.area.left() + 0.4 * line, frame.area.top() + 0.4 * line, 0.0, 1.25 * line)
    box.setWidth(painter.fontMetrics().horizontalAdvance(remark) + 0.8 * line)
    painter.fillRect(box, faded(style.base, 0.85))
    painter.setPen(style.mixed(0.75))
    painter.drawText(box, Qt.AlignCenter, remark)
