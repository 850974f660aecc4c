"""Cached images of robots for the map."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QPointF, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPainter, QPixmap


class Sprites:
    """Pictures by a key, kept while the kind of the pictures stays the same."""

    def __init__(self):
        self._kind, self._pictures = None, {}

    def put(self, painter, kind, half, places, keys, paint):
        """Put the picture of each of ``keys`` about its place (n, 2) [px], on whole pixels.

        ``paint(painter, key)`` paints one about the origin, within ``half`` [px] of it; pictures of
        another ``kind``, anything that can be compared, are forgotten.
        """
        half, ratio = int(math.ceil(half)), painter.device().devicePixelRatioF()
        kind = kind, half, ratio
        if kind != self._kind:
            self._kind, self._pictures = kind, {}
        corners = np.round(places * ratio) / ratio - half
        for (x, y), key in zip(corners.tolist(), keys):
            picture = self._pictures.get(key)
            if picture is None:
                picture = self._pictures[key] = _painted(half, ratio, key, paint)
            painter.drawPixmap(QPointF(x, y), picture)


def _painted(half, ratio, key, paint):
    side = int(math.ceil(2 * half * ratio))
    picture = QPixmap(side, side)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.Antialiasing)
    painter.translate(half, half)
    paint(painter, key)
    painter.end()
    return picture
