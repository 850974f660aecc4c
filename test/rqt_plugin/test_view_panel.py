"""The 3D view shows what the map shows, answers the mouse, and costs nothing while hidden."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QWheelEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.map.ghosts import Ghost
from mrs_simulator.rqt_plugin.map.view import MapView
from mrs_simulator.rqt_plugin.view.panel import ViewPanel

APP = QApplication.instance() or QApplication([])
POSES = np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 1.0), (4.0, 1.0, 2.0)])


def snapshot(time, poses):
    n = len(poses)
    twist = np.zeros((n, 3))
    return snapshot_of(time, tuple(range(1, n + 1)), poses, twist, twist[:, :2], np.ones(n, bool))


@pytest.fixture()
def shown():
    team = MapView()
    team.show_team(POSES)
    panel = ViewPanel(team.scene, lambda: team.revision)
    panel.resize(600, 400)
    panel.show()
    panel.refresh()
    yield team, panel
    panel.close()
    team.close()


def place_on_screen(panel, row):
    canvas = panel.canvas
    from mrs_simulator.pictures.camera import on_screen

    place = canvas.scene.place[row : row + 1]
    return on_screen(canvas.camera.seen(place), canvas.width(), canvas.height())[0]


def test_it_shows_the_maps_team_trails_targets_and_graph(shown):
    team, panel = shown
    team.show_topology([(1, 2, 1.0), (2, 3, 1.0)])
    team.show_targets(POSES[:, :2] + 1.0)
    for step in range(4):
        team.show_snapshot(snapshot(step * 1.0, POSES + (0.5 * step, 0.0, 0.0)))
    scene = team.scene()
    assert scene.state.robots == (1, 2, 3) and scene.edges == [(0, 1, 1.0), (1, 2, 1.0)]
    assert np.allclose(scene.state.pose, POSES + (1.5, 0.0, 0.0))
    assert np.allclose(scene.trails[0][[0, -1], 0], (0.0, 1.5)) and scene.targets.shape == (3, 3)
    team.set_trail_shown(2, False)
    team.set_shown("targets", False)
    team.set_shown("edges", False)
    scene = team.scene()
    assert [len(trail) > 0 for trail in scene.trails] == [True, False, True]
    assert scene.targets is None and not len(scene.edges)
    team.set_shown("trails", False)
    assert not any(len(trail) for trail in team.scene().trails)


def test_the_colours_are_those_of_the_map(shown):
    team, panel = shown
    image = panel.grab().toImage()
    x, y = place_on_screen(panel, 1)
    corner = panel.canvas.geometry().topLeft()
    wanted = np.array(team.scene().shades[1])
    near = [
        image.pixelColor(int(x) + corner.x() + dx, int(y) + corner.y() + dy).getRgbF()[:3]
        for dx in range(-12, 13)
        for dy in range(-14, 6)
    ]
    # Somewhere on the robot its colour, lit: the same direction of colour.
    angles = [np.dot(each, wanted) / np.linalg.norm(each) / np.linalg.norm(wanted) for each in near]
    assert max(angles) > 0.98


def test_the_whole_team_stays_in_view_until_the_mouse_says_otherwise(shown):
    team, panel = shown
    far = POSES + (30.0, 20.0, 0.0) * np.array([[0.0], [0.0], [1.0]])
    team.show_snapshot(snapshot(1.0, far))
    panel.next = 0.0
    panel.refresh()
    at = np.array([place_on_screen(panel, row) for row in range(3)])
    size = np.array([panel.canvas.width(), panel.canvas.height()])
    assert ((at > 0.0) & (at < size)).all()
    before = panel.canvas.camera
    QTest.mousePress(panel.canvas, Qt.LeftButton, Qt.NoModifier, QPoint(100, 100))
    QTest.mouseMove(panel.canvas, QPoint(150, 120))
    QTest.mouseRelease(panel.canvas, Qt.LeftButton, Qt.NoModifier, QPoint(150, 120))
    wheel(panel.canvas, 120)
    assert panel.canvas.camera.distance < before.distance
    team.show_snapshot(snapshot(2.0, far + (300.0, 0.0, 0.0)))
    panel.next = 0.0
    panel.refresh()
    assert panel.canvas.camera.target == pytest.approx(before.target)
    QTest.keyClick(panel, Qt.Key_F)
    assert panel.canvas.camera.target[0] > 150.0  # trails are in view, too


def wheel(widget, angle):
    at = QPointF(widget.rect().center())
    turned = QPoint(0, angle)
    event = QWheelEvent(
        at, at, QPoint(), turned, Qt.NoButton, Qt.NoModifier, Qt.NoScrollPhase, False
    )
    APP.sendEvent(widget, event)


def test_the_first_view_is_from_where_the_team_fills_it():
    team = MapView()
    team.show_team([(0.0, y, 0.0) for y in (0.0, 4.0, 8.0, 12.0)])  # in depth, seen from the south
    panel = ViewPanel(team.scene, lambda: team.revision)
    panel.resize(600, 400)
    panel.refresh()
    first = panel.canvas.camera
    assert abs(first.yaw - 20.0) > 10.0
    panel.canvas.camera = first._replace(yaw=20.0)
    panel.canvas.fit()
    assert panel.canvas.camera.yaw == 20.0 and panel.canvas.camera.distance > first.distance


def test_an_untouched_view_comes_nearer_to_a_team_that_draws_together(shown):
    team, panel = shown
    wide = POSES * (5.0, 5.0, 1.0)
    team.show_team(wide)
    panel.next = 0.0
    panel.refresh()
    before, middle = panel.canvas.camera, wide.mean(axis=0) * (1.0, 1.0, 0.0)
    for share, is_nearer in ((0.9, False), (0.2, True)):
        team.show_snapshot(snapshot(2.0 - share, middle + share * (wide - middle)))
        panel.next = 0.0
        panel.refresh()
        assert (panel.canvas.camera.distance < 0.6 * before.distance) == is_nearer


def test_a_robot_is_followed(shown):
    team, panel = shown
    panel.followed.setCurrentIndex(3)
    panel.followed.activated.emit(3)
    assert panel.canvas.camera.target == pytest.approx((4.0, 1.0, 0.0))
    team.show_snapshot(snapshot(1.0, POSES + (0.0, 5.0, 0.0)))
    panel.next = 0.0
    panel.refresh()
    assert panel.canvas.camera.target == pytest.approx((4.0, 6.0, 0.0))


def test_nothing_is_drawn_while_it_is_hidden_or_nothing_changes(shown):
    team, panel = shown
    shown_before = panel._shown
    assert panel.timer.isActive()
    panel.refresh()
    assert panel._shown == shown_before
    panel.hide()
    assert not panel.timer.isActive()


def test_no_robots_and_robots_unknown_are_no_trouble(shown):
    team, panel = shown
    team.show_team(np.zeros((0, 3)))
    panel.next = 0.0
    panel.refresh()
    panel.grab()
    team.show_snapshot(snapshot(1.0, np.full((2, 3), np.nan)))
    panel.next = 0.0
    panel.refresh()
    panel.grab()
    assert panel.canvas.scene.state.robots == (1, 2)


def test_top_looks_straight_down_and_back(shown):
    _, panel = shown
    before = panel.canvas.camera
    QTest.keyClick(panel, Qt.Key_T)
    down = panel.canvas.camera
    assert down.pitch == -89.0 and down.yaw == 0.0
    first, second = place_on_screen(panel, 0), place_on_screen(panel, 1)
    assert second[0] > first[0] and abs(second[1] - first[1]) < 2.0  # east is to the right
    panel.above.click()
    assert panel.canvas.camera[2:] == before[2:]


def test_compared_runs_and_theorys_paths_are_ghosts_of_the_3d_view(shown):
    team, panel = shown
    other = MapView()
    other.show_team(POSES + (0.0, 3.0, 0.0))
    trails = tuple(np.array([(x, y), (x + 1.0, y)]) for x, y in POSES[:, :2])
    team.show_ghosts([Ghost("other", 1, other.team_scene(), other.team.shapes, trails)], "own")
    paths = np.stack([POSES[:, :2], POSES[:, :2] + 2.0])
    paths[:, 1] = np.nan
    team.show_forecast(paths)
    compared, theory = team.scene().ghosts
    assert np.allclose(compared.place[:, 1], POSES[:, 1] + 3.0) and len(compared.paths) == 3
    assert theory.ringed and not theory.kinds and len(theory.paths) == 2  # of two it knows
    assert np.allclose(theory.paths[1][-1], (6.0, 3.0, 0.0))
    panel.next = 0.0
    panel.refresh()
    panel.grab()
    team.set_shown("trails", False)
    team.set_shown("forecast", False)
    (compared,) = team.scene().ghosts
    assert not compared.paths
