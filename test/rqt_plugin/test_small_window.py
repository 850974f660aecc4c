"""How the window shares its room, and what of that survives a restart."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown, wait_shown
from protocol_fixtures import shipped
from PyQt5.QtWidgets import QApplication

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors", "forked_programs")


@pytest.fixture(autouse=True)
def no_window_stays():
    """Close the windows of a test, which would take the next one's mouse."""
    yield
    for window in APP.topLevelWidgets():
        window.close()


def test_in_a_small_window_the_map_has_half_the_height_and_layers_are_in_a_menu():
    study = quiet_study(shipped("consensus"))
    shown(study, 600, 540)
    panel = study.map_panel
    wait_shown(lambda: study.map.height() >= 270)
    assert study.results_tabs.height() >= 80
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
    study.view.beside.setChecked(False)
    study.resize(1900, 800)
    wait_shown(lambda: study.map.height() >= 350 and panel.shown["trails"].isVisible())
    assert not panel.layers.isVisible()
    study.close_study()


@pytest.mark.parametrize("widths", [(900, 1000, 1100, 1280, 1366), (1600, 1900)])
def test_a_robot_that_is_selected_moves_no_button_and_its_trail_is_hidden_in_row_or_menu(widths):
    study = opened(widths[0])
    panel = study.map_panel
    for width in widths:
        study.resize(width, 740)
        APP.processEvents()
        before = panel._fit.y(), study.map.height(), study.map.y()
        panel.choose(3)
        APP.processEvents()
        assert (panel._fit.y(), study.map.height(), study.map.y()) == before
        (entry,) = [each for each in panel.layers.menu().actions() if each.text() == "Trail of 3"]
        assert entry.isVisible() and panel.layers.isVisible() != panel.trail.isVisible()
        entry.trigger()
        assert not panel.trail.isChecked() and not entry.isChecked()
        panel.choose(2)
        assert panel.trail.isChecked() and entry.isChecked() and entry.text() == "Trail of 2"
        panel.choose(3)
        assert not panel.trail.isChecked() and not entry.isChecked()
        entry.trigger()  # as at the beginning
        panel.choose(0)
    study.close_study()


def opened(width, settings=None):
    """Return the GUI in a window of ``width``, with ``settings`` restored."""
    study = quiet_study(shipped("consensus"))
    shown(study, width, 740)
    if settings is not None:
        study.restore_settings(settings)
    APP.processEvents()
    return study


def beside(study):
    """Return whether the 3D view is seen beside the map, and not among the tabs."""
    low, high = study.map.height(), study.map_panel.width()
    place = study.view.mapTo(study, study.view.rect().topLeft())
    is_beside = place.x() >= study.map_panel.mapTo(study, study.map.pos()).x() + high and low > 0
    assert is_beside == (study.results_tabs.indexOf(study.view) < 0)
    return is_beside


def test_in_a_wide_window_the_3d_view_is_beside_the_map():
    study = opened(1600)
    assert beside(study) and study.view.isVisible() and study.view.width() > 300
    study.banners.notify("error", "error", "over the map alone")
    wait_shown(lambda: study.banners.width() == study.map.width())
    study.resize(1100, 740)
    wait_shown(lambda: study.results_tabs.indexOf(study.view) >= 0)
    assert study.results_tabs.tabText(study.results_tabs.indexOf(study.view)) == "3D view"
    study.resize(1600, 740)
    wait_shown(lambda: study.results_tabs.indexOf(study.view) < 0 and beside(study))
    study.view.beside.setChecked(False)
    assert not study.view.isVisible() and study.results_tabs.indexOf(study.view) == 1
    study.close_study()


def test_sizes_tabs_and_the_place_of_the_3d_view_survive_a_restart():
    first = opened(1600)
    first.views.setSizes([700, 400])
    first.results_tabs.tabBar().moveTab(first.results_tabs.indexOf(first.messages), 0)
    first.results_tabs.setCurrentWidget(first.verdict)
    first.settings_tabs.setCurrentIndex(2)
    sizes, order = first.views.sizes(), first.tab_order()
    kept = first.save_settings()
    first.close_study()
    second = opened(1600, kept)
    assert second.views.sizes() == sizes and second.tab_order() == order
    assert order[0] == "Messages"
    assert second.results_tabs.currentWidget() is second.verdict
    assert second.settings_tabs.currentIndex() == 2
    second.view.beside.setChecked(False)
    kept = second.save_settings()
    second.close_study()
    third = opened(600, kept)
    third.resize(1600, 740)
    APP.processEvents()
    assert third.results_tabs.indexOf(third.view) >= 0
    third.view.beside.setChecked(True)
    wait_shown(lambda: abs(third.views.sizes()[0] - sizes[0]) < 20)
    assert beside(third)
    third.restore_settings({"tabs": "nothing Curves", "front": "none", "views": "-1 x"})
    assert third.tab_order()[0] == "Curves"
    third.close_study()
