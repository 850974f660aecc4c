"""What was heard of a sensor, and which sensors there are to be heard.  No Qt, no ROS."""

import math
from typing import Any, NamedTuple

from mrs_simulator.sensors.mounts import fitted_mounts, spare_mounts
from mrs_simulator.vehicles import Team

MISSED, LEAST = 2.5, 0.5  # [-] periods, [s]: without a reading for longer, a sensor is stale


class Heard(NamedTuple):
    """The newest reading of one sensor of one robot."""

    reading: Any = None  # None before the first
    age: float = math.inf  # [s] of simulated time, of a real robot of wall time
    rate: float = math.nan  # [Hz] by the stamps of the last readings
    topic: str = ""  # "" while nobody publishes it
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


def spares_of(scenario, number):
    """Return ``{(number, name): (Mount, Kind)}`` of sensors that the robot ``number`` may have besides.

    Its kind has places for them, and the scenario does not fit them: a real robot's driver may tell them.
    """
    kind = Team.from_scenario(scenario).kinds[number - 1]
    return {(number, mount.name): (mount, kind) for mount in spare_mounts(kind)}
