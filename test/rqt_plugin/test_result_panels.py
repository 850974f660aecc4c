"""The verdict and the preflight as tables: words beside colours, copied to a spreadsheet, both themes."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import shown
from gui_tables import judged_row, rows_of
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QColor, QPalette
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractSlider, QApplication

from mrs_simulator.rqt_plugin.run.preflight_panel import PreflightPanel
from mrs_simulator.rqt_plugin.run.preflight_run import Finding, PreflightRun, real_arguments
from mrs_simulator.rqt_plugin.verdict.panel import VerdictPanel
from mrs_simulator.rqt_plugin.widgets.symbols import printed_name, symbolic
from mrs_simulator.scenario.requirements import RESULT_KEYS
from mrs_simulator.state.state_table import StateTable

APP = QApplication.instance() or QApplication([])
SIZE = 800, 300  # [px]
pytestmark = pytest.mark.usefixtures("no_hidden_errors")
PLACE = Finding("robot3", "stands in place", "at (1, 2, 0), 0.6 m", "at most 0.3 m and rad", True)
SILENT = Finding("robot2", "publishes", "never received on /robot2/odom", "")


def check(name, predicted, measured, passed, note="", tolerance=0.1):
    difference = None if measured is None or tolerance is None else measured - predicted
    keys = (
        "name",
        "predicted",
        "measured",
        "tolerance",
        "passed",
        "difference",
        "note",
        "question",
    )
    values = (name, predicted, measured, tolerance, passed, difference, note, "theorem")
    return dict(zip(keys, values))


VERDICT = {
    "title": "Four robots",
    "passed": False,
    "checks": [
        check("connected", "holds", "holds", True, tolerance=None),
        check("gap [m]", 2.0, 2.05, True),
        check("speed [m/s]", 0.5, 0.75, False, "at most"),
        check("rate [1/s]", 0.25, None, None, "does not apply: a robot was at its speed limit"),
    ],
    "final_gaps": [2.05, 1.99],
    "min_distance": 1.25,
    "warnings": ["k T is above 2"],
}


@pytest.fixture
def verdict():
    widget = shown(VerdictPanel(), *SIZE)
    widget.set_verdict(VERDICT)
    yield widget
    widget.close()
    widget.deleteLater()


@pytest.fixture
def panel():
    widget = shown(PreflightPanel(), *SIZE)
    widget.asked = []
    widget.start_asked.connect(lambda: widget.asked.append(True))
    yield widget
    widget.close()
    widget.deleteLater()


def test_requirements_are_rows_behind_the_checks(verdict):
    kept = {**dict.fromkeys(RESULT_KEYS), "name": "apart", "met": True, "low": 0.5, "high": 0.5}
    kept.update(note="", margin=0.5, unit="m", time=1.0, member="robot1 and robot2", decided_at=9.0)
    kept.update(predicate="distance > 1 m", formula="always distance > 1 m")
    broken = {**kept, "name": "slow", "met": False, "low": -0.2, "high": -0.2, "margin": -0.2}
    verdict.set_verdict({**VERDICT, "requirements": [kept, broken]})
    row = judged_row(verdict, "apart [m]")
    assert (row["about"], row["result"], row["margin"]) == ("requirement", "passed", "0.5")
    assert "by robot1 and robot2 at 1.00 s" in row["remark"]
    assert judged_row(verdict, "slow [m]")["result"] == "FAILED"
    assert "4 passed" not in verdict.title.message and "3 passed, 2 failed" in verdict.title.message


def test_the_first_row_that_failed_is_in_view_however_many_passed(verdict):
    table, passed = (
        verdict.table,
        [check("gap {} [m]".format(n), 2.0, 2.0, True) for n in range(60)],
    )
    wrong = dict(check("collisions", 0, 1, False), question="robots")
    verdict.set_verdict({**VERDICT, "checks": [*passed, wrong, dict(wrong, name="ended")]})
    (row,) = (row for row in range(table.rowCount()) if table.text(row, 1) == "collisions")
    area = table.viewport().rect()
    assert row == 60 and area.contains(table.visualItemRect(table.item(row, 1)).center())
    verdict.resize(SIZE[0], SIZE[1] // 2)
    APP.processEvents()
    assert table.viewport().rect().contains(table.visualItemRect(table.item(60, 1)).center())
    table.verticalScrollBar().triggerAction(QAbstractSlider.SliderToMinimum)
    verdict.resize(*SIZE)
    APP.processEvents()
    assert area.contains(table.visualItemRect(table.item(0, 1)).center())
    verdict.set_verdict({**VERDICT, "checks": passed})
    assert area.contains(table.visualItemRect(table.item(0, 1)).center())


def test_a_run_that_goes_on_shows_how_claims_stand_and_with_what_margin(verdict):
    headlines = []
    verdict.headline_changed.connect(headlines.append)
    stands = ("on course", "failing", "not yet decidable", "on course")
    rows = [
        {**each, "standing": stand, "margin": 0.25 * (stand == "on course") - 0.1}
        for each, stand in zip(VERDICT["checks"], stands)
    ]
    verdict.set_standings(rows, 12.3, 25.0)
    said = "2 on course, 1 failing, 1 not yet decidable"
    assert verdict.title.message == "Running, 12.3 of 25 s: " + said
    assert verdict.verdict is None and headlines == ["1 failing"]
    row = judged_row(verdict, "rate [1/s]")
    assert (row["result"], row["margin"]) == ("on course", "0.15")
    verdict.set_verdict(VERDICT)
    assert verdict.verdict is not None and judged_row(verdict, "gap [m]")["margin"] == "0.05"
    verdict.clear()
    assert headlines[1:] == ["FAILED", ""]


def test_a_verdict_says_in_words_what_passed_and_what_does_not_apply(verdict):
    assert verdict.title.message == "Four robots: FAILED (2 passed, 1 failed, 1 not judged)"
    gap, speed, rate = (
        judged_row(verdict, name) for name in ("gap [m]", "speed [m/s]", "rate [1/s]")
    )
    assert (gap["predicted"], gap["measured"], gap["difference"]) == ("2", "2.05", "0.05")
    assert [row["result"] for row in (gap, speed, rate)] == ["passed", "FAILED", "not judged"]
    assert rate["measured"] == rate["difference"] == "\u2013"
    assert (
        "speed limit" in rate["remark"] and judged_row(verdict, "connected")["measured"] == "holds"
    )
    tip = verdict.table.item(0, 0).toolTip()
    assert "at most 0.5, within 0.1" in tip and "measured: 0.75" in tip
    assert "k T is above 2" in verdict.more.message and "1.250 m" in verdict.more.message


def test_results_are_tinted_as_the_theme_allows(verdict):
    def tints():
        return [verdict.table.item(row, 2).foreground().color().lightness() for row in range(4)]

    assert max(tints()) < 128
    palette = QPalette(verdict.palette())
    palette.setColor(QPalette.Window, QColor("#202020"))
    palette.setColor(QPalette.WindowText, QColor("white"))
    verdict.setPalette(palette)
    APP.processEvents()
    assert min(tints()) > 128


def test_a_verdict_is_copied_for_a_spreadsheet(verdict):
    QTest.mouseClick(verdict.copy, Qt.LeftButton)
    lines = QApplication.clipboard().text().split("\n")
    assert lines[0].split("\t")[:4] == ["about", "claim", "result", "margin"]
    assert len(lines) == 5 and lines[1].split("\t")[2] == "FAILED"
    where = verdict.table.visualItemRect(
        verdict.table.findItems("gap [m]", Qt.MatchExactly)[0]
    ).center()
    QTest.mouseClick(verdict.table.viewport(), Qt.LeftButton, pos=where)
    QTest.keyClick(verdict.table, Qt.Key_C, Qt.ControlModifier)
    copied = QApplication.clipboard().text().split("\n")
    assert len(copied) == 2 and copied[1].startswith("theorem\tgap [m]\tpassed\t0.05\t2\t2.05\t")


def test_the_table_uses_the_width_that_there_is(verdict):
    table = verdict.table
    for width in (500, 900):
        verdict.resize(width, 300)
        APP.processEvents()
        used = sum(table.columnWidth(column) for column in range(table.columnCount()))
        assert used >= table.viewport().width()


def test_robots_that_are_ready(panel):
    panel.set_running(False)
    assert panel.title.message.startswith("Checking the robots")
    panel.set_findings([], 12, "", False)
    assert panel.title.message == "All robots ready: 12 checks passed."
    assert rows_of(panel) == [] and not panel.start_button.isVisible()


def test_a_start_in_spite_of_what_was_found_wants_two_deliberate_clicks(panel):
    panel.set_findings([PLACE], 11, "refused", True)
    assert rows_of(panel) == [
        ["robot3", "stands in place", "at (1, 2, 0), 0.6 m", "at most 0.3 m and rad"]
    ]
    QTest.mouseClick(panel.start_button, Qt.LeftButton)
    assert panel.asked == []
    QTest.mouseClick(panel.judged, Qt.LeftButton, pos=QPoint(8, panel.judged.height() // 2))
    QTest.mouseClick(panel.start_button, Qt.LeftButton)
    assert panel.asked == [True] and not panel.start_button.isVisible()
    # What was judged once is not judged for the next time.
    panel.set_findings([PLACE], 11, "refused", True)
    assert panel.start_button.isVisible() and not panel.start_button.isEnabled()
    panel.set_findings([PLACE, SILENT], 10, "refused", False)
    assert not panel.start_button.isVisible() and "Not started: 2 findings" in panel.title.message
    QTest.mouseClick(panel.copy, Qt.LeftButton)
    assert QApplication.clipboard().text().count("\n") == 2


class Connection:
    """What a check needs of the connection; the work is done at once, and never."""

    do = staticmethod(lambda name, work: None)
    odometry_topics = staticmethod(dict)
    is_fresh = staticmethod(lambda name: False)


@pytest.mark.parametrize(
    "accepted, findings, outcome",
    [
        (None, [], ""),
        (None, [PLACE], ""),
        ([], [], "started"),
        ([], [PLACE], "refused"),
        ([PLACE], [PLACE], "started"),
        ([PLACE], [PLACE, PLACE._replace(robot="robot4")], "refused"),
        ([PLACE, SILENT], [PLACE, SILENT], "refused"),
    ],
)
def test_only_what_was_found_before_and_can_be_judged_is_started_with(accepted, findings, outcome):
    run = PreflightRun(Connection(), None)
    keys = None if accepted is None else frozenset(finding.key for finding in accepted)
    run.begin("scenario.yaml", accepted=keys)
    assert run.running and run.starting == (accepted is not None)
    assert run.ended(True, (9, findings)) == (outcome == "started")
    assert run.outcome == outcome and not run.running


def test_a_check_that_fails_or_is_called_off_starts_nothing():
    run = PreflightRun(Connection(), None)
    run.begin("scenario.yaml", accepted=frozenset())
    assert not run.ended(False, "Traceback: no such file")
    assert run.outcome == "refused" and not run.may_judge()
    assert run.findings[0].what == "the check itself" and "no such file" in run.findings[0].value
    run.begin("scenario.yaml", accepted=frozenset())
    assert run.cancel() and not run.ended(True, (9, []))
    assert run.outcome == "" and not run.cancel()


@pytest.mark.parametrize("simulated", [True, False])
def test_a_stage_that_is_received_late_still_says_which_robots_are_real(tmp_path, simulated):
    class Late(Connection):
        do = staticmethod(lambda name, work: answers.append(work()))
        registered = {"stage"}
        has_simulated_time = staticmethod(lambda: simulated)
        controller_arguments = staticmethod(lambda topics: [])
        snapshot = staticmethod(lambda: snapshot)
        asked = 0

        def is_fresh(self, name):
            self.asked += 1
            return self.asked > 3

    class Program:
        directory = str(tmp_path)

        def run(self, name, program, *arguments, limit):
            given.append(arguments)
            (tmp_path / "preflight.json").write_text("[]")
            return 0, ""

    answers, given = [], []
    snapshot = StateTable(0.0, (1, 2), pose=np.zeros((2, 3)), real=np.array([False, True]))
    connection = Late()
    run = PreflightRun(connection, Program())
    run.begin("scenario.yaml", accepted=frozenset())
    assert answers == [(True, (0, []))] and "_real:=[2]" in given[0]
    assert run.ended(*answers[0]) and run.real == ["_real:=[2]"]
    connection.asked = -9  # it is silent for a while
    assert real_arguments(connection) == ["_real:=[2]"]
    connection.registered, connection.asked = set(), -9
    assert real_arguments(connection) == []
    run.begin("scenario.yaml", accepted=frozenset())
    assert [found.what for found in answers[1][1][1]] == ["clock"] * simulated


@pytest.mark.parametrize(
    "plain, printed",
    [
        ("lambda_2 >= 0", "\u03bb\u2082 \u2265 0"),
        ("eps above 0", "\u03b5 above 0"),
        ("p^T L p over its bound [-]", "p\u1d40 L p over its bound [-]"),
        ("|1 - gain Tc lambda(L_ff)| < 1", "|1 - gain Tc \u03bb(L_ff)| < 1"),
        ("m/s^0.5", "m/\u221as"),
        ("a_ij in m/s^2", "a\u1d62\u2c7c in m/s\u00b2"),
        ("the pipe of my_law.py, robot_1 and max_speed", None),
        ("adversaries <= F", "adversaries \u2264 F"),
    ],
)
def test_symbols_are_mathematics(plain, printed):
    assert symbolic(plain) == (printed or plain)


def test_rows_are_by_question_and_of_each_failed_ones_come_first():
    QApplication.instance() or QApplication([])
    panel = VerdictPanel()
    names = {"good": True, "none": None, "bad": False, "better": True, "hit": False, "off": None}
    about = dict(dict.fromkeys(names, "theorem"), hit="robots", off="law")
    empty = dict.fromkeys(("predicted", "measured", "difference", "tolerance"))
    checks = [
        dict(empty, name=name, passed=passed, note="", question=about[name])
        for name, passed in names.items()
    ]
    panel.set_verdict(
        dict(title="", passed=False, checks=checks, final_gaps=None, min_distance=None, warnings=[])
    )
    rows = [tuple(panel.table.text(row, column) for column in (0, 1)) for row in range(6)]
    order = ["bad", "good", "better", "none"]
    assert rows == [("theorem", name) for name in order] + [("law", "off"), ("robots", "hit")]


@pytest.mark.parametrize(
    "name, printed",
    [
        ("k", "<i>k</i>"),
        ("c1", "<i>c</i><sub>1</sub>"),
        ("beta", "<i>\u03b2</i>"),
        ("leader_vx", "leader <i>v</i><sub><i>x</i></sub>"),
        ("centre_y", "centre <i>y</i>"),
        ("swing_period", "swing period"),
        ("loss", "loss"),
        ("_", "_"),
    ],
)
def test_names_of_parameters_are_printed_as_mathematics_or_words(name, printed):
    assert printed_name(name) == printed
