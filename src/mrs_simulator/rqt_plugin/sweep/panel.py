"""The sweep: two axes on the left, the map of its cells on the right."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QCompleter,
    QGridLayout,
    QLabel,
    QPushButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.sweep.axes import FEWEST, MOST, USUAL, AxisTexts, key_of
from mrs_simulator.rqt_plugin.sweep.cells import MARGIN
from mrs_simulator.rqt_plugin.sweep.map import SweepMap
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import (
    NoWheelComboBox,
    PatientSpinBox,
    TextField,
    number_text,
)
from mrs_simulator.rqt_plugin.widgets.form_beside import FormBeside
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel

FORM = 17  # [lines of text] that the form is wide at first
BEFORE = (
    "Choose two parameters and Start: each cell is a run of the scenario as it is edited, and is "
    "coloured as soon as it ends. A click on a cell shows its run."
)


@guarded
class AxisForm:
    """Parameter, range and number of cells of one axis, in rows of a grid."""

    def __init__(self, grid, title):
        self._keys, self._chosen = [], ""
        self.name, self.low, self.high = NoWheelComboBox(), TextField(True), TextField(True)
        self.name.setEditable(True)
        self.name.setInsertPolicy(self.name.NoInsert)
        self.name.completer().setCompletionMode(QCompleter.PopupCompletion)
        self.name.completer().setFilterMode(Qt.MatchContains)
        self.name.setToolTip(
            "A parameter of the protocol, or the path of any number in the scenario, as control.rate"
        )
        self.count = PatientSpinBox()
        self.count.setRange(FEWEST, MOST)
        self.count.setValue(USUAL)
        self.count.setToolTip("Cells along this axis, evenly spaced")
        first = grid.rowCount()
        grid.addWidget(QLabel(title), first, 0)
        grid.addWidget(self.name, first, 1, 1, 3)
        ends = row_of((self.low, 1), QLabel("to"), (self.high, 1), QLabel("in"), self.count)
        grid.addLayout(ends, first + 1, 1, 1, 3)
        self.notes = {}
        for place, name in enumerate(("name", "low", "high", "count")):
            note = self.notes[name] = MessageLabel()
            grid.addWidget(note, first + 2 + place, 1, 1, 3)
        self.name.activated.connect(self._on_name)
        self.name.lineEdit().editingFinished.connect(self._on_name)

    def offer(self, keys, place):
        """Offer ``SweptKey``s; the one at ``place`` is chosen where none of them was before."""
        if [each.name for each in keys] == [each.name for each in self._keys]:
            self._keys = keys
            return
        self._keys, before = keys, self.name.currentText()
        self.name.clear()
        self.name.addItems([each.name for each in keys])
        known = [each.name for each in keys]
        kept = before in known
        self.name.setCurrentIndex(known.index(before) if kept else min(place, len(keys) - 1))
        if not kept:
            self._suggest()

    def choose(self, name):
        """Choose the parameter called ``name``, or a path, with a range about its value."""
        self.name.setCurrentText(name)
        self._on_name()

    def _on_name(self, *_):
        if self.name.currentText() != self._chosen:
            self._suggest()

    def _suggest(self):
        """Fill in a range about the value that the scenario has, where it is known."""
        self._chosen = self.name.currentText()
        key = key_of(self._chosen, self._keys)
        if key.field is not None:
            for field, value in zip((self.low, self.high), key.suggested()):
                field.setText(number_text(value))
        self.show_errors({})

    def texts(self):
        """Return the ``AxisTexts``."""
        self.count.interpretText()
        ends = self.low.text(), self.high.text()
        return AxisTexts(self.name.currentText(), *ends, self.count.value())

    def show_errors(self, errors):
        """Show texts beside the fields by their names."""
        for name, note in self.notes.items():
            note.say(errors.get(name, ""))

    def set_enabled(self, on):
        """Let the fields be edited or not."""
        for widget in (self.name, self.low, self.high, self.count):
            widget.setEnabled(on)


@guarded
class SweepPanel(QWidget):
    """Asks for sweeps, and shows their ``SweepCells``."""

    start_asked = Signal()
    cancel_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        self.map, self.hint = SweepMap(), MessageLabel("aside")
        self.axes, grid = [], QGridLayout()
        grid.setColumnStretch(1, 1)
        for title in ("Along x", "Along y"):
            self.axes.append(AxisForm(grid, title))
        self.quantity = NoWheelComboBox()
        self.quantity.addItem(MARGIN)
        self.quantity.setToolTip("What the colours of the cells show")
        self.quantity.currentIndexChanged.connect(self._on_quantity)
        last = grid.rowCount()
        grid.addWidget(QLabel("Colour"), last, 0)
        grid.addWidget(self.quantity, last, 1, 1, 3)
        self.start, self.cancel = QPushButton("Start sweep"), QPushButton("Cancel")
        self.start.setToolTip("Run each cell in the background, on all cores but one")
        self.cancel.setToolTip("End the sweep; what has ended stays")
        self.start.clicked.connect(guarded(lambda *_: self.start_asked.emit()))
        self.cancel.clicked.connect(guarded(lambda *_: self.cancel_asked.emit()))
        self.note, self.place = MessageLabel("aside"), MessageLabel("aside")
        form = page_of(grid, row_of((self.start, 1), self.cancel), self.note, self.place, 1)
        right = page_of(self.hint, (self.map, 1), margins=0)
        self.hint.say(BEFORE)
        column_of(FormBeside(form, right, FORM), owner=self, margins=0)
        self.set_running(False)

    def offer(self, keys):
        """Offer the ``SweptKey``s of the scenario as it is edited."""
        for place, axis in enumerate(self.axes):
            axis.offer(keys, place)

    def set_running(self, on):
        """Show whether a sweep runs."""
        self.start.setEnabled(not on)
        self.cancel.setEnabled(on)
        for axis in self.axes:
            axis.set_enabled(not on)

    def show_cells(self, cells):
        """Show ``SweepCells`` by what is known of them now."""
        self.hint.say("" if cells is not None else BEFORE)
        if cells is not None:
            known = [self.quantity.itemText(row) for row in range(self.quantity.count())]
            for name in cells.quantities():
                if name not in known:
                    self.quantity.addItem(name)
        self.map.show_cells(cells, self.quantity.currentText())

    def forget_quantities(self):
        """Offer what every sweep measures, and nothing of the one before."""
        while self.quantity.count() > 1:
            self.quantity.removeItem(1)

    def _on_quantity(self, *_):
        self.map.show_cells(self.map.cells, self.quantity.currentText())
