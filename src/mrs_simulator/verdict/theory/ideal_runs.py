"""Runs of ideal robots under the law itself, beside a recorded run: of laws without a form on points."""

import contextlib
import itertools
from types import SimpleNamespace

import numpy as np

from mrs_simulator.control.twists import ControlError
from mrs_simulator.control.user_code import call
from mrs_simulator.core.writing import Limited
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.state.columns import COLUMNS
from mrs_simulator.state.state_table import stacked
from mrs_simulator.world.world import EVERY, World

# Keys of a scenario that ideal robots do without; those of its control.
DROPPED = {
    "cmd_vel_timeout",
    "engine",
    "estimates",
    "mismatch",
    "odometry",
    "odometry_errors",
    "odometry_rate",
    "record",
    "requirements",
    "search",
}
DROPPED_OF_CONTROL = {"deadband", "safety"}
IDEAL = {"fidelity": "kinematic", "limits": "none"}
MOST_COMMANDS = 100000  # [-] of all robots in one run: a second or two


class IdealRuns:
    """The robots of ``run`` without limits, slip, delay, errors and safety filter, under their own law."""

    def __init__(self, control, run):
        """Where events or edges by chance change the run, or it was not in lockstep, there are none."""
        scenario, self._going = run.scenario, {}  # by how many times as many commands
        self._protocol, self._scenario, self._content = type(control), scenario, None
        if scenario is None or not run.meta.get("lockstep") or scenario.events or scenario.load:
            return
        if control.links.faults or control.dimension != 2 or control.team.has_arms:
            return
        given = scenario.to_dict()
        content = {key: value for key, value in given.items() if key not in DROPPED}
        if scenario.fidelity != "point_mass":
            content.update(IDEAL)
        own = content.get("control", {}).items()
        kept = {key: value for key, value in own if key not in DROPPED_OF_CONTROL}
        self._content = {**content, "control": {**kept, "saturation": "none"}}

    def over(self, seconds, beside=None, commands=1):
        """Return the ``Run`` over ``seconds``, None where it is too long, or bodies touch.

        ``beside`` (n, 2) [m]: from a start beside the run's; ``commands``: so many times as many.
        """
        scenario, rate = self._scenario, None
        if self._content is not None:
            rate = commands * scenario.control.rate
        if rate is None or seconds * rate * scenario.n > MOST_COMMANDS:
            return None
        control = dict(self._content["control"], rate=rate)
        content = dict(self._content, duration=seconds, control=control)
        if commands > 1:
            content.pop("step", None)
        with contextlib.redirect_stdout(Limited(SimpleNamespace(value=0))):
            try:
                ideal = scenario_from_dict(content, "ideal robots")._replace(path=scenario.path)
                if beside is not None:
                    poses = ideal.poses.copy()
                    poses[:, :2] += beside[:, :2]
                    ideal = ideal._replace(poses=poses)
                    return Going(ideal, self._protocol).over(ideal)
                if commands not in self._going:
                    self._going[commands] = Going(ideal, self._protocol)
                return self._going[commands].over(ideal)
            except (ControlError, ScenarioError):
                return None


class Going:
    """A run of the robots of a ``scenario`` under ``protocol``, kept in memory, that can go on."""

    def __init__(self, scenario, protocol):
        self._states, self._done, self._axes = [], 0, None
        self._steps = self._stepped(scenario, protocol)

    def over(self, scenario):
        """Return the ``Run`` until the end of ``scenario``, which has another duration at most.

        None where bodies touch before, or commands are none that robots can have.  Raises what the law
        raises, and is None from then on.
        """
        last = int(round(scenario.duration / scenario.step))
        for _ in itertools.islice(self._steps, max(0, last + 1 - self._done)):
            self._done += 1
        if self._done <= last:
            return None
        table = stacked(self._states[: last // scenario.steps_per_record + 1])
        columns = {name: value for name, value in vars(table).items() if name in COLUMNS}
        more = {"scenario": scenario, "meta": {"lockstep": True}, "axes": self._axes}
        return Run(table.time, np.arange(1, scenario.n + 1), **columns, **more)

    def _stepped(self, scenario, protocol):
        """Yield after each step, whose state is kept where it is recorded; end where bodies touch."""
        world = World.from_scenario(scenario)
        self._axes = world.team.axes
        try:
            control = make_control(scenario, protocol)
            sensors = Suite.of_scenario(scenario, *world.senses)
            sensors.activate(dict.fromkeys(range(scenario.n), control.SENSORS))
            world.rise()
            call(control.start)
            for step in itertools.count():
                if step:
                    world.step()
                if world.contacts.take() or world.faults.take():
                    return
                sensors.update(step, world.sensed)
                if step % scenario.steps_per_command == 0:
                    joints = world.joints if world.team.has_joints else None
                    readings = None if sensors.is_idle else sensors.readings(world.time)
                    command = call(control.commands, world.pose, world.time, joints, readings)
                    if not world.set_commands(EVERY, command):
                        return
                if step % scenario.steps_per_record == 0:
                    self._states.append(world.team.recorded(world.state(), control.l).copy())
                yield
        finally:
            world.close()
