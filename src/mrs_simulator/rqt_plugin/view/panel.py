"""The 3D view: what the map shows, seen by a camera that orbits, pans, zooms and follows a robot."""

import time

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, QTimer
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QCheckBox,
    QComboBox,
    QLabel,
    QSizePolicy,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.view.canvas import Canvas
from mrs_simulator.rqt_plugin.widgets import pacing
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

PERIOD, BESIDE = 33, 100  # [ms] between pictures: of a view alone, and of one beside the map
HINT = "Drag to orbit, right button to pan, wheel to zoom"


@guarded
class ViewPanel(QWidget):
    """Shows what ``source()`` returns, a ``Scene``, whenever ``revision()`` has changed."""

    def __init__(self, source, revision, parent=None):
        super().__init__(parent)
        self._source, self._revision, self._shown = source, revision, None
        self.next = 0.0  # [s] of wall time
        self.canvas, self.followed, self._numbers = Canvas(), QComboBox(), None
        self.followed.setToolTip("Keep a robot in the centre")
        self.followed.setSizeAdjustPolicy(QComboBox.AdjustToContents)
        self.followed.activated.connect(self._on_follow)
        self.above = top = QToolButton(text="Top", clicked=self._on_top)
        top.setToolTip("Look straight down, north up, or from aside again (T)")
        fit = QToolButton(text="Fit", toolTip="Fit the team into view (F). " + HINT)
        fit.clicked.connect(self._on_fit)
        self.beside = QCheckBox("Beside map", checked=True)
        self.beside.setToolTip("Show this view beside the map, else among the tabs below")
        self._hint = hint = QLabel(HINT, enabled=False)
        hint.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)  # cut off rather than wide
        above = row_of((hint, 1), 0, self.beside, self.followed, top, fit)
        column_of(above, (self.canvas, 1), owner=self, margins=0)
        self.timer = QTimer(self, interval=PERIOD, timeout=self.refresh)

    def showEvent(self, event):
        """Begin to poll for changes, which are not drawn while the view is hidden."""
        super().showEvent(event)
        self.timer.start()
        self.refresh()

    def hideEvent(self, event):
        """Stop polling."""
        super().hideEvent(event)
        if hasattr(self, "timer"):  # else Python has collected it, shown, before Qt takes it down
            self.timer.stop()

    def set_beside(self, beside):
        """Draw less often where the map shows the same beside it, and leave the room to the picture."""
        self._hint.setVisible(not beside)
        self.timer.setInterval(BESIDE if beside else PERIOD)

    @guarded
    def refresh(self, *_):
        """Show the scene if it has changed."""
        now, revision = time.monotonic(), self._revision()
        if revision == self._shown or now < self.next:
            return
        self._shown = revision
        scene = self._source()
        self.canvas.show_scene(scene)
        self._offer(scene.state.robots)
        self.next = now + pacing.pause(self.canvas.cost, pacing.VIEW, len(scene.kinds))

    def _offer(self, numbers):
        """Offer the robots ``numbers`` to follow."""
        if numbers == self._numbers:
            return
        self._numbers, chosen = numbers, self.followed.currentData()
        self.followed.clear()
        self.followed.addItem("whole team", 0)
        for number in numbers:
            self.followed.addItem("follow robot {}".format(number), number)
        self.followed.setCurrentIndex(max(0, self.followed.findData(chosen)))
        self.canvas.follow(self.followed.currentData())
        self.canvas.fit(anew=True)

    def follow(self, number):
        """Keep the robot ``number`` in the centre."""
        self.followed.setCurrentIndex(max(0, self.followed.findData(number)))
        self.canvas.follow(self.followed.currentData())

    def _on_follow(self, *_):
        self.canvas.follow(self.followed.currentData())

    def _on_fit(self, *_):
        self.followed.setCurrentIndex(0)
        self.canvas.follow(0)
        self.canvas.fit()

    def _on_top(self, *_):
        self.canvas.look_down()

    def keyPressEvent(self, event):
        """Fit by F, look down by T."""
        if event.key() == Qt.Key_F and not event.modifiers():
            self._on_fit()
        elif event.key() == Qt.Key_T and not event.modifiers():
            self._on_top()
        else:
            super().keyPressEvent(event)
