"""What is to be otherwise in a look ahead: a gain by a slider, and what came of it in words."""

import math

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QComboBox, QLabel, QPushButton, QSlider, QWidget
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.guard import guarded

FARTHEST, STEPS = 8.0, 60  # [-] times the gain at the end of the slider, which has so many steps
BEFORE = (
    "Drag a robot, click on an edge or move a gain: the run goes on from this moment as a ghost"
)


@guarded
class AheadBar(QWidget):
    """A choice among gains with a slider, a text, and what to do with the look ahead."""

    gain_moved = Signal(str, float)  # name, value
    keep_asked = Signal()
    clear_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self._gains, self._moved = {}, {}  # fields by name, and values of those that were moved
        self._values = None  # as the run has them, by name
        self.gain, self.slider, self._value = QComboBox(), QSlider(Qt.Horizontal), QLabel()
        self.keep, self.clear_button = QPushButton("Keep as run"), QPushButton("Clear")
        self.text = QLabel(BEFORE, wordWrap=True)
        self.gain.setToolTip("The parameter that the slider moves")
        self.slider.setRange(-STEPS, STEPS)
        self.slider.setToolTip("From an eighth of the value to eight times that, within its range")
        self.slider.setMinimumWidth(8 * self.fontMetrics().height())
        self.keep.setToolTip("Run it from the beginning, judge it, and put it on the list of runs")
        self.clear_button.setToolTip("Change nothing")
        first = row_of(self.gain, (self.slider, 1), self._value, self.keep, self.clear_button)
        column_of(first, self.text, owner=self, margins=0, spacing=1)
        self.gain.currentIndexChanged.connect(guarded(lambda *_: self._show_value()))
        self.slider.valueChanged.connect(self._on_slider)
        self.keep.clicked.connect(guarded(lambda *_: self.keep_asked.emit()))
        self.clear_button.clicked.connect(guarded(lambda *_: self.clear_asked.emit()))
        self.show_state("", False)

    def set_gains(self, fields, values):
        """Offer the parameters ``fields`` that are numbers other than 0, with their ``values``."""
        gains = {field.name: field for field in fields if _is_gain(values.get(field.name))}
        if gains == self._gains and values == self._values:
            return
        self._gains, self._values, self._moved = gains, dict(values), {}
        self.gain.blockSignals(True)
        self.gain.clear()
        self.gain.addItems(list(gains))
        self.gain.blockSignals(False)
        for widget in (self.gain, self.slider, self._value):
            widget.setVisible(bool(gains))
        self._show_value()

    def take_back(self):
        """Have all gains as the run has them."""
        self._moved = {}
        self._show_value()

    def show_state(self, text, can_keep, why=""):
        """Show ``text`` on the look ahead; ``can_keep``: whether there is one to keep, else ``why`` not."""
        self.text.setText(text or BEFORE)
        self.keep.setEnabled(can_keep)
        self.clear_button.setEnabled(bool(text))
        if why:
            self.keep.setToolTip(why)

    def _show_value(self):
        """Put the slider where the chosen gain is."""
        name = self.gain.currentText()
        if name not in self._gains:
            return
        value = self._moved.get(name, self._values[name])
        place = math.log(value / self._values[name], FARTHEST) * STEPS
        self.slider.blockSignals(True)
        self.slider.setValue(int(round(place)))
        self.slider.blockSignals(False)
        self._say(name, value)

    def _say(self, name, value):
        unit = self._gains[name].unit
        self._value.setText("{:.4g} {}".format(value, unit).strip())

    def _on_slider(self, place):
        name = self.gain.currentText()
        if name not in self._gains:
            return
        field, value = self._gains[name], self._values[name] * FARTHEST ** (place / STEPS)
        if not _is_allowed(field, value):
            self._show_value()
            return
        self._moved[name] = value
        self._say(name, value)
        self.gain_moved.emit(name, value)


def _is_gain(value):
    return isinstance(value, float) and value != 0.0


def _is_allowed(field, value):
    low = field.low is None or value > field.low or (value == field.low and not field.open_low)
    high = field.high is None or value < field.high or (value == field.high and not field.open_high)
    return low and high
