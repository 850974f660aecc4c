#!/usr/bin/env python3
"""What sensors cost: heard by nobody, heard by a law, rays and pictures alone.

python3 benchmarks/sensors.py [--repeats N]
"""

import argparse
import io
import os
import time

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.compiling import is_wanted
from mrs_simulator.core.obstacles import Box
from mrs_simulator.core.scenario import scenario_from_dict
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.study.experiment import Experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import World

NONE = [{"mounts": {"sonar": None}}]
LASER = [{"mounts": {"laser": {}}}]


class Idle(PioneerControl):
    """Stands, and asks for no sensor."""

    def pointMassLaw(self, hand):
        return 0.1 * (hand[::-1] - hand)


class Listens(Idle):
    """The same, with sonar and laser."""

    SENSORS = ("sonar", "laser")


def experiment(n, law, sensors, duration):
    """Return the ``Experiment`` of ``n`` robots among twenty boxes."""
    rng = np.random.default_rng(1)
    side = 4.0 * np.sqrt(n) + 10.0
    boxes = [
        {"type": "box", "center": (side + rng.uniform(0.0, side, 2)).tolist(), "size": [1.0, 0.5]}
        for _ in range(20)
    ]
    content = {"robots": n, "poses": {"layout": "grid", "spacing": 3.0}, "obstacles": boxes}
    return Experiment(scenario_from_dict(dict(content, duration=duration, sensors=sensors)), law)


def seconds(n, law, sensors, duration):
    """Return the CPU time [s] of a run of ``duration`` [s] of ``n`` robots among twenty boxes."""
    run = experiment(n, law, sensors, duration)
    begun = time.process_time()
    for _ in run.samples():
        pass
    return time.process_time() - begun


def unheard(n, duration, repeats):
    """Return the ratios of runs with sonar and laser that nobody hears to runs without, (repeats,).

    Both go on in turns, a tenth of a second of the world each, whose medians are compared: so other work on
    the machine slows both alike.
    """
    ratios = []
    for k in range(repeats):
        runs = [experiment(n, Idle, sensors, duration).samples() for sensors in (LASER, NONE)]
        took = [], []
        for turn in range(int(10 * duration)):
            for which in (0, 1) if (turn + k) % 2 else (1, 0):
                begun = time.process_time()
                next(runs[which])
                took[which].append(time.process_time() - begun)
        ratios.append(np.median(took[0]) / np.median(took[1]))
    return np.array(ratios)


def picture_seconds(width, height, count=5):
    """Return the CPU time [s] of a picture with its depth, of 7 robots in a circle, and of its messages.

    Messages, of picture, depth and intrinsics, are made and serialised; without ROS they take no time.
    """
    eye = {"type": "camera", "width": width, "height": height, "place": [0.25, 0.0, 0.4]}
    content = {"robots": 7, "poses": {"layout": "circle", "radius": 3.0}}
    scenario = scenario_from_dict(dict(content, sensors=[{"mounts": {"eye": eye}}]))
    world = World.from_scenario(scenario)
    suite = Suite.of_scenario(scenario, *world.senses)
    suite.listen({row: ["eye"] for row in range(7)})
    suite.update(0, world.sensed)
    begun = time.process_time()
    for step in range(10, 10 * (count + 1), 10):
        suite.update(step, world.sensed)
    seen = time.process_time()
    for _ in range(count):
        serialised(suite, world)
    return (seen - begun) / (7 * count), (time.process_time() - seen) / (7 * count)


def serialised(suite, world):
    """Return the bytes of the messages of picture, depth and intrinsics of each robot of a ``suite``."""
    try:
        from std_msgs.msg import Header

        from mrs_simulator.ros.sensor_forms.camera import Colours, Depths, Pinhole
    except ImportError:
        return []
    (sensor,), found = suite.active, []
    reading = sensor.known(world.time + 10.0)
    for form in (Colours, Depths, Pinhole):
        told = form(sensor.mount, world.kinds[0])
        for item in told.rows(reading):
            buffer = io.BytesIO()
            told.message(item, Header()).serialize(buffer)
            found.append(buffer.getvalue())
    return found


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
    print(
        "load {:.1f} on {} cores, compiled: {}".format(
            os.getloadavg()[0], os.cpu_count(), is_wanted()
        )
    )
    for n, duration in ((7, 60.0), (100, 30.0)):
        ratios = unheard(n, duration, repeats)
        text = "{:4d} robots, unheard: {:.3f} (quartiles {:.3f} to {:.3f}) of the CPU time without"
        print(text.format(n, np.median(ratios), *np.percentile(ratios, [25, 75])))
    seconds(7, Listens, LASER, 0.2)  # compiles, where that is wanted
    for n, duration in ((7, 10.0), (100, 2.0)):
        took, without = (seconds(n, *run, duration) for run in ((Listens, LASER), (Idle, NONE)))
        text = (
            "{:4d} robots, sonar and laser: {:.0f} x real time, {:.1f} times the CPU time without"
        )
        print(text.format(n, duration / took, took / without))
    for n, k in ((7, 16), (7, 181), (100, 16), (100, 181)):
        print("{:4d} x {:3d} rays: {:.2e} rays/s".format(n, k, rays_per_second(n, k)))
    for (width, height), rate in (((160, 120), 10.0), ((320, 240), 5.0)):
        seen, told = picture_seconds(width, height)
        text = "camera {} x {}: {:.1f} ms and {:.1f} ms for messages, 7 robots at {:g} Hz {:.2f} of a core"
        took = 7 * rate * (seen + told)
        print(text.format(width, height, 1e3 * seen, 1e3 * told, rate, took))


if __name__ == "__main__":
    main()
