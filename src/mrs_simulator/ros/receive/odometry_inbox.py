"""Newest pose of each robot: written by subscriber threads, read by the control loop."""

import math
import threading
import time

import numpy as np
import rospy

from mrs_simulator.control.guards import Tracks
from mrs_simulator.core.fields import shown
from mrs_simulator.core.kinematics import yaw
from mrs_simulator.core.spatial import Spatial, upright
from mrs_simulator.ros.message_forms.messages import (
    MessageError,
    TeamOdometry,
    read_joints,
    read_odometry,
)
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry
from mrs_simulator.ros.node.node_parameters import ODOM_FRAME, ODOM_TOPIC
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.ros.node.senders import Senders
from mrs_simulator.ros.receive.expected_odometry import NEVER, ExpectedOdometry
from mrs_simulator.ros.receive.intake import FARTHEST_REAL, Intake
from mrs_simulator.ros.receive.shared_receiver import SharedReceiver, subscribe
from mrs_simulator.ros.receive.team_topics import ODOMETRY, team_topics_wanted
from mrs_simulator.scenario.scenario import FARTHEST

MOST_NAMED = 8  # robots named in one line
TIMEOUT = 0.5  # [s] after which a pose is too old to drive by
CLOCK_PATIENCE = 0.5  # [s] of wall time for /clock to come to a message that has overtaken it
NAP = 0.002  # [s] of wall time


def make_inbox(numbers, bounds, real, timeout, frames, together):
    """Return the inbox of the robots' odometry: from one topic for all, or from one for each.

    ``frames``: whether it matters in which frame a robot's own topic has its pose; ``together`` as in
    ``team_topics_wanted``.
    """
    if team_topics_wanted(len(numbers), together):
        return TeamInbox(numbers, bounds, real, timeout)
    return OdometryInbox(numbers, bounds, real, timeout, frames=frames)


def clock_at(stamp, timeout):
    """Return ROS time [s], once /clock has come to a message stamped ``stamp`` [s].

    Where simulated time is fast and the machine busy, messages overtake the clock, each having a
    thread of its own, by more than their ``timeout``.  The wait ends after ``CLOCK_PATIENCE``.
    """
    now, end = rospy.get_time(), time.monotonic() + CLOCK_PATIENCE
    while 0.0 < now < stamp - timeout and time.monotonic() < end:
        if rospy.is_shutdown():
            break
        time.sleep(NAP)
        now = rospy.get_time()
    return now


class Inbox:
    """The newest poses; subclasses subscribe."""

    def __init__(self, numbers, bounds=None, real=(), timeout=TIMEOUT):
        """``numbers``: the robots' numbers; ``bounds``: ``JumpBounds`` or None.

        ``real``: rows of the real robots, whose silence is measured in wall time: simulated time
        may be slow, or stand.  ``timeout`` [s]: age from which on a pose is refused.
        """
        self._numbers = list(numbers)
        n = len(self._numbers)
        self._real = np.isin(np.arange(n), real)
        self._timeout = timeout
        self.intake, self.senders = Intake(self._real, timeout), Senders()
        self.changed = np.full(n, -math.inf)  # [s] of wall time when pose or twist last changed
        self._tracks = Tracks(n, bounds)
        self._stamp = np.full(n, NEVER)  # [ns]
        self._true = np.full(n, NEVER)  # [ns] the same by this host's clock
        self._body = np.zeros((n, 3))  # [m/s, m/s, rad/s]
        # z [m], the quaternion's x, y, z, w, and vz [m/s], wx, wy [rad/s]
        self._lift = np.zeros((n, 8))
        self._lift[:, 4] = 1.0
        self._z = self._lift[:, 0]  # a view
        self._ages = np.zeros(n, dtype=np.int64)  # [ns] up to which the newest stamps may be older
        self._expected = ExpectedOdometry(self._stamp, timeout)
        self._received = np.full(n, -math.inf)
        self._repeated, self._said = set(), {}
        self._changed = threading.Condition()
        self.arrived = -math.inf  # [s] of wall time, when the newest came
        self.accepted = 0  # messages accepted so far
        self._news = False
        self._awaited = None  # rows of the robots whose odometry is waited for; None: any wakes

    def pose(self):
        """Return the newest poses, shape (n, 3), NaN for a robot from which none came."""
        with self._changed:
            return self._tracks.pose.copy()

    def stamps(self):
        """Return the stamps of the newest poses, (n,) [s], NaN for a robot from which none came."""
        with self._changed:
            return np.where(self._stamp == NEVER, np.nan, 1e-9 * self._stamp)

    def heights(self):
        """Return the newest heights above the ground, (n,) [m], as received."""
        with self._changed:
            return self._z.copy()

    def twists(self):
        """Return the newest body twists vx, vy, omega, (n, 3) [m/s, m/s, rad/s], as received."""
        with self._changed:
            return self._body.copy()

    def spatial(self):
        """Return the ``Spatial`` of the robots, as received."""
        with self._changed:
            lift = self._lift.copy()
        return Spatial(lift[:, 0], lift[:, 1:5], lift[:, 5:])

    def true_times(self):
        """Return when the newest poses were true in ROS time, (n,) [ns].

        The stamps; of a robot whose clock is another than this host's the time of arrival.
        """
        with self._changed:
            return self._true.copy()

    def first(self):
        """Return the first pose of each robot, shape (n, 3)."""
        with self._changed:
            return self._tracks.first.copy()

    def jumps(self):
        """Return ``{row: text}`` of the robots whose pose jumped and is no longer followed."""
        with self._changed:
            return dict(self._tracks.jumps)

    def accept(self):
        """Follow the robots that jumped from where they are now, and learn their clocks anew."""
        with self._changed:
            self._tracks.accept()
            self.intake.forget()

    def refused(self):
        """Return how many messages of each robot were refused so far, and ``{number: why}`` of the
        robots whose newest one was."""
        with self._changed:
            reasons = {self._numbers[row]: why for row, why in self.intake.reasons.items()}
            return list(self.intake.refused), reasons

    def doubled(self):
        """Return ``{topic: [nodes]}`` of the robots' topics on which several nodes publish."""
        return self.senders.doubled()

    def stale(self, now, timeout):
        """Return ``{number: age}`` [s] of the robots silent for more than ``timeout`` [s].

        ``now`` [s] in ROS time; a robot from which nothing came has age ``inf``.
        """
        with self._changed:
            ages = self._times(now) - self._received
        return {
            number: float(age) for number, age in zip(self._numbers, ages) if not age <= timeout
        }

    def _times(self, now):
        """Return the time [s] that holds for each robot at ``now`` in ROS time, (n,)."""
        return np.where(self._real, time.monotonic(), now)

    def _note_arrival(self, rows):
        self.arrived = time.monotonic()
        self.accepted += 1
        if self._awaited is not None:
            if not self._awaited:
                return
            self._awaited.difference_update(rows)
            if self._awaited:
                return
        self._notify()

    def is_up_to_date(self, rows, now):
        """Return whether all odometry of robots ``rows`` due by ``now`` [s] in ROS time has arrived.

        From then on messages wake ``wait`` only when the last of those that are missing has come.
        """
        with self._changed:
            self._awaited = set(self._expected.missing(rows, now).tolist())
            return not self._awaited

    def wake(self):
        """Have ``wait`` return: time has gone on."""
        with self._changed:
            self._notify()

    def _notify(self):
        self._news = True
        self._changed.notify()

    def wait(self, seconds):
        """Return once something has come since the last call, or after ``seconds`` of wall time."""
        with self._changed:
            if not self._news:
                self._changed.wait(seconds)
            self._news = False

    def complete(self):
        """Return the newest stamp if no robot's odometry of that time is still to come, else None.

        All robots bear that stamp, unless ``set_periods`` has said that some publish less often.
        """
        with self._changed:
            newest = int(self._stamp.max())
            here = bool((self._stamp != NEVER).all() and (newest - self._stamp <= self._ages).all())
        return rospy.Time(*divmod(newest, 10**9)) if here else None

    def set_periods(self, periods, step):
        """Take in how long after each other robots' odometry comes, ``periods`` (n,) [s].

        ``step`` [s] of the world: the next of a robot has come before the period is over by half of it.
        """
        periods = np.asarray(periods)
        self._ages = ((periods - 0.5 * step) * 1e9).astype(np.int64)
        self._expected.begin((periods * 1e9).astype(np.int64))

    def take_repeated(self):
        """Return the rows whose odometry came again with the same stamp, and forget them."""
        with self._changed:
            taken, self._repeated = self._repeated, set()
        return sorted(taken)


class OdometryInbox(Inbox):
    """Subscribes to ``/robotN/odom`` of every robot, or to another topic of poses."""

    def __init__(
        self,
        numbers,
        bounds=None,
        real=(),
        timeout=TIMEOUT,
        topic="",
        kind=PlanarOdometry,
        frames=True,
    ):
        """``numbers``, ``bounds``, ``real``, ``timeout``: as of ``Inbox``.

        ``topic``: its pattern, ``{}`` for the robot's number, by default the parameter
        ``~odom_topic``; ``kind`` of message: PlanarOdometry or PoseStamped; ``frames``: whether it
        matters in which frame they are.
        """
        super().__init__(numbers, bounds, real, timeout)
        self.topic = topic or read(ODOM_TOPIC)
        odometry = kind is PlanarOdometry
        wanted = OdometryFrames(self._numbers) if odometry else SameFrame()
        farthest = FARTHEST_REAL if odometry else FARTHEST
        self.intake = Intake(self._real, timeout, wanted if frames else None, farthest)
        receiver = SharedReceiver()
        self._subscribers = [
            (subscribe if self._real[row] else receiver.subscribe)(
                self.topic.replace("{}", str(number)), kind, self.put, row
            )
            for row, number in enumerate(self._numbers)
        ]

    def put(self, message, row):
        """Keep the pose of robot ``row``; one that is not current or not possible is refused.

        What is refused is counted, and the robot grows stale.
        """
        if isinstance(message, PlanarOdometry):
            pose, stamp, body = message.planar, message.stamp, message.body
            z, lift = message.z, message.lift
            frame, length = message.frame, message.length
        else:
            pose, stamp, body = planar(message.pose), message.header.stamp, (0.0, 0.0, 0.0)
            z, lift = message.pose.position.z, lifted(message.pose)
            frame, length = message.header.frame_id, quaternion_length(message.pose)
        stamped, seconds = stamp.to_nsec(), stamp.to_sec()
        now = rospy.get_time() if self._real[row] else clock_at(seconds, self._timeout)
        arrival = time.monotonic()
        with self._changed:
            self.senders.note(row, message)
            intake = self.intake
            if not (
                intake.accepts_frame(row, frame)
                and intake.accepts_place(row, *pose[:2], length, z)
                and intake.accepts_twist(row, (*body, *lift[5:]))
                and intake.accepts_stamp(row, seconds, now, arrival)
            ):
                return
            if self._stamp[row] == stamped:
                self._repeated.add(row)
            self._expected.note(row, stamped)
            came = arrival if self._real[row] else min(now, seconds)
            self._stamp[row], self._received[row] = stamped, came
            other = self._real[row] and abs(now - seconds) > self._timeout
            self._true[row] = int(1e9 * now) if other else stamped
            self._body[row], self._lift[row] = body, lift
            self._note_change(row, (*pose, z, *body), arrival)
            self._tracks.take(row, pose, (arrival if self._real[row] else now, seconds), z)
            self._note_arrival((row,))

    def _note_change(self, row, said, arrival):
        if said != self._said.get(row):
            self._said[row], self.changed[row] = said, arrival

    def doubled(self):
        """Return ``{topic: [nodes]}`` of the robots' topics on which several nodes publish."""
        names = self.names()
        return {names[row]: nodes for row, nodes in self.senders.doubled().items()}

    def names(self):
        """Return the names of the robots' topics, remappings applied."""
        return [rospy.resolve_name(self.topic.replace("{}", str(n))) for n in self._numbers]


class TeamInbox(Inbox):
    """Subscribes to one topic with the odometry of all robots."""

    def __init__(self, numbers, bounds=None, real=(), timeout=TIMEOUT):
        """``numbers``, ``bounds``, ``real``, ``timeout``: as of ``Inbox``."""
        super().__init__(numbers, bounds, real, timeout)
        self._rows = {number: row for row, number in enumerate(self._numbers)}
        self.joints = None  # (n, k) [rad] of robots with arms, as last received
        self._age = Intake([False], timeout)  # one stamp holds for all
        self._subscriber = rospy.Subscriber(
            ODOMETRY, TeamOdometry, self.put, queue_size=1, tcp_nodelay=True
        )

    def put(self, message):
        """Keep the poses and joints of the team's robots; what is refused is counted, and grows stale."""
        try:
            numbers, poses, twists, spatial = read_odometry(message)
            joints = read_joints(message)
        except MessageError as error:
            self._refuse_all(str(error))
            return
        rows = np.array([self._rows.get(number, -1) for number in numbers], dtype=int)
        ours = rows >= 0
        poses, twists, rows = poses[ours], twists[ours], rows[ours]
        joints = np.zeros((len(rows), 0)) if joints is None else joints[ours]
        spatial = upright(poses[:, 2]) if spatial is None else spatial.of(ours)
        z = spatial.z
        finite = np.isfinite(np.column_stack([poses, z, joints])).all(axis=1)
        places = np.column_stack([poses[:, :2], z])
        good = finite & (np.abs(places) < FARTHEST).all(axis=1)
        speeds = np.column_stack([twists, spatial.twist])
        moves = np.isfinite(speeds).all(axis=1)
        stamp = message.header.stamp
        now = clock_at(stamp.to_sec(), self._timeout)
        with self._changed:
            self.senders.note(self._subscriber.resolved_name, message)
            for row in np.flatnonzero(~good).tolist():
                x, y, height = places[row].tolist()
                if self.intake.accepts_place(int(rows[row]), x, y, z=height):
                    self.intake.refuse(int(rows[row]), "its heading or a joint is not finite")
            for row in np.flatnonzero(good & ~moves).tolist():
                self.intake.accepts_twist(int(rows[row]), speeds[row])
            good &= moves
            rows, poses, z = rows[good], poses[good], z[good]
            if not self._age.accepts_stamp(0, stamp.to_sec(), now, time.monotonic()):
                for row in rows.tolist():
                    self.intake.refuse(row, self._age.reasons[0])
                return
            for row in rows.tolist() if self.intake.reasons else ():
                self.intake.reasons.pop(row, None)
            self._repeated.update(rows[self._stamp[rows] == stamp.to_nsec()].tolist())
            moved = (poses != self._tracks.pose[rows]).any(axis=1) | (z != self._z[rows])
            self.changed[rows[moved]] = time.monotonic()
            lift = z[:, np.newaxis], spatial.orientation[good], spatial.twist[good]
            self._body[rows], self._lift[rows] = twists[good], np.concatenate(lift, axis=1)
            self._expected.note_all(rows, stamp.to_nsec())
            came = self._times(min(now, stamp.to_sec()))[rows]
            self._stamp[rows], self._received[rows] = stamp.to_nsec(), came
            self._true[rows] = stamp.to_nsec()
            self._tracks.take_all(rows, poses, (now, stamp.to_sec()), z)
            self._keep_joints(rows, joints[good])
            self._note_arrival(rows.tolist())

    def _refuse_all(self, why):
        with self._changed:
            for row in range(len(self._numbers)):
                self.intake.refuse(row, why)

    def _keep_joints(self, rows, joints):
        """Keep the ``joints`` (m, k) of the robots ``rows``; NaN until those of a robot are known."""
        if not joints.shape[1]:
            return
        shape = len(self._numbers), joints.shape[1]
        known = self.joints is not None and self.joints.shape == shape
        result = self.joints.copy() if known else np.full(shape, np.nan)
        result[rows] = joints
        self.joints = result  # not in place: a law may be reading those of before

    def names(self):
        """Return the name of the topic, once for each robot."""
        return [self._subscriber.resolved_name] * len(self._numbers)


class OdometryFrames:
    """The frames in which robots publish odometry: those of ``~odom_frame``, else any "odom"."""

    def __init__(self, numbers):
        """``numbers``: the robots' numbers, which ``{}`` in the parameter stands for."""
        self._numbers = list(numbers)
        self._pattern = read(ODOM_FRAME).lstrip("/")

    def __call__(self, row, frame):
        """Return what frame was wanted of robot ``row`` instead of ``frame``, "" for a right one."""
        if not self._pattern:
            right = not frame or "odom" in frame.lower()  # many drivers leave it empty
            return "" if right else "one called odom, or another _odom_frame"
        wanted = self._pattern.replace("{}", str(self._numbers[row]))
        return "" if frame.lstrip("/") == wanted else repr(wanted)


class SameFrame:
    """The common frame of what localises the robots: whatever the first message says."""

    def __init__(self):
        self._frame = None

    def __call__(self, row, frame):
        """Return what frame was wanted instead of ``frame``, "" for the right one."""
        self._frame = frame if self._frame is None else self._frame
        return "" if frame == self._frame else "{} as before".format(shown(self._frame))


def planar(pose):
    """Return ``(x, y, theta)`` [m, m, rad] of a geometry_msgs/Pose."""
    turn = pose.orientation
    return pose.position.x, pose.position.y, yaw(turn.x, turn.y, turn.z, turn.w)


def lifted(pose):
    """Return what a geometry_msgs/Pose of a robot at rest has besides ``planar``: a ``lift``."""
    turn = pose.orientation
    return (pose.position.z, turn.x, turn.y, turn.z, turn.w, 0.0, 0.0, 0.0)


def quaternion_length(pose):
    """Return the length [-] of the rotation of a geometry_msgs/Pose, 1 for a right one."""
    turn = pose.orientation
    return math.sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w)


def silence(stale, what="odometry", reasons=None):
    """Return the text that names the robots in ``stale`` ``{number: age}``, "" if there is none.

    ``reasons`` ``{number: text}``: why their newest messages were refused.
    """
    if not stale:
        return ""

    def why(number, age):
        text = "never received" if age == np.inf else "{:.1f} s".format(age)
        reason = (reasons or {}).get(number)
        return text if reason is None else "{}, refused: {}".format(text, reason)

    shown = ", ".join(
        "robot{} ({})".format(number, why(number, age))
        for number, age in list(stale.items())[:MOST_NAMED]
    )
    more = ", and {} more".format(len(stale) - MOST_NAMED) if len(stale) > MOST_NAMED else ""
    return "no fresh {} of {}{}".format(what, shown, more)
