"""The list of messages, errors in colour, with a count of unseen errors."""

import html
import logging
import time
from collections import deque

from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QPlainTextEdit
from mrs_simulator.rqt_plugin.widgets.guard import LOG, guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint

EMPTY = "No messages yet. What is done here, and what goes wrong, is listed with its time."
MOST_LINES = 500
MOST_FAULTS = 20  # [-] kept while the GUI is busy


@guarded
class MessageList(QPlainTextEdit):
    """Messages with their times; ``unseen_changed`` emits the number of errors added while hidden."""

    unseen_changed = Signal(int)

    def __init__(self, parent=None):
        super().__init__(parent)
        self.unseen = 0
        self.setReadOnly(True)
        self.setMaximumBlockCount(MOST_LINES)
        self.setPlaceholderText(EMPTY)

    def add(self, text, trouble=False):
        """Add ``text``, in the colour of errors if ``trouble``."""
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

    def showEvent(self, event):
        """Count all as seen."""
        super().showEvent(event)
        self._count(0)


class ErrorLog(logging.Handler):
    """Collects what :func:`guarded` logs, from any thread, until it is shown."""

    def __init__(self):
        super().__init__(logging.ERROR)
        self._texts = deque(maxlen=MOST_FAULTS)
        LOG.addHandler(self)

    def emit(self, record):
        """Add the text of ``record``."""
        error = record.exc_info[1] if record.exc_info else None
        kind = "" if error is None else ": {}: {}".format(type(error).__name__, error)
        self._texts.append("internal error of the GUI {}{}".format(record.getMessage(), kind))

    def take(self):
        """Return the texts since the last call."""
        return [self._texts.popleft() for _ in range(len(self._texts))]

    def close(self):
        """Remove this handler from the log."""
        LOG.removeHandler(self)
        super().close()
