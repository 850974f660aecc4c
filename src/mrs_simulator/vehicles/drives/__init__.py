"""The drives: one module each, pure functions over the robots of that drive.

``docs/development.md`` says what a module provides; ``differential`` is the one to read first.
"""

import importlib

from mrs_simulator.core.fields import unknown_name

DRIVES = ("differential", "omnidirectional", "car", "vessel", "quadrotor")


def drive_module(name):
    """Return the module of the drive called ``name``; ``ValueError`` if there is none."""
    if name not in DRIVES:
        raise ValueError(unknown_name("drive", name, DRIVES))
    return importlib.import_module("mrs_simulator.vehicles.drives." + name)
