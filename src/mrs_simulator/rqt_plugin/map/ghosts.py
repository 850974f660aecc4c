"""Runs that are compared with the one on the map, drawn faintly with it."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.pictures.scene import GHOST_SHOWN, Ghosts, Scene
from mrs_simulator.rqt_plugin.map.drawing import draw_faint
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.style import faded, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QLineF, QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPen

TRAIL = 0.75  # [-] opacity of trails
# Of the trails of compared runs, in widths of their lines, in the order of ``figure_parts.RUN_DASHES``.
DASHES = ((), (5.0, 2.0), (1.2, 1.5), (6.0, 1.5, 1.2, 1.5), (2.5, 1.2))
WIDTH = 1.4  # [px]


class Ghost(NamedTuple):
    """A run at a moment."""

    name: str
    place: int  # among the runs compared, from 1 on
    scene: Scene  # of the robots
    shapes: Shapes
    trails: Tuple  # of each robot, (m, 2) [m]

    def draw(self, painter, style, frame, with_trails):
        """Draw trails and robots."""
        if with_trails:
            painter.save()
            painter.setOpacity(TRAIL)
            self._draw_trails(painter, style, frame)
            painter.restore()
        draw_faint(painter, style, frame, self.scene, self.shapes, GHOST_SHOWN)

    def in_space(self, with_trails):
        """Return the same as ``Ghosts``."""
        scene, paths = self.scene, ()
        if with_trails:
            heights = scene.state.heights
            paths = [np.column_stack([t, np.full(len(t), z)]) for t, z in zip(self.trails, heights)]
        shades = np.asarray(scene.shades)
        return Ghosts(scene.kinds, scene.place, scene.turn, shades, tuple(paths), shades)

    def _draw_trails(self, painter, style, frame):
        for trail, shade in zip(self.trails, self.scene.shades):
            if len(trail) > 1:
                painter.setPen(pen_of(QColor.fromRgbF(*shade), self.place, style))
                painter.drawPolyline(polygon(frame.to_screen(trail)))


def pen_of(shade, place, style):
    """Return the pen of the trails of the run at ``place``, 0 the one shown."""
    pen = QPen(shade, WIDTH * style.unit)
    pen.setCapStyle(Qt.FlatCap)
    dashes = DASHES[place % len(DASHES)]
    if dashes:
        pen.setDashPattern(dashes)
    return pen


def draw_names(painter, style, frame, named, place):
    """Draw the names of runs and their lines in that upper corner where fewer robots are.

    ``named``: ``(name, number of the run)``; ``place``: of the robots (n, 2) [m].
    """
    area, line = frame.area, style.line
    metrics = painter.fontMetrics()
    most = int(0.5 * area.width())
    names = [metrics.elidedText(name, Qt.ElideRight, most) for name, _ in named]
    wide = 3.4 * line + max(map(metrics.horizontalAdvance, names))
    high = (1.2 * len(names) + 0.3) * line
    lefts = area.left() + 0.4 * line, area.right() - 0.4 * line - wide
    boxes = [QRectF(left, area.top() + 0.4 * line, wide, high) for left in lefts]
    screen = frame.to_screen(place[np.isfinite(place).all(axis=1)]).tolist()
    box = min(boxes, key=lambda each: sum(each.contains(x, y) for x, y in screen))
    painter.setPen(QPen(style.mixed(0.25), 1))
    painter.setBrush(faded(style.base, 0.85))
    painter.drawRect(box)
    for row, ((_, number), name) in enumerate(zip(named, names)):
        y = box.top() + (1.2 * row + 0.75) * line
        painter.setPen(pen_of(style.mixed(0.7), number, style))
        painter.drawLine(QLineF(box.left() + 0.4 * line, y, box.left() + 2.4 * line, y))
        painter.setPen(style.text)
        beside = QRectF(box.left() + 2.8 * line, y - line, wide, 2.0 * line)
        painter.drawText(beside, Qt.AlignLeft | Qt.AlignVCenter, name)
