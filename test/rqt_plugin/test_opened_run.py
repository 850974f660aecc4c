"""Runs of the list, opened by mouse and keys: map, curves, time line and verdict show them."""

import json
import os
import shutil
import time

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown, wait_shown
from PyQt5.QtCore import QEvent, QMimeData, QPoint, Qt, QUrl
from PyQt5.QtGui import QDropEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAction, QApplication, QFileDialog, QMenu

from mrs_simulator.record.recording import read_run_csv
from mrs_simulator.record.run_changes import Change, to_plain
from mrs_simulator.rqt_plugin.run.loaded_run import history_of, mean_twist
from mrs_simulator.rqt_plugin.shelf.entry import Entry
from mrs_simulator.rqt_plugin.shelf.panel import ShelfPanel
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.run.experiment import run_experiment

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")
NONE = Qt.NoModifier
GAINS = 0.02, 0.05


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return the folder of a shelf with two runs, and their scenario."""
    home = tmp_path_factory.mktemp("shelf")
    scenario = load_scenario(scenario_path("paper_four"))._replace(duration=12.0)
    for place, gain in enumerate(GAINS):
        control = scenario.control
        control = control._replace(parameters=dict(control.parameters, k=gain))
        path = str(home / "runs" / "run{}".format(place))
        run_experiment(scenario._replace(control=control), path, formats=())
        for each in (path, os.path.join(path, "run.csv")):
            os.utime(each, (1e9 + place, 1e9 + place))
    return home, scenario


@pytest.fixture
def study(runs, no_predictions):
    application = QApplication.instance() or QApplication([])
    home, scenario = runs
    widget = quiet_study(scenario)
    widget.study.shelf.home = str(home)
    widget.study.shelf.change(watched=[])
    widget.shelf_control.look()
    shown(widget, 1280, 720)
    widget.bring_forward("Runs")
    until(widget, lambda: len(widget.shelf.list.runs.entries) == 2)
    yield widget
    widget.close_study()
    widget.close()
    application.processEvents()


def frame(widget):
    widget.opened.follow()
    widget.comparison_control.follow()
    widget.shelf_control.follow()
    widget.replay.show_frame()
    widget.opened.show_frame()
    widget.live.show_frame()
    widget.comparison_control.show_frame()


def until(widget, condition):
    wait_shown(condition, follow=lambda: frame(widget), said=widget.messages.toPlainText)


def click(widget, row, in_box=False):
    runs = widget.shelf.list
    place = runs.visualRect(runs.runs.index(row))
    at = runs.itemDelegate().box(place).center() if in_box else place.center()
    QTest.mouseClick(runs.viewport(), Qt.LeftButton, NONE, at)


def opened(widget, row):
    """Open the run in ``row``, the newest 0, by a click; return its folder."""
    click(widget, row)
    path = widget.shelf.list.runs.entries[row].path
    until(widget, lambda: widget.opened.run is not None and widget.opened.run.path == path)
    frame(widget)
    return path


def test_a_click_shows_a_run_at_any_moment_and_another_button_the_window_s_own(study):
    own = study.map.team.pose.copy()
    path = opened(study, 0)
    run = read_run_csv(os.path.join(path, "run.csv"))
    np.testing.assert_allclose(study.map.team.pose, run.pose[-1])
    assert study.time_line.label.text() == "end: 12.0 s"
    assert "not judged" in study.verdict.title.message and study.map.trails.begun >= 2
    until(study, lambda: study.map.targets is not None)
    ended = study.map.targets.copy()
    QTest.keyClick(study.time_line.slider, Qt.Key_Home)
    # They are where neighbours are.
    until(study, lambda: np.abs(study.map.targets - ended).max() > 0.1)
    np.testing.assert_allclose(study.map.team.pose, run.pose[0])
    assert study.shelf.list.runs.shown == path
    QTest.mouseClick(study.time_line.newest, Qt.LeftButton)
    frame(study)
    np.testing.assert_allclose(study.map.team.pose, own)
    assert study.time_line.label.text() == "no run yet" and study.verdict.verdict is None


def test_the_simulation_goes_on_while_another_run_is_looked_at(study, runs):
    state = history_of(read_run_csv(str(runs[0] / "runs" / "run0" / "run.csv"))).state

    def go_on(row):
        newest = state.at(row).replace(fresh=np.ones(4, dtype=bool))
        study.history.append(newest)
        study.connection.snapshot.return_value = newest
        frame(study)
        return newest.pose

    study.history.before_clearing = lambda: None
    study.study.processes.is_running.return_value = True
    for row in range(40):
        now = go_on(row)
    until(study, lambda: np.array_equal(study.map.team.pose, now))
    opened(study, 0)
    shown = study.map.team.pose.copy()
    for row in range(40, 60):
        now = go_on(row)
    np.testing.assert_array_equal(study.map.team.pose, shown)
    assert study.opened.run is not None and len(study.history.time) == 60
    QTest.mouseClick(study.time_line.newest, Qt.LeftButton)
    frame(study)
    np.testing.assert_array_equal(study.map.team.pose, now)
    trail = study.map.trails.path(0)
    np.testing.assert_allclose(trail[[0, -1]], state.pose[[0, 59], 0, :2], atol=0.05)
    assert go_on(60) is not None and not study.map.is_past
    study.history.saved = np.inf


def test_an_edit_and_a_mode_of_the_mouse_close_the_run(study):
    for overtake in (
        lambda: study.modes["poses"].setChecked(True),
        lambda: study.protocol.parameters_changed.emit(
            dict(study.scenario.control.parameters, k=0.03)
        ),
    ):
        opened(study, 1)
        overtake()
        until(study, lambda: study.opened.run is None)
        assert not study.map.is_past and study.replay.is_own
        study.modes["look"].setChecked(True)


def test_a_run_is_renamed_pinned_deleted_and_brought_back(study):
    opened(study, 0)
    panel, path = study.shelf, study.shelf.list.current_path()
    QTest.keyClick(panel, Qt.Key_F2)
    QTest.keyClicks(panel.name, "faster")
    QTest.keyClick(panel.name, Qt.Key_Return)
    QTest.mouseClick(panel.pin, Qt.LeftButton)
    until(study, lambda: panel.list.runs.entries[0].marks[::2] == ("faster", True))
    QTest.keyClick(panel.list, Qt.Key_Delete)
    until(study, lambda: len(panel.list.runs.entries) == 1)
    assert not os.path.exists(path)
    QTest.mouseClick(panel.undo, Qt.LeftButton)
    until(study, lambda: len(panel.list.runs.entries) == 2)
    assert panel.list.runs.entries[0].name == "faster" and not panel.undo.isVisible()
    study.study.shelf.mark(path, name="", pinned=False)


def test_a_run_that_ends_while_another_is_being_saved_is_saved_after_it(study, runs):
    history, done = study.history, []
    study.connection.do = lambda name, work: done.append(name)
    other = history_of(read_run_csv(str(runs[0] / "runs" / "run0" / "run.csv")))
    for _ in range(2):
        history.clear()
        history.fill(other.state.replace(estimate=None))
        history.moved = history.time[-1]
        study.results.judge()
    assert done == ["save"]
    verdict = str(runs[0] / "runs" / "run0" / "verdict.json")
    assert study.results.ended(True, verdict) and done == ["save", "save"]
    assert study.verdict.verdict is None and study.results.of_run() == ""  # of the run before
    study.results.ended(True, verdict)
    assert study.verdict.verdict is not None
    assert study.results.of_run() == os.path.dirname(verdict)
    assert not history.is_unsaved(0.1)


def test_a_verdict_on_the_own_run_waits_while_another_run_is_shown(study, runs):
    history, done = study.history, []
    study.connection.do = lambda name, work: done.append(name)
    other = history_of(read_run_csv(str(runs[0] / "runs" / "run0" / "run.csv")))
    history.fill(other.state.replace(estimate=None))
    history.moved = history.time[-1]
    study.results.judge()
    opened(study, 0)
    until(study, lambda: study.verdict.verdict is not None)
    verdict = runs[0] / "runs" / "own" / "verdict.json"
    verdict.parent.mkdir()
    verdict.write_text(json.dumps(dict(study.opened.run.verdict, title="own", outcome="failed")))
    assert study.results.ended(True, str(verdict))
    frame(study)
    assert study.verdict.verdict is study.opened.run.verdict
    QTest.mouseClick(study.time_line.newest, Qt.LeftButton)
    assert study.verdict.title.message.startswith("own: FAILED")
    shutil.rmtree(str(verdict.parent))


def test_a_run_that_is_saved_again_stays_one_row(study, runs, tmp_path, monkeypatch):
    first = str(runs[0] / "runs" / "run0")
    monkeypatch.setattr(study.study.files, "saver", lambda *_: lambda: None)
    monkeypatch.setattr(study.study.files, "saver_of", lambda *_: lambda: None)
    study.history.fill(history_of(read_run_csv(os.path.join(first, "run.csv"))).state)
    study.history.moved = study.history.time[-1]

    def ended(path):
        assert study.results.ended(True, os.path.join(str(path), "verdict.json"))
        study.shelf_control.add(os.path.join(str(path), "verdict.json"))

    shutil.copytree(first, str(tmp_path / "copy"))
    study.results.judge()
    study.results.save(str(tmp_path / "copy"))  # which waits
    ended(first)
    ended(tmp_path / "copy")
    assert study.study.shelf.settings()["copies"] == {str(tmp_path / "copy"): first}
    assert study.results.of_run() == first and len(study.study.shelf.scan()) == 2
    path = opened(study, 0)
    shutil.copytree(path, str(tmp_path / "other"))
    study.results.save(str(tmp_path / "other"))
    ended(tmp_path / "other")
    assert len(study.study.shelf.scan()) == 2
    study.study.shelf.change(others=[], copies={})


def test_the_run_that_was_shown_as_a_folder_was_asked_for_is_saved(study, tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(study.study.files, "saver_of", lambda path, *_: lambda: asked.append(path))
    path = opened(study, 1)
    study.results.ask_where()
    opened(study, 0)
    dialog = next(each for each in study.findChildren(QFileDialog) if each.isVisible())
    dialog.fileSelected.emit(str(tmp_path / "saved"))
    dialog.close()
    assert asked == [path]


def test_the_row_of_the_run_that_is_shown_is_highlighted_and_no_other(study):
    listed, line, details = study.shelf.list, study.time_line, study.shelf.details
    assert listed.current() is None and not details.isVisible() and line.run.text() == ""
    path = opened(study, 1)
    assert listed.current_path() == path and details.isVisible()
    name = listed.current().name
    assert line.run.toolTip() == name + time.strftime(", %Y-%m-%d %H:%M", time.localtime(1e9))
    other = listed.visualRect(listed.runs.index(0)).center()
    QTest.mouseClick(listed.viewport(), Qt.RightButton, NONE, other)
    assert listed.current_path() == path  # the menu is for the row below the mouse
    QTest.mouseClick(line.newest, Qt.LeftButton)
    frame(study)
    assert listed.current() is None and not details.isVisible() and line.run.text() == ""
    click(study, 0, in_box=True)
    listed.clearFocus()
    listed.setFocus(Qt.ActiveWindowFocusReason)
    assert listed.current() is None and not details.isVisible()
    listed.clear_compared()


def test_a_run_that_is_marked_as_the_other_is_shown_keeps_its_name_to_itself(study):
    first, second = (entry.path for entry in study.shelf.list.runs.entries)
    opened(study, 0)
    asked = []
    study.shelf.mark_asked.connect(lambda path, marks: asked.append((path, marks)))
    study.shelf.name.setFocus()
    study.shelf.name.selectAll()
    QTest.keyClicks(study.shelf.name, "mine")
    study.opened.open(second)
    until(study, lambda: study.shelf.list.current_path() == second)
    assert asked == [(first, {"name": "mine"})]
    study.study.shelf.mark(first, name="")


def test_a_graph_that_changed_in_a_run_is_shown_as_of_the_moment(study, tmp_path):
    scenario = load_scenario(scenario_path("consensus"))._replace(duration=4.0)
    run_experiment(scenario, str(tmp_path), formats=())
    facts, cut = json.loads((tmp_path / "run.json").read_text()), [[2, 1], [3, 2]]
    change = Change(2.0, "topology", {"edges": cut, "directed": False})
    (tmp_path / "run.json").write_text(json.dumps(dict(facts, changes=to_plain([change]))))
    study.opened.open(str(tmp_path))
    until(study, lambda: study.opened.run is not None)
    for moment, wanted in ((1.0, scenario.topology.edges), (3.0, [(2, 1, 1.0), (3, 2, 1.0)])):
        study.replay.cursor.go(moment)
        until(study, lambda wanted=wanted: sorted(study.map.edges.list) == sorted(wanted))


def test_runs_and_folders_are_dropped_on_the_list(study, runs, tmp_path):
    shutil.copytree(str(runs[0] / "runs" / "run0"), str(tmp_path / "alone"))
    shutil.copytree(str(runs[0] / "runs" / "run1"), str(tmp_path / "others" / "a"))
    data, urls = QMimeData(), [tmp_path / "alone" / "run.csv", tmp_path / "others"]
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in urls])
    drop = QDropEvent(QPoint(5, 5), Qt.CopyAction, data, Qt.LeftButton, NONE)
    study.shelf.list.dropEvent(drop)
    until(study, lambda: len(study.shelf.list.runs.entries) == 4)
    kept = study.study.shelf.settings()
    assert kept["others"] == [str(tmp_path / "alone")]
    assert kept["watched"] == [str(tmp_path / "others")]
    study.study.shelf.change(others=[], watched=[])


def test_a_broken_run_is_refused_in_words(study, tmp_path):
    (tmp_path / "run.csv").write_text("time,robot\n0,1\n")
    study.opened.open(str(tmp_path))
    until(study, lambda: "not opened" in study.messages.toPlainText())
    study.opened.open(str(tmp_path / "none"))
    assert "no run: wanted a folder" in study.messages.toPlainText()
    assert study.opened.run is None


def test_twists_are_taken_from_poses_where_none_were_recorded(runs):
    time = np.linspace(0.0, 2.0, 201)
    pose = np.zeros((201, 1, 3))  # a circle of 2 m at 0.5 rad/s, the heading wrapped
    pose[:, 0] = np.stack([2.0 * np.sin(time / 2), 2.0 - 2.0 * np.cos(time / 2), time / 2], axis=1)
    pose[:, 0, 2] = np.angle(np.exp(1j * (pose[:, 0, 2] + 3.0)))
    twist = mean_twist(time, pose)[1:-1, 0]
    ahead = np.array([np.cos(3.0), -np.sin(3.0)])  # the pose's heading is 3 rad off its path
    np.testing.assert_allclose(twist, np.tile([*ahead, 0.5], (199, 1)), atol=1e-4)
    run = read_run_csv(str(runs[0] / "runs" / "run0" / "run.csv"))
    history = history_of(run)
    assert history.begun == 0.0 and not history.is_unsaved(0.0)
    np.testing.assert_array_equal(history.pose, run.pose)


def test_menus_of_the_list_of_runs_do_not_pile_up():
    panel, settings = ShelfPanel(), {"folder": "runs", "watched": [], "most_bytes": 5e9}
    counts = []
    for _ in range(3):
        panel.show_entries([], settings, 0)
        menu = panel.details.menu(Entry("a", "", 0.0, "", {}, "", 0))
        menu.popup(QPoint(0, 0))
        menu.close()
        APP.sendPostedEvents(None, QEvent.DeferredDelete)
        counts.append([len(panel.findChildren(kind)) for kind in (QMenu, QAction)])
    assert counts[0] == counts[1] == counts[2]
    (sizes,) = [each.menu() for each in panel.menu.menu().actions() if each.menu()]
    assert [each.isChecked() for each in sizes.actions()].count(True) == 1
    panel.close()
