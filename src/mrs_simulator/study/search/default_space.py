"""What a search varies where the scenario does not say: starts, edges, and the law's own parameters."""

import math

import numpy as np

from mrs_simulator.core.fields import NUMBER, TEXT
from mrs_simulator.protocols.loading import choose_protocol
from mrs_simulator.scenario.search import EDGES, POSES
from mrs_simulator.vehicles import Team

GROWN, LEAST = 1.5, 2.0  # [-] times the size of the box of the scenario's places; [m] of its sides
FREE = 0.3  # [m] between two points, or beside what the bodies of two robots need
TIMES = 5.0  # [-] by which a parameter may be smaller or larger
EDITED = 1  # [-] edges cut, and added
LEFT = {"l", "seed"}  # parameters of the mapping and of chance, not of the law
SLIGHTLY = 1e-3  # [-] of a bound that is no value itself, by which values keep away from it


def default_search(scenario):
    """Return what may vary around ``scenario``, a mapping as the key ``search`` has it.

    Whether a variation keeps the hypotheses of the law's theorem is left to its conditions.
    """
    found = {POSES: {"within": box_of(scenario.poses), "apart": apart_of(scenario)}}
    if scenario.topology is not None and len(scenario.topology.edges):
        found[EDGES] = {"cut": EDITED, "add": EDITED}
    _, protocol = choose_protocol(scenario)
    given = scenario.control.parameters
    for each in protocol.PARAMETERS:
        span = None if each.name in LEFT else _span(each, given.get(each.name, each.default))
        if span is not None:
            found["control.parameters." + each.name] = span
    return found


def box_of(poses):
    """Return the box [x_min, y_min, x_max, y_max] [m] around ``poses`` (n, 3), ``GROWN``."""
    low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
    half = np.maximum(0.5 * GROWN * (high - low), 0.5 * LEAST)
    return [float(each) for each in (*(0.5 * (low + high) - half), *(0.5 * (low + high) + half))]


def apart_of(scenario):
    """Return how far apart [m] centres are to begin: so that no two bodies touch, however they stand."""
    if scenario.fidelity == "point_mass":
        return FREE
    bodies = [kind.body for kind in Team.from_scenario(scenario).kinds]
    reach = max(math.hypot(max(each.front, each.rear), 0.5 * each.width) for each in bodies)
    return round(2.0 * reach + FREE, 3)


def _span(parameter, value):
    """Return the range of a ``parameter`` about its ``value``, None where it does not vary."""
    if parameter.kind == TEXT and len(parameter.choices) > 1:
        return {"choices": list(parameter.choices)}
    if parameter.kind != NUMBER or not isinstance(value, (int, float)) or not value:
        return None
    low, high = sorted((value / TIMES, value * TIMES))
    margin = SLIGHTLY * abs(value)
    if parameter.low is not None:
        low = max(low, parameter.low + margin * parameter.open_low)
    if parameter.high is not None:
        high = min(high, parameter.high - margin * parameter.open_high)
    return [low, high] if low < high else None
