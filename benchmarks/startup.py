#!/usr/bin/env python3
"""How long a user waits: experiments from command to figures, and imports; medians of 3.

    source build/devel/setup.bash; python3 benchmarks/startup.py [--keep]

Wall time, for a machine that does nothing else, and processor time, which other programs change less.  The
paper's scenario; its law on 100 and 1,000 robots for 110 s; on 10,000 for two seconds, with the most
memory that this takes.  Verdict, figures and recording at 10 Hz are included.
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


def times(command, ends=(0,)):
    """Return the median wall and processor time [s] of ``command`` over runs that exit with ``ends``."""
    took = []
    for _ in range(REPEATS):
        begin, used = time.perf_counter(), processor_time()
        done = subprocess.run(command, stdout=subprocess.DEVNULL, timeout=300)
        took.append((time.perf_counter() - begin, processor_time() - used))
        if done.returncode not in ends:
            raise SystemExit("{}: exit code {}".format(" ".join(command), done.returncode))
    return tuple(statistics.median(each) for each in zip(*took))


def wall_time(command):
    """Return the median wall time [s] of ``command``."""
    return times(command)[0]


def processor_time():
    """Return the processor time [s] of the commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def note_times(report, case, n, command, ends=(0,)):
    """Note how long ``command`` takes, both ways."""
    for how, took in zip(("wall", "processor"), times(command, ends)):
        report.note("{}, {} time".format(case, how), n, took, "s")


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    report = Report("startup", parser.parse_args().keep)
    paper = os.path.join(ROOT, "scenarios", "paper.yaml")
    with tempfile.TemporaryDirectory() as out:
        command = ["rosrun", "mrs_simulator", "experiment", paper, "--out", out]
        note_times(report, "experiment on paper.yaml", 7, command)
        for n in (100, 1000):
            # So many are not in line by then: the verdict may be that of a run that fails.
            more = command + ["--robots", str(n), "--duration", "110"]
            note_times(report, "experiment of 110 s", n, more, (0, 1))
        command += ["--robots", str(MANY), "--duration", "2"]
        note_times(report, "experiment of 2 s", MANY, command, (0, 1))
        most = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        report.note("its memory per robot", MANY, most / MANY, "bytes")
    bare = wall_time([sys.executable, "-c", "pass"])
    report.note("import of numpy", 0, wall_time([sys.executable, "-c", "import numpy"]) - bare, "s")
    report.note("import of the core", 0, wall_time([sys.executable, "-c", CORE]) - bare, "s")
    report.close()


if __name__ == "__main__":
    main()
