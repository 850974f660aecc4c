#!/usr/bin/env python3
"""What a team of several kinds or drives costs, as a multiple of one of the default kind.

    python3 benchmarks/mixed_teams.py [--robots N] [--rounds N] [--keep]

Headless, kinematic, the paper's law by arrays, steps of 20 ms with a command at each, limits and
collisions as a scenario has them, nothing recorded.  The teams take turns, some milliseconds each, so
that all of them meet the same machine; a share is the median over the rounds of the ratio of the team's
real-time factor to that of the default kind alone, by processor time and by wall time.  Wanted: 0.8 for
four kinds of one drive, 0.4 for three drives.
"""

import argparse
import statistics
import time
from typing import NamedTuple

from headless import scenario_of, use_compiled
from history import Report

from mrs_simulator.protocols.formation.law import Formation
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.study.run.experiment import Experiment

ALONE = "the default kind"
TEAMS = {  # kinds by turns
    ALONE: (DEFAULT_KIND,),
    "four kinds of one drive": (DEFAULT_KIND, "pioneer3at", "amigobot", "turtlebot3_burger"),
    "three drives": (DEFAULT_KIND, "robotino3", "f1tenth"),
    "omnidirectional alone": ("robotino3",),
    "cars alone": ("f1tenth",),
}
SAMPLES = 8  # [-] recorded samples, 0.1 s each, of one team's turn


class Turn(NamedTuple):
    """What a turn of one team took per simulated second, [s]."""

    cpu: float
    wall: float


def begin(kinds, n):
    """Return the experiment of n robots and its samples, past the first."""
    experiment = Experiment(scenario_of(n, "kinematic", kinds), Formation)
    samples = experiment.samples()
    for _ in range(SAMPLES):
        next(samples)
    return experiment, samples


def turn(experiment, samples):
    """Return the ``Turn`` of some more samples."""
    simulated, cpu, wall = experiment.world.time, time.process_time(), time.perf_counter()
    for _ in range(SAMPLES):
        next(samples)
    simulated = experiment.world.time - simulated
    return Turn((time.process_time() - cpu) / simulated, (time.perf_counter() - wall) / simulated)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=100, metavar="N")
    parser.add_argument("--rounds", type=int, default=150, metavar="N")
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    arguments = parser.parse_args()
    use_compiled(False)  # one drive alone could be
    n, report = arguments.robots, Report("mixed teams", arguments.keep)
    runs = {name: begin(kinds, n) for name, kinds in TEAMS.items()}
    turns = {name: [] for name in runs}
    for _ in range(arguments.rounds):
        for name, run in runs.items():
            turns[name].append(turn(*run))
    for name, took in turns.items():
        factor = 1.0 / statistics.median(each.cpu for each in took)
        report.note(name, n, factor, "x real time")
        for how in Turn._fields if name != ALONE else ():
            pairs = zip(turns[ALONE], took)
            share = statistics.median(getattr(a, how) / getattr(b, how) for a, b in pairs)
            report.note("{}, share by {} time".format(name, how), n, share, "-")
    report.close()


if __name__ == "__main__":
    main()
