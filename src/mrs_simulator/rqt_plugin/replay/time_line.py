"""The line below the map on which a moment of the run is chosen."""

from mrs_simulator.rqt_plugin.qt.QtCore import QSize, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QComboBox,
    QLabel,
    QSizePolicy,
    QSlider,
    QStyle,
    QStyleOptionSlider,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.replay.time_cursor import SPEEDS
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

STEPS = 10000  # [-] of the slider
SMALL = 0.8  # [-] of the window's font: run and moment are two lines
TEN = 10  # [-] samples of a step with Shift
NO_RUN, OWN = "no run yet", "this window's run"
KEYS = "Left and right: a sample, with Shift ten; Home and End: the first, the newest; blank: play"


@guarded
class TimeSlider(QSlider):
    """A slider that goes where it is clicked; keys step through samples of the ``cursor``."""

    def __init__(self, cursor):
        super().__init__(Qt.Horizontal)
        self._cursor = cursor
        self.setRange(0, STEPS)
        self.setToolTip("The moment of the run that is shown.\n" + KEYS)
        self.setFocusPolicy(Qt.StrongFocus)

    def mousePressEvent(self, event):
        """Go where the click is, and on with the mouse."""
        if event.button() == Qt.LeftButton:
            option = QStyleOptionSlider()
            self.initStyleOption(option)
            handle = self.style().subControlRect(
                QStyle.CC_Slider, option, QStyle.SC_SliderHandle, self
            )
            room = max(1, self.width() - handle.width())
            at = event.x() - handle.width() // 2
            self.setValue(QStyle.sliderValueFromPosition(0, STEPS, at, room))
        super().mousePressEvent(event)

    def keyPressEvent(self, event):
        """Step, go to an end, or play."""
        samples = TEN if event.modifiers() & Qt.ShiftModifier else 1
        cursor, key = self._cursor, event.key()
        if key in (Qt.Key_Left, Qt.Key_Right):
            cursor.step(samples if key == Qt.Key_Right else -samples)
        elif key == Qt.Key_Home and cursor.span is not None:
            cursor.go(cursor.span[0])
        elif key == Qt.Key_End:
            cursor.follow()
        elif key == Qt.Key_Space:
            cursor.play(not cursor.playing)
        else:
            super().keyPressEvent(event)


@guarded
class TimeLine(QWidget):
    """Slider, play button and speed of a ``TimeCursor``, and in words which run and moment are shown."""

    close_asked = Signal()  # of a run that was opened

    def __init__(self, cursor, parent=None):
        super().__init__(parent)
        self.cursor, self._has_room, self._opened, self.run = cursor, True, None, QLabel()
        self.play, self.newest = QToolButton(), QToolButton(checkable=True, clicked=self._on_newest)
        self.slider, self.speed, self.label = TimeSlider(cursor), QComboBox(), QLabel(NO_RUN)
        self.play.clicked.connect(guarded(lambda *_: cursor.play(not cursor.playing)))
        self.run.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        small = self.font()
        small.setPointSizeF(SMALL * small.pointSizeF())  # so that the line is no higher
        self.run.setFont(small)
        self.label.setFont(small)
        self.set_opened("")
        for speed in SPEEDS:
            self.speed.addItem("{:g} \u00d7".format(speed), speed)
        self.speed.setCurrentIndex(SPEEDS.index(1.0))
        self.speed.setToolTip("Recorded time over wall time of a replay")
        self.speed.activated.connect(self._on_speed)
        widest = self.fontMetrics().horizontalAdvance("past: 0000.00 of 0000.0 s")
        self.label.setMinimumWidth(widest)
        texts = column_of(self.run, self.label, spacing=0), 2
        parts = self.play, (self.slider, 3), texts, self.speed, self.newest
        row_of(*parts, owner=self, margins=(2, 0, 2, 0), spacing=4)
        for each in (self.run, self.label):
            each.setMaximumHeight(self.speed.sizeHint().height() // 2)
        self.slider.valueChanged.connect(self._on_slider)
        cursor.changed.connect(self.show_moment)
        self.show_moment()

    def minimumSizeHint(self):
        """Return a size that makes no window wider."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event):
        """Leave out what there is no room for."""
        super().resizeEvent(event)
        text = self.label.minimumWidth()
        self.speed.setVisible(self.width() > 2.6 * text)
        for each in (self.run, self.label):
            each.setVisible(self.width() > 1.8 * text)
        self._show_run()

    def give_room(self, has_room):
        """Show the line before there is a run only where it ``has_room``."""
        self._has_room = has_room
        self.show_moment()

    def set_opened(self, title):
        """Offer to close the run called ``title`` that was opened, "" to follow the one of now."""
        if title == self._opened:
            return
        self._opened = title
        texts = "Close run", "Show the window's own run again"
        texts = texts if title else ("Newest", "Follow the newest sample (End)")
        self.newest.setText(texts[0])
        self.newest.setToolTip(texts[1])
        self._show_run()

    def _show_run(self):
        """Show which run this is."""
        text = self._opened or (OWN if self.cursor.span is not None else "")
        shown = self.run.fontMetrics().elidedText(text, Qt.ElideMiddle, self.run.width())
        if shown != self.run.text():
            self.run.setText(shown)
            self.run.setToolTip(text)

    def _on_newest(self, *_):
        if self._opened:
            self.close_asked.emit()
        else:
            self.cursor.follow()

    def _on_speed(self, *_):
        self.cursor.speed = self.speed.currentData()

    def _on_slider(self, value):
        span = self.cursor.span
        if span is not None:
            self.cursor.playing = False
            self.cursor.go(span[0] + value / STEPS * (span[1] - span[0]))

    @guarded
    def show_moment(self, *_):
        """Show which moment of the run is shown."""
        cursor, span = self.cursor, self.cursor.span
        self.setVisible(self._has_room or span is not None)
        self._show_run()
        for widget in (self.play, self.slider, self.speed, self.newest):
            widget.setEnabled(span is not None)
        self.newest.setChecked(not cursor.is_past and not self._opened)
        self.play.setText("\u275a\u275a" if cursor.playing else "\u25b6")
        self.play.setToolTip("Pause the replay" if cursor.playing else "Replay the run")
        if span is None:
            self.label.setText(NO_RUN)
            return
        now = cursor.time if cursor.is_past else span[1]
        self.slider.blockSignals(True)
        self.slider.setValue(int(round(STEPS * (now - span[0]) / (span[1] - span[0]))))
        self.slider.blockSignals(False)
        font = self.label.font()
        font.setBold(cursor.is_past)
        self.label.setFont(font)
        passed = now - span[0], span[1] - span[0]
        newest = "end: {1:.1f} s" if self._opened else "newest: {1:.1f} s"
        text = "past: {:.2f} of {:.1f} s" if cursor.is_past else newest
        self.label.setText(text.format(*passed))
