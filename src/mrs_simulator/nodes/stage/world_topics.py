"""Topics that the stage publishes about its world: clock, odometry, tf, true state, collisions."""

import math
import time

import rospy
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from mrs_simulator.nodes.stage.mirror import RealTopics
from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.nodes.stage.robot_topics import (
    AnswersTopic,
    RobotTopics,
    TeamTopics,
    TruePose,
    full_covariances,
    lifts,
    transform,
)
from mrs_simulator.ros.message_forms.messages import (
    Collision,
    Incident,
    TeamState,
    collision_message,
    incident_message,
    team_state,
)
from mrs_simulator.ros.node.node_parameters import TRUE_POSE_TOPIC
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.nonblocking_publisher import prompt_publisher
from mrs_simulator.scenario.surroundings.moving_obstacles import CLOCK_START
from mrs_simulator.world.wheel_odometry.covariance import OdometryCovariance


class WorldTopics(StagePart):
    """Publishes what it sees of a world; it changes nothing there."""

    def __init__(self, world, frames, inbox, odometry, mirror, fixed):
        """``world`` is looked at whenever something is published; ``frames``: ``robot_topics.Frames``.

        ``odometry``: whose robots publish, "world", "wheel", or of a driver, "rosaria"; ``mirror``: the
        ``Mirror`` of those that are real, whose odometry and transforms are not published here; commands
        go to ``inbox``; ``fixed()`` returns further frames, as ``SensorTopics.fixed_frames`` does.
        """
        self._fixed = fixed
        self._sure, self._sure_at = None, 0.0  # OdometryCovariance, and its time [s]
        self._world, self._frames = world, frames
        self._inbox, self._odometry = inbox, odometry
        self._mirror, self._real = mirror, mirror.rows
        self.robots = []
        self._pose_topic = read(TRUE_POSE_TOPIC)
        self._true_poses = {}  # TruePose by row
        self.collisions = self.incidents = 0
        self.clock_sent = 0.0  # [s] of wall time
        self._tf_sent = None
        self._clock = prompt_publisher("/clock", Clock)
        self._tf = publisher("/tf", TFMessage)
        self._tf_static = publisher("/tf_static", TFMessage, latch=True)
        # A recorder must not miss a state: the queue is long.
        self._state = publisher("~state", TeamState, queue_size=1000)
        self._collision = publisher("~collisions", Collision, queue_size=1000)
        self._incident = publisher("~incidents", Incident, queue_size=1000)
        # Real robots have topics of their own only.
        self.team_topics = None if mirror.rows else TeamTopics(inbox)
        self._answers = AnswersTopic(inbox.answers)

    def follow_team(self, scenario):
        """Open or withdraw robots' own topics, so that every robot of the world has its own.

        Wheel odometry states its covariance by the errors of ``scenario``.
        """
        while len(self.robots) > self._world.n:
            self.robots.pop().close()
        for row in range(len(self.robots), self._world.n):
            self.robots.append(self._topics_of(row))
        self._follow_true_poses()
        self._publish_static_transforms()
        world, self._sure_at = self._world, self._world.time
        self._sure = None
        if self._odometry == "wheel" and scenario.odometry_errors is not None:
            known = world.pose, world.estimates.odometry()
            self._sure = OdometryCovariance(world.team, scenario.odometry_errors, *known)

    def _topics_of(self, row):
        if row in self._real:
            return RealTopics(row, self._inbox, self._mirror)
        return RobotTopics(row, self._inbox, self._odometry, self._frames)

    def _follow_true_poses(self):
        wanted = set(range(self._world.n)).difference(self._real) if self._pose_topic else set()
        for row in set(self._true_poses) - wanted:
            self._true_poses.pop(row).close()
        for row in wanted.difference(self._true_poses):
            name = self._pose_topic.replace("{}", str(row + 1))
            self._true_poses[row] = TruePose(name, self._frames.world)

    def unlistened(self):
        """Return the rows of the robots whose odometry has no subscriber."""
        if self.team_topics and self.team_topics.listened_to:
            return []
        return [row for row, robot in enumerate(self.robots) if not robot.listened_to]

    def uncommanded(self):
        """Return the rows of the robots without a publisher of commands."""
        if self.team_topics and self.team_topics.commanded:
            return []
        return [row for row, robot in enumerate(self.robots) if not robot.commanded]

    def recorders(self):
        """Return how many listen to the state, and its name."""
        return self._state.get_num_connections(), self._state.resolved_name

    def stamp(self):
        """Return the stamp of the world's time."""
        return stamp_at(self._world.time)

    def publish_clock(self):
        """Publish simulated time."""
        self.clock_sent = time.monotonic()
        self._clock.publish(Clock(clock=self.stamp()))

    def publish_odometry(self, rows=None):
        """Publish the odometry of the robots in ``rows``, by default of all, and its transforms."""
        rows, stamp = range(self._world.n) if rows is None else rows.tolist(), self.stamp()
        poses, twists = self._world.estimates.odometry(), self._world.twist
        spatial = self._world.estimates.spatial()
        self._follow_covariances()
        if len(rows) < self._world.n:
            poses, twists = poses[rows], twists[rows]
            spatial = None if spatial is None else spatial.of(rows)
        if self.team_topics:
            joints = self._world.joints[rows] if self._world.team.has_arms else None
            self.team_topics.publish(stamp, poses, twists, rows, spatial, joints)
        self._publish_by_robots(stamp, rows, poses, twists, spatial)
        if self._true_poses:
            self._publish_true_poses(stamp, rows)
        listeners = self._tf.get_num_connections()
        # tf complains of a stamp that it has had; at rest only a new subscriber gets it.
        if listeners and (stamp, listeners) != self._tf_sent:
            self._tf_sent = (stamp, listeners)
            frames = self._frames.odom, self._frames.base
            raised = lifts(spatial, len(rows))
            self._tf.publish(self._transforms(*frames, poses.tolist(), rows, raised))

    def _publish_by_robots(self, stamp, rows, poses, twists, spatial):
        """Publish odometry on robots' own topics, where anybody listens."""
        places = [place for place, row in enumerate(rows) if self.robots[row].listened_to]
        if not places:
            return
        spatial = None if spatial is None else spatial.of(places)
        rows = [rows[place] for place in places]
        states = poses[places].tolist(), twists[places].tolist(), lifts(spatial, len(rows))
        for row, *each in zip(rows, *states, self._covariances(rows)):
            self.robots[row].publish(stamp, *each)

    def _follow_covariances(self):
        """Take in how far the robots have gone since the last odometry."""
        if self._sure is not None:
            world = self._world
            self._sure.follow(world.pose, world.estimates.odometry(), world.time - self._sure_at)
            self._sure_at = world.time

    def _covariances(self, rows):
        """Return covariances (36,) of the poses that robots ``rows`` report, None for one that stays."""
        if self._sure is None:
            return [None] * len(rows)
        return full_covariances(self._sure.covariance()[rows])

    def _publish_true_poses(self, stamp, rows):
        world = self._world
        raised = lifts(world.spatial, world.n)
        for row in self._true_poses.keys() & set(rows):
            self._true_poses[row].publish(stamp, world.pose[row].tolist(), raised[row])

    def _publish_static_transforms(self):
        origins = self._world.estimates.origins().tolist()
        world, rows = self._frames.world, range(self._world.n)
        level = [None] * len(rows)
        frames = (lambda _: world), self._frames.odom
        message = self._transforms(*frames, origins, rows, level)
        stamp = self.stamp()
        for parent, child, (x, y, z, *turn) in self._fixed():
            if len(turn) == 1:  # a yaw
                turn = 0.0, 0.0, math.sin(0.5 * turn[0]), math.cos(0.5 * turn[0])
            message.transforms.append(transform(stamp, parent, child, (x, y, 0.0), (z, *turn)))
        self._tf_static.publish(message)

    def _transforms(self, parent, child, poses, rows, raised):
        stamp = self.stamp()
        return TFMessage(
            transforms=[
                transform(stamp, parent(row + 1), child(row + 1), pose, lift)
                for row, pose, lift in zip(rows, poses, raised)
                if row not in self._real
            ]
        )

    def publish_state(self, stage=0, run=0):
        """Publish the true state of all robots, if anybody listens; ``stage``, ``run``: its numbers."""
        if not self._state.get_num_connections():
            return
        message = team_state(self._world, self.stamp(), self._frames.world, (stage, run))
        self._state.publish(message)

    def publish_collisions(self):
        """Publish and log the collisions that began since the last call."""
        for collision in self._world.contacts.take():
            self.collisions += 1
            stamp = stamp_at(collision.time)
            message = collision_message(collision, stamp, self._frames.world)
            self._collision.publish(message)
            rospy.logwarn(
                "stage: collision of %s and %s at %.3f s at (%s) m",
                *collision[1:3],
                collision.time,
                ", ".join(map("{:.2f}".format, collision.place)),
            )

    def publish_incidents(self):
        """Publish and log incidents of robots since the last call."""
        for incident in self._world.faults.take():
            self.incidents += 1
            self._incident.publish(incident_message(incident, stamp_at(incident.time)))
            rospy.logwarn("stage: %s at %.3f s", incident.text, incident.time)


def publisher(name, kind, queue_size=100, latch=False):
    """Return a publisher that sends at once."""
    return rospy.Publisher(name, kind, queue_size=queue_size, latch=latch, tcp_nodelay=True)


def stamp_at(simulated):
    """Return the stamp of simulated time [s]: whole nanoseconds, so that equal times are equal."""
    return rospy.Time(*divmod(int(round((CLOCK_START + simulated) * 1e9)), 10**9))
