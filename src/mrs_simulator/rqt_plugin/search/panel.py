"""Searches among many runs: what may vary on the left, what was found on the right."""

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QFont, QPixmap
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QGridLayout,
    QLabel,
    QPlainTextEdit,
    QProgressBar,
    QPushButton,
    QSplitter,
    QStyle,
    QWidget,
)
from mrs_simulator.rqt_plugin.search.results import ASSURE, BREAK, MARGINS
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, page_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import PatientSpinBox, TextField
from mrs_simulator.rqt_plugin.widgets.form_beside import FormBeside
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.message_label import MessageLabel
from mrs_simulator.rqt_plugin.widgets.scrolled import scrolled

BUTTONS = (
    (BREAK, "Find counterexample", "Search the run that breaks a requirement, or a claim"),
    (ASSURE, "Assure", "Draw runs at random: how sure may one be that they keep it?"),
    (MARGINS, "Margins", "Along delay, loss, rate, wheels: where does each requirement break?"),
)
FORM = 19  # [lines of text] that the form is wide at first
# [characters, lines of text] widths of a table, and of a figure beside it
TABLE, LEAST_FIGURE = 46, 20
FEWEST, MOST, USUAL = 2, 100000, 500  # runs of a search
# What the command break varies by itself.
EMPTY = "Find counterexample: starts, one edge, and the law's parameters"
BEFORE = (
    "Find counterexample searches the run that breaks one of the scenario's requirements, or a claim "
    "of its theorem where it has none; Assure says how sure you may be that runs keep them; Margins "
    "how far robots may differ. They run in the background, on all cores but one."
)


@guarded
class SearchPanel(QWidget):
    """Asks for searches, and shows their progress and their ``Result``."""

    asked = Signal(str)  # the name of a command
    cancel_asked = Signal()
    run_asked = Signal()  # to show the counterexample
    scenario_asked = Signal()

    def __init__(self, parent=None):
        super().__init__(parent)
        form, results = self._build_form(), self._build_results()
        column_of(FormBeside(form, results, FORM), owner=self, margins=0)
        self._suggested = ""
        self.set_running(False)

    def _build_form(self):
        grid = QGridLayout()
        self.vary = QPlainTextEdit(tabChangesFocus=True, placeholderText=EMPTY)
        self.vary.setFont(_fixed_font(self))
        self.vary.setFixedHeight(4 * self.fontMetrics().height())
        self.vary.setToolTip(
            "A line for each: poses: {within: [x, y, x, y], apart: 0.9}, any key's path: [from, to]"
        )
        self.runs, self.share, self.confidence = PatientSpinBox(), TextField(True), TextField(True)
        self.runs.setRange(FEWEST, MOST)
        self.runs.setValue(USUAL)
        self.share.setText("0.99")
        self.confidence.setText("0.95")
        rows = (
            (self.runs, "Runs at most", "Of a search for a counterexample"),
            (self.share, "At least", "Assure: the share of runs that is to keep its requirements"),
            (self.confidence, "Confidence", "Assure: how sure one wants to be of that share"),
        )
        self.notes = {"vary": MessageLabel()}
        first = QLabel("What may vary")
        first.setBuddy(self.vary)
        for place, (field, title, tip) in enumerate(rows):
            label = QLabel(title)
            label.setBuddy(field)
            note = self.notes[title] = MessageLabel()
            for widget in (label, field):
                widget.setToolTip(tip)
            grid.addWidget(label, 2 * place, 0)
            grid.addWidget(field, 2 * place, 1)
            grid.addWidget(note, 2 * place + 1, 0, 1, 2)
        grid.setColumnStretch(1, 1)
        return page_of(first, self.vary, self.notes["vary"], *self._build_buttons(), grid, 1)

    def _build_buttons(self):
        self.buttons = {}
        for name, title, tip in BUTTONS:
            button = self.buttons[name] = QPushButton(title, toolTip=tip)
            button.clicked.connect(guarded(lambda *_, n=name: self.asked.emit(n)))
        self.cancel = QPushButton("Cancel", clicked=guarded(lambda *_: self.cancel_asked.emit()))
        beside = row_of(self.buttons[ASSURE], self.buttons[MARGINS], self.cancel)
        return self.buttons[BREAK], beside

    def _build_results(self):
        self.title, self.bar, self.text = MessageLabel("aside"), QProgressBar(), QPlainTextEdit()
        self.text.setReadOnly(True)
        self.text.setFont(_fixed_font(self))
        self.figure, self._picture = QLabel(alignment=Qt.AlignTop | Qt.AlignHCenter), QPixmap()
        self.show_run, self.load = QPushButton("Show counterexample"), QPushButton("Edit scenario")
        self.show_run.setToolTip("On the map, at the moment at which it breaks")
        self.load.setToolTip("Open the scenario that broke, in place of the one that is edited")
        self.show_run.clicked.connect(guarded(lambda *_: self.run_asked.emit()))
        self.load.clicked.connect(guarded(lambda *_: self.scenario_asked.emit()))
        self.shown_figure = scrolled(self.figure)
        self.beside = QSplitter(Qt.Horizontal)
        self.beside.addWidget(self.text)
        self.beside.addWidget(self.shown_figure)
        self.beside.splitterMoved.connect(guarded(lambda *_: self._fit_figure()))
        whole = page_of(self.title, self.bar, row_of(self.show_run, self.load, 1), (self.beside, 1))
        self.title.say(BEFORE)
        self.show_result(None)
        return whole

    # Showing -------------------------------------------------------------------------------------

    def suggest(self, text, anew):
        """Show what may vary of a scenario; what the user has typed stays.

        ``anew``: of another file, or asked for: an emptied list is filled, too.
        """
        said = self.vary.toPlainText()
        if said == self._suggested or (anew and not said.strip()):
            self.vary.setPlainText(text)
            self._suggested = text

    def show_errors(self, errors):
        """Show texts below the fields by the keys of ``notes``."""
        for name, note in self.notes.items():
            note.say(errors.get(name, ""))

    def set_running(self, on):
        """Show whether a search runs."""
        for button in self.buttons.values():
            button.setEnabled(not on)
        self.cancel.setEnabled(on)
        self.bar.setVisible(on)

    def show_progress(self, title, runs, most):
        """Say how far a search is: how many of ``most`` runs, None where their number is not known."""
        self.title.say(title, "aside")
        self.bar.setRange(0, most or 0)
        if most:
            self.bar.setValue(min(runs, most))

    def show_result(self, result):
        """Show a ``Result``, None for none."""
        self.text.setPlainText(result.text if result is not None else "")
        self.text.setVisible(bool(result is not None and result.text))
        self.show_run.setVisible(bool(result is not None and result.run))
        self.load.setVisible(bool(result is not None and result.scenario))
        self._picture = QPixmap(result.figure if result is not None else "")
        is_table = not self._picture.isNull()  # whose lines are kept
        self.text.setLineWrapMode(QPlainTextEdit.NoWrap if is_table else QPlainTextEdit.WidgetWidth)
        self.shown_figure.setVisible(is_table)
        self._share_room()

    def _share_room(self):
        """Show the figure beside the table where there is room for both, else below it."""
        wide = self.beside.width() - self.text.fontMetrics().horizontalAdvance("m") * TABLE
        across = wide > LEAST_FIGURE * self.fontMetrics().height()
        self.beside.setOrientation(Qt.Horizontal if across else Qt.Vertical)
        length = self.beside.width() if across else self.beside.height()
        self.beside.setSizes([length - wide, wide] if across else [length // 2] * 2)
        self._fit_figure()

    def _fit_figure(self):
        area = self.shown_figure
        bar = area.style().pixelMetric(QStyle.PM_ScrollBarExtent)
        room = (area.width() - bar) * self.devicePixelRatioF()
        if not self._picture.isNull() and room > 0:
            wide = min(room, self._picture.width())
            shown = self._picture.scaledToWidth(int(wide), Qt.SmoothTransformation)
            shown.setDevicePixelRatio(self.devicePixelRatioF())
            self.figure.setPixmap(shown)

    def resizeEvent(self, event):
        """Show the figure as wide as there is room."""
        super().resizeEvent(event)
        self._share_room()


def _fixed_font(widget):
    """Return a font of the size of the widget's, in which all characters are of one width."""
    font = QFont(widget.font())
    font.setFamily("monospace")
    font.setStyleHint(QFont.TypeWriter)
    return font
