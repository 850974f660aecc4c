"""A dialog that composes one figure of a saved run, and shows the command that makes it again."""

import html
import os
import shlex

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, QTimer, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QPixmap
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPushButton,
)
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen

PANELS = (  # of the command ``figure``, and their names
    ("trajectories", "Trajectories"),
    ("x", "x"),
    ("y", "y"),
    ("z", "z"),
    ("inputs", "Inputs"),
    ("error", "Formation error"),
)
FIRST = ("trajectories", "x")  # chosen at first
WIDTHS = ("page", "column", "slide", "88mm")
REST = 0.4  # [s] without another choice, after which the figure is drawn
EVERY = 100  # [ms] between two looks whether it is
LIMIT = 120.0  # [s] of wall time for a figure
SMALLEST = 24  # [lines of text], the least height of the picture
NONE_COMPARED = "Runs ticked on the list Runs are laid over this one"
DRAWING = "drawing ..."
KINDS = "Figures (*.pdf *.png *.svg)"


@guarded
class Composer(QDialog):
    """Choices on the left, the figure on the right, its command below; other windows stay in use."""

    saved = Signal(str)  # the path of a figure

    def __init__(self, parent, processes, directory, ask, compared=()):
        """``directory``: of the run; ``ask``: asks for a path, as ``ScenarioFiles.ask`` does.

        ``compared``: ``(name, path)`` of the run and of those laid over it, () for none.
        """
        super().__init__(parent)
        self.setWindowTitle("Compose a figure of {}".format(os.path.basename(directory)))
        self._processes, self._directory, self._ask = processes, directory, ask
        self._compared = list(compared)
        self._worker, self._picture = DebouncedWorker(REST), QPixmap()
        OnScreen(self)
        self.preview, self.note = QLabel(alignment=Qt.AlignCenter), MessageLabel("aside")
        height = SMALLEST * self.fontMetrics().height()
        self.preview.setMinimumSize(height, height)
        self.command = QLineEdit(readOnly=True)
        across = row_of(self._build_choices(), (self.preview, 1))
        self.copy, self.save = QPushButton("Copy", clicked=self._on_copy), QPushButton("Save...")
        self.copy.setToolTip("Copy the command that makes this figure")
        self.save.clicked.connect(self._on_save)
        last = row_of((self.command, 1), self.copy, self.save)
        column_of((across, 1), self.note, last, owner=self)
        self._timer = QTimer(self, timeout=self._on_timer)
        self._timer.start(EVERY)
        self._on_choice()

    def _build_choices(self):
        grid = QGridLayout()
        self.panels = {}
        for name, title in PANELS:
            box = self.panels[name] = QCheckBox(title, checked=name in FIRST)
            box.toggled.connect(self._on_choice)
            grid.addWidget(box, grid.rowCount(), 0, 1, 2)
        self.robots, self.begin, self.end = QLineEdit(), QLineEdit(), QLineEdit()
        self.width_box, self.theory = QComboBox(editable=True), QCheckBox("Theory", checked=True)
        self.width_box.addItems(WIDTHS)
        self.width_box.setToolTip("page (6.5 in), column (3.5 in), slide, or a length such as 88mm")
        for title, field, hint in (
            ("Robots", self.robots, "all, or 1,3-5"),
            ("From [s]", self.begin, "the beginning"),
            ("To [s]", self.end, "the end"),
        ):
            field.setPlaceholderText(hint)
            room = self.fontMetrics().horizontalAdvance(hint) + self.fontMetrics().height()
            field.setMinimumWidth(room)
            field.textChanged.connect(self._on_choice)
            self._add_row(grid, title, field)
        self._add_row(grid, "Width", self.width_box)
        self.width_box.currentTextChanged.connect(self._on_choice)
        self.compare = QCheckBox("Compared runs", enabled=len(self._compared) > 1)
        self.compare.setChecked(len(self._compared) > 1)
        names = ", ".join(name for name, _ in self._compared) or NONE_COMPARED
        self.compare.setToolTip("<p>{}</p>".format(html.escape(names)))
        for box in (self.theory, self.compare):
            grid.addWidget(box, grid.rowCount(), 0, 1, 2)
            box.toggled.connect(self._on_choice)
        grid.setRowStretch(grid.rowCount(), 1)
        return grid

    @staticmethod
    def _add_row(grid, title, field):
        row, label = grid.rowCount(), QLabel(title)
        label.setBuddy(field)
        grid.addWidget(label, row, 0)
        grid.addWidget(field, row, 1)

    def arguments(self, path):
        """Return the words of the command ``figure`` that writes to ``path`` what is chosen."""
        words = [self._directory, "--out", path, "--width", self.width_box.currentText().strip()]
        words += [
            "--panels",
            ",".join(name for name, box in self.panels.items() if box.isChecked()),
        ]
        robots, begin, end = (each.text().strip() for each in (self.robots, self.begin, self.end))
        words += ["--robots", robots] if robots else []
        words += ["--between", begin or "0", end or "inf"] if begin or end else []
        if self.compare.isChecked():
            names, paths = zip(*self._compared)
            words += ["--compare", *paths[1:], "--names", *names]
        return words + ([] if self.theory.isChecked() else ["--no-theory"])

    def _on_choice(self, *_):
        words = self.arguments("figure.pdf")
        self.command.setText(" ".join(map(shlex.quote, ["mrs-simulator", "figure", *words])))
        self.command.setCursorPosition(0)
        for each in (self.begin, self.end):
            if comma_remark(each.text()):
                self._worker.ask(None)
                said = "{!r}: wanted a number{}"
                self.note.say(said.format(each.text(), comma_remark(each.text())), "error")
                return
        self.note.say(DRAWING, "aside")
        path = os.path.join(self._processes.directory, "composed.png")
        asked = self.arguments(path)
        self._worker.ask(lambda: self._draw(asked))

    def _draw(self, words):
        """Run the command ``figure`` with ``words``; raise ``ValueError`` with what it says."""
        code, output = self._processes.run("figure", "figure", *words, limit=LIMIT)
        if code:
            raise ValueError(output.strip() or "ended with exit code {}".format(code))
        return words[words.index("--out") + 1]

    def _on_timer(self):
        answer = self._worker.take()
        if answer is None:
            return
        path, error = answer
        if error is not None:
            self.note.say(reason(error), "error")
            return
        if path.endswith("composed.png"):
            self._picture = QPixmap(path)
            self._show_picture()
            self.note.say("", "aside")
            return
        self.note.say("saved {}".format(os.path.abspath(path)), "good")
        self.saved.emit(path)

    def _show_picture(self):
        if not self._picture.isNull():
            how = Qt.KeepAspectRatio, Qt.SmoothTransformation
            ratio = self.preview.devicePixelRatioF()
            shown = self._picture.scaled(self.preview.size() * ratio, *how)
            shown.setDevicePixelRatio(ratio)
            self.preview.setPixmap(shown)

    def resizeEvent(self, event):
        """Show the figure in its new size."""
        super().resizeEvent(event)
        self._show_picture()

    def _on_copy(self, *_):
        QApplication.clipboard().setText(self.command.text())

    def _on_save(self, *_):
        def chosen(path):
            words = self.arguments(path)
            self.note.say(DRAWING, "aside")
            self._worker.ask(lambda: self._draw(words))

        self._ask("Save the figure", "figure.pdf", KINDS, chosen, saves=True)

    @guarded
    def done(self, result):
        """Draw nothing more, and go."""
        self._worker.ask(None)
        self._processes.cancel("figure")
        self._timer.stop()
        super().done(result)
        self.deleteLater()
