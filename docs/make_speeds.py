#!/usr/bin/env python3
"""Tables of docs/benchmarks.md, of what benchmarks/history.csv has measured last.

    python3 docs/make_speeds.py     # measures all anew, on an idle machine, and makes the tables

Without anything measured, ``python3 docs/make_tables.py`` makes them.
"""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "benchmarks"))
import history  # noqa: E402, beside what it kept

# What is measured: programs of benchmarks/ with their arguments.
PROGRAMS = ("headless", "vehicles", "startup", "growth", "recording", "mixed_teams")
MACHINE = ("cpu", "cores", "versions")
WHOLE = "a run from its start, recorded"
CROWD_RUN, PLANAR_RUN, LASER_RUN = (
    run + WHOLE[5:] for run in ("a crowd", "the fast engine", "a law that reads lasers")
)
HOOK, ARRAYS = "kinematic, by calculateControlLaw", "kinematic, by arrays"
CROWD = "kinematic, a crowd in contact"
COMPILED = ", compiled"
# Tables: their benchmark, their sizes, and rows: a text with a case, or with what is wanted.
SPEEDS = {
    "whole": (
        "headless",
        (7, 100, 1000, 10000),
        (
            ("robots that do not touch, compiled", WHOLE + COMPILED),
            ("wanted", (10000, 2000, 240, 23)),
            ("the same by numpy alone", WHOLE),
            ("a crowd that touches all the time, compiled", CROWD_RUN + COMPILED),
            ("wanted", ("", 750, 150, 12)),
            ("the same by numpy alone", CROWD_RUN),
            ("wheels with forces, planar engine, compiled", PLANAR_RUN + COMPILED),
            ("wanted", (1000, 300, 60, "")),
            ("the same by numpy alone", PLANAR_RUN),
            ("lasers of 360 rays at 10 Hz that a law reads, compiled", LASER_RUN + COMPILED),
            ("wanted", (400, 60, "", "")),
            ("the same by numpy alone", LASER_RUN),
        ),
    ),
    "loop": (
        "headless",
        (7, 100, 1000, 10000),
        (
            ("through `calculateControlLaw`", HOOK),
            ("wanted", (700, 200, 20, 2)),
            ("the same, recorded", HOOK + ", recorded"),
            ("by arrays", ARRAYS),
            ("the same, recorded", ARRAYS + ", recorded"),
            ("by arrays, compiled, each sample asked for by itself", ARRAYS + COMPILED),
            ("a crowd that touches all the time", CROWD),
            ("the same, compiled", CROWD + COMPILED),
            ("with forces, by pybullet", "dynamic, by arrays"),
            ("with forces, by the planar engine", "dynamic, fast engine"),
            (
                "pybullet alone, writing poses of massless bodies",
                "reference: pybullet writes poses",
            ),
        ),
    ),
    "vehicles": (
        "vehicles",
        (10, 100, 1000),
        (
            (
                "quadrotors: bodies, rotors, controllers in substeps of 2 ms",
                "quadrotors with forces",
            ),
            ("the same in the whole world, hovering", "quadrotors in the world with forces"),
            (
                "a whole run of 110 s from its start, recorded, compiled",
                "a recorded run of quadrotors with forces",
            ),
            ("wanted", (500, 150, 15)),
            ("vessels: the whole world with current, wind, gusts, waves", "vessels with forces"),
        ),
    ),
}
# Whole commands: a text, a case and sizes, by wall and processor time, and what is wanted of the former.
COMMANDS = (
    (
        "`experiment scenarios/paper.yaml`, by `mrs-simulator`",
        "the same without rosrun",
        (7,),
        "0.8 s",
    ),
    ("the same by `rosrun`", "experiment on paper.yaml", (7,), ""),
    (
        "110 s of 100, 1,000 robots in a line, by `rosrun`",
        "experiment of 110 s in a line",
        (100, 1000),
        "",
    ),
    (
        "110 s of 100, 1,000 robots in a crowd, by `rosrun`",
        "experiment of 110 s in a crowd",
        (100, 1000),
        "",
    ),
    (
        "an hour of 100, 1,000 robots in a line, by `rosrun`",
        "experiment of an hour in a line",
        (100, 1000),
        "60 s of 1,000",
    ),
    ("2 s of 10,000 robots in a crowd, by `rosrun`", "experiment of 2 s", (10000,), ""),
    (
        "1,000 runs of `paper.yaml`, a sweep over k, on all cores",
        "a sweep of 1,000 runs",
        (7,),
        "30 s",
    ),
)


def newest():
    """Return the newest row of each ``(benchmark, case, n)``, on the machine of the newest of all."""
    rows = history.read()
    machine = [rows[-1][key] for key in MACHINE]
    alike = [row for row in rows if [row[key] for key in MACHINE] == machine]
    return {(row["benchmark"], row["case"], int(row["n"])): row for row in alike}


def number(value):
    """Return ``value`` as a text of at least three digits; a text as it is."""
    if isinstance(value, str):
        return value
    return "{:,.0f}".format(value) if value >= 99.5 else "{:.3g}".format(value)


def headline(rows):
    """Return the factors of whole compiled runs of 7, 100 and 1,000 robots, as in README's table."""
    return [number(float(rows["headless", WHOLE + COMPILED, n]["value"])) for n in (7, 100, 1000)]


def sentence(rows):
    """Return what README says of speed."""
    cases = HOOK + ", recorded", WHOLE, WHOLE + COMPILED
    hundred, thousand = (
        [number(float(rows["headless", case, n]["value"])) for case in cases] for n in (100, 1000)
    )
    text = (
        "**Speed.** With limits, ramps, collisions and watchdogs, and recorded, a hundred robots run {}\n"
        "times as fast as real time through `calculateControlLaw`, {} times by arrays and {} times\n"
        "compiled; a thousand {}, {} and {} times."
    )
    return text.format(*hundred, *thousand)


def speeds(name, rows):
    """Return the table ``name`` of ``SPEEDS``: simulated seconds per second, a column of each size."""
    benchmark, sizes, lines = SPEEDS[name]
    used, table = [], [["simulated seconds a second", *("{:,} robots".format(n) for n in sizes)]]
    for text, wanted in lines:
        cells = wanted
        if isinstance(wanted, str):
            found = [rows.get((benchmark, wanted, n)) for n in sizes]
            used += filter(None, found)
            cells = [float(row["value"]) if row else "" for row in found]
        table.append([text, *map(number, cells)])
    return _joined(table, used)


def commands(rows):
    """Return the table of whole commands."""
    used, table = [], [["whole command", "wall time", "processor time", "wanted, wall time"]]
    for text, case, sizes, wanted in COMMANDS:
        cells = []
        for clock in ("wall time", "processor time"):
            found = [rows.get(("startup", "{}, {}".format(case, clock), n)) for n in sizes]
            used += filter(None, found)
            cells.append(", ".join("{:.3g} s".format(float(row["value"])) for row in found if row))
        table.append([text, *cells, wanted])
    return _joined(table, used)


def _joined(table, used):
    """Return the lines of a ``table`` of cells, and when and of what the rows ``used`` were measured."""
    header, *lines = (
        "|{}|".format("|".join(" {} ".format(c) if c else " " for c in row)) for row in table
    )
    of = sorted({"{} of {}".format(row["date"][:10], row["commit"]) for row in used})
    text = "Measured on {}: {cpu}, {cores} cores, {versions}."
    rule = "|" + "---|" * len(table[0])
    return "\n".join([header, rule, *lines, "", text.format(", ".join(of), **used[-1])])


def tables():
    """Return the text of each table by its name."""
    rows = newest()
    return {**{name: speeds(name, rows) for name in SPEEDS}, "commands": commands(rows)}


def main():
    """Measure all anew, and make the tables."""
    for program in PROGRAMS:
        path = os.path.join(ROOT, "benchmarks", program + ".py")
        subprocess.run([sys.executable, path, "--keep"], check=True)
    subprocess.run([sys.executable, os.path.join(ROOT, "docs", "make_tables.py")], check=True)


if __name__ == "__main__":
    main()
