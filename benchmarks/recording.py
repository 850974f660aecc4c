#!/usr/bin/env python3
"""How fast runs are written to run.csv and read back, and the memory that takes.

    python3 benchmarks/recording.py [--keep]

1,000 robots; at 50 Hz they make 50,000 rows a second.
"""

import argparse
import contextlib
import os
import sys
import tempfile
import time
import tracemalloc
from importlib.util import find_spec

import numpy as np
from history import Report

from mrs_simulator.record import number_rows
from mrs_simulator.record.recording import Recorder, closest_approach, read_run_csv
from mrs_simulator.state.state_table import StateTable

ROBOTS = 1000
SAMPLES = 200


@contextlib.contextmanager
def python_alone():
    """Let rows be written without orjson meanwhile."""
    there = {name: sys.modules.get(name) for name in ("orjson",)}
    sys.modules["orjson"] = None
    number_rows._writer.cache_clear()
    yield
    sys.modules.pop("orjson")
    sys.modules.update({name: module for name, module in there.items() if module})
    number_rows._writer.cache_clear()


def write(path, samples):
    """Write ``samples`` of a team to ``path``; return processor time and wall time [s]."""
    draw = np.random.default_rng(0)
    pose, command = draw.normal(0.0, 10.0, (ROBOTS, 3)), draw.normal(size=(ROBOTS, 2))
    cpu, wall = time.process_time(), time.perf_counter()
    with Recorder(path, range(1, ROBOTS + 1)) as recorder:
        for index in range(samples):
            recorder.sample(0.02 * index, StateTable(pose=pose + 1e-3 * index, command=command))
    return time.process_time() - cpu, time.perf_counter() - wall


def note_writing(report, case, path):
    """Note how fast samples are written to ``path``."""
    cpu, wall = (min(took) for took in zip(*(write(path, SAMPLES) for _ in range(3))))
    rows = ROBOTS * SAMPLES
    report.note(case, ROBOTS, rows / cpu, "rows/s")
    report.note(case + ", by wall time", ROBOTS, rows / wall, "rows/s")
    report.note(case + ", share of a core at 50 Hz", ROBOTS, cpu / (0.02 * SAMPLES), "share")


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
        with python_alone():
            note_writing(report, "written by Python alone", path)
        if find_spec("orjson"):
            note_writing(report, "written with orjson", path)
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
