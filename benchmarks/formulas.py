#!/usr/bin/env python3
"""What it costs to evaluate a requirement: whole formulas of one operator over many samples.

    python3 benchmarks/formulas.py                 # 5,501 samples: 110 s at 50 Hz
    python3 benchmarks/formulas.py --samples 50001 --most 20

Processor time [ms], the median of ``REPEATS``: robustness, what decides it and when.  Exits with 1 where
a formula takes more than ``--most`` [ms].
"""

import argparse
import statistics
import sys
import time

import numpy as np

from mrs_simulator.core.temporal_logic.robustness import Signal, evaluate
from mrs_simulator.core.temporal_logic.syntax import parse

PERIOD, REPEATS = 0.02, 50  # [s], [-]
FORMULAS = (
    "error > 0.1 m",
    "always (error > -90 m)",
    "always[0, 20] (error > 0.1 m)",
    "eventually[5, 20] (error > 3 m)",
    "(error > -9 m) until (speed > 0.1 m)",
    "(error > -9 m) until[0, 10] (speed > 0.1 m)",
    "(error > -9 m) until[3, 20] (speed > 0.1 m)",
)


def cost(text, times, signals):
    """Return the processor time [ms] of evaluating the formula ``text``, a median."""
    formula, found = parse(text), []
    for _ in range(REPEATS):
        begun = time.process_time()
        evaluate(formula, text, times, signals)
        found.append(1e3 * (time.process_time() - begun))
    return statistics.median(found)


def main():
    """Print the table; exit with 1 where a formula takes too long."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=5501)
    parser.add_argument("--most", type=float, default=2.0, metavar="MS")
    arguments = parser.parse_args()
    random, times = np.random.default_rng(0), PERIOD * np.arange(arguments.samples)
    steps = 0.05 * random.normal(size=(2, arguments.samples))
    signals = {name: Signal(np.cumsum(own), "m") for name, own in zip(("error", "speed"), steps)}
    costs = {text: cost(text, times, signals) for text in FORMULAS}
    for text, spent in costs.items():
        print("{:45} {:6.2f} ms".format(text, spent))
    sys.exit(int(max(costs.values()) > arguments.most))


if __name__ == "__main__":
    main()
