"""Faults of the graph's edges as a scenario states them: delay, loss and switching times.

Edges are written ``(i, j)``, robots from 1: "i receives from j".
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, number, unwanted

ON_LOSS = ("hold", "drop")
CARRIES = ("state", "difference")
ORDERS = ("periodic", "random")
LONGEST_DELAY = 100.0  # [s]
MOST_SETS = 1000


class PerEdge(NamedTuple):
    """A value of every edge: ``default``, and others for ``edges``, ``(i, j, value)``."""

    default: float = 0.0
    edges: Tuple[Tuple[int, int, float], ...] = ()

    def matrix(self, n):
        """Return the values, (n, n), rows receive from columns; 0 on the diagonal.

        Edges of robots beyond n are left out.
        """
        values = np.full((n, n), self.default)
        for i, j, value in self.edges:
            if max(i, j) <= n:
                values[i - 1, j - 1] = value
        np.fill_diagonal(values, 0.0)
        return values

    def is_symmetric(self, n):
        """Return whether both directions of each edge have the same value."""
        values = self.matrix(n)
        return np.array_equal(values, values.T)

    def to_plain(self, n):
        """Return the value that a scenario over n robots gives, a number or a mapping."""
        kept = [list(edge) for edge in self.edges if max(edge[:2]) <= n]
        return {"default": self.default, "edges": kept} if kept else self.default


class Switching(NamedTuple):
    """Which edges of the topology are up in each turn.

    ``graphs``: a tuple of edges (i, j) for each; without them edge k of the topology is up in graph
    k mod ``sets``.  A turn lasts ``dwell`` [s], rounded to whole command periods; the graphs come
    one after the other, or ("random") each turn draws one with equal probability.
    """

    sets: int = 1
    graphs: Tuple[Tuple[Tuple[int, int], ...], ...] = ()
    dwell: float = 0.5
    order: str = "periodic"

    @property
    def count(self):
        """Return how many graphs there are; 1 without ``graphs`` is no switching."""
        return len(self.graphs) or self.sets


class Links(NamedTuple):
    """The faults of all edges; the default has none.

    ``delay`` [s], rounded to whole command periods, and ``loss``, the chance that what is sent over
    an edge at one command never arrives, independent of all else; ``symmetric``: it is lost both ways
    at once.  After a loss the receiver holds what it received last, or drops the edge for this
    command: hold as in Schenato, "To zero or to hold control inputs with lossy links?", 2009; drop as
    in Fagnani and Zampieri, "Average consensus with packet drop communication", 2009.

    ``carries``: "state", the sender's pose: the receiver's own is not delayed
    (Moreau, 2004); or "difference", the relative position as the receiver measured it, so that both
    terms are of the same age (Olfati-Saber and Murray, 2004).
    """

    delay: PerEdge = PerEdge()
    loss: PerEdge = PerEdge()
    on_loss: str = "hold"
    symmetric: bool = False
    carries: str = "state"
    switching: Switching = Switching()

    @property
    def faults(self):
        """Return the kinds of faults, such as "delayed and lossy"; "" without any."""
        words = [
            word
            for word, value in (("delayed", self.delay), ("lossy", self.loss))
            if value.default > 0.0 or any(edge[2] > 0.0 for edge in value.edges)
        ]
        words += ["switching"] if self.switches else []
        return " and ".join(words)

    @property
    def switches(self):
        """Return whether edges of the topology come and go in turns."""
        return self.switching.count > 1 or bool(self.switching.graphs)

    @property
    def changes_edges(self):
        """Return whether the graph itself changes, besides what its edges carry."""
        return self.switches or (self.on_loss == "drop" and "lossy" in self.faults)

    def to_plain(self, n):
        """Return the links as a scenario over n robots gives them."""
        plain = {
            "delay": self.delay.to_plain(n),
            "loss": self.loss.to_plain(n),
            "on_loss": self.on_loss,
            "symmetric": self.symmetric,
            "carries": self.carries,
        }
        if self.switches:
            plain["switching"] = {"dwell": self.switching.dwell, "order": self.switching.order}
            graphs = [
                [list(edge) for edge in graph if max(edge) <= n] for graph in self.switching.graphs
            ]
            plain["switching"].update(
                {"graphs": graphs} if graphs else {"sets": self.switching.sets}
            )
        return plain


NO_FAULTS = Links()


@explained_by("docs/scenarios.md#edges-with-faults")
def read_links(top, others):
    """Return the ``Links`` under ``links`` of the section ``top``.

    Raises ``ScenarioError``, also for edges that are switched and not in the ``topology`` of ``others``.
    """
    section, n = Section(top.take("links", {}), top.at("links")), top.n
    links = Links(
        delay=_read_per_edge(section, "delay", n, LONGEST_DELAY),
        loss=_read_per_edge(section, "loss", n, 1.0),
        on_loss=section.text("on_loss", "hold", ON_LOSS),
        symmetric=section.flag("symmetric", False),
        carries=section.text("carries", "state", CARRIES),
        switching=_read_switching(section, n, others["topology"]),
    )
    section.done()
    if links.symmetric and not links.loss.is_symmetric(n):
        text = "{}: true, but loss differs between the two directions of an edge"
        raise ScenarioError(text.format(section.at("symmetric")))
    return links


def _read_per_edge(section, key, n, high):
    given = section.take(key, 0.0)
    if not isinstance(given, dict):
        return PerEdge(number(given, section.at(key), low=0.0, high=high))
    inner = Section(given, section.at(key))
    default = inner.number("default", 0.0, low=0.0, high=high)
    edges = []
    for place, row in inner.items("edges", "a list of [i, j, value]"):
        if not isinstance(row, list) or len(row) != 3:
            raise unwanted(place, row, "[i, j, value]")
        pair = _read_pair(row[:2], place, n)
        if pair in [edge[:2] for edge in edges]:
            raise ScenarioError("{}: edge {} is given twice".format(place, list(pair)))
        edges.append(pair + (number(row[2], place, low=0.0, high=high),))
    inner.done()
    return PerEdge(default, tuple(edges))


def _read_pair(pair, place, n):
    whole = isinstance(pair, list) and len(pair) == 2
    whole = whole and all(isinstance(r, int) and not isinstance(r, bool) for r in pair)
    if not whole or not all(1 <= robot <= n for robot in pair) or pair[0] == pair[1]:
        raise unwanted(place, pair, "two robots from 1 to {}".format(n))
    return tuple(pair)


def _read_switching(section, n, topology):
    if not section.has("switching"):
        section.take("switching")
        return Switching()
    inner = Section(section.take("switching"), section.at("switching"))
    if topology is None:
        raise ScenarioError("{}: the scenario has no topology".format(section.at("switching")))
    if inner.has("graphs") and inner.has("sets"):
        raise ScenarioError("{}: both graphs and sets, wanted one".format(section.at("switching")))
    given = inner.take("graphs", [])
    if not isinstance(given, list) or not all(isinstance(graph, list) for graph in given):
        raise unwanted(inner.at("graphs"), given, "a list of lists of edges")
    graphs = tuple(
        tuple(
            _switched(pair, "{}[{}]".format(inner.at("graphs"), k), n, topology) for pair in graph
        )
        for k, graph in enumerate(given)
    )
    sets = 1 if graphs else inner.whole("sets", low=1, high=MOST_SETS)
    dwell = inner.number("dwell", 0.5, above=0.0)
    switching = Switching(sets, graphs, dwell, inner.text("order", "periodic", ORDERS))
    inner.done()
    return switching


def _switched(pair, place, n, topology):
    pair = _read_pair(pair, place, n)
    known = {edge[:2] for edge in topology.edges}
    if pair not in known and (topology.directed or pair[::-1] not in known):
        raise ScenarioError("{}: edge {} is not in the topology".format(place, list(pair)))
    return pair
