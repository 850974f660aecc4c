#!/usr/bin/env python3
"""How fast other simulators run, each in its own usual setting, on the machine of the other benchmarks.

    [MRS_SIMULATOR_PEERS=DIR] python3 benchmarks/peers.py [--rounds 3] [--seconds 1] [--keep] [NAME ...]

Whatever of ARGoS, Stage, ir-sim, pybullet-fleet, the Robotarium, MuJoCo and gym-pybullet-drones is
installed takes part, never fetched: as packages and commands of the virtual environment ``DIR``, else
of this interpreter and of the path.  Each row of each round is a process of its own, which builds n
robots in a line, 3 m apart (the Robotarium: in its arena), and lets them drive from their start for a
second of wall time.  Figures are medians of simulated seconds per second of wall time; loading is left
out.  What each row includes is printed with it: they do not do the same.
"""

import argparse
import glob
import math
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Callable, NamedTuple

from history import Report

STEP = 0.02  # [s] where a simulator lets us choose
LONGEST = 60.0  # [s] of wall time for one row of one round
PEERS = "MRS_SIMULATOR_PEERS"  # where other simulators are
DRIVE = (0.3, 0.1)  # [m/s, rad/s], the command where a simulator runs no law of ours


class NotHere(Exception):
    """The simulator cannot take part; the message says why."""


def factor(step, simulated, seconds):
    """Return simulated over wall time of calls of ``step``, of ``simulated`` [s] each."""
    step()
    begin, count = time.perf_counter(), 0
    while time.perf_counter() - begin < seconds:
        step()
        count += 1
    return count * simulated / (time.perf_counter() - begin)


def chain(x, y, theta, k=0.2, c=2.0, l=0.05):
    """Return the paper's law for robots in a line, speeds and turn rates (n,), as a user writes it."""
    import numpy as np

    px, py = x + l * np.cos(theta), y + l * np.sin(theta)
    ux, uy = np.zeros_like(x), np.zeros_like(y)
    ux[:-1], uy[:-1] = -k * (px[:-1] - px[1:] - c), -k * (py[:-1] - py[1:])
    v = np.cos(theta) * ux + np.sin(theta) * uy
    return v, (np.cos(theta) * uy - np.sin(theta) * ux) / l


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
    """gym-pybullet-drones as its examples run it: bullet at 240 Hz, its controllers at 48 Hz, hovering."""
    import numpy as np
    from gym_pybullet_drones.control.DSLPIDControl import DSLPIDControl
    from gym_pybullet_drones.envs.CtrlAviary import CtrlAviary
    from gym_pybullet_drones.utils.enums import DroneModel, Physics

    rate, side = 48, math.ceil(math.sqrt(n))
    places = np.array([[k % side, k // side, 1.0] for k in range(n)])
    given = dict(num_drones=n, initial_xyzs=places, physics=Physics.PYB, gui=False)
    world = CtrlAviary(drone_model=DroneModel.CF2X, pyb_freq=240, ctrl_freq=rate, **given)
    controls = [DSLPIDControl(drone_model=DroneModel.CF2X) for _ in range(n)]
    action = np.zeros((n, 4))
    world.reset()

    def step():
        seen = world.step(action)[0]
        for row, control in enumerate(controls):
            action[row] = control.computeControlFromState(
                control_timestep=1.0 / rate, state=seen[row], target_pos=places[row]
            )[0]

    return factor(step, 1.0 / rate, seconds)


ROVER = """<body pos="{x} 0 0.1"><freejoint/>
 <geom type="box" size="0.22 0.16 0.06" pos="0 0 0.02" mass="9"/>
 <geom type="sphere" size="0.04" pos="-0.18 0 -0.06" friction="0.001" mass="0.2"/>
 <body pos="0.05 0.19 0"><joint name="l{k}" axis="0 1 0"/>
  <geom type="cylinder" size="0.1 0.02" euler="90 0 0" mass="0.5"/></body>
 <body pos="0.05 -0.19 0"><joint name="r{k}" axis="0 1 0"/>
  <geom type="cylinder" size="0.1 0.02" euler="90 0 0" mass="0.5"/></body></body>
"""
MOTORS = '<velocity joint="l{k}" kv="5"/><velocity joint="r{k}" kv="5"/>'
MUJOCO = """<mujoco><option timestep="0.005" integrator="implicitfast"/>
<worldbody><geom type="plane" size="0 0 1"/>{}</worldbody><actuator>{}</actuator></mujoco>
"""


def mujoco(n, seconds):
    """MuJoCo: rovers on two driven wheels and a caster, steps of 5 ms, wheels told a constant speed."""
    import mujoco as simulator

    rovers = "".join(ROVER.format(x=3.0 * k, k=k) for k in range(n))
    motors = "".join(MOTORS.format(k=k) for k in range(n))
    model = simulator.MjModel.from_xml_string(MUJOCO.format(rovers, motors))
    data = simulator.MjData(model)
    forwards, lateral = DRIVE[0] / 0.1, DRIVE[1] * 0.19 / 0.1  # [rad/s]
    data.ctrl[0::2], data.ctrl[1::2] = forwards - lateral, forwards + lateral
    return factor(lambda: simulator.mj_step(model, data, 4), STEP, seconds)


# Commands -------------------------------------------------------------------------------------------


def wall_time_of(command, folder):
    """Return the wall time [s] of ``command``; ``NotHere`` where it fails."""
    begin = time.perf_counter()
    done = subprocess.run(
        command, cwd=folder, timeout=LONGEST, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    took = time.perf_counter() - begin
    if done.returncode:
        lines = done.stdout.decode("utf-8", "replace").strip().splitlines() or ["no word"]
        raise NotHere("{}: exit code {}: {}".format(command[0], done.returncode, lines[-1]))
    return took


def by_command(write, simulated, most=math.inf):
    """Return the measure of a command that runs a file which ``write(folder, n, [s])`` writes.

    It runs longer until that takes the wanted time, at ``most`` so many simulated seconds; loading is taken
    off, as what a run of one step takes.
    """

    def measure(n, seconds):
        with tempfile.TemporaryDirectory() as folder:
            span = simulated
            load = wall_time_of(write(folder, n, STEP), folder)
            while True:
                took = wall_time_of(write(folder, n, span), folder) - load
                if took >= seconds or span >= most:
                    return span / took
                longer = min(8.0, max(1.2 * seconds / max(took, 1e-3), 1.5))
                span = min(longer * span, most)

    return measure


CONTROLLER = """#include <argos3/core/control_interface/ci_controller.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_actuator.h>
using namespace argos;
class Drive : public CCI_Controller {{
   void Init(TConfigurationNode&) override {{
      GetActuator<CCI_DifferentialSteeringActuator>("differential_steering")->SetLinearVelocity({}, {});
   }}
}};
REGISTER_CONTROLLER(Drive, "drive")
"""
FOOTBOT = """  <foot-bot id="f{0}"><body position="{1},0,0" orientation="0,0,0"/>
   <controller config="c"/></foot-bot>
"""
ARGOS = """<?xml version="1.0"?>
<argos-configuration>
 <framework><system threads="0"/>
  <experiment length="{length}" ticks_per_second="50" random_seed="1"/></framework>
 <controllers><drive id="c" library="./libdrive">
  <actuators><differential_steering implementation="default"/></actuators><sensors/><params/>
 </drive></controllers>
 <arena size="{size},100,2" center="{middle},0,0">
{robots} </arena>
 <physics_engines><dynamics2d id="p" iterations="1">
  <spatial_hash cell_size="0.2" cell_num="{cells}"/></dynamics2d></physics_engines>
 <media/>
</argos-configuration>
"""


def drive_of_argos(folder):
    """Compile the controller of ARGoS's robots into ``folder``, as users do; ``NotHere`` if it fails."""
    lateral = 100.0 * DRIVE[1] * 0.07  # half of a foot-bot's track, speeds in cm/s
    with open(os.path.join(folder, "drive.cpp"), "w", encoding="utf-8") as file:
        file.write(CONTROLLER.format(100.0 * DRIVE[0] - lateral, 100.0 * DRIVE[0] + lateral))
    prefix = os.path.dirname(os.path.dirname(shutil.which("argos3")))
    paths = [os.path.join(prefix, "include"), *glob.glob("/usr/include/lua5.*")]
    command = ["c++", "-shared", "-fPIC", "-O2", *("-I" + path for path in paths)]
    done = subprocess.run(
        [*command, "-o", "libdrive.so", "drive.cpp"], cwd=folder, stderr=subprocess.PIPE
    )
    if done.returncode:
        lines = [line for line in done.stderr.decode().splitlines() if "error" in line]
        raise NotHere("; ".join(lines[:1]) or "no compiler")


def argos(folder, n, simulated):
    """Write an ARGoS experiment with foot-bots, whose controller is in C++; return its command."""
    if not os.path.exists(os.path.join(folder, "libdrive.so")):
        drive_of_argos(folder)
    robots = "".join(FOOTBOT.format(i, 3.0 * i) for i in range(n))
    given = {"length": simulated, "size": 6 * n + 200, "middle": 1.5 * n, "robots": robots}
    with open(os.path.join(folder, "line.argos"), "w", encoding="utf-8") as file:
        file.write(ARGOS.format(cells=10 * n, **given))
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


class Row(NamedTuple):
    """A simulator: how it is found, measured, and what a figure includes."""

    needed: str  # a command, or a distribution of Python's with its version
    measure: Callable
    included: str
    sizes: tuple = (7, 100, 1000)


ROWS = {
    "ARGoS": Row(
        "argos3", by_command(argos, 10.0), "dynamics2d, one iteration a step, a constant command in C++"
    ),
    "Stage": Row(
        "stage", by_command(stage, 10.0, OVER), "collisions, a constant command, no sensors"
    ),
    "ir-sim": Row("ir-sim", irsim, "a law in arrays, collisions"),
    "pybullet-fleet": Row(
        "pybullet-fleet", pybullet_fleet, "a law in arrays, collisions, no physics"
    ),
    "Robotarium": Row(
        "robotarium_python_simulator", robotarium, "a law in arrays, steps of 33 ms", (7,)
    ),
    "MuJoCo": Row("mujoco", mujoco, "two driven wheels with forces, steps of 5 ms, a constant command"),
    "gym-pybullet-drones": Row(
        "gym-pybullet-drones", drones, "quadrotors hover, 240 Hz, controllers at 48 Hz", (10, 100)
    ),
}  # fmt: skip
COMMANDS = {"argos3": "--version", "stage": "--help"}  # and what tells their version
VERSION = "import sys, importlib.metadata as m; print(m.version(sys.argv[1]))"


def found_in():
    """Return the interpreter in which other simulators are, and the path of their commands."""
    folder, path = os.environ.get(PEERS), os.environ.get("PATH", "")
    if not folder:
        return sys.executable, path
    programs = os.path.join(folder, "bin")
    return os.path.join(programs, "python3"), os.pathsep.join([programs, path])


def version(name):
    """Return the version of the simulator of the row ``name``, None where it is not installed."""
    needed, (python, path) = ROWS[name].needed, found_in()
    if needed in COMMANDS:
        command = [shutil.which(needed, path=path), COMMANDS[needed]]
    else:
        command = [python, "-c", VERSION, needed]
    if command[0] is None:
        return None
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    told = re.search(r"\d+\.\d[\w.-]*", done.stdout.decode("utf-8", "replace"))
    return told.group(0) if told else None


def measured(name, n, seconds):
    """Return the figure of one row in a process of its own, or why there is none."""
    python, path = found_in()
    command = [python, os.path.abspath(__file__), "--row", name]
    command += ["--robots", str(n), "--seconds", str(seconds)]
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=LONGEST, env=dict(os.environ, PATH=path)
        )
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
    versions = {name: version(name) for name in arguments.names or ROWS}
    missing = sorted(name for name, told in versions.items() if told is None)
    print("not installed: {}".format(", ".join(missing) or "none"))
    here = [name for name, told in versions.items() if told is not None]
    found = {(name, n): [] for name in here for n in ROWS[name].sizes}
    for k in range(arguments.rounds):
        for key in found:
            if not any(isinstance(value, str) for value in found[key]):
                found[key].append(measured(*key, arguments.seconds))
                told = "round {}: {}, {}: {}".format(k + 1, *key, found[key][-1])
                print(told, file=sys.stderr, flush=True)
    for (name, n), values in found.items():
        case = "{} {}".format(name, versions[name])
        if isinstance(values[-1], str):
            print("{:44} {:>6} {}".format(case, n, values[-1]))
        else:
            report.note(case, n, statistics.median(values), "x real time")
    for name in here:
        print("{}: {}".format(name, ROWS[name].included))
    report.close()


def main():
    """Print the table, or the figure of one ``--row``."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(ROWS))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=1.0, help="of one measurement")
    parser.add_argument("--keep", action="store_true", help="append the figures to the history")
    parser.add_argument("--row", choices=ROWS, help=argparse.SUPPRESS)
    parser.add_argument("--robots", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(ROWS))
    if unknown:
        parser.error("{}: wanted {}".format(", ".join(unknown), ", ".join(ROWS)))
    if arguments.row is None:
        compare(arguments)
        return
    try:
        print(ROWS[arguments.row].measure(arguments.robots, arguments.seconds))
    except NotHere as reason:
        sys.exit(str(reason))


if __name__ == "__main__":
    main()
