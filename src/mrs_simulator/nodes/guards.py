"""The guards of the control node: fence, distances and speeds, from its parameters."""

import math

import rospy

from mrs_simulator.core.guards import Violations, limited, slowed
from mrs_simulator.nodes.parameters import number_parameter, numbers_parameter
from mrs_simulator.world.robots import limits_of_team


def speed_limits():
    """Return the parameters ``~v_max`` [m/s] and ``~omega_max`` [rad/s], ``inf`` if not given."""
    return tuple(
        math.inf if rospy.get_param(name, "") == "" else number_parameter(name, math.inf, above=0.0)
        for name in ("~v_max", "~omega_max")
    )


def slower(scenario):
    """Return ``scenario`` with its limits lowered to the parameters, so that the law knows them."""
    speeds = speed_limits()
    if speeds == (math.inf, math.inf):
        return scenario
    limits = limits_of_team(scenario.kinds, scenario.limits)
    return scenario._replace(limits=limited(limits, *speeds))


class Guards(Violations):
    """Lets commands pass: slowed, and zero for robots that broke a bound."""

    def __init__(self, numbers, scope):
        """``numbers``: the robots' numbers; ``scope`` of the scaling."""
        super().__init__(
            numbers,
            numbers_parameter("~geofence", 4),
            number_parameter("~min_distance", 0.0, low=0.0),
        )
        self._speeds, self._scope = speed_limits(), scope

    @property
    def stopped(self):
        """Return the numbers of the robots that are stopped."""
        return [self.numbers[row] for row in sorted(self.reasons)]

    def passed(self, command, pose):
        """Return ``command`` (n, 2) as the guards let it pass at ``pose`` (n, 3)."""
        for text in self.check(pose):
            rospy.logerr("pioneer_control: %s", text)
        command = slowed(command, *self._speeds, scope=self._scope)
        if self.reasons:
            command = command.copy()
            command[sorted(self.reasons)] = 0.0
        return command
