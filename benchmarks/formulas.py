#!/usr/bin/env python3
"""What it costs to evaluate a requirement: whole formulas of one operator over many samples.

    python3 benchmarks/formulas.py                 # 5,501 samples: 110 s at 50 Hz
    python3 benchmarks/formulas.py --samples 50001 --most 20
    python3 benchmarks/formulas.py --rtamt 10000   # compared with rtamt on so many random formulas

Processor time [ms], the median of ``REPEATS``: robustness, what decides it and when.  Exits with 1 where
a formula takes more than ``--most`` [ms], or differs from what the package rtamt (pip install rtamt) has by
more than ``OFF``; ``./test.sh all`` compares them.  Windows fit into the signals: rtamt cuts off those that
do not.  0.4.10 excludes Python 3.13, where the ANTLR runtime 4.7 that it pins, a source package without a
wheel, no longer imports.
"""

import argparse
import math
import os
import statistics
import sys
import time

import numpy as np

from mrs_simulator.core.temporal_logic.formula import children
from mrs_simulator.core.temporal_logic.robustness import Signal, evaluate
from mrs_simulator.core.temporal_logic.syntax import parse

PERIOD, REPEATS, OFF = 0.02, 50, 1e-9  # [s], [-], [-]
TESTS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "test", "core")
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


def written(formula):
    """Return the text of a ``formula`` of random_formulas.py as rtamt reads it."""
    kind, inner = type(formula).__name__.lower(), list(map(written, children(formula)))
    if kind == "predicate":
        signal, constant = formula.terms
        return "({} * {} + ({}) >= 0)".format(signal.factor, signal.signal, constant.factor)
    if kind in ("and", "or", "until"):
        window = _window(formula) if kind == "until" else ""
        return "({})".format(" {}{} ".format(kind, window).join(inner))
    return "({}{} {})".format(kind, "" if kind == "not" else _window(formula), inner[0])


def _window(formula):
    return "[{:.0f}:{:.0f}]".format(*formula.window)


def farthest_off(count):
    """Return by how much robustness differs from rtamt's on so many random formulas, the most."""
    sys.path.insert(0, TESTS)
    import rtamt
    from random_formulas import SIGNALS, has_unbounded, horizon, random_formula, random_signals

    random, most, done = np.random.default_rng(2), 0.0, 0
    while done < count:
        formula = random_formula(random)
        if has_unbounded(formula):
            continue
        samples = max(2, int(horizon(formula)) + 1 + int(random.integers(0, 3)))
        values = random_signals(random, samples)
        oracle = rtamt.StlDiscreteTimeSpecification()
        for name in SIGNALS:
            oracle.declare_var(name, "float")
        oracle.spec = written(formula)
        oracle.parse()
        lists = {name: own.tolist() for name, own in values.items()}
        theirs = oracle.evaluate({"time": list(range(samples)), **lists})[0][1]
        signals = {name: Signal(own) for name, own in values.items()}
        ours = evaluate(formula, "", np.arange(float(samples)), signals)
        off = max(abs(each - theirs) for each in (ours.low, ours.high))
        most, done = max(most, math.inf if math.isnan(off) else off), done + 1
    return most


def main():
    """Print the table; exit with 1 where a formula takes too long."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=5501)
    parser.add_argument("--most", type=float, default=2.0, metavar="MS")
    parser.add_argument("--rtamt", type=int, metavar="N", help="compare N random formulas instead")
    arguments = parser.parse_args()
    if arguments.rtamt:
        off = farthest_off(arguments.rtamt)
        print("{} random formulas, off rtamt by {:.3g} at most".format(arguments.rtamt, off))
        sys.exit(int(off > OFF))
    random, times = np.random.default_rng(0), PERIOD * np.arange(arguments.samples)
    steps = 0.05 * random.normal(size=(2, arguments.samples))
    signals = {name: Signal(np.cumsum(own), "m") for name, own in zip(("error", "speed"), steps)}
    costs = {text: cost(text, times, signals) for text in FORMULAS}
    for text, spent in costs.items():
        print("{:45} {:6.2f} ms".format(text, spent))
    sys.exit(int(max(costs.values()) > arguments.most))


if __name__ == "__main__":
    main()
