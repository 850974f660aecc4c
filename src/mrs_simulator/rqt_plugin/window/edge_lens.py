"""What the team would lose with the edge under the mouse, before a click removes it."""

from mrs_simulator.core.graphs import Topology, edges_without
from mrs_simulator.rqt_plugin.run.error_message import reason
from mrs_simulator.rqt_plugin.team.topology_panel import MOST_ANALYSED, connectivity_text
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.rqt_plugin.widgets.guard import guarded

REST = 0.1  # [s] that the mouse rests on an edge until theory is asked
NOTHING = "\u2013"


@guarded
class EdgeLens:
    """Shows at an edge of the map the connectivity and the settling time without it."""

    def __init__(self, panels, study, opened, replay):
        self._panels, self._study, self._opened, self._replay = panels, study, opened, replay
        self._worker, self._topology, self._answer = DebouncedWorker(REST), None, None
        self._now = None  # the graph of the opened run with that edge, None for the edited one
        panels.map.edge_hovered.connect(self._on_hover)

    def _on_hover(self, edge):
        self._topology, self._answer = None, None
        scenario = self._of_opened() if edge else None
        self._now = None if scenario is None else scenario.topology
        if edge and self._opened.run is None:
            shown, n = self._panels.topology, self._study.scenario.n
            self._topology = self._without(edge, Topology(n, shown.edges(), shown.directed()))
        elif scenario is not None:
            self._topology = self._without(edge, self._now)
        if self._topology is None:
            self._worker.ask(None)
            return
        settling_with, topology = self._study.edited.settling_with, self._topology
        if scenario is None:
            self._worker.ask(lambda: (settling_with(topology), None))
        else:
            graphs = topology, scenario.topology
            self._worker.ask(lambda: tuple(settling_with(graph, scenario) for graph in graphs))
        self.follow()

    def _of_opened(self):
        """Return the scenario of the opened run at the moment shown, None where it is not known."""
        run = self._opened.run
        facts = None if run is None else run.facts_at(self._replay.cursor.row)
        if facts is None:
            return None
        control = run.scenario.control._replace(parameters=facts.values)
        return run.scenario._replace(topology=facts.topology, control=control)

    @staticmethod
    def _without(edge, topology):
        """Return ``topology`` without ``edge``, None where it has no such edge."""
        edges = edges_without(topology.edges, [edge], topology.directed)
        if len(edges) == len(topology.edges):
            return None
        return Topology(topology.n, edges, topology.directed)

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
            now = figure("lambda") if self._now is None else connectivity_text(self._now)
            yield "\u03bb\u2082 = {}, now {}".format(connectivity_text(topology), now)
        (settling, now), error = self._answer or (("...", "..."), None)
        if error is not None:
            yield "the protocol refuses it: {}".format(reason(error))
            return
        now = figure("time") if self._now is None else now or NOTHING
        if now != NOTHING or settling not in ("", "..."):
            yield "converges in " + settling if settling else "no convergence is predicted"
            yield "now in {}".format(now)

    def close(self):
        """Ask for nothing more."""
        self._worker.ask(None)
