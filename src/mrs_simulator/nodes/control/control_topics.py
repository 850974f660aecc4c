"""The topics by which a control node receives sensors and publishes commands."""

from mrs_simulator.nodes.control.command_gate import RobotCommands, command_topics
from mrs_simulator.ros.node.rivals import Rivals
from mrs_simulator.ros.receive.odometry_inbox import TeamInbox
from mrs_simulator.ros.receive.sensor_inbox import SensorInbox
from mrs_simulator.ros.receive.team_topics import COMMAND, AnswerPublisher, TeamCommands
from mrs_simulator.sensors.mounts import fitted_mounts
from mrs_simulator.sensors.suite import check_fitted
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.odometry_rates import odometry_steps


def open_sensors(scenario, law_sensors, real, wake=None):
    """Return the ``SensorInbox`` of what law and estimates ask for, None where they ask for nothing.

    ``law_sensors``: names; ``real``: rows of the real robots; ``wake()`` is called at each reading.
    """
    estimating = scenario.estimates.asked if scenario.estimates else ()
    asked = tuple(dict.fromkeys((*law_sensors, *estimating)))
    if not asked:
        return None
    team = Team.from_scenario(scenario)
    mounts = fitted_mounts(team, scenario.sensors)
    for row, kind in enumerate(team.kinds):
        check_fitted(mounts[row], asked, row + 1, kind)
    wakes = {} if wake is None else {"wake": wake}
    known = asked, mounts, team.kinds, real, scenario.step
    return SensorInbox(*known, kept=estimating, **wakes)


def heed_rates(inbox, scenario):
    """Set in ``inbox`` how often each robot's odometry comes, by the scenario."""
    team, step = Team.from_scenario(scenario), scenario.step
    inbox.set_periods(step * odometry_steps(team, scenario.odometry_rate, step), step)


def refuse_arms_without_stage(team, inbox):
    """Raise ``ValueError`` where robots of ``team`` have arms and no stage takes their commands."""
    if team.has_arms and not isinstance(inbox, TeamInbox):
        text = "robots with arms without a stage: commands of arms go to a stage alone so far"
        raise ValueError(text)


def find_rivals(numbers, simulated):
    """Return the ``Rivals`` at the commands of the robots; ask before this node publishes them."""
    names = command_topics(numbers)
    return Rivals([*names, COMMAND] if simulated else names)


def open_commands(team, numbers, inbox, real, simulated):
    """Return what publishes the commands of ``team``: all in one message, or each on its own topic."""
    if isinstance(inbox, TeamInbox):
        return TeamCommands(numbers, team.axes)
    answers = AnswerPublisher(numbers, team.axes) if simulated else None
    return RobotCommands(command_topics(numbers), real, team.axes, answers)
