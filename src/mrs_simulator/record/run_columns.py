"""The columns of ``run.csv``: which ones a team needs, their names and their order.

A team of the default kind of unicycle has the columns of the first version, ``PLACE`` and ``v, omega``;
any other has more columns after these, as far as it needs them.  Names are components of
``geometry_msgs/Twist`` and ``Quaternion``.
"""

import csv
from typing import NamedTuple, Tuple

from mrs_simulator.core.kinematics import TWIST_AXES, UNICYCLE_AXES

PLACE = ("time", "robot", "x", "y", "theta", "alpha_x", "alpha_y")
COLUMNS = PLACE + ("v", "omega")  # of the first version
PLANAR_TWIST = ("twist.linear.x", "twist.linear.y", "twist.angular.z")
ARM = "arm."  # how the names of the axes of arms begin: ``arm.1`` is the rate of their first joints
JOINT = "joint"  # the first one; the second is ``joint.2``
SPATIAL = ("z", "orientation.x", "orientation.y", "orientation.z", "orientation.w", "alpha_z")
SPATIAL += ("twist.linear.z", "twist.angular.x", "twist.angular.y")
LOAD = ("force.x", "force.y", "force.z", "load.x", "load.y", "load.z")
LOAD += ("load.orientation.x", "load.orientation.y", "load.orientation.z", "load.orientation.w")
ESTIMATE = ("estimate.x", "estimate.y", "estimate.theta")  # the pose that the control used
KIND = ("kind",)


class Columns(NamedTuple):
    """Which columns a file has besides ``PLACE``."""

    axes: Tuple[str, ...] = UNICYCLE_AXES  # of the commands
    twist: bool = False  # body twists in the plane
    joints: int = 0  # greatest number of joints of a robot: a steered wheel, an arm's
    spatial: bool = False  # height, orientation, the points' height, the rest of the twist
    kinds: Tuple[str, ...] = ()  # of the robots, () for a file without that column
    load: bool = False  # each robot's force on the load, and the load's pose
    estimate: bool = False  # the poses that the control used

    @property
    def names(self):
        """Return the names of all columns, in order."""
        commands = ("v", "omega") if self.axes == UNICYCLE_AXES else self.axes
        names = PLACE + commands
        for wanted, more in (
            (self.twist, PLANAR_TWIST),
            (self.joints, joint_names(self.joints)),
            (self.spatial, SPATIAL),
            (self.load, LOAD),
            (self.estimate, ESTIMATE),
            (self.kinds, KIND),
        ):
            names += more if wanted else ()
        return names

    @property
    def width(self):
        """Return the number of columns that hold numbers."""
        return len(self.names) - bool(self.kinds)

    def slices(self):
        """Return where in a row the blocks of numbers are, by name, from the command on."""
        begin, result = len(PLACE), {}
        for name, there, width in (
            ("command", True, len(self.axes)),
            ("twist", self.twist, len(PLANAR_TWIST)),
            ("joints", True, self.joints),
            ("spatial", self.spatial, len(SPATIAL)),
            ("load", self.load, len(LOAD)),
            ("estimate", self.estimate, len(ESTIMATE)),
        ):
            result[name] = slice(begin, begin + width * there)
            begin = result[name].stop
        return result


def columns_in(names):
    """Return the ``Columns`` of a file whose first line has ``names``; None if it is no recording.

    Kinds are not known yet: one without a name stands for them.
    """
    more = tuple(names[len(PLACE) :])
    arms = sum(name.startswith(ARM) for name in more)
    axes = tuple(axis for axis in TWIST_AXES if axis in more) + arm_axes(arms) or UNICYCLE_AXES
    found = Columns(
        axes,
        twist=PLANAR_TWIST[0] in more,
        joints=sum(name.startswith(JOINT) for name in more),
        spatial=SPATIAL[0] in more,
        kinds=("",) if KIND[0] in more else (),
        load=LOAD[0] in more,
        estimate=ESTIMATE[0] in more,
    )
    return found if found.names == tuple(names) else None


def arm_axes(count):
    """Return the names of the axes of arms with ``count`` joints."""
    return tuple("{}{}".format(ARM, place) for place in range(1, count + 1))


def joint_names(count):
    """Return the names of the columns of ``count`` joints."""
    return (JOINT, *("{}.{}".format(JOINT, place) for place in range(2, count + 1)))


def kind_fields(kinds):
    """Return the names of ``kinds`` as fields of a line: quoted where they need it, without line ends."""
    return [_field(" ".join(name.split())) for name in kinds]


def _field(name):
    if '"' in name or "," in name:
        return '"{}"'.format(name.replace('"', '""'))
    return name


def without_kinds(lines):
    """Return ``lines`` without their last field, and these fields; ``ValueError`` if one has none."""
    if any('"' in line for line in lines):
        rows = [_quoted_row(line) for line in lines]
        return [",".join(row[:-1]) for row in rows], [row[-1] for row in rows]
    parts = [line.rstrip("\n").rpartition(",") for line in lines]
    return [head for head, _, _ in parts], [kind for _, _, kind in parts]


def _quoted_row(line):
    try:
        return next(csv.reader([line]))
    except (csv.Error, StopIteration) as error:
        raise ValueError(str(error)) from None
