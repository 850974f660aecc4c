"""Runs of ideal robots under the law itself, beside a recorded run: of laws without a form on points."""

import contextlib
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
        scenario = run.scenario
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
                return run_of(ideal, self._protocol)
            except (ControlError, ScenarioError):
                return None


def run_of(scenario, protocol):
    """Return the ``Run`` of the robots of ``scenario`` under ``protocol``, kept in memory.

    None where bodies touched, or commands were none that robots can have.  Raises what the law raises.
    """
    world = World.from_scenario(scenario)
    try:
        control, states = make_control(scenario, protocol), []
        sensors = Suite.of_scenario(scenario, *world.senses)
        sensors.activate(dict.fromkeys(range(scenario.n), control.SENSORS))
        world.rise()
        call(control.start)
        for step in range(int(round(scenario.duration / scenario.step)) + 1):
            if step:
                world.step()
            if world.contacts.take() or world.faults.take():
                return None
            sensors.update(step, world.sensed)
            if step % scenario.steps_per_command == 0:
                joints = world.joints if world.team.has_joints else None
                readings = None if sensors.is_idle else sensors.readings(world.time)
                command = call(control.commands, world.pose, world.time, joints, readings)
                if not world.set_commands(EVERY, command):
                    return None
            if step % scenario.steps_per_record == 0:
                states.append(world.team.recorded(world.state(), control.l).copy())
    finally:
        world.close()
    table, numbers = stacked(states), np.arange(1, scenario.n + 1)
    columns = {name: value for name, value in vars(table).items() if name in COLUMNS}
    more = {"scenario": scenario, "meta": {"lockstep": True}, "axes": world.team.axes}
    return Run(table.time, numbers, **columns, **more)
