#!/usr/bin/env python3
"""How fast other simulators run beside this one, round by round on the same machine.

    python3 benchmarks/peers.py [--rounds 3] [--seconds 2] [--robots 7 100 1000] [--keep]

Whatever of ARGoS, Stage, ir-sim, pybullet-fleet, the Robotarium and gym-pybullet-drones is installed takes
part: found as a command or as a package of this interpreter, never fetched.  Each row of each round is a
process of its own, which builds n robots in a line, 3 m apart (the Robotarium: in its arena), and runs for
some seconds of processor time.  Figures are medians of simulated seconds per second of processor time.
What each row includes is printed with it: they do not do the same.
"""

import argparse
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec

from history import Report

STEP = 0.02  # [s] where a simulator lets us choose
LONGEST = 120.0  # [s] of wall time for one row of one round
DRIVE = (0.3, 0.1)  # [m/s, rad/s], the command where a simulator runs no law of ours


class NotHere(Exception):
    """The simulator cannot take part; the message says why."""


def factor(step, simulated, seconds):
    """Return simulated over processor time of calls of ``step``, of ``simulated`` [s] each."""
    step()
    begin, count = time.process_time(), 0
    while time.process_time() - begin < seconds:
        step()
        count += 1
    return count * simulated / (time.process_time() - begin)


def chain(x, y, theta, k=0.2, c=2.0, l=0.05):
    """Return the paper's law for robots in a line, speeds and turn rates (n,), as a user writes it."""
    import numpy as np

    px, py = x + l * np.cos(theta), y + l * np.sin(theta)
    ux, uy = np.zeros_like(x), np.zeros_like(y)
    ux[:-1], uy[:-1] = -k * (px[:-1] - px[1:] - c), -k * (py[:-1] - py[1:])
    v = np.cos(theta) * ux + np.sin(theta) * uy
    return v, (np.cos(theta) * uy - np.sin(theta) * ux) / l


# This package ---------------------------------------------------------------------------------------


def ours(fidelity, protocol, compiled=False):
    """Return the measure of this package with a protocol of benchmarks/headless.py."""

    def measure(n, seconds):
        os.environ["MRS_SIMULATOR_COMPILED"] = str(int(compiled))
        import headless

        headless.WALL = seconds
        return headless.real_time_factor(n, fidelity, getattr(headless, protocol), True)

    return measure


# Packages of Python ---------------------------------------------------------------------------------


def irsim(n, seconds):
    """ir-sim without pictures."""
    import irsim as simulator
    import numpy as np

    robot = "  - {{kinematics: {{name: diff}}, shape: {{name: circle, radius: 0.25}}, state: [{}, 0, 0]}}\n"
    world = (
        "world: {{height: 100, width: {0}, offset: [-10, -50], step_time: {1}, sample_time: {1}}}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "line.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(world.format(3 * n + 20, STEP) + "robot:\n")
            file.writelines(robot.format(3.0 * i) for i in range(n - 1, -1, -1))
        world = simulator.make(path, display=False, disable_all_plot=True)

    def step():
        states = np.hstack([robot.state[:3] for robot in world.robot_list])
        v, omega = chain(*states)
        world.step(list(np.stack([v, omega], axis=1)[:, :, np.newaxis]))

    return factor(step, STEP, seconds)


def robotarium(n, seconds):
    """The Robotarium's Python simulator without pictures."""
    import numpy as np
    from rps.robotarium import Robotarium

    if n > 50:
        raise NotHere("takes 50 robots at most")
    start = np.zeros((3, n))
    start[0] = np.linspace(1.4, -1.4, n)
    given = dict(number_of_robots=n, show_figure=False, sim_in_real_time=False)
    given["initial_conditions"] = start
    try:
        world = Robotarium(skip_initialization=True, **given)
    except TypeError:  # releases before 2 have robots where they are wanted at once
        world = Robotarium(**given)

    def step():
        v, omega = chain(*world.get_poses(), c=0.2)
        world.set_velocities(np.arange(n), np.stack([v, omega]))
        world.step()

    period = world.TIME_STEP if hasattr(world, "TIME_STEP") else world.time_step
    return factor(step, period, seconds)


def pybullet_fleet(n, seconds):
    """pybullet-fleet without physics, as it recommends."""
    import numpy as np
    from pybullet_fleet.core_simulation import MultiRobotSimulationCore

    entities = [
        {
            "name": "robot{}".format(i + 1),
            "type": "agent",
            "urdf_path": "robots/mobile_robot.urdf",
            "controller": "differential",
            "pose": [3.0 * (n - 1 - i), 0.0, 0.05],
        }
        for i in range(n)
    ]
    simulation = {
        "timestep": STEP,
        "gui": False,
        "physics": False,
        "monitor": False,
        "target_rtf": 0,
    }
    world = MultiRobotSimulationCore.from_dict({"simulation": simulation, "entities": entities})
    if len(world.agents) != n:
        raise NotHere("made {} robots of {}".format(len(world.agents), n))
    controllers = [agent.controller for agent in world.agents]

    def step():
        poses = [agent.get_pose() for agent in world.agents]
        v, omega = chain(*np.array([[pose.x, pose.y, pose.yaw] for pose in poses]).T)
        for controller, forwards, turn in zip(controllers, v.tolist(), omega.tolist()):
            controller.set_velocity(vx=forwards, wz=turn)
        world.step_once()

    return factor(step, STEP, seconds)


def drones(n, seconds):
    """gym-pybullet-drones, whose rotors are told their hover speed."""
    import numpy as np
    from gym_pybullet_drones.envs.CtrlAviary import CtrlAviary

    places = np.array([[3.0 * i, 0.0, 1.0] for i in range(n)])
    world = CtrlAviary(num_drones=n, initial_xyzs=places, pyb_freq=200, ctrl_freq=50, gui=False)
    world.reset()
    hover = np.full((n, 4), world.HOVER_RPM)
    return factor(lambda: world.step(hover), STEP, seconds)


# Commands -------------------------------------------------------------------------------------------


def processor_time_of(command, simulated, folder):
    """Return ``simulated`` [s] over the processor time of ``command``; ``NotHere`` where it fails."""
    import resource

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        command, cwd=folder, timeout=LONGEST, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        lines = done.stdout.decode("utf-8", "replace").strip().splitlines() or ["no word"]
        raise NotHere("{}: exit code {}: {}".format(command[0], done.returncode, lines[-1]))
    took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return simulated / took


def by_command(write, simulated, most=math.inf):
    """Return the measure of a command that runs a file which ``write(folder, n, [s])`` writes.

    It runs twice as long until that takes the wanted processor time, at ``most`` so many simulated
    seconds; loading is taken off, as what a run of one step takes.
    """

    def measure(n, seconds):
        with tempfile.TemporaryDirectory() as folder:
            span = simulated
            load = STEP / processor_time_of(write(folder, n, STEP), STEP, folder)
            while True:
                took = span / processor_time_of(write(folder, n, span), span, folder) - load
                if took >= seconds or span >= most:
                    return span / took
                span = min(2.0 * span, most)

    return measure


LUA = """function init() end
function step() robot.wheels.set_velocity({:g}, {:g}) end
function reset() end
function destroy() end
"""
FOOTBOT = """  <foot-bot id="f{0}"><body position="{1},0,0" orientation="0,0,0"/>
   <controller config="c"/></foot-bot>
"""
ARGOS = """<?xml version="1.0"?>
<argos-configuration>
 <framework><system threads="0"/>
  <experiment length="{length}" ticks_per_second="50" random_seed="1"/></framework>
 <controllers><lua_controller id="c">
  <actuators><differential_steering implementation="default"/></actuators><sensors/>
  <params script="drive.lua"/></lua_controller></controllers>
 <arena size="{size},100,2" center="{middle},0,0">
{robots} </arena>
 <physics_engines><dynamics2d id="p" iterations="1"/></physics_engines>
 <media/>
</argos-configuration>
"""


def argos(folder, n, simulated):
    """Write an ARGoS experiment with foot-bots; return its command."""
    with open(os.path.join(folder, "drive.lua"), "w", encoding="utf-8") as file:
        lateral = 100.0 * DRIVE[1] * 0.07  # half of a foot-bot's track, speeds in cm/s
        file.write(LUA.format(100.0 * DRIVE[0] - lateral, 100.0 * DRIVE[0] + lateral))
    robots = "".join(FOOTBOT.format(i, 3.0 * i) for i in range(n))
    given = {"length": simulated, "size": 6 * n + 200, "middle": 1.5 * n, "robots": robots}
    with open(os.path.join(folder, "line.argos"), "w", encoding="utf-8") as file:
        file.write(ARGOS.format(**given))
    return ["argos3", "-z", "-n", "-c", "line.argos"]


# Stage moves robots at each step by the velocity in force, which a robot's own update takes back where no
# controller gives another: that comes once it is over.
OVER = 2000  # [s]
STAGE = """interval_sim 20
quit_time {}
speedup -1
define robot position (
 size [0.5 0.4 0.2] drive "diff" velocity [{} 0 0 {}] alwayson 1 update_interval {}000 )
"""


def stage(folder, n, simulated):
    """Write a world of Stage; return its command."""
    head = STAGE.format(simulated, DRIVE[0], math.degrees(DRIVE[1]), OVER)
    robots = ['robot( pose [ {} 0 0 0 ] name "r{}" )\n'.format(3.0 * i, i) for i in range(n)]
    with open(os.path.join(folder, "line.world"), "w", encoding="utf-8") as file:
        file.write(head + "".join(robots))
    return ["stage", "-g", "line.world"]


# The table ------------------------------------------------------------------------------------------

RECORDED = "limits, ramps, collisions, watchdogs, recorder at 10 Hz"
ROWS = {  # name: (package or command that it takes, measure, what is included)
    "by the hook": ("mrs_simulator", ours("kinematic", "ByHook"), "the law in Python, " + RECORDED),
    "by arrays": ("mrs_simulator", ours("kinematic", "Formation"), "the law, " + RECORDED),
    "by arrays, compiled": ("numba", ours("kinematic", "Formation", True), "the law, " + RECORDED),
    "full dynamics": ("pybullet", ours("dynamic", "Formation"), "the law, wheels, " + RECORDED),
    "ARGoS 3": ("argos3", by_command(argos, 10.0), "dynamics2d, one iteration a step, no law"),
    "Stage": (
        "stage",
        by_command(stage, 10.0, OVER),
        "collisions, a constant speed, no law, no sensors",
    ),
    "ir-sim": ("irsim", irsim, "the law by arrays, collisions"),
    "pybullet-fleet": ("pybullet_fleet", pybullet_fleet, "the law by arrays, poses, collisions"),
    "Robotarium": ("rps", robotarium, "the law by arrays, checks of collisions, steps of 33 ms"),
    "gym-pybullet-drones": ("gym_pybullet_drones", drones, "rigid bodies at 200 Hz, no law"),
}


def is_here(name):
    """Return whether what the row ``name`` takes is installed."""
    needed = ROWS[name][0]
    if needed in ("argos3", "stage"):
        return shutil.which(needed) is not None
    return bool(find_spec(needed))


def measured(name, n, seconds):
    """Return the figure of one row in a process of its own, or why there is none."""
    command = [sys.executable, os.path.abspath(__file__), "--row", name]
    command += ["--robots", str(n), "--seconds", str(seconds)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return "takes more than {:g} s".format(LONGEST)
    said = done.stdout.decode("utf-8", "replace").strip().splitlines()
    if done.returncode or not said:
        wrong = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["no word"]
        return wrong[-1]
    return float(said[-1])


def compare(arguments):
    """Run all rows in turn, round by round, and print the medians."""
    report = Report("peers", arguments.keep)
    here = [name for name in ROWS if is_here(name)]
    print("not installed: {}".format(", ".join(sorted(set(ROWS) - set(here))) or "none"))
    found = {(name, n): [] for name in here for n in arguments.robots}
    for k in range(arguments.rounds):
        for key in found:
            if not any(isinstance(value, str) for value in found[key]):
                found[key].append(measured(*key, arguments.seconds))
                told = "round {}: {}, {}: {}".format(k + 1, *key, found[key][-1])
                print(told, file=sys.stderr, flush=True)
    for (name, n), values in found.items():
        if isinstance(values[-1], str):
            print("{:44} {:>6} {}".format(name, n, values[-1]))
        else:
            report.note(name, n, statistics.median(values), "x real time")
    for name in here:
        print("{}: {}".format(name, ROWS[name][2]))
    report.close()


def main():
    """Print the table, or the figure of one ``--row``."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=2.0, help="of one measurement")
    parser.add_argument("--robots", type=int, nargs="+", default=[7, 100, 1000])
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    parser.add_argument("--row", choices=ROWS, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row is None:
        compare(arguments)
        return
    try:
        print(ROWS[arguments.row][1](arguments.robots[0], arguments.seconds))
    except NotHere as reason:
        sys.exit(str(reason))


if __name__ == "__main__":
    main()
