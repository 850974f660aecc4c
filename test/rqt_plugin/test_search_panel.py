"""The searches' panel: what may vary, what was found, and real searches in the background."""

import json
import math
import os

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from unittest.mock import MagicMock

from gui_fixtures import MEETING, SEARCHED, alive, quiet_study, shown, wait_shown
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.search.inputs import (
    read_share,
    suggested,
    with_search,
    without_search,
)
from mrs_simulator.rqt_plugin.search.results import ASSURE, BREAK, MARGINS, result_of
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_yaml


def scenario(more=""):
    return scenario_from_yaml(MEETING + more, "scenario")


# Without Qt


def test_what_may_vary_is_the_scenario_s_or_the_starts_and_reads_back():
    wanted = "poses: {within: [-0.5, -0.75, 1.5, 1.25], apart: 0.3}\n"  # at least 2 m wide
    assert suggested(scenario()) == wanted
    text = suggested(scenario(SEARCHED))
    wanted = "poses: {within: [-3, -3, 3, 3], apart: 1}\ncontrol.parameters.gain: [0.2, 0.8]\n"
    assert text == wanted
    for own in (scenario(), scenario(SEARCHED)):
        searched = with_search(own, suggested(own)).search
        assert searched == with_search(own, suggested(own._replace(search=searched))).search
    assert with_search(scenario(), text).search == scenario(SEARCHED).search
    turned = SEARCHED.replace("apart: 1", "apart: 1, headings: [0, 1]")
    assert "headings: [0, 1]" in suggested(scenario(turned))
    assert without_search(scenario(SEARCHED)).search == scenario().search


@pytest.mark.parametrize(
    "text, told",
    [
        ("", "what may vary: wanted lines such as"),
        ("poses", "what may vary: wanted lines such as"),
        (
            "poses: {within: [1, 1, 0, 0]}",
            "what may vary: poses.within: [1.0, 1.0, 0.0, 0.0], wanted",
        ),
        ("control.rate: [1", "what may vary, line 1: not valid YAML"),
        ("control.rate: [2, 1]", "what may vary.control.rate: [2, 1], wanted two numbers"),
        ("mismach.delay: [0, 1]", "what may vary: unknown 'mismach'; did you mean 'mismatch'?"),
        (
            "control.parameters.gian: [1, 2]",
            "what may vary.control.parameters: unknown 'gian'; did you mean 'gain'?",
        ),
    ],
)
def test_what_cannot_vary_is_told(text, told):
    with pytest.raises(ScenarioError) as raised:
        with_search(scenario(), text, ("gain", "l"))
    assert str(raised.value).startswith(told)


def test_a_parameter_of_the_law_needs_no_path():
    lines = "gain: [1, 2]\nmismatch.delay: [0, 0.4]\nseed: [1, 9]"
    found = with_search(scenario(), lines, ("gain", "l")).search
    assert [each.key for each in found.ranges] == [
        "control.parameters.gain",
        "mismatch.delay",
        "seed",
    ]


@pytest.mark.parametrize("text", ["0", "1", "0,9", "nan", ""])
def test_a_share_lies_between_0_and_1(text):
    assert read_share("0.9") == 0.9
    with pytest.raises(ValueError, match="wanted a number between 0 and 1"):
        read_share(text)


def test_results_are_what_the_commands_have_written(tmp_path):
    out = str(tmp_path)
    printed = "search: 20 runs so far\nnot found: none of 20 runs\n"
    assert result_of(BREAK, out, printed) == ("not found: none of 20 runs", "", 0.0, "", "")
    (tmp_path / "failed.yaml").write_text("")
    assert result_of(ASSURE, out, "not shown")[:4] == ("not shown", "", 0.0, out + "/failed.yaml")
    (tmp_path / "counterexample.yaml").write_text("")
    (tmp_path / "search.json").write_text(json.dumps({"worst": {"decided_at": 1.5}}))
    (tmp_path / "run").mkdir()
    assert result_of(BREAK, out, "found").run == ""  # it was not finished
    (tmp_path / "run" / "run.csv").write_text("")
    found = result_of(BREAK, out, "found")
    assert (found.run, found.moment) == (out + "/run", 1.5)
    assert found.scenario == out + "/counterexample.yaml"
    with pytest.raises(OSError):
        result_of(MARGINS, out, "")


# The panel, with real searches


@pytest.fixture
def application():
    return QApplication.instance() or QApplication([])


@pytest.fixture
def study(application, no_hidden_errors, forked_programs, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    processes = LocalProcesses(MagicMock(**{"take.return_value": []}))
    widget = quiet_study(scenario(SEARCHED), processes)
    widget.study.shelf.home = str(tmp_path / "shelf")
    yield shown(widget, 1366, 768)
    widget.close_study()
    processes.wait_closed()
    widget.close()
    application.processEvents()


def follow(widget):
    widget.search_control.follow()
    widget.opened.follow()
    widget.shelf_control.follow()


def until(widget, condition):
    """Wait until the ``condition`` holds, as the window's timers would."""

    def said():
        panel, processes = widget.search, widget.study.processes
        return processes.output("search"), panel.title.message, widget.messages.toPlainText()

    wait_shown(condition, follow=lambda: follow(widget), said=said)


def open_tab(widget):
    tabs = widget.results_tabs
    place = tabs.tabBar().tabRect(tabs.indexOf(widget.search)).center()
    QTest.mouseClick(tabs.tabBar(), Qt.LeftButton, Qt.NoModifier, place)
    follow(widget)


def press(button):
    QTest.mouseClick(button, Qt.LeftButton)


def ended(widget):
    return widget.search.buttons[BREAK].isEnabled()


def test_margins_are_shown_as_a_table_and_a_figure(study):
    panel = study.search
    open_tab(study)
    panel.vary.setPlainText("nonsense, which margins do not ask for")
    press(panel.buttons[MARGINS])
    assert panel.bar.maximum() == 0  # how many runs it takes is not known
    until(study, lambda: ended(study))
    text = panel.text.toPlainText()
    assert "mismatch.delay [s] 0 to 1" in text and text.splitlines()[0].strip() == "near"
    assert panel.shown_figure.isVisible() and panel.figure.pixmap().width() > 100
    assert not panel.show_run.isVisible() and not panel.load.isVisible()


def test_a_run_that_fails_is_what_assure_has_to_show(study):
    panel = study.search
    open_tab(study)
    panel.share.setText("0.5")
    panel.confidence.setText("0.9")
    press(panel.buttons[ASSURE])
    assert panel.bar.maximum() == 4  # 0.5^4 < 0.1
    until(study, lambda: ended(study))
    assert "not shown with 90 % confidence that at least 50 % keep it" in panel.text.toPlainText()
    press(panel.load)
    assert math.hypot(*(study.scenario.poses[0, :2] - study.scenario.poses[1, :2])) > 2.0


def test_bad_input_is_told_beside_its_field_and_nothing_starts(study):
    panel = study.search
    open_tab(study)
    panel.vary.setPlainText("control.rate: [2, 1]")
    panel.share.setText("2")
    press(panel.buttons[ASSURE])
    assert panel.notes["vary"].message.startswith("what may vary.control.rate: [2, 1]")
    assert panel.notes["At least"].message == "'2': wanted a number between 0 and 1"
    assert not panel.notes["Confidence"].message and ended(study)
    # what the command itself refuses is told, too
    panel.vary.setPlainText("gain: [200, 300]")
    panel.runs.setValue(4)
    press(panel.buttons[BREAK])
    assert not panel.notes["vary"].message and not panel.notes["At least"].message
    until(study, lambda: ended(study))
    assert "gain" in panel.title.message and panel.title.message.startswith("not done: ")


def test_what_was_typed_stays_when_another_scenario_is_opened(study):
    panel = study.search
    open_tab(study)
    study.editing.take(scenario())
    follow(study)
    assert panel.vary.toPlainText() == suggested(scenario())
    panel.vary.setPlainText("control.rate: [5, 10]")
    study.editing.take(scenario(SEARCHED))
    follow(study)
    assert panel.vary.toPlainText() == "control.rate: [5, 10]"


def test_an_emptied_list_is_filled_again_where_something_has_to_vary(study):
    panel = study.search
    open_tab(study)
    panel.vary.setPlainText(" \n")
    press(panel.buttons[ASSURE])
    assert ended(study) and panel.vary.toPlainText() == suggested(scenario(SEARCHED))
    assert panel.notes["vary"].message.startswith("nothing was to vary: above is what the scenario")
    panel.vary.clear()
    study.editing.take(study.scenario._replace(poses=study.scenario.poses + 1.0))
    follow(study)
    assert panel.vary.toPlainText() == ""  # an edit is no other scenario
    study.editing.take(scenario())
    follow(study)
    assert panel.vary.toPlainText() == suggested(scenario())
    panel.vary.clear()
    panel.runs.setValue(4)
    press(panel.buttons[BREAK])  # varies what it does by itself
    assert not panel.notes["vary"].message and not ended(study)
    until(study, lambda: ended(study))
    assert panel.vary.toPlainText() == "" and "4 runs" in panel.text.toPlainText()


def test_cancel_ends_the_search(study):
    panel = study.search
    open_tab(study)
    panel.vary.setPlainText("control.parameters.gain: [0.4, 0.6]")
    panel.runs.setValue(100000)
    press(panel.buttons[BREAK])
    process = study.study.processes.jobs["search"]
    until(study, lambda: "runs" in panel.title.message)
    press(panel.cancel)
    assert not panel.cancel.isEnabled()
    until(study, lambda: ended(study))
    assert process.poll() is not None and panel.title.message.startswith(
        "cancelled; its runs are in "
    )
    until(study, lambda: not alive(process.pid))  # nor a worker
    assert not panel.text.isVisible()


def test_what_was_found_stands_before_warnings(tmp_path):
    printed = "experiment: warning: near\nsearch: 3 runs\nfound after 3 runs\n  near: BROKEN\n"
    text = result_of(BREAK, str(tmp_path), printed).text
    assert text == "found after 3 runs\n  near: BROKEN\nexperiment: warning: near"


def test_a_misspelt_parameter_of_the_law_is_offered_by_its_own_name():
    with pytest.raises(ScenarioError, match="unknown 'gian'; did you mean 'gain'"):
        with_search(scenario(), "gian: [0.4, 0.5]", ("gain",))


def test_a_pointer_below_a_formula_is_a_mark_within_it():
    text = "near: 2 s beside a signal in m\n  always(distance < 2 s)\n                    ^"
    assert reason(ValueError(text)).endswith("always(distance < \u25b82 s)")
