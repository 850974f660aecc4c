"""Faults and incidents: scheduled by the scenario, injected by a service, or detected in the simulation.

A scenario's ``events`` schedule faults.  ``Incident``s are what the world reports: faults that were
injected, and what it detects; neither ends a run.
"""

from typing import NamedTuple, Optional

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, Section, shown

ROTORS = 4
LOST, OFF = "rotor_lost", "motors_off"
UPSIDE_DOWN, SATURATED, NOT_FINITE = "upside_down", "saturated", "not_finite"
ARM_END, LET_GO, FELL = "arm_at_end", "let_go", "load_fell"
IN_WATER = "in_water"
FAULTS = (LOST, OFF)  # that a scenario may schedule
DESCRIPTIONS = {
    LOST: "lost rotor {}",
    OFF: "has its motors off",
    UPSIDE_DOWN: "is upside down, its motors are cut",
    SATURATED: "has rotors at their limit",
    ARM_END: "has joint {} of its arm at its end",
    LET_GO: "lets go of the load, which pulls harder than its grip holds",
    FELL: "was the last of those that held the load: it fell",
    IN_WATER: "drove off the land into the water, and stands still there",
    NOT_FINITE: "has a state that is no number, and is stopped where it was",
}


class Event(NamedTuple):
    """A scheduled fault of a robot."""

    at: float  # [s] of simulated time since the start or the last reset
    robot: int  # number
    event: str  # one of ``FAULTS``
    rotor: Optional[int] = None  # number of the one that is lost, 1: front right, then clockwise

    def to_plain(self):
        """Return the mapping that a scenario holds."""
        return {key: value for key, value in self._asdict().items() if value is not None}


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


@explained_by("docs/scenarios.md#faults-in-the-air")
def read_events(top, n):
    """Return the ``events`` of a scenario with n robots, a tuple in the order of their times."""
    given = top.take("events", [])
    if not isinstance(given, list):
        raise ScenarioError(
            "{}: {}, wanted a list of {{at, robot, event}}".format(top.at("events"), shown(given))
        )
    events = [
        _read_event(Section(item, "{}[{}]".format(top.at("events"), index)), n)
        for index, item in enumerate(given)
    ]
    return tuple(sorted(events, key=lambda event: event.at))


def _read_event(section, n):
    event = section.text("event", choices=FAULTS)
    rotor = section.whole("rotor", low=1, high=ROTORS) if event == LOST else None
    result = Event(
        section.number("at", low=0.0), section.whole("robot", low=1, high=n), event, rotor
    )
    section.done()
    return result


def events_of_first(events, n):
    """Return the ``events`` of the first n robots."""
    return tuple(event for event in events if event.robot <= n)
