"""Readings received of sensors, and the sensors that a robot has.  No Qt, no ROS."""

import math
from typing import Any, NamedTuple

from mrs_simulator.sensors.mounts import fitted_mounts, spare_mounts
from mrs_simulator.vehicles import Team

MISSED, LEAST = 2.5, 0.5  # [-] periods, [s]: after the longer of them a reading is stale


class ReceivedReading(NamedTuple):
    """The newest reading of one sensor of one robot."""

    reading: Any = None  # None before the first
    age: float = math.inf  # [s] of simulated time, of a real robot of wall time
    rate: float = math.nan  # [Hz] by the stamps of the last readings
    topic: str = ""  # "" while it is not published
    trouble: str = ""  # why the newest message was refused

    def is_stale(self, mount):
        """Return whether the reading is older than the sensor's rate and latency allow."""
        return not self.age <= mount.latency + max(LEAST, MISSED / mount.rate)


def mounts_of(scenario):
    """Return ``{(number, name): (Mount, Kind)}`` of the sensors of the robots of ``scenario``.

    Raises ``ScenarioError`` for impossible sensors.
    """
    team = Team.from_scenario(scenario)
    mounts = fitted_mounts(team, scenario.sensors)
    return {
        (row + 1, mount.name): (mount, team.kinds[row])
        for row, own in enumerate(mounts)
        for mount in own
    }


def spare_mounts_of(scenario, number):
    """Return ``{(number, name): (Mount, Kind)}`` of the robot's sensors that the scenario does not use.

    Its kind has mounts for them, so a real robot's driver may publish them.
    """
    kind = Team.from_scenario(scenario).kinds[number - 1]
    return {(number, mount.name): (mount, kind) for mount in spare_mounts(kind)}
