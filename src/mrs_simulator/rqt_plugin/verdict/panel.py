"""The verdict on a run as a table, and how its claims stand while it goes on."""

from mrs_simulator.core.claims import QUESTIONS
from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QPushButton, QWidget
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic
from mrs_simulator.verdict.requirements.results import known_bound, line_of
from mrs_simulator.verdict.standing import STANDS
from mrs_simulator.verdict.verdict import (
    FAILED,
    NOT_JUDGED,
    PASSED,
    SELF_CONSISTENT,
    margin_of,
    outcome_of,
)

HEADERS = (
    ("about", "Theorem, law, robots: which question the row answers; or a requirement"),
    ("claim", "A claim of the protocol's theory, or a check of every run"),
    ("result", "Whether prediction and measurement agree"),
    ("margin", "What is to spare, of a requirement its robustness; less than 0 where it is missed"),
    ("predicted", "The value that theory gives"),
    ("measured", "The value in this run"),
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
BEFORE = "No verdict yet: how claims stand is shown here while a run goes on."
LAST = "last run"  # on the tab, of a verdict that is marked
MOST_GAPS = 12
REQUIREMENT = "requirement"


@guarded
class VerdictPanel(QWidget):
    """Shows what ``verdict.json`` holds, or how claims stand in a run that goes on."""

    headline_changed = Signal(str)  # the outcome in a word or two, "" without one
    row_chosen = Signal(object)  # a check of the verdict, or a requirement stated as one

    def __init__(self, parent=None):
        super().__init__(parent)
        self.verdict = None  # as in verdict.json, None before the first
        self.title, self.more = MessageLabel("aside"), MessageLabel("aside")
        self.table = ResultsTable(HEADERS, widest=len(HEADERS) - 1)
        self.copy = QPushButton("Copy", clicked=self.table.copy, enabled=False)
        self.copy.setToolTip("Copy the table, or the rows selected, for a spreadsheet")
        whole = page_of(row_of((self.title, 1), self.copy), (self.table, 1), self.more)
        column_of(scrolled(whole), owner=self, margins=0)
        self.title.say(BEFORE)
        self._checks = []  # of the rows
        self._remark, self._said, self._headline = "", (BEFORE, "aside"), ""
        for chosen in (self.table.cellClicked, self.table.cellActivated):
            chosen.connect(self._on_row)

    def _on_row(self, row, _):
        self.row_chosen.emit(self._checks[row])

    def set_standings(self, rows, time, duration):
        """Show how claims stand, ``rows`` as of ``standing.standings``, ``time`` [s] into a run."""
        self.verdict = None
        rows = sorted(rows, key=_place)
        counts = [(sum(row["standing"] == stand for row in rows), stand) for stand in STANDS]
        said = ", ".join("{} {}".format(*each) for each in counts if each[0])
        said = said.replace("does not apply", "not judged")
        failing = counts[1][0]
        title = "Running, {:.1f} of {:g} s: {}".format(time, duration, said)
        self._say(title, "error" if failing else "aside")
        self._show_rows(rows, [row["standing"] for row in rows])
        self.more.say("")
        self._head("{} failing".format(failing) if failing else "on course")

    def mark(self, remark):
        """Say with a verdict that it is of the ``remark``, "" where it is of the run shown."""
        if remark != self._remark:
            self._remark = remark
            self._say(*self._said)
            self._head(self._headline)

    def _say(self, title, kind):
        """Show the line above the table."""
        self._said = title, kind
        marked = self._remark if self.verdict is not None else ""
        text = "{}: {}".format(marked[0].upper() + marked[1:], title) if marked else title
        self.title.say(text, "aside" if marked else kind)

    def _head(self, outcome):
        self._headline = outcome
        marked = self._remark and outcome and self.verdict is not None
        self.headline_changed.emit("{} ({})".format(outcome, LAST) if marked else outcome)

    def show_trouble(self, text):
        """Show in place of a verdict why there is none."""
        self.clear()
        self._say(text, "error")

    def _show_rows(self, checks, words):
        """Show ``checks`` with their results in ``words``; rows that stand as before keep their place."""
        cells = [_cells(check, word) for check, word in zip(checks, words)]
        tips, before = [_tip(check) for check in checks], [_kept(check) for check in self._checks]
        self._checks = checks
        self.copy.setEnabled(True)
        if before == [_kept(check) for check in checks]:
            self.table.change_texts(cells, tips)
            return
        tints = [(row, RESULT, TINTS[check["passed"]]) for row, check in enumerate(checks)]
        self.table.set_rows(cells, tips, tints)

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
        self._say("{} ({})".format(title, ", ".join(reason + parts)), TINTS[OUTCOMES[outcome]])
        self._show_rows(checks, [WORDS[check["passed"]] for check in checks])
        failed = [row for row, check in enumerate(checks) if check["passed"] is False]
        self.table.keep_in_view(failed[0] if failed else 0)
        self.more.say(_more(verdict))
        self._head(TITLES[outcome])

    def clear(self):
        """Show no verdict: the run that it was on is gone."""
        self.verdict = None
        self._head("")
        self._say(BEFORE, "aside")
        self._checks = []
        self.table.set_rows([])
        self.more.say("")
        self.copy.setEnabled(False)


def _as_check(result):
    """Return what became of a requirement as a check is stated, its robustness as the margin, with a unit.

    ``time`` [s] of the run, and ``member``, say when and by whom it was decided.
    """
    numbers = dict.fromkeys(("predicted", "measured", "difference", "tolerance"))
    check = {"question": REQUIREMENT, "name": result["name"], "passed": result["met"], **numbers}
    check.update(time=result.get("time"), member=result.get("member"), unit=result.get("unit"))
    return {**check, "margin": known_bound(result), "note": line_of(result)}


def _place(check):
    """Return what rows are sorted by: their question, then their result."""
    return (*QUESTIONS, REQUIREMENT).index(check["question"]), ORDER.index(check["passed"])


def _kept(check):
    """Return what a row has to share with the one before it for its cells to stay."""
    return check["question"], check["name"], check["passed"]


def _cells(check, word):
    numbers = [shown(check[key]) for key in ("predicted", "measured", "difference", "tolerance")]
    margin = shown(check["margin"] if "margin" in check else margin_of(check))
    name = "{} [{}]" if check.get("unit") else "{}"  # names of claims have theirs in them
    name = symbolic(name.format(check["name"], check.get("unit")))
    return [check["question"], name, word, margin, *numbers, symbolic(check["note"])]


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
    # Whose remarks want more room than there is beside the numbers.
    lines = [line_of(each) for each in verdict.get("requirements", []) if each["met"] is False]
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
