#!/usr/bin/env python3
"""How far robots with forces are beside the courses by which the safety filter brakes them.

    python3 benchmarks/courses.py [KIND ...] [--period TC] [--shares S ...] [--engine ENGINE]

A robot is commanded a share of its top speed, ahead, astern, across, or turning as well, for some
seconds; then zero.  From each command on the filter predicts its course, as ``docs/safety.md`` has it.  A
line tells the worst of all motions: the way until it stands, predicted from the last command and true; the
greatest distance from a prediction, and that beyond the bounds of the prediction without forces over the
speed: what ``run_on`` of the kind has to be.
"""

import argparse
from typing import NamedTuple

import numpy as np

from mrs_simulator import PioneerControl
from mrs_simulator.control.safety.braking_certificate import EXACT, WayOut
from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.vehicles.registry import kind as kind_named
from mrs_simulator.vehicles.registry import shipped_kinds
from mrs_simulator.world.world import EVERY, World

HELD = (0.3, 1.0, 5.0)  # [s] for which a command is held
LEFT = 0.01  # [-] of the speed, below which a robot stands
LONGEST = 60.0  # [s]
FASTEST = 6.0  # [m/s]
TURNS = 0.5  # [-] of the top rate


class Deviation(NamedTuple):
    """By how much a robot left its courses."""

    predicted: float  # [m] way until it stands, from the last command
    true: float  # [m]
    beside: float  # [m] at most
    run_on: float  # [s] at its speed
    sooner: float  # whether it was beside by more than its speed explains


class Still(PioneerControl):
    """A law that wants nothing."""

    DIMENSIONS = (2, 3)

    def pointMassLaw(self, hand):
        """Return zeros."""
        return np.zeros_like(hand)


def motions(drive):
    """Return the axes' shares of their tops in each motion of a drive, by name."""
    found = {"ahead": {"linear.x": 1.0}, "turning": {"linear.x": 1.0, "angular.z": TURNS}}
    found["astern"] = {"linear.x": -1.0}
    if "linear.y" in drive.AXES:
        found["across"] = {"linear.y": 1.0}
    if "linear.z" in drive.AXES:
        found["up"], found["down"] = {"linear.z": 1.0}, {"linear.z": -1.0}
    return found


def scenario_of(kind, period, engine, limits):
    """Return the scenario of one robot with forces."""
    content = {"model": [kind], "poses": [[0.0, 0.0, 0.3]], "fidelity": "dynamic"}
    content["control"] = {"rate": 1.0 / period, "safety": True}
    if limits in kind_named(kind).limits:
        content["limits"] = limits
    module = kind_named(kind).module
    if module.MEDIUM == "air":
        content["altitude"] = [100.0]
        content["control"]["dimension"] = 3
    if module.MEDIUM == "ground":
        content["engine"] = engine
    return scenario_from_dict(content)


def deviation(scenario, way, held):
    """Return the ``Deviation`` of a robot commanded ``way`` (1, a) for ``held`` [s]."""
    control, world = make_control(scenario, Still), World.from_scenario(scenario)
    seen = Seen(control, scenario.step)
    every = int(round(control.period / scenario.step))
    tops = None
    try:
        for k in range(int(LONGEST / scenario.step)):
            if k % every == 0:
                command = way if k * scenario.step < held else np.zeros_like(way)
                seen.note(world, command, k)
                world.set_commands(EVERY, command)
            world.step()
            seen.places.append(place_of(world))
            speed = np.linalg.norm(seen.places[-1] - seen.places[-2])
            tops = max(tops or 0.0, speed)
            if k * scenario.step > held + 0.5 and speed < LEFT * tops:
                break
    finally:
        world.close()
    return seen.deviation()


def place_of(world):
    """Return where the robot is, (3,) [m]."""
    z = world.z
    return np.array([*world.pose[0, :2], 0.0 if z is None else z[0]])


class Seen:
    """Where a robot has been, and the courses that were predicted from each command."""

    def __init__(self, control, step):
        self.places, self._step, self._period, self._courses = [], step, control.period, []
        self._way_out = WayOut(
            control.team, control.safety_filter.body_radii, control.period, "dynamic"
        )

    def note(self, world, command, k):
        """Predict the course under ``command``, given in step ``k``."""
        if not self.places:
            self.places.append(place_of(world))
        heights = np.array([self.places[-1][2]])
        course = self._way_out.course(command, world.pose, heights, world.time)
        speed = max(float(self._way_out.speeds[0]), float(course.speed[0]))
        self._courses.append((k, course, command.any(), speed))

    def deviation(self):
        """Return the ``Deviation``."""
        places = np.array(self.places)
        last = max(k for k, (_, _, moves, _) in enumerate(self._courses) if moves)
        found = [self._beside(places, each[0], each[1], each[3]) for each in self._courses[last:]]
        begin, course = self._courses[last][:2]
        way = float(np.linalg.norm(np.diff(course.place[:, 0], axis=0), axis=1).sum())
        true = float(np.linalg.norm(np.diff(places[begin:], axis=0), axis=1).sum())
        return Deviation(way, true, *np.max(found, axis=0))

    def _beside(self, places, begin, course, speed):
        """Return by how much [m] the robot left a ``course``, and as a part of its way."""
        line, place = course.place[:, 0], places[begin:, : course.place.shape[2]]
        time = self._step * np.arange(len(place))
        at = np.stack([np.interp(time, course.time, column) for column in line.T], axis=1)
        row = np.clip(np.searchsorted(course.time, time) - 1, 0, len(course.aside) - 1)
        away = np.linalg.norm(place - at, axis=1)
        beyond = np.maximum(away - course.aside[row, 0] - EXACT, 0.0)
        soon = (beyond > 2.0 * speed * time).any() and beyond.max() > 1e-9
        return float(away.max()), float(beyond.max()) / max(speed, 1e-9), float(soon)


def worst(kind, share, *how):
    """Return the worst ``Deviation`` of a ``kind`` at a ``share`` of its top speed, and its motion."""
    scenario = scenario_of(kind, *how)
    team, found = make_control(scenario, Still).team, []
    top = np.minimum(team.limits.of_all(1).top[0], FASTEST)
    for name, axes in motions(kind_named(kind).module).items():
        shares = [axes.get(axis, 0.0) * (share if "linear" in axis else 1.0) for axis in team.axes]
        for held in HELD:
            found.append((deviation(scenario, (top * shares)[np.newaxis], held), name, held))
    return max(found, key=lambda each: each[0].run_on)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = [name for name in shipped_kinds() if kind_named(name).arm is None]
    parser.add_argument("kinds", nargs="*", default=known, metavar="KIND")
    parser.add_argument("--period", type=float, default=0.1, help="[s] between commands")
    parser.add_argument("--shares", type=float, nargs="+", default=[0.1, 0.25, 1.0], metavar="S")
    parser.add_argument("--engine", default="pybullet", help="what moves robots on wheels")
    parser.add_argument("--limits", default="firmware", help="of the robots")
    given = parser.parse_args()
    text = "{:20}{:>7}{:>15}{:>10}{:>12}{:>12}"
    print(text.format("kind", "speed", "predicted [m]", "true [m]", "beside [m]", "run on [s]"))
    for kind in given.kinds:
        for share in given.shares:
            found, name, held = worst(kind, share, given.period, given.engine, given.limits)
            row = "{:20}{:>7.2f}{:>15.3f}{:>10.3f}{:>12.3f}{:>12.3f}{:>3.0f}  {}, {:g} s"
            print(row.format(kind, share, *found, name, held), flush=True)


if __name__ == "__main__":
    main()
