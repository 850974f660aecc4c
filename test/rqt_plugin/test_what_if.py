"""A look ahead by the mouse: what is asked, what is drawn, and what is said of it."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from ros_fixtures import wait_until

from mrs_simulator.rqt_plugin.curves.quantities import ERROR
from mrs_simulator.study.run.ahead import Future
from mrs_simulator.study.run.law_process import LawProcess

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


@pytest.fixture
def study(monkeypatch):
    widget = shown(quiet_study(shipped("paper_four")), 1180, 720)
    widget.asked = []

    def ask(function, scenario, what, *arguments):
        widget.asked.append((what, arguments))
        if what == "prepare_ahead":
            return True
        pose = np.repeat(scenario.poses[np.newaxis], 3, axis=0)
        return Future(np.arange(3.0), pose, np.array([3.0, 2.0, 0.125]), what == "look_further")

    monkeypatch.setattr(widget.what_if._laws, "ask", ask)
    widget.modes["ahead"].setChecked(True)
    yield widget
    widget.close_study()
    widget.close()
    APP.processEvents()


def looked(study):
    """Return the ``Edit`` of the look, once it is whole, and what is said of it."""

    def whole():
        study.what_if.show_frame()
        return study.what_if._can_keep

    wait_until(whole)
    edits = [arguments[2] for what, arguments in study.asked if what == "look_ahead"]
    return edits[-1], study.map_panel.ahead.text.text()


def test_a_robot_that_is_dragged_stays_where_it_is_and_its_ghost_goes_on(study):
    before = study.map.team.pose.copy()
    at = QPoint(*map(int, study.map.to_screen(*before[1, :2])))
    QTest.mousePress(study.map, Qt.LeftButton, Qt.NoModifier, at)
    move = QPointF(at + QPoint(30, 0)), Qt.NoButton, Qt.LeftButton, Qt.NoModifier
    QApplication.sendEvent(study.map, QMouseEvent(QMouseEvent.MouseMove, *move))
    edit, said = looked(study)
    QTest.mouseRelease(study.map, Qt.LeftButton, Qt.NoModifier, at + QPoint(30, 0))
    (place,) = edit.places.items()
    assert place[0] == 1 and place[1][0] > before[1, 0] + 0.3
    assert said.startswith("From 0.0 s, robot 2 at (") and said.endswith(
        "error 0.125 m after 2.0 s"
    )
    assert study.map.ahead.moved == (1,) and study.map.team.pose.tolist() == before.tolist()
    assert study.scenario.poses.tolist() == before.tolist()
    (ghosts,) = [each for each in study.map.scene().ghosts if each.kinds]  # in 3D, too
    assert len(ghosts.kinds) == len(before) + 1 and len(ghosts.paths) == len(before)
    study.modes["look"].setChecked(True)
    assert study.map.ahead is None


def error_curves(study):
    """Return the error curves shown, by name."""
    panel = study.curves
    tabs = [panel.tabs.tabData(place) for place in range(panel.tabs.count())]
    panel.tabs.setCurrentIndex(tabs.index(ERROR))
    return {curve.name: curve for curve in panel._data()[0]}


def test_the_error_of_a_look_ahead_is_a_dashed_curve_until_it_is_cleared(study):
    study.map_panel.ahead.slider.setValue(20)
    looked(study)
    curve = error_curves(study)["What if"]
    assert curve.time.tolist() == [0.0, 1.0, 2.0] and curve.values.tolist() == [3.0, 2.0, 0.125]
    assert curve.style["ls"] not in ("-", study.curves.plot.error_styles()[1]["ls"])
    assert study.curves._time_limits()[1] >= 2.0
    study.map_panel.ahead.clear_button.click()
    assert "What if" not in error_curves(study)


def test_gains_are_moved_by_a_slider_and_edges_cut_by_a_click(study):
    bar, edge = study.map_panel.ahead, study.map.edges.list[0]
    bar.gain.setCurrentText("k")
    bar.slider.setValue(20)
    edit, said = looked(study)
    assert edit.parameters == {"k": pytest.approx(2.0 * 0.02)} and "k = 0.04" in said
    study.map.ahead_cut.emit(edge)
    edit, said = looked(study)
    edges, directed = edit.topology
    assert len(edges) == len(study.map.edges.list) - 1 and edge not in edges and directed
    assert "without {}\u2013{}".format(*edge[:2]) in said and "k = 0.04" in said
    study.map.ahead_cut.emit(edge)  # again: it is back
    assert study.what_if._edit().topology is None
    bar.clear_button.click()
    assert study.what_if._subject is None and bar.slider.value() == 0
    assert not bar.keep.isEnabled() and study.map.ahead is None


def test_a_kept_run_is_named_after_what_was_changed(study, monkeypatch, tmp_path):
    shelf, edge = study.study.shelf, study.map.edges.list[0]
    shelf.home = str(tmp_path)
    done = []
    monkeypatch.setattr(study.connection, "do", lambda name, work: done.append(work))
    monkeypatch.setattr(LawProcess, "ask", lambda *_: None)
    study.map.ahead_cut.emit(edge)
    looked(study)
    study.map_panel.ahead.keep.click()
    success, answer = done[0]()
    study.what_if.kept(success, answer)
    kept = shelf.settings()
    name = "what if at 0.0 s: without {}\u2013{}".format(*edge[:2])
    assert [marks["name"] for marks in kept["marks"].values()] == [name]
    assert list(kept["origins"].values()) == [[study.scenario.title, 0.0]]


def test_it_is_said_why_there_is_no_look_ahead(study):
    forces = study.scenario._replace(fidelity="dynamic")
    study.study.edited.scenario = forces
    study.map.ahead_moved.emit(1, 0.0, 0.0)
    said = study.map_panel.ahead.text.text()
    assert said.startswith("Not now: with forces (fidelity: dynamic)") and study.asked == []
