#!/usr/bin/env python3
"""How far sound robots of each kind are from their commands, beside the spread that kinds declare.

    python3 benchmarks/spreads.py                     # all kinds, without and with forces
    python3 benchmarks/spreads.py heron wamv otter    # these alone

Six robots of a kind make formations and pursue each other, from rest at headings drawn at random.  Printed
is the largest value less its 3 standard errors over all windows, of wheels and axes of which the run tells,
and in brackets the spread of the kind's file.  Exits with 1 where one is above its spread.
"""

import argparse
import os
import sys
import tempfile

import numpy as np
import yaml

from mrs_simulator.record.recording import part_of
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import perform
from mrs_simulator.vehicles.registry import kind as load_kind
from mrs_simulator.vehicles.registry import shipped_kinds
from mrs_simulator.verdict.obedience import SURE, fits

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")
LAWS = ("displacement_formation", "cyclic_pursuit", "containment")
SEEDS, DURATION, SIZE = 2, 20.0, 4.0  # [-], [s], [-] of the shipped distances, for larger bodies


def largest(name, fidelity):
    """Return the largest gain less 1, dead time [s] and bias [m/s] beyond their errors, (3,)."""
    worst = np.zeros(3)
    for law in LAWS:
        for seed in range(SEEDS):
            found = fits_of(scenario_of(law, name, fidelity, seed))
            if found is not None:
                beyond = np.where(found.tells, np.abs(found.found) - SURE * found.error, 0.0)
                worst = np.maximum(worst, beyond.max(axis=(0, 1, 2)))
    return worst


def scenario_of(law, name, fidelity, seed):
    """Return the scenario ``law`` with robots of the kind ``name``, far apart, at other headings."""
    with open(os.path.join(SCENARIOS, law + ".yaml"), encoding="utf-8") as file:
        shipped = yaml.safe_load(file)
    poses = np.array(shipped["poses"])
    poses[:, :2] *= SIZE
    poses[:, 2] = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(poses))
    control = dict(shipped["control"], saturation="robot")
    control["parameters"].update({"size": SIZE * 3.0} if "size" in control["parameters"] else {})
    topology = {"topology": shipped["topology"]} if "topology" in shipped else {}
    keys = {"fidelity": fidelity, "limits": "firmware", "kind": name, "duration": DURATION}
    content = {"poses": poses.tolist(), "control": control, **topology, **keys}
    return scenario_from_dict(content, law)


def fits_of(scenario):
    """Return the ``Fits`` of a run until bodies touch."""
    with tempfile.TemporaryDirectory() as out:
        run, control = perform(scenario, out)
    if run.collisions:
        end = int(np.searchsorted(run.time, run.collisions[0].time))
        run = part_of(run, slice(0, end))
    return fits(control, run)


def main():
    """Print a line for each kind and fidelity."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", help="by default all")
    parser.add_argument("--fidelity", choices=("kinematic", "dynamic"))
    arguments = parser.parse_args()
    wrong = False
    for name in arguments.kinds or shipped_kinds():
        for fidelity in [arguments.fidelity] if arguments.fidelity else ("kinematic", "dynamic"):
            try:
                worst = largest(name, fidelity)
            except ValueError as error:
                print("{} {}: {}".format(name, fidelity, error), flush=True)
                continue
            print(line(name, fidelity, worst), flush=True)
            wrong = wrong or (worst > spread_of(name, fidelity)).any()
    sys.exit(1 if wrong else 0)


def spread_of(name, fidelity):
    """Return what the kind ``name`` declares, (3,)."""
    return np.array(load_kind(name).spread[fidelity])


def line(name, fidelity, worst):
    """Return what was found beside what is declared, as a text."""
    said = [
        "{:.3g} ({:g})".format(*each) for each in zip(worst, spread_of(name, fidelity).tolist())
    ]
    return "{:20} {:10} gain {}, dead time {} s, bias {} m/s".format(name, fidelity, *said)


if __name__ == "__main__":
    main()
