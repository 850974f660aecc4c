"""A form with one field for each declared parameter, checked as declared."""

import functools
import html

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QGridLayout, QLabel, QWidget
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.rqt_plugin.widgets.fields import field
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel, TintedLabel
from mrs_simulator.rqt_plugin.widgets.symbols import printed_name, symbolic


class ParameterForm(QWidget):
    """One row for each parameter: name, field, unit and range; below it what is wrong with it."""

    changed = Signal(object)  # dict of all values, after a field was finished with a new value

    def __init__(self, parent=None):
        super().__init__(parent)
        self._rows, self._values, self._warnings = {}, {}, {}
        self._parameters = ()
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(1, 1)
        self._below = MessageLabel("warning")

    def set_parameters(self, parameters, values=None):
        """Show ``parameters`` with ``values`` (dict), the defaults where it has none."""
        parameters = tuple(parameters)
        if parameters != self._parameters:
            self._rebuild(parameters)
        defaults = {parameter.name: parameter.default for parameter in parameters}
        self.set_values(dict(defaults, **(values or {})))

    def _rebuild(self, parameters):
        while self._grid.count():
            widget = self._grid.takeAt(0).widget()
            if widget is not self._below:
                # DebouncedWorker, since the change may come from one of these fields.
                widget.hide()
                widget.deleteLater()
        self._parameters = parameters
        self._values = {parameter.name: parameter.default for parameter in parameters}
        self._rows = {}
        for place, parameter in enumerate(parameters):
            row = _Row(parameter, self._grid, 2 * place)
            row.editor.finished.connect(functools.partial(self._finished, parameter.name))
            row.editor.given_up.connect(functools.partial(self._given_up, parameter.name))
            self._rows[parameter.name] = row
        self._grid.addWidget(self._below, 2 * len(parameters), 0, 1, 4)
        self.set_warnings({})

    def values(self):
        """Return the values in force, or as last finished; a copy."""
        return dict(self._values)

    def set_values(self, values):
        """Show the values in force; a field being edited keeps its text."""
        for name in set(values).intersection(self._rows):
            row = self._rows[name]
            try:
                value = row.parameter.checked(values[name])
            except ValueError as error:
                row.complain(error)
                continue
            # A refused text stays, with what is wrong with it, until there is something new.
            if not row.editor.busy() and not (row.refused and value == self._values[name]):
                row.show(value)
            self._values[name] = value

    def set_warnings(self, warnings):
        """Show texts beside the parameters that are its keys; other keys' below the form."""
        self._warnings = dict(warnings)
        for name, row in self._rows.items():
            row.warn(self._warnings.get(name, ""))
        others = [
            "{}: {}".format(name, text) if name else text
            for name, text in self._warnings.items()
            if name not in self._rows and text
        ]
        self._below.say("\n".join(others))

    def set_defaults(self):
        """Reset every field to its default; emit ``changed`` if any differs."""
        for parameter in self._parameters:
            self._rows[parameter.name].show(parameter.default)
        self._take({parameter.name: parameter.default for parameter in self._parameters})

    def finish(self):
        """Apply pending texts of the fields; return whether all are allowed."""
        for name in list(self._rows):
            self._finished(name)
        return not any(row.refused for row in self._rows.values())

    def refused(self):
        """Return the first refused field and why it is, ``(None, "")`` where none is."""
        refused = (row for row in self._rows.values() if row.refused)
        return next(((row.editor, row.note.message) for row in refused), (None, ""))

    @guarded
    def _finished(self, name):
        # A field of a form that is no more may still speak up when it loses the focus.
        value = self._rows[name].read() if name in self._rows else None
        if value is not None:
            self._take({name: value})

    @guarded
    def _given_up(self, name):
        if name in self._rows:
            self._rows[name].show(self._values[name])

    def _take(self, values):
        if any(self._values[name] != value for name, value in values.items()):
            self._values.update(values)
            self.changed.emit(self.values())


class _Row:
    """The widgets of one parameter, in two rows of the grid."""

    def __init__(self, parameter, grid, place):
        self.parameter, self.refused = parameter, False
        self._warning = ""
        self.editor = field(parameter)
        self.editor.setObjectName(parameter.name)
        self.note = MessageLabel()
        name, unit = QLabel(printed_name(parameter.name)), QLabel(symbolic(parameter.unit))
        name.setTextFormat(Qt.RichText)
        name.setWordWrap(True)
        allowed = TintedLabel("aside", interval(parameter))
        tip = tooltip(parameter)
        for column, widget in enumerate((name, self.editor, unit, allowed)):
            widget.setToolTip(tip)
            grid.addWidget(widget, place, column)
        grid.addWidget(self.note, place + 1, 0, 1, 4)
        name.setBuddy(self.editor)
        self.show(parameter.default)

    def show(self, value):
        """Show ``value``, which is allowed."""
        self.refused = False
        self.editor.show_value(value)
        self._say()

    def read(self):
        """Return the value of the field, None if it is not allowed."""
        given = self.editor.read()
        try:
            value = self.parameter.checked(given)
        except ValueError as error:
            self.refused = True
            number = isinstance(self.parameter.default, float)
            self.complain(str(error) + (comma_remark(given) if number else ""))
            return None
        self.refused = False
        self.editor.settle()
        self._say()
        return value

    def complain(self, error):
        """Show the error; the field stays as it is."""
        self._say(str(error))

    def warn(self, text):
        """Show a warning, unless there is something wrong to show."""
        self._warning = text
        if not self.refused:
            self._say()

    def _say(self, wrong=""):
        self.note.say(wrong or self._warning, "error" if wrong else "warning")


def interval(parameter):
    """Return the allowed range, such as ``(0, 1]``; empty if there is none."""
    low, high = parameter.low, parameter.high
    if low is None and high is None:
        return ""
    return "{}{}, {}{}".format(
        "(" if low is None or parameter.open_low else "[",
        "\u2212\u221e" if low is None else "{:g}".format(low),
        "\u221e" if high is None else "{:g}".format(high),
        ")" if high is None or parameter.open_high else "]",
    )


def tooltip(parameter):
    """Return meaning, unit, range, reason and default of ``parameter`` as rich text that wraps."""
    text = "{} [{}]"
    title = (
        text.format(parameter.name, symbolic(parameter.unit)) if parameter.unit else parameter.name
    )
    lines = [title + (": " + parameter.meaning if parameter.meaning else "")]
    lines.append("wanted: " + parameter._replace(why="").wanted())
    if parameter.why:
        lines.append("why: " + parameter.why)
    lines.append("default: {}".format(parameter.default))
    return "<p>{}</p>".format("<br>".join(html.escape(line) for line in lines))
