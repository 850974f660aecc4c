#!/usr/bin/env python3
"""Whether the safety filter keeps its promise: random crossings, measured by prisms over the outlines.

    python3 benchmarks/safety_campaign.py [--runs N] [--seed S] [--kinds A ...] [--jobs J] [--forces SHARE]
    python3 benchmarks/safety_campaign.py --seed S [--kinds A B ...] --only K
    python3 benchmarks/safety_campaign.py --seeds S T --runs N --results FILE

With ``--results`` each outcome is added to FILE as soon as it is there, a line of JSON, and runs that FILE
has are not run again: an interrupted campaign goes on where it was.  The table then is of all runs in FILE.

Each run draws a team (a kind alone, or several that can meet), starts, goals that make the robots cross,
limits, command rate and obstacles, which move slower than the robots or stand. The law is ``u = k (goal
- p)`` of points ``HAND`` before the axles of robots that turn; nearer ones have the heading of a robot
with ramps swing for ever, filter or not. It runs with the filter, and once more without it and with the
robots a kilometre apart from each other: the time that each needs alone. Clearances are those of upright
prisms over the robots' outlines, at every step. Robots that do not arrive alone are not judged by their
time.

Exits with 1 where two bodies touch, or where of the robots among others and obstacles that stand fewer than
95 % arrive within twice the time that they need alone.  Those that flee what moves are counted apart.
"""

import argparse
import itertools
import json
import multiprocessing
import os
import sys
import time
from typing import NamedTuple

import numpy as np

from mrs_simulator import PioneerControl
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.registry import kind as kind_named
from mrs_simulator.vehicles.registry import shipped_kinds
from mrs_simulator.verdict.requirements.clearances import clearance, of_obstacle, of_robot

ARRIVING = 0.95  # [-] share of the robots
SLOWER = 2.0  # [-] times the time alone
AT_GOAL = 0.05  # [-] of the way
AFTER = 1.0  # [s] for which runs go on after all arrived
LONGEST = 400.0  # [s] of a run without the filter
APART = 1000.0  # [m] between robots that are alone
# [m] within which bodies touch: without forces the world puts those that met side by side
TOUCHING = 1e-6
MIXED = {"ground": "mixed ground", "water": "mixed water", "air": "mixed air"}
BOTH = "ground and air"
WAYS = ("head on", "ring", "random")
HAND = 0.2  # [m]
RATES = (10.0, 20.0, 50.0)  # [Hz] of commands


# Drawing ---------------------------------------------------------------------------------------


class Case(NamedTuple):
    """One run: what it is called, its scenario as a mapping, the points' goals (n, d) [m] and the gain."""

    team: str
    content: dict
    goal: np.ndarray
    gain: float
    way: str


def medium(name):
    """Return in which a kind moves."""
    return kind_named(name).module.MEDIUM


def teams_of(kinds):
    """Return the teams that can be drawn: ``{name: kinds to draw from}``."""
    teams = {name: (name,) for name in kinds}
    plain = [name for name in kinds if kind_named(name).arm is None]
    media = {each: tuple(name for name in plain if medium(name) == each) for each in MIXED}
    teams.update({MIXED[each]: own for each, own in media.items() if len(own) > 1})
    if media["ground"] and media["air"]:
        teams[BOTH] = media["ground"] + media["air"]
    return teams


def drawn_kinds(draw, team, choice):
    """Return the kinds of 2 to 7 robots; of a mixed team at least two, of ground and air one of each."""
    n = int(draw.integers(2, 8))
    if len(choice) == 1:
        return list(choice) * n
    names = [str(each) for each in draw.choice(choice, n)]
    if team == BOTH:
        names[0] = str(draw.choice([each for each in choice if medium(each) == "ground"]))
        names[1] = str(draw.choice([each for each in choice if medium(each) == "air"]))
    else:
        names[:2] = [str(each) for each in draw.choice(choice, 2, replace=False)]
    return names


def drawn_places(draw, n, spacing, way):
    """Return n starts and goals, (n, 2) [m], and how large [m] the place is from its middle."""
    size = spacing * draw.uniform(1.5, 3.0) * max(1.0, np.sqrt(n / 3.0))
    if way == "random":
        return apart(draw, n, spacing, size), apart(draw, n, spacing, size), size
    if way == "head on":
        # Pairs of opposite lanes; exactly symmetric half of the time.
        lane = spacing * 1.2 * (np.arange(n) // 2)
        side = np.where(np.arange(n) % 2, 1.0, -1.0)
        start = np.stack([size * side, lane - lane.mean()], axis=1)
        goal = start * [-1.0, 1.0]
    else:
        size = max(size, 0.6 * spacing / np.sin(np.pi / n))
        angle = 2.0 * np.pi * np.arange(n) / n
        start = size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        goal = -start
    noise = draw.choice([0.0, 0.05]) * spacing
    return start + draw.normal(0.0, noise, (n, 2)), goal, size + 0.5 * spacing


def apart(draw, n, spacing, size):
    """Return n points in a square of ``2 size`` [m], at least ``spacing`` [m] apart, (n, 2)."""
    points = []
    for attempt in itertools.count():
        wide = size * (1.0 + attempt / 1000.0)
        point = draw.uniform(-wide, wide, 2)
        if all(np.linalg.norm(point - each) >= spacing for each in points):
            points.append(point)
        if len(points) == n:
            return np.array(points)


def drawn_obstacles(draw, places, spacing, size, slowest):
    """Return up to three obstacles, free of ``places`` (m, 2), as a scenario has them."""
    found, height = [], 3.0
    for k in range(int(draw.integers(1, 4))):
        for _ in range(50):
            center, radius = draw.uniform(-size, size, 2), draw.uniform(0.1, 0.5) * spacing
            to = center + draw.uniform(-size, size, 2) if draw.uniform() < 0.4 else center
            line = center + np.linspace(0.0, 1.0, 40)[:, np.newaxis] * (to - center)
            far = np.linalg.norm(places[:, np.newaxis] - line, axis=2).min()
            if far > radius * np.sqrt(2.0) + spacing:
                break
        else:
            continue
        each = {"name": "thing{}".format(k + 1), "center": center.tolist(), "height": height}
        if draw.uniform() < 0.5:
            each.update(type="cylinder", radius=radius)
        else:
            sides = (radius * np.array([2.0, draw.uniform(0.4, 2.0)])).tolist()
            each.update(type="box", size=sides, yaw=float(draw.uniform(-3.0, 3.0)))
        if (to != center).any():
            speed = slowest * float(draw.uniform(0.05, 0.3))
            each["track"] = {"to": [to.tolist()], "speed": speed}
        found.append(each)
    return found


def drawn_heights(draw, team, names, way):
    """Return heights of start and goal, (n,) [m] each, and the law's dimension; None for the ground."""
    flies = np.array([medium(name) == "air" for name in names])
    if not flies.any():
        return None, None, 2
    if team == BOTH:  # low enough to meet those on the ground
        z = np.where(flies, draw.uniform(0.02, 0.3), 0.0)
        return z, z, 2
    if draw.uniform() < 0.5:
        z = np.full(len(names), 1.0)
        return z, z, 2
    return draw.uniform(1.0, 2.5, (2, len(names))).tolist() + [3]


def drawn(seed, index, kinds, forces):
    """Return the ``Case`` number ``index`` of ``seed``; the same for ever."""
    draw = np.random.default_rng([seed, index])
    teams = teams_of(kinds)
    team = list(teams)[index % len(teams)]
    names = drawn_kinds(draw, team, teams[team])
    way, rate, gain = str(draw.choice(WAYS)), float(draw.choice(RATES)), draw.uniform(0.2, 0.6)
    presets = set.intersection(*(set(kind_named(name).limits) for name in names))
    control = {"rate": rate, "parameters": {"l": HAND}}
    content = {"model": names, "control": control, "seed": int(draw.integers(1000))}
    limits = draw.choice(["default", "firmware", "top"])
    if limits in presets:
        content["limits"] = str(limits)
    if draw.uniform() < forces:
        content["fidelity"] = "dynamic"
        wheels = all(medium(name) == "ground" for name in names)
        if wheels and all(kind_named(name).arm is None for name in names):
            content["engine"] = "planar"
    content["poses"] = [[APART * k, 0.0, 0.0] for k in range(len(names))]
    numbers = Team.from_scenario(scenario_from_dict(content))
    lead = np.broadcast_to(numbers.lead(HAND), len(names))
    spacing = 2.6 * float((numbers.reach + lead).max()) + 0.3
    start, goal, size = drawn_places(draw, len(names), spacing, way)
    facing = np.arctan2(*(goal - start).T[::-1])
    yaw = facing if draw.uniform() < 0.5 else draw.uniform(-np.pi, np.pi, len(names))
    content["poses"] = np.column_stack([start, yaw]).tolist()
    low, high, dimension = drawn_heights(draw, team, names, way)
    if low is not None:
        content["altitude"] = np.asarray(low).tolist()
        content["control"]["dimension"] = dimension
    if dimension == 3:
        goal = np.column_stack([goal, high])
    content["control"]["safety"] = True
    if draw.uniform() < 0.5:
        places, slowest = np.concatenate([start, goal[:, :2]]), float(numbers.speeds[:, 0].min())
        things = drawn_obstacles(draw, places, spacing, size, slowest)
        content.update(obstacles=things)
        content["control"]["safety"] = {"obstacles": True}
    return Case(team, content, goal, float(gain), way)


# Running ---------------------------------------------------------------------------------------


def law(goal, gain):
    """Return the protocol ``u = gain (goal - p)``."""

    class Goals(PioneerControl):
        DIMENSIONS = (2, 3)

        def pointMassLaw(self, hand):
            return gain * (goal - hand)

    return Goals


class Way(NamedTuple):
    """Where n robots were at each of m steps, and when each arrived, (n,) [s]."""

    time: np.ndarray
    pose: np.ndarray
    z: np.ndarray
    arrived: np.ndarray
    deadlock: bool
    collisions: int  # that the world reported


def travelled(content, goal, gain, longest):
    """Return the ``Way`` of a run, until ``AFTER`` all robots arrived or the time is ``longest`` [s]."""
    scenario = scenario_from_dict(dict(content, duration=longest))
    scenario = scenario._replace(record_rate=1.0 / scenario.step)
    experiment = Experiment(scenario, law(goal, gain))
    control, arrived = experiment.control, np.full(scenario.n, np.inf)
    times, poses, heights, near = [], [], [], None
    try:
        for stamp, pose, _ in experiment.samples():
            z = experiment.world.z
            z = np.zeros(scenario.n) if z is None else z.copy()
            points = control.points(np.column_stack([pose, z]) if goal.shape[1] == 3 else pose)
            away = np.linalg.norm(goal - points, axis=1)
            near = np.maximum(AT_GOAL * away, 0.02) if near is None else near
            arrived = np.where((away <= near) & np.isinf(arrived), stamp, arrived)
            times.append(stamp)
            poses.append(pose)
            heights.append(z)
            if stamp > arrived.max() + AFTER:
                break
        held, met = bool(control.safety_filter.deadlock), len(experiment.collisions)
    finally:
        experiment.world.close()
    return Way(np.array(times), np.array(poses), np.array(heights), arrived, held, met)


def least_clearance(a, b):
    """Return the least clearance [m] of two prisms on their ways, and its time's index."""
    (first, reach), (second, other) = a.middle, b.middle
    bound = np.linalg.norm(first - second, axis=1) - reach - other
    guess = int(bound.argmin())
    found = float(clearance(a.at([guess]), b.at([guess]))[0])
    times = np.flatnonzero(bound <= found)
    if not len(times):
        return found, guess
    exact = clearance(a.at(times), b.at(times))
    return float(exact.min()), int(times[exact.argmin()])


def nearest(scenario, way, offset=0.0):
    """Return the least clearance [m] of a ``Way``, who and when [s]; ``offset`` (n, 2) is taken away."""
    pose = way.pose.copy()
    pose[..., :2] -= offset
    bodies = [kind.body for kind in Team.from_scenario(scenario).kinds]
    found = [
        ("robot{}".format(k + 1), of_robot(body, pose[:, k], way.z[:, k]))
        for k, body in enumerate(bodies)
    ]
    found += [(each.name, of_obstacle(each, way.time)) for each in scenario.obstacles]
    pairs = [(a, b) for a, b in itertools.combinations(found, 2) if a[0].startswith("robot")]
    least = [(*least_clearance(a[1], b[1]), a[0], b[0]) for a, b in pairs]
    value, when, first, second = min(least)
    return value, "{} and {} at {:.2f} s".format(first, second, way.time[when])


class Outcome(NamedTuple):
    """What became of one run."""

    index: int
    team: str
    forces: bool
    least: float  # [m]
    who: str
    alone: float  # [m] least clearance, had the robots gone as without the filter
    judged: int  # robots that arrive alone
    arrived: int  # of these, within twice the time
    deadlock: bool
    text: str  # of the case
    met: bool  # whether two bodies touched
    job: tuple  # (seed, index, kinds, forces)
    flees: bool  # whether an obstacle moved


def outcome(job):
    """Run case ``(seed, index, kinds, forces)`` with and without the filter; return the ``Outcome``."""
    seed, index, kinds, share = job
    case = drawn(seed, index, kinds, share)
    n = len(case.goal)
    offset = np.zeros((n, 2))
    offset[:, 1] = APART * np.arange(n)
    poses = np.array(case.content["poses"]) + np.column_stack([offset, np.zeros(n)])
    goal = case.goal + np.pad(offset, [(0, 0), (0, case.goal.shape[1] - 2)])
    control = dict(case.content["control"], safety=False)
    free = dict(case.content, poses=poses.tolist(), control=control, obstacles=[])
    alone = travelled(free, goal, case.gain, LONGEST)
    known = np.isfinite(alone.arrived)
    longest = SLOWER * float(alone.arrived[known].max(initial=1.0)) + AFTER
    way = travelled(case.content, case.goal, case.gain, np.ceil(longest))
    scenario = scenario_from_dict(case.content)
    least, who = nearest(scenario, way)
    in_time = way.arrived[known] <= SLOWER * alone.arrived[known]
    content = case.content
    text = "{}: {}, {} Hz, limits {}, {} obstacles".format(
        case.way,
        " ".join(content["model"]),
        content["control"]["rate"],
        content.get("limits", "by default"),
        len(scenario.obstacles),
    )
    forces = content.get("fidelity") == "dynamic"
    touched = nearest(scenario, alone, offset)[0]
    met = least < TOUCHING or way.collisions > 0
    flees = any("track" in each for each in content.get("obstacles", ()))
    counts = int(known.sum()), int(in_time.sum())
    return Outcome(
        index, case.team, forces, least, who, touched, *counts, way.deadlock, text, met, job, flees
    )


# Telling ---------------------------------------------------------------------------------------


def table(outcomes):
    """Return the lines of a table, one for each team, with and without forces."""
    head = "{:24}{:>7}{:>12}{:>10}{:>12}{:>10}{:>11}"
    names = "team", "runs", "least [m]", "contacts", "unfiltered", "in time", "deadlocks"
    lines = [head.format(*names)]
    keys = sorted({(each.team, each.forces) for each in outcomes})
    for team, forces in [*keys, ("all", None)]:
        own = [each for each in outcomes if forces is None or each[1:3] == (team, forces)]
        judged = sum(each.judged for each in own)
        row = (
            team + (", forces" if forces else ""),
            len(own),
            "{:.4f}".format(min(each.least for each in own)),
            sum(each.met for each in own),
            sum(each.alone < 0.0 for each in own),
            "{:.1f} %".format(100.0 * sum(each.arrived for each in own) / max(1, judged)),
            sum(each.deadlock for each in own),
        )
        lines.append(head.format(*row))
    return lines


def shares(outcomes):
    """Return lines on how many robots arrive in time, and the share of those without moving obstacles."""
    lines, last = [], 1.0
    for flees, what in ((True, "that move"), (False, "that stand, or none")):
        own = [each for each in outcomes if each.flees == flees]
        judged, arrived = (
            sum(getattr(each, name) for each in own) for name in ("judged", "arrived")
        )
        last = arrived / max(1, judged)
        text = "obstacles {}: {} of {} robots in time, {:.1f} %, in {} runs"
        lines.append(text.format(what, arrived, judged, 100.0 * last, len(own)))
    return lines, last


def repeated(job):
    """Return the command line that repeats one run."""
    seed, index, kinds, forces = job
    text = "python3 benchmarks/safety_campaign.py --seed {} --forces {:g}".format(seed, forces)
    if list(kinds) != list(shipped_kinds()):
        text += " --kinds " + " ".join(kinds)
    return text + " --only {}".format(index)


# Results that are kept -------------------------------------------------------------------------


def plain(job):
    """Return a job as a key."""
    seed, index, kinds, forces = job
    return seed, index, tuple(kinds), forces


def known_of(path):
    """Return the outcomes in a file of results, by their jobs; what is left of a line is cut."""
    if path is None or not os.path.exists(path):
        return {}
    with open(path, "rb+") as file:
        text = file.read()
        whole = text[: text.rfind(b"\n") + 1]
        file.truncate(len(whole))
    found = (json.loads(line) for line in whole.splitlines())
    return {plain(each["job"]): Outcome(**dict(each, job=plain(each["job"]))) for each in found}


def with_results(jobs, path, processes):
    """Run those of ``jobs`` that the file of results lacks; return all outcomes that it then has."""
    known = known_of(path)
    left = [job for job in jobs if plain(job) not in known]
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        for each in pool.imap_unordered(outcome, left):
            known[plain(each.job)] = each
            if path is not None:
                with open(path, "a", encoding="utf-8") as file:
                    file.write(json.dumps(each._asdict()) + "\n")
    return sorted(known.values(), key=lambda each: (each.job[0], each.index, each.job[3]))


def parsed():
    """Return the arguments."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = list(shipped_kinds())
    parser.add_argument("--runs", type=int, default=10000, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--kinds", nargs="+", choices=known, default=known, metavar="KIND")
    parser.add_argument("--jobs", type=int, default=1, metavar="J")
    parser.add_argument("--forces", type=float, default=0.1, help="share of runs with forces")
    parser.add_argument("--only", type=int, metavar="K", help="this run alone")
    parser.add_argument(
        "--seeds", type=int, nargs="+", metavar="S", help="several, instead of --seed"
    )
    parser.add_argument(
        "--results", metavar="FILE", help="to which outcomes are added, and which is resumed"
    )
    return parser.parse_args()


def main():
    """Run the campaign; print the table and what failed."""
    arguments, begun = parsed(), time.monotonic()
    indices = range(arguments.runs) if arguments.only is None else [arguments.only]
    shared = tuple(arguments.kinds), arguments.forces
    seeds = arguments.seeds or [arguments.seed]
    jobs = [(seed, index, *shared) for seed in seeds for index in indices]
    outcomes = with_results(jobs, arguments.results, arguments.jobs)
    for each in outcomes:
        if each.met or arguments.only is not None:
            print("run {}: {:.4f} m, {}; {}".format(each.index, each.least, each.who, each.text))
            print("    " + repeated(each.job))
        elif each.arrived < each.judged:
            late = "run {}: {} of {} robots arrived in time; {}"
            print(late.format(each.index, each.arrived, each.judged, each.text))
            print("    " + repeated(each.job))
    print("\n".join(table(outcomes)))
    print("{} runs in {:.0f} s".format(len(outcomes), time.monotonic() - begun))
    lines, share = shares(outcomes)
    print("\n".join(lines))
    sys.exit(any(each.met for each in outcomes) or share < ARRIVING)


if __name__ == "__main__":
    main()
