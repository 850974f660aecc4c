"""The verdict on a run as a table."""

from mrs_simulator.core.claims import QUESTIONS
from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QHBoxLayout, QPushButton, QVBoxLayout, QWidget
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic
from mrs_simulator.verdict.requirements.results import known_bound, line_of
from mrs_simulator.verdict.verdict import FAILED, NOT_JUDGED, PASSED, SELF_CONSISTENT, outcome_of

HEADERS = (
    ("about", "Theorem, law, robots: which question the row answers; or a requirement"),
    ("claim", "A claim of the protocol's theory, or a check of every run"),
    ("result", "Whether prediction and measurement agree"),
    ("predicted", "The value that theory gives"),
    ("measured", "The value in this run; of a requirement its robustness"),
    ("difference", "Measured minus predicted"),
    ("tolerance", "The largest difference that passes"),
    ("remark", "How they are compared, or why the claim does not apply"),
)
CLAIM, RESULT = 1, 2  # columns
WORDS = {True: "passed", False: "FAILED", None: "not judged"}
TINTS = {True: "good", False: "error", None: "aside"}
ORDER = (False, True, None)  # of the rows about the same
# Tinted as results are.
OUTCOMES = {PASSED: True, SELF_CONSISTENT: None, FAILED: False, NOT_JUDGED: None}
TITLES = {
    PASSED: "passed",
    SELF_CONSISTENT: "self-consistent",
    FAILED: "FAILED",
    NOT_JUDGED: "not judged",
}
BEFORE = "No verdict yet. Saving a run compares it with its protocol's theory."
MOST_GAPS = 12
REQUIREMENT = "requirement"


class VerdictPanel(QWidget):
    """Shows what ``verdict.json`` holds."""

    row_chosen = Signal(object)  # a check of the verdict, or a requirement stated as one

    def __init__(self, parent=None):
        super().__init__(parent)
        self.verdict = None  # as in verdict.json, None before the first
        self._title, self._more = MessageLabel("aside"), MessageLabel("aside")
        self._table = ResultsTable(HEADERS, widest=len(HEADERS) - 1)
        self._copy = QPushButton("Copy")
        self._copy.setToolTip("Copy the table, or the rows selected, for a spreadsheet")
        self._copy.clicked.connect(self._table.copy)
        page, line = QWidget(), QHBoxLayout()
        layout = QVBoxLayout(page)
        layout.setContentsMargins(4, 4, 4, 4)
        line.addWidget(self._title, 1)
        line.addWidget(self._copy)
        layout.addLayout(line)
        layout.addWidget(self._table, 1)
        layout.addWidget(self._more)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(scrolled(page))
        self._copy.setEnabled(False)
        self._title.say(BEFORE)
        self._checks = []  # of the rows
        for chosen in (self._table.cellClicked, self._table.cellActivated):
            chosen.connect(self._on_row)

    @guarded
    def _on_row(self, row, _):
        self.row_chosen.emit(self._checks[row])

    def set_verdict(self, verdict):
        """Show ``verdict``, a mapping as in ``verdict.json``."""
        self.verdict = verdict
        wanted = map(_as_check, verdict.get("requirements", []))
        checks = sorted([*verdict["checks"], *wanted], key=_place)
        counts = [sum(check["passed"] is passed for check in checks) for passed in WORDS]
        parts = ["{} {}".format(n, word.lower()) for n, word in zip(counts, WORDS.values()) if n]
        outcome = outcome_of(verdict)
        title = "{}: {}".format(verdict["title"] or "run", TITLES[outcome])
        reason = [verdict["reason"]] if verdict.get("reason") else []
        self._title.say(
            "{} ({})".format(title, ", ".join(reason + parts)), TINTS[OUTCOMES[outcome]]
        )
        self._checks = checks
        self._table.set_rows(
            [_cells(check) for check in checks],
            [_tip(check) for check in checks],
            [(row, RESULT, TINTS[check["passed"]]) for row, check in enumerate(checks)],
        )
        self._more.say(_more(verdict))
        self._copy.setEnabled(True)

    def clear(self):
        """Show no verdict: the run that it was on is gone."""
        self.verdict = None
        self._title.say(BEFORE, "aside")
        self._checks = []
        self._table.set_rows([])
        self._more.say("")
        self._copy.setEnabled(False)

    def title(self):
        """Return the line above the table."""
        return self._title.message

    def click(self, claim):
        """Choose the row of ``claim``, as a click does."""
        names = [check["name"] for check in self._checks]
        self._on_row(names.index(claim), CLAIM)

    def row(self, claim):
        """Return the texts of the row of ``claim``, by column."""
        names = [name for name, _ in HEADERS]
        for row in range(self._table.rowCount()):
            if self._table.text(row, CLAIM) == symbolic(claim):
                return {name: self._table.text(row, c) for c, name in enumerate(names)}
        raise KeyError(claim)


def _as_check(result):
    """Return what became of a requirement as a check is stated, its robustness as the measured value.

    ``time`` [s] of the run, and ``member``, say when and by whom it was decided.
    """
    numbers = dict.fromkeys(("predicted", "difference", "tolerance"))
    robustness = known_bound(result)
    check = {"question": REQUIREMENT, "name": result["name"], "passed": result["met"], **numbers}
    check.update(time=result.get("time"), member=result.get("member"))
    return {**check, "measured": robustness, "note": line_of(result)}


def _place(check):
    """Return what rows are sorted by: their question, then their result."""
    return (*QUESTIONS, REQUIREMENT).index(check["question"]), ORDER.index(check["passed"])


def _cells(check):
    numbers = [shown(check[key]) for key in ("predicted", "measured", "difference", "tolerance")]
    name = symbolic(check["name"])
    return [check["question"], name, WORDS[check["passed"]], *numbers, symbolic(check["note"])]


def _tip(check):
    """Return the conditions under which the claim was judged, in words."""
    lines = [check["name"]]
    if check["passed"] is None:
        return "\n".join(lines + [check["note"]])
    if check["tolerance"] is not None:
        bound = check["note"] if check["note"] in ("at most", "at least") else "equal to"
        text = "required: {} {}, within {}"
        lines.append(text.format(bound, shown(check["predicted"]), shown(check["tolerance"])))
        lines.append("measured: {}".format(shown(check["measured"])))
    if check["note"] not in ("", "at most", "at least"):
        lines.append(check["note"])
    return "\n".join(lines)


def _more(verdict):
    """Return further facts of the verdict, a line each."""
    lines = []
    if verdict["final_gaps"]:
        gaps = ", ".join("{:.4f}".format(gap) for gap in verdict["final_gaps"][:MOST_GAPS])
        more = ", ..." if len(verdict["final_gaps"]) > MOST_GAPS else ""
        lines.append("final gaps [m]: {}{}".format(gaps, more))
    if verdict["min_distance"] is not None:
        lines.append("closest approach of two centres: {:.3f} m".format(verdict["min_distance"]))
    return "\n".join(lines + ["warning: " + warning for warning in verdict["warnings"]])


def shown(value):
    """Return a value of the verdict as a person reads it."""
    if value is None:
        return "\u2013"
    if not isinstance(value, float):
        return str(value)
    return "{:.4g}".format(value)
