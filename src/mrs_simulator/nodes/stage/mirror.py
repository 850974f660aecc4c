"""Real robots mirrored in the stage's world as bodies at the poses of their odometry."""

import math

import numpy as np
import rospy

from mrs_simulator.nodes.control.common_frame import make_common_frame
from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.message_forms.messages import ControlStatus, read_control_status
from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry, QuickTwist
from mrs_simulator.ros.receive.withdrawal import withdraw
from mrs_simulator.scenario.scenario import FARTHEST

REST = (0.0, 0.0, 0.0)  # a body's twist


class Mirror(StagePart):
    """Where the real robots are, put by subscriber threads, taken by the main loop.

    Their poses are those of a control node's common frame.  One that jumped stays where it was until
    a person goes on: starts the controller, resets the stage or gives it a team.
    """

    def __init__(self, world, rows, scenario):
        """``rows``: those of the robots of ``scenario`` that are real, bodies of ``world``."""
        self._world, self.rows = world, frozenset(rows)
        self._twists = {}  # newest body twists by row
        self._running = False
        self.frame = None
        if rows:
            self.frame = make_common_frame(scenario, rows=sorted(rows))
            self._control = rospy.Subscriber(
                "pioneer_control/status", ControlStatus, self._on_control, queue_size=1
            )

    def put(self, message, row):
        """Keep how fast robot ``row`` moves."""
        if all(map(math.isfinite, message.body)):
            self._twists[row] = message.body

    def before_step(self):
        """Put the real robots of the world where they are; one that is silent or jumped at rest."""
        if self.frame is None:
            return
        lost, rows = {*self.silent(), *self.jumps()}, self.frame.rows
        twists = [REST if row in lost else self._twists.get(row, REST) for row in rows]
        poses = self.frame.pose()
        known = (np.abs(poses) <= FARTHEST).all(axis=1)  # nor NaN, before the first message
        self._world.place(np.array(rows)[known], poses[known], np.array(twists)[known])

    def idle(self):
        """Put the real robots where they are: they know no pause."""
        self.before_step()

    def silent(self):
        """Return the rows, ascending, of the real robots that were silent for longer than allowed."""
        stale = self.frame.stale(rospy.get_time()) if self.frame else []
        return [number - 1 for number in stale]

    def jumps(self):
        """Return ``{row: text}`` of the real robots that jumped and are no longer followed."""
        texts = self.frame.jump_texts() if self.frame else {}
        return {self.frame.rows[at]: text for at, text in texts.items()}

    def follow_team(self, scenario):
        """Follow all robots from where they are."""
        if self.frame:
            self.frame.begin_at(scenario.poses)
            self.frame.accept()

    def _on_control(self, status):
        running = read_control_status(status).running
        if running and not self._running:
            self.frame.accept()
        self._running = running


class RealTopics:
    """``/robotN/odom`` and ``/robotN/cmd_vel`` of a real robot: the stage listens to both."""

    # Time does not wait for a real robot.
    listened_to = commanded = True

    def __init__(self, row, inbox, mirror):
        """Commands go to ``inbox`` as those of other robots, to be shown; odometry to ``mirror``."""
        self._subscribers = [
            rospy.Subscriber(
                "/robot{}/{}".format(row + 1, topic),
                kind,
                put,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for topic, kind, put in (
                ("odom", PlanarOdometry, mirror.put),
                ("cmd_vel", QuickTwist, inbox.put),
            )
        ]

    def publish(self, stamp, pose, twist, lift=None, covariance=None):
        """Publish nothing: the robot does."""

    def close(self):
        """Withdraw both topics."""
        for subscriber in self._subscribers:
            withdraw(subscriber)
