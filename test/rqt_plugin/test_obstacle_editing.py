"""Obstacles edited on the map with mouse and keys: as they are drawn, taken up, refused and undone."""

import os

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QContextMenuEvent, QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.rqt_plugin.map import obstacle_shapes as shapes
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box, Cylinder

BOX = {"type": "box", "name": "crate", "center": [0.0, 3.0], "size": [2.0, 1.0]}
POOL = {"type": "land", "name": "shore", "center": [0.0, -4.0], "size": [4.0, 2.0]}
POSES = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
SHIFT, NONE = Qt.ShiftModifier, Qt.NoModifier


@pytest.fixture
def study(app, no_hidden_errors, no_predictions):
    """The GUI with nothing behind it, in the mode for obstacles, a pixel being 4 cm."""
    widget = quiet_study(
        scenario_from_dict({"poses": POSES, "obstacles": [BOX, POOL], "limits": "none"})
    )
    widget.resize(1366, 768)
    widget.show()
    widget.modes["obstacles"].setChecked(True)
    app.processEvents()
    widget.map.frame.scale, widget.map.frame.centre = 25.0, np.zeros(2)
    # Round places lie on pixels.
    widget.map.frame.centre -= widget.map.to_plane(*map(round, widget.map.to_screen(0.0, 0.0)))
    widget.map.untouched = False
    yield widget
    widget.study.edited.close()
    widget.close()
    widget.deleteLater()
    app.processEvents()


def at(study, x, y):
    return QPoint(*(int(round(value)) for value in study.map.to_screen(x, y)))


def drag(study, begin, end, modifier=NONE, release=True):
    view, (begin, end) = study.map, (at(study, *place) for place in (begin, end))
    QTest.mousePress(view, Qt.LeftButton, modifier, begin)
    for share in (0.3, 0.7, 1.0):
        place = QPointF(begin + (end - begin) * share)
        whole = QPointF(view.mapToGlobal(place.toPoint()))
        QApplication.sendEvent(
            view, QMouseEvent(QEvent.MouseMove, place, whole, Qt.NoButton, Qt.LeftButton, modifier)
        )
    if release:
        QTest.mouseRelease(view, Qt.LeftButton, modifier, end)


def key(study, code, modifier=NONE):
    QTest.keyClick(study.map, code, modifier)


def named(study):
    return {obstacle.name: obstacle for obstacle in study.scenario.obstacles}


def lock(study):
    study.connection.is_fresh.side_effect = lambda name: name == "stage"


# Shapes


def test_a_side_that_is_drawn_leaves_the_opposite_one_where_it_is():
    box = Box("a", 1.0, 2.0, np.pi / 6, 4.0, 2.0, 0.5)
    axis = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    behind = np.array([1.0, 2.0]) - 2.0 * axis
    longer = shapes.dragged(box, "ahead", behind + 5.0 * axis + [-0.2, 0.2 * 3**0.5], 0.1, 0.1)
    assert (longer.length, longer.width) == (pytest.approx(5.0), 2.0)
    assert [longer.x, longer.y] == pytest.approx(behind + 2.5 * axis)
    corner = shapes.dragged(box._replace(yaw=0.0), "behind left", [-2.0, 4.0], 0.5, 0.1)
    assert corner == Box("a", 0.5, 2.5, 0.0, 5.0, 3.0, 0.5)
    assert shapes.dragged(box, "ahead", behind - axis, 0.1, 0.1) is None  # nothing would be left


def test_thin_walls_are_moved_by_their_middle_and_not_resized():
    wall = Box("wall", 0.0, 0.0, 0.0, 5.0, 0.1, 0.5)
    assert set(shapes.handles(wall, 0.12)) == {"ahead", "behind", "turn"}
    assert set(shapes.handles(wall, 0.01)) == {*shapes.SIDES, "turn"}
    assert shapes.handles(Cylinder("post", 0.0, 0.0, 0.1, 0.5), 0.12) == {}


# The mouse


def test_what_is_drawn_is_in_the_scenario_and_in_the_file(study, tmp_path):
    drag(study, (-4.0, 1.0), (-3.0, 3.0))
    drag(study, (5.0, 2.0), (5.6, 2.0), SHIFT)
    drawn = {
        "box1": Box("box1", -3.5, 2.0, 0.0, 1.0, 2.0, 0.5),
        "cylinder1": Cylinder("cylinder1", 5.0, 2.0, pytest.approx(0.6), 0.5),
    }
    held = named(study)
    assert {name: held[name] for name in drawn} == drawn and len(held) == 4
    study.save_scenario(str(tmp_path / "mine.yaml"))
    saved = load_scenario(str(tmp_path / "mine.yaml"))
    assert saved.obstacles == study.scenario.obstacles
    study.map_panel.obstacles.shapes["cylinder"].click()
    drag(study, (-5.0, 4.0), (-4.5, 4.0))
    assert "cylinder2" in named(study)


def test_an_obstacle_is_moved_resized_and_turned_by_its_marks(study):
    drag(study, (0.3, 3.0), (-1.7, 2.5))
    assert named(study)["crate"][1:3] == (-2.0, 2.5)
    drag(study, (-1.0, 2.5), (0.0, 2.5))
    assert named(study)["crate"] == Box("crate", -1.5, 2.5, 0.0, 3.0, 1.0, 0.5)
    turn = shapes.handles(named(study)["crate"], study.map.reach)["turn"]
    drag(study, turn, (-1.5, 4.5), SHIFT)
    assert named(study)["crate"].yaw == pytest.approx(np.pi / 2)
    assert study.map_panel.obstacles.fields["yaw"].text() == "90"


def test_one_that_moves_keeps_its_track(study):
    track = {"to": [[5.0, 3.0]], "speed": 0.5}
    study.editing.take(scenario_from_dict({"poses": POSES, "obstacles": [dict(BOX, track=track)]}))
    drag(study, (0.2, 3.0), (0.2, 4.0))
    crate = named(study)["crate"]
    assert crate[1:3] == (0.0, 4.0) and crate.track.to == ((5.0, 3.0),)


def test_land_stays_land(study):
    drag(study, (0.5, -4.0), (0.5, -3.0))
    shore = named(study)["shore"]
    assert (shore.y, shore.height) == (-3.0, 0.0)
    fields = study.map_panel.obstacles.fields
    assert fields["width"].isEnabled() and not fields["height"].isEnabled()


def test_one_that_overlaps_a_robot_is_refused_as_the_simulation_would(study):
    before = study.scenario.obstacles
    drag(study, (0.0, 3.0), (3.0, 0.0))
    assert study.scenario.obstacles == before and study.map.editor.current == before[0]
    assert "robot2 overlaps obstacle crate; wanted them apart" in study.messages.toPlainText()
    drag(study, (0.0, 3.0), (3.0, 0.0), release=False)
    assert study.map.team.touches(study.map.editor.draft)
    key(study, Qt.Key_Escape)
    assert study.map.editor.draft is None and study.scenario.obstacles == before


def test_the_map_stays_where_it_is_whatever_is_selected(app, study):
    places = []
    for name in ("", "crate", "shore"):
        study.map.editor.select(name)
        app.processEvents()
        places.append((study.map.geometry(), study.map.to_screen(0.0, 0.0)))
    assert places[0] == places[1] == places[2]


def test_walls_of_a_map_are_not_edited(app, study, tmp_path):
    (tmp_path / "walls.map").write_text(
        "2D-Map\nNumLines: 1\nLINES\n-2000 2000 2000 2000\n", encoding="utf-8"
    )
    study.editing.take(
        scenario_from_dict({"poses": POSES, "map": {"file": str(tmp_path / "walls.map")}})
    )
    assert study.map.editor.at((0.0, 2.0), 0.1) is None and len(study.map.obstacles) == 1
    drag(study, (-1.0, 3.0), (-0.4, 3.4))
    assert list(named(study)) == ["box1"] and len(study.map.obstacles) == 2
    drag(study, (0.0, 2.0), (0.0, 1.5))
    assert study.map.obstacles[-1].y == 2.0
    assert [each.to_plain()["file"] for each in [study.scenario.map]] == [
        str(tmp_path / "walls.map")
    ]


def test_the_menu_deletes_and_duplicates(study):
    place = at(study, 0.0, 3.0)
    event = QContextMenuEvent(QContextMenuEvent.Mouse, place, study.map.mapToGlobal(place))
    QApplication.sendEvent(study.map, event)
    actions = {action.text(): action for action in study.map.keys.menu.actions()}
    study.map.keys.menu.close()
    actions["Duplicate"].trigger()
    assert named(study)["box1"] == named(study)["crate"]._replace(name="box1", x=0.5)
    study.map.editor.select("crate")
    study.map.editor.delete()
    assert set(named(study)) == {"shore", "box1"}


# Keys


def test_keys_do_all_that_the_mouse_does(study):
    key(study, Qt.Key_B)
    placed = named(study)["box1"]
    assert (placed.length, placed.width) == (1.0, 1.0) and not study.map.team.touches(placed)
    key(study, Qt.Key_Left)
    key(study, Qt.Key_Up, SHIFT)
    key(study, Qt.Key_Plus)
    key(study, Qt.Key_R)
    after = named(study)["box1"]
    assert after[1:3] == pytest.approx((placed.x - 0.1, placed.y + 0.01))
    assert after[3:6] == pytest.approx((np.radians(15.0), 1.1, 1.1))
    key(study, Qt.Key_PageDown)
    assert study.map.editor.selected == "crate"
    key(study, Qt.Key_Delete)
    assert set(named(study)) == {"shore", "box1"}
    key(study, Qt.Key_C)
    assert "cylinder1" in named(study)


def test_undo_and_redo_go_back_and_forth_and_end_with_another_scenario(study):
    first, fields = study.scenario.obstacles, study.map_panel.obstacles
    assert not fields.buttons["undo"].isEnabled()
    drag(study, (0.3, 3.0), (-1.7, 2.5))
    study.map.editor.delete()
    states = [first, (first[0]._replace(x=-2.0, y=2.5), first[1]), (first[1],)]
    for steps in ((-1, 1), (-1, 0)):
        key(study, Qt.Key_Z, Qt.ControlModifier)
        assert study.scenario.obstacles == states[steps[1]]
    key(study, Qt.Key_Z, Qt.ControlModifier)  # there is no more
    assert study.scenario.obstacles == first and not fields.buttons["undo"].isEnabled()
    key(study, Qt.Key_Z, Qt.ControlModifier | SHIFT)
    fields.buttons["redo"].click()
    assert study.scenario.obstacles == states[2] and not fields.buttons["redo"].isEnabled()
    key(study, Qt.Key_Z, Qt.ControlModifier)
    study.map.editor.select("shore")
    study.map.editor.delete()  # another edit: what was taken back is gone
    assert not fields.buttons["redo"].isEnabled()
    study.editing.take(study.scenario)
    assert not fields.buttons["undo"].isEnabled()


# Numbers


def test_numbers_are_typed_and_wrong_ones_refused(study):
    study.map.editor.select("crate")
    for name, text, value, said in (
        ("x", "-1.25", -1.25, ""),
        ("yaw", "30", np.radians(30.0), ""),
        ("length", "two", 2.0, "length of crate: 'two', wanted a number"),
        ("width", "-1", 1.0, "width of crate: '-1', wanted a number above 0"),
        ("height", "0", 0.5, "height of crate: '0', wanted a number above 0"),
    ):
        field = study.map_panel.obstacles.fields[{"length": "size"}.get(name, name)]
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key_Return)
        assert getattr(named(study)["crate"], name) == pytest.approx(value)
        assert said in study.messages.toPlainText()
        shown = np.degrees(value) if name == "yaw" else value
        assert float(field.text()) == pytest.approx(shown)


# When


def test_nothing_is_edited_while_the_simulation_runs(study):
    lock(study)
    study.status_line.show_possible()
    button = study.modes["obstacles"]
    assert not button.isEnabled() and study.map.mode == "look"
    assert "at its start: end it" in button.toolTip()
    before = study.scenario.obstacles
    study.map.editor.select("crate")
    study.map.editor.delete()
    assert study.scenario.obstacles == before
    assert "end it to change them" in study.messages.toPlainText()


def test_a_controller_that_stands_ends_as_it_has_the_old_obstacles(study):
    study.study.processes.is_running.side_effect = lambda name: name == "control"
    study.connection.newest.return_value = False
    study.map.editor.select("crate")
    study.map.editor.delete()
    study.study.processes.stop.assert_called_once_with("control")
    assert "start it with the new obstacles" in study.messages.toPlainText()
