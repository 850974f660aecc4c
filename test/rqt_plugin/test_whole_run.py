"""The button Run: what is typed counts, and a run ends although no robot moves."""

import os
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLineEdit, QTableView

from mrs_simulator.record.run_changes import ControllerRecord
from mrs_simulator.rqt_plugin.run.study_state import StudyState
from mrs_simulator.rqt_plugin.window.pending import PendingTeam
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


def cell(study, robot, column, text, enter=False):
    """Type ``text`` into a cell of the table of poses."""
    study.settings_tabs.setCurrentIndex(0)
    table = study.team.findChild(QTableView)
    table.setCurrentIndex(table.model().index(robot - 1, column))
    table.edit(table.currentIndex())
    editor = QApplication.focusWidget()
    editor.selectAll()
    QTest.keyClicks(editor, text)
    if enter:
        QTest.keyClick(editor, Qt.Key_Return)


def test_run_begins_nothing_where_robots_overlap_and_shows_them(study):
    x, y, _ = study.scenario.poses[1]
    cell(study, 1, 1, str(x), enter=True)
    cell(study, 1, 2, str(y))
    study.settings_tabs.setCurrentIndex(1)
    for name in ("run", "simulate", "control"):
        study.bar.asked.emit(name)
        assert study.begun == [] and not study.study.processes.start.called
        assert study.settings_tabs.tabText(study.settings_tabs.currentIndex()) == "Team"
    assert "not started: robot1 and robot2 overlap" in study.messages.toPlainText()
    cell(study, 1, 1, "10")
    study.bar.asked.emit("run")
    assert len(study.begun) == 1


def test_point_masses_may_begin_in_one_place(study):
    study.editing.take(study.scenario._replace(fidelity="point_mass"))
    cell(study, 1, 1, str(study.scenario.poses[1, 0]), enter=True)
    cell(study, 1, 2, str(study.scenario.poses[1, 1]))
    study.bar.asked.emit("run")
    assert study.team.overlapping == {1, 2} and len(study.begun) == 1


def test_run_begins_nothing_with_a_pose_that_is_typed_and_refused(study):
    cell(study, 2, 1, "1,5")
    study.settings_tabs.setCurrentIndex(1)
    study.bar.asked.emit("run")
    assert study.begun == []
    assert "not started: robot2, x [m]: '1,5', wanted" in study.messages.toPlainText()
    assert study.settings_tabs.tabText(study.settings_tabs.currentIndex()) == "Team"
    study.bar.asked.emit("run")  # the table shows the pose in force again
    assert len(study.begun) == 1


def whole_run(taken):
    """Return a run that waits for its reset, and what stands for study and team."""
    study, team = MagicMock(), MagicMock()
    study.state.no_start.return_value = ""
    team.is_taken.return_value = taken
    study.is_controlled.return_value = False
    whole = WholeRun(study, SimpleNamespace(cleared=0), MagicMock(), team, lambda said: None)
    whole.wait_for("reset")
    return whole, study, team


def test_run_asks_once_more_for_a_team_that_the_simulation_refused():
    whole, study, team = whole_run(taken=False)
    whole.answered("reset", True)
    study.is_controlled.return_value = True  # its last status
    whole.follow()
    assert not team.send_now.called
    study.is_controlled.return_value = False
    whole.follow()
    assert team.send_now.called
    whole.follow()
    assert not study.do.called  # no controller before the answer
    whole.answered("set_team", False)
    assert not study.do.called and whole.no_run() != "a run is under way"


@pytest.mark.parametrize("taken", [False, True])
def test_run_starts_the_controller_of_the_team_as_edited(taken):
    whole, study, team = whole_run(taken)
    whole.answered("reset", True)
    if not taken:
        whole.follow()
        team.is_taken.return_value = True
        whole.answered("set_team", True)
    whole.follow()
    assert not study.do.called  # the simulation does not know yet how long the run lasts
    study.stage.end_after.assert_called_once_with(study.scenario.duration)
    whole.answered("pause_after", True)
    study.do.assert_called_once_with("control")
    assert team.send_now.called == (not taken)


@pytest.mark.parametrize("edited_before_the_answer", [True, False])
def test_run_sends_a_team_that_was_edited_while_the_simulation_began(edited_before_the_answer):
    """Sent after the controller's start, the team would end that controller."""
    whole, study, team = whole_run(taken=True)
    whole.answered("reset", True)
    if edited_before_the_answer:
        whole.follow()
        team.is_taken.return_value = False
        whole.answered("pause_after", True)
    team.is_taken.return_value = False
    whole.follow()
    assert team.send_now.called and not study.do.called
    team.is_taken.return_value = True
    whole.answered("set_team", True)
    whole.follow()
    whole.answered("pause_after", True)
    study.do.assert_called_once_with("control")


def test_a_run_that_is_given_up_has_no_end_of_itself():
    whole, study, _ = whole_run(taken=True)
    whole.answered("reset", True)
    whole.follow()
    whole.answered("pause_after", True)
    whole.give_up()
    study.connection.pause_after.assert_called_once_with(0)


def test_a_refused_team_is_not_the_one_that_the_simulation_has():
    study = MagicMock()
    study.state.drives.return_value = False
    team = PendingTeam(study)
    assert team.is_taken()
    for success in (False, True):
        team.changed()
        assert not team.is_taken()
        team.send_now()
        assert not team.is_taken()
        team.answered(success)
        assert team.is_settled() and team.is_taken() == success
    study.state.drives.return_value = True  # then nothing is sent
    team.changed()
    team.send_now()
    assert team.is_settled() and not team.is_taken()


@pytest.mark.parametrize("begun", [None, 0.0])
def test_a_run_ends_after_its_duration_though_no_robot_moves(begun):
    study, results = MagicMock(), MagicMock()
    study.is_controlled.return_value = True
    history = SimpleNamespace(begun=begun, time=[0.0], cleared=2, scenario=None, recorded="run")
    study.scenario.duration = 5.0
    whole = WholeRun(study, history, results, MagicMock(), lambda said: None)
    whole.wait_for("end")
    for time, ended in ((4.9, False), (5.0, True)):
        study.connection.snapshot.return_value = SimpleNamespace(time=time)
        whole.follow()
        assert results.judge.called == ended


@pytest.mark.parametrize("since", [None, 3.0])
def test_a_run_that_no_program_records_begins_with_its_controller_where_no_robot_moves(since):
    study, results, applied = MagicMock(), MagicMock(), ControllerRecord()
    study.is_controlled.return_value = True
    if since is not None:
        applied.note(since, {})
    history = SimpleNamespace(
        begun=None, time=[1.0], cleared=2, scenario=None, recorded=None, applied=applied
    )
    study.scenario.duration = 5.0
    whole = WholeRun(study, history, results, MagicMock(), lambda said: None)
    whole.wait_for("end")
    begun = 4.0 if since is None else since  # when the controller was first seen
    for time, ended in ((4.0, False), (begun + 4.9, False), (begun + 5.0, True)):
        study.connection.snapshot.return_value = SimpleNamespace(time=time)
        history.time.append(time)
        whole.follow()
        assert results.judge.called == ended and history.begun == (begun if ended else None)


def test_after_a_refused_start_run_is_free_at_once():
    study = MagicMock()
    given = SimpleNamespace(cleared=0), MagicMock(), MagicMock()
    whole = WholeRun(study, *given, lambda said: None)
    whole.wait_for("simulation")
    study.state.no_start.return_value = "no simulation"
    for gone in (False, True):
        study.stage.is_gone.return_value = gone
        whole.follow()
        assert (whole.no_run() == "a run is under way") == (not gone)


@pytest.mark.parametrize("runs_on", [True, False])
def test_a_run_outlasts_a_controller_that_is_silent_for_a_while(runs_on):
    study, results, connection = MagicMock(), MagicMock(), MagicMock()
    processes = connection.processes
    study.connection, study.state = connection, StudyState(connection, processes, MagicMock())
    study.is_controlled = study.state.is_controlled
    control = connection.newest.return_value = SimpleNamespace(running=True, paused=True)
    history = SimpleNamespace(begun=0.0, time=[0.0], cleared=2, scenario=None, recorded="run")
    study.scenario.duration = 5.0
    connection.snapshot.return_value = SimpleNamespace(time=5.0)
    whole = WholeRun(study, history, results, MagicMock(), lambda said: None)
    whole.wait_for("end")
    connection.is_fresh.return_value = False
    processes.is_running.return_value = runs_on
    whole.follow()
    assert not results.judge.called
    connection.is_fresh.return_value = True
    whole.follow()
    assert results.judge.called == runs_on  # what has ended meanwhile is no run any more
    whole.wait_for("end")
    control.running = connection.is_fresh.return_value = False  # stopped before it was silent
    whole.follow()
    assert not whole.waits
