"""A robot clicked in any part of the window is picked out in all of them."""

import os

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study, shown, wait_drawn
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.pictures.camera import on_screen
from mrs_simulator.rqt_plugin.map.robot_card import card_lines
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

pytestmark = pytest.mark.usefixtures("no_hidden_errors")
N = 4


def sample(row):
    pose = np.zeros((N, 3))
    pose[:, 0], pose[:, 1] = 0.1 * row, 3.0 * np.arange(N)
    twist, command = np.zeros((N, 3)), np.tile([1.0, -0.25], (N, 1))
    twist[:, 0], twist[:, 2] = 0.9, -0.2
    numbers, fresh = tuple(range(1, N + 1)), np.ones(N, dtype=bool)
    return snapshot_of(0.1 * row, numbers, pose, twist, command, fresh)


@pytest.fixture
def study():
    application = QApplication.instance() or QApplication([])
    widget = quiet_study(load_scenario(scenario_path("paper_four")))
    widget.history.before_clearing = lambda: None
    for row in range(50):
        widget.history.append(sample(row))
    shown(widget, 1400, 800)
    widget.map.show_snapshot(sample(49))
    widget.map.fit()
    widget.view.refresh()
    wait_drawn(widget.curves)
    yield widget
    widget.history.saved = np.inf
    widget.close_study()
    widget.close()
    application.processEvents()


def on_map(study, number):
    x, y = study.map.to_screen(*study.map.team.pose[number - 1, :2])
    QTest.mouseClick(study.map, Qt.LeftButton, Qt.NoModifier, QPoint(int(x), int(y)))


def in_space(study, number):
    canvas = study.view.canvas
    place = canvas.camera.seen(canvas.scene.place[number - 1 : number] + (0.0, 0.0, 0.1))
    ((x, y),) = on_screen(place, canvas.width(), canvas.height())
    QTest.mouseClick(canvas, Qt.LeftButton, Qt.NoModifier, QPoint(int(x), int(y)))


def on_curves(study, number):
    study.curves._tabs.setCurrentIndex(1)  # y, in which they lie apart
    wait_drawn(study.curves)
    canvas, axes = study.curves.canvas, study.curves._plot.axes
    x, y = axes.transData.transform((2.0, 3.0 * (number - 1)))
    QTest.mouseClick(canvas, Qt.LeftButton, Qt.NoModifier, QPoint(int(x), int(canvas.height() - y)))


def in_table(study, number):
    table = study.team._table
    at = table.visualRect(table.model().index(number - 1, 0)).center()
    QTest.mouseClick(table.viewport(), Qt.LeftButton, Qt.NoModifier, at)


def picked_out(study):
    """Return which robot each part of the window picks out."""
    curves = study.curves._data()[0]
    bold = [curve.robot for curve in curves if "zorder" in curve.style] or [0]
    rows = study.team._table.selectionModel().selectedRows()
    scene = study.map.scene().chosen
    return {
        study.map.selected,
        0 if scene is None else scene + 1,
        study.sensors.number,
        *bold,
        rows[0].row() + 1 if rows else 0,
    }


def test_a_click_anywhere_picks_the_robot_out_everywhere(study):
    for number, click in enumerate((on_map, in_space, on_curves, in_table), 1):
        click(study, number)
        assert picked_out(study) == {number}, click.__name__
    x, y = study.map.to_screen(3.0, 4.5)
    QTest.mouseClick(study.map, Qt.LeftButton, Qt.NoModifier, QPoint(int(x), int(y)))
    assert picked_out(study) == {0}


def test_the_card_has_pose_speed_command_neighbours_and_distance_to_the_target(study):
    targets = study.map.team.pose[:, :2] + (0.3, 0.4)
    edges = [(2, 1, 1.0), (2, 3, 1.0), (4, 2, 1.0)]
    assert card_lines(study.map.team, edges, True, targets, 2) == [
        "Robot 2",
        "(4.90, 3.00) m, \u03b8 0.0\u00b0",
        "v 0.90 m/s, \u03c9 \u22120.20 rad/s",
        "command 1.00 m/s, \u22120.25 rad/s",
        "receives from: 1, 3",
        "sends to: 4",
        "0.50 m from its target",
    ]
    lines = card_lines(study.map.team, edges, False, None, 2)
    assert lines[-1] == "neighbours: 1, 3, 4"
    assert card_lines(study.map.team, edges, True, None, 9) == []
