#!/usr/bin/env python3
"""How fast experiments run headless: simulated seconds per second of one process, medians of 3.

    python3 benchmarks/headless.py [--quick] [--keep]

The world has no obstacles but where lasers see them, steps of 20 ms, a command at each step, collisions
checked, watchdogs on, all recorded at 10 Hz to run.csv, by orjson where it is installed.  "From its start":
by wall time, 110 s of fewer than 10,000 robots, 5 s of so many; with pybullet for a second.  In the crowd
robots touch all the time.  With ``--keep`` the figures go to benchmarks/history.csv.
"""

import argparse
import contextlib
import functools
import itertools
import math
import os
import statistics
import tempfile
import time
import tracemalloc
from importlib.util import find_spec

import numpy as np
from history import Report

from mrs_simulator import PioneerControl, load_scenario, make_twist
from mrs_simulator.core import edge_terms
from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.record.recording import Recorder
from mrs_simulator.scenario.scenario import DEFAULT_KIND, Control, Scenario, scenario_from_dict
from mrs_simulator.scenario.team.layouts import make_layout
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.world.world import EVERY, World

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WALL = 1.0  # [s] of one measurement with pybullet
REPEATS = 3
WHOLE, FEW, MANY = 110.0, 5.0, 10000  # [s] of a run from its start, of one of so many robots


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


def scenario_of(n, fidelity, kinds=()):
    """Return the paper's scenario for 7 robots, else n robots scattered about the line they form.

    ``kinds``: those of the robots by turns, by default one.
    """
    if n == 7 and not kinds:
        paper = load_scenario(os.path.join(ROOT, "scenarios", "paper.yaml"))
        return paper._replace(fidelity=fidelity, duration=1e6)
    draw = np.random.default_rng(0)
    poses = np.zeros((n, 3))
    poses[:, 0] = 3.0 * np.arange(n - 1, -1, -1)
    poses[:, 1] = draw.uniform(-5.0, 5.0, n)
    kinds = tuple(itertools.islice(itertools.cycle(kinds or (DEFAULT_KIND,)), n))
    return Scenario(poses, kinds, fidelity=fidelity, limits="top", control=Control(), duration=1e6)


def pybullet_factor(n):
    """Return simulated over wall time of a recorded run with forces by pybullet, over ``WALL``."""
    experiment = Experiment(scenario_of(n, "dynamic"), Formation)
    with contextlib.ExitStack() as stack:
        stack.callback(experiment.world.close)
        samples = experiment.record(recorder_of(experiment, stack))
        next(samples)  # whatever is loaded is so by then
        begin, simulated = time.perf_counter(), experiment.world.time
        while time.perf_counter() - begin < WALL:
            next(samples)
        return (experiment.world.time - simulated) / (time.perf_counter() - begin)


class RandomWalk(PioneerControl):
    """Each robot's point moves at a velocity that is drawn anew each second, as arrays."""

    def start(self):
        self.draw, self.until = np.random.default_rng(0), 0.0

    def pointMassLaw(self, hand):
        if self.time >= self.until:
            self.u, self.until = self.draw.uniform(-1.0, 1.0, hand.shape), self.until + 1.0
        return self.u


class Looks(PioneerControl):
    """Robots drive in circles of half a metre; one stands while it sees something nearer than that."""

    SENSORS = ("laser",)

    def start(self):
        self.seen = None

    def pointMassLaw(self, hand):
        if self.readings is not self.seen:
            self.seen = self.readings
            scans = [self.readings[number].laser.ranges for number in self.numbers]
            self.speed = np.where(np.array(scans).min(axis=1) < 0.5, 0.0, 0.2)
        angle = 0.4 * self.time
        return self.speed[:, np.newaxis] * [math.cos(angle), math.sin(angle)]


def lasers_of(n):
    """Return the scenario of n robots 3 m apart among 20 boxes, with lasers all around of 10 m range."""
    side, draw = math.ceil(math.sqrt(n)), np.random.default_rng(1)
    places = 3.0 * np.array(list(itertools.product(range(side + 2), repeat=2))) - 1.5
    boxes = [
        {"type": "box", "center": place, "size": [1.0, 0.5], "yaw": draw.uniform(-3.0, 3.0)}
        for place in draw.permutation(places)[:20].tolist()
    ]
    poses = [[3.0 * (k % side), 3.0 * (k // side), 0.0] for k in range(n)]
    laser = {"type": "laser", "rays": 360, "angles": ["-180 deg", "179 deg"], "range": [0.1, 10.0]}
    laser.update(rate=10.0, place=[0.0, 0.0, 0.2], noise={"stddev": "1 cm"})  # robots are seen
    content = {"poses": poses, "obstacles": boxes, "sensors": [{"mounts": {"laser": laser}}]}
    return scenario_from_dict(dict(content, limits="top"))


def crowd_of(n):
    """Return the scenario of n robots 0.8 m apart."""
    poses, kinds = make_layout("grid", n, spacing=0.8), (DEFAULT_KIND,) * n
    return Scenario(poses, kinds, limits="top", control=Control(), duration=WHOLE)


def whole_run_factor(n, compiled, scenario, law=Formation):
    """Return simulated over wall time of 110 s from the start, robots moving, recorded as a user's.

    ``scenario``: as a function of n.  What the command takes to import, and numba to load, is not counted.
    """
    use_compiled(compiled)
    scenario = scenario(n)._replace(duration=WHOLE if n < MANY else FEW)
    recorded_run_factor(scenario._replace(duration=1.0), law=law)  # loads
    return recorded_run_factor(scenario, law=law)


def recorded_run_factor(scenario, clock=time.perf_counter, law=Formation):
    """Return simulated over wall time, or that of another ``clock``, of one recorded run."""
    experiment = Experiment(scenario, law)
    with contextlib.ExitStack() as stack:
        stack.callback(experiment.world.close)
        begin = clock()
        for _ in experiment.record(recorder_of(experiment, stack)):
            pass
        elapsed = clock() - begin
    return scenario.duration / elapsed


def recorder_of(experiment, stack):
    """Return the recorder of a run.csv that is removed when ``stack`` is left."""
    folder = stack.enter_context(tempfile.TemporaryDirectory())
    path = os.path.join(folder, "run.csv")
    numbers, layout = experiment.control.numbers, experiment.layout
    return stack.enter_context(Recorder(path, numbers, layout=layout))


def memory_per_robot(n):
    """Return what the world holds and what its steps leave behind, [bytes] per robot."""
    poses, kinds = make_layout("grid", n, spacing=0.8), ("pioneer3dx",) * n
    tracemalloc.start()
    world = World(kinds, poses, limits="top")
    command = np.full((n, 2), 0.2)
    _run(world, command, 100)
    held = tracemalloc.get_traced_memory()[0]
    _run(world, command, 200)
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return held / n, (after - held) / n


def _run(world, command, steps):
    for _ in range(steps):
        world.set_commands(EVERY, command)
        world.step()


def use_compiled(wanted):
    """Let what is made from here on be compiled, or not."""
    os.environ[COMPILED] = str(int(wanted))
    edge_terms.compiled.cache_clear()


RUNS = (  # from their start: the scenario, the law, sizes
    (
        "a law robot by robot",
        functools.partial(scenario_of, fidelity="kinematic"),
        ByHook,
        (7, 100, 1000, MANY),
    ),
    (
        "a run",
        functools.partial(scenario_of, fidelity="kinematic"),
        Formation,
        (7, 100, 1000, MANY),
    ),
    ("a crowd", crowd_of, RandomWalk, (100, 1000, MANY)),
    ("a law that reads lasers", lasers_of, Looks, (7, 100)),
    (
        "the fast engine",
        lambda n: scenario_of(n, "dynamic")._replace(engine="planar"),
        Formation,
        (7, 100, 1000),
    ),
)
COMPILED = "MRS_SIMULATOR_COMPILED"


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one measurement instead of three")
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    arguments = parser.parse_args()
    repeats = 1 if arguments.quick else REPEATS
    report = Report("headless", arguments.keep)

    def note(case, n, measure, *how):
        value = statistics.median(measure(n, *how) for _ in range(repeats))
        return report.note(case, n, value, "x real time")

    use_compiled(False)
    for n in (7, 100):
        case = "dynamic, by arrays, recorded, by wall time"
        note(case, n, pybullet_factor)
    for (run, scenario, law, sizes), compiled in itertools.product(RUNS, (False, True)):
        for n in sizes if compiled <= bool(find_spec("numba")) else ():
            case = run + " from its start, recorded" + ", compiled" * compiled
            note(case, n, whole_run_factor, compiled, scenario, law)
    use_compiled(False)
    held, left = memory_per_robot(10000)
    report.note("memory of the world per robot", 10000, held, "bytes")
    report.note("memory left behind by 200 steps per robot", 10000, max(left, 0.0), "bytes")
    report.close()


if __name__ == "__main__":
    main()
