#!/usr/bin/env python3
"""How long a user waits: experiments from command to figures, sweeps, imports; medians of 3.

    source build/devel/setup.bash; python3 benchmarks/startup.py [--keep]

Wall time, for a machine that does nothing else, and processor time of all processes, which other programs
change less.  Experiments are whole commands: rosrun, imports, run, recording at 10 Hz, verdict,
certificates and figures as PNG and PDF.  Modules are compiled beforehand, as they are after an installation
or a first command.  The paper's scenario, also by ``mrs-simulator``, which the
shell finds without rosrun, and what rosrun takes, by both commands' ``--help``; 110 s of its law on 100
and 1,000 robots in a line, who never touch, and on as many put where there is room, who touch all the
time; an hour of 100 and of 1,000 robots in a line, once, for its memory; two seconds of 10,000.  A run of
a sweep is what ``LONG_SWEEP`` runs of the paper's scenario take more than ``SHORT_SWEEP``, each another k,
without figures of their own; a sweep of ``MANY_RUNS``, once.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

import yaml
from history import ROOT, Report

REPEATS = 3
MANY = 10000  # robots
SHORT_SWEEP, LONG_SWEEP, MANY_RUNS = 8, 40, 1000  # runs
EXPERIMENT = ["rosrun", "mrs_simulator", "experiment"]
DIRECT = ["mrs-simulator", "experiment"]  # the same, which the shell finds
PAPER = os.path.join(ROOT, "scenarios", "paper.yaml")
CORE = "import mrs_simulator.scenario.scenario, mrs_simulator.verdict.verdict, mrs_simulator.core.claims"


def times(command, ends=(0,), repeats=REPEATS):
    """Return the median wall and processor time [s] of ``command`` and its most memory [bytes].

    Over runs that exit with ``ends``; memory is the resident memory of its largest process.
    """
    took = []
    for _ in range(repeats):
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.WEXITSTATUS(status)
        cpu = used.ru_utime + used.ru_stime
        took.append((time.perf_counter() - begin, cpu, 1024.0 * used.ru_maxrss))
        if not os.WIFEXITED(status) or process.returncode not in ends:
            raise SystemExit("{}: exit code {}".format(" ".join(command), status))
    return tuple(statistics.median(each) for each in zip(*took))


def wall_time(command):
    """Return the median wall time [s] of ``command``."""
    return times(command)[0]


def note_times(report, case, n, command, ends=(0,), repeats=REPEATS):
    """Note how long ``command`` takes, both ways, and its memory; return the latter [bytes]."""
    wall, processor, memory = times(command, ends, repeats)
    report.note("{}, wall time".format(case), n, wall, "s")
    report.note("{}, processor time".format(case), n, processor, "s")
    report.note("{}, memory".format(case), n, memory, "bytes")
    return memory


def line_of(n, duration, out):
    """Write the paper's scenario with ``n`` robots in a line for ``duration`` [s]; return its path."""
    with open(PAPER, encoding="utf-8") as file:
        content = yaml.safe_load(file)
    content.update(robots=n, duration=duration, poses={"layout": "line", "spacing": 2.5})
    path = os.path.join(out, "line_{}_{}.yaml".format(n, duration))
    with open(path, "w", encoding="utf-8") as file:
        yaml.safe_dump(content, file)
    return path


def note_sweep(report, out):
    """Note what a run of a sweep takes, on as many processes as there are cores, and a long sweep."""

    def sweep(runs, last):
        values = "control.parameters.k=0.001..{}/{}".format(last, runs)
        # What an earlier sweep has finished is not run again.
        return [*EXPERIMENT, PAPER, "--sweep", values, "--out", tempfile.mkdtemp(dir=out)]

    found = []
    for runs in (SHORT_SWEEP, LONG_SWEEP):
        found.append([times(sweep(runs, 0.05), repeats=1) for _ in range(REPEATS)])
    for row, how in enumerate(("wall", "processor")):
        short, long = (statistics.median(each[row] for each in took) for took in found)
        per_run = (long - short) / (LONG_SWEEP - SHORT_SWEEP)
        report.note("a run of a sweep, {} time".format(how), 7, per_run, "s")
    # The slowest gain is too slow to be judged.
    long = sweep(MANY_RUNS, 0.1)
    note_times(report, "a sweep of {:,} runs".format(MANY_RUNS), 7, long, (0, 1), repeats=1)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    report = Report("startup", parser.parse_args().keep)
    with tempfile.TemporaryDirectory() as out:
        to = ["--out", os.path.join(out, "run")]
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ["PYTHONPYCACHEPREFIX"] = os.path.join(out, "modules")
        times([*EXPERIMENT, PAPER, *to], repeats=1)
        note_times(report, "experiment on paper.yaml", 7, [*EXPERIMENT, PAPER, *to])
        note_times(report, "the same without rosrun", 7, [*DIRECT, PAPER, *to])
        helps = [wall_time([*command, "--help"]) for command in (EXPERIMENT, DIRECT)]
        report.note("rosrun itself, wall time", 7, helps[0] - helps[1], "s")
        for n in (100, 1000):
            # So many are not in place by then: the verdict may be that of a run that fails.
            line = [*EXPERIMENT, line_of(n, 110, out), *to]
            note_times(report, "experiment of 110 s in a line", n, line, (0, 1))
            crowd = [*EXPERIMENT, PAPER, *to, "--robots", str(n), "--duration", "110"]
            note_times(report, "experiment of 110 s in a crowd", n, crowd, (0, 1))
        for n in (100, 1000):
            hour = [*EXPERIMENT, line_of(n, 3600, out), *to]
            note_times(report, "experiment of an hour in a line", n, hour, (0, 1), repeats=1)
        many = [*EXPERIMENT, PAPER, *to, "--robots", str(MANY), "--duration", "2"]
        memory = note_times(report, "experiment of 2 s", MANY, many, (0, 1))
        report.note("its memory per robot", MANY, memory / MANY, "bytes")
        note_sweep(report, out)
    bare = wall_time([sys.executable, "-c", "pass"])
    report.note("import of numpy", 0, wall_time([sys.executable, "-c", "import numpy"]) - bare, "s")
    report.note("import of the core", 0, wall_time([sys.executable, "-c", CORE]) - bare, "s")
    report.close()


if __name__ == "__main__":
    main()
