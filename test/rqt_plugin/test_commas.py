"""Numbers typed with a comma, and the countries that write them so."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtCore import QLocale, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from mrs_simulator.rqt_plugin.team.spreadsheet import read_number
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark

APP = QApplication.instance() or QApplication([])


@pytest.mark.parametrize("text, has", [("0,5", 1), ("-1,25 ", 1), ("1,2,3", 0), ("abc", 0)])
def test_a_decimal_comma_is_refused_with_what_is_wanted(text, has):
    assert bool(comma_remark(text)) == has
    with pytest.raises(ValueError, match="wanted a number") as refused:
        read_number(text, "robot1, x")
    assert ("a point in place of the comma" in str(refused.value)) == has


def test_fields_have_points_where_the_country_has_commas():
    before = QLocale()
    QLocale.setDefault(QLocale("de_DE"))
    try:
        study = quiet_study(shipped("consensus"))
        assert study.topology.amount.textFromValue(0.3) == "0.30"
        gain = study.protocol.findChild(object, "gain")
        gain.setText("0,5")
        gain.finished.emit()
        row = next(each for each in study.protocol.form._rows.values() if each.editor is gain)
        assert "a point in place of the comma" in row.note.message
        study.close_study()
    finally:
        QLocale.setDefault(before)


@pytest.mark.parametrize("country", ["C", "de_DE"])
def test_a_decimal_comma_is_a_point_in_fields_that_count_up_and_down(country):
    before = QLocale()
    QLocale.setDefault(QLocale(country))
    try:
        study = shown(quiet_study(shipped("consensus")), 1180, 720)
        study.settings_tabs.setCurrentIndex(0)
        height = study.team.altitude_field
        height.setVisible(True)
        study.topology.setParent(None)
        shown(study.topology, 400, 400)
        amount = study.topology.amount
        amount.setVisible(True)
        amount.setDecimals(2)
        for field, typed in ((amount, "0,25"), (amount, "0.75")):
            field.setFocus()
            field.selectAll()
            QTest.keyClicks(field, typed)
            QTest.keyClick(field, Qt.Key_Return)
            assert field.value() == float(typed.replace(",", "."))
            assert typed.replace(",", ".") in field.text()
        assert height.valueFromText("initial height 1,5 m") == 1.5
        assert height.validate("initial height 1,5 m", 0)[1] == "initial height 1.5 m"
        study.topology.close()
        study.close_study()
        study.close()
    finally:
        QLocale.setDefault(before)
