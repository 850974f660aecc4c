"""The states of a headless run at every step of the world, in memory, for its requirements."""

import numpy as np

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.record.recording import Run
from mrs_simulator.state.columns import HAND
from mrs_simulator.state.state_table import stacked
from mrs_simulator.verdict.requirements.results import evaluated, left_open


class StepTrace:
    """What requirements are evaluated on: recorded samples may miss what happens between them."""

    def __init__(self, experiment):
        """Begin a trace of ``experiment``, with no state yet."""
        self._experiment, self._states = experiment, []
        wanted = set().union(*(each.sensors for each in experiment.scenario.requirements))
        self._readings = {each: [] for each in sorted(wanted)}

    def add(self):
        """Keep the state of now."""
        world = self._experiment.world
        self._states.append(self._experiment.state(world.pose, world.command).copy())
        if self._readings:
            self._add_readings(self._experiment.sensors.readings(world.time))

    def _add_readings(self, newest):
        """Keep the least of each wanted field of the ``newest`` readings, ``{row: {name: reading}}``."""
        for (name, field), values in self._readings.items():
            values.append([_least(newest[row].get(name), field) for row in sorted(newest)])

    def results(self):
        """Return what became of the requirements, as ``results.evaluated`` does."""
        experiment = self._experiment
        scenario, control = experiment.scenario, experiment.control
        if not self._states:
            return left_open(scenario, "the run ended at its first command")
        state = stacked(self._states)
        if not state.has(HAND):
            state = state.replace(hand=hand_points(state.pose, control.l))
        state = state.replace(robots=np.arange(1, scenario.n + 1))
        run = Run(**vars(state), collisions=experiment.collisions, scenario=scenario)
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
