"""Sources of a recorded run: the stage's states, or the topics of real robots."""

import math
import queue
import threading
import time

import numpy as np
import rospy

from mrs_simulator.core.kinematics import TWIST_AXES
from mrs_simulator.nodes.control.command_gate import command_topics
from mrs_simulator.nodes.control.common_frame import make_common_frame
from mrs_simulator.nodes.record.estimates_source import EstimatesSource
from mrs_simulator.record.missed_periods import MissedPeriods
from mrs_simulator.ros.message_forms.messages import (
    Collision,
    Incident,
    MessageError,
    StageStatus,
    TeamState,
    read_collision,
    read_incident,
    read_stage_status,
    read_state,
    run_of,
)
from mrs_simulator.ros.message_forms.planar_messages import QuickTwist
from mrs_simulator.state.columns import joint_count
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles.team import on_axes
from mrs_simulator.vehicles.team_in_space import team_of
from mrs_simulator.verdict.impossible_poses import jump

REPORT = 5.0  # [s] of wall time between two reports of what is refused


def make_source(scenario):
    """Return the stage in simulated time, else the real robots."""
    team = team_of(scenario)
    simulated = rospy.get_param("/use_sim_time", False)

    def make():
        return StageSource(team) if simulated else RobotsSource(scenario, team)

    return make() if scenario.estimates is None else EstimatesSource(make, scenario.n)


class StageSource:
    """Every state of the stage, until it begins another run: what comes then is no part of this one."""

    PACED = False  # whether samples come at the scenario's rate

    def __init__(self, team):
        """Listen to the stage of the robots of ``team``."""
        self._team, self._speeds = team, team.speeds[:, 0]
        self._newest, self._part, self._broken = None, None, ""  # since the run began
        self.collisions, self.incidents, self._closest = [], [], math.inf
        self._counting = self._lockstep = False
        self._missed = MissedPeriods()
        self._refused, self._refusal = 0, ""  # messages, and why the newest
        self._queue = queue.Queue()
        self._subscribers = [
            rospy.Subscriber("stage/state", TeamState, self._queue.put, tcp_nodelay=True),
            rospy.Subscriber("stage/collisions", Collision, self._on_collision),
            rospy.Subscriber("stage/incidents", Incident, self._on_incident),
            rospy.Subscriber("stage/status", StageStatus, self._on_status),
        ]

    def next(self, seconds):
        """Return the next ``StateTable``; None after ``seconds`` of wall time without any."""
        try:
            message = self._queue.get(timeout=seconds)
            return self._sample(read_state(message), run_of(message))
        except queue.Empty:
            return None
        except MessageError as error:
            self._refuse("state", error)
            return None

    def _sample(self, state, part):
        """Return ``state`` with the team's axes, None where the run is broken; ``MessageError``."""
        _refuse_infinite(state)
        part = (*part, len(state.pose))
        self._broken = self._broken or self._break(state, part)
        self._newest, self._part = state, part
        if self._broken:
            return None
        wanted = self._team.axes
        if self._team.has_arms or state.joints.ndim > 1 or not set(state.axes) <= set(TWIST_AXES):
            self._refuse_other_arms(state)
        return state.replace(axes=wanted, command=on_axes(state.command, state.axes, wanted))

    def _refuse_other_arms(self, state):
        """Raise ``MessageError`` unless ``state`` has the team's axes and joints."""
        found = state.axes, state.joints[0].size if len(state.pose) else 0
        wanted = self._team.axes, max(1, joint_count(self._team))
        if found != wanted:
            text = "axes {} and {} joints of each robot, wanted {} and {}"
            names = [", ".join(axes) for axes, _ in (found, wanted)]
            raise MessageError(text.format(names[0], found[1], names[1], wanted[1]))

    def _refuse(self, what, error):
        """Count a message that cannot be read, and report it."""
        self._refused += self._counting
        self._refusal = "{}: {}".format(what, error)
        rospy.logerr_throttle(REPORT, "record: stage/{} refused: {}".format(what, error))

    def _break(self, state, part):
        """Return why ``state`` is no part of the run, or ""."""
        if not self._counting:
            return ""
        if part[0] != self._part[0]:
            return "the stage was started again"
        if part[1:] != self._part[1:]:
            return "the stage was reset, or given another team"
        last, dt = self._newest, state.time - self._newest.time
        if dt < 0.0:
            return "simulated time went back"
        speeds = self._speeds if len(self._speeds) == len(state.pose) else math.inf
        found = jump(last.pose, state.pose, dt, speeds)
        if found:
            return "robot{} jumped by {:.2f} m within {:.3f} s".format(found[0] + 1, found[1], dt)
        return ""

    def begin(self):
        """Count from now on: the run has begun."""
        self._counting = True

    def broken(self):
        """Return why the run cannot go on, or ""."""
        return self._broken

    def silence(self):
        """Return what is silent, and why its newest message was refused."""
        return "the stage fell silent" + (self._refusal and ", refused: " + self._refusal)

    def warnings(self):
        """Return what is missing, a list of texts."""
        text = "{} messages of the stage are left out: {}"
        return [text.format(self._refused, self._refusal)] if self._refused else []

    def meta(self):
        """Return what else is known of the run."""
        facts = {"closest_approach": self._closest, "lockstep": self._lockstep}
        degraded = self._missed.text()
        return {**facts, "degraded": degraded} if degraded else facts

    def _on_collision(self, message):
        if self._counting:
            self.collisions.append(read_collision(message))

    def _on_incident(self, message):
        try:
            incident = read_incident(message)
        except MessageError as error:
            self._refuse("incidents", error)
            return
        if self._counting:
            self.incidents.append(incident)

    def _on_status(self, message):
        stage = read_stage_status(message)
        self._lockstep = stage.lockstep
        if self._counting and not self._broken:
            self._closest = min(self._closest, stage.closest_approach)
            self._missed.note(
                stage.stamp, stage.robots, stage.missed_periods, stage.command_periods
            )


def _refuse_infinite(state):
    """Raise ``MessageError`` where a number of ``state`` is not finite."""
    found = state.first_infinite()
    if found is not None:
        text = "column {} of robot{} is not finite"
        raise MessageError(text.format(found[0], state.robots[found[1]]))


class RobotsSource:
    """The newest pose and command of every real robot, at the scenario's rate in wall time.

    A robot that is silent leaves a gap: nothing is made up.  Drivers publish no steering angles: they are
    those to which the commands have led, as the control reckons them.
    """

    PACED = True
    collisions = incidents = ()

    def __init__(self, scenario, team):
        """Listen to the robots' odometry, and whatever else makes the common frame, and commands."""
        self._period, self._due = 1.0 / scenario.record_rate, time.monotonic()
        self._begun = False
        # Of each robot, (n,) [s], as its driver has it.
        given = scenario.cmd_vel_timeout
        self._watchdog = team.timeouts if given is None else np.full(scenario.n, given)
        self.frame = make_common_frame(scenario)
        self._lock = threading.Lock()
        self._team, self._joints = team, np.zeros(scenario.n)  # [rad]
        self._commanded = time.monotonic()  # up to when the joints have followed the commands
        self._columns = [TWIST_AXES.index(axis) for axis in team.axes]
        self._command = np.zeros((scenario.n, len(team.axes)))
        self._received_at = np.full(scenario.n, -math.inf)  # [s] of wall time
        self._subscribers = [
            rospy.Subscriber(
                name,
                QuickTwist,
                self._on_command,
                callback_args=row,
                queue_size=1,
                tcp_nodelay=True,
            )
            for row, name in enumerate(command_topics(self.frame.numbers))
        ]

    def next(self, seconds):
        """Return the ``StateTable`` that is due; None after ``seconds`` [s] or if a robot is silent."""
        wait = self._due - time.monotonic()
        if wait > 0.0:
            time.sleep(min(wait, seconds))
        if wait > seconds:
            return None
        self._due = max(self._due + self._period, time.monotonic())
        now = rospy.get_time()
        if not self._begun and self.frame.jumped():
            self.frame.accept()  # as the control does at its start
        if self.frame.missing(now):
            return None
        with self._lock:
            command, joints = self._in_force(), self._followed()
        # Zeros are also what a node says that has not begun or is stopped.
        frame = self.frame
        return StateTable(
            now,
            axes=self._team.axes,
            pose=frame.pose(),
            command=command,
            commanded=command.any(axis=1),
            real=np.full(len(command), True),
            joints=joints,
            twist=frame.twists(),
            spatial=frame.spatial() if self._team.is_spatial else None,
        )

    def _in_force(self):
        """Return the commands (n, a) that the robots follow now."""
        fresh = time.monotonic() - self._received_at <= self._watchdog
        return np.where(fresh[:, np.newaxis], self._command, 0.0)

    def _followed(self):
        """Return the joints (n,) [rad] after the commands up to now."""
        if self._team.has_joints:
            now = time.monotonic()
            elapsed, self._commanded = now - self._commanded, now
            self._joints = self._team.joints_after(self._in_force(), self._joints, elapsed)
        return self._joints

    def begin(self):
        """Break the run at a jump from now on; before, robots are followed wherever they are put."""
        self._begun = True

    def broken(self):
        """Return who jumped since the run began, and is no longer where the common frame says, or ""."""
        return "; ".join(self.frame.jump_texts().values())

    def silence(self):
        """Return which robots are silent."""
        return self.frame.missing(rospy.get_time())

    def warnings(self):
        """Return what is missing, a list of texts: gaps are in the run itself."""
        return []

    def meta(self):
        """Return what else is known of the run: collisions are not."""
        return {"collisions_unknown": True}

    def _on_command(self, message, row):
        with self._lock:
            self._followed()
            self._command[row] = np.nan_to_num(message.values)[self._columns]
            self._received_at[row] = time.monotonic()
