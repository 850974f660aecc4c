"""Faults and incidents: scheduled by the scenario, injected by a service, or detected in the simulation.

A scenario's ``events`` schedule faults and pushes.  ``Incident``s are what the world reports: what was
injected, and what it detects; neither ends a run.
"""

from typing import NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import Section, unwanted

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


class Event(NamedTuple):
    """A scheduled fault, or push, of a robot."""

    at: float  # [s] of simulated time since the start or the last reset
    robot: int  # number
    event: str  # one of ``EVENTS``
    rotor: Optional[int] = None  # number of the one that is lost, 1: front right, then clockwise
    by: Optional[Tuple[float, float]] = None  # [m] in the common frame, of a push

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        known = {key: value for key, value in self._asdict().items() if value is not None}
        return known if self.by is None else dict(known, by=list(self.by))


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
    events = [_read_event(Section(item, where), n) for where, item in items]
    return tuple(sorted(events, key=lambda event: event.at))


def _read_event(section, n):
    event = section.text("event", choices=EVENTS)
    rotor = section.whole("rotor", low=1, high=ROTORS) if event == LOST else None
    by = _read_push(section) if event == PUSHED else None
    result = Event(
        section.number("at", low=0.0), section.whole("robot", low=1, high=n), event, rotor, by
    )
    section.done()
    return result


def _read_push(section):
    by = tuple(section.numbers("by", 2))
    if max(map(abs, by)) > FARTHEST_PUSH:
        raise unwanted(section.at("by"), list(by), "[x, y] of at most {:g} m".format(FARTHEST_PUSH))
    return by
