"""Fields and buttons for the current run of the list, and its menu."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QGridLayout,
    QLabel,
    QLineEdit,
    QMenu,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.boxes import row_of
from mrs_simulator.rqt_plugin.widgets.colours import CHECKED
from mrs_simulator.rqt_plugin.widgets.guard import guarded

PIN_TIP = "A pinned run never makes room for others"
SCENARIO_TIP = "Open the scenario of this run, to change it and run it again"
DELETE_TIP = "Delete the run (Del); Undo brings it back until the window is closed"


class RunDetails(QWidget):
    """Name, note and pin of a run, and what is done with it."""

    marked = Signal(str, object)  # path, and marks by name
    scenario_asked = Signal(str)
    delete_asked = Signal(str)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._path = ""  # of the run shown
        grid = QGridLayout(self, spacing=4)
        grid.setContentsMargins(0, 0, 0, 0)
        self.name, self.note = QLineEdit(), QLineEdit()
        for place, (field, title) in enumerate(((self.name, "Name"), (self.note, "Note"))):
            label = QLabel(title)
            label.setBuddy(field)
            grid.addWidget(label, place, 0)
            grid.addWidget(field, place, 1)
            field.editingFinished.connect(guarded(lambda f=field, key=title: self._on_text(f, key)))
        self.pin = QToolButton(text="Pin", toolTip=PIN_TIP, checkable=True, styleSheet=CHECKED)
        self.pin.clicked.connect(guarded(lambda on: self._on_pin(self._path, on)))
        self.scenario = QToolButton(text="Edit its scenario", toolTip=SCENARIO_TIP)
        self.delete = QToolButton(text="Delete", toolTip=DELETE_TIP)
        self.scenario.clicked.connect(guarded(lambda *_: self.scenario_asked.emit(self._path)))
        self.delete.clicked.connect(guarded(lambda *_: self.delete_asked.emit(self._path)))
        grid.addLayout(row_of(self.pin, self.scenario, self.delete, 1), 2, 0, 1, 2)

    def show_entry(self, entry):
        """Show the marks of an ``Entry``, but for a field that is being edited.

        What is being edited of another run is taken over before.
        """
        if entry.path != self._path:
            self._on_text(self.name, "name")
            self._on_text(self.note, "note")
            self._path = entry.path
        for field, text in ((self.name, entry.name), (self.note, entry.marks.note)):
            if not field.hasFocus() or not field.isModified():
                field.setText(text)
        self.pin.setChecked(entry.marks.pinned)

    def rename(self):
        """Let the name be typed."""
        self.name.setFocus()
        self.name.selectAll()

    def menu(self, entry):
        """Return a menu with the buttons, for an ``Entry``."""
        menu = QMenu(self, toolTipsVisible=True)
        menu.setAttribute(Qt.WA_DeleteOnClose)
        path = entry.path
        for button, chosen in (
            (self.pin, lambda on: self._on_pin(path, on)),
            (self.scenario, lambda _: self.scenario_asked.emit(path)),
            (self.delete, lambda _: self.delete_asked.emit(path)),
        ):
            action = menu.addAction(button.text())
            action.setToolTip(button.toolTip())
            action.setCheckable(button.isCheckable())
            action.setChecked(button.isCheckable() and entry.marks.pinned)
            action.triggered.connect(guarded(chosen))
        return menu

    def _on_pin(self, path, on):
        self.marked.emit(path, {"pinned": bool(on)})

    def _on_text(self, field, key):
        if field.isModified():
            field.setModified(False)
            self.marked.emit(self._path, {key.lower(): field.text().strip()})
