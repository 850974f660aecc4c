"""Numbers typed with a comma, and the countries that write them so."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study
from protocol_fixtures import shipped
from PyQt5.QtCore import QLocale
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
        assert study.topology._amount.textFromValue(0.3) == "0.30"
        gain = study.protocol.findChild(object, "gain")
        gain.setText("0,5")
        gain.finished.emit()
        row = next(each for each in study.protocol._form._rows.values() if each.editor is gain)
        assert "a point in place of the comma" in row.note.message
        study.close_study()
    finally:
        QLocale.setDefault(before)
