"""What the team would lose with the edge under the mouse, before a click removes it."""

from mrs_simulator.core.graphs import Topology
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.team.topology_panel import MOST_ANALYSED, connectivity_text
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded

REST = 0.1  # [s] that the mouse rests on an edge until theory is asked
NOTHING = "\u2013"


class EdgeLens:
    """Shows at an edge of the map the connectivity and the settling time without it."""

    def __init__(self, panels, study):
        self._panels, self._study = panels, study
        self._worker, self._topology, self._answer = DebouncedWorker(REST), None, None
        panels.map.edge_hovered.connect(self._on_hover)

    @guarded
    def _on_hover(self, edge):
        self._topology, self._answer = self._without(edge) if edge else None, None
        if self._topology is None:
            self._worker.ask(None)
            return
        settling_with, topology = self._study.edited.settling_with, self._topology
        self._worker.ask(lambda: settling_with(topology))
        self.follow()

    def _without(self, edge):
        """Return the graph without ``edge``, None where the edge is not of the edited one."""
        shown, edited = self._panels.topology, self._study.edited
        edges = shown.without(*edge[:2])
        if len(edges) == len(shown.edges()):
            return None
        return Topology(edited.scenario.n, edges, shown.directed())

    def follow(self):
        """Show what is known of the edge under the mouse by now."""
        self._answer = self._worker.take() or self._answer
        shown = self._panels.map
        if self._topology is not None and shown.hovered is not None:
            lines = [shown.edges.described(shown.hovered), *self._lines()]
            shown.show_hover_text("\n".join(lines))

    def _lines(self):
        topology, figure = self._topology, self._panels.topology.figure
        tree = "a" if topology.has_spanning_tree() else "no"
        yield "without it: {} spanning tree".format(tree)
        if topology.n <= MOST_ANALYSED:
            values = connectivity_text(topology), figure("lambda")
            yield "\u03bb\u2082 = {}, now {}".format(*values)
        settling, error = self._answer or ("...", None)
        if error is not None:
            yield "the protocol refuses it: {}".format(reason(error))
        elif figure("time") != NOTHING or settling not in ("", "..."):
            yield "converges in " + settling if settling else "no convergence is predicted"
            yield "now in {}".format(figure("time"))

    def close(self):
        """Ask for nothing more."""
        self._worker.ask(None)
