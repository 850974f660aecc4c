"""The safety filter's part of a scenario: what it keeps robots from besides each other."""

from typing import NamedTuple, Tuple, Union

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, number, number_list


class Safety(NamedTuple):
    """``control.safety`` of a scenario as a mapping."""

    obstacles: bool = True  # whether robots are kept from the scene's obstacles
    arena: Tuple[float, ...] = ()  # (x_min, y_min, x_max, y_max) [m] that they stay in, or ()
    speed: Union[None, float, Tuple[float, ...]] = None  # [m/s] of each controlled point at most
    sensed: Tuple[str, ...] = ()  # names of the sensors by which it acts, () for known places

    def with_robots(self, n):
        """Return this for n robots: those added have the last one's cap."""
        if not isinstance(self.speed, tuple):
            return self
        return self._replace(speed=(self.speed + self.speed[-1:] * n)[:n])

    def to_plain(self):
        """Return plain values, as a scenario has them."""
        plain = {"obstacles": self.obstacles}
        if self.arena:
            plain["arena"] = list(self.arena)
        if self.speed is not None:
            plain["speed"] = list(self.speed) if isinstance(self.speed, tuple) else self.speed
        if self.sensed:
            plain["sensed"] = list(self.sensed)
        return plain


@explained_by("docs/protocols.md#safety-filter")
def read_safety(section, n):
    """Return ``safety`` of the ``section`` of n robots: False, True, or a :class:`Safety`."""
    given = section.take("safety", False)
    if not isinstance(given, dict):
        if isinstance(given, bool):
            return given
        text = "{}: {!r:.60}, wanted true, false, or a mapping of obstacles, arena, speed, sensed"
        raise ScenarioError(text.format(section.at("safety"), given))
    part = Section(given, section.at("safety"))
    safety = Safety(
        part.flag("obstacles", True), _read_arena(part), _read_speed(part, n), _read_sensed(part)
    )
    part.done()
    return safety


def _read_sensed(part):
    given = part.take("sensed", [])
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        text = "{}: {!r:.60}, wanted names of sensors, such as [sonar, neighbours]"
        raise ScenarioError(text.format(part.at("sensed"), given))
    return tuple(names)


def _read_arena(part):
    if not part.has("arena"):
        return part.take("arena", ())
    arena = part.numbers("arena", 4)
    if not (arena[0] < arena[2] and arena[1] < arena[3]):
        text = "{}: {}, wanted [x_min, y_min, x_max, y_max] with x_min < x_max, y_min < y_max"
        raise ScenarioError(text.format(part.at("arena"), arena))
    return tuple(arena)


def _read_speed(part, n):
    given, where = part.take("speed"), part.at("speed")
    if given is None:
        return None
    if not isinstance(given, list):
        return number(given, where, above=0.0)
    values = number_list(given, n, where)
    return tuple(
        number(value, "{}[{}]".format(where, row), above=0.0) for row, value in enumerate(values)
    )
