"""The safety filter's part of a scenario: what it keeps robots from besides each other."""

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import EACH, NAMES, NUMBERS, POSITIVE, Field
from mrs_simulator.scenario.reading import ScenarioError, Section, record, written


def _read_arena(part, others):
    arena = part.field(ARENA)
    if arena and not (arena[0] < arena[2] and arena[1] < arena[3]):
        text = "{}: {}, wanted [x_min, y_min, x_max, y_max] with x_min < x_max, y_min < y_max"
        raise ScenarioError(text.format(part.at("arena"), list(arena)))
    return arena


ARENA = Field(
    "arena",
    (),
    "m",
    type=NUMBERS,
    sizes=(4,),
    read=_read_arena,
    rule="none",
    meaning="`[x_min, y_min, x_max, y_max]` [m] in which robots stay",
)
SAFETY = (
    Field("obstacles", True, meaning="whether robots are kept from the scene's obstacles, too"),
    ARENA,
    Field(
        "speed",
        None,
        "m/s",
        **POSITIVE,
        type=EACH,
        meaning="[m/s] of each controlled point at most: one, or a list with one for each robot",
    ),
    Field(
        "sensed",
        (),
        type=NAMES,
        rule="none",
        meaning="the [sensor](sensors.md), or sensors, by which each robot acts, not by known places",
    ),
)


class Safety(record("Safety", SAFETY)):
    """``control.safety`` of a scenario as a mapping: the values of ``SAFETY``."""

    __slots__ = ()

    def with_robots(self, n):
        """Return this for n robots: those added have the last one's cap."""
        if not isinstance(self.speed, tuple):
            return self
        return self._replace(speed=(self.speed + self.speed[-1:] * n)[:n])

    def to_plain(self):
        """Return plain values, as a scenario has them."""
        return written(self, SAFETY)


@explained_by("docs/safety_filter.md#safety-filter")
def read_safety(section, others):
    """Return ``safety`` of the ``section``: False, True, or a :class:`Safety`."""
    given = section.take("safety", False)
    if not isinstance(given, dict):
        if isinstance(given, bool):
            return given
        text = "{}: {!r:.60}, wanted true, false, or a mapping of obstacles, arena, speed, sensed"
        raise ScenarioError(text.format(section.at("safety"), given))
    part = dict(given)
    if isinstance(part.get("sensed"), str):
        part["sensed"] = [part["sensed"]]
    return Safety(**Section(part, section.at("safety"), section.n).values(SAFETY))
