"""Reads a run from a rosbag: the stage's states, or odometry and commands of real robots."""

import math
import re

import numpy as np

from mrs_simulator.core.kinematics import (
    DEFAULT_HAND_LENGTH,
    UNICYCLE_AXES,
    compose,
    hand_points,
    yaw,
)
from mrs_simulator.core.missed_periods import MissedPeriods
from mrs_simulator.core.parameters import shown
from mrs_simulator.core.reading import reason, refuse_special
from mrs_simulator.core.recording import Run, RunError
from mrs_simulator.core.scenario import (
    MOST_ROBOTS,
    ScenarioError,
    scenario_from_yaml,
)
from mrs_simulator.ros.messages import read_collision, read_stage_status, read_state
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.registry import file_named
from mrs_simulator.vehicles.team import on_axes

# As the stage has them, and as RosAria and p2os drivers in namespaces do.
ODOMETRY = re.compile(r"^/robot(\d+)/(?:odom|pose|RosAria/pose|RosAria/odom)$")
COMMANDS = re.compile(r"^/robot(\d+)/(?:RosAria/)?cmd_vel$")
JITTER = 0.3  # [-] of a period, by which real robots' odometry may be early
STATE, COLLISIONS, SCENARIO = "/stage/state", "/stage/collisions", "/stage/scenario"
STATUS = "/stage/status"


def read_bag(path, scenario=None):
    """Return the ``Run`` in the bag at ``path``, from the first command on.

    The states of ``/stage/state`` are used, else ``/robotN/odom`` and ``/robotN/cmd_vel`` (on real
    robots): the newest of each at every odometry of the first robot.  ``scenario`` is needed for
    what a bag does not say; by default the bag's own, which is read as data only.  Raises
    ``RunError``.
    """
    import rosbag  # ROS only where a bag is read

    try:
        refuse_special(path)
        with rosbag.Bag(path) as bag:
            topics = bag.get_type_and_topic_info().topics
            scenario = scenario or _scenario_in(bag)
            team = _team_of(scenario)
            reader = _from_states if STATE in topics else _from_robots
            taken = reader(bag, topics, team.axes if team else UNICYCLE_AXES)
            time, robots, pose, command, joints = taken
            if reader is _from_robots:
                pose = _in_common_frame(pose, scenario)
            collisions = _collisions(bag)
            unknown = reader is _from_robots and COLLISIONS not in topics
            degraded = _degraded(bag, topics, time)
    except ScenarioError as error:
        raise RunError("{}: cannot be read: {}".format(path, error)) from None
    except Exception as error:  # rosbag and genpy raise whatever a damaged file leads them to
        text = "{}: cannot be read: {}: {}".format(path, type(error).__name__, reason(error)[:200])
        raise RunError(text) from None
    if not len(time):
        raise RunError("{}: holds no sample in which a robot is commanded".format(path))
    _refuse_impossible(path, time, robots, pose, command)
    slack = JITTER if reader is _from_robots else 0.0
    keep = _every(time, scenario.record_rate if scenario else None, slack)
    if scenario is not None:  # a bag may have run on while the results were written
        late = slack / scenario.record_rate + 1e-6
        keep = keep[time[keep] - time[0] <= scenario.duration + late]
    start, l = time[0], scenario.hand_length if scenario else DEFAULT_HAND_LENGTH
    return Run(
        time=np.round(time[keep] - start, 9),
        robots=np.array(robots),
        pose=pose[keep],
        hand=_points(team, pose[keep], joints[keep], l),
        command=command[keep],
        collisions=[c._replace(time=c.time - start) for c in collisions if c.time >= start],
        scenario=scenario,
        meta=_meta(command[keep], unknown, degraded),
        axes=team.axes if team else UNICYCLE_AXES,
    )


def _meta(command, collisions_unknown, degraded):
    """Return what else is known of the run; zeros are what a controller says that never began."""
    facts = {
        "collisions_unknown": collisions_unknown,
        "uncommanded": not command.any(),
        "degraded": degraded,
    }
    return {name: fact for name, fact in facts.items() if fact}


def _degraded(bag, topics, time):
    """Return that the timing between the first and the last of ``time`` (m,) was degraded, or ""."""
    missed = MissedPeriods()
    # Bags of earlier versions have no status, or one that does not count the periods.
    if len(time) and STATUS in topics:
        for _, message, _ in bag.read_messages([STATUS]):
            stage = read_stage_status(message)
            if time[0] <= stage.stamp <= time[-1]:
                missed.note(stage.stamp, stage.robots, stage.missed_periods, stage.command_periods)
    return missed.text()


def _refuse_impossible(path, time, robots, pose, command):
    bad = np.flatnonzero(~np.isfinite(np.concatenate([pose, command], axis=2)).all(axis=(1, 2)))
    if len(bad):
        text = "{}: at {:.3f} s a pose or command is not finite"
        raise RunError(text.format(path, time[bad[0]]))
    if len(set(robots)) != len(robots) or not all(1 <= number <= MOST_ROBOTS for number in robots):
        raise RunError("{}: robots {}, wanted each number once".format(path, robots[:10]))


def _scenario_in(bag):
    for _, message, _ in bag.read_messages([SCENARIO]):
        return scenario_from_yaml(message.data, SCENARIO)
    return None


def _team_of(scenario):
    """Return the ``Team`` of ``scenario``, None without one.

    A scenario that came in a bag may have come from anybody: no file that it names is opened.
    """
    if scenario is None:
        return None
    named = "" if scenario.path else file_named(scenario)
    if named:
        raise ScenarioError(
            "{}: {}: wanted the scenario's file, by --scenario".format(SCENARIO, shown(named))
        )
    return Team.from_scenario(scenario)


def _points(team, pose, joints, l):
    """Return the controlled points (m, n, 2) [m]; without a team hand points."""
    if team is None or team.n != pose.shape[1]:
        return hand_points(pose, l)
    if not team.has_joints:
        return team.point(pose, joints[0] if len(joints) else joints, l)
    return np.array([team.point(*sample, l) for sample in zip(pose, joints)])


def _from_states(bag, _topics, axes):
    rows, robots, part = [], None, None
    for _, message, _ in bag.read_messages([STATE]):
        state = read_state(message)
        if not rows and not state.commanded.any():
            continue
        robots = robots or list(state.robots)
        part = part or state.part
        if list(state.robots) != robots or state.part != part:
            break  # another team, a reset, another stage: another run
        command = on_axes(state.command, state.axes, axes)
        table = np.concatenate([state.pose, state.joints[:, np.newaxis], command], axis=1)
        rows.append((state.stamp, table))
    return _tables(rows, robots, axes)


def _from_robots(bag, topics, axes):
    """Read the robots' own topics; the time base is the odometry of the first robot."""
    odometry = {t: int(m.group(1)) for t, m in ((t, ODOMETRY.match(t)) for t in topics) if m}
    commands = {t: int(m.group(1)) for t, m in ((t, COMMANDS.match(t)) for t in topics) if m}
    robots = sorted(set(odometry.values()))
    blank = [math.nan] * 3 + [0.0] + [math.nan] * len(axes)
    newest, commanded, rows = {n: list(blank) for n in robots}, False, []
    for topic, message, _ in bag.read_messages(list(odometry) + list(commands)):
        if topic in commands:
            if commands[topic] in newest:
                given = [getattr(getattr(message, part), x) for part, x in map(_split, axes)]
                newest[commands[topic]][4:] = given
                # Zeros are also what a node says that has not begun or is stopped.
                commanded = commanded or any(given)
            continue
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        newest[odometry[topic]][:3] = position.x, position.y, yaw(turn.x, turn.y, turn.z, turn.w)
        if commanded and odometry[topic] == robots[0]:
            table = np.array([newest[n] for n in robots])
            table[:, 4:] = np.nan_to_num(table[:, 4:])
            if np.isfinite(table).all():
                rows.append((message.header.stamp.to_sec(), table))
    return _tables(rows, robots, axes)


def _split(axis):
    return axis.split(".")


def _in_common_frame(pose, scenario):
    """Return ``pose`` (m, n, 3) of odometry that starts at zero where the scenario puts the robots."""
    if scenario is None or scenario.odometry != "wheel" or pose.shape[1] != scenario.n:
        return pose
    return np.array([compose(scenario.poses, sample) for sample in pose])


def _tables(rows, robots, axes):
    """Return times (m,), robots, poses (m, n, 3), commands (m, n, a) and joints (m, n)."""
    time, width = np.array([stamp for stamp, _ in rows]), 4 + len(axes)
    table = np.array([values for _, values in rows]).reshape(len(rows), len(robots or ()), width)
    return time, robots, table[:, :, :3], table[:, :, 4:], table[:, :, 3]


def _collisions(bag):
    return [read_collision(message) for _, message, _ in bag.read_messages([COLLISIONS])]


def _every(time, rate, slack=0.0):
    """Return the indices of samples at least 1/rate [s] apart; all if ``rate`` is None.

    ``slack`` [-]: part of 1/rate by which one may be early.
    """
    if rate is None:
        return np.arange(len(time))
    keep, following = [], -math.inf
    for index, stamp in enumerate(time):
        if stamp >= following - 1e-6:
            keep.append(index)
            following = stamp + (1.0 - slack) / rate
    return np.array(keep)
