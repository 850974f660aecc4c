"""Verify coordination protocols of multi-robot systems, in simulation and on real robots.

The names below are loaded when first used, so that the core can be imported without ROS.
"""

import importlib

from mrs_simulator import moved
from mrs_simulator.version import __version__

moved.install()

_HOMES = {
    "PioneerControl": "mrs_simulator.control.pioneer_control",
    "Position": "mrs_simulator.control.pioneer_control",
    "array_law": "mrs_simulator.control.array_law",
    "make_twist": "mrs_simulator.control.twist_message",
    "Twist": "mrs_simulator.control.twist_message",
    "Parameter": "mrs_simulator.core.fields",
    "run": "mrs_simulator.nodes.control.starting",
    "run_experiment": "mrs_simulator.study.run.experiment",
    "load_scenario": "mrs_simulator.scenario.scenario",
    "simulate": "mrs_simulator.study.run.simulating",
    "open_run": "mrs_simulator.study.run.simulating",
}

__all__ = ["__version__"] + sorted(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError("module 'mrs_simulator' has no attribute {!r}".format(name))
    return getattr(importlib.import_module(_HOMES[name]), name)
