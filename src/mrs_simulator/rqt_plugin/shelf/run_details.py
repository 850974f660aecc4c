"""Fields and buttons for the current run of the list, and its menu."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QMenu,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.colours import CHECKED
from mrs_simulator.rqt_plugin.widgets.guard import guarded

PIN_TIP = "A pinned run never makes room for others"
SCENARIO_TIP = "Open the scenario of this run, to change it and run it again"
DELETE_TIP = "Delete the run (Del); Undo brings it back until the window is closed"


class RunDetails(QWidget):
    """Name, note and pin of a run, and what is done with it."""

    marked = Signal(object)  # marks by name
    scenario_asked = Signal()
    delete_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        self.name, self.note = QLineEdit(), QLineEdit()
        for row, (field, title) in enumerate(((self.name, "Name"), (self.note, "Note"))):
            label = QLabel(title)
            label.setBuddy(field)
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1)
            field.editingFinished.connect(guarded(lambda f=field, key=title: self._on_text(f, key)))
        self.pin = _button("Pin", PIN_TIP)
        self.pin.setCheckable(True)
        self.pin.setStyleSheet(CHECKED)
        self.pin.clicked.connect(guarded(lambda on: self.marked.emit({"pinned": bool(on)})))
        self.scenario = _button("Edit its scenario", SCENARIO_TIP)
        self.delete = _button("Delete", DELETE_TIP)
        self.scenario.clicked.connect(guarded(lambda *_: self.scenario_asked.emit()))
        self.delete.clicked.connect(guarded(lambda *_: self.delete_asked.emit()))
        row = QHBoxLayout()
        for button in (self.pin, self.scenario, self.delete):
            row.addWidget(button)
        row.addStretch(1)
        grid.addLayout(row, 2, 0, 1, 2)

    def show_entry(self, entry):
        """Show the marks of an ``Entry``, but for a field that is being edited."""
        for field, text in ((self.name, entry.name), (self.note, entry.marks.note)):
            if not field.hasFocus() or not field.isModified():
                field.setText(text)
        self.pin.setChecked(entry.marks.pinned)

    def rename(self):
        """Let the name be typed."""
        self.name.setFocus()
        self.name.selectAll()

    def menu(self):
        """Return a menu with the buttons."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WA_DeleteOnClose)
        menu.setToolTipsVisible(True)
        for button in (self.pin, self.scenario, self.delete):
            action = menu.addAction(button.text())
            action.setToolTip(button.toolTip())
            action.setCheckable(button.isCheckable())
            action.setChecked(button.isChecked())
            action.triggered.connect(guarded(lambda *_, b=button: b.click()))
        return menu

    def _on_text(self, field, key):
        if field.isModified():
            field.setModified(False)
            self.marked.emit({key.lower(): field.text().strip()})


def _button(text, tip):
    button = QToolButton()
    button.setText(text)
    button.setToolTip(tip)
    return button
