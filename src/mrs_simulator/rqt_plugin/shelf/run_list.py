"""The list of runs: a click shows one, its box lays it over the run that is shown."""

import os
import time

from mrs_simulator.rqt_plugin.qt.QtCore import QAbstractListModel, QModelIndex, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QAbstractItemView, QListView
from mrs_simulator.rqt_plugin.shelf.differences import differing, telling
from mrs_simulator.rqt_plugin.shelf.run_row import ENTRY, LINES, LOW_LINES, RunRow, when_text
from mrs_simulator.rqt_plugin.shelf.thumbnail import Thumbnails
from mrs_simulator.rqt_plugin.widgets.guard import guarded

SAME, AGAINST, ELSE_AS = "as {}", "{}, against {}", "else as {}"
SWEPT, NOTHING = "{} runs over {}", "nothing yet"
MOST_NAMED = 4  # [-] differences in a row


class RunModel(QAbstractListModel):
    """``Entry``s, what differs from an earlier run, and which are compared or shown."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.entries, self._texts = [], []
        self.compared, self.shown = [], ""  # paths: those laid over the run shown, and that
        self.unfolded = set()  # paths of the sweeps whose runs are listed

    def rowCount(self, parent=None):
        """Return how many runs there are."""
        return 0 if parent is not None and parent.isValid() else len(self.entries)

    def data(self, index, role=Qt.DisplayRole):
        """Return what the list asks for."""
        if not index.isValid() or index.row() >= len(self.entries):
            return None
        entry = self.entries[index.row()]
        if role == ENTRY:
            return entry, self._texts[index.row()]
        if role == Qt.CheckStateRole:
            return Qt.Checked if entry.path in self.compared else Qt.Unchecked
        if role == Qt.DisplayRole:  # what a screen reader reads, and what is typed for
            return entry.name
        if role == Qt.ToolTipRole:
            return tip_of(entry, self._texts[index.row()])
        return None

    def take(self, entries):
        """List ``entries``, the newest first; return whether that changed anything."""
        if entries == self.entries:
            return False
        self.beginResetModel()
        self.entries = entries
        self._texts = [self._difference(row) for row in range(len(entries))]
        present = {entry.path for entry in entries}
        self.compared = [path for path in self.compared if path in present]
        self.endResetModel()
        return True

    def _difference(self, row):
        """Return in words what differs from the run before of the same title, else of any, and its time.

        "" where it is not known.  Of a sweep: over what it is; of a what-if: the run as which it begins.
        """
        if self.entries[row].sweep is not None:
            swept = self.entries[row].sweep
            return SWEPT.format(swept.runs, ", ".join(swept.keys) or NOTHING)
        if self.entries[row].origin:
            name, when = self.entries[row].origin
            return ELSE_AS.format(", ".join([name] + [when_text(when)] * (when > 0)))
        keys = {} if self.entries[row].within else self.entries[row].keys
        earlier = [e for e in self.entries[row + 1 :] if e.keys and not (e.within or e.origin)]
        alike = [each for each in earlier if each.title == self.entries[row].title]
        before = next(iter(alike + earlier), None)
        if not keys or before is None:
            return ""
        found, when = telling(differing((before.keys, keys))), when_text(before.time)
        texts = [each.text for each in found[:MOST_NAMED]] + ["..."] * (len(found) > MOST_NAMED)
        return AGAINST.format(", ".join(texts), when) if found else SAME.format(when)

    def about(self, path):
        """Return name and time [s] of the run at ``path``, () where it is not listed."""
        row = self.row_of(path)
        return (self.entries[row].name, self.entries[row].time) if row >= 0 else ()

    def toggle(self, row):
        """Lay the run in ``row`` over the one shown, or no longer."""
        path = self.entries[row].path
        if path in self.compared:
            self.compared.remove(path)
        else:
            self.compared.append(path)
        self.dataChanged.emit(self.index(row), self.index(row))

    def row_of(self, path):
        """Return the row of the run at ``path``, -1 for none."""
        paths = [entry.path for entry in self.entries]
        return paths.index(path) if path in paths else -1


def tip_of(entry, difference):
    """Return all that the list knows of a run."""
    when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(entry.time))
    lines = [entry.name, entry.path, "{}, {}".format(when, size_text(entry.size))]
    lines += ["changed: " + difference] if difference else []
    return "\n".join(lines + ([entry.marks.note] if entry.marks.note else []))


def size_text(size):
    """Return a ``size`` [bytes] as a person reads it."""
    for unit in ("kB", "MB", "GB"):
        size /= 1000.0
        if size < 999.5 or unit == "GB":
            return "{:.3g} {}".format(size, unit)
    return ""


@guarded
class RunList(QListView):
    """The list, with mouse and keys: Return shows, blank compares or unfolds, Del deletes."""

    show_asked = Signal(str)  # path of a run
    compared_changed = Signal(object)  # paths of the runs to compare with the one shown
    delete_asked = Signal(str)
    folded = Signal()  # a sweep was, or was unfolded
    dropped = Signal(object)  # paths of files and folders

    def __init__(self, parent=None):
        super().__init__(parent)
        self.runs, self.thumbnails = RunModel(self), Thumbnails()
        self.setModel(self.runs)
        self.setItemDelegate(RunRow(self.thumbnails, self))
        self.setSelectionMode(QAbstractItemView.SingleSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarAlwaysOff)
        self.setResizeMode(QListView.Adjust)
        self.setAcceptDrops(True)
        self.setAccessibleName("Runs")

    def take(self, entries):
        """List ``entries``; what was current stays so."""
        path = self.current_path()
        if self.runs.take(entries):
            self.choose(path)

    def current_path(self):
        """Return the path of the current run, "" for none."""
        current = self.current()
        return "" if current is None else current.path

    def current(self):
        """Return the ``Entry`` of the row that is highlighted, None for none."""
        rows = [index.row() for index in self.selectionModel().selectedIndexes()]
        return self.runs.entries[rows[0]] if rows and rows[0] < len(self.runs.entries) else None

    def choose(self, path):
        """Make the run at ``path`` the current one; return whether it is there."""
        row = self.runs.row_of(path)
        if row >= 0:
            self.setCurrentIndex(self.runs.index(row))
        return row >= 0

    def follow(self):
        """Show pictures that are there by now."""
        if self.thumbnails.take():
            self.viewport().update()

    def set_low(self, low):
        """Show rows of fewer lines where there is little room."""
        self.itemDelegate().lines = LOW_LINES if low else LINES
        self.scheduleDelayedItemsLayout()

    def set_shown(self, path):
        """Mark the run at ``path`` as the one that is shown, "" for none; its row becomes the current one.

        Of a sweep that is folded this is the sweep's.  Return whether another run is shown by now.
        """
        if path == self.runs.shown:
            return False
        self.runs.shown = path
        if not self.choose(path) and not self.choose(os.path.dirname(path)):
            self._choose_none()
        self.viewport().update()
        return True

    def _choose_none(self):
        self.setCurrentIndex(QModelIndex())
        self.clearSelection()

    def toggle(self, row):
        """Compare the run in ``row``, or no longer; fold or unfold a sweep."""
        entry = self.runs.entries[row]
        if entry.sweep is not None:
            self.runs.unfolded.symmetric_difference_update([entry.path])
            self.viewport().update()
            self.folded.emit()
            return
        self.runs.toggle(row)
        self.compared_changed.emit(list(self.runs.compared))

    def clear_compared(self):
        """Compare nothing."""
        self.runs.compared = []
        self.viewport().update()
        self.compared_changed.emit([])

    def mousePressEvent(self, event):
        """Compare by the box, or with Ctrl; else show."""
        index, left = self.indexAt(event.pos()), event.button() == Qt.LeftButton
        in_box = self.itemDelegate().box(self.visualRect(index)).contains(event.pos())
        if index.isValid() and left and (in_box or event.modifiers() & Qt.ControlModifier):
            self.toggle(index.row())  # whose name and note are not asked for
            return
        if event.button() == Qt.RightButton:
            return  # its menu is for the row below the mouse, the highlighted one stays
        super().mousePressEvent(event)
        if index.isValid() and left:
            self.show_asked.emit(self.runs.entries[index.row()].path)

    def keyPressEvent(self, event):
        """Show, compare or delete the current run."""
        path = self.current_path()
        row = self.runs.row_of(path)
        if path and event.key() in (Qt.Key_Return, Qt.Key_Enter):
            self.show_asked.emit(path)
        elif path and event.key() == Qt.Key_Space:
            self.toggle(row)
        elif path and event.key() in (Qt.Key_Left, Qt.Key_Right):
            self._fold(row, event.key() == Qt.Key_Left)
        elif path and event.key() == Qt.Key_Delete:
            self.delete_asked.emit(path)
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event):
        """Highlight by Tab the row that keys act on; of itself the list would make one current unseen."""
        super().focusInEvent(event)
        if self.current() is None:
            by_key = event.reason() in (Qt.TabFocusReason, Qt.BacktabFocusReason)
            if by_key:
                self.setCurrentIndex(self.currentIndex())
            else:
                self._choose_none()

    def _fold(self, row, folded):
        """Fold or unfold the sweep in ``row``; from a run of one go to the sweep, to fold it."""
        entry = self.runs.entries[row]
        if entry.within and folded:
            self.choose(entry.within)
        elif entry.sweep is not None and folded == (entry.path in self.runs.unfolded):
            self.toggle(row)

    def dragEnterEvent(self, event):
        """Take files and folders."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dragMoveEvent(self, event):
        """Take files and folders."""
        event.acceptProposedAction()

    def dropEvent(self, event):
        """Add what was dropped."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        self.dropped.emit([os.path.normpath(path) for path in paths])
        event.acceptProposedAction()
