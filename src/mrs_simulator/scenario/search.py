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

import math
from typing import Any, NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.incidents import FARTHEST_PUSH
from mrs_simulator.scenario.reading import (
    ScenarioError,
    Section,
    number,
    number_list,
    shown,
    unwanted,
)

POSES, ROBOTS, SEED = "poses", "robots", "seed"
EDGES, DEAD, PUSHES = "edges", "dead", "pushes"
MOST_EDITS = 20
MOST_RANGES = 100


class PoseRange(NamedTuple):
    """Poses in the box ``within``, their centres at least ``apart`` [m], headings in ``headings`` [rad]."""

    within: Tuple[float, float, float, float]  # x_min, y_min, x_max, y_max [m]
    apart: float = 0.0
    headings: Tuple[float, float] = (-math.pi, math.pi)


class EdgeRange(NamedTuple):
    """How many edges of the topology may be ``cut``, and how many others ``add``ed, at most."""

    cut: int = 0
    add: int = 0


class PushRange(NamedTuple):
    """At most so many pushes, each by up to ``within`` [m] along x and y, ``until`` [s] at the latest."""

    most: int = 1
    within: float = 0.5
    until: float = 10.0


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


@explained_by("docs/search.md")
def read_search(top):
    """Return the ``Search`` under the key ``search``."""
    return search_from(top.take("search", {}), top.at("search"))


def search_from(given, where):
    """Return the ``Search`` in the mapping ``given``; ``where`` names it in errors."""
    if not isinstance(given, dict) or len(given) > MOST_RANGES:
        raise unwanted(where, given, "a mapping of ranges by key")
    poses = _poses(given[POSES], "{}.{}".format(where, POSES)) if POSES in given else None
    ranges = [
        _range(key, value, "{}.{}".format(where, key))
        for key, value in given.items()
        if key not in (POSES, EDGES, DEAD, PUSHES)
    ]
    edges = _edges(given[EDGES], "{}.{}".format(where, EDGES)) if EDGES in given else None
    dead = Section(given, where).whole(DEAD, 0, low=0, high=MOST_EDITS) if DEAD in given else 0
    pushes = _pushes(given[PUSHES], "{}.{}".format(where, PUSHES)) if PUSHES in given else None
    found = Search(tuple(ranges), poses, edges, dead, pushes)
    if found.robots is not None and found.robots.choices:
        raise ScenarioError("{}.robots: {}, wanted [from, to]".format(where, shown(given[ROBOTS])))
    if found.robots is not None and poses is None:
        text = "{}.robots: wanted poses beside it: where other numbers of robots may begin"
        raise ScenarioError(text.format(where))
    return found


def _poses(given, where):
    section = Section(given, where)
    box = number_list(section.take("within"), 4, section.at("within"))
    if not (box[0] < box[2] and box[1] < box[3]):
        raise unwanted(section.at("within"), list(box), "x_min, y_min, x_max, y_max")
    headings = section.take("headings", [-math.pi, math.pi])
    headings = number_list(headings, 2, section.at("headings"))
    result = PoseRange(tuple(box), section.number("apart", 0.0, low=0.0), tuple(headings))
    section.done()
    return result


def _edges(given, where):
    section = Section(given, where)
    found = EdgeRange(*(section.whole(k, 0, low=0, high=MOST_EDITS) for k in EdgeRange._fields))
    section.done()
    if not any(found):
        raise unwanted(where, given, "cut or add above 0")
    return found


def _pushes(given, where):
    section = Section(given, where)
    found = PushRange(
        section.whole("most", 1, low=1, high=MOST_EDITS),
        section.number("within", above=0.0, high=FARTHEST_PUSH),
        section.number("until", above=0.0),
    )
    section.done()
    return found


def _range(key, given, where):
    if not isinstance(key, str) or not key or key == "search":
        raise unwanted(where, key, "the path of a key")
    if isinstance(given, dict):
        section = Section(given, where)
        choices = section.take("choices")
        if not isinstance(choices, list) or len(choices) < 2:
            raise unwanted(section.at("choices"), choices, "a list of at least two values")
        section.done()
        return Range(key, choices=tuple(choices))
    if not isinstance(given, list) or len(given) != 2:
        raise unwanted(where, given, "[from, to] or {choices: [...]}")
    low, high = (number(each, where) for each in given)
    whole = key in (ROBOTS, SEED) or key.endswith(".seed")
    if not low < high or (whole and (low != round(low) or high != round(high) or low < 0)):
        wanted = "two {}numbers, the second the larger".format("whole " if whole else "")
        raise unwanted(where, given, wanted)
    return Range(key, low, high, whole)
