"""Sources of a recorded run: the stage's states, or the topics of real robots."""

import math
import queue
import threading
import time
from typing import NamedTuple

import numpy as np
import rospy

from mrs_simulator.core.recording import Collision as RunCollision
from mrs_simulator.msg import Collision, StageStatus, TeamState
from mrs_simulator.nodes.control.command_gate import command_topics
from mrs_simulator.nodes.control.common_frame import make_common_frame
from mrs_simulator.ros.planar_messages import PlanarTwist


class Sample(NamedTuple):
    """What all robots do at one time."""

    stamp: float  # [s]
    pose: np.ndarray  # (n, 3) [m, m, rad], common frame
    command: np.ndarray  # (n, 2) [m/s, rad/s], in force from the stamp on
    commanded: bool  # whether any robot is


def make_source(scenario):
    """Return the stage in simulated time, else the real robots."""
    return StageSource() if rospy.get_param("/use_sim_time", False) else RobotsSource(scenario)


class StageSource:
    """Every state of the stage."""

    PACED = False  # whether samples come at the scenario's rate

    def __init__(self):
        """Listen to the stage."""
        self.collisions, self._closest = [], math.inf
        self._counting = self._lockstep = False
        self._queue = queue.Queue()
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._queue.put, tcp_nodelay=True),
            rospy.Subscriber("stage/collisions", Collision, self._on_collision),
            rospy.Subscriber("stage/status", StageStatus, self._on_status),
        ]

    def next(self, seconds):
        """Return the next ``Sample``; None after ``seconds`` of wall time without any."""
        try:
            state = self._queue.get(timeout=seconds)
        except queue.Empty:
            return None
        return Sample(
            state.header.stamp.to_sec(),
            np.array([state.x, state.y, state.theta]).T,
            np.array([state.command_v, state.command_omega]).T,
            any(state.commanded),
        )

    def begin(self):
        """Count from now on: the run has begun."""
        self._counting = True

    def broken(self):
        """Return why the run cannot go on, or ""."""
        return ""

    def silence(self):
        """Return who it is that says nothing."""
        return "the stage fell silent"

    def meta(self):
        """Return what else is known of the run."""
        return {"closest_approach": self._closest, "lockstep": self._lockstep}

    def _on_collision(self, message):
        if self._counting:
            stamp = message.header.stamp.to_sec()
            self.collisions.append(
                RunCollision(stamp, message.first, message.second, message.x, message.y)
            )

    def _on_status(self, message):
        self._lockstep = message.lockstep
        if self._counting:
            self._closest = min(self._closest, message.closest_approach)


class RobotsSource:
    """The newest pose and command of every real robot, at the scenario's rate in wall time.

    A robot that was not heard of late leaves a gap: nothing is made up.
    """

    PACED = True
    collisions = ()

    def __init__(self, scenario):
        """Listen to the robots' odometry, and whatever else makes the common frame, and commands."""
        self._period, self._due = 1.0 / scenario.record_rate, time.monotonic()
        self._watchdog = scenario.cmd_vel_timeout
        self._frame = make_common_frame(scenario)
        self._lock = threading.Lock()
        self._command = np.zeros((scenario.n, 2))
        self._told = np.full(scenario.n, -math.inf)  # [s] of wall time
        self._subscribers = [
            rospy.Subscriber(
                name,
                PlanarTwist,
                self._on_command,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for row, name in enumerate(command_topics(self._frame.numbers))
        ]

    def next(self, seconds):
        """Return the ``Sample`` that is due; None after ``seconds`` of wall time or if one is silent."""
        wait = self._due - time.monotonic()
        if wait > 0.0:
            time.sleep(min(wait, seconds))
        if wait > seconds:
            return None
        self._due = max(self._due + self._period, time.monotonic())
        now = rospy.get_time()
        if self._frame.missing(now):
            return None
        with self._lock:
            fresh = time.monotonic() - self._told <= self._watchdog
            command = np.where(fresh[:, np.newaxis], self._command, 0.0)
        # Zeros are also what a node says that has not begun or is stopped.
        return Sample(now, self._frame.pose(), command, bool(command.any()))

    def begin(self):
        """Nothing was counted before."""

    def broken(self):
        """Return who jumped and is no longer where the common frame says, or ""."""
        return "; ".join(self._frame.jump_texts().values())

    def silence(self):
        """Return who it is that says nothing."""
        return self._frame.missing(rospy.get_time())

    def meta(self):
        """Return what else is known of the run: collisions are not."""
        return {"collisions_unknown": True}

    def _on_command(self, message, row):
        with self._lock:
            self._command[row] = np.nan_to_num(message.command)
            self._told[row] = time.monotonic()
