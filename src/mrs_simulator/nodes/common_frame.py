"""The robots' poses in the common frame, from whatever tells where they are."""

import math

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped

from mrs_simulator.core.guards import JumpBounds, Tracks
from mrs_simulator.core.kinematics import compose, origins
from mrs_simulator.nodes.odometry_inbox import OdometryInbox, planar, silence
from mrs_simulator.nodes.parameters import number_parameter, pattern_parameter, text_parameter
from mrs_simulator.world.robots import limits_of_team

DEFAULT_SOURCES = {"world": "odometry", "wheel": "scenario"}
MAX_JUMP = 0.3  # [m], [rad], and what the robot's speed explains
RESTART = 0.5  # [s] of silence that a driver's restart takes at least
WATCHDOG = 0.6  # [s] of silence after which a robot's driver stops it
START = "then call the service {}"


def make_common_frame(scenario):
    """Return the :class:`CommonFrame` that the parameter ``~frame_source`` names."""
    default = DEFAULT_SOURCES[scenario.odometry]
    return SOURCES[text_parameter("~frame_source", default, tuple(SOURCES))](scenario)


class CommonFrame:
    """Odometry that is already in the common frame; the other sources change what they need."""

    ABSOLUTE = True  # the poses tell where a robot is, whatever the scenario says
    BEGINS_AT_ZERO = False  # a driver that is started again begins at its origin
    WATCHES_ODOMETRY = True  # where a jump would show
    WHAT = "odometry"
    ADVICE = "see where it stands and what its odometry says"

    def __init__(self, scenario):
        """Listen to the odometry of the robots of ``scenario``."""
        self.numbers = tuple(range(1, scenario.n + 1))
        self.odom_timeout = number_parameter("~odom_timeout", 0.5, above=0.0)
        self._starts = scenario.poses
        self._bounds = self._jump_bounds(scenario)
        self.inbox = OdometryInbox(self.numbers, self._bounds if self.WATCHES_ODOMETRY else None)

    def _jump_bounds(self, scenario):
        # The simulator's robots are put elsewhere on purpose: by reset, by another team.
        simulated = rospy.get_param("/use_sim_time", False)
        slack = number_parameter("~max_jump", 0.0 if simulated else MAX_JUMP, low=0.0)
        if slack == 0.0:
            return None
        limits = limits_of_team(scenario.kinds, scenario.limits)
        top = limits_of_team(scenario.kinds, "top")
        speeds = [
            given if math.isfinite(given) else highest for given, highest in zip(limits[:2], top)
        ]
        silent = min(self.odom_timeout, RESTART) if self.BEGINS_AT_ZERO else math.inf
        return JumpBounds(slack, *speeds, longest=self.odom_timeout + WATCHDOG, silence=silent)

    def pose(self):
        """Return the robots' poses in the common frame, (n, 3), NaN where not known."""
        return self.inbox.pose()

    def missing(self, now):
        """Return which robots' poses are not known or too old at ``now`` [s], or ""."""
        return silence(self.inbox.stale(now, self.odom_timeout))

    def stale(self, now):
        """Return the numbers of those robots."""
        return list(self.inbox.stale(now, self.odom_timeout))

    def jumped(self):
        """Return ``{row: text}`` of the robots that are no longer followed."""
        return self.inbox.jumps()

    def jump_trouble(self):
        """Return what jumped and what to do, or ""."""
        return "; ".join(
            "robot{}: the {} {}: {}, {}".format(
                self.numbers[row],
                self.WHAT,
                jump,
                self._advice(row),
                START.format(rospy.resolve_name("~start")),
            )
            for row, jump in sorted(self.jumped().items())
        )

    def _advice(self, row):
        return self.ADVICE.format("({:.2f}, {:.2f}, {:.2f})".format(*self._starts[row]))

    def accept(self):
        """Follow the robots that jumped from where they are now: a person has said so."""
        self.inbox.accept()


class ScenarioFrame(CommonFrame):
    """Odometry that began at zero where the scenario says that the robot stood."""

    ABSOLUTE = False
    BEGINS_AT_ZERO = True
    ADVICE = (
        "was its driver restarted? Put it back on its initial pose {} and restart its driver there"
    )

    def pose(self):
        """Return the odometry from the scenario's initial poses on."""
        return compose(self._starts, self.inbox.pose())


class FirstFrame(ScenarioFrame):
    """Odometry whose first value counts as the scenario's initial pose, for drivers left running."""

    ADVICE = (
        "was its driver restarted? Put it back on its initial pose {}, as which its odometry will "
        "count from there"
    )

    def pose(self):
        """Return the odometry as seen from where it was first heard."""
        return compose(origins(self._starts, self.inbox.first()), self.inbox.pose())


class ExternalFrame(CommonFrame):
    """PoseStamped of each robot on ``~pose_topic``, from a camera or motion capture."""

    WATCHES_ODOMETRY = False
    WHAT = "pose"
    ADVICE = "see what localises it"

    def __init__(self, scenario):
        """Listen to the poses, and to the odometry as a sign of life of the robots' drivers."""
        super().__init__(scenario)
        topic = pattern_parameter("~pose_topic", "/robot{}/pose")
        self.pose_timeout = number_parameter("~pose_timeout", 0.5, above=0.0)
        self._poses = OdometryInbox(self.numbers, self._bounds, topic, PoseStamped)

    def pose(self):
        """Return the newest poses."""
        return self._poses.pose()

    def missing(self, now):
        """Return which robots' odometry or pose is missing, or ""."""
        stale = self._poses.stale(now, self.pose_timeout)
        return super().missing(now) or silence(stale, "pose on " + self._poses.topic)

    def stale(self, now):
        """Return the numbers of the robots whose odometry or pose is missing."""
        return sorted(set(super().stale(now)).union(self._poses.stale(now, self.pose_timeout)))

    def jumped(self):
        """Return ``{row: text}`` of the robots whose pose jumped."""
        return self._poses.jumps()

    def accept(self):
        """Follow the poses again."""
        self._poses.accept()


class TfFrame(CommonFrame):
    """The transforms from ``~world_frame`` to each robot's ``~base_frame``."""

    WATCHES_ODOMETRY = False
    WHAT = "transform"
    ADVICE = "see what localises it"

    def __init__(self, scenario):
        """Listen to tf, and to the odometry as a sign of life of the robots' drivers."""
        super().__init__(scenario)
        import tf2_ros  # only where it is wanted

        self._world = text_parameter("~world_frame", "world").lstrip("/")
        base = pattern_parameter("~base_frame", "robot{}/base_link").lstrip("/")
        self._frames = [base.replace("{}", str(number)) for number in self.numbers]
        self.pose_timeout = number_parameter("~pose_timeout", 0.5, above=0.0)
        self._tracks = Tracks(scenario.n, self._bounds)
        self._stamps = [None] * scenario.n
        self._wrong = {}
        self._buffer = tf2_ros.Buffer()
        self._error = tf2_ros.TransformException
        self._listener = tf2_ros.TransformListener(self._buffer)

    def _look(self, now):
        """Take in the newest transforms; keep what is wrong with the others."""
        self._wrong = {}
        for row, frame in enumerate(self._frames):
            try:
                found = self._buffer.lookup_transform(self._world, frame, rospy.Time(0))
            except self._error as error:
                self._wrong[row] = "{} -> {}: {}".format(self._world, frame, error)
                continue
            stamp = found.header.stamp
            if not stamp.is_zero() and now - stamp.to_sec() > self.pose_timeout:
                text = "{} -> {} is {:.1f} s old"
                self._wrong[row] = text.format(self._world, frame, now - stamp.to_sec())
            elif stamp != self._stamps[row]:
                self._stamps[row] = stamp
                self._take(row, found.transform, stamp.to_sec())

    def _take(self, row, move, stamp):
        pose = planar(_Pose(move.translation, move.rotation))
        if np.isfinite(pose).all():
            self._tracks.take(row, pose, (stamp, stamp))

    def pose(self):
        """Return the poses that ``missing`` last found."""
        return self._tracks.pose.copy()

    def missing(self, now):
        """Look all transforms up; return which robots' odometry or transform is missing, or ""."""
        self._look(now)
        lost = "; ".join(self._wrong[row] for row in sorted(self._wrong)[:3])
        more = ", and {} more".format(len(self._wrong) - 3) if len(self._wrong) > 3 else ""
        return super().missing(now) or ("no fresh transform " + lost + more if lost else "")

    def stale(self, now):
        """Return the numbers of the robots whose odometry or transform is missing."""
        return sorted(set(super().stale(now)).union(self.numbers[row] for row in self._wrong))

    def jumped(self):
        """Return ``{row: text}`` of the robots whose transform jumped."""
        return dict(self._tracks.jumps)

    def accept(self):
        """Follow the transforms again."""
        self._tracks.accept()


class _Pose:
    """What ``planar`` reads, from the parts of a transform."""

    def __init__(self, position, orientation):
        self.position, self.orientation = position, orientation


SOURCES = {
    "odometry": CommonFrame,
    "scenario": ScenarioFrame,
    "first": FirstFrame,
    "tf": TfFrame,
    "external": ExternalFrame,
}
