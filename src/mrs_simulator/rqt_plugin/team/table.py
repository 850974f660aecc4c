"""The table of initial poses: edited by hand, copied to and pasted from a spreadsheet."""

from mrs_simulator.rqt_plugin.map.arranging import ARRANGEMENTS
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, Qt, QTimer, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QKeySequence
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QAbstractItemView,
    QAction,
    QApplication,
    QComboBox,
    QHeaderView,
    QMenu,
    QStyle,
    QStyledItemDelegate,
    QTableView,
)
from mrs_simulator.rqt_plugin.team.model import DECIMALS, KIND, kind_name
from mrs_simulator.rqt_plugin.widgets.guard import guarded

ROWS_SHOWN = 4  # at least
REST = 100  # [ms] after the last change of a robot until the columns are fitted to it


class KindDelegate(QStyledItemDelegate):
    """Chooses a robot's kind from a list."""

    @guarded
    def createEditor(self, parent, option, index):
        """Return a list of the kinds."""
        editor = QComboBox(parent)
        for name in index.model().kind_choices:
            editor.addItem(kind_name(name), name)
        return editor

    @guarded
    def setEditorData(self, editor, index):
        """Show the robot's kind."""
        editor.setCurrentIndex(editor.findData(index.data(Qt.EditRole)))

    @guarded
    def setModelData(self, editor, model, index):
        """Take the chosen kind."""
        model.setData(index, editor.currentData())


@guarded
class TeamTable(QTableView):
    """The table, with copying and pasting of robots."""

    pasted = Signal(str)
    arranged = Signal(object)  # a function of poses (k, 3), for the robots selected
    follow_asked = Signal(int)  # the number of a robot

    def __init__(self, model, parent=None):
        super().__init__(parent)
        self.setModel(model)
        self.setItemDelegateForColumn(KIND, KindDelegate(self))
        self.setSelectionBehavior(QAbstractItemView.SelectRows)
        self.verticalHeader().hide()
        self.setTabKeyNavigation(True)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.Fixed)
        header.setMinimumSectionSize(1)
        header.setSectionsClickable(False)
        header.setHighlightSections(False)
        height = int(1.5 * self.fontMetrics().height())
        self.verticalHeader().setDefaultSectionSize(height)
        self.setMinimumHeight(int((ROWS_SHOWN + 1) * height))
        self._add_action("Copy", QKeySequence.Copy, self.copy)
        self._paste = self._add_action("Paste", QKeySequence.Paste, self.paste)
        self._rest = QTimer(self, interval=REST, singleShot=True, timeout=self.fit_columns)
        model.dataChanged.connect(self._on_data)
        for changed in (model.modelReset, model.rowsInserted, model.rowsRemoved):
            changed.connect(self.fit_columns)

    def _on_data(self, *_):
        self._rest.start()

    @guarded
    def fit_columns(self, *_):
        """Make each column as wide as its texts need, and leave out decimals where that is too much."""
        found, level = widths(self, self.model(), self.viewport().width())
        self.model().set_decimals(level)
        for column, width in enumerate(found):
            self.setColumnWidth(column, width)

    def resizeEvent(self, event):
        """Let the columns share the new width."""
        super().resizeEvent(event)
        self.fit_columns()

    def changeEvent(self, event):
        """Let the columns follow the font."""
        super().changeEvent(event)
        if event.type() in (QEvent.FontChange, QEvent.StyleChange):
            self._rest.start()

    def _add_action(self, text, keys, function):
        # The keys are shown here and handled below: as a shortcut they might clash with rqt's.
        text = "{}\t{}".format(text, QKeySequence(keys).toString(QKeySequence.NativeText))
        action = QAction(text, self, triggered=function)
        self.addAction(action)
        return action

    def focusNextPrevChild(self, forward):
        """Go to the next cell, from the last, or back from the first, to the next widget."""
        model = self.model()
        ends = model.index(model.rowCount() - 1, model.columnCount() - 1), model.index(0, 0)
        current = self.currentIndex()
        leaves = not current.isValid() or current == ends[0 if forward else 1]
        self.setTabKeyNavigation(not leaves)
        try:
            return super().focusNextPrevChild(forward)
        finally:
            self.setTabKeyNavigation(True)

    def contextMenuEvent(self, event):
        """Offer what can be done with the robots selected."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        self.menu = menu = QMenu(self)
        menu.setAttribute(Qt.WA_DeleteOnClose)
        menu.addActions(self.actions())
        menu.addAction("Select all\tCtrl+A").triggered.connect(self.selectAll)
        follow = menu.addAction("Follow in the 3D view")
        follow.setEnabled(len(rows) == 1)
        follow.triggered.connect(guarded(lambda *_: self.follow_asked.emit(rows[0] + 1)))
        menu.addSeparator()
        for text, least, arrangement in ARRANGEMENTS:
            entry = menu.addAction(text)
            entry.setEnabled(len(rows) >= least and self.model().editable)
            entry.triggered.connect(guarded(lambda *_, do=arrangement: self.arranged.emit(do)))
        menu.popup(event.globalPos())

    def keyPressEvent(self, event):
        """Copy and paste."""
        if event.matches(QKeySequence.Copy):
            self.copy()
        elif event.matches(QKeySequence.Paste):
            self.paste()
        else:
            super().keyPressEvent(event)

    @guarded
    def copy(self, *_):
        """Put the selected robots into the clipboard."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        if rows:
            QApplication.clipboard().setText(self.model().copied(rows))

    @guarded
    def paste(self, *_):
        """Hand on what the clipboard holds."""
        if self.model().editable:
            self.pasted.emit(QApplication.clipboard().text())

    def set_editable(self, editable):
        """Allow changes or not."""
        self.model().editable = editable
        self._paste.setEnabled(editable)
        self.setEditTriggers(
            QAbstractItemView.DoubleClicked
            | QAbstractItemView.EditKeyPressed
            | QAbstractItemView.AnyKeyPressed
            if editable
            else QAbstractItemView.NoEditTriggers
        )


def widths(table, model, room):
    """Return the columns' widths [px] and the number, among ``DECIMALS``, of the decimals to show.

    All of ``room`` [px] is used.  Where numbers in full need more, decimals are left out; where even
    that is too much, the columns are wider than ``room`` together.
    """
    for level in range(len(DECIMALS)):
        needed = [_needed(table, model, column, level) for column in range(model.columnCount())]
        if sum(needed) <= room:
            break
    spare, columns = max(0, room - sum(needed)), len(needed)
    shares = [spare // columns + (place < spare % columns) for place in range(columns)]
    return [width + share for width, share in zip(needed, shares)], level


def _needed(table, model, column, level):
    """Return what the header and the texts of a column need [px]."""
    style, metrics = table.style(), table.fontMetrics()
    margin = 2 * (style.pixelMetric(QStyle.PM_FocusFrameHMargin) + 1) + 1
    icon = margin + style.pixelMetric(QStyle.PM_SmallIconSize) if column == 0 else 0
    texts = model.longest_texts(column, level)
    header = model.headerData(column, Qt.Horizontal).splitlines()
    inner = max([metrics.horizontalAdvance(text) for text in texts] + [0]) + icon
    titles = max(table.horizontalHeader().fontMetrics().horizontalAdvance(t) for t in header)
    return int(max(inner + margin, titles + 2 * style.pixelMetric(QStyle.PM_HeaderMargin)) + 1)
