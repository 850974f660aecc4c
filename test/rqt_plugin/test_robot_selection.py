"""Several robots selected, moved and arranged on the map, and its ruler."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import shown
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.rqt_plugin.map.arranging import aligned, distributed, parallel, snapped
from mrs_simulator.rqt_plugin.map.view import MapView

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")
POSES = np.array([[0.0, 0.0, 0.0], [4.0, 0.2, 1.0], [1.1, 3.0, 2.0], [8.0, 3.0, -1.0]])


def view_in(mode):
    view = MapView()
    view.show_team(POSES)
    view.set_mode(mode)
    return shown(view, 600, 500)


def at(view, x, y):
    return QPoint(*(int(round(part)) for part in view.to_screen(x, y)))


def drag(view, begin, end, held=Qt.NoModifier, later=None):
    QTest.mousePress(view, Qt.LeftButton, held, begin)
    held = held if later is None else later
    place = QPointF(end), QPointF(view.mapToGlobal(end))
    APP.sendEvent(view, QMouseEvent(QEvent.MouseMove, *place, Qt.NoButton, Qt.LeftButton, held))
    QTest.mouseRelease(view, Qt.LeftButton, held, end)


def test_arrangements_change_what_they_name_and_nothing_else():
    assert aligned(POSES, 0)[:, 0] == pytest.approx(np.full(4, 3.275))
    assert (aligned(POSES, 0)[:, 1:] == POSES[:, 1:]).all()
    assert distributed(POSES, 0)[:, 0] == pytest.approx([0.0, 16.0 / 3.0, 8.0 / 3.0, 8.0])
    assert snapped(POSES)[1] == pytest.approx([4.0, 0.0, 1.0])
    assert (parallel(POSES) == np.column_stack([POSES[:, :2], np.zeros(4)])).all()


def test_a_band_selects_robots_that_then_move_together_as_one_edit():
    view, edits = view_in("poses"), []
    view.poses_edited.connect(edits.append)
    drag(view, at(view, -0.5, -0.5), at(view, 4.6, 0.8), Qt.ShiftModifier)
    assert view.chosen.numbers == {1, 2}
    drag(view, at(view, 0.0, 0.0), at(view, 0.0, 1.5))
    moved = edits[-1] - POSES
    assert len(edits) == 1 and moved[0] == pytest.approx([0.0, 1.5, 0.0], abs=0.05)
    assert moved[1] == pytest.approx(moved[0]) and not moved[2:].any()
    QTest.mouseClick(view, Qt.LeftButton, Qt.ControlModifier, at(view, 8.0, 3.0))
    assert view.chosen.numbers == {1, 2, 4}
    QTest.keyClick(view, Qt.Key_Escape)
    assert not view.chosen.numbers
    view.close()


def test_with_ctrl_a_drag_ends_on_the_grid():
    view, edits = view_in("poses"), []
    view.pose_edited.connect(lambda *pose: edits.append(pose))
    drag(view, at(view, 4.0, 0.2), at(view, 5.4, 1.1), later=Qt.ControlModifier)
    assert edits[-1] == (2, 5.5, 1.0, 1.0)
    view.close()


def test_the_ruler_measures_between_robots_and_follows_them():
    view = view_in("measure")
    drag(view, at(view, 0.0, 0.0), at(view, 8.0, 3.0))
    assert view.ruler.text().startswith("8.544 m\nx +8.000 m, y +3.000 m, 20.6")
    view.show_team(POSES * [1, 2, 1])
    assert view.ruler.text().startswith("10.000 m")
    view.grab()
    view.close()
