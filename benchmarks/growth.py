#!/usr/bin/env python3
"""What simulating costs against the number of robots, and against the time simulated: a table and a figure.

    python3 benchmarks/growth.py [--quick] [--keep]
    python3 benchmarks/growth.py --draw     # docs/images/growth.png, of what was kept last

Pioneers in cyclic pursuit drive on a circle without end, 5 m apart, recorded at 10 Hz to run.csv, with what
``./demo.sh`` installs: runs from their start, compiled where numba is there, by processor time of the whole
process, verdict and figures left out.  Sizes: 110 s of 7 to 1,000 robots, fewer of more.  Times: from a
minute to a day of 7 robots, to six hours of 100, to an hour of 1,000.  A knee would show as a cost that
rises from one point to the next.  With ``--keep`` the figures go to benchmarks/history.csv.
"""

import argparse
import contextlib
import math
import os
import time

from headless import recorder_of, use_compiled
from history import ROOT, Report, read
from matplotlib.ticker import StrMethodFormatter

from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.draw.canvas import new_figure, save, styled
from mrs_simulator.study.run.experiment import Experiment

APART, GAIN = (
    5.0,
    0.02,
)  # [m], [1/s]: slow enough that held commands widen the circle by a third a day
SHORT, LONG = 110.0, 86400.0  # [s]
SIZES = (7, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
TIMES = (60.0, 600.0, 3600.0, 21600.0, LONG)  # [s]
OF_SPANS = (7, 100, 1000)  # robots
MOST = 4e6  # [s] of all robots together in one run
SPANS = ("1 min", "10 min", "1 h", "6 h", "1 d")
PICTURE = os.path.join(ROOT, "docs", "images", "growth.png")
OF_SIZE, OF_TIME = "a robot-step of a run", "a simulated second of {} robots after {:g} s"


def circle(n, duration):
    """Return the scenario in which n robots circle for ``duration`` [s]."""
    radius = 0.5 * APART / math.sin(math.pi / n)
    angles = [-2.0 * math.pi * i / n for i in range(n)]  # clockwise
    poses = [[radius * math.cos(a), radius * math.sin(a), a - 0.5 * math.pi] for a in angles]
    parameters = {"gain": GAIN, "angle": math.pi / n}
    return scenario_from_dict(
        {
            "poses": poses,
            "fidelity": "kinematic",
            "control": {"protocol": "cyclic_pursuit", "parameters": parameters},
            "duration": duration,
        }
    )


def seconds(n, duration):
    """Return the processor time [s] of a recorded run of n robots for ``duration`` [s], and its steps."""
    experiment = Experiment(circle(n, duration))
    with contextlib.ExitStack() as stack:
        stack.callback(experiment.world.close)
        begin = time.process_time()
        for _ in experiment.record(recorder_of(experiment, stack)):
            pass
        return time.process_time() - begin, duration / experiment.scenario.step


def kept():
    """Return what was kept last: ``{n: us}`` of a step of one, ``{n: {duration: ms}}`` of a second."""
    value = {(row["case"], int(row["n"])): float(row["value"]) for row in read()}
    costs = {n: value[OF_SIZE, n] for n in SIZES}
    spans = {
        n: {t: value[OF_TIME.format(n, t), n] for t in TIMES if (OF_TIME.format(n, t), n) in value}
        for n in OF_SPANS
    }
    return costs, spans


@styled
def draw(costs, spans):
    """Draw what runs cost, as ``kept`` returns it, to ``PICTURE``."""
    figure = new_figure(7.0, 2.6)
    left, right = figure.subplots(1, 2)
    left.semilogx(list(costs), list(costs.values()), "o-", markersize=4.0)
    left.set_ylim(0.0, 1.15 * max(costs.values()))
    left.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    left.set_xlabel("number of robots")
    left.set_ylabel("processor time\nof a robot-step [us]")
    for n, of_n in spans.items():
        label = "{:,} robots".format(n)
        right.loglog(list(of_n), list(of_n.values()), "o-", markersize=4.0, label=label)
    right.set_xticks(TIMES)
    right.set_xticklabels(SPANS)
    right.minorticks_off()
    every = [cost for of_n in spans.values() for cost in of_n.values()]
    right.set_ylim(0.5 * min(every), 2.0 * max(every))
    right.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    right.set_xlabel("simulated time")
    right.set_ylabel("processor time\nof a simulated second [ms]")
    right.legend()
    save(figure, PICTURE)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="short runs of few robots alone")
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    parser.add_argument("--draw", action="store_true", help="the figure of what was kept, alone")
    arguments = parser.parse_args()
    if arguments.draw:
        return draw(*kept())
    report = Report("growth", arguments.keep)
    use_compiled(True)
    seconds(7, 2.0)  # what is compiled is so by then
    sizes, durations = (SIZES[:4], TIMES[:2]) if arguments.quick else (SIZES, TIMES)
    for n in sizes:
        took, steps = seconds(n, min(SHORT, SHORT * 1000 / n))
        report.note(OF_SIZE, n, 1e6 * took / (steps * n), "us")
    for n in OF_SPANS:
        for duration in durations:
            if n * duration <= MOST and n in sizes:
                took = 1e3 * seconds(n, duration)[0] / duration
                report.note(OF_TIME.format(n, duration), n, took, "ms")
    report.close()


if __name__ == "__main__":
    main()
