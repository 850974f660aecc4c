"""The guards of the control node: fence, distances, speeds, stalls, from its parameters."""

import math
import time

import numpy as np
import rospy

from mrs_simulator.control.guards import (
    Repetition,
    Standstill,
    Violations,
    limited,
    planar,
    slowed,
    speed_and_turn,
    stilled,
)
from mrs_simulator.control.stopping import Stopping, approaching, held_for, leaving
from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.nodes.real.real_robots import real_among
from mrs_simulator.ros.node.node_parameters import (
    DEADBAND,
    FROZEN_TIME,
    GEOFENCE,
    MIN_DISTANCE,
    OMEGA_MAX,
    STUCK_TIME,
    V_MAX,
)
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.odometry_rates import OF_KINDS

REPEATS = (
    "commanded to move at {:.2f} m/s, {:.2f} rad/s, and for {:g} s its odometry says the very same: is its "
    "link lost, its emergency button pressed?"
)
LEAVING = "would leave the geofence before it stands, at ({})"
NEARING = "would come within {:.2f} m of robot{} before it stands"
BEHIND = "would come within {:.2f} m of robot{} if that stopped now"
MOTORS_OFF = "its motors are off (motors_state): is its emergency button pressed?"
STUCK = (
    "commanded to move at {:.2f} m/s, {:.2f} rad/s for {:g} s and has not: are its motors on, its "
    "wheels free, its driver connected?"
)


def speed_limits(n):
    """Return ``~v_max`` [m/s] and ``~omega_max`` [rad/s] of each robot, (n,), ``inf`` if not given."""
    return tuple(read(parameter, math.inf, n) for parameter in (V_MAX, OMEGA_MAX))


def top_speeds(n):
    """Return the highest of these [m/s, rad/s], which no robot exceeds."""
    return tuple(float(each.max()) for each in speed_limits(n))


def slower(scenario):
    """Return ``scenario`` as the parameters have it, so that the law and its claims know them.

    Its limits are lowered to the highest speeds, and its dead band is that of ``~deadband``.
    """
    deadband = read(DEADBAND, scenario.control.deadband)
    scenario = scenario._replace(control=scenario.control._replace(deadband=deadband))
    speeds = top_speeds(scenario.n)
    if speeds == (math.inf, math.inf):
        return scenario
    return scenario._replace(limits=limited(scenario.limits, *speeds))


def stopping_team(scenario):
    """Return the ``Team`` by whose limits robots brake: real ones by their firmware's, always."""
    return Team.from_scenario(scenario, "firmware" if real_among(scenario.n) else scenario.limits)


def going_on(scenario, team, period):
    """Return for how long [s] robots go on until a zero acts, with odometry as the ``team`` sends it."""
    rate = scenario.odometry_rate
    slowest = min(kind.odometry_rate for kind in team.kinds)
    return held_for(period, slowest if rate in (None, OF_KINDS) else rate)


def patience(n, parameter):
    """Return for how long [s] each of n robots may stand though it is commanded to move, (n,).

    The ``parameter`` for all, 0: for ever; by default its own for real robots and no bound for simulated
    ones, which obstacles may hold.
    """
    if is_given(parameter):
        return np.full(n, read(parameter) or math.inf)
    result = np.full(n, math.inf)
    result[real_among(n)] = parameter.default
    return result


class Guards(Violations):
    """Lets commands pass: slowed, and zero for robots that broke a bound."""

    def __init__(self, numbers, scope, dry_run=False, axes=UNICYCLE_AXES, deadband=0.0, ahead=None):
        """``numbers``: the robots' numbers; ``scope`` of the scaling; in a dry run no robot moves.

        ``axes``: the columns of commands; ``deadband`` [m/s, rad/s] without a parameter; ``ahead``: the
        team and for how long it goes on until a zero acts [s]; None: bounds hold for poses alone.
        """
        super().__init__(numbers, read(GEOFENCE), read(MIN_DISTANCE))
        n = len(self.numbers)
        self._speeds, self._scope = speed_limits(n), scope
        self._deadband = read(DEADBAND, deadband)
        self._patience = np.full(n, math.inf) if dry_run else patience(n, STUCK_TIME)
        never = np.full(n, math.inf)
        self._frozen_time = never if dry_run else patience(n, FROZEN_TIME)
        self._standstill, self._passed = Standstill(self._patience), np.zeros((n, len(axes)))
        self._axes = axes
        bounded = self.fence is not None or self.min_distance > 0.0
        self._stopping = Stopping(*ahead) if ahead is not None and bounded else None
        self._repetition = Repetition(self._frozen_time)

    @property
    def stopped(self):
        """Return the numbers of the robots that are stopped."""
        return [self.numbers[row] for row in sorted(self.reasons)]

    def _stuck(self, pose, now, changed):
        """Return ``{row: text}`` of the robots that do not move as commanded."""
        commanded = planar(self._passed, self._axes)
        shown = speed_and_turn(self._passed, self._axes)
        stuck = {
            row: STUCK.format(*shown[row], self._patience[row])
            for row in self._standstill.stuck(now, pose, commanded)
        }
        # In wall time, as the drivers' silence is.
        frozen = self._repetition.frozen(time.monotonic(), changed, commanded)
        repeating = {row: REPEATS.format(*shown[row], self._frozen_time[row]) for row in frozen}
        return {**stuck, **repeating}

    def _soon(self, command, pose, now):
        """Return ``{row: text}`` of the robots that would break a bound before they stand."""
        if self._stopping is None:
            return {}
        if self.reasons:
            command = command.copy()
            command[sorted(self.reasons)] = 0.0
        found, courses = {}, self._stopping.courses(command, pose, now)
        for course in courses:
            for row, other, distance in approaching(course, self.min_distance, stands=True):
                found[row] = BEHIND.format(distance, self.numbers[other])
        for course in courses:
            for i, j, distance in approaching(course, self.min_distance):
                for row, other in ((i, j), (j, i)):
                    found[row] = NEARING.format(distance, self.numbers[other])
            for row, place in leaving(course, self.fence).items():
                found[row] = LEAVING.format(", ".join("{:.2f}".format(each) for each in place))
        return found

    def release(self, pose):
        """Let the robots go on whose cause is gone; whether they move is found out later."""
        super().release(pose)
        if self._stopping is not None:
            self._stopping.stand()
        self._standstill.forget()
        self._repetition.forget()

    def passed(self, command, pose, now, changed, motors_off=()):
        """Return ``command`` (n, a) as the guards let it pass at ``pose`` and ``now`` [s].

        ``pose`` (n, 3), or (n, 4) with heights; ``changed`` (n,) [s] of ``time.monotonic``: when each
        robot's odometry last said something else; ``motors_off``: rows of the robots that say that
        their motors are off.
        """
        command = slowed(command, *self._speeds, scope=self._scope, axes=self._axes)
        command = stilled(command, self._deadband)
        others = {**self._stuck(pose, now, changed), **dict.fromkeys(motors_off, MOTORS_OFF)}
        others = {**self._soon(command, pose, now), **others}
        for text in self.check(pose, others):
            rospy.logerr("pioneer_control: %s", text)
        if self.reasons:
            command = command.copy()
            command[sorted(self.reasons)] = 0.0
        if self._stopping is not None:
            self._stopping.note(command, now)
        self._passed = command
        return command
