"""Ready-made layouts of a team, with their parameters."""

from mrs_simulator.core.fields import Parameter
from mrs_simulator.rqt_plugin.protocol.parameter_form import ParameterForm
from mrs_simulator.rqt_plugin.qt.QtCore import Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import QGroupBox, QPushButton
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.fields import NoWheelComboBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.scenario.team.layouts import LAYOUTS, make_layout

ORDER = ("line", "circle", "grid", "random")
SEED = Parameter("seed", 0, low=0, meaning="the same seed gives the same layout")


@guarded
class LayoutBox(QGroupBox):
    """Offers layouts; ``chosen`` emits the poses (n, 3) [m, m, rad] of one, ``refused`` an error."""

    chosen = Signal(object)
    refused = Signal(str)

    def __init__(self, count, parent=None):
        """``count()``: returns the number of robots."""
        super().__init__("Layout", parent)
        self._count = count
        self.names = NoWheelComboBox()
        self.names.setToolTip("Arrangement of all robots")
        self.names.addItems(sorted(LAYOUTS, key=lambda name: (ORDER + (name,)).index(name)))
        self.names.currentIndexChanged.connect(self._on_name)
        self._apply = QPushButton("Apply", toolTip="Place all robots in this layout")
        self._apply.clicked.connect(self._on_apply)
        self._another = QPushButton("Another", clicked=self._on_another)
        self._another.setToolTip("Place all robots in another random layout, with the next seed")
        self.form = ParameterForm()
        self._values = {}  # of all layouts seen so far
        column_of(row_of((self.names, 1), self._apply, self._another), self.form, owner=self)
        self._on_name()

    def _on_name(self, *_):
        name = self.names.currentText()
        self._values.update(self.form.values())
        self.form.set_parameters(
            LAYOUTS[name] + ((SEED,) if name == "random" else ()), self._values
        )

        self._another.setVisible(name == "random")

    def _on_apply(self, *_):
        if self.form.finish():
            self._apply_layout()

    def _on_another(self, *_):
        if self.form.finish():
            self._values.update(self.form.values())
            self._values["seed"] += 1
            self.form.set_parameters(LAYOUTS["random"] + (SEED,), self._values)
            self._apply_layout()

    def _apply_layout(self):
        try:
            poses = make_layout(self.names.currentText(), self._count(), **self.form.values())
        except ValueError as error:
            self.refused.emit(str(error))
            return
        self.chosen.emit(poses)
