"""What is beside the cells of a sweep map: colour bar, marks and legend.

Each ``draw_`` function gets a painter and the ``MapStyle`` of the widget.
"""

import functools
import math
import re

import numpy as np
from matplotlib.colors import LogNorm

from mrs_simulator.rqt_plugin.map.frame import nice_step
from mrs_simulator.rqt_plugin.map.style import polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QImage, QPen, QStaticText, QTextOption
from mrs_simulator.rqt_plugin.widgets.symbols import GREEK
from mrs_simulator.verdict.verdict import FAILED, PASSED

BAR, STEPS = 0.9, 64  # [lines of text] width of the colour bar, and its steps
BEYOND = 0.6  # [lines of text] height of its tips, for values beyond its ends
WAITING = 0.1  # [-] share of text in the colour of cells whose runs have not ended
UNKNOWN = 0.3  # [-] the same where they have no value
DASHES = [4.0, 2.5]  # of theory's line
FORMULA = re.compile(r"_\{?\\?(\w+)\}?")


def draw_bar(painter, style, area, scale, label):
    """Draw the colours of a ``Scale`` at the right of ``area``, with numbers and a ``label``."""
    line, room = style.line, BEYOND * style.line
    box = QRectF(area.right() + line, area.top(), BAR * line, area.height())
    box.adjust(0.0, room * scale.beyond[1], 0.0, -room * scale.beyond[0])
    image = QImage(1, STEPS, QImage.Format_RGB32)
    values = scale.norm.inverse(np.linspace(1.0, 0.0, STEPS))
    for row, shade in enumerate(scale.shades(values).tolist()):
        image.setPixelColor(0, row, QColor(*shade))
    painter.setRenderHint(painter.SmoothPixmapTransform)
    painter.drawImage(box, image)
    painter.setPen(QPen(style.mixed(0.6), 1))
    painter.setBrush(Qt.NoBrush)
    painter.drawRect(box)
    for shown, y, tip, row in (
        (scale.beyond[1], box.top(), box.top() - room, 0),
        (scale.beyond[0], box.bottom(), box.bottom() + room, STEPS - 1),
    ):
        painter.setBrush(image.pixelColor(0, row))
        ends = [[box.left(), y], [box.center().x(), tip], [box.right(), y]]
        if shown:
            painter.drawPolygon(polygon(np.array(ends)))
    painter.setPen(style.mixed(0.85))
    wide = 0
    for value, text in _ticks(scale, max(2, int(box.height() / (1.6 * line)))):
        y = box.bottom() - float(scale.norm(value)) * box.height()
        painter.drawLine(QLineF(box.right(), y, box.right() + 0.25 * line, y))
        place = QRectF(box.right() + 0.4 * line, y - 0.5 * line, 6 * line, line)
        painter.drawText(place, Qt.AlignLeft | Qt.AlignVCenter, text)
        wide = max(wide, painter.fontMetrics().horizontalAdvance(text))
    draw_upwards(painter, box.right() + 0.6 * line + wide, area, line, label)


def _ticks(scale, most):
    """Return ``(value, text)`` of ticks of a colour bar, about ``most`` of them."""
    low, high = float(scale.norm.vmin), float(scale.norm.vmax)
    if isinstance(scale.norm, LogNorm):
        powers = range(math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9) + 1)
        values = [10.0**power for power in powers][:: max(1, -(-len(powers) // most))]
    else:
        step = nice_step(max((high - low) / most, 1e-300))
        count = range(math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6) + 1)
        values = [float("{:.9g}".format(step * each)) for each in count]
    return [(value, "{:g}".format(value).replace("-", "\u2212")) for value in values]


def draw_upwards(painter, left, area, line, text):
    """Draw ``text`` from below upwards, centred beside ``area``; in two lines where it is too long."""
    room = area.bottom() + line
    if painter.fontMetrics().horizontalAdvance(text) > room:
        text = text.replace(" [", "\n[")
    lines = text.count("\n") + 1
    painter.save()
    painter.translate(left, area.center().y())
    painter.rotate(-90.0)
    painter.drawText(QRectF(-room, 0.0, 2.0 * room, 1.2 * lines * line), Qt.AlignCenter, text)
    painter.restore()


def draw_mark(painter, style, centre, size, outcome):
    """Draw a cross of a run that failed, a dot of one that was not judged, readable on any colour."""
    x, y, thin = centre.x(), centre.y(), min(1.0, size / (0.26 * style.line))  # in small cells
    for colour, width in ((QColor("black"), 3.6 * thin), (QColor("white"), 1.8 * thin)):
        if outcome == FAILED:
            painter.setPen(QPen(colour, width * style.unit, Qt.SolidLine, Qt.RoundCap))
            painter.drawLine(QLineF(x - size, y - size, x + size, y + size))
            painter.drawLine(QLineF(x - size, y + size, x + size, y - size))
        else:
            painter.setPen(Qt.NoPen)
            painter.setBrush(colour)
            radius = 0.45 * size + 0.5 * (width - 1.8 * thin) * style.unit
            painter.drawEllipse(centre, radius, radius)


def draw_legend(painter, style, area, width, cells, values):
    """Draw above ``area`` what marks, greys and line of ``SweepCells`` mean, as far as they occur.

    ``width`` [px] of the widget; ``values``: of the quantity that is shown, NaN where a cell has none.
    """
    line, parts = style.line, []  # (width of a symbol, how it is drawn, text)
    known = cells.known()
    found = {cell.outcome for cell in known}
    if FAILED in found:
        parts.append((line, functools.partial(_square, 0.4, FAILED), "failed"))
    if PASSED in found:
        parts.append((0.0, lambda *_: None, "no mark: passed"))
    if found - {PASSED, FAILED}:
        parts.append((line, functools.partial(_square, 0.4, ""), "not judged"))
    if np.count_nonzero(np.isfinite(values)) < len(known):
        parts.append((line, functools.partial(_square, UNKNOWN, None), "not measured"))
    if len(known) < cells.cells.size:
        parts.append((line, functools.partial(_square, WAITING, None), "to be run"))
    if cells.lines:
        text = formula(cells.boundary) or "its conditions hold on one side"
        parts.append((2.0 * line, _dashes, "theory: " + text))
    texts = [_one_line(painter, words) for _, _, words in parts]
    wide = sum(part[0] + text.size().width() + 1.2 * line for part, text in zip(parts, texts))
    painter.save()
    painter.translate(max(0.0, min(area.left(), width - wide)), 0.95 * line)
    smaller = min(1.0, width / max(wide, 1.0))
    painter.scale(smaller, smaller)
    x = 0.0
    for (across, draw, _), text in zip(parts, texts):
        draw(painter, style, QRectF(x, -0.5 * line, across, line))
        x += across + 0.3 * line
        painter.setPen(style.mixed(0.85))
        painter.drawStaticText(QPointF(x, -0.5 * text.size().height()), text)
        x += text.size().width() + 0.9 * line
    painter.restore()


def _square(share, outcome, painter, style, box):
    """Draw a square that is ``share`` text, with the mark of an ``outcome`` unless that is None."""
    edge = 0.05 * style.line
    painter.fillRect(box.adjusted(edge, edge, -edge, -edge), style.mixed(share))
    if outcome is not None:
        draw_mark(painter, style, box.center(), 0.26 * style.line, outcome)


def _dashes(painter, style, box):
    pen = QPen(style.text, 1.8 * style.unit)
    pen.setDashPattern(DASHES)
    painter.setPen(pen)
    painter.drawLine(QLineF(box.left(), box.center().y(), box.right(), box.center().y()))


def _one_line(painter, words):
    """Return rich text ``words``, never broken into lines."""
    text, option = QStaticText(words), QTextOption()
    option.setWrapMode(QTextOption.NoWrap)
    text.setTextOption(option)
    text.setTextFormat(Qt.RichText)
    text.prepare(painter.transform(), painter.font())
    return text


def formula(text):
    """Return a formula of mathtext as rich text."""
    text = text.replace("$", "")
    for name in sorted(GREEK, key=len)[::-1]:
        text = text.replace("\\" + name, "<i>{}</i>".format(GREEK[name]))
    return FORMULA.sub("<sub>\\1</sub>", text)
