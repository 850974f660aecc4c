"""The ``topology`` of a scenario: edges, or a preset with its numbers."""

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import FLAG, NUMBER, POSITIVE, REQUIRED, TEXT, WHOLE, Field
from mrs_simulator.core.graphs import PRESETS, Topology
from mrs_simulator.scenario.reading import ScenarioError, Section, shown

ALWAYS_UNDIRECTED = ("random", "proximity")
OTHER_GRAPHS = ALWAYS_UNDIRECTED + ("k_nearest", "erdos_renyi")  # of chance, of places
PRESET = Field("preset", choices=PRESETS + OTHER_GRAPHS, type=TEXT, rule=REQUIRED)
DIRECTED = Field("directed", type=FLAG)  # None: as the preset has it
PROBABILITY = Field("probability", 0.3, low=0.0, high=1.0)
RADIUS = Field("radius", unit="m", **POSITIVE, type=NUMBER, rule=REQUIRED)
NEAREST = Field("k", low=1, type=WHOLE, rule=REQUIRED)


@explained_by("docs/scenarios.md#graphs")
def read_topology(top, poses, seed):
    """Return the ``Topology`` under ``topology`` of the section ``top``, None where there is none.

    ``poses`` (n, 3) and ``seed``: of graphs by places or by chance.
    """
    if not top.has("topology"):
        top.take("topology")
        return None
    section = Section(top.take("topology"), top.at("topology"))
    try:
        topology = _made_topology(section, poses, seed)
    except ScenarioError:
        raise
    except ValueError as error:
        raise ScenarioError("{}: {}".format(top.at("topology"), error)) from None
    section.done()
    return topology


def _made_topology(section, poses, seed):
    if not section.has("preset"):
        edges = section.take("edges", [])
        if not isinstance(edges, list):
            raise ValueError(
                "edges {}: wanted a list of [i, j] or [i, j, weight]".format(shown(edges))
            )
        return Topology(len(poses), edges, section.field(DIRECTED) is not False)
    name, n = section.field(PRESET), len(poses)
    directed = section.field(DIRECTED)
    if name in ALWAYS_UNDIRECTED and directed:
        raise ScenarioError("{}: true, but {} is undirected".format(section.at("directed"), name))
    if name == "random":
        return Topology.random(n, section.field(PROBABILITY), seed)
    if name == "proximity":
        return Topology.proximity(poses[:, :2], section.field(RADIUS))
    if name == "k_nearest":
        return Topology.k_nearest(poses[:, :2], section.field(NEAREST), directed is not False)
    if name == "erdos_renyi":
        return Topology.erdos_renyi(n, section.field(PROBABILITY), seed, directed is True)
    return Topology.preset(name, n, directed)
