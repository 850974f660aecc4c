"""Runs as points of a unit cube: what a scenario's ``search`` lets vary."""

import copy
import math

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.scenario.incidents import PUSHED
from mrs_simulator.scenario.reading import ScenarioError, UnknownKey, number
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.scenario.search import DEAD, EDGES, POSES, PUSHES, ROBOTS, EdgeRange
from mrs_simulator.study.run.sweep import (
    PARAMETERS,
    PROTOCOL,
    SweepError,
    meant,
    parameters_of,
    put_key,
)
from mrs_simulator.study.search.stated_noise import NOISE, enlarge_noise

PUSH = ("time", "robot", "x", "y")  # the coordinates of one
DIGITS = 6  # of poses and numbers that are drawn
MOST_TRIES = 1000  # [-] places for one robot, before the box counts as full


class Space:
    """The unit cube whose points are the variations of a scenario.

    A *variation* is a mapping: numbers by the paths of keys; ``poses``, a list of [x, y, theta];
    ``edges``, a mapping of lists of pairs [i, j] by ``cut`` and ``add``; ``dead``, a list of robots;
    ``pushes``, a list of [time, robot, x, y].
    """

    def __init__(self, search, robots, topology=None):
        """``search``: the scenario's; ``robots``: how many there are where that does not vary;
        ``topology``: the graph whose edges it may edit, or None."""
        self.search, self._robots = search, robots
        self._pairs = _pairs(search.edges, topology)
        most = int(search.robots.high) if search.robots else robots
        self._edits = len(search.ranges)  # the first coordinate of what follows the ranges
        self._pushes = self._edits + sum(search.edges or ()) + search.dead
        self._poses = self._pushes + (len(PUSH) * search.pushes.most if search.pushes else 0)
        self.size = self._poses + (3 * most if search.poses else 0)
        if not self.size:
            raise ScenarioError("search: nothing varies; wanted poses or ranges of keys")

    def variation(self, point):
        """Return the variation at ``point`` (size,), each coordinate within [0, 1]."""
        values = {each.key: _value(each, at) for each, at in zip(self.search.ranges, point)}
        values.update(self._edited(list(point[self._edits : self._pushes])))
        pushes = self._pushed(point[self._pushes : self._poses])
        values.update({PUSHES: pushes} if pushes else {})
        if self.search.poses:
            at = np.reshape(point[self._poses :], (-1, 3))
            at = at[: values.get(ROBOTS, self._robots)]
            low, high = self._corners()
            values[POSES] = np.round(low + at * (high - low), DIGITS).tolist()
        return values

    def _edited(self, coordinates):
        """Return the edits that ``coordinates`` in [0, 1] mean: each is one of what it may be, or none."""
        values, edges = {}, {}
        for key, count in (self.search.edges or EdgeRange())._asdict().items():
            own, coordinates = coordinates[:count], coordinates[count:]
            edges[key] = _chosen(own, self._pairs[key])
        dead = _chosen(coordinates, list(range(1, self._robots + 1)))
        values.update({EDGES: edges} if any(edges.values()) else {})
        values.update({DEAD: dead} if dead else {})
        return values

    def _pushed(self, coordinates):
        """Return the pushes that ``coordinates`` in [0, 1] mean, by robot; the least robot means none."""
        if not self.search.pushes:
            return []
        _, within, until = self.search.pushes
        found = []
        for time, robot, x, y in np.reshape(coordinates, (-1, len(PUSH))).tolist():
            number = min(int(robot * (self._robots + 1)), self._robots)
            by = [round(within * (2.0 * each - 1.0), DIGITS) for each in (x, y)]
            found += [[round(until * time, DIGITS), number, *by]] if number else []
        return found

    def _corners(self):
        box, headings = self.search.poses.within, self.search.poses.headings
        return np.array([*box[:2], headings[0]]), np.array([*box[2:], headings[1]])

    def draw(self, random):
        """Return a point drawn uniformly, of the poses that are far enough apart; by ``random``."""
        point = random.random(self.size)
        if not self.search.poses:
            return point
        robots = len(self.variation(point)[POSES])
        low, high = self._corners()
        places = []
        for row in range(robots):
            begin = self._poses + 3 * row
            for _ in range(MOST_TRIES):
                place = low[:2] + point[begin : begin + 2] * (high - low)[:2]
                if all(np.hypot(*(place - each)) >= self.search.poses.apart for each in places):
                    break
                point[begin : begin + 2] = random.random(2)
            else:
                text = "search.poses: no room for {} robots {:g} m apart within {}"
                numbers = robots, self.search.poses.apart, list(self.search.poses.within)
                raise ScenarioError(text.format(*numbers))
            places.append(place)
        return point

    def too_near(self, variation):
        """Return by how much [m] two robots of a ``variation`` begin nearer than they may, 0 if none do."""
        if not self.search.poses or len(variation[POSES]) < 2:
            return 0.0
        places = np.array(variation[POSES])[:, :2]
        first, second = np.triu_indices(len(places), 1)
        least = np.linalg.norm(places[first] - places[second], axis=1).min()
        return max(0.0, self.search.poses.apart - float(least))


def _pairs(edges, topology):
    """Return by name which pairs [i, j] may be cut from the ``topology``, and which may be added."""
    if edges is None:
        return {"cut": [], "add": []}
    if topology is None:
        raise ScenarioError("search.edges: the scenario has no topology whose edges could change")
    there = [list(edge[:2]) for edge in topology.edges]
    known = there if topology.directed else there + [[j, i] for i, j in there]
    numbers = range(1, topology.n + 1)
    free = [[i, j] for i in numbers for j in numbers if i != j and [i, j] not in known]
    free = free if topology.directed else [pair for pair in free if pair[0] < pair[1]]
    return {"cut": there, "add": free}


def _chosen(coordinates, values):
    """Return which of ``values`` the ``coordinates`` in [0, 1] mean, each once; the least mean none."""
    rows = {int(at * (len(values) + 1)) - 1 for at in coordinates}
    return [values[row] for row in sorted(rows) if 0 <= row < len(values)]


def _value(each, at):
    """Return what coordinate ``at`` in [0, 1] means for a ``Range``."""
    if each.choices:
        return each.choices[min(int(at * len(each.choices)), len(each.choices) - 1)]
    if each.whole:
        return min(int(each.low + at * (each.high - each.low + 1.0)), int(each.high))
    return float(np.round(each.low + at * (each.high - each.low), DIGITS))


def content_with(content, variation, path=""):
    """Return the scenario's ``content``, a mapping, with the values of a ``variation`` and no search.

    ``path``: of its file.
    """
    changed = copy.deepcopy(content)
    changed.pop("search", None)
    for key, value in variation.items():
        if key == NOISE:
            enlarge_noise(changed, number(value, NOISE, low=0.0))
        elif key not in (EDGES, DEAD, PUSHES):
            put_key(changed, key, copy.deepcopy(value))
    if POSES in variation:
        robots = changed["robots"] = len(variation[POSES])
        topology = changed.get("topology")
        if isinstance(topology, dict) and isinstance(topology.get("edges"), list):
            topology["edges"] = [each for each in topology["edges"] if max(each[:2]) <= robots]
        if isinstance(changed.get("model"), list):
            changed["model"] = (changed["model"] * robots)[:robots]
    if EDGES in variation:
        _edit_edges(changed, path, **variation[EDGES])
    if DEAD in variation:
        _stop(changed, path, variation[DEAD])
    if PUSHES in variation:
        _push(changed, variation[PUSHES])
    return changed


def least_values(search):
    """Return by key the least value that a ``search`` lets each key take, but for the number of robots."""
    return {each.key: _value(each, 0.0) for each in search.ranges if each.key != ROBOTS}


def check_keys(values, content, path, where):
    """Raise ``ScenarioError`` where a key of ``values`` is none of the scenario ``content`` or of its law.

    ``path``: of its file; ``where``: what names the keys.  What values of known keys are worth is left to
    the runs.
    """
    known, where = parameters_of(content, path), "{}: {}".format(path, where)
    try:
        scenario_of_file(content_with(content, values, path), path, where)
    except (UnknownKey, SweepError) as error:
        bare = meant(values, known)
        raise ScenarioError("{}: {}".format(where, bare) if bare else str(error)) from None
    except ScenarioError:
        pass
    if not {"control", PROTOCOL} & set(values):
        for name in (key[len(PARAMETERS) :] for key in values if key.startswith(PARAMETERS)):
            if name not in known:
                raise ScenarioError(unknown_name(where + "." + PARAMETERS[:-1], name, known))


def _edit_edges(content, path, cut, add):
    """Put the graph's edges into a scenario's ``content``, without those to ``cut``, and those to ``add``.

    Edges of robots that are not there are left out.
    """
    topology = scenario_of_file(content, path).topology
    kept = [list(edge) for edge in topology.edges if list(edge[:2]) not in cut]
    kept += [pair for pair in add if max(pair) <= topology.n and pair not in [e[:2] for e in kept]]
    content["topology"] = {"edges": kept, "directed": topology.directed}


def _stop(content, path, dead):
    """Let the robots with the numbers ``dead`` never move: their wheels turn at 0 of the speed."""
    n = scenario_of_file(content, path).n
    mismatch = content.setdefault("mismatch", {})
    speed = mismatch.get("speed", 1.0)
    speeds = list(speed) if isinstance(speed, list) else [speed] * n
    mismatch["speed"] = [0.0 if row + 1 in dead else own for row, own in enumerate(speeds)]


def _push(content, pushes):
    """Add ``pushes``, [time, robot, x, y] each, to the events of a scenario's ``content``.

    Those of robots that a variation has left out are left out.
    """
    most = content["robots"] if isinstance(content.get("robots"), int) else math.inf
    known = [each for each in pushes if each[1] <= most]
    events = [{"at": t, "robot": k, "event": PUSHED, "by": [x, y]} for t, k, x, y in known]
    content["events"] = [*content.get("events", []), *events]


def varied_scenario(content, path, variation, title="", duration=None):
    """Return the ``Scenario`` of a ``variation``, which means the same from anywhere.

    ``content``: of the file at ``path``; ``title`` and ``duration`` [s]: others than the file's.
    """
    changed = content_with(content, variation, path)
    if duration is not None:
        changed["duration"] = duration
    scenario = from_anywhere(scenario_of_file(changed, path))
    return scenario._replace(title=title or scenario.title)
