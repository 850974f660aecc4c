"""Choosing a protocol and its parameters."""

import os

from mrs_simulator.rqt_plugin.protocol.parameter_form import ParameterForm
from mrs_simulator.rqt_plugin.qt.QtCore import QEvent, QSize, Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QCheckBox,
    QFrame,
    QLabel,
    QPushButton,
    QScrollArea,
    QStyle,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import NoWheelComboBox, TextField
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel

ROWS_SHOWN = 6  # at least, in lines of text


@guarded
class ProtocolPanel(QWidget):
    """The protocol's name or file above, a form of its parameters below."""

    protocol_chosen = Signal(str)  # a shipped one's name, /path/file.py or /path/file.py:Class
    parameters_changed = Signal(object)  # dict of all parameters
    safety_changed = Signal(bool)  # whether the safety filter is wanted
    file_requested = Signal(str)  # the directory to look in; the answer goes to take_file

    def __init__(self, parent=None):
        super().__init__(parent)
        self._shipped, self._name = (), ""
        self._own = ""  # the last protocol that is not a shipped one, to be offered again
        self._directory = ""
        self._build_chooser()
        self.form = ParameterForm()
        self.form.changed.connect(self.parameters_changed)
        self.values, self.set_warnings = self.form.values, self.form.set_warnings
        self._empty = QLabel("This protocol has no parameters.", wordWrap=True)
        self._defaults = QPushButton(
            "Defaults", clicked=guarded(lambda *_: self.form.set_defaults())
        )
        self._defaults.setToolTip("Reset all parameters to the protocol's defaults")
        self.safety = QCheckBox("Safety filter")
        self.safety.setToolTip(
            "Replaces the law's commands by the nearest with which robots touch neither each other nor "
            "obstacles; the verdict says what that leaves of the theorem"
        )
        self.safety.clicked.connect(self.safety_changed)
        self._build_layout()
        self._show_protocol()
        self.set_parameters((), {})

    def _build_chooser(self):
        self.combo = NoWheelComboBox()
        self.combo.setToolTip("The team's coordination protocol")
        self.combo.activated.connect(self._on_activated)
        self._file = QPushButton("File...")
        self._file.setToolTip("Load a protocol from a Python file on this computer")
        self._file.clicked.connect(guarded(lambda *_: self.file_requested.emit(self._directory)))
        self.class_field = TextField(is_number=False)
        self.class_field.setPlaceholderText("the only one in the file")
        self.class_field.setToolTip(
            "<p>Name of the protocol's class; needed only if the file defines several</p>"
        )
        self.class_field.finished.connect(self._on_class)
        self.class_field.given_up.connect(self._show_protocol)
        self._problem = MessageLabel()

    def _build_layout(self):
        self._class_label, self._scroll = QLabel("Class"), _FormArea()
        self._scroll.setWidget(page_of(self.form, 1, margins=0))
        column_of(
            row_of(QLabel("Protocol"), (self.combo, 1), self._file),
            row_of(self._class_label, (self.class_field, 1)),
            self._problem,
            self._empty,
            (self._scroll, 1),
            row_of(self.safety, 1, self._defaults),
            owner=self,
        )

    # The protocol --------------------------------------------------------------------------------

    def set_protocols(self, names):
        """Offer the shipped protocols called ``names``."""
        self._shipped = tuple(names)
        self._name = self._name or (self._shipped[0] if self._shipped else "")
        self._show_protocol()

    def set_protocol(self, name):
        """Show the protocol in force, named as in ``protocol_chosen``; no signal."""
        if name != self._name:
            self._name = name
            self._show_protocol()

    def _show_protocol(self):
        if self._name not in self._shipped:
            self._own = self._name
        self.combo.clear()
        self.combo.addItems(list(self._shipped))
        if self._own:
            path = split_name(self._own)[0]
            self.combo.addItem(os.path.basename(path) or self._own)
            self.combo.setItemData(len(self._shipped), path or self._own, Qt.ToolTipRole)
        offered = self._offered()
        index = offered.index(self._name) if self._name in offered else -1
        self.combo.setCurrentIndex(index)
        path, class_name = split_name(self._name)
        self.combo.setToolTip(path or "The team's coordination protocol")
        self.class_field.setText(class_name)
        self.class_field.setVisible(bool(path))
        self._class_label.setVisible(bool(path))
        self._problem.say("")

    def _offered(self):
        return self._shipped + ((self._own,) if self._own else ())

    def protocol(self):
        """Return the name of the protocol that is shown."""
        return self._name

    def _choose(self, name):
        self.set_protocol(name)
        self.protocol_chosen.emit(name)

    def _on_activated(self, index):
        name = self._offered()[index]
        if name != self._name:
            self._choose(name)

    def take_file(self, path):
        """Take the file at ``path`` as the protocol, if it is one of Python."""
        self._directory = os.path.join(os.path.dirname(path), "")
        if path.endswith(".py"):
            # Chosen again, the file may have been changed meanwhile.
            self._choose(path)
        else:
            self._problem.say("{}: wanted a Python file, *.py".format(path))

    def _on_class(self):
        path, before = split_name(self._name)
        name = self.class_field.text().strip()
        if not path or name == before:
            self._problem.say("")
        elif name and not name.isidentifier():
            self._problem.say("class {!r}: wanted the name of a Python class".format(name))
        else:
            self._choose("{}:{}".format(path, name) if name else path)

    # Its parameters ------------------------------------------------------------------------------

    def set_parameters(self, parameters, values):
        """Make the form of ``parameters`` and show ``values`` (dict), else defaults; no signal."""
        parameters = tuple(parameters)
        self.form.set_parameters(parameters, values)
        self._empty.setVisible(not parameters)
        self._defaults.setEnabled(bool(parameters))

    def finish(self):
        """Apply pending texts of the parameters; return why one is refused, "" where none is."""
        self.form.finish()
        return self.form.refused()[1]

    def show_refused(self):
        """Put the focus on the first parameter that is refused."""
        field, _ = self.form.refused()
        if field is not None:
            field.setFocus()
            self._scroll.ensureWidgetVisible(field)


class _FormArea(QScrollArea):
    """Scrolls up and down only, and is as large as its form where there is room."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setFrameShape(QFrame.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarAlwaysOff)

    def sizeHint(self):
        """Return the form's size, with a scroll bar."""
        return self._with_bar(self.widget().sizeHint())

    def minimumSizeHint(self):
        """Return the form's least width, and a few rows."""
        least = self._with_bar(self.widget().minimumSizeHint())
        return QSize(least.width(), min(least.height(), ROWS_SHOWN * self.fontMetrics().height()))

    def eventFilter(self, watched, event):
        """Pass on that the form has grown or shrunk, as Qt's own area does not."""
        if watched is self.widget() and event.type() == QEvent.LayoutRequest:
            self.updateGeometry()
        return super().eventFilter(watched, event)

    def _with_bar(self, size):
        bar = self.style().pixelMetric(QStyle.PM_ScrollBarExtent)
        return QSize(size.width() + bar, size.height())


def split_name(name):
    """Return the path and the class of ``/path/file.py:Class``, both empty for another name."""
    if name.endswith(".py"):
        return name, ""
    path, _, class_name = name.rpartition(":")
    return (path, class_name) if path.endswith(".py") else ("", "")
