"""Banners and messages: errors, laws being loaded, saving, edits that a crash has left."""

import functools
import os
import threading
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import quiet_study
from gui_fixtures import shown as active
from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtTest import QTest

from mrs_simulator.rqt_plugin.run.autosave import Autosave
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage
from mrs_simulator.rqt_plugin.widgets.banners import Banners
from mrs_simulator.rqt_plugin.widgets.file_dialog import FileDialog
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.scenario import scenario_from_dict

POSES = [[0, 0, 0], [3, 0, 0]]


@pytest.fixture
def make_study(app, tmp_path, no_predictions):
    """Return a function that makes a GUI with nothing behind it, its edits kept in ``tmp_path``."""
    made = []

    def make():
        edits = Autosave(str(tmp_path / "edits"))
        made.append(quiet_study(scenario_from_dict({"poses": POSES}), autosave=edits))
        return made[-1]

    yield make
    for widget in made:
        widget.study.edited.laws.close()
        widget._errors.close()
        widget.bar.release_keys()
        widget.close()
        widget.deleteLater()
    app.processEvents()


def test_the_heaviest_matter_is_on_top_and_a_strip_goes_with_its_matter(app):
    banners, pressed = Banners(), []
    banners.notify("saving", "aside", "Saving", ("Cancel", lambda: pressed.append(True)))
    banners.notify("emergency", "alarm", "Stopped")
    banners.notify("error", "error", "Wrong")
    banners.notify("timing", "warning", "Late")
    active(banners, 700, 200)
    texts = [banners.column.itemAt(i).widget().text for i in range(banners.column.count())]
    assert texts == ["Stopped", "Wrong", "Late", "Saving"]
    QTest.mouseClick(banners.button("saving", "Cancel"), Qt.LeftButton)
    assert pressed == [True]
    for matter in ("saving", "emergency", "error", "timing", "unknown"):
        banners.clear(matter)
    assert not banners.isVisible() and banners.text("error") == ""
    banners.close()


def test_errors_are_shown_in_a_banner_and_counted_on_the_tab(make_study):
    study = make_study()
    active(study, 1022, 700)
    tabs, index = study.results_tabs, study.results_tabs.indexOf(study.messages)
    study.say("done")
    assert study.banners.text("error") == "" and tabs.tabText(index) == "Messages"
    study.say(ErrorMessage("first"))
    study.say(ErrorMessage("law.py:3: second\nwith <b> a line"))
    assert study.banners.text("error").startswith("law.py:3") and tabs.tabText(index)[-3:] == "(2)"
    QTest.mouseClick(study.banners.button("error", "Messages"), Qt.LeftButton)
    assert tabs.currentWidget() is study.messages and tabs.tabText(index) == "Messages"
    assert "with <b> a line" in study.messages.toPlainText()
    QTest.mouseClick(study.banners.button("error", "Close"), Qt.LeftButton)
    assert not study.banners.isVisible()


def test_an_error_of_the_gui_itself_is_shown_too(make_study):
    study = make_study()
    guarded(lambda: [][1])()
    study.tick()
    assert "IndexError" in study.banners.text("error")


def test_of_a_class_slots_and_handlers_of_events_are_guarded(caplog):
    @guarded
    class Panel:
        def _on_click(self):
            raise KeyError("clicked")

        def leaveEvent(self):
            raise KeyError("left")

        def read(self):
            raise KeyError("read")

    panel = Panel()
    assert panel._on_click() is None and panel.leaveEvent() is None
    assert "clicked" in caplog.text and "left" in caplog.text
    with pytest.raises(KeyError):
        panel.read()


@pytest.mark.parametrize("gives_up", [True, False])
def test_while_a_file_never_finishes_importing_the_emergency_stop_works(
    make_study, tmp_path, gives_up
):
    study = make_study()
    active(study, 1022, 700)
    law, seen = tmp_path / "hangs.py", []
    law.write_text("import time\ntime.sleep(1000.0)")
    study.study.edited.laws.limit = 60.0 if gives_up else 2.0

    def meanwhile():
        if not study.banners.text("law"):
            QTimer.singleShot(20, meanwhile)
            return
        seen.append((study.settings_tabs.isEnabled(), study.banners.text("law")))
        QTest.mouseClick(study.bar.button("emergency"), Qt.LeftButton)
        if gives_up:
            QTest.mouseClick(study.banners.button("law", "Cancel"), Qt.LeftButton)

    QTimer.singleShot(0, meanwhile)
    study.protocol.protocol_chosen.emit(str(law))
    ((enabled, text),) = seen
    assert not enabled and "Loading the protocol" in text
    study.connection.set_emergency.assert_called_once_with(True)
    shown = "cancelled" if gives_up else "hangs.py: no answer within 2 s"
    assert shown in study.banners.text("error") and study.settings_tabs.isEnabled()
    assert study.scenario.control.protocol == "formation" and not study.banners.text("law")


def test_saving_shows_how_far_it_is_and_can_be_cancelled(make_study, monkeypatch, tmp_path):
    study = make_study()
    active(study, 1022, 700)
    study.history.saved, cancelled = 0.0, threading.Event()
    monkeypatch.setattr(study.results, "_nothing_to_save", lambda: False)
    files = study.study.files
    begin = functools.partial(setattr, files, "saving", "run.csv")
    monkeypatch.setattr(files, "saver", lambda *_: begin)
    monkeypatch.setattr(files, "cancel", cancelled.set)
    study.save_results(str(tmp_path))
    assert study.banners.text("saving").startswith("Saving: run.csv, 0 s")
    QTest.mouseClick(study.banners.button("saving", "Cancel"), Qt.LeftButton)
    assert cancelled.is_set()
    study.connection.take_results.return_value = [("save", False, "cancelled")]
    study.tick()
    assert not study.banners.text("saving") and "cancelled" in study.banners.text("error")


def test_a_verdict_that_cannot_be_read_is_said_with_its_file(make_study, tmp_path):
    study, path = make_study(), tmp_path / "verdict.json"
    path.write_text('{"passed": true, "checks": [3]}')
    study.connection.take_results.return_value = [("save", True, str(path))]
    study.tick()
    shown = study.banners.text("error")
    assert "cannot be shown" in shown and str(path) in shown and "checks: 3" in shown
    assert study.results_tabs.currentWidget() is not study.verdict


def test_edits_are_offered_again_after_a_crash_and_not_after_an_end_in_good_order(make_study):
    first = make_study()
    first.tick()
    assert not first.banners.text("edits")
    first.team.set_pose(1, -2.0, 0.0, 0.0)
    first.team.team_changed.emit()
    first.tick()
    assert not make_study().banners.text("edits")  # the first one lives
    first.edits._autosave._file.close()  # as the system does for one that is killed
    second = make_study()
    active(second, 1022, 700)
    assert "ended unexpectedly" in second.banners.text("edits")
    assert second.scenario.poses[0, 0] == 0.0
    QTest.mouseClick(second.banners.button("edits", "Restore"), Qt.LeftButton)
    assert second.scenario.poses[0, 0] == -2.0 and not second.banners.text("edits")
    second.team.set_pose(1, -3.0, 0.0, 0.0)
    second.team.team_changed.emit()
    second.tick()
    second.close_study()
    assert not make_study().banners.text("edits")


def test_edits_that_are_discarded_are_not_offered_again(make_study):
    first = make_study()
    first.team.set_pose(1, -2.0, 0.0, 0.0)
    first.team.team_changed.emit()
    first.tick()
    first.edits._autosave._file.close()
    second = make_study()
    active(second, 1022, 700)
    QTest.mouseClick(second.banners.button("edits", "Discard"), Qt.LeftButton)
    assert second.scenario.poses[0, 0] == 0.0
    assert not make_study().banners.text("edits")


def test_what_a_run_left_does_not_stay_beside_another_team(make_study):
    study = make_study()
    study.verdict.set_verdict(
        dict(title="", final_gaps=None, min_distance=None, passed=True, checks=[], warnings=[])
    )
    cleared = []
    study.history.clear = lambda: cleared.append(True)
    study.team.set_pose(1, -2.0, 0.0, 0.0)
    study.team.team_changed.emit()
    assert study.verdict.verdict is None and "No verdict yet" in study.verdict.title.message
    assert cleared and study.connection.forget.call_args_list[-1][0] == ("state",)


def test_what_a_controller_said_of_its_graph_before_an_edit_does_not_undo_the_edit(make_study):
    study = make_study()

    def says(edges):
        weighted = [edge + (1.0,) for edge in edges]
        status = MagicMock(
            edges=weighted, directed=True, command=[0.0, 0.0], targets=[], trouble=""
        )
        study.connection.newest.side_effect = lambda name: status if name == "control" else None
        study.live.follow_control()
        return [edge[:2] for edge in study.topology.edges()]

    study.connection.is_fresh.side_effect = lambda name: name == "control"
    study.study.processes.is_ending.return_value = False
    assert says([(1, 2)]) == [(1, 2)]
    study.map.edge_added.emit(2, 1)
    both = [(1, 2), (2, 1)]
    assert says([(1, 2)]) == both
    study._on_result("set_topology", True, "2 edges")
    assert says([(1, 2)]) == both  # however long it was under way
    assert says(both) == both
    assert says([(2, 1)]) == [(2, 1)]  # another one has changed it
    study.map.edge_added.emit(1, 2)
    study._on_result("set_topology", False, "no")
    assert says([(2, 1)]) == [(2, 1)]


def test_neither_a_banner_nor_a_mode_moves_the_map(make_study, app):
    study = active(make_study(), 1280, 800)
    shown = study.map

    def places():
        app.processEvents()
        return shown.mapTo(study, shown.rect().topLeft()), shown.size(), shown.frame.area

    before = places()
    study.say(ErrorMessage("wrong " * 80))
    study.bar._stop_all.click()
    assert places() == before
    lie = study.banners.geometry()
    assert lie.topLeft() == before[0] and lie.width() == before[1].width() and lie.height() > 40
    for mode in ("poses", "edges", "obstacles"):
        study.modes[mode].setChecked(True)
        help, hint = study.map_panel.help, study.map_panel.hint
        assert places() == before and hint.isVisible() and help.isVisible() == (mode == "obstacles")
        # The axis below can be read: its labels and its name.
        line = shown.fontMetrics().height()
        assert hint.geometry().bottom() <= shown.height() - 2.5 * line
        assert hint.width() <= shown.frame.area.width() + 1 and hint.height() >= 0.8 * line
        assert hint.testAttribute(Qt.WA_TransparentForMouseEvents)
    study.modes["look"].setChecked(True)
    assert study.map_panel.help.isHidden() and study.map_panel.hint.isHidden()


def test_a_hint_lies_above_the_fields_of_its_mode_however_many_rows_they_have(make_study, app):
    study = active(make_study(), 1000, 768)
    help, hint = study.map_panel.help, study.map_panel.hint
    for width in (1000, 560, 1366, 700, 480, 1366):
        study.resize(width, 768)
        app.processEvents()
        study.modes["look"].setChecked(True)
        study.modes["obstacles"].setChecked(True)
        assert hint.geometry().bottom() < help.geometry().top()
        for wide in (width + 100, width):
            study.resize(wide, 768)
            app.processEvents()
            assert hint.geometry().bottom() < help.geometry().top()
            assert hint.height() >= hint.heightForWidth(hint.width())


def test_the_hint_on_edges_says_what_an_edge_of_this_graph_is(make_study, app):
    study = active(make_study(), 1280, 800)
    study.modes["edges"].setChecked(True)
    for directed, said in ((False, "they become neighbours"), (True, "j receives from i")):
        study.map.show_topology([(1, 2, 1.0)], directed)
        assert said in study.map_panel.hint.text() and said in study.modes["edges"].toolTip()
        assert ("receives" in study.map_panel.hint.text()) == directed


def test_a_file_dialog_is_gone_before_what_was_chosen_is_tried(make_study, app, tmp_path):
    study, seen = active(make_study(), 1280, 800), []
    (tmp_path / "law.py").write_text("")

    def chosen(path):
        dialogs = study.findChildren(FileDialog)
        seen.append((path, [dialog.isVisible() for dialog in dialogs]))

    dialog = FileDialog(study, "Open", str(tmp_path) + os.sep, "Laws (*.py)", chosen)
    assert dialog.isVisible()
    dialog.selectFile(str(tmp_path / "law.py"))
    dialog.accept()
    assert seen == [(str(tmp_path / "law.py"), [False])]


def test_what_a_controller_warns_of_is_in_the_message_bar(make_study, no_hidden_errors):
    study = active(make_study(), 1022, 700)
    study.connection.is_fresh.side_effect = lambda name: name == "control"
    status = dict.fromkeys(("stopped", "stale", "targets", "edges", "command"), ())
    status.update(protocol="Formation", trouble="", period=0.02, overrun=0.0, directed=True)

    def shown(warnings, running=True):
        received = SimpleNamespace(**status, warnings=warnings, running=running)
        study.connection.newest.side_effect = {"control": received}.get
        study.tick()
        return study.banners.text("warnings")

    two = ["robots 1 and 2 hold each other still", "k is high"]
    assert shown(two[:1]) == two[0] and shown(two) == "\n".join(two)
    QTest.mouseClick(study.banners.button("warnings", "Close"), Qt.LeftButton)
    assert not shown(two)  # the same again
    assert shown(two[1:]) == two[1]
    assert not shown(two[1:], running=False)
