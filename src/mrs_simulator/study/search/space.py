"""Runs as points of a unit cube: what a scenario's ``search`` lets vary."""

import copy

import numpy as np

from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_of_file
from mrs_simulator.scenario.search import POSES, ROBOTS
from mrs_simulator.study.run.sweep import put_key

DIGITS = 6  # of poses and numbers that are drawn
MOST_TRIES = 1000  # [-] places for one robot, before the box counts as full


class Space:
    """The unit cube whose points are the variations of a scenario.

    A *variation* is a mapping: numbers by the paths of keys, and ``poses``, a list of [x, y, theta].
    """

    def __init__(self, search, robots):
        """``search``: the scenario's; ``robots``: how many there are where that does not vary."""
        self.search, self._robots = search, robots
        most = int(search.robots.high) if search.robots else robots
        self.size = len(search.ranges) + (3 * most if search.poses else 0)
        if not self.size:
            raise ScenarioError("search: nothing varies; wanted poses or ranges of keys")

    def variation(self, point):
        """Return the variation at ``point`` (size,), each coordinate within [0, 1]."""
        values = {each.key: _value(each, at) for each, at in zip(self.search.ranges, point)}
        if self.search.poses:
            at = np.reshape(point[len(self.search.ranges) :], (-1, 3))
            at = at[: values.get(ROBOTS, self._robots)]
            low, high = self._corners()
            values[POSES] = np.round(low + at * (high - low), DIGITS).tolist()
        return values

    def _corners(self):
        box, headings = self.search.poses.within, self.search.poses.headings
        return np.array([*box[:2], headings[0]]), np.array([*box[2:], headings[1]])

    def draw(self, random):
        """Return a point drawn uniformly, of the poses that are far enough apart; by ``random``."""
        point = random.random(self.size)
        if not self.search.poses:
            return point
        ranges = len(self.search.ranges)
        robots = len(self.variation(point)[POSES])
        low, high = self._corners()
        places = []
        for row in range(robots):
            begin = ranges + 3 * row
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


def _value(each, at):
    """Return what coordinate ``at`` in [0, 1] means for a ``Range``."""
    if each.choices:
        return each.choices[min(int(at * len(each.choices)), len(each.choices) - 1)]
    if each.whole:
        return min(int(each.low + at * (each.high - each.low + 1.0)), int(each.high))
    return float(np.round(each.low + at * (each.high - each.low), DIGITS))


def content_with(content, variation):
    """Return the scenario's ``content``, a mapping, with the values of a ``variation`` and no search."""
    changed = copy.deepcopy(content)
    changed.pop("search", None)
    for key, value in variation.items():
        put_key(changed, key, copy.deepcopy(value))
    if POSES in variation:
        robots = changed["robots"] = len(variation[POSES])
        topology = changed.get("topology")
        if isinstance(topology, dict) and isinstance(topology.get("edges"), list):
            topology["edges"] = [each for each in topology["edges"] if max(each[:2]) <= robots]
        if isinstance(changed.get("model"), list):
            changed["model"] = (changed["model"] * robots)[:robots]
    return changed


def varied_scenario(content, path, variation, title="", duration=None):
    """Return the ``Scenario`` of a ``variation``, which means the same from anywhere.

    ``content``: of the file at ``path``; ``title`` and ``duration`` [s]: others than the file's.
    """
    changed = content_with(content, variation)
    if duration is not None:
        changed["duration"] = duration
    scenario = from_anywhere(scenario_of_file(changed, path))
    return scenario._replace(title=title or scenario.title)
