"""The picture of a robot's camera."""

import numpy as np
from python_qt_binding.QtCore import QRect, QSize, Qt
from python_qt_binding.QtGui import QImage, QPainter
from python_qt_binding.QtWidgets import QSizePolicy, QWidget

from mrs_simulator.rqt_plugin.widgets.guard import guarded

LEAST, USUAL = 8, 12  # [lines of text] of width


class Picture(QWidget):
    """Shows an image as large as there is room, its sides in proportion."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.image = None  # ``QImage``
        self._pixels = None
        self.setSizePolicy(QSizePolicy.Maximum, QSizePolicy.Expanding)
        self.hide()

    def show_pixels(self, pixels):
        """Show ``pixels`` (height, width, 3) uint8, red, green, blue; None for no picture."""
        self.setVisible(pixels is not None)
        if pixels is self._pixels:
            return
        self._pixels = pixels
        if pixels is not None:
            height, width = pixels.shape[:2]
            data = np.ascontiguousarray(pixels).tobytes()
            self.image = QImage(data, width, height, 3 * width, QImage.Format_RGB888).copy()
        self.update()

    def sizeHint(self):
        """Return the size that the panel begins with."""
        line = self.fontMetrics().height()
        return QSize(USUAL * line, USUAL * line * 3 // 4)

    def minimumSizeHint(self):
        """Return the least size at which something is to be seen."""
        line = self.fontMetrics().height()
        return QSize(LEAST * line, LEAST * line // 2)

    @guarded
    def paintEvent(self, _):
        if self.image is None:
            return
        size = self.image.size().scaled(self.size(), Qt.KeepAspectRatio)
        place = QRect(0, 0, size.width(), size.height())
        place.moveCenter(self.rect().center())
        painter = QPainter(self)
        painter.setRenderHint(QPainter.SmoothPixmapTransform)
        painter.drawImage(place, self.image)
        painter.end()
