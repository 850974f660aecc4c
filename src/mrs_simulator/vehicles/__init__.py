"""The kinds of robots: one module each, its model file beside it."""

import importlib

from mrs_simulator.core.kinematics import NO_LIMITS, Limits
from mrs_simulator.core.parameters import unknown_name

KINDS = ("pioneer3dx",)


def robot_kind(name):
    """Return the module that describes the kind of robot called ``name``."""
    if name not in KINDS:
        raise ValueError(unknown_name("model", name, KINDS))
    return importlib.import_module("mrs_simulator.vehicles." + name)


def limits_of(kind, limits):
    """Return the ``Limits`` of a ``kind`` of robot under ``limits``.

    ``limits``: "firmware" (factory settings), "top" (the highest the firmware accepts), None for
    no limits, or ``Limits`` of one's own.
    """
    if limits is None:
        return NO_LIMITS
    if isinstance(limits, Limits):
        return limits
    module = robot_kind(kind)
    return {"firmware": module.FIRMWARE_LIMITS, "top": module.TOP_LIMITS}[limits]


def limits_of_team(kinds, limits):
    """Return the ``Limits`` that every robot of the team can keep to."""
    return Limits(*map(min, zip(*(limits_of(kind, limits) for kind in set(kinds)))))
