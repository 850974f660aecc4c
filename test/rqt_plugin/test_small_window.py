"""How the window shares its room."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtWidgets import QApplication

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


def test_in_a_small_window_the_map_has_half_the_height_and_layers_are_in_a_menu():
    study = quiet_study(shipped("consensus"))
    shown(study, 600, 540)
    APP.processEvents()
    panel = study.map_panel
    assert study.map.height() >= 270 and study.results_tabs.height() >= 80
    assert panel.layers.isVisible() and not panel.shown["trails"].isVisible()
    entry = next(each for each in panel.layers.menu().actions() if each.text() == "Trails")
    entry.trigger()
    assert not study.map.shown["trails"] and not panel.shown["trails"].isChecked()
    panel.shown["trails"].setChecked(True)
    assert entry.isChecked()
    study.right.splitterMoved.emit(200, 1)  # what the user chose stays
    study.right.setSizes([200, 200])
    sizes = study.right.sizes()
    study.resize(599, 540)
    APP.processEvents()
    assert study.right.sizes()[0] == sizes[0]
    study.resize(1900, 800)
    APP.processEvents()
    assert study.map.height() >= 350 and panel.shown["trails"].isVisible()
    assert not panel.layers.isVisible()
    study.close_study()
