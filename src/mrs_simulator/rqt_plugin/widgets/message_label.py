"""A line of text beside a field, with an error or a remark."""

import re

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import QLabel, QSizePolicy
from mrs_simulator.rqt_plugin.widgets.guard import guarded

# On a light and on a dark background.
COLOURS = {
    "error": ("#b3261e", "#ff8a80"),
    "warning": ("#7a4f00", "#ffc46b"),
    "aside": ("#5c5c5c", "#b4b4b4"),
    "good": ("#1b6b34", "#7fdc9a"),
    "link": ("#0000ee", "#8ab4f8"),
}
DARK = 128  # [-] a background whose lightness (of 255) is below is dark
LONG_WORD = re.compile("([^\\s\u200b]{20})(?=\\S)")  # may be broken after 20 characters


def tint(kind, palette):
    """Return the colour of ``kind``, a key of ``COLOURS``, that can be read in the theme."""
    return COLOURS[kind][palette.color(QPalette.Window).lightness() < DARK]


@guarded
class TintedLabel(QLabel):
    """A line of plain text in a colour that follows the theme."""

    def __init__(self, kind, text="", parent=None):
        """``kind`` is a key of ``COLOURS``."""
        super().__init__(text, parent)
        self.setTextFormat(Qt.PlainText)
        self.tint(kind)

    def tint(self, kind):
        """Take the colour of ``kind``."""
        self._kind = kind
        palette = self.palette()
        wanted = QColor(tint(kind, palette))
        if palette.color(QPalette.WindowText) != wanted:
            palette.setColor(QPalette.WindowText, wanted)
            self.setPalette(palette)

    def changeEvent(self, event):
        """Take the colour that suits the new theme."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange:
            self.tint(self._kind)


class MessageLabel(TintedLabel):
    """A text that wraps, and takes no room while empty."""

    def __init__(self, kind="error", parent=None):
        """``kind`` is a key of ``COLOURS``."""
        super().__init__(kind, parent=parent)
        self.message = ""
        self.setWordWrap(True)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        self.setVisible(False)

    def sizeHint(self):
        """Return a small width, so that no long text makes its surroundings wide."""
        return QSize(0, super().sizeHint().height())

    def minimumSizeHint(self):
        """Return one line: how many are needed follows from the width."""
        return QSize(0, self.fontMetrics().height())

    def say(self, message, kind=None):
        """Show ``message``, or nothing if it is empty."""
        self.tint(kind or self._kind)
        if message != self.message:
            self.message = message
            self.setText(breakable(message))
            self.setVisible(bool(message))


def breakable(text):
    """Return ``text`` with invisible places to break names, paths and very long words."""
    text = re.sub(r"([/_])(?=\w)", "\\1\u200b", text)
    return LONG_WORD.sub("\\1\u200b", text)
