"""The window around the study widget, on screens of any size."""

import argparse
import logging
import os

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from gui_fixtures import wait_shown
from PyQt5.QtCore import QSettings, QSize
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QApplication, QWidget

from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen
from mrs_simulator.rqt_plugin.window.main_window import SIZE, Window, scenario_of_run


class Study(QWidget):
    def save_settings(self):
        return {}

    def close_study(self):
        pass


@pytest.fixture(scope="module")
def app():
    return QApplication.instance() or QApplication([])


@pytest.fixture
def settings(tmp_path):
    return QSettings(str(tmp_path / "settings.ini"), QSettings.IniFormat)


def opened(app, settings):
    window = Window(Study(), settings)
    window.show()
    app.processEvents()
    return window


def test_the_window_is_on_its_screen_however_large_it_was(app, settings, caplog):
    room = QGuiApplication.primaryScreen().availableGeometry()
    assert room.width() < SIZE[0]  # the screen of Qt's platform offscreen
    first = opened(app, settings)
    assert room.contains(first.frameGeometry()) and first.frameGeometry().width() == room.width()
    first.setGeometry(room.width() - 200, 300, 3000, 2000)
    first.close()
    second = opened(app, settings)
    assert room.contains(second.frameGeometry())
    second.close()
    assert [record for record in caplog.records if record.levelno >= logging.ERROR] == []


def test_a_window_that_fits_stays_where_it_was(app, settings):
    first = opened(app, settings)
    first.setGeometry(50, 60, 500, 400)
    first.close()
    second = opened(app, settings)
    assert second.geometry().getRect() == (50, 60, 500, 400)
    second.close()


def test_a_run_is_opened_with_the_scenario_beside_it_and_other_names_are_scenarios(tmp_path):
    run, alone, bag = tmp_path / "run", tmp_path / "alone", tmp_path / "a.bag"
    for folder in (run, alone):
        folder.mkdir()
        (folder / "run.csv").write_text("")
    (run / "scenario.yaml").write_text("")
    bag.write_bytes(b"")
    with_scenario = str(run), str(run / "scenario.yaml")
    assert scenario_of_run(str(run)) == scenario_of_run(str(run / "run.csv")) == with_scenario
    assert scenario_of_run(str(alone)) == (str(alone), "")
    assert scenario_of_run(str(bag)) == (str(bag), "")
    sweep = tmp_path / "sweep"
    sweep.mkdir()
    (sweep / "sweep.csv").write_text("")
    assert scenario_of_run(str(sweep)) == (str(sweep), "")
    for name in ("", "paper", str(run / "scenario.yaml")):
        assert scenario_of_run(name) == ("", name)
    for name in (str(tmp_path), str(tmp_path / "none" / "run.csv")):
        with pytest.raises(ValueError, match="no run: wanted a folder with a run.csv"):
            scenario_of_run(name)


def test_the_value_of_an_option_of_qt_is_no_run(monkeypatch):
    pytest.importorskip("rospy")
    from mrs_simulator.rqt_plugin import standalone

    parser = argparse.ArgumentParser()
    parser.add_argument("run", nargs="?", default="")
    for words, wanted in (
        (["-style", "fusion"], ("", ["-style", "fusion"])),
        (["results"], ("results", [])),
        (["results", "-style", "fusion"], ("results", ["-style", "fusion"])),
    ):
        monkeypatch.setattr(standalone.rospy, "myargv", lambda words=words: ["mrs_gui", *words])
        arguments, rest = standalone._parsed(parser)
        assert (arguments.run, rest) == wanted


class Framed(QWidget):
    """A window that gets a frame later than it is shown, as from a window manager."""

    frame = 0  # [px] at each side

    def frameGeometry(self):
        return self.geometry().adjusted(-self.frame, -self.frame, self.frame, self.frame)


def test_a_window_stays_on_its_screen_with_the_frame_that_comes_late(app):
    room, window = QGuiApplication.primaryScreen().availableGeometry(), Framed()
    kept = OnScreen(window)
    window.resize(room.width() + 100, room.height() + 200)
    window.show()
    wait_shown(lambda: window.size() == room.size())
    window.frame = 12
    wait_shown(lambda: window.size() == room.size() - QSize(24, 24))
    wait_shown(lambda: not kept._timer.isActive())  # from now on its user puts it anywhere
    window.move(room.right() - 50, 10)
    assert window.pos().x() == room.right() - 50
    window.close()
