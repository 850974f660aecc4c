"""A read-only table that can be copied to a spreadsheet."""

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QSize, Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QKeySequence
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
)
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import tint

ROWS = 3  # [-] that there is room for, if anyhow
WIDEST = 0.3  # [-] of the table's width that a column takes at most by itself


@guarded
class ResultsTable(QTableWidget):
    """Rows of texts; a cell may be tinted, and a row has a tooltip."""

    def __init__(self, headers, widest, parent=None):
        """``headers``: ``(name, tooltip)`` of each column; the column ``widest`` takes the room left."""
        super().__init__(0, len(headers), parent)
        self._headers, self._widest = tuple(name for name, _ in headers), widest
        self._tints, self._in_view = [], None  # the row that stays in view until somebody scrolls
        self.verticalScrollBar().actionTriggered.connect(self._on_scroll)
        self.setHorizontalHeaderLabels(self._headers)
        for column, (_, tip) in enumerate(headers):
            self.horizontalHeaderItem(column).setToolTip(tip)
        header = self.horizontalHeader()
        header.setDefaultAlignment(Qt.AlignLeft | Qt.AlignVCenter)
        header.setSectionResizeMode(QHeaderView.Interactive)
        header.setHighlightSections(False)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(int(1.5 * self.fontMetrics().height()))
        self.setEditTriggers(QAbstractItemView.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectRows)
        self.setTabKeyNavigation(False)
        self.setAlternatingRowColors(True)
        self.setWordWrap(False)

    def sizeHint(self):
        """Ask for a few rows: where there is less room than for all, the table alone scrolls."""
        rows = ROWS * self.verticalHeader().defaultSectionSize()
        around = (
            self.horizontalHeader().sizeHint().height()
            + self.horizontalScrollBar().sizeHint().height()
        )
        return QSize(super().sizeHint().width(), rows + around)

    def set_rows(self, rows, tips=(), tints=()):
        """Show ``rows`` of texts; ``tips`` of the rows; ``tints``: ``(row, column, kind of note)``."""
        self.setRowCount(len(rows))
        self._in_view = None
        tips = list(tips) or ["\n".join(filter(None, cells)) for cells in rows]
        for row, (cells, tip) in enumerate(zip(rows, tips)):
            for column, text in enumerate(cells):
                item = QTableWidgetItem(text)
                item.setToolTip(tip)
                self.setItem(row, column, item)
        self._tints = list(tints)
        self._paint_tints()
        self._fit_columns()

    def keep_in_view(self, row):
        """Scroll to ``row``, and again where the table is laid out anew, until somebody scrolls."""
        self._in_view = row
        self._scroll()

    def _on_scroll(self, *_):
        self._in_view = None

    def _scroll(self):
        if self._in_view is not None:
            self.doItemsLayout()  # else rows set just now are not within reach
            self.scrollTo(self.model().index(self._in_view, 0))

    def change_texts(self, rows, tips):
        """Show other texts in the same cells, whose columns grow only where a text needs it."""
        for row, (cells, tip) in enumerate(zip(rows, tips)):
            for column, text in enumerate(cells):
                item = self.item(row, column)
                item.setText(text)
                item.setToolTip(tip)
        wanted = [c for c in range(self.columnCount()) if c != self._widest]
        most = self._most()
        if any(min(most, self.sizeHintForColumn(c)) > self.columnWidth(c) for c in wanted):
            self._fit_columns()

    def _most(self):
        """Return the width [px] that a column takes at most by itself."""
        return max(100, int(WIDEST * self.viewport().width()))

    def _paint_tints(self):
        for row, column, kind in self._tints:
            item, font = self.item(row, column), self.font()
            font.setBold(True)
            item.setFont(font)
            item.setForeground(QColor(tint(kind, self.palette())))

    def _fit_columns(self):
        room = self.viewport().width()
        most = self._most()
        for column in range(self.columnCount()):
            self.resizeColumnToContents(column)
            self.setColumnWidth(column, min(most, self.columnWidth(column)))
        left = room - sum(self.columnWidth(column) for column in range(self.columnCount()))
        if left > 0:
            self.setColumnWidth(self._widest, self.columnWidth(self._widest) + left)

    def text(self, row, column):
        """Return a cell's text."""
        return self.item(row, column).text()

    def as_tsv(self, rows=None):
        """Return the header and ``rows``, all by default, as lines of cells with tabs between them."""
        rows = range(self.rowCount()) if rows is None else rows
        lines = [self._headers]
        lines += [[self.text(row, c) for c in range(self.columnCount())] for row in rows]
        return "\n".join("\t".join(line) for line in lines)

    @guarded
    def copy(self, *_):
        """Put the rows that are selected, or all of them, into the clipboard."""
        chosen = sorted({index.row() for index in self.selectedIndexes()})
        QApplication.clipboard().setText(self.as_tsv(chosen or None))

    def keyPressEvent(self, event):
        """Copy."""
        if event.matches(QKeySequence.Copy):
            self.copy()
        else:
            super().keyPressEvent(event)

    def changeEvent(self, event):
        """Take the colours that suit the new theme."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange:
            self._paint_tints()

    def resizeEvent(self, event):
        """Let the columns share the new width."""
        super().resizeEvent(event)
        self._fit_columns()
        self._scroll()
