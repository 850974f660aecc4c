"""What is told of one robot: on ``/diagnostics``, by stage and controller.  No Qt, no ROS."""

import math
import re
from typing import NamedTuple

import numpy as np

from mrs_simulator.rqt_plugin.sensing.texts import degrees, number


class Told(NamedTuple):
    """What is told of a robot by one part of a program, as a row of its panel."""

    name: str
    message: str
    level: str  # good, warning, error or stale
    age: float = math.nan  # [s] of wall time
    tip: str = ""


def parts_of(robot, parts):
    """Return those ``Part``s of ``/diagnostics`` that name the robot of the number ``robot``.

    By their name or their hardware's, as ``robot1/driver`` and ``/robot1/RosAria: battery`` do.
    """
    name = re.compile(r"(?<![A-Za-z0-9_])robot{}(?![0-9])".format(robot))
    return [part for part in parts if name.search(part.name) or name.search(part.hardware)]


def told_of(robot, snapshot, stage, control):
    """Return the ``Told`` of motion and control of the robot of the number ``robot``.

    ``snapshot``: the newest ``Snapshot``; ``stage``, ``control``: what they say of themselves; None for
    what is not heard.
    """
    rows = []
    if snapshot is not None and robot in snapshot.numbers:
        row = snapshot.numbers.index(robot)
        fresh = bool(snapshot.fresh[row])
        rows.append(Told("motion", _motion(snapshot, row), "good" if fresh else "stale"))
    if stage is not None and robot in stage.real_silent:
        rows.append(Told("stage", "receives no odometry", "error"))
    elif stage is not None and robot in stage.timed_out:
        rows.append(Told("stage", "receives no command: the robot stands still", "warning"))
    if control is not None:
        rows.append(Told("controller", *_controlled(robot, control)))
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
    if snapshot.spatial is not None:
        texts.insert(1, "z = {}".format(number(snapshot.spatial.z[row], 2, " m")))
    return ", ".join(texts)


def _controlled(robot, control):
    """Return in words what the controller does with the robot, and the level of that."""
    if robot in control.stopped:
        return "has stopped the robot: {}".format(control.trouble or "a guard"), "error"
    if robot in control.stale:
        return "has no recent pose", "error"
    if not control.running:
        return control.trouble or "sends no commands", "warning"
    return "sends commands", "good"
