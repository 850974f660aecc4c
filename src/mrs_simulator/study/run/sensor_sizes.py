"""How much recorded sensors will take, stated before a run: by what they read where robots begin."""

import math

import numpy as np

from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite, of_robot
from mrs_simulator.sensors.types import TYPES

TURNS = 8  # [-] headings at which each robot looks around: it will not go on looking as it begins


def samples_at_start(scenario, team, obstacles, names):
    """Yield ``(mount, number, reading)`` of sensors ``names`` where robots of ``scenario`` begin.

    Each robot is turned to ``TURNS`` headings.  Types whose samples have one length are left out.
    """
    suite = Suite.of_scenario(scenario, team, obstacles)
    wanted = {
        row: [m.name for m in own if m.name in names and TYPES[m.type].VARIES]
        for row, own in enumerate(suite.mounts)
    }
    suite.activate({row: own for row, own in wanted.items() if own})
    for k in range(TURNS):
        pose = scenario.poses + [0.0, 0.0, 2.0 * math.pi * k / TURNS]
        state = State(0.0, pose, np.zeros_like(pose), z=scenario.altitude)
        suite.begin(k)
        for sensor in suite.update(k, lambda state=state: state):
            for row, number in enumerate((sensor.rows + 1).tolist()):
                yield sensor.mount, number, of_robot(sensor.newest, row)


def with_sizes(sensors, scenario, team, obstacles, lines):
    """Return ``sensors``, ``Recorded`` each, with the mean length of a sample as it is at the start.

    ``lines(sensor, number, time, reading)``: the lines of a reading.
    """
    named = {each.name: each for each in sensors}
    found, time = {}, round(0.5 * scenario.duration, 1) + 0.01  # with the digits that most have
    for mount, number, reading in samples_at_start(scenario, team, obstacles, named):
        text = lines(named[mount.name], number, time, reading)
        found.setdefault(mount.name, []).append(sum(map(len, text)))
    return [
        each._replace(sample=float(np.mean(found[each.name]))) if each.name in found else each
        for each in sensors
    ]
