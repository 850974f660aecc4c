"""The shelf: the list of runs, and what can be done with one of them."""

from mrs_simulator.core.fields import counted
from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.shelf.run_details import RunDetails
from mrs_simulator.rqt_plugin.shelf.run_list import RunList, size_text
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel

EMPTY = (
    "No runs yet. Each run made here comes on this list; runs of other programs are added by the "
    "menu, or dropped here."
)
SIZES = (1, 2, 5, 20, 100)  # [GB] that the user's folder may hold
GIGA = 10**9  # [bytes]
ADDING = (
    ("run", "Add a run...", "A folder with a run.csv, or a bag: it stays where it is"),
    ("watch", "Watch a folder...", "Its runs are listed as they come and go"),
    ("folder", "Keep runs in...", "The folder in which runs made here are kept"),
)
LOW = 14  # [lines of text] of height, below which the list has all of it


@guarded
class ShelfPanel(QWidget):
    """Shows ``Entry``s, and asks by signals for what is done to them."""

    mark_asked = Signal(str, object)  # path, and marks by name
    delete_asked = Signal(str)
    undo_asked = Signal()
    scenario_asked = Signal(str)  # path of the run whose scenario is to be edited
    add_asked = Signal(str)  # a name of ``ADDING``
    unwatch_asked = Signal(str)
    size_chosen = Signal(object)  # [bytes]

    def __init__(self, parent=None):
        super().__init__(parent)
        self._entries, self._filter, self._is_low = [], QLineEdit(placeholderText="Filter"), False
        self.list, self._hint = RunList(), MessageLabel("aside")
        self._hint.say(EMPTY)
        self._filter.setToolTip("Words that name, protocol, verdict or note contain")
        self._filter.setClearButtonEnabled(True)
        self._filter.textChanged.connect(guarded(lambda *_: self._list()))
        self.menu = QToolButton(text="Folders", popupMode=QToolButton.InstantPopup)
        self.menu.setMenu(QMenu(self.menu))
        self._sizes = QMenu("Keep at most", self.menu)
        self.clear = QPushButton("Compare none", visible=False)
        self.clear.clicked.connect(guarded(lambda *_: self.list.clear_compared()))
        top = row_of((self._filter, 1), self.clear, self.menu)
        parts = top, self._hint, (self.list, 1), self._build_details(), self._build_foot()
        column_of(*parts, owner=self, margins=4, spacing=4)
        self.list.selectionModel().selectionChanged.connect(self._on_current)
        self.list.runs.modelReset.connect(self._on_current)
        compared = self.list.compared_changed
        compared.connect(guarded(lambda paths: self.clear.setVisible(bool(paths))))
        self.list.delete_asked.connect(self.delete_asked)
        self._on_current()

    def _build_details(self):
        """Return what is edited of the current run."""
        self.details = details = RunDetails()
        self.name, self.note, self.pin = details.name, details.note, details.pin
        details.marked.connect(self.mark_asked)
        details.delete_asked.connect(self.delete_asked)
        details.scenario_asked.connect(self.scenario_asked)
        self.list.setContextMenuPolicy(Qt.CustomContextMenu)
        self.list.customContextMenuRequested.connect(self._on_menu)
        return details

    def _build_foot(self):
        self._size, self.undo = QLabel(enabled=False), QPushButton("Undo deletion", visible=False)
        self._size.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        self.undo.clicked.connect(guarded(lambda *_: self.undo_asked.emit()))
        return row_of((self._size, 1), self.undo)

    # Showing -------------------------------------------------------------------------------------

    def show_entries(self, entries, settings, own):
        """List ``entries``; ``settings``: the shelf's; ``own``: the size [bytes] of the user's folder."""
        self._entries = entries
        self._hint.setVisible(not entries)
        self._list()
        runs = sum(each.sweep.runs if each.sweep else not each.within for each in entries)
        sizes = size_text(own), size_text(settings["most_bytes"])
        text = "{}, {} of {}".format(counted(runs, "run"), *sizes)
        self._size.setText(text)
        self._size.setToolTip("kept in {}".format(settings["folder"]))
        self._fill_menu(settings)

    def _fill_menu(self, settings):
        menu, sizes = self.menu.menu(), self._sizes
        if menu.isVisible():
            return
        menu.clear()  # but for submenus, which would pile up if they were made anew
        sizes.clear()
        menu.setToolTipsVisible(True)
        for name, text, tip in ADDING:
            action = menu.addAction(text)
            action.setToolTip(tip)
            action.triggered.connect(guarded(lambda *_, n=name: self.add_asked.emit(n)))
        menu.addMenu(sizes)
        for size in SIZES:
            action = sizes.addAction("{} GB".format(size))
            action.setCheckable(True)
            action.setChecked(settings["most_bytes"] == size * GIGA)
            action.triggered.connect(guarded(lambda *_, s=size: self.size_chosen.emit(s * GIGA)))
        for folder in settings["watched"]:
            action = menu.addAction("Watch no longer: {}".format(folder))
            action.triggered.connect(guarded(lambda *_, f=folder: self.unwatch_asked.emit(f)))

    def _list(self):
        words = self._filter.text().lower().split()
        self.list.take([each for each in self._entries if _matches(each, words)])

    def _on_current(self, *_):
        """Show the marks of the current run."""
        entry = self.list.current()
        self.details.setVisible(entry is not None and not self._is_low)
        if entry is not None:
            self.details.show_entry(entry)

    def _on_menu(self, at):
        index = self.list.indexAt(at)
        if index.isValid():
            menu = self.details.menu(self.list.runs.entries[index.row()])
            menu.popup(self.list.viewport().mapToGlobal(at))

    def resizeEvent(self, event):
        """Leave the room to the list where there is little; the menu of a run has its buttons, too."""
        super().resizeEvent(event)
        low = self.height() < LOW * self.fontMetrics().height()
        if low != self._is_low:
            self._is_low = low
            self._size.setVisible(not low)
            self.list.set_low(low)
            self._on_current()

    def keyPressEvent(self, event):
        """Rename by F2."""
        if event.key() == Qt.Key_F2 and self.details.isVisible():
            self.details.rename()
        else:
            super().keyPressEvent(event)


def _matches(entry, words):
    text = " ".join((entry.name, entry.protocol, entry.outcome, entry.marks.note)).lower()
    return all(word in text for word in words)
