"""The states of a run at every step of the world, in memory, for its requirements."""

import numpy as np

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.record.recording import Run
from mrs_simulator.state.columns import HAND
from mrs_simulator.state.state_table import stacked
from mrs_simulator.verdict.requirements.results import evaluated, left_open


class StepTrace:
    """What requirements are evaluated on: recorded samples may miss what happens between them."""

    def __init__(self, requirements):
        """Begin a trace for ``requirements``, with no state yet."""
        self._states = []
        wanted = set().union(*(each.sensors for each in requirements))
        self._readings = {each: [] for each in sorted(wanted)}

    def add(self, state, readings=None):
        """Keep the ``state`` at one step, and the newest ``readings``, ``{row: {name: reading}}``."""
        self._states.append(state.copy())
        for (name, field), values in self._readings.items():
            values.append([_least(readings[row].get(name), field) for row in sorted(readings)])

    def results(self, scenario, control, collisions, begun=0.0):
        """Return what became of the requirements of ``scenario``, as ``results.evaluated`` does.

        ``control`` computes signals; ``collisions`` with times since the run began, at ``begun`` [s].
        """
        if not self._states:
            return left_open(scenario, "the run ended at its first command")
        state = stacked(self._states)
        if not state.has(HAND):
            state = state.replace(hand=hand_points(state.pose, control.l))
        time = np.round(state.time - begun, 9) if begun else state.time
        robots = np.arange(1, scenario.n + 1)
        state = state.replace(time=time, robots=robots)
        run = Run(**vars(state), collisions=collisions, scenario=scenario)
        run.meta["readings"] = {key: _filled(rows) for key, rows in self._readings.items()}
        return evaluated(control, run.in_space(control.dimension))


def _least(reading, field):
    """Return the least of a ``reading``'s ``field``, inf where it is empty, nan where none is known."""
    values = np.ravel(np.asarray(getattr(reading, field, np.nan), dtype=float))
    return float(np.fmin.reduce(values)) if len(values) else np.inf


def _filled(rows):
    """Return the values (n, m) of m steps, unknown ones those before them, or the first that is known."""
    values = np.array(rows, dtype=float).T
    for own in values:
        known = np.flatnonzero(~np.isnan(own))
        if len(known):
            before = np.searchsorted(known, np.arange(len(own)), side="right") - 1
            own[:] = own[known[np.maximum(before, 0)]]
    return values
