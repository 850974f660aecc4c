"""Changes of a scenario to its robots' sensors: added, removed and tuned mounts.

Only who is meant is checked here; what a mount may hold is known to the room ``sensors``.
"""

from typing import Any, Dict, NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError, Section, unwanted


class SensorChange(NamedTuple):
    """One entry of ``sensors``: mounts by name, None for one that is taken away."""

    mounts: Dict[str, Optional[Dict[str, Any]]]
    robots: Optional[Tuple[int, ...]] = None  # numbers; None: all
    where: str = ""  # for errors

    def concerns(self, number):
        """Return whether the robot ``number`` is concerned."""
        return self.robots is None or number in self.robots

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        plain = {"mounts": {name: mount and dict(mount) for name, mount in self.mounts.items()}}
        return plain if self.robots is None else dict(plain, robots=list(self.robots))


@explained_by("docs/sensors.md")
def read_sensor_changes(top, kinds, groups=()):
    """Return the tuple of ``SensorChange`` under ``sensors``, those of ``groups`` first.

    ``kinds``: the name of each robot's kind; ``groups``: of a scenario, ``(numbers, section)`` each, whose
    ``sensors`` are mounts of these robots.
    """
    changes = [
        SensorChange(_mounts(section, "sensors"), numbers, section.at("sensors"))
        for numbers, section in groups
        if section.has("sensors")
    ]
    for where, item in top.items("sensors", "a list of {robots, kind, mounts}"):
        changes.append(_read_change(Section(item, where), kinds))
    return tuple(changes)


def _read_change(section, kinds):
    if section.has("robots") and section.has("kind"):
        raise ScenarioError(
            "{}: given beside robots, wanted one of them".format(section.at("kind"))
        )
    robots = _numbers(section, len(kinds)) if section.has("robots") else section.take("robots")
    if section.has("kind"):
        kind = section.text("kind")
        if kind not in kinds:
            raise ScenarioError(unknown_name(section.at("kind"), kind, set(kinds)))
        robots = tuple(row + 1 for row, name in enumerate(kinds) if name == kind)
    section.take("kind")
    change = SensorChange(_mounts(section, "mounts"), robots, section.at("mounts"))
    section.done()
    return change


def _numbers(section, n):
    given = section.take("robots")
    numbers = given if isinstance(given, list) else [given]
    for number in numbers:
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= n:
            raise unwanted(section.at("robots"), number, "robots' numbers from 1 to {}".format(n))
    return tuple(numbers)


def _mounts(section, key):
    given = section.take(key)
    fits = isinstance(given, dict) and all(isinstance(name, str) for name in given)
    if not fits or not all(mount is None or isinstance(mount, dict) for mount in given.values()):
        raise unwanted(section.at(key), given, "a mapping such as {sonar: {rate: 5}, laser: null}")
    return given


def changes_for_robots(changes, before, n):
    """Return ``changes``, of a team of ``before`` robots, for its first ``n``; more are as the last one."""
    kept = []
    for change in changes:
        robots = change.robots
        if robots is not None:
            more = range(before + 1, n + 1) if before in robots else ()
            robots = tuple(number for number in (*robots, *more) if number <= n)
        if robots != ():
            kept.append(change._replace(robots=robots))
    return tuple(kept)
