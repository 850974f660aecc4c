"""The state of one robot as diagnostics, stage and controller report it.  No Qt, no ROS."""

import math
import re
from typing import NamedTuple

import numpy as np

from mrs_simulator.sensors.number_texts import degrees, number
from mrs_simulator.state.columns import Z

MOVES = "v and \u03c9: how the robot moves, not what it is commanded"


class StatusRow(NamedTuple):
    """What one source reports of a robot, a row of its panel."""

    name: str
    message: str
    level: str  # good, warning, error or stale
    age: float = math.nan  # [s] of wall time
    tip: str = ""


def parts_of(robot, parts):
    """Return the ``Part``s of ``/diagnostics`` that name the robot with number ``robot``.

    The name is the part's or its hardware's, as in ``robot1/driver`` and ``/robot1/RosAria: battery``.
    """
    name = re.compile(r"(?<![A-Za-z0-9_])robot{}(?![0-9])".format(robot))
    return [part for part in parts if name.search(part.name) or name.search(part.hardware)]


def status_rows(robot, snapshot, stage, control):
    """Return the ``StatusRow``s on motion and control of the robot ``robot``, a number.

    ``snapshot``: the newest ``StateTable``; ``stage``, ``control``: their newest statuses; None for what
    was not received.
    """
    rows = []
    if snapshot is not None and robot in snapshot.robots:
        row = snapshot.robots.index(robot)
        fresh = bool(snapshot.fresh[row])
        motion, level = _motion(snapshot, row), "good" if fresh else "stale"
        rows.append(StatusRow("motion", motion, level, tip="{}\n{}".format(motion, MOVES)))
    if stage is not None and robot in stage.real_silent:
        rows.append(StatusRow("stage", "receives no odometry", "error"))
    elif stage is not None and robot in stage.timed_out:
        rows.append(StatusRow("stage", "receives no command: the robot stands still", "warning"))
    if control is not None:
        rows.append(StatusRow("controller", *_controlled(robot, control)))
    return rows


def _motion(snapshot, row):
    x, y, theta = snapshot.pose[row]
    along, across, turn = snapshot.twist[row]
    texts = [
        "({}, {}) m".format(number(x, 2), number(y, 2)),
        "\u03b8 = {}".format(degrees(math.remainder(theta, 2.0 * math.pi))),
        "v = {}".format(number(along if not across else np.hypot(along, across), 2, " m/s")),
        "\u03c9 = {}".format(number(turn, 2, " rad/s")),
    ]
    if snapshot.has(Z):
        texts.insert(1, "z = {}".format(number(snapshot.z[row], 2, " m")))
    return ", ".join(texts)


def _controlled(robot, control):
    """Return the controller's message on the robot, and its level."""
    if robot in control.stopped:
        return "has stopped the robot: {}".format(control.trouble or "a guard"), "error"
    if robot in control.stale:
        return "has no recent pose", "error"
    if not control.running:
        return control.trouble or "sends no commands", "warning"
    return "sends commands", "good"
