"""Widths of the table's columns: wide enough for what stands in them, as long as there is room."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QStyle
from mrs_simulator.rqt_plugin.team.model import DECIMALS


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
