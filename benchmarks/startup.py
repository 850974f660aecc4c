#!/usr/bin/env python3
"""How long a user waits: experiments from command to figures, and imports; medians of 3.

    source build/devel/setup.bash; python3 benchmarks/startup.py [--keep]

Wall time, on a machine that does nothing else.  The paper's scenario, and its law on 10,000 robots for
two seconds, with the most memory that this takes.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from history import ROOT, Report

REPEATS = 3
MANY = 10000  # robots
CORE = "import mrs_simulator.core.scenario, mrs_simulator.core.verdict, mrs_simulator.core.claims"


def wall_time(command, ends=(0,)):
    """Return the median wall time [s] of ``command`` over ``REPEATS`` runs that exit with ``ends``."""
    took = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        done = subprocess.run(command, stdout=subprocess.DEVNULL, timeout=120)
        took.append(time.perf_counter() - begin)
        if done.returncode not in ends:
            raise SystemExit("{}: exit code {}".format(" ".join(command), done.returncode))
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
        command += ["--robots", str(MANY), "--duration", "2"]
        # Two seconds bring nobody into line: the verdict is that of a run that fails.
        took = wall_time(command, ends=(1,))
        report.note("experiment of 2 s to figures", MANY, took, "s")
        most = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        report.note("its memory per robot", MANY, most / MANY, "bytes")
    bare = wall_time([sys.executable, "-c", "pass"])
    report.note("import of numpy", 0, wall_time([sys.executable, "-c", "import numpy"]) - bare, "s")
    report.note("import of the core", 0, wall_time([sys.executable, "-c", CORE]) - bare, "s")
    report.close()


if __name__ == "__main__":
    main()
