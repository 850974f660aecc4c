"""The 3D view: pictures of the stage, with a camera to orbit and to follow a robot."""

from python_qt_binding.QtCore import QRect, Qt, Signal
from python_qt_binding.QtGui import QImage, QPainter
from python_qt_binding.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QVBoxLayout, QWidget

from mrs_simulator.rqt_plugin.widgets.guard import guarded

TURN = 0.4  # [deg] of the camera for a pixel of the mouse
ZOOM = 1.15  # [-] for a notch of the wheel
TIP = "Render the stage in a process of its own; drag to orbit, wheel to zoom"
OFF = "Off: it costs up to half of a core"
AWAITED = "Waiting for the first picture"
NEAREST, FARTHEST = 1.0, 300.0  # [m]


class ViewPanel(QWidget):
    """Shows pictures; tells where the camera is wanted.  Off until it is switched on."""

    switched = Signal(bool)
    look_changed = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self.yaw, self.pitch, self.distance = 0.0, -45.0, 20.0
        self.x, self.y = 0.0, 0.0
        layout = QVBoxLayout(self)
        row = QHBoxLayout()
        self._on = QCheckBox("3D view")
        self._on.setToolTip(TIP)
        self._on.toggled.connect(self._on_switched)
        self._follow = QComboBox()
        self._follow.setToolTip("Keep a robot in the middle")
        self._follow.activated.connect(guarded(lambda *_: self.look_changed.emit()))
        row.addWidget(self._on)
        row.addStretch(1)
        row.addWidget(self._follow)
        layout.addLayout(row)
        self.picture = Picture(self)
        layout.addWidget(self.picture, 1)
        self.set_team((), None)

    def set_team(self, numbers, points):
        """Offer the robots ``numbers`` to follow; frame their ``points`` (n, 2) [m]."""
        chosen = self.follow()
        self._follow.clear()
        self._follow.addItem("whole team", 0)
        for number in numbers:
            self._follow.addItem("follow robot {}".format(number), int(number))
        self._follow.setCurrentIndex(max(0, self._follow.findData(chosen)))
        if points is not None and len(points):
            low, high = points.min(axis=0), points.max(axis=0)
            self.x, self.y = (float(value) for value in 0.5 * (low + high))
            self.distance = 3.0 + 1.2 * float((high - low).max())

    def set_possible(self, possible, remark=""):
        """Let the view be switched on or not; ``remark``: why not, in the tooltip."""
        self._on.setEnabled(possible or self._on.isChecked())
        self._on.setToolTip(TIP if possible else "{}\nNot now: {}".format(TIP, remark))

    def is_on(self):
        """Return whether the view is switched on."""
        return self._on.isChecked()

    def follow(self):
        """Return the number of the robot to follow, 0 for none."""
        return self._follow.currentData() or 0

    def show_image(self, width, height, data):
        """Show a picture of ``width`` by ``height`` pixels, 3 bytes each; none while switched off."""
        if not self._on.isChecked():
            return
        # The copy outlives the message that the bytes belong to.
        self.picture.image = QImage(data, width, height, 3 * width, QImage.Format_RGB888).copy()
        self.picture.update()

    @guarded
    def _on_switched(self, on):
        if not on:
            self.picture.image = None
        self.picture.update()
        self.switched.emit(on)

    def turn(self, right, down):
        """Orbit the camera by a drag of so many pixels."""
        self.yaw = (self.yaw - TURN * right + 180.0) % 360.0 - 180.0
        self.pitch = min(-5.0, max(-89.0, self.pitch - TURN * down))
        self.look_changed.emit()

    def zoom(self, notches):
        """Go nearer by so many notches of the wheel."""
        self.distance = min(FARTHEST, max(NEAREST, self.distance * ZOOM**-notches))
        self.look_changed.emit()


class Picture(QWidget):
    """The picture itself, and the mouse on it."""

    def __init__(self, panel):
        super().__init__(panel)
        self._panel, self._last, self.image = panel, None, None
        self.setMinimumSize(160, 100)

    @guarded
    def paintEvent(self, _):
        """Paint the picture in the middle, or say that there is none."""
        painter = QPainter(self)
        try:
            self._paint(painter)
        finally:
            painter.end()  # even if the traceback of an error holds it for a while

    def _paint(self, painter):
        if self.image is None:
            painter.drawText(self.rect(), Qt.AlignCenter, AWAITED if self._panel.is_on() else OFF)
            return
        size = self.image.size().scaled(self.size(), Qt.KeepAspectRatio)
        place = QRect(0, 0, size.width(), size.height())
        place.moveCenter(self.rect().center())
        painter.setRenderHint(QPainter.SmoothPixmapTransform)
        painter.drawImage(place, self.image)

    @guarded
    def mousePressEvent(self, event):
        """Begin to orbit."""
        self._last = event.pos()

    @guarded
    def mouseMoveEvent(self, event):
        """Orbit."""
        if self._last is not None:
            moved = event.pos() - self._last
            self._last = event.pos()
            self._panel.turn(moved.x(), moved.y())

    @guarded
    def mouseReleaseEvent(self, _):
        """End the orbit."""
        self._last = None

    @guarded
    def wheelEvent(self, event):
        """Zoom."""
        self._panel.zoom(event.angleDelta().y() / 120.0)
        event.accept()
