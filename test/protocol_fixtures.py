"""What the tests of protocols share: shipped scenarios, their verdicts, their checks."""

import os

from mrs_simulator import load_scenario, run_experiment

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")


def shipped(name, parameters=None, **changes):
    scenario = load_scenario(os.path.join(SCENARIOS, name + ".yaml"))
    changed = dict(scenario.control.parameters, **(parameters or {}))
    control = dict(scenario.control._asdict(), parameters=changed)
    return scenario.changed(control=control, **changes)


def verdict_of(scenario, out, law=None):
    """Run; a ``law`` of another class keeps the parameters if the scenario names that class."""
    if law is not None:
        control = dict(scenario.control._asdict(), protocol="test:" + law.__name__)
        scenario = scenario.changed(control=control)
    return run_experiment(scenario, str(out), law, formats=())


def failed(verdict):
    return [check["name"] for check in verdict["checks"] if check["passed"] is False]


def check(verdict, name):
    (found,) = [check for check in verdict["checks"] if check["name"].startswith(name)]
    return found
