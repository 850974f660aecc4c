"""What the tests of protocols share: shipped scenarios, their verdicts, their checks."""

import functools
import os

import numpy as np
import pytest

from mrs_simulator import load_scenario, run_experiment

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")


@functools.lru_cache(maxsize=None)
def as_it_ships(name):
    """Return the shipped scenario itself, read once."""
    return load_scenario(os.path.join(SCENARIOS, name + ".yaml"))


def shipped(name, parameters=None, rate=None, **changes):
    """Return the shipped scenario with other parameters, rate [Hz] of commands and top-level keys."""
    scenario = as_it_ships(name)
    control = scenario.control.to_plain()
    control["parameters"] = dict(control["parameters"], **(parameters or {}))
    if rate:
        control["rate"] = rate
        changes["step"] = min(0.02, 1.0 / rate)
    return scenario.changed(control=control, **changes)


def ended_early(shares):
    """Parametrise by the ``name`` of a shipped scenario and the ``share`` of its duration that is run.

    ``shares``: that by name, enough for theory to speak of all; before a release the whole as well, and
    it alone where none is given.
    """
    early = [(name, share) for name, share in shares.items() if share]
    whole = [pytest.param(name, 1.0, marks=pytest.mark.release) for name in shares]
    return pytest.mark.parametrize("name, share", early + whole)


def part_of_shipped(name, share, **changes):
    """Return the shipped scenario, ended after this share of its duration."""
    scenario = shipped(name, **changes)
    return scenario._replace(duration=share * scenario.duration)


def near_the_line(directory):
    """Write the scenario ``paper_four`` from where its robots are after 28 s; return its path."""
    poses = [[1.49, 11.61, 2.16], [-0.84, 12.11, 2.26], [-2.94, 12.25, 2.43], [-5.05, 12.3, 0.0]]
    path = os.path.join(str(directory), "near.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(shipped("paper_four", poses=poses).to_yaml())
    return path


def as_points(scenario):
    """Return the scenario on point masses without limits."""
    control = scenario.control._replace(saturation="none")
    return scenario._replace(fidelity="point_mass", limits=None, control=control)


def verdict_of(scenario, out, law=None):
    """Run; a ``law`` of another class keeps the parameters if the scenario names that class."""
    if law is not None:
        control = dict(scenario.control.to_plain(), protocol="test:" + law.__name__)
        scenario = scenario.changed(control=control)
    return run_experiment(scenario, str(out), law, formats=())


def played(control, scenario, period, steps):
    """Return the control's commands, one each ``period`` [s], to point masses without limits."""
    pose, commands = np.array(scenario.poses), []
    for step in range(steps):
        commands.append(control.commands(pose, period * step))
        pose[:, :2] += period * commands[-1]
    return commands


def failed(verdict):
    return [check["name"] for check in verdict["checks"] if check["passed"] is False]


def check(verdict, name):
    (found,) = [check for check in verdict["checks"] if check["name"].startswith(name)]
    return found
