"""The ``limits`` of a scenario: a preset, a preset lowered, or numbers of its own."""

import math
from typing import NamedTuple

from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.reading import Section

LIMIT_PRESETS = ("firmware", "top", "none")


class LoweredLimits(NamedTuple):
    """The limits of a preset, and no faster than this."""

    preset: str
    v_max: float = math.inf  # [m/s]
    omega_max: float = math.inf  # [rad/s]


def read_limits(top):
    """Return the ``limits`` of ``top``: a preset's name, ``LoweredLimits``, ``Limits`` or None."""
    given = top.take("limits", "firmware")
    if not isinstance(given, dict):
        preset = top.text("limits", "firmware", LIMIT_PRESETS)
        return None if preset == "none" else preset
    section = Section(given, top.at("limits"))
    if section.has("preset"):
        return _read_lowered(section)
    section.take("preset")
    top_speeds = [section.number(name, above=0.0) for name in ("v_max", "omega_max")]
    # A ramp left out is none: the robot answers at once.
    ramps = [
        section.number(name, above=0.0) if section.has(name) else section.take(name, math.inf)
        for name in ("v_accel", "omega_accel")
    ]
    section.done()
    return Limits(*top_speeds, *ramps)


def _read_lowered(section):
    preset = section.text("preset", choices=LIMIT_PRESETS[:2])
    lowered = LoweredLimits(
        preset,
        *(
            section.number(name, above=0.0) if section.has(name) else section.take(name, math.inf)
            for name in ("v_max", "omega_max")
        ),
    )
    section.done()
    return lowered


def limits_to_plain(limits):
    """Return ``limits`` as plain values, as a file has them."""
    if limits is None:
        return "none"
    if isinstance(limits, str):
        return limits
    return {name: value for name, value in limits._asdict().items() if value != math.inf}
