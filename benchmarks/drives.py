#!/usr/bin/env python3
"""On which drives the shipped protocols run, and how far from theory: a table of docs/shipped_protocols.md.

    python3 benchmarks/drives.py                      # all of them, written into the page
    python3 benchmarks/drives.py marching coverage    # these alone

Each protocol's scenario runs for its first seconds on kinematic robots of one kind of each drive, within
their own limits, from points as the scenario has them.  A cell tells the largest distance from where the
published law takes these robots, until bodies touched, and what else failed; of laws by sensors, that
they run.
"""

import argparse
import concurrent.futures
import itertools
import os
import re
import tempfile

import numpy as np

from mrs_simulator import load_scenario
from mrs_simulator.protocols import HOMES
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.verdict.law.published_checks import ROBOTS

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE = os.path.join(ROOT, "docs", "shipped_protocols.md")
DURATION = 5.0  # [s]
DRIVES = {
    "differential": "pioneer3dx",
    "omnidirectional": "robotino3",
    "car": "f1tenth",
    "vessel": "heron",
    "quadrotor": "crazyflie2",
}
OTHER_NAMES = {"formation": "paper_four"}
HEADER = "| name | on robots of each drive, largest distance from theory in {:g} s [m] |".format(
    DURATION
)
BY_HAND = ("carrying",)  # protocols of robots with arms, whose cells are written by hand
TOUCHED = "collisions"


def on_kind(name, kind):
    """Return the scenario of the protocol ``name`` on robots of a ``kind``, its points where they were."""
    path = os.path.join(ROOT, "scenarios", OTHER_NAMES.get(name, name) + ".yaml")
    scenario = load_scenario(path)
    own = Team.from_scenario(scenario)
    flies = kind == DRIVES["quadrotor"]
    other = scenario._replace(
        kinds=(kind,) * scenario.n,
        fidelity="kinematic",
        limits="firmware",
        odometry="world",
        duration=min(DURATION, scenario.duration),
        altitude=np.ones(scenario.n) if flies else None,
    )
    l, poses, still = scenario.hand_length, scenario.poses.copy(), np.zeros(scenario.n)
    team = Team.from_scenario(other)
    poses[:, :2] += own.point(poses, still, l) - team.point(poses, still, l)
    return other._replace(poses=poses)


def distance(task):
    """Return in words how far [m] robots are from theory at most, or why that is not told."""
    name, kind = task
    try:
        scenario = on_kind(name, kind)
        if scenario.control.dimension == 3 and kind != DRIVES["quadrotor"]:
            return "not in space"
        with tempfile.TemporaryDirectory() as out:
            checks = {c["name"]: c for c in run_experiment(scenario, out, formats=())["checks"]}
    except ValueError as error:
        return "too large" if "overlap" in str(error) else "refused"
    wrong = [name for name, check in checks.items() if check["passed"] is False]
    check = checks.get(ROBOTS)
    touched = " (touched)" if TOUCHED in wrong else ""
    if check is None:  # a law by sensors is not published as one of points
        return "runs" + touched
    found = "not judged" if check["passed"] is None else _shown(check["measured"])
    failed = ["FAILED " + name for name in wrong if name != TOUCHED]
    return ", ".join([found + touched] + failed)


def _shown(value):
    return "{:.0e}".format(value) if value else "0"


def cell(found):
    """Return what was ``found`` on each drive, by name, as the cell of a table."""
    return "; ".join("{} {}".format(drive, value) for drive, value in found.items())


def with_rows(page, cells):
    """Return the ``page`` whose table of drives has ``cells``, texts by name, in place of their rows."""
    before, _, after = page.partition(HEADER + "\n|---|---|\n")
    table = re.match(r"(?:\|.*\n)*", after).group()
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", table, re.M), **cells)
    fresh = "".join("| `{}` | {} |\n".format(*row) for row in sorted(rows.items()))
    return "{}{}\n|---|---|\n{}{}".format(before, HEADER, fresh, after[len(table) :])


def main():
    """Run the protocols that the command line names, and write their rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="protocol")
    given = parser.parse_args().names
    names = given or sorted(set(HOMES) - set(BY_HAND))
    tasks = list(itertools.product(names, DRIVES.values()))
    with concurrent.futures.ProcessPoolExecutor() as pool:
        found = dict(zip(tasks, pool.map(distance, tasks)))
    cells = {
        name: cell({drive: found[name, kind] for drive, kind in DRIVES.items()}) for name in names
    }
    with open(PAGE, encoding="utf-8") as file:
        page = file.read()
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(with_rows(page, cells))


if __name__ == "__main__":
    main()
