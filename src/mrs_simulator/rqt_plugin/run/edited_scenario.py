"""The edited scenario, what its protocol derives from it, and undo of edits; without Qt."""

import functools
import time

import numpy as np

from mrs_simulator.core.fields import Field, checked_values
from mrs_simulator.core.graphs import Topology
from mrs_simulator.protocols import HOMES
from mrs_simulator.rqt_plugin.run.error_message import ErrorMessage, reason
from mrs_simulator.rqt_plugin.widgets.debounced_worker import DebouncedWorker
from mrs_simulator.scenario.safety import Safety
from mrs_simulator.scenario.scenario import title_of
from mrs_simulator.scenario.surroundings.maps import obstacles_of
from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at
from mrs_simulator.scenario.surroundings.obstacle_reading import checked_obstacles
from mrs_simulator.study.run.law_process import LawProcess
from mrs_simulator.vehicles import Team, kind
from mrs_simulator.world.checks import checked_heights, refuse_in_obstacles, refuse_overlaps
from mrs_simulator.world.contact.bodies import Bodies

LONGEST_PREDICTION = 120.0  # [s] of wall time; that of containment takes 10 s with 200 robots
DURATION = Field("duration", 60.0, "s", high=1e5)  # at least a step of the simulation
PREDICTION_REST = 0.25  # [s] after the last edit until theory's error is computed
MOST_UNDONE = 200  # [-] edits that can be undone
TOGETHER = 0.5  # [s] of wall time between changes of poses that are one edit, such as a drag


class EditedScenario:
    """A scenario that its law accepts; edits that the law refuses change nothing."""

    def __init__(self, scenario, connection, state):
        """``state``: the ``StudyState``, which knows whether a controller follows the edits."""
        self._connection, self._state = connection, state
        self.scenario, self.undo = scenario, Undo()
        self.derived = None  # law_answers.Facts of the scenario, since it was applied
        # A user's law runs in neither thread of the GUI: one process for edits, which the user waits
        # for, one for what takes longer, of shipped laws too.
        self.laws, self._background = LawProcess(), LawProcess(LONGEST_PREDICTION)
        self._prediction = DebouncedWorker(PREDICTION_REST)
        self._run_prediction = DebouncedWorker(PREDICTION_REST)
        self._forecast = DebouncedWorker(PREDICTION_REST)
        self.take_forecast = self._forecast.take
        self.take_prediction = self._prediction.take
        self.take_run_prediction = self._run_prediction.take

    def take(self, scenario):
        """Apply ``scenario``; where its protocol raises an exception, the old one stays."""
        self.derived = self.laws.ask("facts", scenario)
        self.scenario = scenario
        self.predict(scenario)

    def predict(self, scenario):
        """Compute the prediction for ``scenario`` in the background, for ``take_prediction``.

        Its paths are for ``take_forecast``.
        """
        self._prediction.ask(lambda: self._background.ask("prediction", scenario))
        self._forecast.ask(lambda: self._background.ask("forecast", scenario))

    def predict_run(self, scenario, poses):
        """Compute the prediction of a run from ``poses`` (n, 3), for ``take_run_prediction``.

        ``scenario``: None if the running law is unknown: no prediction.
        """
        work = None
        if scenario is not None and len(poses) == scenario.n and np.isfinite(poses).all():
            begun = scenario._replace(poses=poses.copy())
            work = functools.partial(self._background.ask, "prediction", begun)
        self._run_prediction.ask(work)

    def try_out(self, scenario):
        """Take up ``scenario``; return what is wrong with it, or ""."""
        before = self.scenario
        try:
            self.take(scenario)
        except Exception as error:  # a file of one's own may raise anything
            return ErrorMessage("not applied: {}".format(reason(error)))
        self.undo.note(before, scenario)
        return ""

    def restore(self, scenario):
        """Take up an earlier or later ``scenario``, at the speed of now; return what is wrong, or "".

        A controller that is there gets its parameters and its graph at once.
        """
        before, scenario = self.scenario, scenario._replace(speed=self.scenario.speed)
        try:
            self.take(scenario)
        except Exception as error:  # a file of one's own may raise anything
            return ErrorMessage("not applied: {}".format(reason(error)))
        same = scenario.control.protocol == before.control.protocol and scenario.n == before.n
        if same and self._state.has_control():
            if repr(scenario.topology) != repr(before.topology):
                topology = self.derived.topology
                self._connection.set_topology(topology.edges, topology.directed)
            if scenario.control.parameters != before.control.parameters:
                self._connection.set_parameters(self.derived.values)
        return ""

    def set_team(self, poses, kinds, altitude=None):
        """Take in a team; edges of robots that are gone go with them.  Return what is wrong, or ""."""
        topology = self.scenario.topology
        if topology is not None:
            topology = topology.for_robots(len(poses))
        scenario = self.scenario._replace(
            poses=poses, kinds=tuple(kinds), altitude=altitude, topology=topology
        )
        if len(poses) != self.scenario.n:
            title = title_of(len(poses), scenario.control.protocol)
            scenario = scenario._replace(title=title)
        return self.try_out(scenario)

    def set_obstacles(self, obstacles):
        """Take other obstacles of the scenario's own; return what is wrong with them, or ""."""
        try:
            obstacles = checked_obstacles(obstacles)
            obstacles_of(self.scenario._replace(obstacles=obstacles))  # names beside those of walls
            if self.scenario.fidelity != "point_mass":  # others have bodies
                bodies = Bodies(self.team(), obstacles)
                refuse_in_obstacles(bodies, self.scenario.poses, self._heights())
        except ValueError as error:
            return ErrorMessage("not applied: {}".format(error))
        return self.try_out(self.scenario._replace(obstacles=obstacles))

    def no_start(self):
        """Return which robots a simulation would refuse where they begin, and why, or ""."""
        scenario = self.scenario
        if scenario.fidelity == "point_mass":  # others have bodies
            return ""
        try:
            team, obstacles = self.team(), obstacles_at(obstacles_of(scenario), 0.0)
            heights = checked_heights(team, scenario.altitude)
            refuse_overlaps(team, scenario.poses, obstacles, z=heights)
        except ValueError as error:
            return str(error)
        return ""

    def _heights(self):
        """Return the heights (n,) [m] at which robots begin, None on the ground."""
        return None if self.scenario.takeoff else self.scenario.altitude

    def kind(self, name):
        """Return the ``Kind`` that ``name`` means in the scenario."""
        return kind(name, self.scenario.directory, self.scenario.own_kinds)

    def team(self):
        """Return the ``Team`` of the scenario's robots."""
        return Team.from_scenario(self.scenario)

    def set_protocol(self, name):
        """Take another protocol with its defaults; return what is wrong with it, or ""."""
        scenario = self.scenario.with_protocol(name)
        if scenario.topology is None:
            scenario = scenario._replace(topology=Topology.preset("cycle", scenario.n))
        return self.try_out(scenario)

    def set_parameters(self, values):
        """Take other values; a controller that is there gets them at once.  Return what is wrong, or ""."""
        try:
            checked = checked_values(self.derived.parameters, values, self.derived.protocol)
        except ValueError as error:
            return ErrorMessage(error)
        control = self.scenario.control._replace(parameters=checked)
        wrong = self.try_out(self.scenario._replace(control=control))
        if not wrong and self._state.has_control():
            self._connection.set_parameters(checked)
        return wrong

    def set_safety(self, on):
        """Have the safety filter, of obstacles too, or none; return what is wrong with it, or ""."""
        control = self.scenario.control._replace(safety=Safety() if on else False)
        return self.try_out(self.scenario._replace(control=control))

    def set_topology(self, edges, directed):
        """Take another graph; a controller that is there gets it at once.  Return what is wrong, or ""."""
        topology = Topology(self.scenario.n, edges, directed)
        try:
            parameters = self.laws.ask("parameters_with", self.scenario, topology)
        except Exception as error:  # a file of one's own may raise anything
            return ErrorMessage("not applied: {}".format(reason(error)))
        changed = self.scenario.control._replace(parameters=parameters)
        wrong = self.try_out(self.scenario._replace(topology=topology, control=changed))
        if not wrong and self._state.has_control():
            self._connection.set_topology(edges, directed)
        return wrong

    def set_duration(self, duration):
        """Let the next run last for ``duration`` [s]; return what is wrong with it, or ""."""
        if duration == self.scenario.duration:
            return ""
        allowed = DURATION._replace(low=self.scenario.step)
        try:
            allowed.checked(duration)
        except ValueError as error:
            return ErrorMessage(error)
        return self.try_out(self.scenario._replace(duration=duration))

    def settling_with(self, topology, scenario=None):
        """Return in words how long the team would take over ``topology``, "" where theory says nothing.

        ``scenario``: another one than the edited.  It may take long, and is for a thread of its own.
        Raises what the law raises.
        """
        scenario = scenario or self.scenario
        parameters = self._background.ask("parameters_with", scenario, topology)
        control = scenario.control._replace(parameters=parameters)
        changed = scenario._replace(topology=topology, control=control)
        return self._background.ask("prediction", changed).settling

    def ask_apart(self, function, scenario, *arguments):
        """As ``LawProcess.ask`` of any ``scenario``; it may take long, and is for a thread of its own."""
        return self._background.ask(function, scenario, *arguments)

    def starts(self):
        """Return where the robots' odometry is zero in the common frame, (n, 3), None: at its origin."""
        return self.scenario.poses if self.scenario.odometry == "wheel" else None

    @property
    def is_users_law(self):
        """Return whether the protocol is not a shipped one."""
        return self.scenario.control.protocol not in HOMES

    def error_function(self, scenario=None):
        """Return a function of poses (m, n, 3) that gives the largest target error (m,), or None.

        ``scenario``: whose targets, by default the edited one's.  That of a user's law may take long, and
        is for a thread of its own.
        """
        if scenario is None and self.derived.targets is None:
            return None
        scenario = self.scenario if scenario is None else scenario
        return lambda pose: self._background.ask("errors", scenario, pose)

    def close(self):
        """End the laws' processes."""
        self._prediction.ask(None)
        self._run_prediction.ask(None)
        self._forecast.ask(None)
        self.laws.close()
        self._background.close()


class Undo:
    """The scenarios before each edit, and the edits that were undone."""

    def __init__(self):
        self.clear()

    def clear(self):
        """Drop all of them."""
        self.done, self.undone, self._moved = [], [], None

    def note(self, before, after):
        """Note the edit of the scenario ``before`` into ``after``."""
        now, is_move = time.monotonic(), without_poses(before) == without_poses(after)
        goes_on = is_move and self._moved is not None and now - self._moved < TOGETHER
        if not (goes_on and self.done):
            self.done = [*self.done[1 - MOST_UNDONE :], before]
        self.undone, self._moved = [], now if is_move else None

    def exchange(self, source, target, now):
        """Move the last of ``source`` away; the scenario ``now`` goes to ``target``."""
        source.pop()
        target.append(now)
        self._moved = None


def without_poses(scenario):
    """Return what of ``scenario`` an edit changes besides poses, for comparing."""
    rest = scenario.kinds, scenario.obstacles, scenario.topology, scenario.control
    return (scenario.n, scenario.duration, *map(repr, rest))
