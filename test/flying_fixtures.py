"""A drive that leaves the ground, registered for a test."""

import importlib.util
import os
import sys

import pytest

from mrs_simulator.vehicles import drives

HERE = os.path.dirname(os.path.abspath(__file__))
NAME = "mrs_simulator.vehicles.drives.hoverer"
KIND = """
title: Hoverer
drive: hoverer
body: {radius: 0.2 m, height: 0.1 m}
mass: 0.5 kg
flight: {lean: 0.1}
limits:
  firmware:
    linear.x: {max: 1 m/s, acceleration: 2 m/s^2}
    linear.y: {max: 1 m/s, acceleration: 2 m/s^2}
    linear.z: {max: 0.5 m/s, acceleration: 1 m/s^2}
    angular.z: {max: 90 deg/s, acceleration: 3 rad/s^2}
"""


KNOWING = (
    drives,
    sys.modules["mrs_simulator.vehicles.kind"],
)  # modules that have the drives' names


def register():
    """Make the drive in ``hoverer.py`` a module of the package; return the names of all drives."""
    specification = importlib.util.spec_from_file_location(NAME, os.path.join(HERE, "hoverer.py"))
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    sys.modules[NAME] = module
    return tuple(dict.fromkeys((*drives.DRIVES, "hoverer")))


@pytest.fixture
def hoverer(monkeypatch, tmp_path):
    """Return the path of a kind of that drive."""
    monkeypatch.setitem(sys.modules, NAME, None)
    known = register()
    for each in KNOWING:
        monkeypatch.setattr(each, "DRIVES", known)
    path = tmp_path / "hoverer.yaml"
    path.write_text(KIND)
    return str(path)
