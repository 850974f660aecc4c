"""A run's moments, chosen by mouse and keys on the line below the map, the curves and the verdict."""

import os

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown, wait_drawn
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.record.recording import Collision
from mrs_simulator.record.run_changes import Change, to_plain
from mrs_simulator.rqt_plugin.verdict.panel import CLAIM
from mrs_simulator.rqt_plugin.widgets.symbols import symbolic
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")
STEP, SAMPLES = 0.1, 201
BEGUN = STEP  # [s] when the first command came
NONE = Qt.NoModifier


def sample(n, row):
    """Return the team at sample ``row``: robot i goes along x at i m/s from the second one on."""
    pose = np.zeros((n, 3))
    pose[:, 0], pose[:, 1] = np.arange(1, n + 1) * STEP * max(0, row - 1), 3.0 * np.arange(n)
    command = np.zeros((n, 2))
    command[:, 0] = np.arange(1, n + 1) * (row > 0)
    twist, fresh = np.zeros((n, 3)), np.ones(n, dtype=bool)
    return snapshot_of(row * STEP, tuple(range(1, n + 1)), pose, twist, command, fresh)


DRAWS_CURVES = pytest.mark.parametrize("study", [True], indirect=True)


@pytest.fixture
def study(request):
    application = QApplication.instance() or QApplication([])
    draws = getattr(request, "param", False)
    widget = quiet_study(load_scenario(scenario_path("paper_four")), draws_curves=draws)
    widget.history.before_clearing = lambda: None  # nothing is kept
    for row in range(SAMPLES):
        widget.history.append(sample(4, row))
    shown(widget, 1180, 720)
    show(widget, sample(4, SAMPLES - 1))
    yield widget
    widget.history.saved = np.inf
    widget.close_study()
    widget.close()
    application.processEvents()


def show(widget, newest):
    widget.connection.snapshot.return_value = newest
    widget.study.processes.is_running.return_value = True
    frame(widget)


def frame(widget):
    widget.replay.show_frame()
    widget.live.show_frame()


def x_of(widget):
    frame(widget)
    return widget.map.team.pose[:, 0]


def test_a_click_on_the_line_shows_that_moment_and_another_button_the_newest(study):
    line = study.time_line
    assert line.label.text() == "newest: 19.9 s" and line.newest.isChecked()
    middle = QPoint(line.slider.width() // 2, line.slider.height() // 2)
    QTest.mouseClick(line.slider, Qt.LeftButton, NONE, middle)
    time = study.replay.cursor.time
    assert time == pytest.approx(10.0, abs=0.2)
    row = int(time / STEP + 1e-9)
    np.testing.assert_allclose(x_of(study), sample(4, row).pose[:, 0])
    assert line.label.text() == "past: {:.2f} of 19.9 s".format(time - BEGUN)
    assert study.map.is_past and study.curves.moment == time - BEGUN
    # Trails end there; the run that goes on is recorded, and shown later.
    trail = study.map.trails.path(3)
    assert len(trail) > 50 and trail[:, 0].max() <= 4.0 * STEP * row
    study.history.append(sample(4, SAMPLES))
    show(study, sample(4, SAMPLES))
    np.testing.assert_allclose(study.map.team.pose[:, 0], sample(4, row).pose[:, 0])
    QTest.mouseClick(line.newest, Qt.LeftButton)
    np.testing.assert_allclose(x_of(study), sample(4, SAMPLES).pose[:, 0])
    assert not study.map.is_past and study.curves.moment is None
    assert study.map.trails.path(3)[:, 0].max() > 75.0


def test_keys_step_through_samples(study):
    slider, cursor = study.time_line.slider, study.replay.cursor
    QTest.keyClick(slider, Qt.Key_Left)
    assert cursor.time == pytest.approx(19.9) and cursor.row == SAMPLES - 2
    QTest.keyClick(slider, Qt.Key_Left, Qt.ShiftModifier)
    assert cursor.row == SAMPLES - 12
    QTest.keyClick(slider, Qt.Key_Right)
    assert cursor.row == SAMPLES - 11
    QTest.keyClick(slider, Qt.Key_Home)
    assert cursor.time == BEGUN
    QTest.keyClick(slider, Qt.Key_Left)
    assert cursor.time == BEGUN
    QTest.keyClick(slider, Qt.Key_Space)
    assert cursor.playing
    cursor.pass_time(2.0)
    assert cursor.time == pytest.approx(BEGUN + 2.0)
    QTest.keyClick(slider, Qt.Key_Space)
    cursor.pass_time(2.0)
    assert cursor.time == pytest.approx(BEGUN + 2.0)
    QTest.keyClick(slider, Qt.Key_End)
    assert cursor.time is None


def test_a_replay_runs_to_the_end_at_its_speed_and_begins_again(study):
    line, cursor = study.time_line, study.replay.cursor
    line.speed.setCurrentIndex(line.speed.findData(10.0))
    line.speed.activated.emit(line.speed.currentIndex())
    QTest.mouseClick(line.play, Qt.LeftButton)
    assert cursor.time == BEGUN
    cursor.pass_time(0.5)
    assert cursor.time == pytest.approx(BEGUN + 5.0)
    cursor.pass_time(30.0)
    assert cursor.time == pytest.approx(20.0) and not cursor.playing
    QTest.mouseClick(line.play, Qt.LeftButton)
    assert cursor.time == BEGUN and cursor.playing


@DRAWS_CURVES
def test_a_click_on_curves_chooses_the_moment_and_a_drag_does_not(study):
    study.results_tabs.setCurrentWidget(study.curves)
    wait_drawn(study.curves)
    canvas = study.curves.canvas
    middle = QPoint(canvas.width() // 2, canvas.height() // 2)
    QTest.mousePress(canvas, Qt.LeftButton, NONE, middle)
    QTest.mouseMove(canvas, middle + QPoint(60, 0))
    QTest.mouseRelease(canvas, Qt.LeftButton, NONE, middle + QPoint(60, 0))
    assert study.replay.cursor.time is None
    study.curves.see_all()
    wait_drawn(study.curves)
    QTest.mouseClick(canvas, Qt.LeftButton, NONE, middle)
    time = study.replay.cursor.time
    assert 5.0 < time < 15.0
    frame(study)
    assert study.curves.moment == time - BEGUN


def test_a_new_run_and_an_edit_are_shown_at_once(study):
    study.replay.cursor.go(3.0)
    frame(study)
    study.history.append(sample(4, 0))  # time went back: another run
    study.history.append(sample(4, 1))
    show(study, sample(4, 1))
    frame(study)
    assert not study.replay.cursor.is_past and study.map.team.state.time == STEP
    for row in range(2, 40):
        study.history.append(sample(4, row))
    study.replay.cursor.go(1.0)
    frame(study)
    study.map.show_team(study.scenario.poses)
    frame(study)
    assert not study.replay.cursor.is_past


def test_targets_and_graph_of_a_moment_are_those_of_the_law_then(study):
    closed = dict(study.scenario.control.parameters, closure="cycle")
    control = dict(study.scenario.to_dict()["control"], parameters=closed)
    changes = to_plain([Change(10.0, "control", control)])
    study.live.ran = study.scenario, {"changes": changes}
    for moment, edges in ((15.0, 4), (5.0, 3)):
        study.replay.cursor.go(moment)
        for _ in range(6000):
            frame(study)
            if len(study.map.edges.list) == edges and study.map.targets is not None:
                break
            QTest.qWait(10)
        # Each robot but the last is to be 2 m beside the one that it receives from.
        pose, targets = study.map.team.pose, study.map.targets
        assert len(study.map.edges.list) == edges
        np.testing.assert_allclose(targets[0], pose[1, :2] + (2.0, 0.0), atol=0.1)


def check(name, **more):
    numbers = dict.fromkeys(("predicted", "difference", "tolerance"), 1.0)
    return {"question": "robots", "name": name, "passed": False, "note": "", **numbers, **more}


def test_a_line_of_the_verdict_leads_to_the_moment_and_robot_that_decided_it(study):
    study.history.collisions.append(Collision(4.2, "robot3", "robot2", 0.0, 0.0))
    broken = dict(
        dict.fromkeys(("predicate", "unit", "decided_at", "grade", "scale", "period"), 0.1),
        **{"name": "apart", "formula": "always(distance > 1 m)", "met": False, "note": ""},
        **{"low": -0.5, "high": -0.5, "margin": -0.5, "time": 6.0, "member": "robot2 and robot4"},
    )
    broken.update(predicate="distance > 1 m", unit="m")
    verdict = {
        "title": "four",
        "checks": [
            check("collisions", measured=1),
            check("settling time [s]", measured=12.5),
            check("final gap [m]", measured=1.5, note="robot4, left wheel"),
        ],
        "requirements": [broken],
        "passed": False,
        "outcome": "failed",
        "final_gaps": [],
        "min_distance": None,
        "warnings": [],
    }
    study.verdict.set_verdict(verdict)
    found, table = [], study.verdict.table

    def click(claim):
        rows = (row for row in range(table.rowCount()) if table.text(row, CLAIM) == symbolic(claim))
        table.cellClicked.emit(next(rows), CLAIM)

    for name in ("collisions", "settling time [s]", "apart [m]"):
        click(name)
        found.append((study.replay.cursor.time, study.map.selected))
    # The run begins with its first command, at 0.1 s.
    assert found == [(pytest.approx(4.2), 3), (pytest.approx(12.6), 3), (pytest.approx(6.1), 2)]
    click("final gap [m]")
    assert study.map.selected == 4


def test_without_a_run_there_is_nothing_to_choose():
    application = QApplication.instance() or QApplication([])
    widget = quiet_study(load_scenario(scenario_path("paper_four")))
    frame(widget)
    line = widget.time_line
    assert line.label.text() == "no run yet" and not line.slider.isEnabled()
    widget.replay.cursor.go(3.0)
    widget.replay.cursor.play(True)
    assert not widget.replay.cursor.is_past and not widget.replay.cursor.playing
    widget.close_study()
    application.processEvents()
