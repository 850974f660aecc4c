"""Faults and incidents: scheduled by the scenario, injected by a service, or detected in the simulation.

A scenario's ``events`` schedule faults and pushes.  ``Incident``s are what the world reports: what was
injected, and what it detects; neither ends a run.
"""

from typing import NamedTuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.core.fields import NUMBER, NUMBERS, REQUIRED, TEXT, WHOLE, Field
from mrs_simulator.scenario.reading import Section, record, unwanted, written

ROTORS = 4
LOST, OFF, PUSHED = "rotor_lost", "motors_off", "pushed"
UPSIDE_DOWN, SATURATED, NOT_FINITE = "upside_down", "saturated", "not_finite"
ARM_END, LET_GO, FELL = "arm_at_end", "let_go", "load_fell"
IN_WATER = "in_water"
EVENTS = (LOST, OFF, PUSHED)  # that a scenario may schedule
FARTHEST_PUSH = 100.0  # [m] along each axis
DESCRIPTIONS = {
    LOST: "lost rotor {}",
    OFF: "has its motors off",
    PUSHED: "was pushed",
    UPSIDE_DOWN: "is upside down, its motors are cut",
    SATURATED: "has rotors at their limit",
    ARM_END: "has joint {} of its arm at its end",
    LET_GO: "lets go of the load, which pulls harder than its grip holds",
    FELL: "was the last of those that held the load: it fell",
    IN_WATER: "drove off the land into the water, and stands still there",
    NOT_FINITE: "has a state that is no number, and is stopped where it was",
}


def _read_robot(section, others):
    return section.field(Field("robot", low=1, high=section.n, type=WHOLE, rule=REQUIRED))


def _read_push(section, others):
    by = section.field(Field("by", type=NUMBERS, sizes=(2,), rule=REQUIRED))
    if max(map(abs, by)) > FARTHEST_PUSH:
        raise unwanted(section.at("by"), list(by), "[x, y] of at most {:g} m".format(FARTHEST_PUSH))
    return by


NAME = Field(
    "event", choices=EVENTS, type=TEXT, rule=REQUIRED, meaning="`{}`, `{}` or `{}`".format(*EVENTS)
)
ALWAYS = (
    Field(
        "at",
        unit="s",
        low=0.0,
        type=NUMBER,
        rule=REQUIRED,
        meaning="from the beginning, or from the last reset",
    ),
    Field("robot", read=_read_robot, rule=REQUIRED, meaning="its number"),
    NAME,
)
ROTOR = Field(
    "rotor",
    low=1,
    high=ROTORS,
    type=WHOLE,
    rule=REQUIRED,
    meaning="of `{}`: 1 is front right, then clockwise".format(LOST),
)
PUSH = Field(
    "by",
    unit="m",
    read=_read_push,
    rule=REQUIRED,
    meaning="of `{}`: along x and y of the common frame".format(PUSHED),
)
MORE = {LOST: (ROTOR,), PUSHED: (PUSH,)}  # of some events
EVENT = (*ALWAYS, ROTOR, PUSH)


class Event(record("Event", EVENT)):
    """A scheduled fault, or push, of a robot: the values of ``EVENT``, None of what it has not."""

    __slots__ = ()

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        return written(self, EVENT)


class Incident(NamedTuple):
    """An incident: time [s], robot, what; ``ordered``: scheduled or injected, or a consequence of that."""

    time: float
    robot: str  # robotN
    what: str  # a key of ``DESCRIPTIONS``
    rotor: int = 0  # or joint of an arm
    ordered: bool = False

    @property
    def text(self):
        """Return the incident as a text."""
        return "{} {}".format(self.robot, DESCRIPTIONS[self.what].format(self.rotor))


@explained_by("docs/scenarios.md#faults-and-pushes")
def read_events(top, n):
    """Return the ``events`` of a scenario with n robots, a tuple in the order of their times."""
    items = top.items("events", "a list of {at, robot, event}")
    events = [_read_event(Section(item, where, n)) for where, item in items]
    return tuple(sorted(events, key=lambda event: event.at))


def _read_event(section):
    more = MORE.get(section.field(NAME), ())
    return Event(**section.values(ALWAYS + more))
