"""Packing and unpacking the package's own messages; no other module knows their fields.

Arrays hold one robot per row.  Messages of the first version, as old bags have them, are read too:
they lack what a planar team of unicycles does not need.

Commands have one column for each component of ``geometry_msgs/Twist`` in ``axes``.  In messages
forward speed and turn rate are always there, any other component only where a robot obeys it.
"""

import json
from typing import NamedTuple, Tuple

import numpy as np
from geometry_msgs.msg import Point, Pose, Pose2D, Quaternion, Vector3

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.core.spatial import upright
from mrs_simulator.msg import (
    Camera,
    Collision,
    ControlScenario,
    ControlStatus,
    Incident,
    RangeBearing,
    RobotSpec,
    StageStatus,
    TeamCommand,
    TeamOdometry,
    TeamState,
)
from mrs_simulator.record.recording import Collision as RunCollision
from mrs_simulator.record.run_changes import CONTROLLER_KEYS, SPEEDS, TOP_SPEEDS
from mrs_simulator.scenario.incidents import DESCRIPTIONS
from mrs_simulator.scenario.incidents import Incident as RunIncident
from mrs_simulator.state.columns import (
    ARM,
    COLUMNS,
    FORCE,
    JOINTS,
    LOAD,
    ORIENTATION,
    OUT_OF_PLANE,
    POSE,
    TWIST,
    LoadState,
    Z,
    always,
    arm_axes,
)
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.state.status import Controller, Stage

__all__ = ["Camera", "Collision", "ControlScenario", "ControlStatus", "Incident"]
__all__ += ["RangeBearing", "StageStatus", "TeamCommand", "TeamOdometry", "TeamState"]

# Fields of commands by component of Twist.
FIELDS = {
    "linear.x": "v",
    "linear.y": "vy",
    "linear.z": "vz",
    "angular.x": "wx",
    "angular.y": "wy",
    "angular.z": "omega",
}


SPATIAL_FIELDS = (*Z.message, *ORIENTATION.message, *OUT_OF_PLANE.message)
MESSAGES = {"orientation": Quaternion, "force": Vector3}  # of which arrays are
_APART = (POSE, TWIST, Z, ORIENTATION, OUT_OF_PLANE, FORCE)  # read by functions of their own
OTHERS = tuple(each for each in COLUMNS.values() if each.message and each not in _APART)


class CameraView(NamedTuple):
    """Where the 3D view looks from."""

    target: Tuple[float, float]  # [m]
    distance: float  # [m]
    yaw: float  # [deg]
    pitch: float  # [deg]
    follow: int  # number of a robot, 0: none
    size: Tuple[int, int]  # [px] width, height


class MessageError(ValueError):
    """A message whose arrays do not fit together; says which."""


def commands_of(command, axes, prefix=""):
    """Return the fields of a message for ``command`` (n, a), by name with ``prefix``."""
    columns = dict(zip(axes, np.asarray(command, dtype=float).T.tolist()))
    n = len(command)
    fields = {axis: columns.get(axis) for axis in FIELDS}
    for axis in UNICYCLE_AXES:
        fields[axis] = [0.0] * n if fields[axis] is None else fields[axis]
    return {prefix + FIELDS[axis]: column for axis, column in fields.items() if column is not None}


def read_commands(message, n, prefix=""):
    """Return axes and commands (n, a) in ``message``; ``MessageError`` where an array is not as long."""
    columns = {axis: _array(message, prefix + name) for axis, name in FIELDS.items()}
    axes = tuple(axis for axis, column in columns.items() if axis in UNICYCLE_AXES or len(column))
    _refuse_lengths({prefix + FIELDS[axis]: columns[axis] for axis in axes}, n)
    return axes, np.array([columns[axis] for axis in axes], dtype=float).reshape(len(axes), n).T


def _arms_of(command, axes):
    """Return the rates of arms in ``command`` (n, a), of whose axes they are the last, as a list."""
    count = sum(axis.startswith(ARM) for axis in axes)
    return np.asarray(command, dtype=float)[:, len(axes) - count :].ravel().tolist()


def _with_arms(axes, command, rates):
    """Return ``axes`` and ``command`` (n, a) with the ``rates`` of arms, as many of each robot."""
    if not len(rates):
        return axes, command
    n = len(command)
    if not n or len(rates) % n:
        text = "{} robots, {} rates of arms; wanted as many of each robot"
        raise MessageError(text.format(n, len(rates)))
    rates = np.array(rates, dtype=float).reshape(n, -1)
    return axes + arm_axes(rates.shape[1]), np.column_stack([command, rates])


def _array(message, name):
    """Return the array ``name``; an empty one where the message's version has none."""
    return getattr(message, name, ())


def team_state(world, stamp, frame, run):
    """Return the ``TeamState`` of ``world``; ``run``: numbers of the stage and of its run."""
    state = world.state()
    message = TeamState(robot=state.robots, kind=state.kinds)
    message.header.stamp, message.header.frame_id = stamp, frame
    message.stage, message.run = run
    _put(message, state)
    for name, column in commands_of(state.command, state.axes, "command_").items():
        setattr(message, name, column)
    message.command_arm = _arms_of(state.command, state.axes)
    if state.has(LOAD):
        message.load = [load_pose(state.load)]
    return message


def run_of(message):
    """Return the numbers of the stage and of its run in a ``TeamState``, 0 where unknown."""
    return getattr(message, "stage", 0), getattr(message, "run", 0)


def load_pose(carried):
    """Return the ``Pose`` of a load that is ``LoadState``."""
    return Pose(Point(*carried.place.tolist()), Quaternion(*carried.orientation.tolist()))


def _read_load(message, n):
    """Return the ``LoadState`` in a ``TeamState``, None without one; ``MessageError``."""
    load, force = _array(message, "load"), _array(message, "force")
    if not len(load):
        return None
    if len(load) != 1 or len(force) != n:
        text = "{} robots, {} loads, {} forces; wanted one load and as many forces as robots"
        raise MessageError(text.format(n, len(load), len(force)))
    at, turn = load[0].position, load[0].orientation
    return LoadState(
        np.array([at.x, at.y, at.z]),
        np.array([turn.x, turn.y, turn.z, turn.w]),
        np.array([(each.x, each.y, each.z) for each in force]),
    )


def _put(message, state):
    """Write the columns of ``state`` that have fields of their own into ``message``."""
    for column in COLUMNS.values():
        if not (column.message and state.has(column)):
            continue
        values = state[column]
        if len(column.message) > 1:
            for name, numbers in zip(column.message, values.T.tolist()):
                setattr(message, name, numbers)
            continue
        (name,) = column.message
        kind = MESSAGES.get(name)
        rows = values.ravel().tolist() if kind is None else [kind(*row) for row in values.tolist()]
        setattr(message, name, rows)


def read_spatial(message, theta):
    """Return the ``Spatial`` in a ``TeamState`` or ``TeamOdometry``, None if all is planar.

    ``theta`` (n,) [rad]: headings of robots without an orientation.  Raises ``MessageError``
    where an array is not as long as the others.
    """
    columns = {name: _array(message, name) for name in SPATIAL_FIELDS}
    given = {name: column for name, column in columns.items() if len(column)}
    if not given:
        return None
    result = upright(theta)
    _refuse_lengths(given, len(theta))
    result.z[:] = given.get("z", 0.0)
    if "orientation" in given:
        result.orientation[:] = [(q.x, q.y, q.z, q.w) for q in given["orientation"]]
    for column, name in enumerate(SPATIAL_FIELDS[2:]):
        result.twist[:, column] = given.get(name, 0.0)
    return result


def read_planar(message):
    """Return poses and body twists, (n, 3) each, of a ``TeamState`` or ``TeamOdometry``.

    Raises ``MessageError`` where an array is not as long as the others.
    """
    n = len(message.robot)
    columns = {name: getattr(message, name) for name in (*POSE.message, *TWIST.message)}
    _refuse_lengths(columns, n)
    table = np.array([*columns.values()], dtype=float).reshape(6, n).T
    return table[:, :3], table[:, 3:]


def read_state(message):
    """Return the ``StateTable`` in a ``TeamState``; ``MessageError`` where its arrays do not fit.

    Robots of which there are no joints have one at 0.
    """
    n, kinds = len(message.robot), tuple(_array(message, "kind"))
    pose, twist = read_planar(message)
    axes, command = read_commands(message, n, "command_")
    axes, command = _with_arms(axes, command, _array(message, "command_arm"))
    columns = {column.name: _read(message, column, n) for column in OTHERS}
    columns["joints"] = np.zeros(n) if columns["joints"] is None else columns["joints"]
    return StateTable(
        message.header.stamp.to_sec(),
        tuple(message.robot),
        kinds if len(kinds) == n else (),
        axes,
        pose=pose,
        twist=twist,
        command=command,
        spatial=read_spatial(message, pose[:, 2]),
        load=_read_load(message, n),
        **columns,
    )


def _read(message, column, n):
    """Return the ``column`` of n robots, None where the ``message`` has nothing of it.

    One of each team is only missing in messages of versions without it.
    """
    fields = {name: _array(message, name) for name in column.message}
    is_old = not hasattr(message, column.message[0])
    if not any(map(len, fields.values())) and (is_old or column.of is not always):
        return None
    if column is JOINTS:
        joints = _joints(message.joint, n)
        return joints[:, 0] if joints.shape[1] == 1 else joints
    _refuse_lengths(fields, n)
    table = np.array([*fields.values()], dtype=column.kind)
    return table[0] if len(table) == 1 else table.T


def _refuse_lengths(fields, n):
    """Raise ``MessageError`` where one of ``fields``, arrays by name, is not of n robots."""
    for name, values in fields.items():
        if len(values) != n:
            text = "{} robots, {} {}; wanted as many of each"
            raise MessageError(text.format(n, len(values), name))


def _joints(joints, n):
    """Return the joints (n, k) of a message, k of each robot."""
    if not n or len(joints) % n:
        text = "{} robots, {} joint; wanted as many of each robot"
        raise MessageError(text.format(n, len(joints)))
    return np.array(joints, dtype=float).reshape(n, -1)


def is_commanded(message):
    """Return whether a ``TeamState`` has a command that is not zero, without taking it apart."""
    return any(np.any(_array(message, "command_" + name)) for name in FIELDS.values())


def read_odometry(message):
    """Return the robots' numbers, poses, body twists, (n, 3) each, and ``Spatial`` of a ``TeamOdometry``.

    The last is None where all is planar.  Raises ``MessageError`` where its arrays do not fit.
    """
    pose, twist = read_planar(message)
    return message.robot, pose, twist, read_spatial(message, pose[:, 2])


def team_odometry(numbers, pose, twist=None, stamp=None, spatial=None, joints=None):
    """Return the ``TeamOdometry`` of the robots ``numbers`` at ``pose`` (n, 3), with ``twist`` (n, 3).

    ``spatial``: their ``Spatial``, None for robots on the ground; ``joints`` (n, k) [rad] of robots with
    arms, else None.
    """
    message = TeamOdometry(robot=list(numbers))
    if stamp is not None:
        message.header.stamp = stamp
    twist = np.zeros_like(pose) if twist is None else twist
    _put(message, StateTable(pose=pose, twist=twist, spatial=spatial, joints=joints))
    return message


def team_command(numbers, command, axes=UNICYCLE_AXES, answered=None):
    """Return the ``TeamCommand`` of the robots ``numbers``: ``command`` (n, a).

    ``answered`` (n,) [s]: the stamp of the odometry that each command answers, None for no odometry.
    """
    arm = _arms_of(command, axes)
    stamps = [] if answered is None else np.asarray(answered, dtype=float).tolist()
    stamps = stamps[:1] if len(set(stamps)) == 1 else stamps
    return TeamCommand(robot=list(numbers), arm=arm, odometry=stamps, **commands_of(command, axes))


def read_team_command(message):
    """Return the robots' numbers, the axes and the commands (n, a) in a ``TeamCommand``.

    Raises ``MessageError`` where its arrays do not fit, or a robot's number is 0.
    """
    if 0 in message.robot:
        raise MessageError("robot 0, wanted robots numbered from 1")
    axes, command = read_commands(message, len(message.robot))
    return (message.robot, *_with_arms(axes, command, message.arm))


def read_answered(message):
    """Return the stamp of the odometry that each command of a ``TeamCommand`` answers, (n,) [s].

    NaN where unknown; ``MessageError`` where there are neither as many as robots nor one for all.
    """
    n, stamps = len(message.robot), np.array(_array(message, "odometry"), dtype=float)
    if len(stamps) not in (0, 1, n):
        raise MessageError(
            "{} robots, {} odometry; wanted as many of each, one or none".format(n, len(stamps))
        )
    return np.broadcast_to(stamps if len(stamps) else np.nan, n)


def read_joints(message):
    """Return the joints (n, k) [rad] in a ``TeamOdometry``, None where it has none."""
    return _joints(message.joint, len(message.robot)) if len(message.joint) else None


def stage_status(stamp, round_trips, **facts):
    """Return the ``StageStatus`` of ``facts``, other fields by name; ``round_trips``: median and 99 %."""
    median, p99 = round_trips
    message = StageStatus(round_trip_median=median, round_trip_p99=p99, **facts)
    message.header.stamp = stamp
    return message


def read_stage_status(message):
    """Return the ``Stage`` in a ``StageStatus``."""
    # Bags of earlier versions do not count the periods.
    values = {name: getattr(message, name, 0) for name in Stage._fields[1:]}
    values["real_silent"] = tuple(message.real_silent)
    for name in ("flight", "timed_out"):
        values[name] = tuple(getattr(message, name, ()))
    return Stage(stamp=message.header.stamp.to_sec(), **values)


def control_status(command, axes, edges, targets, **facts):
    """Return the ``ControlStatus`` of commands (n, a), edges (i, j, weight), targets and ``facts``.

    ``targets`` (n, 2) or, in space, (n, 3) [m], None for nowhere; ``facts``: other fields by name.
    """
    hears, heard, weight = zip(*edges) if edges else ((), (), ())
    message = ControlStatus(hears=hears, heard=heard, weight=weight, **facts)
    for name, column in commands_of(command, axes, "command_").items():
        setattr(message, name, column)
    if targets is not None:
        columns = np.asarray(targets, dtype=float).T.tolist()
        message.target_x, message.target_y = columns[:2]
        message.target_z = columns[2] if len(columns) > 2 else []
    return message


def read_control_status(message):
    """Return the ``Controller`` in a ``ControlStatus``; ``MessageError`` where arrays do not fit."""
    axes, command = read_commands(message, len(message.command_v), "command_")
    return Controller(
        stamp=message.header.stamp.to_sec(),
        protocol=message.protocol,
        period=message.period,
        running=message.running,
        trouble=message.trouble,
        stale=tuple(message.stale),
        stopped=tuple(message.stopped),
        axes=axes,
        command=command,
        edges=tuple(zip(message.hears, message.heard, message.weight)),
        directed=message.directed,
        targets=_targets(message),
        warnings=tuple(message.warnings),
    )


def control_scenario(obeyed):
    """Return the ``ControlScenario`` of ``obeyed``, plain values by ``CONTROLLER_KEYS``, ``TOP_SPEEDS``."""
    return ControlScenario(obeyed=json.dumps(obeyed, default=float))


def read_control_scenario(message):
    """Return the stamp [s] of a ``ControlScenario`` and what is obeyed, plain values by keys.

    Raises ``MessageError`` for anything else.
    """
    known = *CONTROLLER_KEYS, TOP_SPEEDS
    try:
        obeyed = json.loads(message.obeyed)
        unknown = set(obeyed).difference(known)
    except (ValueError, TypeError, RecursionError) as error:
        raise MessageError("obeyed: no JSON of a scenario's keys: {}".format(error)) from None
    if unknown or not isinstance(obeyed, dict):
        text = "obeyed: {:.60}, wanted a mapping of {}"
        raise MessageError(text.format(repr(obeyed), ", ".join(known)))
    _check_speeds(obeyed.get(TOP_SPEEDS, {}))
    return message.header.stamp.to_sec(), obeyed


def _check_speeds(speeds):
    """Raise ``MessageError`` unless ``speeds`` are of ``SPEEDS``, none of them below 0."""
    named = isinstance(speeds, dict) and set(speeds) <= set(SPEEDS)
    if not named or not all(type(each) is float and each >= 0.0 for each in speeds.values()):
        text = "obeyed: {}: {:.60}, wanted numbers of at least 0 for {}"
        raise MessageError(text.format(TOP_SPEEDS, repr(speeds), ", ".join(SPEEDS)))


def _targets(message):
    """Return the targets of a ``ControlStatus``, (n, 2) or (n, 3) [m]."""
    height = _array(message, "target_z")
    columns = [message.target_x, message.target_y] + ([height] if len(height) else [])
    if len({len(column) for column in columns}) > 1:
        raise MessageError(
            "{} target_x, {}; wanted as many of each".format(
                len(message.target_x),
                ", ".join(
                    "{} target_{}".format(len(column), axis)
                    for axis, column in zip("yz", columns[1:])
                ),
            )
        )
    return np.array(columns, dtype=float).T.reshape(-1, len(columns))


def collision_message(collision, stamp, frame):
    """Return the message of a ``recording.Collision``."""
    first, second, x, y, z = collision[1:]
    message = Collision(first=first, second=second, x=x, y=y, z=z)
    message.header.stamp, message.header.frame_id = stamp, frame
    return message


def read_collision(message):
    """Return the ``recording.Collision`` in ``message``, its time that of the stamp [s]."""
    stamp = message.header.stamp.to_sec()
    place = message.x, message.y, getattr(message, "z", 0.0)
    return RunCollision(stamp, message.first, message.second, *place)


def range_bearing(header, numbers, ranges, bearings):
    """Return the ``RangeBearing`` of the robots ``numbers``, ``ranges`` [m] and ``bearings`` [rad] away."""
    return RangeBearing(header, numbers.tolist(), ranges.tolist(), bearings.tolist())


def read_range_bearing(message):
    """Return numbers, ranges [m] and bearings [rad], (K,) each; ``MessageError`` where they do not fit."""
    columns = message.robot, message.range, message.bearing
    if len({*map(len, columns)}) > 1:
        text = "{} robots, {} ranges, {} bearings; wanted as many of each"
        raise MessageError(text.format(*map(len, columns)))
    return tuple(np.array(each, dtype=kind) for each, kind in zip(columns, (int, float, float)))


def incident_message(incident, stamp):
    """Return the message of a ``incidents.Incident``."""
    message = Incident(**dict(zip(("robot", "what", "rotor", "ordered"), incident[1:])))
    message.header.stamp = stamp
    return message


def read_incident(message):
    """Return the ``incidents.Incident`` in ``message``, its time that of the stamp [s].

    Raises ``MessageError`` for one that is not known.
    """
    if message.what not in DESCRIPTIONS:
        raise MessageError(
            "incident {!r}, wanted one of {}".format(message.what, ", ".join(DESCRIPTIONS))
        )
    stamp = message.header.stamp.to_sec()
    return RunIncident(stamp, message.robot, message.what, message.rotor, message.ordered)


def read_camera_view(message):
    """Return the ``CameraView`` in a ``Camera``."""
    return CameraView(
        (message.x, message.y),
        message.distance,
        message.yaw,
        message.pitch,
        message.follow,
        (message.width, message.height),
    )


def robot_specs(kinds, poses, z=None):
    """Return each robot's ``RobotSpec``: its kind's name, pose (n, 3), height ``z`` (n,) [m], else 0."""
    heights = np.zeros(len(poses)) if z is None else z
    return [
        RobotSpec(kind=kind, pose=Pose2D(*map(float, pose)), z=float(height))
        for kind, pose, height in zip(kinds, poses, heights)
    ]


def read_robot_specs(robots, default):
    """Return kinds, poses [x, y, theta] and heights of ``RobotSpec``s; an empty kind is ``default``."""
    kinds = [robot.kind or default for robot in robots]
    poses = [[robot.pose.x, robot.pose.y, robot.pose.theta] for robot in robots]
    return kinds, poses, [robot.z for robot in robots]
