"""Banners across the window for important messages, each with its buttons."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QFrame,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.boxes import row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import DARK, breakable

# Background and text by weight, the heaviest first; on a light and on a dark ground.
KINDS = {
    "alarm": (("#c00000", "#ffffff"), ("#c00000", "#ffffff")),
    "error": (("#fbdad7", "#6d120c"), ("#571b17", "#ffd9d5")),
    "warning": (("#fdebc8", "#5c3b00"), ("#4d3a12", "#ffe3b3")),
    "aside": (("#e3ebf5", "#1f3350"), ("#2b3a4d", "#dbe7f7")),
}
MOST_LINES = 4  # of a text


class Banners(QWidget):
    """One banner for each matter, the most severe on top."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self._strips = {}
        self.column = QVBoxLayout(self, spacing=2)
        self.column.setContentsMargins(4, 4, 4, 4)
        self.setVisible(False)

    def notify(self, matter, kind, text, *buttons):
        """Show ``text`` on the ``matter``; ``kind``: a key of ``KINDS``; ``buttons``: (label, function)."""
        strip = self._strips.get(matter)
        labels = [label for label, _ in buttons]
        if strip is None or (strip.kind, strip.labels) != (kind, labels):
            self.clear(matter)
            strip = self._strips[matter] = _Strip(kind, buttons)
            weights = list(KINDS)
            heavier = [s for s in self._strips.values() if weights.index(s.kind) < _weight(strip)]
            equal = [s for s in self._strips.values() if s.kind == kind and s is not strip]
            self.column.insertWidget(len(heavier) + len(equal), strip)
        strip.say(text)
        strip.show()  # else Qt shows it later, and its height is not known before
        self.setVisible(True)

    def clear(self, matter):
        """Remove the banner of the ``matter``."""
        strip = self._strips.pop(matter, None)
        if strip is not None:
            self.column.removeWidget(strip)
            strip.hide()
            strip.deleteLater()  # its own button may have called this
            self.setVisible(bool(self._strips))

    def text(self, matter):
        """Return the text on the ``matter``, "" for none."""
        strip = self._strips.get(matter)
        return strip.text if strip is not None else ""

    def button(self, matter, label):
        """Return a button of the ``matter``."""
        return self._strips[matter].buttons[label]


def _weight(strip):
    return list(KINDS).index(strip.kind)


@guarded
class _Strip(QFrame):
    def __init__(self, kind, buttons):
        super().__init__()
        self.kind, self.text, self.labels = kind, "", [label for label, _ in buttons]
        self.buttons = {}
        self.setAutoFillBackground(True)
        self._label = _Text()
        for label, function in buttons:
            self.buttons[label] = button = QPushButton(label)
            button.clicked.connect(guarded(lambda *_, called=function: called()))
        row_of((self._label, 1), *self.buttons.values(), owner=self, margins=(8, 3, 4, 3))
        self._paint()

    def say(self, text):
        if text != self.text:
            self.text = text
            lines = text.splitlines()
            more = ["..."] if len(lines) > MOST_LINES else []
            self._label.setText(breakable("\n".join(lines[:MOST_LINES] + more)))
            self.setToolTip(text)

    def _paint(self):
        # Of the application: this strip's own window colour is what is chosen here.
        ground = self.parentWidget().palette() if self.parentWidget() else self.palette()
        dark = ground.color(QPalette.Window).lightness() < DARK
        back, front = KINDS[self.kind][dark]
        font = self.font()
        font.setBold(self.kind == "alarm")
        self._label.setFont(font)
        sheet = "QFrame {{ background: {}; border-radius: 3px; }} QLabel {{ color: {}; }}"
        if self.styleSheet() != sheet.format(back, front):
            self.setStyleSheet(sheet.format(back, front))

    def changeEvent(self, event):
        """Take the colours that suit the new theme."""
        super().changeEvent(event)
        if event.type() in (QEvent.PaletteChange, QEvent.ParentChange):
            self._paint()

    def showEvent(self, event):
        """Take the colours that suit the new background."""
        super().showEvent(event)
        self._paint()


class _Text(QLabel):
    """A text that wraps, and makes nothing wider."""

    def __init__(self):
        super().__init__()
        self.setTextFormat(Qt.PlainText)
        self.setWordWrap(True)
        self.setTextInteractionFlags(Qt.TextSelectableByMouse)
        self.setFocusPolicy(Qt.NoFocus)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)

    def sizeHint(self):
        return QSize(0, super().sizeHint().height())

    def minimumSizeHint(self):
        # Not that of the text broken into a narrow column: the window would grow by it.
        return QSize(0, self.fontMetrics().height())
