"""The picture of a robot's camera, or its depth in colours."""

import numpy as np
from matplotlib import cm

from mrs_simulator.rqt_plugin.qt.QtCore import QRect, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QImage, QPainter
from mrs_simulator.rqt_plugin.qt.QtWidgets import QSizePolicy, QWidget
from mrs_simulator.rqt_plugin.widgets.guard import guarded

LEAST, USUAL = 8, 12  # [lines of text] of width
NEAR_TO_FAR = (255.0 * cm.viridis_r(np.linspace(0.0, 1.0, 256))[:, :3]).astype(np.uint8)
UNKNOWN = (150, 150, 150)  # [-] colour of pixels without a depth
TALL, GAP = 0.6, 0.25  # [lines of text] of the scale, and above it
STEPS = (1.0, 2.0, 5.0, 10.0)  # [-] at which a scale ends, times a power of ten


@guarded
class Picture(QWidget):
    """Shows an image as large as fits, with its aspect ratio."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.image = None  # ``QImage``
        self.most = None  # [m] at the end of the scale, None for a picture without one
        self._pixels = None
        self.setSizePolicy(QSizePolicy.Maximum, QSizePolicy.Expanding)
        self.hide()

    def show_pixels(self, pixels):
        """Show ``pixels`` (height, width, 3) uint8, red, green, blue; None for no picture."""
        self._show(pixels, lambda: (pixels, None))

    def show_depth(self, depth):
        """Show ``depth`` (height, width) [m] in colours, with their scale below; None for no picture."""
        self._show(depth, lambda: in_colours(depth))

    def _show(self, given, drawn):
        self.setVisible(given is not None)
        if given is self._pixels:
            return
        self._pixels = given
        if given is not None:
            pixels, self.most = drawn()
            self.image = _image(pixels)
        self.update()

    def sizeHint(self):
        """Return the initial size."""
        line = self.fontMetrics().height()
        return QSize(USUAL * line, USUAL * line * 3 // 4)

    def minimumSizeHint(self):
        """Return the smallest useful size."""
        line = self.fontMetrics().height()
        return QSize(LEAST * line, LEAST * line // 2)

    def paintEvent(self, _):
        if self.image is None:
            return
        line, room = self.fontMetrics().height(), self.rect()
        below = 0 if self.most is None else int((GAP + TALL + 1.0) * line)
        size = self.image.size().scaled(
            room.width(), max(1, room.height() - below), Qt.KeepAspectRatio
        )
        place = QRect(0, 0, size.width(), size.height() + below)
        place.moveCenter(room.center())
        painter = QPainter(self)
        painter.setRenderHint(QPainter.SmoothPixmapTransform, self.most is None)
        painter.drawImage(QRect(place.topLeft(), size), self.image)
        if self.most is not None:
            self._draw_scale(painter, place, line)
        painter.end()

    def _draw_scale(self, painter, place, line):
        """Draw the colour scale at the bottom of ``place``, with text ``line`` [px] high."""
        top = place.bottom() + 1 - int((TALL + 1.0) * line)
        painter.drawImage(
            QRect(place.left(), top, place.width(), int(TALL * line)),
            _image(NEAR_TO_FAR[np.newaxis]),
        )
        words = QRect(place.left(), top + int(TALL * line), place.width(), line)
        painter.setPen(self.palette().windowText().color())
        painter.drawText(words, Qt.AlignLeft, "0")
        painter.drawText(words, Qt.AlignHCenter, "{:g}".format(0.5 * self.most))
        painter.drawText(words, Qt.AlignRight, "{:g} m".format(self.most))


def in_colours(depth):
    """Return ``depth`` (height, width) [m] as pixels (height, width, 3) uint8, and the scale's end [m].

    The scale begins at 0; pixels of unknown depth are grey.
    """
    known = np.isfinite(depth)
    most = round_end(float(depth[known].max())) if known.any() else 1.0
    share = np.where(known, depth, 0.0) / most
    pixels = NEAR_TO_FAR[np.clip(255.0 * share, 0.0, 255.0).astype(int)]
    return np.where(known[..., np.newaxis], pixels, np.array(UNKNOWN, dtype=np.uint8)), most


def round_end(most):
    """Return the least of 1, 2, 5 times a power of ten that is not below ``most``."""
    power = 10.0 ** np.floor(np.log10(max(most, 1e-3)))
    return float(power * next(step for step in STEPS if step * power >= 0.999999 * most))


def _image(pixels):
    """Return the ``QImage`` of ``pixels`` (height, width, 3) uint8."""
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels).tobytes()
    return QImage(data, width, height, 3 * width, QImage.Format_RGB888).copy()
