#!/usr/bin/env python3
"""How far robots on wheels are from where pybullet's untuned solver has them, by engine and manoeuvre.

    python3 benchmarks/engines.py

Each kind spins, drives an S-curve, brakes and pushes a Pioneer, under its highest limits, for 4 s beside
the same robot in steps of 1/240 s with 50 iterations: greatest distance [mm], of headings [mrad].
"""

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.vehicles import Team
from mrs_simulator.world.motion.wheeled import MOTIONS

UNTUNED = {"substep": 1.0 / 240.0, "iterations": 50}
KINDS = (
    "pioneer3dx", "amigobot", "turtlebot3_burger", "epuck", "pioneer3at", "husky", "youbot", "robotino3",
    "f1tenth",
)  # fmt: skip
SECONDS, STEP = 4.0, 0.02  # [s]


def spin(t, is_car):
    """Return forward speed [m/s] and turn rate [rad/s]; a car turns along its circle."""
    return float(is_car and t < 2.5), 3.0 * (t < 2.5)


def curve(t, is_car):
    """Return those of an S-curve."""
    return 0.7, 1.5 * np.sin(2.0 * t)


def brake(t, is_car):
    """Return those of a robot that drives as fast as it may, and stops."""
    return (4.0 if is_car else 1.2) * (t < 2.0), 0.0


def push(t, is_car):
    """Return those of a robot that pushes slowly."""
    return 0.3, 0.0


def trajectory(engine, kinds, poses, commands, **options):
    """Return the poses (steps, n, 3) of robots under ``commands(t)`` for the first; the others stand."""
    motion = MOTIONS[engine](kinds, poses, limits="top", step=STEP, **options)
    columns = [motion.team.axes.index(axis) for axis in ("linear.x", "angular.z")]
    command, found = np.zeros((len(kinds), len(motion.team.axes))), []
    for step in range(int(SECONDS / STEP)):
        command[0, columns] = commands(step * STEP)
        motion.advance(command)
        found.append(motion.pose.copy())
    motion.close()
    return np.array(found)


def deviations(name, manoeuvre):
    """Return by engine the greatest distance [m] and difference of headings [rad]."""
    kind = Team([name]).kinds[0]
    kinds, poses = [name], np.zeros((1, 3))
    if manoeuvre is push:
        kinds, poses = [name, "pioneer3dx"], np.zeros((2, 3))
        poses[1] = [kind.body.front + 0.5, 0.03, 0.2]

    def commands(t):
        return manoeuvre(t, kind.drive == "car")

    reference = trajectory("pybullet", kinds, poses, commands, **UNTUNED)
    result = {}
    for engine in MOTIONS:
        apart = trajectory(engine, kinds, poses, commands) - reference
        away = np.hypot(apart[..., 0], apart[..., 1]).max()
        result[engine] = away, np.abs(wrap_angle(apart[..., 2])).max()
    return result


def main():
    """Print the table."""
    manoeuvres = (spin, curve, brake, push)
    print("| kind, engine | {} |".format(" | ".join(each.__name__ for each in manoeuvres)))
    print("|---|" + "---|" * len(manoeuvres))
    for name in KINDS:
        found = [deviations(name, manoeuvre) for manoeuvre in manoeuvres]
        for engine in MOTIONS:
            cells = ["{:.1f}, {:.1f}".format(*(1e3 * np.array(each[engine]))) for each in found]
            print("| {}, {} | {} |".format(name, engine, " | ".join(cells)))


if __name__ == "__main__":
    main()
