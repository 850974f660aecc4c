#!/usr/bin/env python3
"""How fast robots in air and water go with forces: simulated seconds per second of one process.

    python3 benchmarks/vehicles.py [--quick] [--keep]

Medians of 3, by processor time.  Quadrotors, with rotors and controllers in substeps of 2 ms: the whole
world of those that hover; and recorded runs of 110 s from their start, under the law ``formation``; both
compiled, where numba is.  Vessels: the whole world, steps of 20 ms, a command at each, current, wind, gusts
and waves, collisions checked.  With ``--keep`` the figures go to benchmarks/history.csv.
"""

import argparse
import statistics
import time
from importlib.util import find_spec

import numpy as np
from headless import WHOLE, recorded_run_factor, scenario_of, use_compiled
from history import Report

from mrs_simulator.scenario.surroundings.environment import Environment
from mrs_simulator.scenario.team.layouts import make_layout
from mrs_simulator.world.world import EVERY, World

STEP = 0.02  # [s]
LEAST, REPEATS = 1.0, 3  # [s] of processor time of one measurement, at least
SIZES = (10, 100, 1000)
WEATHER = Environment((0.2, 0.1), (3.0, 1.0), 1.0, 2.0, 0.2, 4.0)


def real_time_factor(step, least):
    """Return simulated over processor time of calling ``step``, which simulates ``STEP``."""
    step()
    begin, steps = time.process_time(), 0
    while time.process_time() - begin < least:
        step()
        steps += 1
    return STEP * steps / (time.process_time() - begin)


def hovering(n):
    """Return a function that lets the whole world of n Crazyflies, 1 m apart, go on for a step."""
    poses = make_layout("grid", n, spacing=1.0)
    world = World(("crazyflie2",) * n, poses, fidelity="dynamic", step=STEP, z=np.ones(n))
    command = np.zeros((n, 4))

    def step():
        world.set_commands(EVERY, command)
        world.step()

    return step


def run_factor(n):
    """Return simulated over processor time of a recorded run of n Crazyflies, numba loaded."""
    flying = scenario_of(n, "dynamic", ("crazyflie2",))._replace(altitude=np.ones(n))
    factors = [
        recorded_run_factor(flying._replace(duration=WHOLE), time.process_time) for _ in range(2)
    ]
    return factors[1]  # the first loads


def vessels(n):
    """Return a function that lets n Herons sail for a step."""
    world = World(
        ("heron",) * n,
        make_layout("grid", n, spacing=12.0),
        fidelity="dynamic",
        step=STEP,
        environment=WEATHER,
    )
    command = np.random.default_rng(0).uniform(0.3, 0.5, (n, 2))  # circles that do not meet

    def step():
        world.set_commands(EVERY, command)
        world.step()

    return step


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one short measurement of each")
    parser.add_argument("--keep", action="store_true", help="append to benchmarks/history.csv")
    options = parser.parse_args()
    least, repeats = (0.2, 1) if options.quick else (LEAST, REPEATS)
    report = Report("vehicles", options.keep)
    use_compiled(bool(find_spec("numba")))
    for name, make in (("quadrotors in the world", hovering), ("vessels", vessels)):
        for n in SIZES:
            factor = statistics.median(real_time_factor(make(n), least) for _ in range(repeats))
            report.note(name + " with forces", n, factor, "x real time")
    for n in SIZES:
        factor = statistics.median(run_factor(n) for _ in range(repeats))
        report.note("a recorded run of quadrotors with forces", n, factor, "x real time")
    report.close()


if __name__ == "__main__":
    main()
