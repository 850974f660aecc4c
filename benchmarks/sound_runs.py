#!/usr/bin/env python3
"""Right laws on sound robots, over kinds, numbers, rates, limits, filters and noise: none may fail.

    python3 benchmarks/sound_runs.py           # all of them
    python3 benchmarks/sound_runs.py 10        # the first ten

Prints the outcome of each run, and what failed in it; exits with 1 where one failed.
"""

import argparse
import collections
import itertools
import os
import sys
import tempfile

from mrs_simulator import load_scenario, run_experiment

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")
NOISE = {"odometry": "wheel", "odometry_errors": {"alpha": [1e-4, 0.0, 0.0, 1e-4, 0.0, 0.0]}}
LAWS = ("displacement_formation", "paper", "marching", "containment", "cyclic_pursuit")
CHANGES = (  # keys of the scenario, and of its control
    ({"fidelity": "kinematic", "limits": "firmware"}, {}),
    ({"fidelity": "kinematic", "limits": "top"}, {"safety": {"speed": 0.7}}),
    ({"fidelity": "dynamic"}, {}),
    ({"fidelity": "dynamic", "mismatch": {"speed": 1.0001}}, {}),
    ({"fidelity": "kinematic", "mismatch": {"speed": 0.98, "delay": 0.1}}, {}),
    ({"fidelity": "kinematic", "step": 0.02}, {"rate": 10}),
    ({"fidelity": "dynamic", "step": 0.02}, {"rate": 10, "parameters": {"l": 0.2}}),
    ({"fidelity": "kinematic", **NOISE}, {}),
    ({"fidelity": "kinematic", **NOISE, "estimates": "odometry"}, {}),
    ({"fidelity": "kinematic", "record_rate": 50.0}, {"deadband": 0.01}),
)
KINDS = (
    "formation_mixed",
    "formation_cars",
    "formation_boats",
    "formation_crazyflies",
    "formation_omnidirectional",
)
BY_KIND = ("kinematic", "dynamic")


def runs():
    """Yield names and scenarios: laws on Pioneers under all changes, then other kinds."""
    for (keys, own), name in itertools.product(CHANGES, LAWS):
        yield name, scenario_of(name, keys, own)
    for fidelity, name in itertools.product(BY_KIND, KINDS):
        yield name, scenario_of(name, {"fidelity": fidelity}, {})


def scenario_of(name, keys, own):
    """Return the shipped scenario ``name`` with other ``keys``, and ``own`` of its control."""
    scenario = load_scenario(os.path.join(SCENARIOS, name + ".yaml"))
    control = dict(scenario.control.to_plain())
    parameters = dict(control.get("parameters", {}), **own.get("parameters", {}))
    control = {**control, **own, "parameters": parameters}
    return scenario.changed(control=control, **keys)


def main():
    """Run them, and print a line each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int)
    outcomes = collections.Counter()
    for name, scenario in itertools.islice(runs(), parser.parse_args().count):
        with tempfile.TemporaryDirectory() as out:
            verdict = run_experiment(scenario, out, formats=())
        outcomes[verdict["outcome"]] += 1
        wrong = [
            "{} {}, allowed {} ({})".format(c["name"], c["measured"], c["tolerance"], c["note"])
            for c in verdict["checks"]
            if c["passed"] is False
        ]
        found = name, scenario.fidelity, verdict["outcome"], "; ".join(wrong)
        print("{} {}: {} {}".format(*found), flush=True)
    print(dict(outcomes))
    sys.exit(1 if outcomes["failed"] else 0)


if __name__ == "__main__":
    main()
