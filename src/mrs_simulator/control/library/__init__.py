"""The shipped protocols: a name for each, and the class behind it."""

import importlib

# Scenarios, launch files and the GUI name them so.
HOMES = {
    "consensus": "consensus:Consensus",
    "formation": "formation:Formation",
}


def shipped(name):
    """Return the class of the shipped protocol called ``name``; ``KeyError`` if there is none."""
    module, _, class_name = HOMES[name].partition(":")
    return getattr(importlib.import_module("mrs_simulator.control.library." + module), class_name)
