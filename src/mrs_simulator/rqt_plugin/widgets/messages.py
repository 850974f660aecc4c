"""All messages so far, those on trouble in colour, and how many of these nobody has seen."""

import html
import logging
import time
from collections import deque

from python_qt_binding.QtCore import Signal
from python_qt_binding.QtWidgets import QPlainTextEdit

from mrs_simulator.rqt_plugin.widgets.guard import LOG, guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint

MOST_LINES = 500
MOST_FAULTS = 20  # [-] kept while the GUI is busy


class MessageList(QPlainTextEdit):
    """Messages with their times; ``unseen_changed`` tells how many on trouble came while hidden."""

    unseen_changed = Signal(int)

    def __init__(self, parent=None):
        super().__init__(parent)
        self.unseen = 0
        self.setReadOnly(True)
        self.setLineWrapMode(QPlainTextEdit.NoWrap)
        self.setMaximumBlockCount(MOST_LINES)

    def add(self, text, trouble=False):
        """Add ``text``; in the colour of errors where it tells of ``trouble``."""
        line = html.escape("{}  {}".format(time.strftime("%H:%M:%S"), text))
        line = line.replace("\n", "<br>").replace("  ", "&nbsp; ")
        if trouble:
            line = "<span style='color:{}'>{}</span>".format(tint("error", self.palette()), line)
        self.appendHtml(line)
        if trouble and not self.isVisible():
            self._count(self.unseen + 1)

    def _count(self, unseen):
        if unseen != self.unseen:
            self.unseen = unseen
            self.unseen_changed.emit(unseen)

    @guarded
    def showEvent(self, event):
        """Count all as seen."""
        super().showEvent(event)
        self._count(0)


class ErrorLog(logging.Handler):
    """Keeps what :func:`guarded` logs, from any thread, until it is taken to be shown."""

    def __init__(self):
        super().__init__(logging.ERROR)
        self._told = deque(maxlen=MOST_FAULTS)
        LOG.addHandler(self)

    def emit(self, record):
        """Keep one record."""
        error = record.exc_info[1] if record.exc_info else None
        kind = "" if error is None else ": {}: {}".format(type(error).__name__, error)
        self._told.append("internal error of the GUI {}{}".format(record.getMessage(), kind))

    def take(self):
        """Return the texts since the last call."""
        return [self._told.popleft() for _ in range(len(self._told))]

    def close(self):
        """Listen no more."""
        LOG.removeHandler(self)
        super().close()
