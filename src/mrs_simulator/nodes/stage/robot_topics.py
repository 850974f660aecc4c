"""Topics of the simulated robots, one set for each or one for all: odometry out, commands in."""

import math
import threading
import time

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped

from mrs_simulator.core.kinematics import TWIST_AXES
from mrs_simulator.nodes.stage.answered_odometry import Answers
from mrs_simulator.ros.message_forms.messages import (
    MessageError,
    TeamCommand,
    TeamOdometry,
    read_answered,
    read_team_command,
    team_odometry,
)
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry, QuickTwist
from mrs_simulator.ros.node.senders import Senders
from mrs_simulator.ros.nonblocking_publisher import prompt_publisher
from mrs_simulator.ros.receive.shared_receiver import SharedReceiver
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.vehicles.team import on_all_axes

# Variances of the published odometry: x, y [m^2] and yaw [rad^2] as good as the simulator knows
# them; what a planar robot does not measure is marked as unknown by a very large value.
UNKNOWN = 1e6
PLANAR = (0, 1, 5, 6, 7, 11, 30, 31, 35)  # of x, y and yaw among the 36 numbers of a covariance
LEAST = 1e-6  # [m^2, rad^2] which keeps a covariance invertible
POSE_VARIANCE = {"world": (1e-6, 1e-6, 1e-6), "wheel": (1e-3, 1e-3, 1e-2)}
TWIST_VARIANCE = (1e-6, 1e-6, 1e-6)


class Inbox:
    """The newest command of each robot, put by subscriber threads, taken by the main loop."""

    def __init__(self):
        self._lock = threading.Lock()
        self._commands, self._senders = {}, Senders()  # by row, newer than the batches
        self._batches = []  # rows (m,) and commands (m, 6) of several robots, the newest last
        self._arms = {}  # rates of arms by row
        self.answers, self.receiver = Answers(), SharedReceiver()
        self.doubled = self._senders.doubled  # the topics of commands with several nodes

    def put(self, twist, row):
        """Keep ``twist``, a ``QuickTwist``, as the newest command of robot ``row``."""
        self._senders.note("/robot{}/cmd_vel".format(row + 1), twist)
        self.answers.note(row, twist.values, time.monotonic())
        with self._lock:
            self._commands[row] = twist.values

    def put_all(self, rows, commands, stamps, message=None, arms=()):
        """Keep ``commands`` (m, 6) of the robots ``rows``, which came in ``message``.

        ``stamps`` (m,) [s]: of the odometry that they answer, NaN where unknown; ``arms`` (m, k)
        [rad/s]: rates of their arms' joints, or empty.
        """
        self._senders.note("stage/command", message)
        self.answers.note_all(rows, time.monotonic(), stamps)
        with self._lock:
            self._close_batch()
            self._batches.append((rows, commands))
            self._arms.update(zip(rows, arms))

    def take_arms(self):
        """Return the newest rates of arms by row, and forget them."""
        with self._lock:
            taken, self._arms = self._arms, {}
        return taken

    def take(self, n):
        """Return ``(rows, commands)`` of the first n robots, ascending, and forget all.

        Shapes (m,) and (m, 6) [m/s, rad/s], all components of Twist.
        """
        with self._lock:
            self._close_batch()
            batches, self._batches = self._batches, []
        if not batches:
            return [], np.empty((0, 6))
        rows, commands = (np.concatenate(parts)[::-1] for parts in zip(*batches))
        rows, newest = np.unique(rows, return_index=True)
        # A late message may still come for a robot that has been taken away.
        here = (rows >= 0) & (rows < n)
        return rows[here].tolist(), commands[newest[here]]

    def _close_batch(self):
        if self._commands:
            rows = np.array(list(self._commands), dtype=int)
            self._batches.append((rows, np.array(list(self._commands.values()), dtype=float)))
            self._commands = {}


class Link:
    """A topic of odometry out, ``_publisher``, and one of commands in, ``_subscriber``."""

    @property
    def listened_to(self):
        """Return whether anybody subscribes to the odometry."""
        return self._publisher.get_num_connections() > 0

    @property
    def commanded(self):
        """Return whether anybody publishes commands."""
        return self._subscriber.get_num_connections() > 0

    def close(self):
        """Withdraw both topics."""
        self._publisher.unregister()
        withdraw(self._subscriber)


class RobotTopics(Link):
    """``/robotN/odom`` and ``/robotN/cmd_vel`` of one robot."""

    def __init__(self, row, inbox, odometry, frames):
        """``odometry``: "world", "wheel" or "rosaria"; ``frames``: :class:`Frames`."""
        name = "/robot{}".format(row + 1)
        self._publisher = prompt_publisher(name + "/odom", PlanarOdometry)
        self._subscriber = inbox.receiver.subscribe(name + "/cmd_vel", QuickTwist, inbox.put, row)
        # RosAria publishes no covariance.
        known = odometry != "rosaria"
        self._message = PlanarOdometry()
        self._message.prepare(
            frames.odom(row + 1),
            frames.base(row + 1),
            covariance(POSE_VARIANCE[odometry] if known else None),
            covariance(TWIST_VARIANCE if known else None),
        )

    def publish(self, stamp, pose, twist, lift=None, covariance=None):
        """Publish ``pose`` (x, y, theta) and body ``twist`` (vx, vy, omega).

        ``lift``: what a robot that leaves the ground reports besides, as ``PlanarOdometry`` has it;
        ``covariance`` (36,) of the pose, None for one that does not change.
        """
        message = self._message
        if covariance is not None:
            message.tell_pose_covariance(covariance)
        message.lift = lift
        message.stamp, message.planar, message.body = stamp, pose, twist
        self._publisher.publish(message)


class TruePose:
    """The true pose of one robot, as motion capture publishes it."""

    def __init__(self, name, frame):
        """``name`` of the topic; ``frame``: the common one."""
        self._publisher = rospy.Publisher(name, PoseStamped, queue_size=1, tcp_nodelay=True)
        self.close = self._publisher.unregister
        self._message = PoseStamped()
        self._message.header.frame_id = frame

    def publish(self, stamp, pose, lift=None):
        """Publish ``pose`` (x, y, theta), and what of ``lift`` belongs to it."""
        message, where = self._message, self._message.pose
        message.header.stamp = stamp
        fill(where.position, where.orientation, pose, lift)
        self._publisher.publish(message)


class TeamTopics(Link):
    """``~odometry`` and ``~command`` of the stage: all robots at once."""

    def __init__(self, inbox):
        """Commands go to ``inbox`` as those of the robots' own topics."""
        self._inbox = inbox
        self._publisher = rospy.Publisher("~odometry", TeamOdometry, queue_size=1, tcp_nodelay=True)
        self._subscriber = rospy.Subscriber(
            "~command", TeamCommand, self._on_command, queue_size=1, tcp_nodelay=True
        )

    def publish(self, stamp, poses, twists, rows, spatial=None, joints=None):
        """Publish ``poses`` and body ``twists``, (m, 3) each, of robots ``rows`` if anybody listens.

        ``joints`` (m, k) [rad] of robots with arms.
        """
        if not self.listened_to:
            return
        numbers = [row + 1 for row in rows]
        self._publisher.publish(team_odometry(numbers, poses, twists, stamp, spatial, joints))

    def _on_command(self, message):
        read = rows_commanded(message, self._subscriber.resolved_name)
        if read is not None:
            rows, twists, stamps, arms = read
            self._inbox.put_all(rows, twists, stamps, message, arms)


class AnswersTopic:
    """``~answers``: what a controller says on robots' own topics, and to which odometry."""

    def __init__(self, answers):
        """What is received goes to ``answers``, an ``Answers``."""
        self._answers = answers
        self._subscriber = rospy.Subscriber("~answers", TeamCommand, self._put, tcp_nodelay=True)

    def _put(self, message):
        read = rows_commanded(message, self._subscriber.resolved_name)
        if read is not None:
            rows, twists, stamps, _ = read
            self._answers.expect(rows.tolist(), twists.tolist(), stamps.tolist())


def rows_commanded(message, name):
    """Return rows, Twists (m, 6), stamps (m,) [s] and rates of arms in a ``TeamCommand``.

    None, and a line in the log that names its topic ``name``, where its arrays do not fit.
    """
    try:
        numbers, axes, command = read_team_command(message)
        stamps = read_answered(message)
    except MessageError as error:
        rospy.logerr_throttle(5.0, "stage: refused a command on {}: {}".format(name, error))
        return None
    rows = np.array(numbers, dtype=int) - 1
    planar = tuple(axis for axis in axes if axis in TWIST_AXES)  # those of arms come after them
    arms = command[:, len(planar) :] if len(planar) < len(axes) else ()
    return rows, on_all_axes(command[:, : len(planar)], planar), stamps, arms


class Frames:
    """Frame names, from the parameters ``~world_frame``, ``~odom_frame``, ``~base_frame``.

    ``{}`` in a pattern stands for the robot's number; no name begins with a slash (tf2).
    """

    def __init__(self, world="world", odom="robot{}/odom", base="robot{}/base_link"):
        for name, pattern in (("odom_frame", odom), ("base_frame", base)):
            if pattern.count("{}") != 1:
                raise ValueError(
                    "{} = {!r}: wanted one {{}} for the robot's number".format(name, pattern)
                )
        self.world = world.lstrip("/")
        self._odom, self._base = odom.lstrip("/"), base.lstrip("/")

    def odom(self, robot):
        """Return the odometry frame of robot number ``robot``."""
        return self._odom.replace("{}", str(robot))

    def base(self, robot):
        """Return the base frame of robot number ``robot``."""
        return self._base.replace("{}", str(robot))

    def mount(self, robot, name):
        """Return the frame of the sensor ``name`` of robot number ``robot``: ``robot1/laser``."""
        base = self.base(robot)
        return "{}/{}".format(base.rpartition("/")[0] or base, name)


def covariance(variances):
    """Return the row-major 6x6 covariance with these variances of x, y and yaw; None: all zero."""
    if variances is None:
        return [0.0] * 36
    matrix = np.diag([variances[0], variances[1], UNKNOWN, UNKNOWN, UNKNOWN, variances[2]])
    return matrix.ravel().tolist()


def full_covariances(planar):
    """Return the row-major 6x6 covariances (m, 36) with those of x, y and yaw, ``planar`` (m, 3, 3)."""
    full = np.tile(covariance((LEAST, LEAST, LEAST)), (len(planar), 1))
    full[:, PLANAR] += np.reshape(planar, (-1, 9))
    return full


def fill(place, turn, pose, lift=None):
    """Write ``pose`` (x, y, theta), or with ``lift`` all of it, into a position and a quaternion."""
    place.x, place.y = pose[:2]
    if lift is None:
        turn.z, turn.w = math.sin(0.5 * pose[2]), math.cos(0.5 * pose[2])
    else:
        place.z, turn.x, turn.y, turn.z, turn.w = lift[:5]


def lifts(spatial, count):
    """Return what each of ``count`` robots reports of ``spatial``, as ``PlanarOdometry`` has it."""
    if spatial is None:
        return [None] * count
    return np.column_stack([spatial.z, spatial.orientation, spatial.twist]).tolist()


def transform(stamp, parent, child, pose, lift=None):
    """Return the transform of frame ``child`` at ``pose`` (x, y, theta), and ``lift``, in ``parent``."""
    message = TransformStamped()
    message.header.stamp, message.header.frame_id = stamp, parent
    message.child_frame_id = child
    fill(message.transform.translation, message.transform.rotation, pose, lift)
    return message
