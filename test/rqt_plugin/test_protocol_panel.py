"""The form of a protocol's parameters: what is typed is checked, sent once, and not overwritten."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from gui_fixtures import quiet_study, shown
from protocol_fixtures import shipped
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QColor, QPalette, QWheelEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QPushButton, QWidget

from mrs_simulator.core.fields import Parameter
from mrs_simulator.protocols.formation.equations import PARAMETERS
from mrs_simulator.rqt_plugin.protocol.panel import ProtocolPanel
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel

OWN = (
    Parameter("gain", 1.0, low=0.0, meaning="of <b>all</b>", why="stable & fast"),
    Parameter("horizon", 5, low=1, high=50, unit="steps"),
    Parameter("damped", True),
    Parameter("label", "abc"),
    Parameter("count", 0),
)
DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
APP = QApplication.instance() or QApplication([])
pytestmark = pytest.mark.usefixtures("no_hidden_errors")


@pytest.fixture
def panel():
    """Return a shown panel with the paper's parameters; ``sent`` and ``chosen`` record signals."""
    widget = ProtocolPanel()
    widget.sent, widget.chosen = [], []
    widget.parameters_changed.connect(widget.sent.append)
    widget.protocol_chosen.connect(widget.chosen.append)
    widget.set_protocols(["formation", "consensus"])
    widget.set_parameters(PARAMETERS, DEFAULTS)
    yield shown(widget, 360, 600)
    widget.close()
    widget.deleteLater()


def field(panel, name):
    """Return the shown field of the parameter ``name``."""
    APP.processEvents()
    (found,) = [f for f in panel.findChildren(QWidget, name) if f.isVisibleTo(panel)]
    return found


def notes(panel):
    """Return the messages that are shown."""
    return [n.message for n in panel.findChildren(MessageLabel) if n.isVisibleTo(panel)]


def type_into(widget, text, end=Qt.Key_Return):
    """Replace a field's text by ``text``, as with the keyboard."""
    widget.setFocus()
    widget.selectAll()
    QTest.keyClicks(widget, text)
    if end:
        QTest.keyClick(widget, end)


def press(panel, text):
    """Click the button called ``text``."""
    (button,) = [b for b in panel.findChildren(QPushButton) if b.text() == text]
    QTest.mouseClick(button, Qt.LeftButton)


def turn_wheel(widget):
    """Turn the wheel one notch over ``widget``."""
    where = QPointF(widget.rect().center())
    event = QWheelEvent(
        where,
        QPointF(widget.mapToGlobal(widget.rect().center())),
        QPoint(),
        QPoint(0, -120),
        Qt.NoButton,
        Qt.NoModifier,
        Qt.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)


@pytest.mark.parametrize(
    "text, value", [("0.5", 0.5), ("5e-2", 0.05), (" .25 ", 0.25), ("1E-3", 0.001)]
)
def test_any_notation_of_a_number_is_taken(panel, text, value):
    type_into(field(panel, "k"), text)
    assert panel.sent == [dict(DEFAULTS, k=value)]
    assert notes(panel) == []


@pytest.mark.parametrize("text", ["1.5", "0", "nan", "inf", "abc", "", "1,5", "1e999"])
def test_what_is_not_allowed_is_not_sent(panel, text):
    k = field(panel, "k")
    type_into(k, text or "\b")
    assert panel.sent == []
    (note,) = notes(panel)
    assert note.startswith("k = ") and "wanted a number above 0 and below 1" in note
    assert "overshoots" in note
    assert panel.values()["k"] == 0.02
    # The same values, set again, do not hide the reason.
    panel.form.set_values(DEFAULTS)
    assert notes(panel) == [note] and k.text() == text
    field(panel, "T").setFocus()
    panel.form.set_values(DEFAULTS)
    assert notes(panel) == [note] and k.text() == text
    panel.form.set_values({"k": 0.03})
    assert notes(panel) == [] and k.text() == "0.03"


def test_a_good_value_clears_the_message(panel):
    type_into(field(panel, "k"), "7")
    type_into(field(panel, "k"), "0.7")
    assert notes(panel) == []
    assert panel.sent == [dict(DEFAULTS, k=0.7)]


def test_leaving_a_field_finishes_it_once(panel):
    type_into(field(panel, "k"), "0.5", end=None)
    assert panel.sent == []
    field(panel, "T").setFocus()
    assert panel.sent == [dict(DEFAULTS, k=0.5)]
    type_into(field(panel, "k"), "0.50")
    field(panel, "T").setFocus()
    assert len(panel.sent) == 1


def test_escape_gives_the_value_in_force_back(panel):
    k = field(panel, "k")
    type_into(k, "9")
    assert notes(panel)
    QTest.keyClick(k, Qt.Key_Escape)
    assert (k.text(), notes(panel), panel.sent) == ("0.02", [], [])


def test_values_in_force_do_not_overwrite_typing(panel):
    k, c = field(panel, "k"), field(panel, "c")
    type_into(k, "0.5", end=None)
    panel.form.set_values(dict(DEFAULTS, k=0.03, c=4, closure="cycle"))
    assert k.text() == "0.5"
    assert c.text() == "4"
    assert field(panel, "closure").currentText() == "cycle"
    assert panel.sent == []
    QTest.keyClick(k, Qt.Key_Return)
    assert panel.sent == [dict(DEFAULTS, k=0.5, c=4.0, closure="cycle")]
    panel.form.set_values({"k": 0.03})
    assert k.text() == "0.03", "finished: what is in force is shown again"


def test_values_in_force_that_cannot_be_are_said(panel):
    panel.form.set_values({"k": None, "T": float("nan"), "unknown": 3, "c": 3.0})
    assert field(panel, "k").text() == "0.02"
    assert field(panel, "c").text() == "3"
    assert [note[:5] for note in notes(panel)] == ["k = n", "T = n"]
    assert panel.values() == dict(DEFAULTS, c=3.0)
    panel.form.set_values(DEFAULTS)
    assert notes(panel) == []


def test_numbers_keep_all_their_digits(panel):
    panel.form.set_values({"k": 0.1 + 0.2})
    k = field(panel, "k")
    k.setFocus()
    QTest.keyClick(k, Qt.Key_Return)
    assert k.text() == "0.30000000000000004"
    assert panel.sent == []


def test_a_choice_is_sent_when_chosen(panel):
    closure = field(panel, "closure")
    closure.setFocus()
    QTest.keyClick(closure, Qt.Key_Down)
    assert panel.sent == [dict(DEFAULTS, closure="cycle")]


def test_defaults(panel):
    panel.form.set_values({"k": 0.5, "closure": "path"})
    type_into(field(panel, "T"), "-1")
    press(panel, "Defaults")
    assert panel.sent == [DEFAULTS]
    assert notes(panel) == []
    assert field(panel, "T").text() == "0.1"
    press(panel, "Defaults")
    assert len(panel.sent) == 1


def test_kinds_of_fields(panel):
    panel.set_parameters(OWN, {})
    wanted = {"gain": 1.0, "horizon": 5, "damped": True, "label": "abc", "count": 0}
    assert panel.values() == wanted
    QTest.mouseClick(field(panel, "damped"), Qt.LeftButton, pos=QPoint(8, 12))
    assert panel.sent[-1] == dict(wanted, damped=False)
    type_into(field(panel, "label"), "left")
    assert panel.sent[-1]["label"] == "left"
    type_into(field(panel, "horizon"), "12", end=None)
    assert panel.sent[-1]["horizon"] == 5, "not while a number is being typed"
    QTest.keyClick(field(panel, "horizon"), Qt.Key_Return)
    assert panel.sent[-1]["horizon"] == 12 and type(panel.sent[-1]["horizon"]) is int
    QTest.keyClick(field(panel, "horizon"), Qt.Key_Up)
    assert panel.sent[-1]["horizon"] == 13
    type_into(field(panel, "count"), "-5000000000")
    assert panel.sent[-1]["count"] == -5000000000
    assert len(panel.sent) == 5


def test_a_whole_number_being_typed_is_not_overwritten(panel):
    panel.set_parameters(OWN, {})
    horizon = field(panel, "horizon")
    type_into(horizon, "3", end=None)
    panel.form.set_values({"horizon": 9})
    assert horizon.text() == "3"
    QTest.keyClick(horizon, Qt.Key_Return)
    assert panel.sent[-1]["horizon"] == 3
    panel.form.set_values({"horizon": 9})
    assert horizon.text() == "9"


def test_the_wheel_changes_no_field_that_is_not_being_edited(panel):
    panel.set_parameters(OWN + PARAMETERS[-1:], {})
    panel.set_protocol("formation")
    for name in ("horizon", "closure"):
        field(panel, "label").setFocus()
        turn_wheel(field(panel, name))
    turn_wheel(panel.combo)
    assert panel.sent == [] and panel.chosen == []
    field(panel, "horizon").setFocus()
    turn_wheel(field(panel, "horizon"))
    assert panel.sent[-1]["horizon"] == 4


def test_tooltips_tell_all_and_take_nothing_for_markup(panel):
    panel.set_parameters(OWN, {})
    tip = field(panel, "gain").toolTip()
    assert "of &lt;b&gt;all&lt;/b&gt;" in tip and "stable &amp; fast" in tip
    assert "a number of at least 0" in tip
    assert "[steps]" in field(panel, "horizon").toolTip()


def test_warnings_stand_beside_their_parameters(panel):
    panel.set_warnings({"k": "slow", "": "no spanning tree", "gone": "odd"})
    assert notes(panel) == ["slow", "no spanning tree\ngone: odd"]
    k, note = field(panel, "k"), panel.form._rows["k"].note
    assert k.geometry().bottom() < note.geometry().top() < field(panel, "T").geometry().top()
    type_into(field(panel, "k"), "2")
    assert "slow" not in notes(panel), "what is wrong comes first"
    type_into(field(panel, "k"), "0.5")
    assert "slow" in notes(panel)
    panel.set_warnings({})
    assert notes(panel) == []


def test_another_protocol_while_a_field_is_being_edited(panel):
    panel.parameters_changed.connect(lambda _: panel.set_parameters(OWN, {}))
    type_into(field(panel, "k"), "0.5")
    QTest.qWait(1)
    assert panel.values()["horizon"] == 5
    assert len(panel.sent) == 1
    panel.set_parameters((), {})
    assert panel.values() == {}
    press(panel, "Defaults")
    assert len(panel.sent) == 1


def test_the_same_parameters_keep_their_fields(panel):
    before = field(panel, "k")
    panel.set_parameters(PARAMETERS, dict(DEFAULTS, k=0.3))
    assert field(panel, "k") is before and before.text() == "0.3"
    panel.set_parameters(PARAMETERS, {})
    assert panel.values() == DEFAULTS and before.text() == "0.02"
    assert panel.sent == []


def test_a_shipped_protocol_is_chosen(panel):
    assert panel.protocol() == "formation" and panel.chosen == []
    panel.combo.setFocus()
    QTest.keyClick(panel.combo, Qt.Key_Down)
    assert panel.chosen == ["consensus"]
    panel.set_protocol("consensus")
    panel.set_protocol("formation")
    assert panel.combo.currentText() == "formation"
    assert panel.chosen == ["consensus"]


def test_a_file_is_chosen_and_a_class_in_it(panel):
    asked = []
    panel.file_requested.connect(asked.append)
    assert not panel.class_field.isVisible()
    press(panel, "File...")
    panel.take_file("/home/me/own.py")
    press(panel, "File...")
    assert asked == ["", "/home/me/"]
    assert panel.chosen == ["/home/me/own.py"]
    assert panel.combo.currentText() == "own.py" and panel.class_field.isVisible()
    type_into(panel.class_field, "no class")
    assert "wanted the name of a Python class" in notes(panel)[0]
    type_into(panel.class_field, "Consensus")
    panel.combo.setFocus()
    assert panel.chosen == ["/home/me/own.py", "/home/me/own.py:Consensus"]
    assert notes(panel) == []
    QTest.keyClick(panel.combo, Qt.Key_Up)
    QTest.keyClick(panel.combo, Qt.Key_Down)
    assert panel.chosen[2:] == ["consensus", "/home/me/own.py:Consensus"]


def test_a_wrong_file(panel):
    panel.take_file("/home/me/own.txt")
    assert "wanted a Python file" in notes(panel)[0]
    assert panel.chosen == []


@pytest.mark.parametrize(
    "name, shown, class_name",
    [
        ("/a/b/own.py:Own", "own.py", "Own"),
        ("own.py", "own.py", ""),
        ("package.module:Class", "package.module:Class", None),
    ],
)
def test_names_of_protocols(panel, name, shown, class_name):
    panel.set_protocol(name)
    assert panel.combo.currentText() == shown
    assert panel.class_field.isVisible() == (class_name is not None)
    assert panel.class_field.text() == (class_name or "")
    assert panel.protocol() == name and panel.chosen == []


@pytest.mark.parametrize("background", ["#efefef", "#202020"])
def test_messages_can_be_read_on_any_background(panel, background):
    panel.setPalette(QPalette(QColor(background)))
    panel.set_warnings({"k": "slow"})
    type_into(field(panel, "T"), "-1")
    for note in panel.findChildren(MessageLabel):
        if note.isVisible():
            ink = note.palette().color(QPalette.WindowText).lightness()
            assert abs(ink - QColor(background).lightness()) > 60


def test_the_panel_fits_a_narrow_column(panel):
    word = "a" * 300
    panel.set_warnings({"k": word, "": "/".join(["directory"] * 30)})
    assert panel.minimumSizeHint().width() <= 360 * max(1.0, panel.fontMetrics().height() / 18.0)
    for name in DEFAULTS:
        assert field(panel, name).width() >= field(panel, name).minimumWidth()


def test_the_safety_filter_is_switched_on_and_off_and_undone():
    widget = shown(quiet_study(shipped("formation_safely")), 1180, 720)
    try:
        box, arena = widget.protocol.safety, widget.study.scenario.control.safety
        assert box.isChecked() and arena
        QTest.mouseClick(box, Qt.LeftButton, Qt.NoModifier, QPoint(8, box.height() // 2))
        assert widget.study.scenario.control.safety is False and not box.isChecked()
        widget.bar.undo_asked.emit()
        assert widget.study.scenario.control.safety == arena and box.isChecked()
        widget.editing.take(shipped("paper_four"))
        assert not box.isChecked()
        QTest.mouseClick(box, Qt.LeftButton, Qt.NoModifier, QPoint(8, box.height() // 2))
        assert widget.study.scenario.control.safety.obstacles and box.isChecked()
    finally:
        widget.close_study()
        widget.close()
        APP.processEvents()
