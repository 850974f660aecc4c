"""Colours and sizes that the map takes from its widget."""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QPointF
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPolygonF
from mrs_simulator.rqt_plugin.widgets import colours


class MapStyle(NamedTuple):
    """Colours and sizes of a widget."""

    base: QColor
    text: QColor
    highlight: QColor
    unit: float  # [px], 1 at the usual size of the font
    line: float  # [px], height of a line of text
    count: int  # of robots in the team
    shades: Tuple[QColor, ...]  # the robots' distinct colours

    @classmethod
    def of(cls, widget, count=1):
        """Return the style that palette and font of ``widget`` ask for, with a team of ``count`` robots."""
        palette, line = widget.palette(), widget.fontMetrics().height()
        base, text, highlight = palette.base(), palette.text(), palette.highlight()
        unit = max(1.0, line / 16.0)
        base, text, highlight = base.color(), text.color(), highlight.color()
        style = base, text, highlight, unit, float(line), count
        return cls(*style, colours.shades(count, base))

    def mixed(self, share):
        """Return the colour that is ``share`` text and the rest background."""
        return mixed(self.base, self.text, share)

    def shade(self, number):
        """Return the colour of robot ``number``."""
        return self.shades[self.places([number])[0]]

    def shades_of(self, numbers, fresh):
        """Return the colours (n, 3) of robots in 0..1, grey of those that are not ``fresh`` (n,)."""
        colour = np.array([shade.getRgbF()[:3] for shade in (*self.shades, self.mixed(0.5))])
        return colour[np.where(fresh, self.places(numbers), -1)]

    def places(self, numbers):
        """Return the places of the robots ``numbers`` among the ``shades``."""
        return colours.places(numbers, self.count)


def mixed(first, second, share):
    """Return the colour between ``first`` (share 0) and ``second`` (share 1)."""
    pairs = zip(first.getRgb()[:3], second.getRgb()[:3])
    return QColor(*(int(round(a + share * (b - a))) for a, b in pairs))


def faded(shade, opacity):
    """Return a copy of the colour ``shade`` with ``opacity`` between 0 and 1."""
    shade = QColor(shade)
    shade.setAlphaF(min(1.0, max(0.0, opacity)))
    return shade


def polygon(points):
    """Return ``points`` (m, 2) as a ``QPolygonF``."""
    result = QPolygonF(len(points))
    try:
        memory = result.data()
        memory.setsize(16 * len(points))
        np.frombuffer(memory, dtype=float).reshape(-1, 2)[:] = points
    except (AttributeError, TypeError, ValueError):  # bindings that do not show the memory
        result = QPolygonF([QPointF(x, y) for x, y in np.asarray(points).tolist()])
    return result
