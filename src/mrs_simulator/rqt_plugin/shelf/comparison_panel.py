"""Tables of what differs between the runs compared: parameters, and claims with their results."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication, QPushButton, QSplitter, QWidget
from mrs_simulator.rqt_plugin.shelf.comparison import claim_rows, parameter_rows
from mrs_simulator.rqt_plugin.verdict.panel import TINTS, WORDS, shown
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic

BEFORE = "Tick runs on the list Runs: they are laid over the run shown, and compared with it here."
SAME = "The scenarios are the same."
OF_CLAIMS = (
    ("predicted", "The value that theory gives for the run"),
    ("measured", "The value in the run; of a requirement its robustness"),
    ("result", "Whether they agree"),
)
LEAST = 8  # [lines of text] of height of the tables, which scroll where there is less room
NOTHING = "\u2013"


@guarded
class ComparisonPanel(QWidget):
    """Shows ``ComparedRun``s beside each other."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.title, self._copy = MessageLabel("aside"), QPushButton("Copy", clicked=self._on_copy)
        self._copy.setToolTip("Copy both tables for a spreadsheet")
        self._tables, self.parameters, self.claims = QSplitter(Qt.Horizontal), None, None
        whole = page_of(row_of((self.title, 1), self._copy), (self._tables, 1))
        self._tables.setMinimumHeight(LEAST * self.fontMetrics().height())
        column_of(scrolled(whole), owner=self, margins=0)
        self.compare([])

    def compare(self, runs):
        """Show ``runs``, the one shown first; fewer than two: nothing."""
        for table in (self.parameters, self.claims):
            if table is not None:
                table.setParent(None)
                table.deleteLater()
        self.parameters = self.claims = None
        self._copy.setVisible(len(runs) > 1)
        self._tables.setVisible(len(runs) > 1)
        if len(runs) < 2:
            self.title.say(BEFORE, "aside")
            return
        rows = parameter_rows(runs)
        names = " | ".join(run.name for run in runs)
        self.title.say(names if rows else "{}. {}".format(names, SAME), "aside")
        self._show_parameters(runs, rows)
        self._show_claims(runs)
        self._tables.setSizes([100, 300])

    def _show_parameters(self, runs, rows):
        heads = [("differs", "A key of the scenario whose values differ")]
        heads += [(run.name, "Its value in {}".format(run.name)) for run in runs]
        self.parameters = ResultsTable(heads, widest=0)
        self._tables.addWidget(self.parameters)
        self.parameters.set_rows(rows)

    def _show_claims(self, runs):
        heads = [("claim", "A claim of theory, a check of every run, or a requirement")]
        for run in runs:
            heads += [("{}, {}".format(run.name, what), tip) for what, tip in OF_CLAIMS]
        self.claims = ResultsTable(heads, widest=0)
        lines = ["\n".join(head.rsplit(", ", 1)) for head, _ in heads]
        self.claims.setHorizontalHeaderLabels(lines)
        self._tables.addWidget(self.claims)
        rows, tints = [], []
        for row, (name, checks) in enumerate(claim_rows(runs)):
            cells = [symbolic(name)]
            for place, check in enumerate(checks):
                cells += _cells(check)
                kind = "aside" if check is None else TINTS[check["passed"]]
                tints.append((row, 3 * place + 3, kind))
            rows.append(cells)
        self.claims.set_rows(rows, tints=tints)

    def _on_copy(self, *_):
        tables = self.parameters, self.claims
        QApplication.clipboard().setText("\n\n".join(table.as_tsv() for table in tables))


def _cells(check):
    if check is None:
        return [NOTHING] * 3
    return [shown(check["predicted"]), shown(check["measured"]), WORDS[check["passed"]]]
