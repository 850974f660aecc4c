"""Fields for one value each: a number, a text, a choice, a switch.

A field sends ``finished`` when a new value stands in it, and ``given_up`` when the old one is
wanted back.  ``read`` returns what stands in it, ``show_value`` shows a value, ``settle`` marks the
text as applied, ``busy`` returns whether it is being edited.
"""

import math

from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QLocale, QSize, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QLineEdit,
    QSizePolicy,
    QSpinBox,
    QStyle,
    QStyleOptionComboBox,
    QStylePainter,
)
from mrs_simulator.rqt_plugin.widgets.guard import guarded

LARGEST_WHOLE = 2.0**53  # up to here a double holds every whole number
LONGEST_NUMBER, LONGEST_TEXT = 60, 1000  # [characters]
WIDTH = 9  # [average characters], least of a field


def field(parameter):
    """Return the field that suits ``parameter``."""
    if parameter.choices:
        return ChoiceField(parameter.choices)
    if isinstance(parameter.default, bool):
        return SwitchField()
    if isinstance(parameter.default, int):
        return WholeField(parameter)
    return TextField(isinstance(parameter.default, float))


def number_text(value):
    """Return ``value`` in the fewest digits that give it back."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


@guarded
class _Patient:
    """Leaves the wheel to the surrounding scroll area unless it has the focus."""

    def wheelEvent(self, event):
        """Turn the field's value, or the page."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


@guarded
class _Escapable:
    """Escape discards the text being typed; otherwise the key is passed on."""

    def event(self, event):
        """Keep Escape from being a shortcut while a text is edited."""
        if event.type() == QEvent.ShortcutOverride and self._escapes(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event):
        """Discard the text, or handle the key as usual."""
        if self._escapes(event):
            self.give_up()
        else:
            super().keyPressEvent(event)

    def _escapes(self, event):
        return event.key() == Qt.Key_Escape and self.busy()

    def give_up(self):
        """Ask the owner for the value in force."""
        self.given_up.emit()


class PatientSpinBox(_Escapable, _Patient, QSpinBox):
    """A spin box with a signal when its value is entered."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.StrongFocus)

    def busy(self):
        """Return whether its text differs from the value in force."""
        return self.text() != self.textFromValue(self.value())

    def give_up(self):
        """Show the value in force."""
        self.setValue(self.value())


class PointSpinBox(QDoubleSpinBox):
    """A number whose decimal comma is taken for a point; Qt takes it for one between thousands."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setLocale(QLocale.c())  # shown as typed, in any country

    @guarded
    def validate(self, text, place):
        """Return whether ``text`` may be typed, with points in place of commas."""
        return super().validate(text.replace(",", "."), place)

    @guarded
    def valueFromText(self, text):
        """Return the number in ``text``."""
        return super().valueFromText(text.replace(",", "."))


@guarded
class NoWheelComboBox(QComboBox):
    """A combo box that the wheel does not change, and that may be narrower than its texts."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Fixed)
        self.setMinimumWidth(int(self.fontMetrics().averageCharWidth() * (WIDTH + 1)))

    def sizeHint(self):
        """Return the least width, however long the texts are."""
        return QSize(self.minimumWidth(), super().sizeHint().height())

    def wheelEvent(self, event):
        """Leave the wheel to the scroll area around."""
        event.ignore()

    def paintEvent(self, _):
        """Draw a long text with dots in its middle; Qt would cut it off."""
        painter, option = QStylePainter(self), QStyleOptionComboBox()
        self.initStyleOption(option)
        room = self.style().subControlRect(
            QStyle.CC_ComboBox, option, QStyle.SC_ComboBoxEditField, self
        )
        option.currentText = option.fontMetrics.elidedText(
            option.currentText, Qt.ElideMiddle, room.width()
        )
        painter.drawComplexControl(QStyle.CC_ComboBox, option)
        painter.drawControl(QStyle.CE_ComboBoxLabel, option)


class TextField(_Escapable, QLineEdit):
    """A number in any notation, or a text."""

    finished = Signal()
    given_up = Signal()

    def __init__(self, is_number):
        super().__init__()
        self._is_number = is_number
        self.setMaxLength(LONGEST_NUMBER if is_number else LONGEST_TEXT)
        self.setMinimumWidth(int(self.fontMetrics().averageCharWidth() * WIDTH))
        self.editingFinished.connect(self.finished)

    def read(self):
        """Return a float, or the text where it is none."""
        try:
            return float(self.text()) if self._is_number else self.text()
        except ValueError:
            return self.text()

    def show_value(self, value):
        """Show ``value``."""
        text = number_text(value) if self._is_number else str(value)
        if text != self.text():
            self.setText(text)
            self.setCursorPosition(0)
        self.settle()

    def settle(self):
        """Take the text as the value in force."""
        self.setModified(False)

    def busy(self):
        """Return whether a text is being edited."""
        return self.hasFocus() and self.isModified()


class WholeField(_Escapable, _Patient, QDoubleSpinBox):
    """A whole number; a double's spin box, since ``QSpinBox`` ends at 32 bits."""

    finished = Signal()
    given_up = Signal()

    def __init__(self, parameter):
        super().__init__()
        low, high = parameter.low, parameter.high
        if low is not None:
            low = math.floor(low) + 1 if parameter.open_low else math.ceil(low)
        if high is not None:
            high = math.ceil(high) - 1 if parameter.open_high else math.floor(high)
        self.setDecimals(0)
        self.setRange(
            -LARGEST_WHOLE if low is None else float(low),
            LARGEST_WHOLE if high is None else float(high),
        )
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Fixed)
        self.setMinimumWidth(int(self.fontMetrics().averageCharWidth() * WIDTH))
        self.valueChanged.connect(self.finished)

    def sizeHint(self):
        """Return the least width; Qt's would hold the largest number."""
        return QSize(self.minimumWidth(), super().sizeHint().height())

    def read(self):
        """Return the number."""
        self.interpretText()
        return int(self.value())

    def show_value(self, value):
        """Show ``value``."""
        blocked = self.blockSignals(True)
        self.setValue(float(value))
        self.blockSignals(blocked)
        self.settle()

    def settle(self):
        """Take the text as the value in force."""
        self.lineEdit().setModified(False)

    def busy(self):
        """Return whether a text is being edited."""
        return self.hasFocus() and self.lineEdit().isModified()


class ChoiceField(NoWheelComboBox):
    """One of several texts."""

    finished = Signal()
    given_up = Signal()

    def __init__(self, choices):
        super().__init__()
        self.addItems([str(choice) for choice in choices])
        self.activated.connect(self.finished)

    def read(self):
        """Return the chosen text."""
        return self.currentText()

    def show_value(self, value):
        """Show ``value``."""
        self.setCurrentIndex(self.findText(str(value)))

    def settle(self):
        """Do nothing: a choice is applied at once."""

    def busy(self):
        """Return whether the list is open."""
        return self.view().isVisible()


class SwitchField(QCheckBox):
    """True or false."""

    finished = Signal()
    given_up = Signal()

    def __init__(self):
        super().__init__()
        self.clicked.connect(self.finished)

    def read(self):
        """Return whether it is on."""
        return self.isChecked()

    def show_value(self, value):
        """Show ``value``."""
        self.setChecked(bool(value))

    def settle(self):
        """Do nothing: the switch is applied at once."""

    def busy(self):
        """Return whether it is being pressed."""
        return self.isDown()
