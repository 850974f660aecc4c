#!/usr/bin/env python3
"""A campaign inside the theorems' hypotheses: random starts of points, of which no claim may fail.

    python3 benchmarks/hypotheses.py                        # 100 starts of each protocol
    python3 benchmarks/hypotheses.py consensus --runs 10000 --results FILE   # goes on from FILE
    python3 benchmarks/hypotheses.py --results FILE --part 2/4   # of four machines that share FILE
    python3 benchmarks/hypotheses.py --results FILE --runs 10000 --table   # what FILE holds

Each protocol's scenario runs on points without limits, from places drawn uniformly from a box: that of
``BOXES``, else that of the scenario's own places, half as large again; headings and seeds are drawn as
well.  Laws of ``NEAR``, most of them by sensors, move robots as the scenario has them, from near its
places: what they say holds from there.  A start at which a condition of the theorem does not hold is
outside.  A claim that fails is a mistake: of a law, of the simulation, or of a claim that forgets what its
theorem needs.  Prints starts, how many were inside, in how many of these a claim of the theorem was judged,
and what failed; exits with 1 where one did.  Runs are in memory, as long as claims need, with a step of the
world from command to command; points, and laws by sensors, are judged by the theorem alone, but for every
``WHOLE``-th start.  Laws with a form that numba compiles are compiled.
"""

import argparse
import collections
import contextlib
import functools
import io
import json
import multiprocessing
import os
import sys
from importlib.util import find_spec

import numpy as np
from claims import ARMED, SCENARIOS

from mrs_simulator.core.claims import THEOREM
from mrs_simulator.core.compiling import VARIABLE
from mrs_simulator.study.search import default_space
from mrs_simulator.verdict.verdict import FAILED, HOLDS

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# Boxes (x_min, y_min, x_max, y_max) [m] of theorems that hold from some places alone, by protocol.
BOXES = {"rendezvous": [-1.3, -1.3, 1.3, 1.3], "limited_visibility": [-3.0, -3.0, 3.0, 3.0]}
# The first so many robots stay where the scenario has them: leaders that have to fit the shape.
KEPT = {"bearing_leaders": 2}
# How far places [m] and headings [rad] may be from the scenario's: of laws by sensors, which have to sense
# the wall, or the robot before them, from the start, and of one that turns robots, which points do not.
NEAR = {
    "exploration": (0.2, 3.0),
    "leader_follower": (0.5, 0.5),
    "sensed_following": (0.05, 0.05),
    "wall_following": (0.05, 0.05),
}
RATE = 10.0  # [Hz] of commands, at most: a hypothesis of held commands is nearer than at 50 Hz
# [Hz] of what 10 Hz puts outside, and of a law that is as fast as its sensor
RATES = {"event_triggered_consensus": 100.0, "rendezvous": 25.0, "sensed_following": 20.0}
# Shares of the scenario's duration after which all claims are judged, where that is not the whole.
LONG_ENOUGH = {
    "bearing_formation": 1.5,
    "bearing_leaders": 0.5,
    "cucker_smale": 0.25,
    "cyclic_pursuit": 0.3,
    "delayed_consensus": 0.6,
    "discrete_consensus": 0.6,
    "displacement_formation": 0.6,
    "distance_formation": 3.0,
    "event_triggered_consensus": 0.6,
    "exploration": 0.75,
    "flocking": 0.8,
    "leader_follower": 0.4,
    "limited_visibility": 0.5,
    "line_of_sight": 1.15,
    "marching": 0.25,
    "resilient_consensus": 0.45,
    "second_order_consensus": 0.7,
    "sensed_following": 0.6,
    "station_keeping": 0.75,
    "switching_consensus": 0.6,
    "vicsek": 0.3,
    "wall_following": 0.8,
}
WHOLE = 50  # every so many starts the whole verdict is made, with what compares points and law
OUTSIDE = "does not hold"  # the measured value of a condition
TOLD = "{}: {} starts, {} inside, {} judged, {} failed"
RUN_ENDED = "two samples"  # the condition that a run fails which ends at once


def names(wanted):
    """Return the protocols ``wanted``, by default all whose robots may be points."""
    from mrs_simulator.protocols import HOMES

    return [name for name in wanted or sorted(HOMES) if name not in ARMED]


def start(scenario, name, seed):
    """Return ``scenario`` of points, from places and with a seed drawn by ``seed``."""
    box, random = np.array(box_of(scenario, name)), np.random.default_rng(seed)
    kept = scenario.poses[: KEPT.get(name, 0)]
    places = list(kept[:, :2])
    while len(places) < scenario.n:
        place = random.uniform(box[:2], box[2:])
        if all(np.hypot(*(place - each)) >= default_space.FREE for each in places):
            places.append(place)
    headings = random.uniform(-np.pi, np.pi, scenario.n)
    headings[: len(kept)] = kept[:, 2]
    if name in NEAR:
        spread = np.array([NEAR[name][0]] * 2 + [NEAR[name][1]])
        places, headings = np.split(
            scenario.poses + random.uniform(-spread, spread, (scenario.n, 3)), [2], axis=1
        )
    poses = np.column_stack([places, headings]).tolist()
    return scenario.changed(seed=seed, poses=poses, **keys_of(scenario, name))


def keys_of(scenario, name):
    """Return the keys of a run of the protocol ``name`` under its rate of commands.

    Of points without limits, but for laws of ``NEAR``: what sensors see turns with robots alone.
    """
    rate = min(scenario.control.rate, RATES.get(name, RATE))
    control = dict(scenario.control.to_plain(), rate=rate)
    keys = {"step": 1.0 / rate, "record_rate": min(scenario.record_rate, rate)}
    if name not in NEAR:
        control["saturation"] = "none"
        keys.update(fidelity="point_mass", limits="none")
    return dict(keys, control=control, duration=duration_of(scenario, name))


def duration_of(scenario, name):
    """Return how long [s] the runs of the protocol ``name`` are."""
    return round(LONG_ENOUGH.get(name, 1.0) * scenario.duration, 0)


def box_of(scenario, name):
    """Return the box (x_min, y_min, x_max, y_max) [m] of the starts of the protocol ``name``."""
    return BOXES.get(name) or default_space.box_of(scenario.poses)


def run(task):
    """Return what became of a ``task``, (protocol, seed), a plain mapping."""
    name, seed = task
    found = {"protocol": name, "seed": seed, "judged": 0, "failed": {}, "error": "", "outside": []}
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        try:
            found.update(_judged(name, seed))
        except Exception as error:
            found["error"] = "{}: {}".format(type(error).__name__, error)
    return found


def _judged(name, seed):
    from mrs_simulator.study.run.experiment import played
    from mrs_simulator.verdict.judging import judged

    run, control = played(start(_scenario(name), name, seed))
    by_theorem = seed % WHOLE > 0
    if (
        by_theorem and control.SENSORS
    ):  # whose commands are not compared with what sensors should have read
        control._keep(published=lambda: None)
    points = by_theorem and name not in NEAR
    verdict = theorem_verdict(run, control) if points else judged(run, control)[0]
    checks = verdict["checks"]
    outside = [each["name"] for each in checks if each["measured"] == OUTSIDE]
    if RUN_ENDED in outside:
        raise RuntimeError("the run ended at once: {}".format(verdict["outcome"]))
    failed = {each["name"]: each["note"] for each in checks if each["passed"] is False}
    claims = [each for each in checks if each["question"] == THEOREM and each["predicted"] != HOLDS]
    count = sum(each["passed"] is not None for each in claims)
    if outside:
        failed, count = {}, 0
    return {"judged": count, "outcome": verdict["outcome"], "failed": failed, "outside": outside}


def theorem_verdict(run, control):
    """Return the verdict on a ``run`` of points by the theorem alone; they are its exact solution.

    That points go where the published law has them is known to rounding of each run that is judged wholly.
    Only of a claim that fails has the theorem to be asked whether the run was long enough.
    """
    from mrs_simulator.verdict.judging import checked_claims
    from mrs_simulator.verdict.theory.theorem import Points
    from mrs_simulator.verdict.verdict import Theory, judge

    run, faults = run.in_space(control.dimension), []
    claims = checked_claims(control.all_claims(run.hand[0]), run, faults)
    verdict = judge(run, claims + faults, theory=Theory(run))
    if verdict["outcome"] != FAILED:
        return verdict
    return judge(run, claims + faults, theory=Theory(run, points=Points(control, run, run, {})))


@functools.lru_cache(maxsize=None)
def _scenario(name):
    from mrs_simulator import load_scenario

    return load_scenario(os.path.join(ROOT, "scenarios", SCENARIOS.get(name, name) + ".yaml"))


def tasks_left(protocols, runs, path):
    """Return the tasks that are still to be run, and what ``path`` holds of the others."""
    done = []
    if path and os.path.exists(path):
        with open(path) as file:
            done = [json.loads(line) for line in file if line.endswith("\n")]
    done = [each for each in done if each["protocol"] in protocols and each["seed"] < runs]
    known = {(each["protocol"], each["seed"]): each for each in done}
    tasks = [(name, seed) for name in protocols for seed in range(runs)]
    return [task for task in tasks if task not in known], list(known.values())


def campaign(arguments):
    """Run what is left, and return all results."""
    tasks, done = tasks_left(names(arguments.protocols), arguments.runs, arguments.results)
    part, parts = map(int, arguments.part.split("/"))
    tasks = [(name, seed) for name, seed in tasks if seed % parts == part - 1]
    os.environ.setdefault(VARIABLE, "1" if find_spec("numba") else "0")
    os.environ.setdefault(
        "OPENBLAS_NUM_THREADS", "1"
    )  # of a few robots, many threads wait for each other
    with contextlib.ExitStack() as stack:
        log = stack.enter_context(open(arguments.results or os.devnull, "a"))
        anew = multiprocessing.get_context(
            "spawn"
        )  # numpy reads the number of threads as it is loaded
        pool = stack.enter_context(anew.Pool(arguments.jobs, maxtasksperchild=1000))
        for result in pool.imap_unordered(run, tasks, chunksize=1):
            done.append(result)
            log.write(json.dumps(result) + "\n")
            log.flush()
    return done


def main():
    """Run the campaign and say what failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("protocols", nargs="*", help="in this order, by default all")
    parser.add_argument("--runs", type=int, default=100, help="of each protocol")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--results", help="a file to which each result is added")
    parser.add_argument(
        "--part", default="1/1", metavar="K/N", help="the K-th of N parts of the seeds"
    )
    parser.add_argument("--table", action="store_true", help="of what --results holds; run nothing")
    arguments = parser.parse_args()
    if arguments.table:
        _, results = tasks_left(names(arguments.protocols), arguments.runs, arguments.results)
        print("| protocol | starts | inside | judged | failed |\n|---|---|---|---|---|")
    else:
        results = campaign(arguments)
    row = "| `{}` | {} | {} | {} | {} |" if arguments.table else TOLD
    by_protocol = collections.defaultdict(list)
    for each in results:
        by_protocol[each["protocol"]].append(each)
    for name, own in sorted(by_protocol.items()):
        wrong = [each for each in own if each["failed"] or each["error"]]
        inside = [each for each in own if not each["outside"] and not each["error"]]
        judged = sum(each["judged"] > 0 for each in inside)
        print(row.format(name, len(own), len(inside), judged, len(wrong)))
        for each in wrong[:3]:
            print("  seed {}: {}".format(each["seed"], each["error"] or each["failed"]))
    return int(any(each["failed"] or each["error"] for each in results))


if __name__ == "__main__":
    sys.exit(main())
