"""The sweep map: its axes and cells, and the panel with a real sweep in the background."""

import csv
import json
import math
import os

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from unittest.mock import MagicMock

from gui_fixtures import alive, quiet_study, shown, wait_shown
from PyQt5.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PyQt5.QtGui import QDropEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLabel

from mrs_simulator.protocols.making import make_control
from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin.sweep.axes import AxisTexts, key_of, read_texts, swept_keys
from mrs_simulator.rqt_plugin.sweep.cells import (
    GROWTH,
    MARGIN,
    SETTLING,
    SweepCells,
    read_news,
    scale_for,
)
from mrs_simulator.rqt_plugin.sweep.legend import formula
from mrs_simulator.rqt_plugin.widgets.form_beside import FormBeside
from mrs_simulator.rqt_plugin.window import sweep as sweep_control
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.results.report import write_scenario
from mrs_simulator.study.run import sweep

NONE = Qt.NoModifier
GAIN, RATE = "control.parameters.gain", "control.rate"


@pytest.fixture(scope="module")
def scenario():
    return load_scenario(scenario_path("consensus"))._replace(duration=3.0)


@pytest.fixture(scope="module")
def keys(scenario):
    control = make_control(scenario)
    return swept_keys(scenario, control.PARAMETERS, control.parameters)


# Axes, without Qt


def test_the_protocol_s_parameters_come_first_with_a_range_about_their_values(keys):
    names = [each.name for each in keys]
    assert names[0] == "gain" and names[-1] == "l"
    assert {"control.rate", "mismatch.delay", "links.loss", "seed", "duration"} <= set(names)
    assert keys[0].path == GAIN and keys[0].suggested() == (0.25, 1.0)
    assert key_of("control.rate", keys).suggested() == (25.0, 100.0)
    assert key_of("seed", keys).suggested() == (0, 5)
    assert key_of("links.loss", keys).suggested() == (0.0, 1.0)  # no more than is allowed
    assert key_of("mismatch.speed", keys).suggested() == (0.5, 2.0)
    assert key_of(GAIN, keys) is keys[0]


def test_a_range_becomes_the_word_and_the_values_of_the_command(keys):
    read = read_texts(AxisTexts("gain", "0.5", "2", 4), keys)
    assert read == (GAIN + "=0.5..2.0/4", [0.5, 1.0, 1.5, 2.0], {})
    assert read_texts(AxisTexts("seed", "0", "5", 3), keys)[:2] == ("seed=0,2,4", [0, 2, 4])
    read = read_texts(AxisTexts("sensors[0].noise", "1", "2", 2), keys)
    assert read == ("sensors[0].noise=1.0..2.0/2", [1.0, 2.0], {})


@pytest.mark.parametrize(
    "texts, field, told",
    [
        (("gain", "0,5", "2", 4), "low", "'0,5': wanted a number, with a point in place"),
        (("gain", "0.5", "", 4), "high", "'': wanted a number"),
        (("gain", "2", "0.5", 4), "high", "0.5: wanted more than 2"),
        (("gain", "1", "inf", 4), "high", "gain = inf: wanted a number"),
        (("seed", "1.5", "3", 4), "low", "'1.5': wanted a whole number"),
        (("control.rate", "0.01", "3", 4), "low", "rate = 0.01: wanted a number from 0.1 to 1000"),
        (("gain", "1", "2", 51), "count", "51: wanted from 2 to 50 cells"),
        (("what now", "1", "2", 4), "name", "'what now': wanted a key's path"),
        (("other.key", "1", "nan", 4), "high", "nan: wanted a finite number"),
    ],
)
def test_what_is_wrong_with_a_range_is_told_by_its_field(keys, texts, field, told):
    word, values, errors = read_texts(AxisTexts(*texts), keys)
    assert word is None and values is None
    assert list(errors) == [field] and errors[field].startswith(told)


# Cells, without Qt


def check(name, difference, tolerance, passed):
    about = {"name": name, "predicted": 0.0, "note": ""}
    return {**about, "difference": difference, "tolerance": tolerance, "passed": passed}


def plan_of(holds, lines=()):
    runs = [
        {"run": "{}{}".format(x, y), "values": {"x": x, "y": y}, "holds": holds[j][i], "why": ""}
        for i, x in enumerate((1.0, 2.0, 4.0))
        for j, y in enumerate((0, 1))
    ]
    boundary = {"name": "a = b" if lines else "", "lines": list(lines)}
    return {
        "keys": ["x", "y"],
        "units": {"x": "s"},
        "values": {},
        "runs": runs,
        "boundary": boundary,
    }


def cells_of(holds, lines=()):
    cells = SweepCells(("x", "y"), {"x": [1.0, 2.0, 4.0], "y": [0, 1]})
    cells.take_plan(plan_of(holds, lines))
    return cells


HOLDS = [[True, True, False], [True, None, False]]


def test_cells_know_their_runs_their_margins_and_whether_theory_is_right():
    cells = cells_of(HOLDS)
    assert cells.cells[0, 2].run == "4.00" and cells.cells[1, 0].run == "1.01"
    assert cells.known() == [] and cells.quantities() == [MARGIN]
    requirement = {"name": "apart", "unit": "m", "met": False, "low": -0.5, "high": -0.2}
    good = {"passed": True, "outcome": "passed", "ended": "complete", "settle_time": 3.5}
    good["checks"] = [check("rate", 0.01, 0.05, True), check("limit", 0.04, 0.05, True)]
    bad = {"passed": False, "outcome": "failed", "ended": "complete", "growth_rate": 0.5}
    bad.update(checks=[check("limit", 0.2, 0.05, False)], requirements=[requirement])
    ended = {"passed": False, "outcome": "failed", "ended": "its law raised", "checks": []}
    cells.take_verdicts({"1.00": good, "4.00": bad, "2.00": ended, "of another sweep": bad})
    margin = cells.measured(MARGIN)
    assert margin[0] == pytest.approx([0.2, -1.0, -3.0])  # 1 - 0.04/0.05; 1 - 0.2/0.05
    assert np.isnan(margin[1]).all()
    assert cells.cells[0, 0].worst == "limit" and cells.cells[0, 1].worst == "its law raised"
    names = MARGIN, SETTLING, "robustness of apart [m]", GROWTH
    assert set(cells.quantities()) == set(names)
    assert cells.measured(names[2])[0, 2] == -0.2 and cells.measured(SETTLING)[0, 0] == 3.5
    assert [cell.agrees for cell in cells.cells[0]] == [True, False, True]
    assert cells.summary() == "3 of 6 cells, 1 passed; as theory has it: 2 of 3"
    cells.take_verdicts({"2.01": good})
    assert cells.cells[1, 1].agrees is None  # no theorem applies


def test_without_a_line_theory_s_boundary_goes_between_cells():
    sides = {tuple(map(tuple, side.tolist())) for side in cells_of(HOLDS).lines}
    assert sides == {
        ((1.5, -0.5), (1.5, 0.5)),  # between the second and the third column of the first row
        ((0.5, 0.5), (0.5, 1.5)),  # between the first and the second of the second row
        ((0.5, 0.5), (1.5, 0.5)),  # between the rows of the second column
    }


def test_a_line_and_the_mouse_find_their_cells_where_values_are_not_even():
    cells = cells_of(HOLDS, [[[1.0, 0.0], [3.0, 0.5], [5.0, 2.0], [0.5, -1.0]]])
    assert cells.boundary == "a = b"
    expected = [[0.0, 0.0], [1.5, 0.5], [2.5, 2.0], [-0.5, -1.0]]
    np.testing.assert_allclose(cells.lines[0], expected)
    assert cells.at(2.4, -0.4) == (0, 2) and cells.at(2.6, 0.0) is None
    assert cells.at(-0.4, 1.4) == (1, 0) and cells.at(0.0, 1.6) is None


def test_colours_are_centred_where_zero_decides():
    values = np.array([[0.5, -7.0], [np.nan, 0.9]])
    scale = scale_for(MARGIN, values)
    assert scale.norm(0.0) == 0.5 and scale.beyond == (True, False)
    scale = scale_for("robustness of apart [m]", values)
    assert scale.norm(0.0) == 0.5 and scale.norm.vmax == 7.0 and scale.beyond == (False, False)
    scale = scale_for(SETTLING, np.array([[1.0, 3.0]]))
    assert scale.colours == "viridis" and (scale.norm.vmin, scale.norm.vmax) == (1.0, 3.0)
    assert scale_for(MARGIN, np.full((2, 2), math.nan)) is None


def test_what_just_holds_is_seen_beside_what_just_fails():
    holds, fails = scale_for(MARGIN, np.array([[0.5, -7.0]])).shades(np.array([1e-6, -1e-6]))
    assert holds[2] - holds[0] > 50 and fails[0] - fails[2] > 50  # blue and red, not white


def test_news_are_what_ended_since_with_why_a_run_has_no_verdict(tmp_path):
    assert read_news(str(tmp_path), set(), False) == (None, {})
    (tmp_path / "sweep.json").write_text(json.dumps(plan_of(HOLDS)))
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "verdict.json").write_text('{"passed": true, "checks": []}')
    with open(str(tmp_path / "sweep.csv"), "w") as file:
        table = csv.writer(file)
        table.writerows([["run", "ended"], ["one", "complete"], ["two", "its process died"]])
    plan, verdicts = read_news(str(tmp_path), set(), False)
    assert len(plan["runs"]) == 6 and verdicts["one"]["passed"] is True
    assert verdicts["two"]["ended"] == "its process died"
    assert list(read_news(str(tmp_path), {"one"}, True)[1]) == ["two"]
    assert read_news(str(tmp_path), {"one"}, True)[0] is None


def test_a_formula_is_printed_with_letters_and_indices():
    printed = formula(r"$\kappa T_c = 2/\lambda_{\max}$")
    assert printed == "<i>\u03ba</i> T<sub>c</sub> = 2/<i>\u03bb</i><sub>max</sub>"


# The panel, with real sweeps


@pytest.fixture
def application():
    return QApplication.instance() or QApplication([])


@pytest.fixture
def study(application, no_hidden_errors, forked_programs, scenario, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(sweep_control, "EVERY", 0.05)  # [s]
    processes = LocalProcesses(MagicMock(**{"take.return_value": []}))
    widget = quiet_study(scenario, processes)
    widget.study.shelf.home = str(tmp_path / "shelf")
    shown(widget, 1366, 768)
    widget.bring_forward("Sweep")
    widget.sweep_control.follow()
    yield widget
    widget.close_study()
    processes.wait_closed()
    widget.close()
    application.processEvents()


def until(widget, condition):
    """Wait until the ``condition`` holds, as the window's timers would."""

    def follow():
        widget.sweep_control.follow()
        widget.shelf_control.follow()
        widget.opened.follow()

    def said():
        panel, processes = widget.sweep, widget.study.processes
        return processes.output("sweep"), panel.note.message, widget.messages.toPlainText()

    wait_shown(condition, follow=follow, said=said)


def test_a_form_stands_above_its_content_where_there_is_little_room(application):
    form, content = QLabel("\n".join("a line of a form" for _ in range(20))), QLabel("content")
    both = FormBeside(form, content, 10)
    shown(both, 1000, 300)
    assert content.mapTo(both, content.pos()).x() > form.width() // 2
    both.resize(300, 200)
    QTest.qWait(0)
    top = content.mapTo(both, QPoint(0, 0))
    assert top.x() == 0 and top.y() >= form.sizeHint().height()  # by the whole form, which scrolls
    both.close()


def fill(form, name, low, high, count):
    """Type an axis as a user does."""
    form.name.lineEdit().selectAll()
    QTest.keyClicks(form.name.lineEdit(), name)
    QTest.keyClick(form.name.lineEdit(), Qt.Key_Return)
    for field, text in ((form.low, low), (form.high, high)):
        field.selectAll()
        QTest.keyClicks(field, text)
    form.count.setValue(count)


def press(button):
    QTest.mouseClick(button, Qt.LeftButton)


def click_cell(widget, row, column):
    place = widget.sweep.map.cell_box(row, column).center().toPoint()
    QTest.mouseClick(widget.sweep.map, Qt.LeftButton, NONE, place)


@pytest.fixture
def earlier(scenario, tmp_path, monkeypatch):
    """A sweep as the command line makes it, without plan and figures, in a folder that is not watched."""
    monkeypatch.setattr(sweep, "can_draw", lambda: False)
    path, out = write_scenario(scenario, str(tmp_path)), str(tmp_path / "made" / "before")
    runs = sweep.make_runs(path, [(GAIN, [0.5, 4.0]), (RATE, [4.0, 20.0])])
    sweep.run_sweep(runs, out, jobs=1)
    return out


def test_an_earlier_sweep_is_dropped_and_its_runs_are_below_it_on_the_list(study, earlier):
    data, runs = QMimeData(), study.shelf.list
    data.setUrls([QUrl.fromLocalFile(earlier)])
    place = QPointF(5, 5)
    event = QDropEvent(place, Qt.CopyAction, data, Qt.LeftButton, NONE)
    study.start.eventFilter(study, event)  # Qt itself sends none outside a drag
    until(study, lambda: study.sweep_control.cells and study.sweep_control.cells.are_known())
    cells = study.sweep_control.cells.cells
    assert [[cell.outcome for cell in row] for row in cells] == [
        ["passed", "failed"],
        ["passed", "passed"],
    ]
    assert study.results_tabs.currentWidget() is study.sweep
    click_cell(study, 0, 1)
    until(study, lambda: study.opened.run is not None)
    assert study.opened.run.path == os.path.join(earlier, cells[0, 1].run)
    study.bring_forward("Runs")
    until(study, lambda: runs.current_path() == earlier)
    assert [entry.name for entry in runs.runs.entries] == [study.scenario.title]
    runs.setFocus()
    for key, count in ((Qt.Key_Right, 5), (Qt.Key_Left, 1), (Qt.Key_Space, 5)):
        QTest.keyClick(runs, key)
        until(study, lambda count=count: len(runs.runs.entries) == count)
    assert runs.runs.entries[1].name == "gain 0.5, rate 4" and runs.runs.entries[1].within
    QTest.keyClick(runs, Qt.Key_Down)
    QTest.keyClick(runs, Qt.Key_Return)
    wanted = os.path.join(earlier, cells[0, 0].run)
    until(study, lambda: study.opened.run is not None and study.opened.run.path == wanted)
    QTest.keyClick(runs, Qt.Key_Left)  # to the sweep
    assert runs.current_path() == earlier and not runs.runs.compared
    study.sweep_control.open(earlier)
    until(study, lambda: study.sweep_control.cells and study.sweep_control.cells.are_known())
    press(study.sweep.start)  # another one, with the form as it stands
    study.sweep_control.open(earlier)
    assert "cancel the sweep that runs" in study.banners.text("error")
    press(study.sweep.cancel)
    until(study, lambda: study.sweep.start.isEnabled())


def test_cancel_ends_the_sweep_and_its_workers_and_keeps_what_has_ended(study):
    panel = study.sweep
    fill(panel.axes[0], "gain", "0.1", "1", 15)
    fill(panel.axes[1], "control.rate", "20", "100", 15)
    press(panel.start)
    cells, process = study.sweep_control.cells, study.study.processes.jobs["sweep"]
    until(study, lambda: cells.known())
    assert len(alive(process.pid)) > 1  # with a worker
    press(panel.cancel)
    assert not panel.cancel.isEnabled()
    until(study, lambda: panel.start.isEnabled())
    assert process.poll() is not None
    until(study, lambda: not alive(process.pid))
    assert 0 < len(cells.known()) < 225
    assert "sweep cancelled" in study.messages.toPlainText()


def test_closing_the_window_ends_the_sweep(study):
    panel = study.sweep
    fill(panel.axes[0], "gain", "0.1", "1", 15)
    fill(panel.axes[1], "control.rate", "20", "100", 15)
    press(panel.start)
    process = study.study.processes.jobs["sweep"]
    study.close_study()
    study.study.processes.wait_closed()
    assert process.poll() is not None


def test_bad_input_is_told_beside_its_field_and_nothing_starts(study):
    panel = study.sweep
    fill(panel.axes[0], "gain", "2", "1", 3)
    fill(panel.axes[1], "gain", "0.5", "1,5", 3)
    press(panel.start)
    first, second = (axis.notes for axis in panel.axes)
    assert first["high"].message == "1: wanted more than 2" and not first["low"].message
    assert "with a point in place of the comma" in second["high"].message
    assert second["name"].message == "wanted another parameter than along x"
    assert study.sweep_control.cells is None and panel.start.isEnabled()
    fill(panel.axes[0], "gain", "1", "2", 3)
    fill(panel.axes[1], "control.speeed", "1", "2", 2)
    press(panel.start)
    until(study, lambda: panel.start.isEnabled())
    assert second["name"].message.startswith("control: unknown 'speeed' (known: ")
    assert not any(note.message for note in first.values())
    assert study.sweep_control.cells is None
