#!/usr/bin/env python3
"""How fast experiments run headless: simulated seconds per second of one process, medians of 3.

    python3 benchmarks/headless.py [--quick] [--history FILE]

The world has no obstacles, steps of 20 ms, a command at each step, collisions checked.  Beside them
runs a fixed load, pybullet writing poses of massless bodies: figures of two machines, or of one
machine at two times, are compared as multiples of it.
"""

import argparse
import json
import math
import os
import statistics
import time

import numpy as np
import pybullet

from mrs_simulator import PioneerControl, load_scenario, make_twist
from mrs_simulator.control.library.formation import Formation
from mrs_simulator.core.scenario import Control, Scenario
from mrs_simulator.experiment import Experiment
from mrs_simulator.version import __version__

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WALL = 1.0  # [s] of one measurement, at least
REPEATS = 3


class ByHook(PioneerControl):
    """The paper's law as a researcher writes it: robot by robot, positions in, Twists out."""

    def calculateControlLaw(self, pos_map):
        k, T, l, c = 0.02, 0.1, self.l, 2.0
        last, twists = len(pos_map), {}
        cos, sin = math.cos, math.sin
        for i, p in pos_map.items():
            q = pos_map[min(i + 1, last)]
            ux = (
                -(k / T) * (p.x + l * cos(p.theta) - q.x - l * cos(q.theta) - c)
                if i < last
                else 0.0
            )
            uy = -(k / T) * (p.y + l * sin(p.theta) - q.y - l * sin(q.theta)) if i < last else 0.0
            v = cos(p.theta) * ux + sin(p.theta) * uy
            omega = (-sin(p.theta) * ux + cos(p.theta) * uy) / l
            twists[i] = make_twist(v, omega)
        return twists


def scenario_of(n, fidelity):
    """Return the paper's scenario for 7 robots, else n robots scattered about the line they form."""
    if n == 7:
        paper = load_scenario(os.path.join(ROOT, "scenarios", "paper.yaml"))
        return paper._replace(fidelity=fidelity, duration=1e6)
    draw = np.random.default_rng(0)
    poses = np.zeros((n, 3))
    poses[:, 0] = 3.0 * np.arange(n - 1, -1, -1)
    poses[:, 1] = draw.uniform(-5.0, 5.0, n)
    return Scenario(
        poses, ("pioneer3dx",) * n, fidelity=fidelity, limits="top", control=Control(), duration=1e6
    )


def real_time_factor(n, fidelity, protocol):
    """Return simulated over wall time of one experiment."""
    experiment = Experiment(scenario_of(n, fidelity), protocol)
    samples = experiment.samples()
    next(samples)
    begin, simulated = time.process_time(), experiment.world.time
    while time.process_time() - begin < WALL:
        next(samples)
    elapsed = time.process_time() - begin
    factor = (experiment.world.time - simulated) / elapsed
    experiment.world.close()
    return factor


def reference(n):
    """Return the factor at which pybullet alone writes n poses at each step of 20 ms."""
    client = pybullet.connect(pybullet.DIRECT)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.2] * 3, physicsClientId=client
    )
    bodies = [
        pybullet.createMultiBody(0, shape, basePosition=[3.0 * i, 0, 0], physicsClientId=client)
        for i in range(n)
    ]
    begin, steps = time.process_time(), 0
    while time.process_time() - begin < WALL:
        for i, body in enumerate(bodies):
            pybullet.resetBasePositionAndOrientation(
                body, [3.0 * i, 0.01 * steps, 0], [0, 0, 0, 1], physicsClientId=client
            )
        pybullet.stepSimulation(physicsClientId=client)
        steps += 1
    factor = 0.02 * steps / (time.process_time() - begin)
    pybullet.disconnect(client)
    return factor


CASES = (
    ("kinematic, by calculateControlLaw", "kinematic", ByHook, (7, 100, 1000)),
    ("kinematic, by arrays", "kinematic", Formation, (7, 100, 1000, 10000)),
    ("dynamic, by arrays", "dynamic", Formation, (7, 100)),
)


def main():
    """Print the table; append it to a history file if one is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one measurement instead of three")
    parser.add_argument("--history", help="JSON lines file to append to and to compare with")
    arguments = parser.parse_args()
    repeats = 1 if arguments.quick else REPEATS
    result = {"version": __version__, "time": time.strftime("%Y-%m-%dT%H:%M:%S"), "rtf": {}}
    base = {n: statistics.median(reference(n) for _ in range(repeats)) for n in (7, 100, 1000)}
    last = _last(arguments.history)
    print(
        "{:36} {:>6} {:>10} {:>14} {:>12}".format("case", "n", "RTF", "x reference", "x last time")
    )
    for n, factor in base.items():
        print("{:36} {:6d} {:10.2f}".format("reference: pybullet writes poses", n, factor))
    for name, fidelity, protocol, sizes in CASES:
        for n in sizes:
            factor = statistics.median(
                real_time_factor(n, fidelity, protocol) for _ in range(repeats)
            )
            relative = factor / base.get(n, base[1000] * 1000.0 / n)
            key = "{}, n={}".format(name, n)
            result["rtf"][key] = {"rtf": factor, "relative": relative}
            before = last.get("rtf", {}).get(key, {}).get("relative")
            change = "{:.2f}".format(relative / before) if before else "-"
            print("{:36} {:6d} {:10.2f} {:14.3f} {:>12}".format(name, n, factor, relative, change))
    if arguments.history:
        with open(arguments.history, "a", encoding="utf-8") as file:
            file.write(json.dumps(result) + "\n")


def _last(path):
    if not path or not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    return json.loads(lines[-1]) if lines else {}


if __name__ == "__main__":
    main()
