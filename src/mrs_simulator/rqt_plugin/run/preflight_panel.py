"""Findings of the preflight, and the button to start in spite of those that a person may judge."""

from mrs_simulator.core.fields import counted
from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QCheckBox, QPushButton, QWidget
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel

HEADERS = (
    ("robot", "Which robot; team: all of them together"),
    ("what", "What was checked"),
    ("found", "The value found"),
    ("required", "The value required"),
)
FOUND = 2  # column
BEFORE = (
    "Not checked yet. Check robots tests whether each robot reports its pose, is in place and far enough "
    "from the others, and whether the predicted paths keep their distance."
)
JUDGE = "I see all robots, and the emergency stop is at hand"
START_TIP = "Check again, and start the controller unless there are new findings"


@guarded
class PreflightPanel(QWidget):
    """Findings in a table; ``start_asked`` when a person starts in spite of them."""

    start_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self.title = MessageLabel("aside")
        self.table = ResultsTable(HEADERS, widest=FOUND)
        self.copy = QPushButton("Copy", clicked=self.table.copy)
        self.copy.setToolTip("Copy the table, or the rows selected, for a spreadsheet")
        self.judged = QCheckBox(JUDGE)
        self.start_button = QPushButton("Start anyway", toolTip=START_TIP, clicked=self._on_start)
        self.judged.toggled.connect(self.start_button.setEnabled)
        first, last = row_of((self.title, 1), self.copy), row_of(self.judged, self.start_button, 1)
        column_of(first, (self.table, 1), last, owner=self, margins=4)
        self.title.say(BEFORE)
        self._offer(False)

    def _on_start(self, *_):
        self._offer(False)
        self.start_asked.emit()

    def _offer(self, offered):
        """Offer the start in spite of what was found, or not; it is judged anew each time."""
        self.judged.setChecked(False)
        self.start_button.setEnabled(False)
        for widget in (self.judged, self.start_button):
            widget.setVisible(offered)

    def set_running(self, starting):
        """Show that a check is under way; ``starting``: the controller starts after it."""
        after = ", the controller starts if they are ready" if starting else ""
        self.title.say("Checking the robots{} ...".format(after), "aside")
        self.table.set_rows([])
        self.copy.setEnabled(False)
        self._offer(False)

    def set_findings(self, findings, passed, outcome, may_judge):
        """Show the ``Finding``s of a check in which so many others ``passed``.

        ``outcome`` for the controller: "started", "refused" or ""; ``may_judge``: a person may
        overrule a refusal.
        """
        rows = [[f.robot or "team", f.what, f.value, f.wanted] for f in findings]
        self.table.set_rows(rows, tints=[(row, 1, "error") for row in range(len(rows))])
        self.copy.setEnabled(bool(rows))
        text = _title(len(findings), passed, outcome, may_judge)
        self.title.say(text, "error" if findings else "good")
        self._offer(may_judge)


def _title(found, passed, outcome, may_judge):
    started = " The controller starts." if outcome == "started" else ""
    if not found:
        return "All robots ready: {} checks passed.{}".format(passed, started)
    text = "{}, {} passed.".format(counted(found, "finding"), counted(passed, "check"))
    if outcome != "refused":
        return text + started
    if may_judge:
        return "Not started: {} Resolve this and start again, or confirm by sight:".format(text)
    return "Not started: {} Resolve this, then start again.".format(text)
