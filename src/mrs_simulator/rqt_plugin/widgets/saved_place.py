"""A line that says where the newest file is, and opens its folder by a click."""

import html
import os

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, QUrl, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QDesktopServices
from mrs_simulator.rqt_plugin.qt.QtWidgets import QLabel, QSizePolicy
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint

TEXT = "saved: {} \u2013 <a href='folder' style='color: {}'>Open folder</a>"
TIP = "{}\nA click on the link opens its folder"
LEAST = 24  # [average characters] of a path that are shown at least


@guarded
class SavedPlace(QLabel):
    """Names a path until the next one, or until it is cleared."""

    not_opened = Signal(str)  # the folder that no program of this computer opens

    def __init__(self, parent=None):
        super().__init__(parent)
        self.path = ""
        self.setTextFormat(Qt.RichText)
        self.setTextInteractionFlags(Qt.TextBrowserInteraction)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        self.linkActivated.connect(self._on_link)
        self.setVisible(False)

    def name(self, path, width):
        """Name ``path`` in ``width`` [px], without its middle where that is too little."""
        self.path = os.path.abspath(path)
        metrics = self.fontMetrics()
        others = metrics.horizontalAdvance("saved:  \u2013 Open folder ")
        room = max(LEAST * metrics.averageCharWidth(), width - others)
        home = os.path.expanduser("~") + os.sep
        short = "~" + os.sep + self.path[len(home) :] if self.path.startswith(home) else self.path
        shown = metrics.elidedText(short, Qt.ElideMiddle, room)
        self.setText(TEXT.format(html.escape(shown), tint("link", self.palette())))
        self.setToolTip(TIP.format(self.path))
        self.setVisible(True)

    def forget(self):
        """Name nothing."""
        self.path = ""
        self.setVisible(False)

    def folder(self):
        """Return the folder of what is named; a folder that is named is its own."""
        return self.path if os.path.isdir(self.path) else os.path.dirname(self.path)

    def _on_link(self, _):
        if not QDesktopServices.openUrl(QUrl.fromLocalFile(self.folder())):
            self.not_opened.emit(self.folder())
