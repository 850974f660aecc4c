"""The ``limits`` of a scenario: a preset, a preset lowered, or numbers of its own."""

import math
from typing import NamedTuple

from mrs_simulator.core.fields import POSITIVE, REQUIRED, TEXT, Field
from mrs_simulator.core.kinematics import Limits
from mrs_simulator.scenario.reading import Section

LIMIT_PRESETS = ("firmware", "top", "none")


V_MAX = Field("v_max", math.inf, "m/s", **POSITIVE)
OMEGA_MAX = Field("omega_max", math.inf, "rad/s", **POSITIVE)
LOWERED = (Field("preset", choices=LIMIT_PRESETS[:2], type=TEXT, rule=REQUIRED), V_MAX, OMEGA_MAX)
OWN = (
    V_MAX._replace(rule=REQUIRED),
    OMEGA_MAX._replace(rule=REQUIRED),
    # A ramp left out is none: the robot answers at once.
    V_MAX._replace(name="v_accel", unit="m/s^2"),
    OMEGA_MAX._replace(name="omega_accel", unit="rad/s^2"),
)


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
        return LoweredLimits(**section.values(LOWERED))
    section.take("preset")
    return Limits(**section.values(OWN))


def limits_to_plain(limits):
    """Return ``limits`` as plain values, as a file has them."""
    if limits is None:
        return "none"
    if isinstance(limits, str):
        return limits
    return {name: value for name, value in limits._asdict().items() if value != math.inf}
