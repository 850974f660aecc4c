"""Values that a run rounds: delays of robots are whole steps of the world, of edges whole periods."""

import re

_OF_ROBOTS = re.compile(r"mismatch\.delay(\[\d+\])?")
_OF_EDGES = re.compile(r"links\.delay(\W.*)?")


def grain_of(key, scenario):
    """Return the time [s] to whole multiples of which runs of a scenario round a value, or 0.0."""
    if _OF_ROBOTS.fullmatch(key):
        return scenario.step
    if _OF_EDGES.fullmatch(key):
        return scenario.steps_per_command * scenario.step
    return 0.0


def rounded(value, grain):
    """Return ``value`` as a run rounds it to whole multiples of ``grain``; as it is where that is 0.0."""
    return round(round(value / grain) * grain, 9) if grain else value
