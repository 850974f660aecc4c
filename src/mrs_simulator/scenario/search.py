"""What may vary between the runs of a search, the key ``search`` of a scenario, and within what.

::

    search:
      poses: {within: [-5, -5, 5, 5], apart: 0.9}       # [m]; headings anywhere unless given
      mismatch.delay: [0, 0.4]                          # any key's path: from, to
      topology: {choices: [{preset: path}, {preset: cycle}]}
      robots: [2, 7]                                    # whole numbers, as of seed
      edges: {cut: 2, add: 1}                           # of the topology, at most so many
      dead: 1                                           # robots that never move, at most so many
      pushes: {most: 1, within: 0.5, until: 10}         # by up to 0.5 m along x and y, in the first 10 s
"""

import difflib
import math
from typing import Any, NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBER, NUMBERS, POSITIVE, REQUIRED, Field, unknown_name
from mrs_simulator.scenario.incidents import FARTHEST_PUSH
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    number,
    record,
    shown,
    unwanted,
)

POSES, ROBOTS, SEED = "poses", "robots", "seed"
EDGES, DEAD, PUSHES = "edges", "dead", "pushes"
MOST_EDITS = 20
MOST_RANGES = 100


def _read_box(section, others):
    box = section.field(WITHIN)
    if not (box[0] < box[2] and box[1] < box[3]):
        raise unwanted(section.at("within"), list(box), "x_min, y_min, x_max, y_max")
    return box


def _read_headings(section, others):
    headings = section.field(HEADINGS)
    if headings[0] > headings[1]:
        raise unwanted(section.at("headings"), list(headings), "[from, to], the second no smaller")
    return headings


WITHIN = Field(
    "within",
    unit="m",
    type=NUMBERS,
    sizes=(4,),
    rule=REQUIRED,
    meaning="`[x_min, y_min, x_max, y_max]` of the box in which robots begin",
)
HEADINGS = Field(
    "headings",
    (-math.pi, math.pi),
    "rad",
    type=NUMBERS,
    sizes=(2,),
    rule="any",
    meaning="`[from, to]` of their headings",
)
POSE_RANGE = (
    WITHIN._replace(read=_read_box),
    Field("apart", 0.0, "m", low=0.0, meaning="least distance of two centres"),
    HEADINGS._replace(read=_read_headings),
)
EDGE_RANGE = (
    Field(
        "cut",
        0,
        low=0,
        high=MOST_EDITS,
        meaning="edges of the topology that are left out, at most so many",
    ),
    Field("add", 0, low=0, high=MOST_EDITS, meaning="edges that are added to it, at most so many"),
)
PUSH_RANGE = (
    Field("most", 1, low=1, high=MOST_EDITS, meaning="pushes, at most so many"),
    Field(
        "within",
        unit="m",
        **POSITIVE,
        high=FARTHEST_PUSH,
        type=NUMBER,
        rule=REQUIRED,
        meaning="by how much along x and y, at most",
    ),
    Field("until", unit="s", **POSITIVE, type=NUMBER, rule=REQUIRED, meaning="when, at the latest"),
)
DEAD_ROBOTS = Field(
    DEAD, 0, low=0, high=MOST_EDITS, meaning="robots that never move, at most so many"
)


class PoseRange(record("PoseRange", POSE_RANGE)):
    """Poses in the box ``within``, their centres at least ``apart`` [m], headings in ``headings`` [rad]."""

    __slots__ = ()


class EdgeRange(record("EdgeRange", EDGE_RANGE)):
    """How many edges of the topology may be ``cut``, and how many others ``add``ed, at most."""

    __slots__ = ()


class PushRange(record("PushRange", PUSH_RANGE)):
    """At most so many pushes, each by up to ``within`` [m] along x and y, ``until`` [s] at the latest."""

    __slots__ = ()


class Range(NamedTuple):
    """Numbers from ``low`` to ``high`` of the ``key``, or its ``choices``; ``whole``: whole numbers."""

    key: str
    low: float = 0.0
    high: float = 0.0
    whole: bool = False
    choices: Tuple[Any, ...] = ()


class Search(NamedTuple):
    """All that may vary."""

    ranges: Tuple[Range, ...] = ()
    poses: Optional[PoseRange] = None
    edges: Optional[EdgeRange] = None
    dead: int = 0  # robots that never move, at most
    pushes: Optional[PushRange] = None

    @property
    def robots(self):
        """Return the ``Range`` of the number of robots, None where it does not vary."""
        return next((each for each in self.ranges if each.key == ROBOTS), None)

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        result = {}
        if self.poses is not None:
            own = self.poses._asdict().items()
            result[POSES] = {key: list(v) if isinstance(v, tuple) else v for key, v in own}
        if self.edges is not None:
            result[EDGES] = dict(self.edges._asdict())
        if self.dead:
            result[DEAD] = self.dead
        if self.pushes is not None:
            result[PUSHES] = dict(self.pushes._asdict())
        for each in self.ranges:
            span = [int(each.low), int(each.high)] if each.whole else [each.low, each.high]
            result[each.key] = {"choices": list(each.choices)} if each.choices else span
        return result


NO_SEARCH = Search()
RANGE = "[from, to] or {choices: [...]}"
OWN = POSES, EDGES, DEAD, PUSHES  # what varies otherwise than as a range of a scenario's key


@explained_by("docs/search.md")
def read_search(top):
    """Return the ``Search`` under the key ``search``."""
    return search_from(top.take("search", {}), top.at("search"))


def search_from(given, where):
    """Return the ``Search`` in the mapping ``given``; ``where`` names it in errors."""
    if not isinstance(given, dict) or len(given) > MOST_RANGES:
        raise unwanted(where, given, "a mapping of ranges by key")
    section = Section(given, where)
    poses = _within(section, POSES, PoseRange, POSE_RANGE)
    ranges = [
        _range(key, value, "{}.{}".format(where, key))
        for key, value in given.items()
        if key not in OWN
    ]
    edges = _within(section, EDGES, EdgeRange, EDGE_RANGE)
    if edges is not None and not any(edges):
        raise unwanted(section.at(EDGES), given[EDGES], "cut or add above 0")
    dead = section.field(DEAD_ROBOTS)
    pushes = _within(section, PUSHES, PushRange, PUSH_RANGE)
    found = Search(tuple(ranges), poses, edges, dead, pushes)
    if found.robots is not None and found.robots.choices:
        raise ScenarioError("{}.robots: {}, wanted [from, to]".format(where, shown(given[ROBOTS])))
    if found.robots is not None and poses is None:
        text = "{}.robots: wanted poses beside it: where other numbers of robots may begin"
        raise ScenarioError(text.format(where))
    return found


def _within(section, key, kind, fields):
    """Return what varies under ``key`` of the ``section``, a ``kind`` of ``fields``; None without it."""
    if not section.has(key):
        return None
    return kind(**Section(section.take(key), section.at(key)).values(fields))


def _range(key, given, where):
    if not isinstance(key, str) or not key or key == "search":
        raise unwanted(where, key, "the path of a key")
    if isinstance(given, dict):
        section = Section(given, where)
        if not section.has("choices"):
            if difflib.get_close_matches(key, OWN):
                raise ScenarioError(unknown_name(where.rpartition(".")[0], key, OWN))
            raise unwanted(where, given, RANGE)
        choices = section.take("choices")
        if not isinstance(choices, list) or len(choices) < 2:
            raise unwanted(section.at("choices"), choices, "a list of at least two values")
        section.done()
        return Range(key, choices=tuple(choices))
    if not isinstance(given, list) or len(given) != 2:
        raise unwanted(where, given, RANGE)
    low, high = (number(each, where) for each in given)
    whole = key in (ROBOTS, SEED) or key.endswith(".seed")
    if not low < high or (whole and (low != round(low) or high != round(high) or low < 0)):
        wanted = "two {}numbers, the second the larger".format("whole " if whole else "")
        raise unwanted(where, given, wanted)
    return Range(key, low, high, whole)
