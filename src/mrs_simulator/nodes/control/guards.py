"""The guards of the control node: fence, distances, speeds, standstill, from its parameters."""

import math

import numpy as np
import rospy

from mrs_simulator.core.guards import Standstill, Violations, limited, slowed
from mrs_simulator.nodes.real.real_robots import real_among
from mrs_simulator.ros.parameters import number_parameter, numbers_parameter, robots_parameter

PATIENCE = 2.0  # [s] for which a real robot may fail to move as it is told
STUCK = (
    "told to move at {:.2f} m/s, {:.2f} rad/s for {:g} s and has not: are its motors on, its "
    "wheels free, its driver connected?"
)


def speed_limits(n):
    """Return ``~v_max`` [m/s] and ``~omega_max`` [rad/s] of each robot, (n,), ``inf`` if not given."""
    return tuple(robots_parameter(name, n, math.inf) for name in ("~v_max", "~omega_max"))


def top_speeds(n):
    """Return the highest of these [m/s, rad/s], which no robot exceeds."""
    return tuple(float(each.max()) for each in speed_limits(n))


def slower(scenario):
    """Return ``scenario`` with its limits lowered to the highest speeds, so that the law knows them."""
    speeds = top_speeds(scenario.n)
    if speeds == (math.inf, math.inf):
        return scenario
    return scenario._replace(limits=limited(scenario.limits, *speeds))


def patience(n):
    """Return for how long [s] each of n robots may stand though it is told to move, (n,).

    ``~stuck_time`` for all, 0: for ever; by default ``PATIENCE`` for real robots and no bound for
    simulated ones, which obstacles may hold.
    """
    if rospy.get_param("~stuck_time", "") != "":
        time = number_parameter("~stuck_time", PATIENCE, low=0.0)
        return np.full(n, time or math.inf)
    result = np.full(n, math.inf)
    result[real_among(n)] = PATIENCE
    return result


class Guards(Violations):
    """Lets commands pass: slowed, and zero for robots that broke a bound."""

    def __init__(self, numbers, scope, dry_run=False):
        """``numbers``: the robots' numbers; ``scope`` of the scaling; in a dry run nobody moves."""
        super().__init__(
            numbers,
            numbers_parameter("~geofence", 4),
            number_parameter("~min_distance", 0.0, low=0.0),
        )
        n = len(self.numbers)
        self._speeds, self._scope = speed_limits(n), scope
        self._patience = np.full(n, math.inf) if dry_run else patience(n)
        self._standstill, self._passed = Standstill(self._patience), np.zeros((n, 2))

    @property
    def stopped(self):
        """Return the numbers of the robots that are stopped."""
        return [self.numbers[row] for row in sorted(self.reasons)]

    def _stuck(self, pose, now):
        return {
            row: STUCK.format(*self._passed[row], self._patience[row])
            for row in self._standstill.stuck(now, pose, self._passed)
        }

    def release(self, pose):
        """Let the robots go on whose cause is gone; whether they move, time will tell."""
        super().release(pose)
        self._standstill.forget()

    def passed(self, command, pose, now):
        """Return ``command`` (n, 2) as the guards let it pass at ``pose`` (n, 3) and ``now`` [s]."""
        for text in self.check(pose, self._stuck(pose, now)):
            rospy.logerr("pioneer_control: %s", text)
        command = slowed(command, *self._speeds, scope=self._scope)
        if self.reasons:
            command = command.copy()
            command[sorted(self.reasons)] = 0.0
        self._passed = command
        return command
