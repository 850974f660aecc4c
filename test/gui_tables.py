"""What the tables of results show, as texts."""

from mrs_simulator.rqt_plugin.verdict.panel import CLAIM, HEADERS
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic


def rows_of(panel):
    """Return the rows of texts of the table in ``panel``."""
    table = panel.table
    columns = range(table.columnCount())
    return [[table.text(row, column) for column in columns] for row in range(table.rowCount())]


def judged_row(verdict, claim):
    """Return the texts of the row of ``claim`` in the panel ``verdict``, by the names of its columns."""
    (row,) = (row for row in rows_of(verdict) if row[CLAIM] == symbolic(claim))
    return dict(zip((name for name, _ in HEADERS), row))
