"""Runs that go on from a snapshot: of every shipped scenario, the same bytes as before.

The tests run the first moments of each; ``python3 test/snapshot_runs.py`` runs each whole, in every
fidelity, and goes back from its end to its middle, which takes minutes.
"""

import itertools
import os
import sys

import numpy as np

from mrs_simulator.scenario.scenario import FIDELITIES, load_scenario
from mrs_simulator.state.columns import COLUMNS
from mrs_simulator.study.run.experiment import Experiment

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")
NAMES = sorted(name[:-5] for name in os.listdir(SCENARIOS) if name.endswith(".yaml"))


def rest_of(experiment, count=None):
    """Return what the next ``count`` samples, by default all, and the run then tell, as bytes."""
    told = []
    for time, pose, command in itertools.islice(experiment.samples(), count):
        estimate = experiment.world.estimates.pose()
        state = experiment.state(pose, command)
        recorded = [state[column] for column in COLUMNS.values() if state.has(column)]
        told.append(flat([time, estimate, *recorded]))
    ended = experiment.collisions, experiment.incidents, experiment.control.safety_filter.deadlock
    return [each.tobytes() for each in told], repr(ended), experiment.world.contacts.closest


def flat(values):
    """Return numbers and arrays in one array."""
    return np.concatenate([np.ravel(each).astype(float) for each in values])


def goes_on_alike(scenario, protocol=None, share=0.5):
    """Return whether a run of ``scenario`` goes on alike twice from its sample at this ``share``."""
    experiment = Experiment(scenario, protocol)
    try:
        count = int(scenario.duration * scenario.record_rate)
        rest_of(experiment, max(1, int(share * count)))
        kept = experiment.snapshot()
        rest = [rest_of(experiment)]
        for _ in range(2):
            experiment.restore(kept)
            rest.append(rest_of(experiment))
        return len(rest[0][0]) > 0 and rest[0] == rest[1] == rest[2]
    finally:
        experiment.world.close()


def shipped(name, **changes):
    """Return the shipped scenario of this ``name``."""
    return load_scenario(os.path.join(SCENARIOS, name + ".yaml"))._replace(**changes)


def main():
    """Run all; return how many do not go on alike."""
    wrong = 0
    for name, fidelity in itertools.product(NAMES, FIDELITIES):
        try:
            alike = goes_on_alike(shipped(name, fidelity=fidelity))
        except ValueError as error:
            alike = "refused: {}".format(error)
        wrong += alike is False
        print(name, fidelity, {True: "same", False: "DIFFERENT"}.get(alike, alike), flush=True)
    return wrong


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
