"""The columns of a team's state: each is declared here once.

A column has a name, by which states hold it; names in ``run.csv``; fields in ``TeamState``; unit, frame and
meaning; and a rule which teams have it.
"""

from typing import Any, Callable, NamedTuple, Tuple

from mrs_simulator.core.kinematics import TWIST_AXES, UNICYCLE_AXES
from mrs_simulator.core.spatial import Spatial

ARM = "arm."  # how the names of the axes of arms begin: ``arm.1`` is the rate of their first joints
JOINT = "joint"  # the first one; the second is ``joint.2``
XYZW = "x y z w"


def always(_):
    return True


def _others(team):
    return not team.is_of_unicycles


def _in_space(team):
    return team.is_spatial or team.has_arms


def _carrying(scenario):
    return scenario.load is not None


class Column(NamedTuple):
    """What is known of each robot at one time, or of the team."""

    name: str
    csv: Any  # names in ``run.csv``, or their function of the number of them and of the axes
    unit: str = ""
    meaning: str = ""  # in Markdown; with the frame where it is not the common one
    when: str = "always"  # it is in run.csv, in Markdown
    of: Callable[[Any], int] = always  # how many numbers a ``Team`` has; True for all
    given: Callable[[Any], bool] = always  # whether a ``Scenario`` has it
    message: Tuple[
        str, ...
    ] = ()  # fields of ``TeamState``, one for each number or one array for all
    over_ros: bool = True  # whether the record node has it; else runs without ROS alone
    of_team: bool = False  # one value for all robots
    is_flat: bool = True  # (n,) where each robot has one number, else (n, 1)
    kind: type = float  # of its numbers

    def names(self, width, axes):
        """Return the names in ``run.csv`` of ``width`` numbers under commands with ``axes``."""
        return self.csv(width, axes) if callable(self.csv) else self.csv

    def width(self, count):
        """Return how many numbers each robot has of a recorded column; ``count``: as ``of`` returns it."""
        return count if callable(self.csv) else len(self.csv)

    @property
    def rank(self):
        """Return how many dimensions a column at one time has before those of a robot's numbers."""
        return 0 if self.of_team else 1


class Group(NamedTuple):
    """Columns that only come together, and the named tuple that holds them."""

    name: str
    kind: Any
    columns: Tuple[str, ...]


class LoadState(NamedTuple):
    """A load at one time, or at each of m: (m, ...)."""

    place: Any  # (3,) [m] of its centre, common frame
    orientation: Any  # (4,) unit quaternion x, y, z, w
    force: Any  # (n, 3) [N] that each robot exerts on it, common frame

    def at(self, rows):
        """Return the ``LoadState`` of the samples ``rows``."""
        return LoadState(*(each[rows] for each in self))


def arm_axes(count):
    """Return the names of the axes of arms with ``count`` joints."""
    return tuple("{}{}".format(ARM, place) for place in range(1, count + 1))


def command_names(_width, axes):
    """Return the names of the columns of commands with ``axes``."""
    return ("v", "omega") if axes == UNICYCLE_AXES else axes


def axes_in(names):
    """Return the axes of which ``names`` are, those of a unicycle where there is none."""
    arms = sum(name.startswith(ARM) for name in names)
    return tuple(axis for axis in TWIST_AXES if axis in names) + arm_axes(arms) or UNICYCLE_AXES


def joint_names(width, _axes):
    """Return the names of the columns of ``width`` joints."""
    return (JOINT, *("{}.{}".format(JOINT, place) for place in range(2, width + 1)))


def joint_count(team):
    """Return how many joints each robot of ``team`` has."""
    return team.has_joints and (1 if team.rest_joints.ndim == 1 else team.rest_joints.shape[1])


def _parts(stem, parts):
    return tuple("{}.{}".format(stem, part) for part in parts.split())


SPACE = "a team of which one leaves the ground, or with arms"
CARRIED = "scenarios with a [`load`](manipulators.md#carrying-together)"

# In the order of run.csv.
POSE = Column(
    "pose",
    ("x", "y", "theta"),
    "m, m, rad",
    "the true pose of the robot's centre",
    message=("x", "y", "theta"),
)
HAND = Column("hand", ("alpha_x", "alpha_y"), "m", "its controlled point")
COMMAND = Column(
    "command",
    command_names,
    "m/s, rad/s",
    "the command held from that time on; any team but one of unicycles has a column for each component of "
    "`geometry_msgs/Twist` that a robot obeys, such as `linear.y`, and for arms' rates, `arm.1`, ...; 0 "
    "for a robot that does not",
    of=lambda team: len(team.axes),
    is_flat=False,
)
TWIST = Column(
    "twist",
    ("twist.linear.x", "twist.linear.y", "twist.angular.z"),
    "m/s, m/s, rad/s",
    "the true velocity of the centre, of a real robot what its driver measures, in the robot's body frame",
    "any team but one of unicycles, and any with real robots",
    _others,
    message=("vx", "vy", "omega"),
)
JOINTS = Column(
    "joints",
    joint_names,
    "rad",
    "the steering angle, 0 for a robot without; then, `joint.2`, ..., further joints of a robot",
    "a team with steered wheels, or with arms",
    joint_count,
    message=("joint",),
)
Z = Column("z", ("z",), "m", "height above the ground", SPACE, _in_space, message=("z",))
ORIENTATION = Column(
    "orientation",
    _parts("orientation", XYZW),
    "",
    "the body's orientation as a unit quaternion; `theta` is its heading",
    SPACE,
    _in_space,
    message=("orientation",),
)
POINT_Z = Column("point_z", ("alpha_z",), "m", "height of the controlled point", SPACE, _in_space)
OUT_OF_PLANE = Column(
    "out_of_plane",
    ("twist.linear.z", "twist.angular.x", "twist.angular.y"),
    "m/s, rad/s, rad/s",
    "the rest of the velocity, in the robot's body frame",
    SPACE,
    _in_space,
    message=("vz", "wx", "wy"),
)
FORCE = Column(
    "force",
    _parts("force", "x y z"),
    "N",
    "the force of the robot's grip on the load",
    CARRIED,
    given=_carrying,
    message=("force",),
)
LOAD_PLACE = Column(
    "load_place",
    _parts("load", "x y z"),
    "m",
    "the place of the load's centre, the same for each robot",
    CARRIED,
    given=_carrying,
    of_team=True,
)
LOAD_ORIENTATION = Column(
    "load_orientation",
    _parts("load.orientation", XYZW),
    "",
    "the load's orientation as a unit quaternion",
    CARRIED,
    given=_carrying,
    of_team=True,
)
ESTIMATE = Column(
    "estimate",
    _parts("estimate", "x y theta"),
    "m, m, rad",
    "the pose that the control knew; the true one is in `x`, `y`, `theta`",
    "scenarios with [`estimates`](sensors.md#estimated-poses)",
    given=lambda scenario: scenario.estimates is not None,
)
RECORDED = (POSE, HAND, COMMAND, TWIST, JOINTS, Z, ORIENTATION, POINT_Z, OUT_OF_PLANE, FORCE)
RECORDED += (LOAD_PLACE, LOAD_ORIENTATION, ESTIMATE)
# In no recording.
COMMANDED = Column(
    "commanded", (), meaning="a command is in force", message=("commanded",), kind=bool
)
REAL = Column("real", (), meaning="it is a real robot", message=("real",), kind=bool)
FRESH = Column("fresh", (), meaning="there is recent data of it", kind=bool)
COLUMNS = {column.name: column for column in (*RECORDED, COMMANDED, REAL, FRESH)}

SPATIAL = Group("spatial", Spatial, ("z", "orientation", "out_of_plane"))
LOAD = Group("load", LoadState, ("load_place", "load_orientation", "force"))
GROUPS = {group.name: group for group in (SPATIAL, LOAD)}
