"""Faults of the graph's edges as a scenario states them: delay, loss and switching times.

Edges are written ``(i, j)``, robots from 1: "i receives from j".
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import POSITIVE, REQUIRED, Field
from mrs_simulator.scenario.reading import ScenarioError, Section, fitting, record, unwanted

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


def _per_edge(name, high, unit, meaning):
    """Return the declaration of a number from 0 to ``high`` that all edges have, or each its own."""
    default = Field("default", 0.0, unit, low=0.0, high=high)

    def read_edges(section, others):
        edges = []
        for place, row in section.items("edges", "a list of [i, j, value]"):
            if not isinstance(row, list) or len(row) != 3:
                raise unwanted(place, row, "[i, j, value]")
            pair = _read_pair(row[:2], place, section.n)
            if pair in [edge[:2] for edge in edges]:
                raise ScenarioError("{}: edge {} is given twice".format(place, list(pair)))
            edges.append(pair + (fitting(default, row[2], place),))
        return tuple(edges)

    def read(section, others):
        given, where = section.take(name, 0.0), section.at(name)
        if not isinstance(given, dict):
            return PerEdge(fitting(default, given, where))
        return PerEdge(**Section(given, where, section.n).values((default, edges)))

    edges = Field("edges", (), read=read_edges)
    return Field(name, PerEdge(), unit, read=read, rule=default.default_text(), meaning=meaning)


def _read_pair(pair, place, n):
    whole = isinstance(pair, list) and len(pair) == 2
    whole = whole and all(isinstance(r, int) and not isinstance(r, bool) for r in pair)
    if not whole or not all(1 <= robot <= n for robot in pair) or pair[0] == pair[1]:
        raise unwanted(place, pair, "two robots from 1 to {}".format(n))
    return tuple(pair)


def _read_graphs(section, others):
    if section.has("graphs") and section.has("sets"):
        raise ScenarioError("{}: both graphs and sets, wanted one".format(section.where))
    given, where = section.take("graphs", []), section.at("graphs")
    if not isinstance(given, list) or not all(isinstance(graph, list) for graph in given):
        raise unwanted(where, given, "a list of lists of edges")
    return tuple(
        tuple(
            _switched(pair, "{}[{}]".format(where, k), section.n, others["topology"])
            for pair in graph
        )
        for k, graph in enumerate(given)
    )


def _read_sets(section, others):
    return 1 if others["graphs"] else section.field(SETS)


def _switched(pair, place, n, topology):
    pair = _read_pair(pair, place, n)
    known = {edge[:2] for edge in topology.edges}
    if pair not in known and (topology.directed or pair[::-1] not in known):
        raise ScenarioError("{}: edge {} is not in the topology".format(place, list(pair)))
    return pair


SETS = Field(
    "sets",
    1,
    low=1,
    high=MOST_SETS,
    rule=REQUIRED,
    meaning="edge k of the topology is up in turn k mod `sets`",
)
SWITCHING = (
    Field(
        "graphs",
        (),
        read=_read_graphs,
        meaning="in place of `sets`, the edges of each graph: `[[[1, 2], [2, 3]], [[3, 4]]]`",
    ),
    SETS._replace(read=_read_sets),
    Field("dwell", 0.5, "s", **POSITIVE, meaning="of a turn, rounded to whole command periods"),
    Field(
        "order",
        ORDERS[0],
        choices=ORDERS,
        meaning="`periodic`: one after the other; `random`: each turn draws one",
    ),
)


class Switching(record("Switching", SWITCHING)):
    """Which edges of the topology are up in each turn.

    ``graphs``: a tuple of edges (i, j) for each; without them edge k of the topology is up in graph
    k mod ``sets``.  A turn lasts ``dwell`` [s], rounded to whole command periods; the graphs come
    one after the other, or ("random") each turn draws one with equal probability.
    """

    __slots__ = ()

    @property
    def count(self):
        """Return how many graphs there are; 1 without ``graphs`` is no switching."""
        return len(self.graphs) or self.sets


def _read_switching(section, others):
    if not section.has("switching"):
        return section.take("switching", Switching())
    inner = Section(section.take("switching"), section.at("switching"), section.n)
    if others["topology"] is None:
        raise ScenarioError("{}: the scenario has no topology".format(section.at("switching")))
    return Switching(**inner.values(SWITCHING, others))


LINKS = (
    _per_edge(
        "delay",
        LONGEST_DELAY,
        "s",
        "of what is received, rounded to whole command periods: for all edges, or "
        "`{default: 0.1, edges: [[1, 2, 0.4]]}`",
    ),
    _per_edge(
        "loss", 1.0, "", "chance for each message that it is lost, for all edges or as above"
    ),
    Field(
        "on_loss",
        ON_LOSS[0],
        choices=ON_LOSS,
        meaning="`hold`: go by what was received last; `drop`: without the edge for this command",
    ),
    Field("symmetric", False, meaning="whether messages are lost in both directions at once"),
    Field(
        "carries",
        CARRIES[0],
        choices=CARRIES,
        meaning="`state`: what is received is old, one's own state is not; `difference`: both terms are",
    ),
    Field(
        "switching",
        Switching(),
        read=_read_switching,
        rule="none",
        meaning="edges that come and go in turns",
    ),
)


class Links(record("Links", LINKS)):
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

    __slots__ = ()

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
    n, section = top.n, Section(top.take("links", {}), top.at("links"), top.n)
    links = Links(**section.values(LINKS, others))
    if links.symmetric and not links.loss.is_symmetric(n):
        text = "{}: true, but loss differs between the two directions of an edge"
        raise ScenarioError(text.format(section.at("symmetric")))
    return links
