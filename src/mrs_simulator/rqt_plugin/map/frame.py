"""The part of the plane that the map shows, and where it is on the screen."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QRectF

SCALES = (1e-4, 5000.0)  # [px/m], least, which shows a team that is driven apart, and most
LEAST_EXTENT = 3.0  # [m], of what a fitted view shows
MARGIN = 0.08  # around a fitted view, as a share of its larger side


class Frame:
    """Where the plane lies on the screen: y points up, both axes have one scale."""

    def __init__(self):
        self.centre = np.zeros(2)  # [m], in the middle of the area
        self.scale = 50.0  # [px/m]
        self.area = QRectF(0.0, 0.0, 100.0, 100.0)  # [px]

    def about_origin(self):
        """Return a frame of the same scale that shows the origin at (0, 0) [px]."""
        result = Frame()
        result.scale, result.area = self.scale, QRectF(-1.0, -1.0, 2.0, 2.0)
        return result

    def _middle(self):
        return np.array([self.area.center().x(), self.area.center().y()])

    def to_screen(self, points):
        """Return ``points`` (..., 2) [m] on the screen [px]."""
        shifted = np.asarray(points, dtype=float)[..., :2] - self.centre
        return shifted * (self.scale, -self.scale) + self._middle()

    def to_plane(self, points):
        """Return the ``points`` (..., 2) of the screen [px] in the plane [m]."""
        shifted = np.asarray(points, dtype=float) - self._middle()
        return shifted / (self.scale, -self.scale) + self.centre

    def pan(self, shift):
        """Move the drawing by ``shift`` (2,) [px]."""
        self.centre = self.centre - np.asarray(shift) / (self.scale, -self.scale)

    def zoom(self, factor, at):
        """Enlarge by ``factor``; the point ``at`` (2,) [px] stays where it is."""
        held = self.to_plane(at)
        self.scale = float(np.clip(self.scale * factor, *SCALES))
        self.centre = self.centre + held - self.to_plane(at)

    def look_at(self, low, high, padding=0.0):
        """Show the rectangle from ``low`` to ``high`` [m], with a margin and ``padding`` [px]."""
        size = np.maximum(np.subtract(high, low), LEAST_EXTENT)
        size = size + 2.0 * MARGIN * size.max()
        room = np.array([self.area.width(), self.area.height()])
        room = np.maximum(room - 2.0 * padding, 0.5 * room)
        self.centre = 0.5 * np.add(low, high)
        self.scale = float(np.clip(np.min(room / size), *SCALES))

    def bounds(self):
        """Return the corners (low, high) [m] of what is in view."""
        half = 0.5 * np.array([self.area.width(), self.area.height()]) / self.scale
        return self.centre - half, self.centre + half

    def sees(self, screen, margin=0.0):
        """Return which points ``screen`` (n, 2) [px] lie in the area, or ``margin`` about it."""
        area = self.area.adjusted(-margin, -margin, margin, margin)
        low, high = (area.left(), area.top()), (area.right(), area.bottom())
        return ((screen >= low) & (screen <= high)).all(axis=1)


def nice_step(least):
    """Return the smallest of 1, 2, 5 times a power of ten that is at least ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * 0.999999)
