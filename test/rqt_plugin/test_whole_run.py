"""The button Run: what is typed counts, and a run ends although no robot moves."""

import os
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLineEdit

from mrs_simulator.rqt_plugin.window.whole_run import WholeRun
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

pytestmark = pytest.mark.usefixtures("no_hidden_errors")


@pytest.fixture
def study():
    application = QApplication.instance() or QApplication([])
    widget = shown(quiet_study(load_scenario(scenario_path("paper_four"))), 1180, 720)
    begun = []
    widget.whole.begin = lambda speed: begun.append(widget.scenario.control.parameters["k"]) or ""
    widget.begun = begun
    yield widget
    widget.close_study()
    widget.close()
    application.processEvents()


def typed(study, text):
    """Type ``text`` into the field of k, and leave the mouse and Enter alone."""
    study.settings_tabs.setCurrentIndex(1)
    field = study.protocol.findChild(QLineEdit, "k")
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


def test_run_takes_over_what_is_being_typed(study):
    typed(study, "0.031")
    study.bar.asked.emit("run")
    assert study.begun == [0.031]
    assert QApplication.focusWidget() is not None  # the window's keys still work


def test_run_begins_nothing_with_a_refused_parameter(study):
    typed(study, "fast")
    study.settings_tabs.setCurrentIndex(0)
    study.bar.asked.emit("run")
    assert study.begun == []
    assert "a parameter is refused" in study.messages.toPlainText()
    assert study.settings_tabs.tabText(study.settings_tabs.currentIndex()) == "Protocol"


@pytest.mark.parametrize("begun", [None, 0.0])
def test_a_run_ends_after_its_duration_though_no_robot_moves(begun):
    study, results = MagicMock(), MagicMock()
    study.is_controlled.return_value = True
    history = SimpleNamespace(begun=begun, time=[0.0], cleared=2, scenario=None, recorded="run")
    study.scenario.duration = 5.0
    whole = WholeRun(study, history, results, lambda said: None)
    whole._wait_for("end")
    for time, ended in ((4.9, False), (5.0, True)):
        study.connection.snapshot.return_value = SimpleNamespace(time=time)
        whole.follow()
        assert results.judge.called == ended


def test_after_a_refused_start_run_is_free_at_once():
    study = MagicMock()
    whole = WholeRun(study, SimpleNamespace(cleared=0), MagicMock(), lambda said: None)
    whole._wait_for("simulation")
    study.state.no_start.return_value = "no simulation"
    for gone in (False, True):
        study.processes.is_gone.return_value = gone
        whole.follow()
        assert (whole.no_run() == "a run is under way") == (not gone)
