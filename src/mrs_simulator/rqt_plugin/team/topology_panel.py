"""The topology editor: table of edges, and the quantities that decide convergence."""

from mrs_simulator.core.graphs import PRESETS, Topology, edges_without
from mrs_simulator.core.spectra import ZERO, algebraic_connectivity
from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QSpinBox,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)
from mrs_simulator.rqt_plugin.widgets.boxes import column_of, row_of
from mrs_simulator.rqt_plugin.widgets.commas import comma_remark
from mrs_simulator.rqt_plugin.widgets.fields import PointSpinBox
from mrs_simulator.rqt_plugin.widgets.guard import guarded

MOST_ANALYSED = 200  # robots up to which eigenvalues are computed while editing
# Presets with an amount: its first value, suffix, decimals, and what it is.
AMOUNTS = {
    "random": (0.3, "", 2, "probability of an edge, in addition to a spanning tree"),
    "erdos_renyi": (0.3, "", 2, "probability of an edge; the graph may be disconnected"),
    "proximity": (5.0, " m", 2, "radius of the proximity graph"),
    "k_nearest": (3.0, "", 0, "number of nearest neighbours of each robot"),
}
SEEDED = ("random", "erdos_renyi")
MADE = PRESETS + tuple(AMOUNTS)
COLUMNS = ("robot", "neighbour", "weight")


@guarded
class TopologyPanel(QWidget):
    """A table of edges, presets, and lambda_2 with what follows from it, updated while editing."""

    topology_changed = Signal(object, bool)  # edges (i, j, weight), directed

    def __init__(self, parent=None):
        super().__init__(parent)
        self._n, self._points, self._edges, self._directed = 1, None, [], True
        self._filling = False
        self._build()
        self._show()

    def _build(self):
        presets = self._build_presets()
        self.as_directed = QCheckBox("directed: the neighbour sends to the robot", checked=True)
        self.as_directed.toggled.connect(self._on_directed)
        self.table = QTableWidget(0, len(COLUMNS))
        self.table.setHorizontalHeaderLabels(COLUMNS)
        self.table.horizontalHeader().setSectionResizeMode(QHeaderView.Stretch)
        self.table.verticalHeader().hide()
        self.table.setSelectionBehavior(QAbstractItemView.SelectRows)
        self.table.cellChanged.connect(self._on_cell)
        remove = QPushButton("Remove selected", clicked=self._on_remove)
        clear = QPushButton("Remove all", clicked=guarded(lambda *_: self._change([])))
        below = row_of(remove, clear), self._build_figures()
        column_of(presets, self.as_directed, (self.table, 1), *below, owner=self)

    def _build_presets(self):
        self.preset = QComboBox()
        self.preset.addItems(MADE)
        self.preset.currentTextChanged.connect(self._on_preset)
        self.amount = PointSpinBox()
        self.amount.setRange(0.0, 1000.0)
        self.seed = QSpinBox(toolTip="seed of the random graph")
        self.seed.setRange(0, 10**6)
        make = QPushButton("Make", toolTip="Replace all edges by this preset")
        make.clicked.connect(self._on_make)
        self._on_preset(self.preset.currentText())
        return row_of(QLabel("Replace by"), self.preset, self.amount, self.seed, make)

    def _build_figures(self):
        form = QFormLayout()
        self._figures = {}
        for key, title, tip in (
            ("edges", "edges", "number of edges"),
            ("tree", "spanning tree", "whether some robot's state reaches all others along edges"),
            ("lambda", "\u03bb\u2082", "algebraic connectivity: second smallest real part of L"),
            (
                "time",
                "converges in",
                "convergence time predicted by theory for this protocol, graph and initial poses; "
                "\u2013 where there is no prediction",
            ),
        ):
            label = QLabel("\u2013", toolTip=tip)
            self._figures[key] = label
            form.addRow(title, label)
        self.message = QLabel(wordWrap=True)
        form.addRow(self.message)
        return form

    # Inputs --------------------------------------------------------------------------------------

    def set_topology(self, edges, directed):
        """Show ``edges``, ``(i, j, weight)``; no signal."""
        edges = [tuple(edge) for edge in edges]
        if edges != self._edges or directed != self._directed:
            self._edges, self._directed = edges, bool(directed)
            self._show()

    def set_team(self, points):
        """Take in the robots' positions (n, 2) [m]; edges of robots that are gone go with them."""
        self._points = points
        if len(points) != self._n:
            self._n = len(points)
            self._edges = [edge for edge in self._edges if max(edge[:2]) <= self._n]
            self._show()

    def set_convergence_time(self, text):
        """Show the predicted convergence time, a text; "" without a prediction."""
        self._figures["time"].setText(text or "\u2013")

    def edges(self):
        """Return the edges ``(i, j, weight)``."""
        return list(self._edges)

    def directed(self):
        """Return whether edges count one way."""
        return self._directed

    def figure(self, key):
        """Return the text shown for ``key``: edges, tree, lambda or time."""
        return self._figures[key].text()

    def add_edge(self, i, j):
        """Add the edge over which robot i receives from robot j."""
        self._change(self._edges + [(i, j, 1.0)])

    def remove_edge(self, i, j):
        """Remove the edge between i and j, either way round if undirected."""
        self._change(self.without(i, j))

    def without(self, i, j):
        """Return the edges without the one between i and j, either way round if undirected."""
        return edges_without(self._edges, [(i, j)], self._directed)

    # What a person does --------------------------------------------------------------------------

    def _on_preset(self, name):
        self.seed.setVisible(name in SEEDED)
        self.amount.setVisible(name in AMOUNTS)
        if name in AMOUNTS:
            value, suffix, decimals, tip = AMOUNTS[name]
            self.amount.setDecimals(decimals)
            self.amount.setSuffix(suffix)
            self.amount.setValue(value)
            self.amount.setToolTip(tip)

    def _on_make(self, *_):
        try:
            made = self._made(self.preset.currentText())
        except ValueError as error:
            self.message.setText(str(error))
            return
        self._change(made.edges, made.directed)

    def _made(self, name):
        """Return the graph of the preset ``name`` over this team."""
        amount, seed = self.amount.value(), self.seed.value()
        if name == "random":
            return Topology.random(self._n, min(1.0, amount), seed)
        if name == "erdos_renyi":
            return Topology.erdos_renyi(self._n, min(1.0, amount), seed, self._directed)
        if name == "proximity":
            return Topology.proximity(self._points, amount)
        if name == "k_nearest":
            return Topology.k_nearest(self._points, int(amount), self._directed)
        return Topology.preset(name, self._n)

    def _on_directed(self, directed):
        if not self._filling:
            edges = self._edges
            if not directed:  # one of two opposite edges is enough
                edges = [e for e in edges if e[0] < e[1] or (e[1], e[0]) not in _pairs(edges)]
            self._change(edges, directed)

    def _on_remove(self, *_):
        rows = {index.row() for index in self.table.selectedIndexes()}
        self._change([edge for row, edge in enumerate(self._edges) if row not in rows])

    def _on_cell(self, row, column):
        if self._filling:
            return
        edge = list(self._edges[row])
        text = self.table.item(row, column).text()
        try:
            edge[column] = float(text) if column == 2 else int(text)
            edges = list(self._edges)
            edges[row] = tuple(edge)
        except ValueError:
            remark = comma_remark(text)
            self.message.setText("{!r}: wanted a number{}".format(text, remark))
            self._show_table()
            return
        self._change(edges)

    def _change(self, edges, directed=None):
        directed = self._directed if directed is None else directed
        try:
            Topology(self._n, edges, directed)
        except ValueError as error:
            self.message.setText(str(error))
            self._show_table()
            return
        self.message.clear()
        self._edges, self._directed = [tuple(edge) for edge in edges], directed
        self._show()
        self.topology_changed.emit(self.edges(), self._directed)

    # Showing -------------------------------------------------------------------------------------

    def _show(self):
        self._filling = True
        self.as_directed.setChecked(self._directed)
        self._filling = False
        self._show_table()
        self._show_figures()

    def _show_table(self):
        self._filling = True
        self.table.setRowCount(len(self._edges))
        for row, edge in enumerate(self._edges):
            for column, value in enumerate(edge):
                item = QTableWidgetItem("{:g}".format(value))
                item.setTextAlignment(Qt.AlignCenter)
                self.table.setItem(row, column, item)
        self._filling = False

    def _show_figures(self):
        topology = Topology(self._n, self._edges, self._directed)
        self._figures["edges"].setText(str(len(self._edges)))
        self._figures["tree"].setText("yes" if topology.has_spanning_tree() else "no")
        if self._n > MOST_ANALYSED:
            self._figures["lambda"].setText("not computed above {} robots".format(MOST_ANALYSED))
            return
        self._figures["lambda"].setText(connectivity_text(topology))


def connectivity_text(topology):
    """Return ``lambda_2`` of the ``topology`` as it is written."""
    slowest = algebraic_connectivity(topology)
    return "{:.4g}".format(slowest if abs(slowest) > ZERO else 0.0)


def _pairs(edges):
    return {edge[:2] for edge in edges}
