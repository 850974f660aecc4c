"""The window around the study widget, on screens of any size."""

import logging
import os

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import QSettings
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QApplication, QWidget

from mrs_simulator.rqt_plugin.window.main_window import SIZE, Window


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
