"""The states of a headless run at every step of the world, in memory, for its requirements."""

import numpy as np

from mrs_simulator.core.kinematics import hand_points
from mrs_simulator.core.spatial import Spatial
from mrs_simulator.record.recording import Run
from mrs_simulator.verdict.requirements.results import evaluated


class StepTrace:
    """What requirements are evaluated on: recorded samples may miss what happens between them."""

    def __init__(self, experiment):
        """Begin a trace of ``experiment``, with no state yet."""
        self._experiment, self._states, self._spatial = experiment, [], []

    def add(self):
        """Keep the state of now."""
        experiment, world = self._experiment, self._experiment.world
        pose, more = world.pose.copy(), experiment.more()
        points = experiment.points(pose)
        self._states.append((world.time, pose, world.command.copy(), points))
        if more.get("spatial") is not None:
            spatial = more["spatial"].copy()
            self._spatial.append((*spatial, np.copy(more.get("point_z", spatial.z))))

    def results(self):
        """Return what became of the requirements, as ``results.evaluated`` does."""
        experiment, (time, pose, command, points) = self._experiment, zip(*self._states)
        scenario, control = experiment.scenario, experiment.control
        pose = np.array(pose)
        hand = hand_points(pose, control.l) if points[0] is None else np.array(points)
        run = Run(np.array(time), np.arange(1, scenario.n + 1), pose, hand, np.array(command))
        run = run._replace(collisions=experiment.collisions, scenario=scenario)
        if self._spatial:
            *spatial, point_z = map(np.array, zip(*self._spatial))
            run = run._replace(spatial=Spatial(*spatial), point_z=point_z)
        return evaluated(control, run.in_space(control.dimension))
