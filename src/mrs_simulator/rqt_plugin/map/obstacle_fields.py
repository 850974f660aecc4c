"""A row that draws, undoes and deletes obstacles, and has the numbers of the one selected."""

import math

from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QButtonGroup, QLabel, QToolButton, QWidget
from mrs_simulator.rqt_plugin.widgets.boxes import row_of
from mrs_simulator.rqt_plugin.widgets.colours import CHECKED
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.rqt_plugin.widgets.fields import TextField
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.surroundings.obstacles import is_flat

# Of each field: its label, unit, and which numbers of an obstacle it may have.
NUMBERS = {
    "x": ("x", "m", ("x",)),
    "y": ("y", "m", ("y",)),
    "size": ("length", "m", ("length", "radius")),
    "width": ("width", "m", ("width",)),
    "yaw": ("\u03b8", "\u00b0", ("yaw",)),
    "height": ("height", "m", ("height",)),
}
ABOVE_0 = ("length", "radius", "width", "height")
SHAPES = (
    ("box", "Box", "A drag on free floor draws a box, with Shift a cylinder (B places one)"),
    (
        "cylinder",
        "Cylinder",
        "A drag on free floor draws a cylinder, with Shift a box (C places one)",
    ),
)
WIDE = 6  # [average characters] of a field
WIDER = 1.5  # [-] times that for an angle
DIGITS = 6  # [-] after the point of what is shown
TURN_DIGITS = 2  # of degrees


@guarded
class ObstacleFields(QWidget):
    """Shows what is selected in the ``ObstacleEditor`` of a ``MapView``, and edits it.

    It has the same size whatever is selected, lest the map moves under the mouse.
    """

    refused = Signal(str)  # what was wrong with a number

    def __init__(self, view, parent=None):
        super().__init__(parent)
        self._view, self._editor = view, view.editor
        flow = FlowLayout(self)
        self.shapes, self.fields, self._labels, self._names = {}, {}, {}, {}
        self._build_shapes(flow)
        self._build_buttons(flow)
        for name in NUMBERS:
            flow.addWidget(self._build_field(name))
        self.show_selected()

    def _build_shapes(self, flow):
        chosen = QButtonGroup(self)
        for shape, text, tip in SHAPES:
            button = QToolButton(text=text, toolTip=tip, checkable=True, styleSheet=CHECKED)
            chosen.addButton(button)
            button.toggled.connect(guarded(lambda on, s=shape: on and self._choose(s)))
            flow.addWidget(button)
            self.shapes[shape] = button
        self.shapes["box"].setChecked(True)

    def _choose(self, shape):
        self._editor.shape = shape

    def _build_buttons(self, flow):
        editor, view = self._editor, self._view
        self.buttons = {}
        for name, text, tip, action in (
            ("undo", "\u21b6", "Undo the last edit (Ctrl+Z)", view.undo_asked.emit),
            ("redo", "\u21b7", "Redo what was undone (Ctrl+Shift+Z)", view.redo_asked.emit),
            ("delete", "Delete", "Delete the obstacle selected (Del)", editor.delete),
        ):
            button = self.buttons[name] = QToolButton(text=text, toolTip=tip, accessibleName=name)
            button.clicked.connect(guarded(lambda *_, do=action: do()))
            flow.addWidget(button)
        self.set_undoable(False, False)

    def _build_field(self, name):
        text, unit, _ = NUMBERS[name]
        group, field = QWidget(), TextField(is_number=True)
        label = self._labels[name] = QLabel(text)
        label.setBuddy(field)
        wide = WIDE * WIDER if "yaw" in NUMBERS[name][2] else WIDE
        field.setFixedWidth(int(wide * self.fontMetrics().averageCharWidth()))
        field.setToolTip("of the obstacle selected [{}]".format(unit))
        field.finished.connect(guarded(lambda: self._on_finished(name)))
        field.given_up.connect(guarded(lambda: self._show_number(name)))
        row_of(label, field, owner=group, margins=(5, 0, 0, 0), spacing=3)
        self.fields[name] = field
        return group

    def set_undoable(self, undo, redo):
        """Offer to undo and to redo, or not."""
        self.buttons["undo"].setEnabled(undo)
        self.buttons["redo"].setEnabled(redo)

    def show_selected(self):
        """Show the obstacle that is selected now."""
        found = self._editor.current
        self.buttons["delete"].setEnabled(found is not None)
        for name, (text, _, numbers) in NUMBERS.items():
            held = [number for number in numbers if hasattr(found, number)]
            if name == "height" and found is not None and is_flat(found):
                held = []  # land has none
            self._names[name] = held[0] if held else ""
            self.fields[name].setEnabled(bool(held))
            self._labels[name].setText(held[0] if name == "size" and held else text)
            self._show_number(name)

    def _show_number(self, name):
        field, number = self.fields[name], self._names[name]
        if not number:
            field.clear()
            return
        value = getattr(self._editor.current, number)
        turn = number == "yaw"
        shown = round(math.degrees(value), TURN_DIGITS) if turn else round(value, DIGITS)
        field.show_value(shown)

    def _on_finished(self, name):
        field, number = self.fields[name], self._names[name]
        if not number or not field.isModified():
            return
        value, text = field.read(), field.text()
        field.settle()
        least = 0.0 if number in ABOVE_0 else -math.inf
        if isinstance(value, float) and least < value < math.inf:
            self._editor.change(**{number: math.radians(value) if number == "yaw" else value})
        else:
            wanted = "a number above 0" if number in ABOVE_0 else "a number"
            shown = number, self._editor.current.name, text, wanted + comma_remark(text)
            self.refused.emit("{} of {}: {!r}, wanted {}".format(*shown))
        self._show_number(name)
