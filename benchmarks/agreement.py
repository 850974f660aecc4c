#!/usr/bin/env python3
"""How far the shipped protocols stay from theory on robots: a table for docs/agreement.md.

    python3 benchmarks/agreement.py > docs/agreement.md
    python3 benchmarks/agreement.py --dynamic > docs/agreement_dynamic.md
    python3 benchmarks/agreement.py paper marching    # the rows of these alone
    python3 benchmarks/agreement.py --dynamic         # the page's second table, on full dynamics

The table of mistakes at the page's end is that of benchmarks/mutants.py.

Every shipped scenario runs as point masses, and on kinematic robots within speed limits of 1.5 m/s
and 360 deg/s, with commands at 50 Hz and at the 10 Hz of RosAria's odometry; those on robots run on
full dynamics, too, as they are shipped otherwise.
"""

import argparse
import concurrent.futures
import datetime
import itertools
import os
import sys
import tempfile

from mrs_simulator import load_scenario, run_experiment

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMITS = {"v_max": 1.5, "omega_max": 6.2832}
# name, fidelity, limits, rate [Hz]
CASES = (
    ("point masses, 50 Hz", "point_mass", "none", 50.0),
    ("robots, 50 Hz", "kinematic", LIMITS, 50.0),
    ("robots, 10 Hz", "kinematic", LIMITS, 10.0),
)
LEFT_OUT = (
    "paper_literal",
    "paper_dynamic",
    "paper_theory",
)  # the same law as paper, or meant to fail
ARMED = ("carrying",)  # of robots with arms, which are never points
DYNAMIC_CASES = (("full dynamics", "dynamic", None, None),)  # the scenario's own limits and rate
DYNAMIC_HEADER = """# On full dynamics

The shipped scenarios with robots that have masses, motors, contacts and friction, or hulls and rotors;
made by `python3 benchmarks/agreement.py --dynamic`, with numbers in brackets as
[without forces](agreement.md). A tolerance is what held commands and limits are computed to cost, and a
bound on slip; within it, the published law must show the same when it is given what robots made of their
commands
([where tolerances come from](verdict_numbers.md#where-tolerances-come-from)).

How much slip may cost is not derived. These bounds, beside what held commands and limits cost, are
round numbers above the worst that was measured over the runs of this table:

| bound | of what | the worst run | by which factor above it |
|---|---|---|---|
| 5 % | settling time | paper, 3.2 % | 1.5 |
| 5 cm | gap | lab_four, 2.8 cm (wheel odometry) | 1.7 |
| 2 cm | spread | lab_four, 1.4 cm (wheel odometry) | 1.5 |
| 5 cm | final place in a line | lab_four, 3.1 cm (wheel odometry) | 1.6 |
| 15 cm | place of a limit or a path | marching, 10.6 cm | 1.4 |
| 15 cm and 5 % of the radius | place under bearings alone | bearing_formation, 28 cm | 1.7 |
| 15 cm | drift of an invariant | bearing_formation, 12.3 cm | 1.2 |
| 5 cm, 0.05 rad | what is zero at the end, wherever that is | formation_boats, 3.1 cm | 1.6 |
| 0.05 | scale, bearings | bearing_formation, 0.025 | 2.0 |
| 5 % | rates, where friction lets them show | containment, 0.7 % | 7 |
| 2 % of the team's size | a spiral's distance from the exact one | cyclic_pursuit, 0.4 % | 5 |
| 0.1 % | growth of an energy in a sample | coverage, 4e-11 | |

For laws that see velocities or poses, and for robots with wheel odometry, only these bounds hold.
"""
HEADER = """# How far from theory

What each shipped scenario's claims measure on point masses and on robots; made by `python3
benchmarks/agreement.py > docs/agreement.md`. The robots are of the scenario's own kinds, kinematic,
with speeds limited to 1.5 m/s and 360 deg/s. The number in brackets is the share of the claim's
tolerance that the difference uses up ([where tolerances come
from](verdict_numbers.md#where-tolerances-come-from)). Where speed limits cost a claim more than it
allows, only the part of the run after they have let go is judged. A dash means not judged: a condition
does not hold, robots touched, limits left no rest of the run, or the run is too short for the claim.
Bold means outside the claim's tolerance. Collisions are those of bodies, which point masses do not have.

Gain, dead time and bias are fitted from samples at 10 Hz. Commands at 50 Hz that jump between samples are
not in the record: where edges fail, events come or sensors are noisy nothing is fitted; with
`record_rate: 50` it is.

Robots use up nearly all of a tolerance that is computed, since held commands, ramps and limits cost
them what they cost in the computation; only a tenth of what points are allowed comes on top.

Two more pages tell how robots do [on full dynamics](agreement_dynamic.md), and [which wrong laws are
caught](mistakes.md).
"""


def run(task):
    """Return the verdict of one scenario in one case."""
    path, fidelity, limits, rate = task
    scenario = load_scenario(path)
    limits = scenario.to_dict()["limits"] if limits is None else limits
    control = dict(scenario.control.to_plain(), rate=rate or scenario.control.rate)
    control["saturation"] = "none" if fidelity == "point_mass" else scenario.control.saturation
    if control["saturation"] == "none" and fidelity != "point_mass":
        control["saturation"] = "robot"
    content = dict(scenario.to_dict(), fidelity=fidelity, limits=limits, control=control)
    if rate is not None:
        content.pop("step", None)
    if fidelity == "point_mass":  # which has no wheels
        content["odometry"] = "world"
    try:
        from mrs_simulator.scenario.scenario import scenario_from_dict

        with tempfile.TemporaryDirectory() as out:
            return run_experiment(scenario_from_dict(content, path), out, formats=())
    except ValueError as error:
        return {"checks": [], "error": str(error)}


def cell(check):
    """Return one measured value as Markdown."""
    if check is None or check["passed"] is None:
        return "-"
    value = check["measured"]
    if value is None:
        return "**not measurable**"
    text = "{:.3g}".format(value) if isinstance(value, float) else str(value)
    if check["tolerance"] and check["difference"] is not None:
        text += " ({})".format(share(check))
    return text if check["passed"] else "**{}**".format(text)


def share(check):
    """Return how much of its tolerance a check used up, in percent, or that a bound was not reached."""
    difference = check["difference"]
    bound = {"at most": 1.0, "at least": -1.0}.get(check["note"].split(",")[0])
    used = abs(difference) if bound is None else bound * difference
    return "below" if used < 0.0 else "{:.2g} %".format(100.0 * used / check["tolerance"])


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--dynamic", action="store_true", help="on full dynamics")
    parser.add_argument("names", nargs="*", help="of shipped scenarios, by default all")
    arguments = parser.parse_args()
    folder = os.path.join(ROOT, "scenarios")
    paths = {
        n[:-5]: os.path.join(folder, n) for n in sorted(os.listdir(folder)) if n[-5:] == ".yaml"
    }
    names = arguments.names or [name for name in paths if name not in LEFT_OUT]
    if arguments.dynamic:
        names = [name for name in names if load_scenario(paths[name]).fidelity != "point_mass"]
    else:
        names = [name for name in names if name not in ARMED]
    cases = DYNAMIC_CASES if arguments.dynamic else CASES
    tasks = [(paths[name],) + case[1:] for name in names for case in cases]
    title, text = (DYNAMIC_HEADER if arguments.dynamic else HEADER).rstrip().split("\n\n", 1)
    print("{}\n\nFigures of {:%Y-%m-%d}.\n\n{}".format(title, datetime.date.today(), text))
    with concurrent.futures.ProcessPoolExecutor() as pool:
        print_table(names, cases, pool.map(run, tasks))


def print_table(names, cases, verdicts):
    """Print a section for each of the scenarios ``names``, as the ``verdicts`` of their ``cases`` come."""
    for name in names:
        print("\n## {}\n".format(name))
        print("| claim | predicted | {} |".format(" | ".join(case[0] for case in cases)))
        print("|---|---|" + "---|" * len(cases))
        found = list(itertools.islice(verdicts, len(cases)))
        print_scenario(found)
        sys.stdout.flush()
        for verdict in found:
            if "error" in verdict:
                print("not run: {}".format(verdict["error"]), file=sys.stderr)


def print_scenario(verdicts):
    """Print the rows of one scenario."""
    by_case = [{check["name"]: check for check in verdict["checks"]} for verdict in verdicts]
    claims = []
    for checks in by_case:
        claims += [c for c in checks if c not in claims and checks[c]["predicted"] != "holds"]
    for claim in claims:
        if claim in ("ended",):
            continue
        predicted = next(checks[claim]["predicted"] for checks in by_case if claim in checks)
        shown = "{:.4g}".format(predicted) if isinstance(predicted, float) else predicted
        cells = " | ".join(cell(checks.get(claim)) for checks in by_case)
        print("| {} | {} | {} |".format(claim.replace("|", "\\|"), shown, cells))


if __name__ == "__main__":
    main()
