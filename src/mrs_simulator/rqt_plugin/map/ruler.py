"""Measures on the map: the distance between two points, or robots, and the way from one to the other."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map.style import faded
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QPointF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPen


class Ruler:
    """Two ends, each a point of the plane or a robot, which it follows."""

    def __init__(self, team):
        """``team``: the ``MapTeam``."""
        self._team, self.ends = team, None  # two of (number, point (2,) [m]), number 0: no robot

    def begin(self, row, point):
        """Lay both ends on the robot in ``row``, with -1 on ``point`` (2,) [m]."""
        self.ends = [self._end(row, point)] * 2

    def lead(self, row, point):
        """Lay the second end on the robot in ``row``, with -1 on ``point`` (2,) [m]."""
        self.ends[1] = self._end(row, point)

    def _end(self, row, point):
        return (self._team.numbers[row] if row >= 0 else 0, np.asarray(point, dtype=float))

    def places(self):
        """Return both ends (2, 2) [m] now, None where there is nothing to measure."""
        if self.ends is None:
            return None
        rows = {number: row for row, number in enumerate(self._team.numbers)}
        places = [
            self._team.pose[rows[number], :2] if number in rows else point
            for number, point in self.ends
        ]
        return np.array(places) if np.isfinite(places).all() else None

    def text(self):
        """Return the distance, the differences in x and y, and the direction."""
        (x, y), (to_x, to_y) = self.places()
        x, y = to_x - x, to_y - y
        return "{:.3f} m\nx {:+.3f} m, y {:+.3f} m, {:.1f}\u00b0".format(
            math.hypot(x, y), x, y, math.degrees(math.atan2(y, x))
        )

    def draw(self, painter, style, frame):
        """Draw the line with a mark at each end, and its text beside the second."""
        places = self.places()
        if places is None:
            return
        begin, end = frame.to_screen(places).tolist()
        painter.setPen(QPen(style.highlight, 2.0 * style.unit))
        painter.setBrush(style.base)
        painter.drawLine(QLineF(*begin, *end))
        for x, y in (begin, end):
            painter.drawEllipse(QPointF(x, y), 3.0 * style.unit, 3.0 * style.unit)
        if np.ptp(places, axis=0).any():
            _draw_text(painter, style, frame.area, begin, end, self.text())


def draw_selection_band(painter, style, begin, end):
    """Draw the rectangle between two corners (2,) [px] that selects what is in it."""
    painter.setPen(QPen(style.highlight, style.unit, Qt.DashLine))
    painter.setBrush(faded(style.highlight, 0.12))
    painter.drawRect(QRectF(QPointF(*begin), QPointF(*end)).normalized())


def _draw_text(painter, style, area, begin, end, text):
    """Write ``text`` beyond the ``end`` of a line from ``begin``, within ``area``."""
    metrics, lines, gap = painter.fontMetrics(), text.split("\n"), 0.3 * style.line
    wide, high = max(map(metrics.horizontalAdvance, lines)) + 2.0 * gap, len(lines) * style.line
    ahead, below = end[0] >= begin[0], end[1] >= begin[1]
    left = end[0] + style.line if ahead else end[0] - style.line - wide
    top = end[1] + style.line if below else end[1] - style.line - high
    left = max(area.left(), min(left, area.right() - wide))
    box = QRectF(left, max(area.top(), min(top, area.bottom() - high)), wide, high + gap)
    painter.fillRect(box, faded(style.base, 0.92))
    painter.setPen(style.text)
    painter.drawText(box, Qt.AlignCenter, text)
