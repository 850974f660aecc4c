#!/usr/bin/env python3
"""Thresholds of theorems, found by bisection on the sign of a growth rate that runs show.

    python3 benchmarks/thresholds.py                   # all
    python3 benchmarks/thresholds.py delay pursuit     # of these alone
    python3 benchmarks/thresholds.py --table           # as a table in Markdown

The search knows a law, a number and its range, and nothing of theory: a run grows or decays.  What it
finds is compared with the threshold of the sampled law, commands held for Tc, stated here by its
characteristic polynomial, and with that of continuous time, which it approaches with Tc.  Exits with 1
where a threshold is more than 2 % off the sampled one, or where the finer of two periods is farther from
continuous time.
"""

import argparse
import contextlib
import io
import math
import os
import sys
from typing import Any, Callable, NamedTuple

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "src"))

MOST_OFF = 0.02  # [-] of the sampled threshold
FINE = 5e-4  # [-] of the range's upper end, to which a threshold is bisected
POINTS = {"fidelity": "point_mass", "limits": "none"}
PATH = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 2.0, 0.0], [4.0, 5.0, 0.0]]
LAMBDA = 2.0 + math.sqrt(2.0)  # [1] the largest eigenvalue of a path of four
RING, FREQUENCY, LINKS = 6, 1.0, 3


class Case(NamedTuple):
    """A law whose runs with ``content(value, rate)`` grow beyond a ``value``, or below one that ``damps``.

    ``grows(run)``: a number above 0 where it does; ``span``: within which the value is looked for;
    ``sampled(rate)``, ``continuous``: thresholds of theory; ``rates`` [Hz], the coarse one first.
    """

    content: Callable
    span: Any
    sampled: Callable
    continuous: float
    rates: Any
    grows: Callable
    damps: bool = False


def team(protocol, rate, duration, parameters, **more):
    """Return the content of a scenario of points without limits."""
    control = {"protocol": protocol, "rate": rate, "saturation": "none", "parameters": parameters}
    return {**POINTS, "control": control, "duration": duration, "step": 1.0 / rate, **more}


def on_path(gain, rate, duration=40.0, **more):
    """Return consensus over a path of four."""
    topology = {"preset": "path"}
    more = {"poses": PATH, "topology": topology, **more}
    return team("consensus", rate, duration, {"gain": gain}, **more)


def growth(run):
    """Return the fitted growth rate [1/s] of the distance from agreement; inf of a team driven apart."""
    from mrs_simulator.core.claims import disagreement
    from mrs_simulator.core.stability import growth_rate

    if run.meta["ended"] != "complete":
        return math.inf
    return growth_rate(run.time, disagreement(run.hand))


def swing(run):
    """Return the logarithm of the first robot's sway over its leader's, late in the run."""
    from mrs_simulator.protocols.marching.string_equations import amplitudes

    late = run.time >= run.time[-1] - 10.0 * math.pi / FREQUENCY
    ways = run.hand[late, :, 0] - run.hand[0, :, 0]
    found = amplitudes(run.time[late], ways, FREQUENCY)
    return float(np.log(found[0] / found[-1]))


def crossing(radius, low, high):
    """Return where ``radius`` passes 1 between ``low`` and ``high``, by bisection."""
    above = radius(high) > 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if (radius(middle) > 1.0) == above else (middle, high)
    return 0.5 * (low + high)


TAU = 0.2  # [s]


def held_delay(rate):
    """Return the gain at which ``z^(m+1) - z^m + gain lambda Tc = 0`` has a root on the unit circle."""
    steps = int(round(TAU * rate))
    return rate / LAMBDA * 2.0 * math.sin(0.5 * math.pi / (2 * steps + 1))


def pursuit_radius(angle, rate):
    """Return the largest factor by which one command multiplies a mode of cyclic pursuit."""
    modes = np.exp(2j * math.pi * np.arange(1, RING) / RING) - 1.0
    return np.abs(1.0 + np.exp(1j * angle) * modes / rate).max()


def damping_radius(g, rate):
    """Return the spectral radius of second-order consensus over a directed ring, by semi-implicit steps."""
    period, radii = 1.0 / rate, []
    for mu in 1.0 - np.exp(2j * math.pi * np.arange(1, RING) / RING):
        turned = np.array([-period * mu, 1.0 - period * mu * g])  # the new velocity, of (p, v)
        radii.append(
            np.abs(np.linalg.eigvals([np.array([1.0, 0.0]) + period * turned, turned])).max()
        )
    return max(radii)


def least_damping():
    """Return the damping [s] that a directed ring needs: ``max sqrt(Im(mu)^2/(Re(mu) |mu|^2))``."""
    mu = 1.0 - np.exp(2j * math.pi * np.arange(1, RING) / RING)
    return float(np.sqrt(mu.imag**2 / (mu.real * np.abs(mu) ** 2)).max())


def passed_on(gain, rate):
    """Return ``|G|`` at the leader's frequency, ``G = a z^-d/(z - 1 + a z^-d)``, ``a = gain Tc``."""
    z = np.exp(1j * FREQUENCY / rate)
    late = gain / rate * z ** -int(round(TAU_CHAIN * rate))
    return abs(late / (z - 1.0 + late))


TAU_CHAIN = 0.5  # [s]
CIRCLE = {"layout": "circle", "radius": 4.0}
OFF_CIRCLE = [[4.2, 0.0, 0.0], [2.0, 3.0, 0.0], [-2.0, 3.6, 0.0]]
OFF_CIRCLE += [[-4.0, 0.3, 0.0], [-1.5, -3.5, 0.0], [2.2, -3.2, 0.0]]
CASES = {
    "delay": Case(
        lambda gain, rate: on_path(gain, rate, links={"delay": TAU, "carries": "difference"}),
        (0.2, 6.0),
        held_delay,
        math.pi / (2.0 * TAU * LAMBDA),
        (10.0, 100.0),
        growth,
    ),
    "delayed commands": Case(
        lambda gain, rate: on_path(gain, rate, mismatch={"delay": TAU}),
        (0.2, 6.0),
        held_delay,
        math.pi / (2.0 * TAU * LAMBDA),
        (50.0,),
        growth,
    ),
    "held commands": Case(
        lambda gain, rate: on_path(gain, rate, 300.0 / rate),
        (0.1, 40.0),
        lambda rate: 2.0 * rate / LAMBDA,
        math.inf,
        (10.0, 20.0),
        growth,
    ),
    "pursuit": Case(
        lambda angle, rate: team(
            "cyclic_pursuit", rate, 60.0, {"gain": 1.0, "angle": angle}, poses=OFF_CIRCLE
        ),
        (0.1, 1.2),
        lambda rate: crossing(lambda angle: pursuit_radius(angle, rate), 0.1, 1.2),
        math.pi / RING,
        (10.0, 50.0),
        growth,
    ),
    "damping": Case(
        lambda g, rate: team(
            "second_order_consensus",
            rate,
            60.0,
            {"g": g, "push": 1.0, "seed": 3},
            poses=OFF_CIRCLE,
            topology={"preset": "cycle"},
        ),
        (0.5, 3.0),
        lambda rate: crossing(lambda g: damping_radius(g, rate), 0.5, 3.0),
        least_damping(),
        (10.0, 50.0),
        growth,
        damps=True,
    ),
    "a chain": Case(
        lambda gain, rate: team(
            "platoon",
            rate,
            70.0,
            {"gain": gain, "tau": TAU_CHAIN, "amplitude": 0.2, "frequency": FREQUENCY},
            robots=LINKS + 1,
            poses={"layout": "line", "spacing": 2.0},
        ),
        (0.5, 1.5),
        lambda rate: crossing(lambda gain: passed_on(gain, rate), 0.5, 1.5),
        FREQUENCY / (2.0 * math.sin(FREQUENCY * TAU_CHAIN)),
        (10.0, 50.0),
        swing,
    ),
}


def found_threshold(case, rate):
    """Return the value at which runs at ``rate`` [Hz] begin to grow, and how many runs it took."""
    from mrs_simulator.study.run.simulating import simulate

    runs = 0

    def breaks(value):
        nonlocal runs
        runs += 1
        with contextlib.redirect_stderr(io.StringIO()):
            run = simulate(case.content(value, rate)).run
        return (case.grows(run) > 0.0) != case.damps

    low, high = case.span
    if breaks(low) or not breaks(high):
        raise ValueError("the range {} does not hold below and break above".format(case.span))
    while high - low > FINE * case.span[1]:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if breaks(middle) else (middle, high)
    return 0.5 * (low + high), runs


def measured(names):
    """Yield ``(name, rate, found, sampled, continuous, runs)`` of the cases ``names``."""
    for name in names:
        case = CASES[name]
        for rate in case.rates:
            found, runs = found_threshold(case, rate)
            yield name, rate, found, case.sampled(rate), case.continuous, runs


def wrong(rows):
    """Return what is wrong with the ``rows`` of :func:`measured`, a list of texts."""
    texts, last = [], {}
    for name, rate, found, sampled, continuous, _ in rows:
        off = abs(found / sampled - 1.0)
        if off > MOST_OFF:
            texts.append("{} at {:g} Hz: {:.1f} % off".format(name, rate, 100.0 * off))
        far = abs(found - continuous)
        if math.isfinite(far) and far > last.get(name, math.inf):
            texts.append("{} at {:g} Hz: farther from continuous time".format(name, rate))
        last[name] = far
    return texts


def main():
    """Find the thresholds that the command line names; exit with 1 where one is off."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help="of {}".format(", ".join(CASES)))
    parser.add_argument("--table", action="store_true", help="in Markdown")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(CASES))
    if unknown:
        parser.error("{}: wanted one of {}".format(unknown[0], ", ".join(CASES)))
    row = (
        "| {} | {} | {} | {} | {} | {} |"
        if arguments.table
        else "{:17} {:>6} {:>9} {:>9} {:>7} {:>11}"
    )
    print(row.format("threshold", "Hz", "found", "sampled", "off", "continuous"))
    if arguments.table:
        print(row.format(*["---"] * 6))
    rows = []
    for name, rate, found, sampled, continuous, runs in measured(arguments.names or CASES):
        off = "{:+.2f} %".format(100.0 * (found / sampled - 1.0))
        numbers = ("{:.4f}".format(each) for each in (found, sampled))
        known = "{:.4f}".format(continuous) if math.isfinite(continuous) else "none"
        print(row.format(name, "{:g}".format(rate), *numbers, off, known), flush=True)
        rows.append((name, rate, found, sampled, continuous, runs))
    texts = wrong(rows)
    print(
        "{} runs; {}".format(sum(each[-1] for each in rows), "; ".join(texts) or "all within 2 %")
    )
    sys.exit(1 if texts else 0)


if __name__ == "__main__":
    main()
