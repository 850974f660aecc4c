"""The window by keyboard alone: no trap, every mode reachable, and the focus seen."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QTableView, QToolButton

from mrs_simulator.rqt_plugin.map.panel import MODES
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")
MOST = 200  # [-] presses of Tab, of the whole window and all cells of a table


@pytest.fixture
def study():
    widget = shown(quiet_study(load_scenario(scenario_path("paper_four"))), 1600, 900)
    yield widget
    widget.close_study()
    widget.close()


def test_tab_goes_round_the_whole_window(study):
    wanted = [
        study.bar.button("speed"),
        study.bar.button("emergency"),
        study.team.findChild(QTableView),
        study.settings_tabs.tabBar(),
        study.results_tabs.tabBar(),
        study.curves.field,
    ]
    for key in (Qt.Key_Tab, Qt.Key_Backtab):
        study.map.setFocus()
        passed = []
        for _ in range(MOST):
            QTest.keyClick(QApplication.focusWidget(), key)
            passed.append(QApplication.focusWidget())
            if passed[-1] is study.map:
                break
        assert passed[-1] is study.map
        assert any(button in passed for button in study.modes.values())  # arrows choose another
        assert [widget for widget in wanted if widget not in passed] == []


def test_tab_goes_through_the_cells_of_the_table_and_then_on(study):
    table = study.team.findChild(QTableView)
    table.setFocus()
    table.setCurrentIndex(table.model().index(0, 0))
    cells = table.model().rowCount() * table.model().columnCount()
    for count in range(1, cells):
        QTest.keyClick(table, Qt.Key_Tab)
        index = table.currentIndex()
        assert table.hasFocus()
        assert index.row() * table.model().columnCount() + index.column() == count
    QTest.keyClick(table, Qt.Key_Tab)
    assert not table.hasFocus()


def test_every_mode_of_the_mouse_has_a_key(study):
    for button in study.modes.values():
        button.setEnabled(True)
    for digit, (mode, _, _) in reversed(list(enumerate(MODES, 1))):
        for focus in (study.map, study.bar.button("run")):
            study.modes["look"].setChecked(True)
            focus.setFocus()
            QTest.keyClick(focus, Qt.Key_0 + digit, Qt.ControlModifier)
            assert study.map.mode == mode
        assert "(Ctrl+{})".format(digit) in study.modes[mode].toolTip()
    study.modes["edges"].setEnabled(False)
    QTest.keyClick(study.map, Qt.Key_3, Qt.ControlModifier)
    assert study.map.mode == "look"  # the last that was chosen


def picture(study, button):
    """Return the pixels of ``button`` and what is just around it."""
    place = (
        button.rect()
        .adjusted(-3, -3, 3, 3)
        .translated(button.mapTo(study, button.rect().topLeft()))
    )
    image = study.grab(place).toImage()
    return image.constBits().asstring(image.byteCount())


def test_the_focus_is_seen_on_every_button_that_can_have_it(study):
    buttons = [each for each in study.findChildren(QToolButton) if each.isVisible()]
    buttons = [each for each in buttons if each.isEnabled() and each.focusPolicy() & Qt.TabFocus]
    assert study.modes["look"] in buttons and len(buttons) > 6
    for button in buttons:
        study.curves.field.setFocus()
        QTest.keyClick(study.curves.field, Qt.Key_Tab)  # from then on Qt marks the focus
        study.curves.field.setFocus()
        APP.processEvents()
        before = picture(study, button)
        button.setFocus(Qt.TabFocusReason)
        APP.processEvents()
        assert picture(study, button) != before, button.text()
