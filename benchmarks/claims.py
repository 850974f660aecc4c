#!/usr/bin/env python3
"""A campaign of false theorems: each claim of the shipped laws is made wrong, and has to fail.

    python3 benchmarks/claims.py                       # over all shipped protocols
    python3 benchmarks/claims.py consensus marching    # of these alone
    python3 benchmarks/claims.py --table               # as a table in Markdown

Predicted rates and times are off by 3 %, all others by three of the tolerances typed beside them, up and
down; bounds are left out.  Each protocol's scenario runs on points without limits and on kinematic robots;
robots with arms are no points.  A claim that passed there has to fail with the wrong number, not to pass or
to be left unjudged.  Exits with 1 where one does not, and where a run ends with an error.
"""

import argparse
import contextlib
import io
import multiprocessing
import os
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
POINTS, ROBOTS = "points", "robots"
ARMED = {"carrying"}  # protocols of robots with arms
SCENARIOS = {"formation": "paper_four"}  # of protocols without one of their name


def scenarios(names):
    """Return ``(protocol, points or robots)`` of the protocols ``names``, by default all."""
    from mrs_simulator.protocols import HOMES

    modes = {name: (ROBOTS,) if name in ARMED else (POINTS, ROBOTS) for name in names or HOMES}
    return [(name, mode) for name in modes for mode in modes[name]]


def run(task):
    """Return ``(task, how many claims were tried, those not noticed by name, error)``."""
    name, mode = task
    with contextlib.redirect_stderr(io.StringIO()):
        try:
            return (task, *_unnoticed(name, mode), "")
        except Exception as error:
            return task, 0, {}, "{}: {}".format(type(error).__name__, error)


def _unnoticed(name, mode):
    from mrs_simulator import load_scenario
    from mrs_simulator.study.check.claim_mistakes import confirmed, mistaken, shift_of
    from mrs_simulator.study.run.experiment import perform
    from mrs_simulator.verdict.judging import judged

    scenario = load_scenario(os.path.join(ROOT, "scenarios", SCENARIOS.get(name, name) + ".yaml"))
    with tempfile.TemporaryDirectory() as out:
        run, control = perform(_moved(scenario, mode), out)
    right = judged(run, control)[0]
    wrong = [judged(run, mistaken(control, sign))[0] for sign in (1.0, -1.0)]
    start = run.in_space(control.dimension).hand[0]
    tried = {claim.name for claim in control.all_claims(start) if shift_of(claim)}
    passed = {check["name"] for check in right["checks"] if check["passed"]}
    return len(tried & passed), confirmed(right, wrong)


def _moved(scenario, mode):
    if mode == POINTS:
        control = scenario.control._replace(saturation="none")
        return scenario._replace(fidelity="point_mass", limits=None, control=control)
    return scenario if scenario.fidelity == "kinematic" else scenario.changed(fidelity="kinematic")


def results(tasks):
    """Yield what :func:`run` returns of each task; a process for each."""
    import numpy  # noqa: F401  shared by all processes

    context = multiprocessing.get_context("fork")
    with context.Pool(min(2, os.cpu_count()), maxtasksperchild=1) as pool:
        yield from pool.imap(run, tasks, chunksize=1)


def main():
    """Run the campaign and say which wrong claims were not noticed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--table", action="store_true", help="print a table in Markdown")
    parser.add_argument("protocols", nargs="*", help="by default all")
    arguments = parser.parse_args()
    row = "| {} | {} | {} | {} |" if arguments.table else "{:26} {:7} {:>6} {}"
    print(row.format("protocol", "moved", "claims", "with a wrong number not noticed"))
    if arguments.table:
        print("|---|---|---|---|")
    bad = False
    for (name, mode), judged, missed, error in results(scenarios(arguments.protocols)):
        bad |= bool(missed or error)
        text = "not run: " + error if error else "; ".join(map(told, missed.values())) or "none"
        print(row.format(name, mode, judged, text), flush=True)
    sys.exit(1 if bad else 0)


def told(check):
    """Return which wrong claim was not noticed, in words."""
    outcome = "passed" if check["passed"] else "not judged"
    numbers = [check[key] for key in ("predicted", "measured", "tolerance")]
    shown = ["-" if number is None else "{:.4g}".format(number) for number in numbers]
    text = "{} {}: {} predicted, {} measured, tolerance {}".format(check["name"], outcome, *shown)
    return "{} ({})".format(text, check["note"][:60]) if check["note"] else text


if __name__ == "__main__":
    main()
