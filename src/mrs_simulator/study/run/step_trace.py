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

    def add(self):
        """Keep the state of now."""
        world = self._experiment.world
        self._states.append(self._experiment.state(world.pose, world.command).copy())

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
        return evaluated(control, run.in_space(control.dimension))
