#!/usr/bin/env python3
"""How fast runs are written to run.csv and read back, and the memory that takes.

    python3 benchmarks/recording.py [--keep]

1,000 robots; at 50 Hz they make 50,000 rows a second.
"""

import argparse
import os
import tempfile
import time
import tracemalloc

import numpy as np
from history import Report

from mrs_simulator.core.recording import Recorder, closest_approach, read_run_csv

ROBOTS = 1000
SAMPLES = 200


def write(path, samples):
    """Write ``samples`` of a team to ``path``; return the processor time [s]."""
    draw = np.random.default_rng(0)
    pose, command = draw.normal(0.0, 10.0, (ROBOTS, 3)), draw.normal(size=(ROBOTS, 2))
    begin = time.process_time()
    with Recorder(path, range(1, ROBOTS + 1)) as recorder:
        for index in range(samples):
            recorder.sample(0.02 * index, pose + 1e-3 * index, command)
    return time.process_time() - begin


def peak(function, *arguments):
    """Return the most memory [bytes] that Python and numpy held at once in a call."""
    tracemalloc.start()
    function(*arguments)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    report, rows = Report("recording", parser.parse_args().keep), ROBOTS * SAMPLES
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "run.csv")
        took = min(write(path, SAMPLES) for _ in range(3))
        report.note("written", ROBOTS, rows / took, "rows/s")
        report.note("share of a core at 50 Hz", ROBOTS, took / (0.02 * SAMPLES), "share")
        begin = time.process_time()
        run = read_run_csv(path)
        report.note("read", ROBOTS, rows / (time.process_time() - begin), "rows/s")
        begin = time.process_time()
        closest_approach(run.pose)
        report.note("closest approach", ROBOTS, rows / (time.process_time() - begin), "rows/s")
        report.note(
            "memory of reading per row, at most", ROBOTS, peak(read_run_csv, path) / rows, "bytes"
        )
        short, long = peak(write, path, 20), peak(write, path, 100)
        report.note("memory of writing, at most", ROBOTS, long, "bytes")
        report.note("its growth from 20 to 100 samples", ROBOTS, long / short, "-")
    report.close()


if __name__ == "__main__":
    main()
