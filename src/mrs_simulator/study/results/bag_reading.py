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
from mrs_simulator.core.spatial import Spatial, upright
from mrs_simulator.record.controller_log import Interruptions
from mrs_simulator.record.missed_periods import MissedPeriods
from mrs_simulator.record.recording import Run, RunError
from mrs_simulator.record.run_changes import ControllerRecord, changed_by
from mrs_simulator.ros.message_forms.messages import (
    read_collision,
    read_control_scenario,
    read_incident,
    read_odometry,
    read_stage_status,
    read_state,
    run_of,
)
from mrs_simulator.scenario.reading import reason, refuse_special
from mrs_simulator.scenario.scenario import MOST_ROBOTS, ScenarioError, scenario_from_yaml
from mrs_simulator.scenario.surroundings.moving_obstacles import scene_facts, scene_time
from mrs_simulator.state.columns import ESTIMATE, SPATIAL, Z
from mrs_simulator.state.state_table import StateTable, stacked
from mrs_simulator.study.run.applied_scenario import what_ran
from mrs_simulator.vehicles.arms.team import ArmedTeam, has_arms
from mrs_simulator.vehicles.portable import team_from_message
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.verdict.estimation import UNKNOWN, held_at

# As the stage has them, and as RosAria and p2os drivers in namespaces do.
ODOMETRY = re.compile(r"^/robot(\d+)/(?:odom|pose|RosAria/pose|RosAria/odom)$")
COMMANDS = re.compile(r"^/robot(\d+)/(?:RosAria/)?cmd_vel$")
JITTER = 0.3  # [-] of a period, by which real robots' odometry may be early
# What drivers of robots on the ground say of height and tilt is rounding, or where the axle is.
LEVEL, UPRIGHT = 1e-3, 1e-3  # [m] of rising, [-] of a quaternion's x and y
STATE, COLLISIONS, SCENARIO = "/stage/state", "/stage/collisions", "/stage/scenario"
ESTIMATES, OBEYED = "/pioneer_control/estimates", "/pioneer_control/scenario"
STATUS, INCIDENTS = "/stage/status", "/stage/incidents"
CONTROLLER = "/pioneer_control/status"
NO_SAMPLE = "{}: holds no sample in which a robot is commanded"


def read_bag(path, scenario=None):
    """Return the ``Run`` in the bag at ``path``, from the controller's first command on.

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
            if reader is _from_robots and team is not None and team.has_arms:
                raise ScenarioError("robots with arms: wanted a bag with {}".format(STATE))
            taken = reader(bag, topics, team.axes if team else UNICYCLE_AXES)
            if taken is None:
                raise RunError(NO_SAMPLE.format(path))
            if reader is _from_robots:
                taken = taken.replace(pose=_in_common_frame(taken.pose, scenario))
            estimates, facts = _estimates_in(bag), {}
            if estimates is not None:
                taken = _with_estimates(taken, *estimates)
            if taken.has(ESTIMATE) and reader is _from_robots:
                facts = {"truth_unknown": True, "warnings": [UNKNOWN]}
                taken = taken.replace(pose=taken.estimate)
            collisions = _collisions(bag)
            unknown = reader is _from_robots and COLLISIONS not in topics
            incidents = [read_incident(each) for _, each, _ in bag.read_messages([INCIDENTS])]
            degraded = _degraded(bag, topics, taken.time)
            controller, stops = _controller_in(bag)
    except RunError:
        raise
    except ScenarioError as error:
        raise RunError("{}: cannot be read: {}".format(path, error)) from None
    except Exception as error:  # rosbag and genpy raise whatever a damaged file leads them to
        text = "{}: cannot be read: {}: {}".format(path, type(error).__name__, reason(error)[:200])
        raise RunError(text) from None
    _refuse_impossible(path, taken)
    slack = JITTER if reader is _from_robots else 0.0
    keep = _recorded(taken.time, scenario, slack)
    kept, start = taken.at(keep), taken.time[0]
    ended = stops.emergency(start, kept.time[-1])
    meta = dict(_meta(kept.command, unknown, degraded, ended), **facts)
    if scenario is not None:
        scenario = _obeyed_in(path, scenario, controller, kept.time, meta)
    if scenario is not None and reader is _from_states:
        meta.update(scene_facts(scenario.obstacles, scene_time(start)))
    incidents = _since(start, incidents)
    if incidents:
        meta["incidents"] = incidents
    kept = _with_points(team, kept, scenario.hand_length if scenario else DEFAULT_HAND_LENGTH)
    kept = kept.replace(time=np.round(kept.time - start, 9), robots=np.array(kept.robots))
    collisions = _since(start, collisions)
    return Run(**vars(kept), collisions=collisions, scenario=scenario, meta=meta)


def _since(start, events):
    """Return the ``events`` from ``start`` [s] on, timed from there."""
    return [each._replace(time=each.time - start) for each in events if each.time >= start]


def _meta(command, collisions_unknown, degraded, ended):
    """Return what else is known of the run; zeros are what a controller says that never began."""
    facts = {
        "collisions_unknown": collisions_unknown,
        "uncommanded": not command.any(),
        "degraded": degraded,
        "ended": ended,
    }
    return {name: fact for name, fact in facts.items() if fact}


def _degraded(bag, topics, time):
    """Return a text where the timing between the ends of ``time`` (m,) was degraded, else ""."""
    missed = MissedPeriods()
    # Bags of earlier versions have no status, or one that does not count the periods.
    if len(time) and STATUS in topics:
        for _, message, _ in bag.read_messages([STATUS]):
            stage = read_stage_status(message)
            if time[0] <= stage.stamp <= time[-1]:
                missed.note(stage.stamp, stage.robots, stage.missed_periods, stage.command_periods)
    return missed.text()


def _controller_in(bag):
    """Return the ``ControllerRecord`` of the bag, and its ``Interruptions``."""
    controller, stops = ControllerRecord(), Interruptions()
    for _, message, _ in bag.read_messages([OBEYED]):
        controller.note(*read_control_scenario(message))
    for _, message, _ in bag.read_messages([CONTROLLER]):
        stops.note(message.header.stamp.to_sec(), message.running, message.trouble)
    return controller, stops


def _obeyed_in(path, scenario, controller, time, meta):
    """Return ``scenario`` as the ``controller`` obeyed it; its changes go into ``meta``."""
    obeyed, changes = controller.during(time[0], time[-1])
    try:
        ran, unknown = what_ran(scenario, obeyed=obeyed)
        changed_by(ran, changes)
    except ValueError as error:
        raise RunError("{}: {}: {}".format(path, OBEYED, error)) from None
    meta.update({"changes": changes} if changes else {})
    meta.update({"unknown_law": unknown} if unknown else {})
    return ran


def _estimates_in(bag):
    """Return the times (k,) [s] of the control's estimates, and these (k, n, 3); None without any."""
    reported = [
        (m.header.stamp.to_sec(), read_odometry(m)[1]) for _, m, _ in bag.read_messages([ESTIMATES])
    ]
    alike = [each for each in reported if each[1].shape == reported[0][1].shape]
    return tuple(map(np.array, zip(*alike))) if reported else None


def _with_estimates(taken, stamps, poses):
    """Return the samples of which estimates are known, with the newest of then."""
    if poses.shape[1] != taken.pose.shape[1]:
        return taken
    newest = held_at(stamps, taken.time)
    known = np.flatnonzero(newest >= 0)
    return taken.at(known).replace(estimate=poses[newest[known]])


def _refuse_impossible(path, taken):
    found = taken.first_infinite()
    if found is not None:
        text = "{}: at {:.3f} s a {} is not finite"
        raise RunError(text.format(path, taken.time[found[1]], found[0]))
    robots = taken.robots
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
    if scenario.path:
        return team_of(scenario)
    try:
        team = team_from_message(scenario)
        return ArmedTeam(team.kinds) if has_arms(team.kinds) else team
    except ScenarioError as error:
        text = "{}: {}: wanted the scenario's file, by --scenario"
        raise ScenarioError(text.format(SCENARIO, error)) from None


def _with_points(team, state, l):
    """Return the ``state`` at m times as it is recorded, with controlled points.

    Without a team they are hand points.
    """
    if team is not None and team.n == state.pose.shape[1] and team.has_joints:
        return stacked([team.recorded(state.at(row), l) for row in range(len(state.time))])
    is_known = team is not None and team.n == state.pose.shape[1]
    hand = team.point(state.pose, 0.0, l) if is_known else hand_points(state.pose, l)
    point_z = state.z if state.has(Z) else None
    return state.replace(hand=hand, point_z=point_z, joints=None)


def _from_states(bag, _topics, axes):
    """Return the state at m times that a stage published, None where there is none."""
    states, run = [], None
    for _, message, _ in bag.read_messages([STATE]):
        state = read_state(message)
        if not states and not state.commanded.any():
            continue
        if states and (state.robots, run_of(message)) != (states[0].robots, run):
            break  # another team, a reset, another stage: another run
        run = run_of(message)
        command = on_axes(state.command, state.axes, axes) if state.axes != axes else state.command
        states.append(state.replace(axes=axes, command=command, commanded=None))
    if any(state.has(SPATIAL) for state in states):
        states = [_in_space(state) for state in states]
    return stacked(states) if states else None


def _in_space(state):
    return state if state.has(SPATIAL) else state.replace(spatial=upright(state.pose[:, 2]))


def _from_robots(bag, topics, axes):
    """Read the robots' own topics; the time base is the odometry of the first robot."""
    odometry = {t: int(m.group(1)) for t, m in ((t, ODOMETRY.match(t)) for t in topics) if m}
    commands = {t: int(m.group(1)) for t, m in ((t, COMMANDS.match(t)) for t in topics) if m}
    robots = sorted(set(odometry.values()))
    command = slice(len(FIELDS), None)  # of a row
    parts = [axis.split(".") for axis in axes]
    blank = [math.nan] * len(FIELDS) + [0.0] * len(axes)
    newest, commanded, rows, times = {n: list(blank) for n in robots}, False, [], []
    runs = True  # the controller; bags without its status begin with any command
    for topic, message, _ in bag.read_messages([*odometry, *commands, CONTROLLER]):
        if topic == CONTROLLER:
            runs = message.running
            continue
        if topic in commands:
            if commands[topic] in newest:
                given = [getattr(getattr(message, part), x) for part, x in parts]
                newest[commands[topic]][command] = np.nan_to_num(given).tolist()
                # A node that has not begun or is stopped commands zeros too.
                commanded = commanded or runs and any(given)
            continue
        newest[odometry[topic]][: len(FIELDS)] = _odometry_row(message)
        if commanded and odometry[topic] == robots[0]:
            table = np.array([newest[n] for n in robots])
            if np.isfinite(table[:, :3]).all():
                rows.append(table)
                times.append(message.header.stamp.to_sec())
    if not rows:
        return None
    table = np.array(rows)
    return StateTable(
        np.array(times),
        robots,
        axes=axes,
        pose=table[:, :, :3],
        command=table[:, :, command],
        twist=_finite(table[:, :, 3:6]),
        real=np.full(table.shape[:2], True),
        joints=np.zeros(table.shape[:2]),
        spatial=_spatial_of(_finite(table[:, :, 6 : len(FIELDS)])),
    )


def _finite(table):
    """Return ``table``, None where a driver does not report all of it: the poses are enough."""
    return table if np.isfinite(table).all() else None


# What is read of an odometry message.
FIELDS = ("x", "y", "theta", "vx", "vy", "omega", "z", "qx", "qy", "qz", "qw", "vz", "wx", "wy")


def _odometry_row(message):
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    quaternion = turn.x, turn.y, turn.z, turn.w
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    planar = place.x, place.y, yaw(*quaternion), linear.x, linear.y, angular.z
    return planar + (place.z, *quaternion, linear.z, angular.x, angular.y)


def _spatial_of(odometry):
    """Return the ``Spatial`` of the ``odometry`` (m, n, 8) of robots; None if all of it is planar."""
    if odometry is None:
        return None
    spatial = Spatial(odometry[:, :, 0], odometry[:, :, 1:5], odometry[:, :, 5:])
    tilted = np.abs(spatial.orientation[:, :, :2]).max(initial=0.0) > UPRIGHT
    if tilted or np.ptp(spatial.z, axis=0).max(initial=0.0) > LEVEL:
        return spatial
    return None


def _in_common_frame(pose, scenario):
    """Return ``pose`` (m, n, 3) of odometry that starts at zero where the scenario puts the robots."""
    if scenario is None or scenario.odometry != "wheel" or pose.shape[1] != scenario.n:
        return pose
    return np.array([compose(scenario.poses, sample) for sample in pose])


def _collisions(bag):
    return [read_collision(message) for _, message, _ in bag.read_messages([COLLISIONS])]


def _recorded(time, scenario, slack):
    """Return the indices of the samples that a run of ``scenario``, None for unknown, records."""
    if scenario is None:
        return np.arange(len(time))
    keep = _every(time, scenario.record_rate, slack)
    # A bag may have run on while the results were written.
    late = slack / scenario.record_rate + 1e-6
    return keep[time[keep] - time[0] <= scenario.duration + late]


def _every(time, rate, slack=0.0):
    """Return the indices of samples at least 1/rate [s] apart.

    ``slack`` [-]: part of 1/rate by which one may be early.
    """
    keep, following = [], -math.inf
    for index, stamp in enumerate(time):
        if stamp >= following - 1e-6:
            keep.append(index)
            following = stamp + (1.0 - slack) / rate
    return np.array(keep)
