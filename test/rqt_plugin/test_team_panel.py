"""The team panel: number, table, spreadsheet, layouts, overlaps; with real keys and clicks."""

import math
import os
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest
from gui_fixtures import shown
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QContextMenuEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractItemView, QApplication, QComboBox, QPushButton, QStyle

from mrs_simulator.rqt_plugin.team import panel as team_panel
from mrs_simulator.rqt_plugin.team.panel import TeamPanel
from mrs_simulator.scenario.team.layouts import make_layout
from mrs_simulator.vehicles import KINDS, kind

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


def shown_panel():
    """Return a shown panel with four robots in a line; ``changes`` counts its signals."""
    widget = TeamPanel()
    widget.changes = []
    widget.set_team(make_layout("line", 4), KINDS[:1] * 4)
    widget.team_changed.connect(lambda: widget.changes.append(widget.poses()))
    return shown(widget, 360, 640)


@pytest.fixture
def panel():
    """Return ``shown_panel()``."""
    widget = shown_panel()
    yield widget
    widget.close()
    widget.deleteLater()


def go_to(panel, robot, column=1):
    """Click the cell of ``robot`` in ``column``."""
    index = panel.model.index(robot - 1, column)
    panel.table.scrollTo(index)
    where = panel.table.visualRect(index).center()
    QTest.mouseClick(panel.table.viewport(), Qt.LeftButton, pos=where)


def edit(panel, robot, column, text, end=Qt.Key_Return):
    """Type ``text`` into a cell."""
    go_to(panel, robot, column)
    QTest.keyClick(panel.table, Qt.Key_F2)
    editor = QApplication.focusWidget()
    editor.selectAll()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, end)
    APP.processEvents()


def paste(panel, robot, text):
    """Paste ``text`` at ``robot``."""
    go_to(panel, robot)
    QApplication.clipboard().setText(text)
    QTest.keyClick(panel.table, Qt.Key_V, Qt.ControlModifier)


def set_number(panel, n):
    """Type the number of robots."""
    panel.number.setFocus()
    panel.number.selectAll()
    QTest.keyClicks(panel.number, str(n))
    QTest.keyClick(panel.number, Qt.Key_Return)


def press(panel, text):
    """Click the button called ``text``."""
    (button,) = [b for b in panel.findChildren(QPushButton) if b.text() == text]
    QTest.mouseClick(button, Qt.LeftButton)


def texts(panel, robot):
    """Return the texts of a row."""
    columns = range(panel.model.columnCount())
    return [panel.model.index(robot - 1, column).data() for column in columns]


def test_more_robots_than_the_window_edits_are_refused_and_not_cut_off(panel):
    before = len(panel.kinds())
    set_number(panel, 1001)
    assert len(panel.kinds()) == before and panel.number.value() == before
    assert panel.message.message == "1001 robots: the window edits at most 1000"


def test_rows_follow_the_number(panel):
    before = panel.poses()
    set_number(panel, 12)
    assert len(panel.changes) == 1
    assert panel.poses().shape == (12, 3) and panel.kinds() == KINDS[:1] * 12
    np.testing.assert_array_equal(panel.poses()[:4], before)
    assert panel.overlapping == set()
    assert panel.model.rowCount() == 12
    set_number(panel, 3)
    assert len(panel.changes) == 2
    np.testing.assert_array_equal(panel.poses(), before[:3])
    set_number(panel, 3)
    assert len(panel.changes) == 2


def test_there_is_room_for_the_largest_team(panel):
    set_number(panel, 200)
    assert len(panel.poses()) == 200 and panel.overlapping == set()
    set_number(panel, 1)
    assert len(panel.poses()) == 1


def test_without_room_the_number_returns(panel, monkeypatch):
    monkeypatch.setattr(team_panel, "ROOM", (0.1, 0.0))
    panel.set_team([[0.0, 0.0, 0.0]], KINDS[:1])
    set_number(panel, 5)
    assert "no room for robot 2 of 5" in panel.message.message
    assert panel.number.value() == 1 and len(panel.poses()) == 1 and panel.changes == []


@pytest.mark.parametrize(
    "column, text, value",
    [(1, "-3.25", -3.25), (2, "1e-3", 1e-3), (3, "90", math.pi / 2), (1, "1e6", 1e6)],
)
def test_a_cell_is_edited(panel, column, text, value):
    wanted = panel.poses()
    wanted[1, column - 1] = value
    edit(panel, 2, column, text)
    np.testing.assert_allclose(panel.poses(), wanted, rtol=0, atol=1e-15)
    assert len(panel.changes) == 1 and panel.message.message == ""


@pytest.mark.parametrize("text", ["abc", "nan", "inf", "1e7", "1,5", "x" * 200])
def test_what_is_no_position_is_refused(panel, text):
    before = panel.poses()
    edit(panel, 2, 1, text)
    np.testing.assert_array_equal(panel.poses(), before)
    message = panel.message.message
    assert message.startswith("robot2, x [m]: '" + text[:20]) and "wanted a number" in message
    assert len(message) < 100
    assert panel.changes == []
    assert texts(panel, 2)[1] == "1"
    edit(panel, 2, 1, "1.5")
    assert panel.message.message == ""


def test_opening_a_cell_changes_nothing(panel):
    panel.set_pose(2, 1.0 / 3.0, 0.0, 1.0)
    before = panel.poses()
    for column in (1, 3):
        go_to(panel, 2, column)
        QTest.keyClick(panel.table, Qt.Key_F2)
        QTest.keyClick(QApplication.focusWidget(), Qt.Key_Return)
        APP.processEvents()
    np.testing.assert_array_equal(panel.poses(), before)
    assert panel.changes == []


def test_numbers_are_short_in_the_table(panel):
    panel.set_pose(1, -123456.789, 1.0 / 3.0, math.radians(-0.001))
    assert texts(panel, 1) == ["1", "-123457", "0.3333", "0"]
    panel.set_pose(1, 1e6, -100.0, math.pi)
    assert texts(panel, 1) == ["1", "1000000", "-100", "180"]


def test_paste_from_a_spreadsheet(panel):
    paste(panel, 2, "5\t-6\t90\r\n7\t8\t-45\r\n")
    np.testing.assert_allclose(
        panel.poses()[1:3], [[5, -6, math.pi / 2], [7, 8, -math.pi / 4]], atol=1e-15
    )
    assert len(panel.changes) == 1
    before = panel.poses()
    paste(panel, 2, "1, 2")
    np.testing.assert_array_equal(panel.poses()[1], [1.0, 2.0, before[1, 2]])
    np.testing.assert_array_equal(panel.poses()[2:], before[2:])


def test_paste_grows_the_team(panel):
    paste(panel, 1, "\n".join("{},{}".format(2 * i, 1) for i in range(7)))
    assert len(panel.poses()) == 7 and panel.number.value() == 7
    np.testing.assert_array_equal(panel.poses()[6], [12.0, 1.0, 0.0])
    assert panel.kinds() == KINDS[:1] * 7
    assert len(panel.changes) == 1


@pytest.mark.parametrize(
    "robot, text, message",
    [
        (1, "", "the clipboard is empty"),
        (1, "x\ty\n1\t2", "pasted row 1, x [m]: 'x', wanted a number"),
        (1, "1\t2\n3", "pasted row 2: 1 values, wanted x [m], y [m]"),
        (1, "1\t2\n\n3\t4", "pasted row 2: 0 values"),
        (1, "\t2\t3", "pasted row 1, x [m]: ''"),
        (1, "1,2,3,4", "pasted row 1: 4 values"),
        (1, "1,5\t2", "'1,5'"),
        (3, "1\t2\n3\t4\n5\t6", "to get more robots paste at robot1"),
        (1, "0,0\n" * 1001, "1001 rows pasted, wanted at most 1000"),
    ],
)
def test_a_paste_is_taken_whole_or_not_at_all(panel, robot, text, message):
    before = panel.poses()
    paste(panel, robot, text)
    assert message in panel.message.message
    np.testing.assert_array_equal(panel.poses(), before)
    assert panel.changes == []


def test_copy_and_paste_keep_the_poses(panel):
    poses = make_layout("random", 4, seed=3)
    panel.set_team(poses, KINDS[:1] * 4)
    go_to(panel, 1)
    QTest.keyClick(panel.table, Qt.Key_A, Qt.ControlModifier)
    QTest.keyClick(panel.table, Qt.Key_C, Qt.ControlModifier)
    text = QApplication.clipboard().text()
    assert len(text.splitlines()) == 4 and all(len(r.split("\t")) == 3 for r in text.splitlines())
    panel.set_team(np.zeros((1, 3)), KINDS[:1])
    paste(panel, 1, text)
    np.testing.assert_allclose(panel.poses(), poses, atol=1e-9)


def test_copy_takes_the_selected_rows(panel):
    go_to(panel, 3)
    QTest.keyClick(panel.table, Qt.Key_C, Qt.ControlModifier)
    assert QApplication.clipboard().text() == "-1\t0\t0"


def test_copy_and_paste_from_the_menu(panel):
    copy, paste_here = panel.table.actions()
    go_to(panel, 1)
    copy.trigger()
    assert QApplication.clipboard().text() == "3\t0\t0"
    QApplication.clipboard().setText("9\t9")
    paste_here.trigger()
    assert texts(panel, 1) == ["1", "9", "9", "0"]


def test_numbers_that_are_none_can_be_shown(panel):
    panel.set_pose(1, math.nan, math.inf, 0.0)
    assert texts(panel, 1) == ["1", "nan", "inf", "0"]


def test_layouts(panel):
    names = [panel.layouts.names.itemText(i) for i in range(panel.layouts.names.count())]
    assert names == ["line", "circle", "grid", "random"]
    for name in names[1:]:
        panel.layouts.names.setFocus()
        QTest.keyClick(panel.layouts.names, Qt.Key_Down)
        assert panel.layouts.names.currentText() == name
        press(panel, "Apply")
        np.testing.assert_array_equal(panel.poses(), make_layout(name, 4))
    assert len(panel.changes) == 3
    press(panel, "Apply")
    assert len(panel.changes) == 3, "the same layout again is no change"


def test_a_layouts_parameters(panel):
    panel.layouts.names.setCurrentText("random")
    for name, text in (("size", "1e2"), ("seed", "7")):
        (field,) = [f for f in panel.layouts.form.children() if f.objectName() == name]
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
    press(panel, "Apply")
    np.testing.assert_array_equal(panel.poses(), make_layout("random", 4, seed=7, size=100.0))
    (size,) = [f for f in panel.layouts.form.children() if f.objectName() == "size"]
    size.setFocus()
    size.selectAll()
    QTest.keyClicks(size, "-1")
    press(panel, "Apply")
    assert len(panel.changes) == 1
    size.setFocus()
    size.selectAll()
    QTest.keyClicks(size, "0.1")
    press(panel, "Apply")
    assert "no room" in panel.message.message and len(panel.changes) == 1
    panel.layouts.names.setCurrentText("line")
    panel.layouts.names.setCurrentText("random")
    assert panel.layouts.form.values() == {"min_distance": 1.5, "size": 0.1, "seed": 7}


def test_overlaps_are_marked_and_named(panel):
    edit(panel, 3, 1, "1.1")
    assert panel.overlapping == {2, 3}
    assert panel.overlaps.message == "robot2 and robot3 overlap"
    model = panel.model
    assert model.index(1, 0).data(Qt.ToolTipRole) == "robot2 overlaps robot3"
    assert model.index(2, 2).data(Qt.ToolTipRole) == "robot3 overlaps robot2"
    red = model.index(2, 1).data(Qt.BackgroundRole).color()
    assert red.red() > 2 * red.green()
    assert model.index(0, 1).data(Qt.BackgroundRole) is None
    edit(panel, 3, 1, "-1")
    assert panel.overlapping == set() and panel.overlaps.message == ""
    assert not panel.overlaps.isVisible()


def test_many_overlaps_stay_readable(panel):
    panel.set_team(np.zeros((200, 3)), KINDS[:1] * 200)
    assert panel.overlapping == set(range(1, 201))
    assert panel.overlaps.message == (
        "robot1 and robot2, robot1 and robot3, robot1 and robot4 overlap, and 19897 more pairs"
    )
    tip = panel.model.index(0, 0).data(Qt.ToolTipRole)
    assert tip.endswith("and robot7 and 193 more")


def test_a_robot_is_dragged(panel):
    panel.set_pose(2, 3.2, 0.1, -math.pi / 2)
    np.testing.assert_array_equal(panel.poses()[1], [3.2, 0.1, -math.pi / 2])
    assert texts(panel, 2) == ["2", "3.2", "0.1", "-90"]
    assert panel.overlapping == {1, 2}
    panel.set_pose(2, 30.0, 0.0, 0.0)
    assert panel.overlapping == set() and panel.changes == []
    for number in (0, 5):
        with pytest.raises(ValueError, match="wanted 1 to 4"):
            panel.set_pose(number, 0.0, 0.0, 0.0)


def test_set_team_sends_nothing_and_keeps_its_own_copy(panel):
    poses = make_layout("grid", 9)
    panel.set_team(poses, KINDS[:1] * 9)
    poses[:] = 7.0
    panel.poses()[:] = 8.0
    np.testing.assert_array_equal(panel.poses(), make_layout("grid", 9))
    assert panel.number.value() == 9 and panel.changes == []
    with pytest.raises(ValueError, match="wanted as many kinds as poses"):
        panel.set_team(poses, KINDS[:1])


def test_a_team_larger_than_the_box_allows_is_shown_whole(panel):
    panel.set_team(make_layout("grid", 300), KINDS[:1] * 300)
    assert panel.number.value() == 300 and len(panel.poses()) == 300 and panel.changes == []
    panel.set_team(np.empty((0, 3)), ())
    assert panel.poses().shape == (0, 3) and panel.overlapping == set()
    set_number(panel, 2)
    assert len(panel.poses()) == 2


def test_nothing_changes_while_not_editable(panel):
    before = panel.poses()
    panel.set_editable(False)
    paste(panel, 1, "5,5")
    go_to(panel, 1)
    QTest.keyClick(panel.table, Qt.Key_F2)
    QTest.keyClicks(panel.table, "5")
    assert panel.table.state() != QAbstractItemView.EditingState
    press(panel, "Apply")
    set_number(panel, 9)
    np.testing.assert_array_equal(panel.poses(), before)
    assert panel.changes == []
    QTest.keyClick(panel.table, Qt.Key_C, Qt.ControlModifier)
    assert QApplication.clipboard().text() == "3\t0\t0"
    panel.set_editable(True)
    edit(panel, 1, 1, "4")
    assert len(panel.changes) == 1


def test_scenario_buttons_only_ask(panel):
    asked = []
    panel.open_requested.connect(lambda: asked.append("open"))
    panel.save_requested.connect(lambda: asked.append("save"))
    press(panel, "Open scenario...")
    press(panel, "Save scenario...")
    assert asked == ["open", "save"] and panel.changes == []


def choose_kind(panel, name):
    index = panel.kind.findData(name)
    panel.kind.setCurrentIndex(index)
    panel.kind.activated.emit(index)


def test_a_kind_is_chosen_for_all_for_a_group_and_for_a_row(panel):
    choose_kind(panel, "robotino3")
    assert panel.kinds() == ("robotino3",) * 4 and panel.model.columnCount() == 4
    panel.table.selectRow(2)
    choose_kind(panel, "husky")
    assert panel.kinds() == ("robotino3", "robotino3", "husky", "robotino3")
    assert panel.model.columnCount() == 5 and len(panel.changes) == 2
    panel.table.clearSelection()
    assert panel.kind.currentText() == "several kinds"
    go_to(panel, 1, 4)
    QTest.keyClick(panel.table, Qt.Key_F2)
    (editor,) = panel.table.viewport().findChildren(QComboBox)
    assert set(KINDS) <= {editor.itemText(place) for place in range(editor.count())}
    editor.setCurrentText("epuck")
    panel.table.setFocus()
    assert panel.kinds() == ("epuck", "robotino3", "husky", "robotino3")
    panel.table.clearSelection()
    choose_kind(panel, KINDS[0])
    assert panel.kinds() == KINDS[:1] * 4 and panel.model.columnCount() == 4
    choose_kind(panel, KINDS[0])  # nothing new
    assert len(panel.changes) == 4


def test_robots_overlap_as_their_own_bodies_do(panel):
    panel.set_team([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]], ("epuck", "epuck"))
    assert panel.overlapping == set()
    panel.set_team([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]], ("husky", "epuck"))
    assert panel.overlapping == {1, 2}


def test_a_layout_is_signalled_so_that_it_can_be_fitted_into_view(panel):
    arranged = []
    panel.arranged.connect(lambda: arranged.append(panel.poses()))
    press(panel, "Apply")
    assert len(arranged) == 1


def test_a_kind_in_a_file_is_offered_by_its_short_name_and_stays_offered(panel, tmp_path):
    own = tmp_path / "mine.yaml"
    own.write_text("base: husky")
    panel.set_team([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], (str(own), "husky"))
    assert [texts(panel, robot)[4] for robot in (1, 2)] == ["mine.yaml", "husky"]
    panel.kind.setCurrentIndex(panel.kind.findData("epuck"))
    panel.kind.activated.emit(panel.kind.currentIndex())
    assert panel.kinds() == ("epuck", "epuck") and panel.kind.findData(str(own)) >= 0
    panel.set_team([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], ("epuck", "husky"))
    index = panel.model.index(1, 4)
    editor = panel.table.itemDelegateForColumn(4).createEditor(panel.table, None, index)
    editor.setCurrentText("mine.yaml")
    panel.table.itemDelegateForColumn(4).setModelData(editor, panel.model, index)
    assert panel.kinds() == ("epuck", str(own))


def test_one_kind_needs_no_column(panel):
    assert panel.model.columnCount() == 4


@pytest.mark.parametrize("poses", [make_layout("grid", 200), make_layout("circle", 200)])
def test_dragging_is_quick_with_the_largest_team(panel, poses):
    panel.set_team(poses, KINDS[:1] * 200)
    taken = []
    for step in range(50):
        begin = time.process_time()  # a busy machine's other work is no matter
        panel.set_pose(100, 0.1 * step, 0.0, 0.0)
        taken.append(time.process_time() - begin)
    assert np.median(taken) < 5e-3


MIXED = ("pioneer3dx", "robotino3", "turtlebot3_burger", "husky")


@pytest.mark.parametrize("n, width", [(7, 440), (100, 440), (100, 480), (7, 1000)])
def test_every_text_of_the_table_is_whole_where_robots_are_of_several_kinds(panel, n, width):
    panel.resize(width, 640)
    poses = make_layout("random", n, seed=1, min_distance=1.0, size=30.0)
    panel.set_team(poses, (MIXED * n)[:n])
    table, model = panel.table, panel.model
    columns = range(model.columnCount())
    metrics, sizes = table.fontMetrics(), [table.columnWidth(column) for column in columns]
    assert len(sizes) == 5 and sum(sizes) <= table.viewport().width()
    for row in range(n):
        wide = [metrics.horizontalAdvance(text) for text in texts(panel, row + 1)]
        wide[0] += table.style().pixelMetric(QStyle.PM_SmallIconSize)  # its colour
        assert all(need < size for need, size in zip(wide, sizes)), texts(panel, row + 1)
    assert any("." in cell for cell in texts(panel, 1)[1:3])


def test_where_there_is_no_room_the_table_scrolls_rather_than_cut_off_what_it_says(panel):
    panel.set_team(make_layout("random", 7, seed=1, size=30.0), (MIXED * 2)[:7])
    before = panel.poses()
    panel.resize(200, 640)
    table = panel.table
    assert table.horizontalScrollBar().maximum() > 0
    advance = table.fontMetrics().horizontalAdvance("turtlebot3_burger")
    assert table.columnWidth(4) > advance and texts(panel, 1)[4] == "pioneer3dx"
    np.testing.assert_array_equal(panel.poses(), before)  # decimals are only not shown


def test_the_panel_fits_a_narrow_column(panel):
    panel.layouts.names.setCurrentText("random")
    panel.set_team(make_layout("grid", 200), KINDS[:1] * 200)
    assert panel.minimumSizeHint().width() <= 360
    table = panel.table
    for column in range(panel.model.columnCount()):
        lines = panel.model.headerData(column, Qt.Horizontal).splitlines() + ["-123456"]
        if column == 0:
            lines = lines[:1]
        needed = max(table.fontMetrics().horizontalAdvance(line) for line in lines)
        assert table.columnWidth(column) > needed


def test_kinds_of_the_scenarios_own_are_shown_and_offered(panel):
    own = {"wide": {"base": "epuck", "title": "A wide one", "body": {"radius": 1.5}}}
    panel.set_kinds(lambda name: kind(name, own=own), own)
    panel.set_team([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], ("epuck", "wide"))
    assert panel.overlapping == {1, 2}
    place = panel.kind.findData("wide")
    assert place >= 0 and panel.kind.itemData(place, Qt.ToolTipRole) == "A wide one"
    assert "wide" in panel.model.kind_choices


def test_the_height_of_those_who_fly_is_set_for_all_or_for_those_selected(panel):
    assert not panel.altitude_field.isVisible() and panel.altitude() is None
    kinds = ("crazyflie2", "crazyflie2", "pioneer3dx")
    panel.set_team(make_layout("line", 3), kinds, [1.0, 2.0, 3.0])
    assert (
        panel.altitude_field.isVisible()
        and panel.altitude_field.text() == "several initial heights"
    )
    assert panel.altitude().tolist() == [1.0, 2.0, 0.0]  # what does not fly stands on the ground
    panel.altitude_field.setValue(1.5)
    assert panel.altitude().tolist() == [1.5, 1.5, 0.0] and len(panel.changes) == 1
    go_to(panel, 2)
    panel.altitude_field.setValue(0.5)
    assert panel.altitude().tolist() == [1.5, 0.5, 0.0] and len(panel.changes) == 2
    panel.number.setValue(2)
    panel.number.setValue(4)
    assert panel.altitude().tolist() == [1.5, 0.5, 0.5, 0.5]
    edit(panel, 1, 1, "-3")
    assert panel.altitude().tolist() == [1.5, 0.5, 0.5, 0.5]


def test_robots_above_each_other_do_not_overlap(panel):
    panel.set_team(np.zeros((2, 3)), ("crazyflie2",) * 2, [1.0, 2.0])
    assert panel.overlapping == set()
    panel.altitude_field.setValue(1.0)
    assert panel.overlapping == {1, 2}


def test_a_team_that_is_locked_says_why_in_a_line_and_in_tooltips(panel):
    panel.set_editable(False, "stop it: press End")
    assert panel.locked.isVisible() and panel.locked.message == "Stop it: press End"
    assert "Not now: stop it: press End" in panel.table.toolTip()
    panel.set_editable(True)
    assert not panel.locked.isVisible() and panel.table.toolTip() == ""


def menu_of(panel):
    """Open the table's menu; return its entries by text."""
    place = panel.table.rect().center()
    QApplication.sendEvent(
        panel.table.viewport(), QContextMenuEvent(QContextMenuEvent.Mouse, place)
    )
    return {entry.text().split("\t")[0]: entry for entry in panel.table.menu.actions()}


def test_the_tables_menu_copies_selects_arranges_and_follows(panel):
    asked = []
    panel.follow_asked.connect(asked.append)
    go_to(panel, 2)
    entries = menu_of(panel)
    assert not entries["Align: same x"].isEnabled() and entries["Copy"].isEnabled()
    entries["Follow in the 3D view"].trigger()
    assert asked == [2]
    entries["Select all"].trigger()
    entries = menu_of(panel)
    assert not entries["Follow in the 3D view"].isEnabled()
    before = panel.poses()
    entries["Align: same x"].trigger()
    assert (panel.poses()[:, 0] == before[:, 0].mean()).all() and len(panel.changes) == 1
    panel.set_editable(False, "locked")
    entries = menu_of(panel)
    assert not entries["Align: same y"].isEnabled() and not entries["Paste"].isEnabled()
    panel.table.menu.close()
