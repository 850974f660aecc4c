"""Keeps a window on its screen, with the frame that a window manager gives it."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QObject, QRect, QTimer
from mrs_simulator.rqt_plugin.qt.QtGui import QGuiApplication
from mrs_simulator.rqt_plugin.widgets.guard import guarded

EVERY, LOOKS = 50, 40  # [ms] between looks for the frame, which comes late; [-] of them at most


@guarded
class OnScreen(QObject):
    """Shrinks and moves a window, as it is shown, that reaches beyond its screen.

    Afterwards it may be put anywhere.
    """

    def __init__(self, window):
        super().__init__(window)
        self._window, self._looks = window, 0
        self._timer = QTimer(self, interval=EVERY, timeout=self._on_time)
        window.installEventFilter(self)

    def eventFilter(self, watched, event):
        """Begin as the window is shown."""
        if event.type() == QEvent.Show and not event.spontaneous():
            self._looks = LOOKS
            self._timer.start()
            self.keep()
        return False

    def _on_time(self, *_):
        self._looks -= 1
        framed = self._window.frameGeometry() != self._window.geometry()
        self.keep()
        if framed or self._looks <= 0:
            self._timer.stop()

    def keep(self):
        """Shrink and move the window, where it is neither maximized nor fills the screen."""
        window = self._window
        if window.isMaximized() or window.isFullScreen():
            return
        at = window.frameGeometry()
        screen = QGuiApplication.screenAt(at.center()) or QGuiApplication.primaryScreen()
        room = screen.availableGeometry()
        window.resize(window.size().boundedTo(room.size() - (at.size() - window.size())))
        frame = QRect(at.topLeft(), window.frameGeometry().size())
        frame.moveRight(min(frame.right(), room.right()))
        frame.moveBottom(min(frame.bottom(), room.bottom()))
        frame.moveLeft(max(frame.left(), room.left()))
        frame.moveTop(max(frame.top(), room.top()))
        if frame.topLeft() != at.topLeft():
            window.move(frame.topLeft())
