"""Poses of the robots in the common frame, from any source of localisation."""

import math

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped

from mrs_simulator.control.guards import JumpBounds
from mrs_simulator.core.kinematics import compose, origins
from mrs_simulator.core.spatial import headings, turned
from mrs_simulator.nodes.real.real_robots import real_among
from mrs_simulator.ros.message_forms.messages import TeamOdometry, read_odometry, team_odometry
from mrs_simulator.ros.node.node_parameters import (
    BASE_FRAME,
    FRAME_SOURCE,
    MAX_JUMP,
    ODOM_TIMEOUT,
    POSE_TIMEOUT,
    POSE_TOPIC,
    WORLD_FRAME,
)
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.receive.odometry_inbox import OdometryInbox, make_inbox, silence
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.team_in_space import team_of

DEFAULT_SOURCES = {"world": "odometry", "wheel": "scenario"}
RESTART = 0.5  # [s] of silence that a driver's restart takes at least
WATCHDOG = 0.6  # [s] of silence after which a robot's driver stops it
START = "then call the service {}"
FIRST = "pioneer_control/first_odometry"  # name as its listeners resolve it


def make_common_frame(scenario, leads=False, rows=None):
    """Return the :class:`CommonFrame` that the parameter ``~frame_source`` names.

    ``leads``: whether this is the control node, whose frame is that of all others; ``rows`` of the
    robots to listen to, all of them real; by default those of the whole team.
    """
    default = DEFAULT_SOURCES[scenario.odometry]
    return SOURCES[read(FRAME_SOURCE, default)](scenario, leads, rows)


class CommonFrame:
    """Odometry that is already in the common frame; the other sources change what they need."""

    ABSOLUTE = True  # the poses are where a robot is, whatever the scenario says
    BEGINS_AT_ZERO = False  # a driver that is started again begins at its origin
    WATCHES_ODOMETRY = True  # where a jump would show
    WHAT = "odometry"
    ADVICE = "see where it stands and what its odometry says"

    def __init__(self, scenario, leads=False, rows=None):
        """Listen to the odometry of the robots of ``scenario``, as ``make_common_frame`` says."""
        self._leads = leads
        self.rows = list(range(scenario.n) if rows is None else rows)
        self.numbers = tuple(row + 1 for row in self.rows)
        self.odom_timeout = read(ODOM_TIMEOUT)
        self.begin_at(scenario.poses)
        self._is_spatial = Team.from_scenario(scenario).is_spatial
        self._real = real_among(scenario.n) if rows is None else list(range(len(rows)))
        self._bounds = self._jump_bounds(scenario)
        bounds = self._bounds if self.WATCHES_ODOMETRY else None
        known = self.numbers, bounds, self._real, self.odom_timeout
        more = {"frames": self.WATCHES_ODOMETRY}
        if rows is None:
            self.inbox = make_inbox(*known, **more, together=team_of(scenario).has_arms)
        else:
            self.inbox = OdometryInbox(*known, **more)
        self._poses = self.inbox  # whatever says where the robots are

    def begin_at(self, poses):
        """Take in other initial poses of the whole team, (n, 3)."""
        self._starts = poses[self.rows]

    def _jump_bounds(self, scenario):
        """Return the ``JumpBounds`` of each robot, None for one that may be anywhere, or None."""
        # The simulator's robots are put elsewhere on purpose: by reset, by another team.
        given = is_given(MAX_JUMP)
        rows = range(len(self.rows)) if given else self._real
        slack = read(MAX_JUMP)
        if slack == 0.0 or not len(rows):
            return None
        speeds = Team.from_scenario(scenario).speeds
        highest = Team.from_scenario(scenario, "top").speeds
        speeds = np.where(np.isfinite(speeds), speeds, highest)[self.rows].tolist()
        silent = min(self.odom_timeout, RESTART) if self.BEGINS_AT_ZERO else math.inf
        longest = self.odom_timeout + WATCHDOG
        return [
            JumpBounds(slack, *speeds[row], longest=longest, silence=silent)
            if row in rows
            else None
            for row in range(len(self.rows))
        ]

    def pose(self):
        """Return the robots' poses in the common frame, (n, 3), NaN where not known."""
        return self._poses.pose()

    def heights(self):
        """Return the robots' heights above the ground, (n,) [m], as received."""
        return self._poses.heights()

    def with_heights(self, pose):
        """Return ``pose`` (n, 3); of a team that leaves the ground (n, 4), with its heights."""
        return np.column_stack([pose, self.heights()]) if self._is_spatial else pose

    def twists(self):
        """Return the body twists vx, vy, omega, (n, 3) [m/s, m/s, rad/s], as in odometry."""
        return self.inbox.twists()

    def spatial(self):
        """Return the robots' ``Spatial``; orientations in the common frame."""
        received, theta = self._poses.spatial(), self.pose()[:, 2]
        if self._poses is not self.inbox:
            received = received._replace(twist=self.inbox.spatial().twist)
        return received._replace(
            orientation=turned(received.orientation, theta - headings(received.orientation))
        )

    def missing(self, now):
        """Return which robots' poses are not known or too old at ``now`` [s], or ""."""
        stale = self.inbox.stale(now, self.odom_timeout)
        return silence(stale, reasons=self.inbox.refused()[1]) if stale else ""

    def stale(self, now):
        """Return the numbers of those robots."""
        return list(self.inbox.stale(now, self.odom_timeout))

    def refused(self):
        """Return how many messages of each robot were refused, and why the newest were, in words."""
        counts, reasons = self.inbox.refused()
        return counts, _named(reasons, "odometry")

    def doubled(self):
        """Return ``{topic: [nodes]}`` of the robots' topics on which several nodes publish."""
        return self.inbox.doubled()

    def jumped(self):
        """Return ``{row: text}`` of the robots that are no longer followed."""
        return self._poses.jumps()

    def jump_texts(self):
        """Return ``{row: text}`` of the robots that are no longer followed, each named."""
        return {
            row: "robot{}: the {} {}".format(self.numbers[row], self.WHAT, jump)
            for row, jump in sorted(self.jumped().items())
        }

    def jump_trouble(self):
        """Return what jumped and what to do, or ""."""
        start = START.format(rospy.resolve_name("~start"))
        return "; ".join(
            "{}: {}, {}".format(text, self._advice(row), start)
            for row, text in self.jump_texts().items()
        )

    def _advice(self, row):
        return self.ADVICE.format("({:.2f}, {:.2f}, {:.2f})".format(*self._starts[row]))

    def accept(self):
        """Follow the robots that jumped from where they are now: a person has said so."""
        for source in {self.inbox, self._poses}:
            source.accept()


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

    def __init__(self, scenario, leads=False, rows=None):
        """Listen to the odometry, and to where the leading node first received it, or publish that."""
        super().__init__(scenario, leads, rows)
        self._first_poses = np.full((len(self.rows), 3), np.nan)
        if leads:
            self._first_publisher = rospy.Publisher(FIRST, TeamOdometry, queue_size=1, latch=True)
        else:
            self._listener = rospy.Subscriber(
                FIRST, TeamOdometry, self._on_first_poses, queue_size=1
            )

    def pose(self):
        """Return the odometry as seen from where it was first received."""
        first = self.inbox.first()
        if self._leads:
            self._publish_first(first)
        else:
            first = np.where(np.isnan(self._first_poses), first, self._first_poses)
        return compose(origins(self._starts, first), self.inbox.pose())

    def _publish_first(self, first):
        if first.tobytes() != self._first_poses.tobytes():
            self._first_poses = first
            self._first_publisher.publish(team_odometry(self.numbers, first))

    def _on_first_poses(self, message):
        numbers, poses, _, _ = read_odometry(message)
        received = dict(zip(numbers, poses))
        self._first_poses = np.array(
            [received.get(number, (np.nan,) * 3) for number in self.numbers]
        )


class LocalisedFrame(CommonFrame):
    """Poses from what localises the robots; the odometry is a sign of life of their drivers."""

    WATCHES_ODOMETRY = False
    ADVICE = "see what localises it"

    def __init__(self, scenario, leads=False, rows=None):
        """Listen to the poses and to the odometry."""
        super().__init__(scenario, leads, rows)
        self.pose_timeout = read(POSE_TIMEOUT)
        self._poses = self._open_poses()

    def missing(self, now):
        """Return which robots' odometry or pose is missing, or ""."""
        what = self.WHAT + " on " + self._poses.topic
        stale = self._poses.stale(now, self.pose_timeout)
        return super().missing(now) or silence(stale, what, self._poses.refused()[1])

    def stale(self, now):
        """Return the numbers of the robots whose odometry or pose is missing."""
        return sorted(set(super().stale(now)).union(self._poses.stale(now, self.pose_timeout)))

    def refused(self):
        counts, text = super().refused()
        more, reasons = self._poses.refused()
        texts = filter(None, (text, _named(reasons, self.WHAT)))
        return [a + b for a, b in zip(counts, more)], "; ".join(texts)

    def doubled(self):
        return {**super().doubled(), **self._poses.doubled()}


class ExternalFrame(LocalisedFrame):
    """PoseStamped of each robot on ``~pose_topic``, from a camera or motion capture."""

    WHAT = "pose"

    def _open_poses(self):
        topic = read(POSE_TOPIC)
        return OdometryInbox(
            self.numbers, self._bounds, self._real, self.pose_timeout, topic, PoseStamped
        )


class TfFrame(LocalisedFrame):
    """The transforms from ``~world_frame`` to each robot's ``~base_frame``."""

    WHAT = "transform"

    def _open_poses(self):
        from mrs_simulator.nodes.control.tf_inbox import (
            TransformInbox,  # tf only where it is wanted
        )

        world = read(WORLD_FRAME).lstrip("/")
        base = read(BASE_FRAME).lstrip("/")
        return TransformInbox(
            self.numbers, self._bounds, self._real, self.pose_timeout, world, base
        )


def _named(reasons, what):
    """Return the text of ``{number: why}``, messages of the robots' ``what`` that were refused."""
    if not reasons:
        return ""
    number, why = min(reasons.items())
    more = " and {} more robots".format(len(reasons) - 1) if len(reasons) > 1 else ""
    return "{} of robot{} refused: {}{}".format(what, number, why, more)


SOURCES = {
    "odometry": CommonFrame,
    "scenario": ScenarioFrame,
    "first": FirstFrame,
    "tf": TfFrame,
    "external": ExternalFrame,
}
