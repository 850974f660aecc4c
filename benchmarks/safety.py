#!/usr/bin/env python3
"""How long one call of the safety filter takes: 50 robots that cross, and 50 that crowd into one place.

    python3 benchmarks/safety.py [--robots N]
    python3 benchmarks/safety.py --ring N [N ...] [--keep]

With ``--ring``: the processor time of 30 s in which N Pioneers with ramps cross a ring, 1.5 m apart at
first, with the filter and without, where they push each other in its middle; the least of five runs each,
by turns: those after numba was loaded, where it is installed.  ``--keep``: into benchmarks/history.csv.

Each robot is 0.3 m in radius and wants the other side of a circle, or the middle of a square.  A call
has to fit the command period: 20 ms at 50 Hz.
"""

import argparse
import time

import numpy as np
from history import Report

from mrs_simulator import PioneerControl
from mrs_simulator.control.safety.nearest_velocities import safe_velocities
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment

PERIOD = 0.02  # [s]
DISTANCE = 0.8  # [m] between hand points
FASTEST = 0.75  # [m/s]
STEPS = 500
SECONDS = 30.0  # [s] of a run
RATE = 20.0  # [Hz] of its commands
RUNS = 5


def circle(n):
    """Return n points on a circle, 1.5 m apart, and the opposite ones, (n, 2) [m] each."""
    angle = 2.0 * np.pi * np.arange(n) / n
    points = 1.5 * n / (2.0 * np.pi) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return points, -points


def square(n):
    """Return n points of a grid, 1.5 m apart, and their middle, (n, 2) [m] each."""
    side = int(np.ceil(np.sqrt(n)))
    points = 1.5 * np.stack([np.arange(n) // side, np.arange(n) % side], axis=1).astype(float)
    return points, np.repeat(points.mean(axis=0)[np.newaxis], n, axis=0)


def calls(points, goals):
    """Return how long each of ``STEPS`` calls took, (STEPS,) [ms], on the way to ``goals``."""
    taken = []
    for _ in range(STEPS):
        away = goals - points
        size = np.linalg.norm(away, axis=1, keepdims=True)
        wanted = 2.0 * away * np.minimum(1.0, FASTEST / np.maximum(2.0 * size, 1e-9))
        begin = time.perf_counter()
        velocity = safe_velocities(wanted, points, DISTANCE, PERIOD)
        taken.append(1e3 * (time.perf_counter() - begin))
        points = points + PERIOD * velocity
    return np.array(taken)


def processor_time(n, safety):
    """Return the processor time [s] of one run of n Pioneers that cross a ring, ``safety`` or not."""
    points, goals = circle(n)
    heading = np.arctan2(*(goals - points).T[::-1])

    class Cross(PioneerControl):
        def pointMassLaw(self, hand):
            return 0.3 * (goals - hand)

    scenario = scenario_from_dict(
        {
            "robots": n,
            "poses": np.column_stack([points, heading]).tolist(),
            "limits": "firmware",
            "duration": SECONDS,
            "control": {"rate": RATE, "safety": safety},
        }
    )
    experiment = Experiment(scenario, Cross)
    begin = time.process_time()
    for _ in experiment.samples():
        pass
    spent = time.process_time() - begin
    experiment.world.close()
    return spent


def rings(sizes, keep):
    """Print the processor times of runs with and without the filter, and ``keep`` them."""
    report = Report("safety", keep)
    for n in sizes:
        turns = [[processor_time(n, safety) for safety in (True, False)] for _ in range(RUNS)]
        own, free = map(min, zip(*turns))
        report.note("with the filter", n, own, "s")
        report.note("without the filter", n, free, "s")
        report.note("with over without", n, own / free, "x")
    report.close()


def main():
    """Print median, 95th percentile and longest of the calls, or the times of runs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=50, metavar="N")
    parser.add_argument("--ring", type=int, nargs="+", metavar="N")
    parser.add_argument("--keep", action="store_true", help="append those of rings to the history")
    arguments = parser.parse_args()
    if arguments.ring:
        rings(arguments.ring, arguments.keep)
        return
    n = arguments.robots
    print("{:24} {:>6} {:>12} {:>10} {:>10}".format("case", "n", "median [ms]", "95 %", "longest"))
    for name, (points, goals) in (("crossing", circle(n)), ("crowding", square(n))):
        taken = calls(points, goals)
        row = (np.median(taken), np.percentile(taken, 95), taken.max())
        print("{:24} {:6d} {:12.2f} {:10.2f} {:10.2f}".format(name, n, *row))


if __name__ == "__main__":
    main()
