"""What ran: a scenario with what the stage and the controller published that they do instead."""

from typing import NamedTuple

from mrs_simulator.control.guards import limited
from mrs_simulator.protocols import HOMES
from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.record.run_changes import (
    CONTROLLER_KEYS,
    TOP_SPEEDS,
    controller_settings,
    differences,
    with_keys,
)
from mrs_simulator.scenario.scenario import Scenario, title_of
from mrs_simulator.vehicles.portable import portable, team_from_message

NOT_OF_STAGE = (
    *CONTROLLER_KEYS,
    *("title", "duration", "speed", "record_rate", "record", "requirements", "search"),
)
KINDS = ("model", "kinds")  # neither means anything without the other


class Ran(NamedTuple):
    """What ran, as far as it is known."""

    scenario: Scenario
    unknown_law: str = ""  # the name of a law that runs no code here, "" of a known one


def what_ran(scenario, staged=None, obeyed=None):
    """Return the ``Ran`` of ``scenario`` with what its programs have otherwise.

    ``staged``: the ``Scenario`` that the stage publishes; ``obeyed``: what the controller publishes that it
    does, plain values by keys, and ``TOP_SPEEDS``; None where none did.  A law that only a topic names runs
    no code: it is unknown unless it is shipped or the ``scenario``'s own.  Where another team or law ran,
    the title says which.  Raises ``ScenarioError`` for what cannot have run.
    """
    mine = from_anywhere(scenario)
    other = {} if staged is None else _of_stage(mine, staged)
    speeds = {}
    if obeyed is not None:
        obeyed = dict(obeyed)
        speeds = obeyed.pop(TOP_SPEEDS, {})
        other.update(differences(controller_settings(mine), obeyed))
    if not other and not speeds:
        return Ran(scenario)
    n, name = other.get("robots", mine.n), other.get("control", {}).get("protocol")
    if (n, name or mine.control.protocol) != (mine.n, mine.control.protocol):
        other["title"] = title_of(n, name or mine.control.protocol)
    known = (None, mine.control.protocol, *HOMES)
    ran = with_keys(mine, other) if other else scenario
    limits = limited(ran.limits, **speeds) if speeds else ran.limits
    ran = ran if limits == ran.limits else ran._replace(limits=limits)
    return Ran(ran, "" if name in known else name)


def _of_stage(scenario, staged):
    """Return ``{key: value}`` of what the stage has otherwise than ``scenario``."""
    team_from_message(staged)  # names no files
    mine, his = (
        {key: value for key, value in each.to_dict().items() if key not in NOT_OF_STAGE}
        for each in (portable(scenario)[0], staged)
    )
    other = differences(mine, his)
    if any(key in other for key in KINDS):
        other.update({key: his.get(key) for key in KINDS})
    if "obstacles" in other:
        other["map"] = None  # its walls are among the obstacles
    return other
