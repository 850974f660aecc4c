"""Nothing of the GUI's frame is cut off: wide, at half a screen, in a narrow dock."""

import os
from unittest.mock import MagicMock, call

import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import PREDICTS, quiet_study, wait_shown
from gui_fixtures import shown as active
from PyQt5.QtCore import QEvent, QPoint, QPointF, QRect, QSize, Qt
from PyQt5.QtGui import QKeySequence, QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QApplication,
    QDockWidget,
    QLabel,
    QLineEdit,
    QMainWindow,
    QShortcut,
    QSizePolicy,
    QWidget,
)
from ros_fixtures import wait_until
from snapshots import snapshot_of

from mrs_simulator.rqt_plugin.run.bar import ACTIONS, FOLDED, RunBar
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.widgets.file_dialog import FileDialog
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.shipped import shipped_scenarios

POSES = [[0, 0, 0], [3, 0, 0]]
BOX = {"type": "box", "center": [9.0, 9.0], "size": [2.0, 1.0]}
FLOCK = {"poses": POSES, "control": {"protocol": "flocking"}}


@pytest.fixture(scope="module")
def app():
    return QApplication.instance() or QApplication([])


@pytest.fixture
def study(app, no_predictions):
    """The whole GUI with nothing behind it."""
    widget = quiet_study(scenario_from_dict({"poses": POSES}))
    yield widget
    widget.close()
    widget.deleteLater()
    app.processEvents()


def shown(app, widget, width, height):
    widget.resize(width, height)
    widget.show()
    app.processEvents()
    return widget


def place(widget, within):
    """Return the rectangle of ``widget`` in the pixels of ``within``."""
    return QRect(widget.mapTo(within, widget.rect().topLeft()), widget.size())


@pytest.mark.parametrize("width", [320, 480, 683, 1022, 1366, 3840])
def test_no_button_is_cut_off_and_the_emergency_stop_has_the_corner(app, width):
    owner = QWidget()
    bar = RunBar(owner)
    shown(app, bar, width, 36)  # styles have their sizes once they are shown
    bar.show_singly(width > 683)
    shown(app, bar, width, bar.heightForWidth(width))
    names = {name for name, *_ in ACTIONS}
    seen = {name for name in names if bar.button(name).isVisible()}
    in_menu = [entry for entry in bar.more.menu().actions() if entry.isVisible()]
    assert len(seen) + len(in_menu) == len(names)
    assert seen >= names.difference(FOLDED) and (width < 3840 or seen == names)
    buttons = [bar.button(name) for name in ("emergency", "speed", *seen)]
    buttons += [bar.more] if in_menu else []
    assert bar.more.isVisible() == bool(in_menu)
    places = [place(button, bar) for button in buttons]
    assert bar.width() == width
    for button, rect in zip(buttons, places):
        assert button.isVisible() and bar.rect().contains(rect)
        assert rect.width() >= button.sizeHint().width()
    for i, rect in enumerate(places):
        assert not any(rect.intersects(other) for other in places[:i])
    assert places[0].right() >= width - 4 and places[0].top() <= 8
    bar.close()


def test_what_would_take_another_line_is_in_the_menu_and_its_key_works(app):
    owner = QWidget()
    bar = RunBar(owner)
    asked = []
    bar.asked.connect(asked.append)
    shown(app, bar, 2000, 36)
    line = bar.heightForWidth(2000)
    assert bar.button("step").isVisible() and bar.button("end").isVisible()
    shown(app, bar, 720, 36)
    assert bar.heightForWidth(720) == line and bar.button("save").isVisible()
    entries = {entry.text().split("\t")[0]: entry for entry in bar.more.menu().actions()}
    assert not bar.button("step").isVisible() and entries["Step"].isVisible()
    entries["Step"].trigger()
    bar.button("step").click()  # what its key does
    assert asked == ["step", "step"]
    bar.set_enabled("step", False, "it runs")
    bar.set_recording(True)
    assert not entries["Step"].isEnabled() and entries["Record bag"].text() == "End bag\tCtrl+B"
    bar.close()


@pytest.mark.parametrize("size", [(480, 640), (683, 700), (1366, 700)])
def test_the_emergency_stop_is_seen_in_the_whole_gui_however_narrow(app, study, size):
    shown(app, study, *size)
    assert study.size() == QSize(*size)  # no part of it asks for more
    stop = study.bar.button("emergency")
    assert not stop.visibleRegion().isEmpty()
    assert stop.visibleRegion().boundingRect() == stop.rect()
    assert study.rect().contains(place(stop, study))


@pytest.mark.parametrize("size", [(480, 800), (1366, 768)])
def test_no_banner_and_no_verdict_makes_the_window_grow(app, study, size):
    shown(app, study, *size)
    for matter, kind in (("a", "alarm"), ("b", "error"), ("c", "warning")):
        study.banners.notify(matter, kind, "so much is wrong that it takes several lines " * 3)
    study.verdict.set_verdict(
        {
            "title": "run",
            "passed": False,
            "checks": [],
            "warnings": ["long " * 60] * 3,
            "final_gaps": None,
            "min_distance": None,
        }
    )
    study.results_tabs.setCurrentWidget(study.verdict)
    app.processEvents()
    assert study.size() == QSize(*size)
    strips = study.banners.findChildren(QLabel)
    assert len(strips) == 3
    for strip in strips:  # whole, in as many lines as the width makes of it
        assert strip.height() >= strip.heightForWidth(strip.width())


def test_a_narrow_window_has_one_column_with_the_settings_below_the_map(app, study):
    shown(app, study, 1180, 720)
    assert study.settings_tabs.count() == 4 and study.settings_tabs.isVisible()
    results = study.results_tabs.count()
    study.results_tabs.setCurrentWidget(study.messages)
    study.resize(480, 720)
    wait_shown(lambda: study.results_tabs.count() > results)
    titles = [study.results_tabs.tabText(place) for place in range(study.results_tabs.count())]
    assert titles[:5] == ["Team", "Protocol", "Topology", "Runs", "Curves"]
    assert (
        "Robot" in titles and "Sensors" not in titles
    )  # all that is known of one, not these alone
    assert study.results_tabs.currentWidget() is study.messages
    assert not study.settings_tabs.isVisible()
    study.results_tabs.setCurrentIndex(0)
    wait_shown(lambda: study.team.isVisible() and study.map.width() > 400)
    study.resize(1180, 720)
    wait_shown(lambda: study.settings_tabs.count() == 4 and study.team.isVisible())
    assert study.results_tabs.tabText(0) == "Curves"
    assert study.results_tabs.count() == results


@pytest.fixture
def saving(study, no_hidden_errors, monkeypatch):
    """The GUI and its dialog that asks where results go; ``study.saved``: what was answered."""
    study.saved = []
    monkeypatch.setattr(study.results, "_nothing_to_save", lambda: False)
    files = study.study.files
    monkeypatch.setattr(files, "saver", lambda _, to, *more: lambda: study.saved.append(to))
    active(study, 1022, 700)
    study.bar.button("save").setEnabled(True)
    QTest.mouseClick(study.bar.button("save"), Qt.LeftButton)
    (dialog,) = study.findChildren(FileDialog)
    dialog.activateWindow()
    assert QTest.qWaitForWindowActive(dialog)
    return study, dialog


def window_click(widget):
    """Click on ``widget`` through its window, as the mouse does: a modal dialog would keep it."""
    window = widget.window()
    place = widget.mapTo(window, widget.rect().center())
    QTest.mouseClick(window.windowHandle(), Qt.LeftButton, Qt.NoModifier, QPoint(place))


def test_the_emergency_stop_works_while_a_file_dialog_is_open(saving):
    study, dialog = saving
    window_click(study.bar.button("emergency"))
    study.connection.set_emergency.assert_called_once_with(True)
    window_click(study.bar.button("emergency"))
    study.connection.set_emergency.reset_mock()
    dialog.activateWindow()
    assert QTest.qWaitForWindowActive(dialog)
    QTest.keyClick(dialog.windowHandle(), Qt.Key_F8)
    study.connection.set_emergency.assert_called_once_with(True)
    study.connection.set_emergency.reset_mock()
    QTest.keyPress(dialog, Qt.Key_Escape)  # the release would come to what is gone
    study.connection.set_emergency.assert_not_called()
    assert study.saved == [] and not any(d.isVisible() for d in study.findChildren(FileDialog))


def test_the_file_chosen_is_taken_and_one_that_exists_after_a_question(saving, tmp_path):
    study, dialog = saving
    (tmp_path / "old").write_text("kept")
    name = dialog.findChild(QLineEdit)
    name.setText(str(tmp_path / "old"))
    dialog.accept()
    assert dialog.isVisible() and dialog.labelText(dialog.Accept) == "Replace"
    assert "old exists" in dialog.windowTitle()
    name.setText(str(tmp_path / "older"))
    assert dialog.labelText(dialog.Accept) == "Save" and "exists" not in dialog.windowTitle()
    name.setText(str(tmp_path / "old"))
    dialog.accept()
    dialog.accept()
    assert study.saved == [str(tmp_path / "old")] and not dialog.isVisible()


def test_the_dialog_for_scenarios_offers_those_that_ship(app, study):
    shown(app, study, 1022, 700)
    study.files.ask_to_open()
    (dialog,) = study.findChildren(FileDialog)
    places = [url.toLocalFile() for url in dialog.sidebarUrls()]
    assert shipped_scenarios() in places and os.path.isfile(places[-1] + "/paper.yaml")
    dialog.close()


def test_another_scenario_is_brought_into_view_without_what_was_before(app, study):
    shown(app, study, 1022, 700)
    study.map.show_targets(np.array([[-300.0, 0.0], [300.0, 0.0]]))
    study.editing.take(scenario_from_dict({"poses": [[0, k, 0] for k in range(4)]}))
    low, high = study.map.frame.bounds()
    assert (high - low).max() < 30.0


def test_a_scenario_chosen_while_a_controller_runs_is_not_opened(app, study, tmp_path):
    shown(app, study, 1022, 700)
    study.files.ask_to_open()
    study.study.is_controlled = lambda: True
    (dialog,) = study.findChildren(FileDialog)
    dialog.fileSelected.emit(str(tmp_path / "none.yaml"))
    assert "not opened: stop the controller" in study.messages.toPlainText()


def test_files_open_where_the_gui_was_started_and_then_where_the_last_one_was(app, tmp_path, study):
    def directory():
        (dialog,) = [d for d in study.findChildren(FileDialog) if d.isVisible()]
        place = dialog.directory().absolutePath()
        return place, dialog

    study.files.directory = str(tmp_path)
    study.files.ask_to_open()
    place, dialog = directory()
    assert place == str(tmp_path)
    (tmp_path / "deeper").mkdir()
    dialog.fileSelected.emit(str(tmp_path / "deeper" / "none.yaml"))
    dialog.close()
    study.files.ask_to_save()
    assert directory()[0] == str(tmp_path / "deeper")
    assert StudyWidget.sizeHint(study).width() >= 1000


def stops(study):
    """Return how often the emergency stop was pressed; it is then released."""
    pressed = study.connection.set_emergency.call_args_list.count(call(True))
    study.connection.set_emergency.reset_mock()
    study.bar.set_emergency(False)
    return pressed


def settings_field(study, tab, name):
    study.settings_tabs.setCurrentIndex(tab)
    widget = study.findChild(QWidget, name) if isinstance(name, str) else name
    QApplication.processEvents()  # a new one is shown then
    widget.setFocus()
    widget.selectAll()
    assert widget.hasFocus()
    return widget


def test_escape_gives_up_what_is_being_typed_and_stops_nothing(study):
    for tab, name, typed in ((1, "k", "0.3"), (1, "seed", "5"), (0, study.team.number, "3")):
        study.editing.take(scenario_from_dict(FLOCK if name == "seed" else {"poses": POSES}))
        widget = settings_field(active(study, 1366, 768), tab, name)
        before = widget.text()
        QTest.keyClicks(widget, typed)
        assert widget.text() == typed
        QTest.keyClick(widget, Qt.Key_F8)  # from everywhere
        assert stops(study) == 1 and widget.text() == typed
        QTest.keyClick(widget, Qt.Key_Escape)
        assert stops(study) == 0 and widget.text() == before
        QTest.keyClick(widget, Qt.Key_Escape)
        assert stops(study) == 0


def test_escape_gives_up_an_edge_that_is_being_drawn(study):
    view = active(study, 1366, 768).map
    view.set_mode("edges")
    view.setFocus()
    begin = QPoint(*map(round, view.to_screen(0.0, 0.0)))
    QTest.mousePress(view, Qt.LeftButton, Qt.NoModifier, begin)
    QTest.keyClick(view, Qt.Key_Escape)
    assert stops(study) == 0 and view.drag is None


def test_the_stop_key_works_from_the_start_in_any_dock_and_behind_another_tab(app, study):
    window, other, dock = QMainWindow(), QLineEdit(), QDockWidget()
    window.setCentralWidget(other)
    dock.setWidget(study)
    window.addDockWidget(Qt.RightDockWidgetArea, dock)
    active(window, 1022, 700)
    other.setFocus()
    study.tick()
    QTest.keyClick(other, Qt.Key_F8)
    assert stops(study) == 1
    dock.hide()
    QTest.keyClick(other, Qt.Key_F8)
    assert stops(study) == 1
    dock.show()
    dock.setFloating(True)
    study.tick()
    QTest.keyClick(other, Qt.Key_F8)
    assert stops(study) == 1
    study.close_study()
    QTest.keyClick(other, Qt.Key_F8)
    assert stops(study) == 0
    study.setParent(None)
    window.close()


def test_while_the_emergency_stop_is_latched_a_red_bar_says_how_to_release_it(study):
    active(study, 1022, 700)
    assert not study.banners.isVisible()
    QTest.keyClick(study, Qt.Key_F8)
    assert "RELEASE STOP" in study.banners.text("emergency") and study.banners.isVisible()
    strip = study.banners.grab().toImage()
    assert strip.pixelColor(4, strip.height() // 2).name() == "#c00000"
    QTest.keyClick(study, Qt.Key_F8)  # never releases
    assert stops(study) == 1
    study.tick()
    assert not study.banners.isVisible()


def test_no_key_is_one_for_editing_nor_given_twice(study):
    keys = [shortcut.key() for shortcut in study.findChildren(QShortcut)]
    assert len({key.toString() for key in keys}) == len(keys) > len(ACTIONS)
    editing = [
        getattr(QKeySequence, name)
        for name in dir(QKeySequence)
        if name.startswith(("Delete", "Insert", "Move", "Select"))
        or name in ("Cut", "Copy", "Paste")
    ]
    taken = [key for action in editing for key in QKeySequence.keyBindings(action)]
    assert QKeySequence("Ctrl+Backspace") in taken
    assert not [key.toString() for key in keys if key in taken]


def test_keys_undo_and_redo_every_edit(study):
    active(study, 1366, 768).setFocus()
    obstacles = scenario_from_dict({"poses": POSES, "obstacles": [BOX]}).obstacles

    def team(poses, kinds):
        study.team.set_team(np.array(poses, dtype=float), kinds)
        study.team.team_changed.emit()

    edits = {
        "pose": lambda: study.map.pose_edited.emit(1, 0.5, 1.0, 0.25),
        "kind": lambda: team(POSES, ["amigobot", "pioneer3dx"]),
        "parameter": lambda: study.protocol.parameters_changed.emit(
            dict(study.study.edited.derived.values, k=0.01)
        ),
        "edge": lambda: study.topology.topology_changed.emit([(1, 2, 1.0)], True),
        "obstacle": lambda: study.map.obstacles_edited.emit(obstacles),
        "robots": lambda: team([*POSES, [6, 0, 0]], ["pioneer3dx"] * 3),
    }
    before = study.scenario.to_yaml()
    for edit in edits.values():
        edit()
        after = study.scenario.to_yaml()
        assert after != before
        QTest.keyClick(study, Qt.Key_Z, Qt.ControlModifier)
        assert study.scenario.to_yaml() == before and len(study.team.poses()) == 2
        assert study.team.poses()[0].tolist() == [0.0, 0.0, 0.0]
        QTest.keyClick(study, Qt.Key_Z, Qt.ControlModifier)  # there is no more
        QTest.keyClick(study, Qt.Key_Z, Qt.ControlModifier | Qt.ShiftModifier)
        assert study.scenario.to_yaml() == after
        QTest.keyClick(study, Qt.Key_Z, Qt.ControlModifier)


def test_a_field_that_is_being_edited_undoes_its_own_text(study):
    active(study, 1366, 768)
    study.map.pose_edited.emit(1, 0.5, 1.0, 0.25)
    edited, field = study.scenario, study.curves.findChildren(QLineEdit)[0]
    field.setFocus()
    QTest.keyClicks(field, "1")
    QTest.keyClick(field, Qt.Key_Z, Qt.ControlModifier)
    assert field.text() == "" and study.scenario is edited


def test_keys_choose_the_next_speed(study):
    active(study, 1366, 768).setFocus()
    study.bar.set_speed(3.0)  # not in the list
    speeds = []
    study.bar.speed_chosen.connect(speeds.append)
    study.bar.set_enabled("speed", True)
    for key in (Qt.Key_Plus, Qt.Key_Equal, Qt.Key_Minus, Qt.Key_Minus):
        QTest.keyClick(study, key, Qt.ControlModifier)
    assert speeds == [5.0, 10.0, 5.0, 3.0]
    study.bar.set_speed(20.0)
    for _ in range(2):
        QTest.keyClick(study, Qt.Key_Plus, Qt.ControlModifier)
    assert speeds[4:] == [0.0]  # as fast as possible, and no faster
    study.bar.set_enabled("speed", False)
    QTest.keyClick(study, Qt.Key_Minus, Qt.ControlModifier)
    assert speeds[5:] == []


def test_a_long_trouble_in_the_status_does_not_widen_the_window(app, study):
    before = study.minimumSizeHint().width()
    study.status["controller"].setText("no fresh odometry of " + "robot1, " * 200)
    assert study.minimumSizeHint().width() == before


def test_a_map_that_paints_slowly_gets_fewer_snapshots(app, study):
    poses = np.zeros((2, 3))
    poses[1, 0] = 3.0

    def received(time):
        flags = np.ones(2, dtype=bool)
        study.connection.snapshot.return_value = snapshot_of(
            time, (1, 2), poses, np.zeros((2, 3)), np.zeros((2, 2)), flags
        )
        study._on_frame()
        return study.map.time

    assert received(1.0) == 1.0
    study.map.cost = 1e4  # [s]
    assert received(2.0) == 1.0
    study.map.cost = study.map.spent = 0.0
    assert received(3.0) == 3.0


def test_a_robot_put_elsewhere_stays_there_until_the_stage_has_taken_it_over(study, monkeypatch):
    def reported(time, x):
        pose = np.array([[x, 0.0, 0.0], [3.0, 0.0, 0.0]])
        zeros = np.zeros((2, 3)), np.zeros((2, 2)), np.ones(2, dtype=bool)
        study.connection.snapshot.return_value = snapshot_of(time, (1, 2), pose, *zeros)
        study.map.cost = study.map.spent = 0.0
        study._on_frame()
        return study.map.team.pose[0, 0]

    monkeypatch.setattr("mrs_simulator.rqt_plugin.window.pending.TEAM_REST", 0.0)
    study.connection.is_fresh.side_effect = lambda name: name == "state"
    view = active(study, 1366, 768).map
    assert reported(1.0, 0.1) == 0.1
    view.set_mode("poses")
    places = [QPoint(*map(round, view.to_screen(x, 0.0))) for x in (0.1, 1.0, 1.1)]
    QTest.mousePress(view, Qt.LeftButton, Qt.NoModifier, places[0])
    for place_ in places[1:]:
        held = QEvent.MouseMove, QPointF(place_), Qt.NoButton, Qt.LeftButton, Qt.NoModifier
        QApplication.sendEvent(view, QMouseEvent(*held))
    moved = study.team.poses()[0, 0]
    assert moved > 0.9 and reported(1.1, 0.1) == moved
    QTest.mouseRelease(view, Qt.LeftButton, Qt.NoModifier, places[-1])
    study.tick()
    assert study.connection.set_team.call_args[0][0][0, 0] == moved
    assert reported(1.2, 0.1) == moved
    study.connection.take_results.return_value = [("set_team", False, "no room")]
    study.tick()
    assert reported(1.3, 0.1) == 0.1  # where it is, whatever was wanted


@PREDICTS
def test_theory_is_drawn_once_it_is_computed_and_that_of_another_team_is_not(study):
    def theory():
        study.tick()
        return study.curves.source.theory

    assert wait_until(theory)
    study.team.set_pose(1, -2.0, 0.0, 0.0)
    study.team.team_changed.emit()
    assert study.curves.source.theory is None
    assert wait_until(theory)[1][0] > 0.0


def test_the_maps_buttons_hide_what_they_name_and_show_it_again(study):
    for what in ("trails", "targets", "edges", "numbers", "sensors"):
        button, first = study.shown[what], dict(study.map.shown)
        assert button.isChecked() == first[what] == (what != "sensors")
        for shown_ in (not first[what], first[what]):
            button.click()
            assert study.map.shown == dict(first, **{what: shown_})


def boxes(app, layout, width):
    """Return the places of labels of 60 by 20 pixels, three of them about a gap, and a corner."""
    box = QWidget()
    flow = FlowLayout(box)
    flow.setSpacing(10)
    labels = [QLabel() for _ in range(5)]
    for label in labels:
        label.setFixedSize(60, 20)
    labels[1].setFixedSize(2, 20)
    for label, add in zip(labels, layout):
        getattr(flow, add)(label)
    box.resize(width, flow.heightForWidth(width))
    box.show()
    app.processEvents()
    result = [(label.x(), label.y()) if label.width() else None for label in labels]
    box.close()
    return result, flow.heightForWidth(width)


FLOW = ("addWidget", "add_gap", "addWidget", "addWidget", "add_corner")


@pytest.mark.parametrize(
    "width, places, height",
    [
        (400, [(0, 0), (70, 0), (82, 0), (152, 0), (340, 0)], 20),
        (212, [(0, 0), (70, 0), (82, 0), (0, 30), (152, 0)], 50),
        # A gap neither ends nor begins a line.
        (150, [(0, 0), None, (0, 30), (70, 30), (90, 0)], 50),
    ],
)
def test_lines_break_where_the_width_ends(app, width, places, height):
    found, needed = boxes(app, FLOW, width)
    if places[1] is None:
        assert found[1] is None or found[1] == (0, 0)
        found[1] = None
    assert (found, needed) == (places, height)


def test_a_widget_that_may_be_cut_off_does_not_ask_for_width(app):
    box = QWidget()
    flow = FlowLayout(box)
    label = QLabel("many words " * 50)
    label.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
    flow.addWidget(label)
    box.resize(200, 40)
    box.show()
    app.processEvents()
    assert box.minimumSizeHint().width() == 0 and label.width() == 200
    box.close()


def type_duration(study, text, key=Qt.Key_Return):
    field = study.bar.duration
    field.setFocus()
    field.selectAll()
    QTest.keyClick(field, Qt.Key_Delete)
    QTest.keyClicks(field, text)
    QTest.keyClick(field, key)
    study.status_line.show_possible()
    return field


def test_a_typed_duration_is_that_of_the_scenario_and_undone(app, study):
    active(study, 1022, 700)
    study.status_line.show_possible()
    typed = {"20": 20, "7.5 s": 7.5, "1.5min": 90, "0.05 h": 180, "0.02": 0.02}
    for text, seconds in typed.items():
        field, before = type_duration(study, text), 60.0
        assert study.scenario.duration == seconds
        assert field.text() == "{:g} s".format(seconds)
        assert "duration: {}\n".format(float(seconds)) in study.save_settings()["scenario"]
        study.bar.undo_asked.emit()
        study.status_line.show_possible()
        assert study.scenario.duration == before and field.text() == "60 s"
        study.bar.redo_asked.emit()
        assert study.scenario.duration == seconds
        study.bar.undo_asked.emit()


BETWEEN = "wanted a number from 0.02 to 100000 [s]"
SECONDS = "wanted a number of seconds, such as 20, 1.5 min or 1 h"
REFUSED = {"1,5": "with a point in place of the comma", "long": SECONDS, "": SECONDS}
REFUSED.update(dict.fromkeys(("0", "0.01", "30 h", "nan"), BETWEEN))


def test_a_refused_duration_is_said_and_nothing_starts(app, study):
    active(study, 1022, 700)
    study.status_line.show_possible()
    for text, why in REFUSED.items():
        assert not study.banners.text("error")
        field = type_duration(study, text)
        assert study.scenario.duration == 60.0 and why in study.banners.text("error")
        assert field.text() == text and why in field.toolTip()
        study.whole.begin = MagicMock(return_value="")
        study.bar.asked.emit("run")
        assert not study.whole.begin.called and why in study.banners.text("error")
        field.setFocus()
        QTest.keyClick(field, Qt.Key_Escape)
        assert field.text() == "60 s" and not field.why
        study.bar.asked.emit("run")
        assert study.whole.begin.called


def test_a_duration_is_shown_as_it_is_in_force_but_while_it_is_typed(app, study):
    active(study, 1022, 700)
    for duration, text in ((60.0, "60 s"), (7.5, "7.5 s"), (123.4567, "123.4567 s")):
        study.editing.take(study.scenario._replace(duration=duration))
        study.status_line.show_possible()
        field = study.bar.duration
        assert field.text() == text
        assert field.width() > field.fontMetrics().horizontalAdvance(text)
    field = study.bar.duration
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "4")
    study.status_line.show_possible()
    assert field.text() == "4"
    study.bar.button("run").setEnabled(True)
    study.whole.begin = MagicMock(side_effect=lambda speed: str(study.scenario.duration))
    study.bar.asked.emit("run")  # takes over what is typed
    assert study.messages.toPlainText().rstrip().endswith("4.0")
