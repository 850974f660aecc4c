"""The team as a table: a robot's number, initial pose and kind in each row."""

import math
import os

import numpy as np

from mrs_simulator.rqt_plugin.qt.QtCore import QAbstractTableModel, QModelIndex, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QBrush, QColor, QPalette
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication
from mrs_simulator.rqt_plugin.team.spreadsheet import HEADERS, read_number
from mrs_simulator.rqt_plugin.widgets.colours import shade
from mrs_simulator.rqt_plugin.widgets.guard import guarded

# The unit on a line of its own leaves room for all columns.
TITLES = ("robot", "x\n[m]", "y\n[m]", "\u03b8\n[deg]", "kind")
TIPS = (
    "Robot's number, 1 for the first",
    "Initial position along x, wheel-axle centre [m]",
    "Initial position along y, wheel-axle centre [m]",
    "Initial heading [deg], counter-clockwise from the x axis",
    "Kind of robot",
)
KIND = 4  # column
OVERLAP = QColor(220, 40, 40, 90)
NO_PAIRS = (np.empty(0, dtype=int), np.empty(0, dtype=int))
MOST_NAMED = 6  # robots in one tooltip
# Most decimals that are shown of x, y and heading: where there is room, and where there is less.
DECIMALS = ((4, 4, 2), (3, 3, 1), (2, 2, 0), (1, 1, 0))
DIGITS = 6  # most that are shown, unless all of them stand before the point


class TeamModel(QAbstractTableModel):
    """Poses and kinds of a team, one robot per row; signals ``accepted`` and ``refused`` after edits."""

    accepted = Signal()
    refused = Signal(str)

    def __init__(self, kind_choices, parent=None):
        """``kind_choices``: the kinds that a robot may be of."""
        super().__init__(parent)
        self.kind_choices = tuple(kind_choices)
        self.poses, self.kinds = np.zeros((0, 3)), ()
        self._pairs, self.overlapping = NO_PAIRS, frozenset()
        self.editable, self.real = True, frozenset()
        self._level = 0  # among DECIMALS

    def set_decimals(self, level):
        """Show ``DECIMALS[level]`` decimals."""
        if level != self._level:
            self._level = level
            if len(self.poses):
                last = self.index(len(self.poses) - 1, KIND - 1)
                self.dataChanged.emit(self.index(0, 1), last)

    def longest_texts(self, column, level):
        """Return the texts of a column that may be the widest, with the decimals of ``level``."""
        if column == KIND:
            return {kind_name(kind) for kind in self.kinds}
        rows = range(len(self.poses))
        if column == 0:
            rows = sorted({row - 1 for row in self.real} | set(rows[-1:]))
            return [self._text(row, 0, exact=False) for row in rows]
        texts = {self._number(row, column, level) for row in rows}
        longest = max((len(text) for text in texts), default=0)
        return [text for text in texts if len(text) == longest]

    def set_real(self, numbers):
        """Mark the robots ``numbers``, a set, as real ones."""
        if numbers != self.real and len(self.poses):
            self.real = frozenset(numbers)
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.poses) - 1, 0))

    def set_team(self, poses, kinds, pairs):
        """Show ``poses`` (n, 3) [m, m, rad]; ``pairs``: rows (m,), (m,) of robots that overlap."""
        before = len(self.poses)
        # A kind in a file of its own is offered from then on.
        self.kind_choices = tuple(dict.fromkeys(self.kind_choices + tuple(kinds)))
        if (len(set(kinds)) > 1) != self.is_mixed():  # the kinds' column comes or goes
            self.beginResetModel()
            self.poses, self.kinds = poses, tuple(kinds)
            self._take_pairs(pairs)
            self.endResetModel()
            return
        if len(poses) > before:
            self.beginInsertRows(QModelIndex(), before, len(poses) - 1)
        elif len(poses) < before:
            self.beginRemoveRows(QModelIndex(), len(poses), before - 1)
        self.poses, self.kinds = poses, tuple(kinds)
        self._take_pairs(pairs)
        if len(poses) > before:
            self.endInsertRows()
        elif len(poses) < before:
            self.endRemoveRows()
        if len(poses):
            last = self.index(len(poses) - 1, self.columnCount() - 1)
            self.dataChanged.emit(self.index(0, 0), last)

    def _take_pairs(self, pairs):
        self._pairs, self.overlapping = pairs, frozenset(np.unique(np.concatenate(pairs)).tolist())

    def is_mixed(self):
        """Return whether the team has robots of several kinds."""
        return len(set(self.kinds)) > 1

    def rowCount(self, parent=None):
        """Return the number of robots."""
        return 0 if parent is not None and parent.isValid() else len(self.poses)

    def columnCount(self, parent=None):
        """Return 4, or 5 where the robots are of several kinds."""
        if parent is not None and parent.isValid():
            return 0
        return KIND + self.is_mixed()

    @guarded
    def headerData(self, section, orientation, role=Qt.DisplayRole):
        """Return a column's name."""
        if orientation == Qt.Horizontal and role in (Qt.DisplayRole, Qt.ToolTipRole):
            return TITLES[section] if role == Qt.DisplayRole else TIPS[section]
        return None

    def flags(self, index):
        """Return what may be done with a cell."""
        flags = Qt.ItemIsSelectable | Qt.ItemIsEnabled
        return flags | Qt.ItemIsEditable if self.editable and index.column() else flags

    @guarded
    def data(self, index, role=Qt.DisplayRole):
        """Return a cell's text or style."""
        row, column = index.row(), index.column()
        if role in (Qt.DisplayRole, Qt.EditRole):
            return self._text(row, column, exact=role == Qt.EditRole)
        if role == Qt.DecorationRole and column == 0:
            ground = QApplication.palette().color(QPalette.Base)
            return shade(row + 1, len(self.poses), ground)
        if role == Qt.TextAlignmentRole and column < KIND:
            return int(Qt.AlignVCenter | Qt.AlignRight)
        if role == Qt.BackgroundRole and row in self.overlapping:
            return QBrush(OVERLAP)
        return self._tooltip(row) if role == Qt.ToolTipRole else None

    def _text(self, row, column, exact):
        if column == 0:
            return str(row + 1) + (" real" if row + 1 in self.real and not exact else "")
        if column == KIND:
            return self.kinds[row] if exact else kind_name(self.kinds[row])
        if exact:
            return "{:.12g}".format(self._value(row, column))
        return self._number(row, column, self._level)

    def _value(self, row, column):
        value = float(self.poses[row, column - 1])
        return math.degrees(value) if column == 3 else value

    def _number(self, row, column, level):
        return short_number(self._value(row, column), DECIMALS[level][column - 1])

    def _tooltip(self, row):
        """Return a robot's tooltip, None for none."""
        lines = [kind_name(self.kinds[row])] if self.is_mixed() else []
        lines += ["robot{} is a real robot".format(row + 1)] if row + 1 in self.real else []
        lines += [self._overlap(row)] if row in self.overlapping else []
        return "\n".join(lines) or None

    def _overlap(self, row):
        first, second = self._pairs
        rows = sorted(first[second == row].tolist() + second[first == row].tolist())
        others = ["robot{}".format(other + 1) for other in rows]
        more = len(others) - MOST_NAMED
        others = others[:MOST_NAMED] + (["{} more".format(more)] if more > 0 else [])
        return "robot{} overlaps {}".format(row + 1, " and ".join(others))

    @guarded
    def setData(self, index, value, role=Qt.EditRole):
        """Apply a value that was typed or chosen; keep the old one if it is not valid."""
        row, column = index.row(), index.column()
        if role != Qt.EditRole or str(value) == self._text(row, column, exact=True):
            return False
        if column == KIND:
            self.kinds = self.kinds[:row] + (str(value),) + self.kinds[row + 1 :]
        else:
            try:
                number = read_number(value, "robot{}, {}".format(row + 1, HEADERS[column]))
            except ValueError as error:
                self.refused.emit(str(error))
                return False
            self.poses[row, column - 1] = math.radians(number) if column == 3 else number
        self.dataChanged.emit(index, index)
        self.accepted.emit()
        return True

    def copied(self, rows):
        """Return the robots of ``rows`` as a spreadsheet takes them."""
        return "\n".join(
            "\t".join(self._text(row, column, exact=True) for column in (1, 2, 3)) for row in rows
        )


def kind_name(kind):
    """Return the name of a kind for display; for a kind's file, the file's name."""
    return os.path.basename(kind)


def short_number(value, decimals):
    """Return ``value`` with at most that many decimals, fewer where it is large."""
    if not math.isfinite(value):
        return str(value)
    before = len(str(int(abs(value))))
    text = "{:.{}f}".format(value, max(0, min(decimals, DIGITS - before)))
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text
