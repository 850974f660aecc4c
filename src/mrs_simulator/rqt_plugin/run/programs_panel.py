"""Programs of the study with their states, output and exit codes, and the diagnostics of all nodes."""

import re

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QSplitter,
    QTabWidget,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.verdict.results_table import ResultsTable
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded

HEADERS = (("program", "Name of the program"), ("state", "Whether it runs, or how it ended"))
NODES = (
    ("node", "The node and its part"),
    ("level", "good, warning, error, or stale: nothing received for 5 s"),
    ("message", "The part's message"),
)
STATE, LEVEL, MESSAGE = 1, 1, 2  # columns
WIDE = 17  # [lines of text] of width that the list of programs has at first
ACTIONS = (
    ("start", "Start", "Start the program selected"),
    ("end", "End", "End it: by INT, TERM and KILL in turn"),
    ("restart", "Restart", "End it, then start it again"),
    ("kill", "Kill", "Kill it and its child processes at once"),
    ("remove", "Remove", "Remove a program of your own from this list"),
)
COMMAND = "rosrun my_package my_node"
ANY = "python3 my_program.py"  # without ROS
TIP = "A program of your own: {}, roslaunch my_package my.launch, or any command"
ANONYMOUS = re.compile(r"_\d+_\d{13}(?=$|:)")
SILENT = "No output yet."
QUIET = "Nothing has been received on /diagnostics yet."


@guarded
class ProgramsPanel(QWidget):
    """Shows ``Program``s; ``asked`` emits an action and a name, ``added`` a command."""

    asked = Signal(str, str)
    added = Signal(str)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._programs, self._users, self._states, self._levels = (), (), None, None
        self.table, self.nodes = ResultsTable(HEADERS, STATE), ResultsTable(NODES, MESSAGE)
        self.table.itemSelectionChanged.connect(guarded(self._offer))
        self.output, self.command = QPlainTextEdit(readOnly=True), QLineEdit()
        self.details = QTabWidget()
        self.details.addTab(self.output, "Output")
        self.details.addTab(self.nodes, "Diagnostics")
        self.across = QSplitter(Qt.Horizontal)
        self.across.addWidget(self._build_programs())
        self.across.addWidget(self.details)
        self.across.setStretchFactor(1, 1)
        line = self.fontMetrics().height()
        self.across.setSizes([WIDE * line, 2 * WIDE * line])
        column_of(self.across, owner=self, margins=4)

    def _build_programs(self):
        self.buttons, first = {}, FlowLayout()
        for name, text, tip in ACTIONS:
            button = self.buttons[name] = QToolButton(text=text, toolTip=tip)
            button.clicked.connect(guarded(lambda *_, n=name: self.asked.emit(n, self.selected)))
            first.addWidget(button)
        self.command.setPlaceholderText(COMMAND)
        self.command.setToolTip(TIP.format(COMMAND))
        self.command.returnPressed.connect(self._on_added)
        self.add = QPushButton("Add", toolTip="Add the command to the list without starting it")
        self.add.clicked.connect(self._on_added)
        return page_of(first, (self.table, 1), row_of((self.command, 1), self.add), margins=0)

    def hide_absent(self, absent):
        """Disable what is ``absent``, with the reason; names as of ``Connection.absent``."""
        if "diagnostics" in absent:
            self.details.setTabEnabled(1, False)
            self.details.setTabToolTip(1, absent["diagnostics"])
        if "rosrun" in absent:
            self.command.setPlaceholderText(ANY)
            self.command.setToolTip("A program of your own: any command")

    @property
    def selected(self):
        """Return the name of the program selected, "" for none."""
        rows = {index.row() for index in self.table.selectedIndexes()}
        return self._programs[min(rows)].name if rows and min(rows) < len(self._programs) else ""

    def select(self, name):
        """Select the program called ``name``."""
        names = [program.name for program in self._programs]
        if name in names:
            self.table.selectRow(names.index(name))

    def show_programs(self, programs, users=()):
        """Show each ``Program``; ``users``: names of those that may be removed."""
        chosen, self._programs, self._users = self.selected, tuple(programs), tuple(users)
        rows = [(program.title, program.state) for program in programs]
        tips = ["{}\n{}".format(program.tip, program.state) for program in programs]
        states = [(program.name, program.is_running, program.failed) for program in programs]
        if states == self._states:
            self.table.change_texts(rows, tips)
        else:
            self._states = states
            tints = [(k, STATE, "good") for k, each in enumerate(programs) if each.is_running]
            tints += [(k, STATE, "error") for k, each in enumerate(programs) if each.failed]
            self.table.set_rows(rows, tips, tints)
            self.select(chosen or "stage")
        self._offer()

    def _offer(self):
        """Enable what can be done with the program selected."""
        found = [program for program in self._programs if program.name == self.selected]
        one = found[0] if found else None
        possible = {
            "start": one is not None and not one.can_start,
            "end": one is not None and one.is_running,
            "restart": one is not None and (one.is_running or not one.can_start),
            "kill": one is not None and one.is_running,
            "remove": one is not None and one.name in self._users and not one.is_running,
        }
        for name, _, tip in ACTIONS:
            why = one.can_start if one is not None and name == "start" else ""
            self.buttons[name].setEnabled(possible[name])
            self.buttons[name].setToolTip(tip + ("\nNot now: " + why if why else ""))

    def show_output(self, text):
        """Show what the program selected has printed; the end stays in view if it was."""
        text = text or SILENT
        if text == self.output.toPlainText():
            return
        bar = self.output.verticalScrollBar()
        was, at_end = bar.value(), bar.value() >= bar.maximum() - 1
        self.output.setPlainText(text)
        bar.setValue(bar.maximum() if at_end else was)

    def show_diagnostics(self, parts):
        """Show each ``Part`` of ``/diagnostics``."""
        rows = [(short(part.name), part.level, part.message) for part in parts]
        rows = rows or [("", "", QUIET)]
        tips = [part_text(part) for part in parts] or [QUIET]
        levels = [row[:2] for row in rows]
        if levels == self._levels:
            self.nodes.change_texts(rows, tips)
        else:
            self._levels = levels
            tints = [(k, LEVEL, TINTS[part.level]) for k, part in enumerate(parts)]
            self.nodes.set_rows(rows, tips, tints)
        count = sum(part.level in ("warning", "error") for part in parts)
        title = "Diagnostics ({})".format(count) if count else "Diagnostics"
        self.details.setTabText(1, title)

    def _on_added(self, *_):
        self.added.emit(self.command.text())


TINTS = {"good": "good", "warning": "warning", "error": "error", "stale": "aside"}


def short(name):
    """Return the ``name`` of a node or a part of one without what rospy adds to an anonymous node's."""
    return ANONYMOUS.sub("", name)


def part_text(part):
    """Return the whole text of a ``Part``, for a tooltip."""
    lines = ["{}: {}".format(part.name, part.message)]
    lines += ["{} = {}".format(*pair) for pair in part.values]
    return "\n".join(lines + ["{:.0f} s ago".format(part.age)])
