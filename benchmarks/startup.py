#!/usr/bin/env python3
"""How long a user waits: the paper's experiment from command to figures, and imports; medians of 3.

    source build/devel/setup.bash; python3 benchmarks/startup.py [--keep]

Wall time, on a machine that does nothing else.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

from history import ROOT, Report

REPEATS = 3
CORE = (
    "import mrs_simulator.core.scenario, mrs_simulator.core.verdict, mrs_simulator.core.formation"
)


def wall_time(command):
    """Return the median wall time [s] of ``command`` over ``REPEATS`` runs."""
    took = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=120)
        took.append(time.perf_counter() - begin)
    return statistics.median(took)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    report = Report("startup", parser.parse_args().keep)
    paper = os.path.join(ROOT, "scenarios", "paper.yaml")
    with tempfile.TemporaryDirectory() as out:
        command = ["rosrun", "mrs_simulator", "experiment", paper, "--out", out]
        report.note("experiment on paper.yaml to figures", 7, wall_time(command), "s")
    bare = wall_time([sys.executable, "-c", "pass"])
    report.note("import of numpy", 0, wall_time([sys.executable, "-c", "import numpy"]) - bare, "s")
    report.note("import of the core", 0, wall_time([sys.executable, "-c", CORE]) - bare, "s")
    report.close()


if __name__ == "__main__":
    main()
