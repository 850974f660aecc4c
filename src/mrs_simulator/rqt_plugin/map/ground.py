"""Cached layers of the map: the background, and trails that only grow.

Both are kept in one picture of the size of the widget.  While the view stays as it is, trails are
only continued there; any other change paints the picture anew.
"""

import numpy as np

from mrs_simulator.rqt_plugin.map import axes
from mrs_simulator.rqt_plugin.map.drawing import draw_obstacles
from mrs_simulator.rqt_plugin.map.marks import draw_starts
from mrs_simulator.rqt_plugin.map.style import mixed, polygon
from mrs_simulator.rqt_plugin.map.trails import TRAIL_PIXELS
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPainter, QPen, QPixmap
from mrs_simulator.rqt_plugin.widgets.colours import dash_places
from mrs_simulator.scenario.surroundings.obstacles import is_flat

MANY_TRAILS = 120  # [-] in view; beyond, they are thin and not dashed
# [-] of trails, in widths of their lines.
DASHES = (5.0, 3.0), (9.0, 3.0, 2.0, 3.0), (2.0, 2.0), (16.0, 3.0)


class Ground:
    """The picture of grid, axes, obstacles and trails."""

    def __init__(self):
        self._picture, self._key, self._trails = None, None, TrailPainter()
        self.solid = False  # whether trails are not dashed, as other runs' are

    def draw(self, painter, widget, style, frame, obstacles, trails, now, numbers, hidden):
        """Draw the ground of ``widget`` with the ``trails``, None for none.

        ``now``: where the robots ``numbers`` are (n, 2) and their trails go on to, None for nowhere;
        ``hidden``: the numbers of those without a trail.
        """
        ratio = widget.devicePixelRatioF()
        size, place = widget.size(), (*frame.centre, frame.scale, frame.area)
        # Objects are compared as such: another run has other trails.
        shown = trails, trails and trails.begun, frozenset(hidden), self.solid
        self._trails.solid = self.solid
        key = size, ratio, place, style, widget.font(), obstacles, numbers, shown
        anew = key != self._key
        if anew:
            self._picture = QPixmap(size * ratio)
            self._picture.setDevicePixelRatio(ratio)
        brush = QPainter(self._picture)
        try:
            if anew:
                _draw_ground(brush, widget, style, frame, obstacles)
            brush.setClipRect(frame.area)
            brush.setRenderHint(QPainter.Antialiasing)
            if anew and trails is not None:
                self._trails.begin(brush, style, frame, trails, now, numbers, hidden)
            elif trails is not None and now is not None:
                self._trails.go_on(brush, style, frame, trails, now)
            self._key = key
        finally:
            brush.end()
        painter.drawPixmap(0, 0, self._picture)


def _draw_ground(painter, widget, style, frame, obstacles):
    painter.fillRect(widget.rect(), style.base)
    painter.setFont(widget.font())
    painter.setRenderHint(QPainter.Antialiasing)
    painter.setClipRect(frame.area)
    draw_obstacles(painter, style, frame, [each for each in obstacles if is_flat(each)])
    axes.draw_grid(painter, style, frame)
    draw_obstacles(painter, style, frame, [each for each in obstacles if not is_flat(each)])
    painter.setClipping(False)
    axes.draw_axes(painter, style, frame)


class TrailPainter:
    """Draws trails once as they are kept, then only where the robots have gone on."""

    solid = False  # whether no trail is dashed

    def begin(self, painter, style, frame, trails, now, numbers, hidden):
        """Draw the trails of all robots but the ``hidden`` ones, on to where they are ``now``."""
        self._places = style.places(numbers).tolist()
        self._dashes = dash_places(numbers, style.count).tolist()
        shown = np.array([number not in hidden for number in numbers], dtype=bool)
        self._shown = shown & (trails.count > 0)
        rows = [row for row in trails.in_view(frame).tolist() if self._shown[row]]
        self._many = len(rows) > MANY_TRAILS
        self._pens = self._pens_of(style)
        ends = trails.last() if now is None else np.where(np.isfinite(now), now, trails.last())
        self._tips, self._lengths = frame.to_screen(ends), np.zeros(len(numbers))
        self._starts, self._held = trails.first(), trails.count.copy()
        painter.setRenderHint(QPainter.Antialiasing, not self._many)
        painter.setBrush(Qt.NoBrush)
        for row, line in zip(rows, _lines(trails, rows, ends, frame)):
            self._draw(painter, frame, row, line)
        painter.setRenderHint(QPainter.Antialiasing, True)
        draw_starts(painter, style, frame, self._starts[rows])

    def _draw(self, painter, frame, row, line):
        pen = self._pen(row)
        if self._many:
            painter.setPen(pen)
            painter.drawPolyline(polygon(line))
            return
        lengths = np.cumsum(np.hypot(*np.diff(line, axis=0).T))
        self._lengths[row] = lengths[-1]
        for begin, end in _parts_in_view(frame, line):
            if begin and self._is_dashed():  # the dashes stay where they are when the view moves
                pen.setDashOffset(lengths[begin - 1] / pen.widthF() % sum(pen.dashPattern()))
            painter.setPen(pen)
            painter.drawPolyline(polygon(line[begin:end]))

    def _is_dashed(self):
        return not self._many and not self.solid

    def _pens_of(self, style):
        """Return the pens of trails, one for each of the robots' colours."""
        if self._many:
            return [QPen(mixed(style.base, shade, 0.6), 1) for shade in style.shades]
        pens = [QPen(shade, 1.4 * style.unit) for shade in style.shades]
        for pen in pens:
            pen.setCapStyle(Qt.FlatCap)
        return pens

    def _pen(self, row):
        pen = QPen(self._pens[self._places[row]])
        if self._is_dashed():
            pen.setDashPattern(DASHES[self._dashes[row]])
        return pen

    def go_on(self, painter, style, frame, trails, now):
        """Continue the ``trails`` to where the robots are ``now`` (n, 2), if that is to be seen."""
        screen = frame.to_screen(now)
        steps = np.hypot(*(screen - self._tips).T)
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(self._shown & (steps >= TRAIL_PIXELS))
        if not len(rows):
            return
        inside = frame.sees(self._tips[rows]) | frame.sees(screen[rows])
        lines = np.hstack([self._tips[rows], screen[rows]])
        # In a fast run robots have passed several points since.
        more = trails.count[rows] > self._held[rows] + 1
        painter.setRenderHint(QPainter.Antialiasing, not self._many)
        for row, line, bends in zip(*(each[inside].tolist() for each in (rows, lines, more))):
            pen = self._pen(row)
            if self._is_dashed():
                pen.setDashOffset(self._lengths[row] / pen.widthF() % sum(pen.dashPattern()))
            painter.setPen(pen)
            if bends:
                passed = frame.to_screen(trails.path(row)[self._held[row] :])
                whole = np.vstack([line[:2], passed, line[2:]])
                painter.drawPolyline(polygon(whole))
                steps[row] = np.hypot(*np.diff(whole, axis=0).T).sum()
            else:
                painter.drawLine(QLineF(*line))
        painter.setRenderHint(QPainter.Antialiasing, True)
        # A start is on top of its own trail.
        near = rows[np.hypot(*(frame.to_screen(self._starts[rows]) - self._tips[rows]).T) < 9.0]
        draw_starts(painter, style, frame, self._starts[near], self._starts)
        self._lengths[rows] += steps[rows]
        self._tips[rows], self._held[rows] = screen[rows], trails.count[rows]


def _lines(trails, rows, ends, frame):
    """Return the trails of ``rows``, on to ``ends`` (n, 2) [m], on the screen, (m, 2) [px] each."""
    parts = []
    for row in rows:
        parts += [trails.path(row, trails.stride(row, frame.scale)), ends[row : row + 1]]
    if not parts:
        return []
    counts = np.array([len(part) for part in parts]).reshape(-1, 2).sum(axis=1)
    return np.split(frame.to_screen(np.concatenate(parts)), np.cumsum(counts)[:-1])


def _parts_in_view(frame, line):
    """Return the (begin, end) of the stretches of ``line`` (m, 2) [px] that may be seen."""
    area = frame.area
    left, top = line[:, 0] < area.left(), line[:, 1] < area.top()
    right, bottom = line[:, 0] > area.right(), line[:, 1] > area.bottom()
    outside = np.stack([left, top, right, bottom])
    if not outside.any():
        return [(0, len(line))]
    # A step with both ends beyond the same side is not seen.
    seen = ~(outside[:, :-1] & outside[:, 1:]).any(axis=0)
    turns = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
    return [(begin, end + 1) for begin, end in turns.reshape(-1, 2).tolist()]
