#!/usr/bin/env python3
"""What sensors cost: heard by nobody, heard by a law, and rays alone.

python3 benchmarks/sensors.py [--repeats N]
"""

import argparse
import time

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.obstacles import Box
from mrs_simulator.core.scenario import scenario_from_dict
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.study.experiment import Experiment
from mrs_simulator.vehicles import Team

NONE = [{"mounts": {"sonar": None}}]
LASER = [{"mounts": {"laser": {}}}]


class Idle(PioneerControl):
    """Stands, and asks for no sensor."""

    def pointMassLaw(self, hand):
        return 0.1 * (hand[::-1] - hand)


class Listens(Idle):
    """The same, with sonar and laser."""

    SENSORS = ("sonar", "laser")


def seconds(n, law, sensors, duration):
    """Return the CPU time [s] of a run of ``duration`` [s] of ``n`` robots among twenty boxes."""
    rng = np.random.default_rng(1)
    side = 4.0 * np.sqrt(n) + 10.0
    boxes = [
        {"type": "box", "center": (side + rng.uniform(0.0, side, 2)).tolist(), "size": [1.0, 0.5]}
        for _ in range(20)
    ]
    content = {"robots": n, "poses": {"layout": "grid", "spacing": 3.0}, "obstacles": boxes}
    scenario = scenario_from_dict(dict(content, duration=duration, sensors=sensors))
    experiment = Experiment(scenario, law)
    begun = time.process_time()
    for _ in experiment.samples():
        pass
    return time.process_time() - begun


def unheard(n, duration, repeats):
    """Return the ratio of runs with sonar and laser that nobody hears to runs without, and its spread."""
    ratios = []
    for k in range(repeats):
        pair = [LASER, NONE][:: 1 if k % 2 else -1]
        took = {id(sensors): seconds(n, Idle, sensors, duration) for sensors in pair}
        ratios.append(took[id(LASER)] / took[id(NONE)])
    return np.median(ratios), np.percentile(ratios, [25, 75])


def rays_per_second(n, k):
    """Return how many rays a second ``n`` robots with ``k`` rays each cast among twenty boxes."""
    rng = np.random.default_rng(1)
    boxes = [
        Box("box{}".format(i), *rng.uniform(-10.0, 10.0, 2), 0.3, 1.0, 0.5, 0.5) for i in range(20)
    ]
    poses = np.column_stack([rng.uniform(-10.0, 10.0, (n, 2)), rng.uniform(-3.0, 3.0, n)])
    shapes = Scenery(Team(("pioneer3dx",) * n), boxes).at(State(0.0, poses, 0.0 * poses))
    angle = poses[:, 2:] + np.linspace(-1.5, 1.5, k)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    rays = Rays(poses[:, np.newaxis, :2], direction, np.full(n, 0.17), np.arange(n))
    cast(shapes, rays, 8.0)
    begun, count = time.process_time(), 0
    while time.process_time() - begun < 0.5:
        cast(shapes, rays, 8.0)
        count += 1
    return count * n * k / (time.process_time() - begun)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    repeats = parser.parse_args().repeats
    for n, duration in ((7, 20.0), (100, 10.0)):
        ratio, (low, high) = unheard(n, duration, repeats)
        print(
            "{:4d} robots, unheard: {:.3f} ({:.3f} to {:.3f}) of a run without".format(
                n, ratio, low, high
            )
        )
    for n, duration in ((7, 10.0), (100, 2.0)):
        took = seconds(n, Listens, LASER, duration)
        print("{:4d} robots, sonar and laser: {:.0f} x real time".format(n, duration / took))
    for n, k in ((7, 16), (7, 181), (100, 16), (100, 181)):
        print("{:4d} x {:3d} rays: {:.2e} rays/s".format(n, k, rays_per_second(n, k)))


if __name__ == "__main__":
    main()
