"""A file dialog that does not block the rest of the GUI, the emergency stop above all."""

import os

from mrs_simulator.rqt_plugin.qt.QtCore import QUrl
from mrs_simulator.rqt_plugin.qt.QtWidgets import QFileDialog, QLineEdit
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen


@guarded
class FileDialog(QFileDialog):
    """Asks for a file to open, or to save to, and leaves the other windows their mouse and keys.

    Qt's own dialog, as native ones keep the keys.  Where Qt would ask or warn in a window that holds
    up all others, this one does without: it deletes and renames nothing, takes names of files that
    do not exist, and asks by its button whether one that exists is to be replaced.
    """

    def __init__(self, parent, title, start, kinds, chosen, saves=False, places=()):
        """``start``: directory or file to begin with; ``chosen``: is called with the path.

        ``places``: directories that are offered beside the files.  Without ``kinds`` of files an existing
        directory is asked for, unless it ``saves``.
        """
        super().__init__(parent, title, os.path.dirname(start), kinds)
        for option in (self.DontUseNativeDialog, self.ReadOnly, self.DontConfirmOverwrite):
            self.setOption(option)
        self.setSidebarUrls([QUrl.fromLocalFile(place) for place in dict.fromkeys(places)])
        self._saves, self._title = saves, title
        self.setAcceptMode(self.AcceptSave if saves else self.AcceptOpen)
        self.setFileMode(self.AnyFile if saves or kinds else self.Directory)
        self.selectFile(os.path.basename(start))
        self.findChild(QLineEdit).textChanged.connect(guarded(lambda *_: self._ask_to_replace("")))
        self._chosen = chosen
        self.fileSelected.connect(self._on_selected)
        self.finished.connect(self.deleteLater)
        OnScreen(self)
        self.show()

    @guarded
    def accept(self):
        """Give the file; one that would be replaced, once its button is pressed again."""
        existing = [path for path in self.selectedFiles() if self._saves and os.path.isfile(path)]
        if existing and self.labelText(self.Accept) != "Replace":
            self._ask_to_replace(existing[0])
        else:
            super().accept()

    def _on_selected(self, path):
        self.hide()  # what is chosen may take long, and be cancelled in the window behind
        self._chosen(path)

    def _ask_to_replace(self, path):
        if self._saves:
            self.setLabelText(self.Accept, "Replace" if path else "Save")
            self.setWindowTitle("{} exists: replace it?".format(path) if path else self._title)
