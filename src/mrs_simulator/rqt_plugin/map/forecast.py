"""Where theory, or a simulation ahead, has the robots go: faint paths, and rings where these end."""

import numpy as np

from mrs_simulator.pictures.signs import by_count
from mrs_simulator.rqt_plugin.map.style import faded, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPen

PATH, END = 0.4, 0.75  # [-] opacity of paths and of their ends
WIDTH, RADIUS = 1.4, (5.0, 3.5, 2.0)  # [px] of a path; of a ring, in teams of some, more, many
MOST_DRAWN = 20000  # [-] points of all paths


def draw_forecast(painter, style, frame, paths, numbers):
    """Draw ``paths`` (k, n, 2) [m] of the robots ``numbers``; of one point alone the ring."""
    drawn = _thinned(paths)
    screen, radius = frame.to_screen(drawn), by_count(len(numbers), *RADIUS) * style.unit
    painter.setBrush(Qt.NoBrush)
    for row, number in enumerate(numbers):
        line, shade = screen[:, row], style.shade(number)
        if not np.isfinite(line).all():
            continue
        painter.setPen(QPen(faded(shade, PATH), WIDTH * style.unit))
        painter.drawPolyline(polygon(line))
        painter.setPen(QPen(faded(shade, END), WIDTH * style.unit))
        painter.drawEllipse(QPointF(*line[-1].tolist()), radius, radius)


def _thinned(paths):
    stride = max(1, -(-paths[..., 0].size // MOST_DRAWN))
    return np.concatenate([paths[:-1:stride], paths[-1:]])


def paths_in_space(paths, heights):
    """Return ``paths`` (k, n, 2) [m] of n robots at ``heights`` (n,) [m], (p, 3) each, a list."""
    drawn = _thinned(paths)
    level = np.broadcast_to(heights, drawn.shape[:2])[..., np.newaxis]
    return list(np.moveaxis(np.concatenate([drawn, level], axis=2), 1, 0))
