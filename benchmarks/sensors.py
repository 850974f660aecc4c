#!/usr/bin/env python3
"""What sensors cost: heard by nobody, heard by a law, rays and pictures alone.

    python3 benchmarks/sensors.py [--turns N] [--check] [--stage] [--keep]

With ``--keep`` rays and pictures go to benchmarks/history.csv; a law that reads lasers is in headless.py.
"""

import argparse
import io
import itertools
import os
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec

import numpy as np
import yaml
from history import Report

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.compiling import chosen, is_wanted
from mrs_simulator.scenario.scenario import scenario_from_dict
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.sensors.scenery import Rays, Scenery, cast
from mrs_simulator.sensors.state import State
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.study.run.experiment import Experiment
from mrs_simulator.vehicles import Team
from mrs_simulator.world.world import World

MOST = 1.02  # [-] what sensors may cost that nobody hears, of the CPU time without
SETTLING, WINDOW = (
    1.5,
    4.0,
)  # [s] of wall time that listeners take to be there, and of a measurement
WARM = 20  # [-] first turns that are not counted
NONE = [{"mounts": {"sonar": None}}]
LASER = [{"mounts": {"laser": {}}}]


class Idle(PioneerControl):
    """Stands, and asks for no sensor."""

    def pointMassLaw(self, hand):
        return 0.1 * (hand[::-1] - hand)


class Listens(Idle):
    """The same, with sonar and laser."""

    SENSORS = ("sonar", "laser")


def experiment(n, law, sensors, duration):
    """Return the ``Experiment`` of ``n`` robots among twenty boxes."""
    rng = np.random.default_rng(1)
    side = 4.0 * np.sqrt(n) + 10.0
    boxes = [
        {"type": "box", "center": (side + rng.uniform(0.0, side, 2)).tolist(), "size": [1.0, 0.5]}
        for _ in range(20)
    ]
    content = {"robots": n, "poses": {"layout": "grid", "spacing": 3.0}, "obstacles": boxes}
    return Experiment(scenario_from_dict(dict(content, duration=duration, sensors=sensors)), law)


def seconds(n, law, sensors, duration):
    """Return the CPU time [s] of a run of ``duration`` [s] of ``n`` robots among twenty boxes."""
    run = experiment(n, law, sensors, duration)
    begun = time.process_time()
    for _ in run.samples():
        pass
    return time.process_time() - begun


def unheard(n, turns, others=(LASER, NONE)):
    """Return the ratios (turns,) of turns with sonar and laser that nobody hears to turns without.

    A turn is a tenth of a second of the world, in CPU time; two runs go on in alternation, each first in
    every other pair, so that other work on the machine, caches and clock rates meet both alike.
    """
    runs = [experiment(n, Idle, sensors, 0.1 * turns + 1.0).samples() for sensors in others]
    took = np.zeros((turns, 2))
    for turn in range(turns):
        for which in (0, 1) if turn % 2 else (1, 0):
            begun = time.process_time()
            next(runs[which])
            took[turn, which] = time.process_time() - begun
    return took[WARM:, 0] / took[WARM:, 1]


def median_between(ratios):
    """Return the median of ``ratios`` and bounds within which their true one is by 95 %, by their order.

    The number of values below the median is binomial: the bounds are the values 0.98 sqrt(m) places off.
    """
    ordered, m = np.sort(ratios), len(ratios)
    off = int(np.ceil(0.98 * np.sqrt(m)))
    low, high = ordered[max(0, m // 2 - off)], ordered[min(m - 1, m // 2 + off)]
    return float(np.median(ordered)), float(low), float(high)


def tell_unheard(n, turns):
    """Print what sensors cost that nobody hears, beside two runs alike; return whether it is little.

    It is, if the whole interval is under ``MOST``; where two equal runs are not told to be equal within it,
    nothing is known.
    """
    found = [median_between(unheard(n, turns, two)) for two in ((LASER, NONE), (NONE, NONE))]
    text = "{:4d} robots, unheard: {:.4f} ({:.4f} to {:.4f}) of the CPU time without"
    print((text + "; alike {:.4f} ({:.4f} to {:.4f})").format(n, *found[0], *found[1]))
    return found[0][2] < MOST and found[1][2] < MOST


def picture_seconds(width, height, count=5):
    """Return the CPU time [s] of a picture with its depth, of 7 robots in a circle, and of its messages.

    Messages, of picture, depth and intrinsics, are made and serialised; without ROS they take no time.
    """
    eye = {"type": "camera", "width": width, "height": height, "place": [0.25, 0.0, 0.4]}
    content = {"robots": 7, "poses": {"layout": "circle", "radius": 3.0}}
    scenario = scenario_from_dict(dict(content, sensors=[{"mounts": {"eye": eye}}]))
    world = World.from_scenario(scenario)
    suite = Suite.of_scenario(scenario, *world.senses)
    suite.activate({row: ["eye"] for row in range(7)})
    suite.update(0, world.sensed)
    begun = time.process_time()
    for step in range(10, 10 * (count + 1), 10):
        suite.update(step, world.sensed)
    seen = time.process_time()
    for _ in range(count):
        serialised(suite, world)
    return (seen - begun) / (7 * count), (time.process_time() - seen) / (7 * count)


def serialised(suite, world):
    """Return the bytes of the messages of picture, depth and intrinsics of each robot of a ``suite``."""
    try:
        from std_msgs.msg import Header

        from mrs_simulator.ros.message_forms.sensor_forms.camera import Colours, Depths, Pinhole
    except ImportError:
        return []
    (sensor,), found = suite.active, []
    reading = sensor.known(world.time + 10.0)
    for form in (Colours, Depths, Pinhole):
        told = form(sensor.mount, world.team.kinds[0])
        for item in told.rows(reading):
            buffer = io.BytesIO()
            told.message(item, Header()).serialize(buffer)
            found.append(buffer.getvalue())
    return found


def stage_cameras(width, height, rate, pairs=3):
    """Return what pictures for a listener cost a running stage, in cores, and how many come a second.

    The CPU time of the whole process with 7 robots, whose pictures and depths are subscribed to, less that
    without subscribers, over the time between, (pairs,); and pictures of a robot a second of wall time.
    """
    import rospy
    from ros_transport import cpu_time, ended

    eye = {
        "type": "camera",
        "width": width,
        "height": height,
        "rate": rate,
        "place": [0.25, 0.0, 0.4],
    }
    content = {"robots": 7, "poses": {"layout": "circle", "radius": 3.0}, "duration": 1e4}
    costs, rates, heard = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scenario.yaml")
        with open(path, "w") as file:
            yaml.safe_dump(dict(content, sensors=[{"mounts": {"eye": eye}}]), file)
        command = ["rosrun", "mrs_simulator", "stage", "--scenario", path]
        stage = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            first = "/robot1/eye"
            rospy.wait_for_message(first, rospy.AnyMsg, 60.0)
            for _ in range(pairs):
                shares = []
                for is_heard in (False, True):
                    names = [
                        "/robot{}/eye{}".format(k, s) for k in range(1, 8) for s in ("", "_depth")
                    ]
                    ears = [
                        rospy.Subscriber(
                            name, rospy.AnyMsg, lambda _, name=name: heard.append(name)
                        )
                        for name in names * is_heard
                    ]
                    time.sleep(SETTLING)
                    heard.clear()
                    used, begun = cpu_time(stage.pid), time.monotonic()
                    time.sleep(WINDOW)
                    elapsed = time.monotonic() - begun
                    shares.append((cpu_time(stage.pid) - used) / elapsed)
                    rates.append(heard.count(first) / elapsed)
                    for ear in ears:
                        ear.unregister()
                costs.append(shares[1] - shares[0])
        finally:
            ended([stage])
    return np.array(costs), float(np.median(rates[1::2]))


def tell_stage_cameras():
    """Print what cameras cost a stage, with a master of its own."""
    from ros_transport import ended, free_port

    port = free_port()
    os.environ.update(ROS_MASTER_URI="http://localhost:{}".format(port), ROS_HOSTNAME="localhost")
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL)
    try:
        import rosgraph
        import rospy

        end = time.monotonic() + 30.0
        while not rosgraph.is_master_online() and time.monotonic() < end:
            time.sleep(0.1)
        rospy.init_node("benchmark", disable_signals=True)
        for (width, height), rate, most in (((160, 120), 10.0, 0.5), ((320, 240), 5.0, 1.0)):
            costs, kept = stage_cameras(width, height, rate)
            text = "stage, 7 cameras {} x {} at {:g} Hz: {:.2f} of a core ({:.2f} to {:.2f}), "
            text += "wanted {:g}; {:.1f} Hz came"
            told = width, height, rate, np.median(costs), costs.min(), costs.max(), most, kept
            print(text.format(*told), flush=True)
    finally:
        ended([master])


def rays_per_second(n, k):
    """Return how many rays a second ``n`` robots with ``k`` rays each cast among twenty boxes."""
    rng = np.random.default_rng(1)
    boxes = [
        Box("box{}".format(i), *rng.uniform(-10.0, 10.0, 2), 0.3, 1.0, 0.5, 0.5) for i in range(20)
    ]
    poses = np.column_stack([rng.uniform(-10.0, 10.0, (n, 2)), rng.uniform(-3.0, 3.0, n)])
    shapes = Scenery(Team(("pioneer3dx",) * n), boxes).at(State(0.0, poses, 0.0 * poses))
    angle = poses[:, 2:] + np.linspace(-1.5, 1.5, k)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    rays = Rays(poses[:, np.newaxis, :2], direction, np.full(n, 0.17), np.arange(n))
    cast(shapes, rays, 8.0)
    begun, count = time.process_time(), 0
    while time.process_time() - begun < 0.5:
        cast(shapes, rays, 8.0)
        count += 1
    return count * n * k / (time.process_time() - begun)


def note_alone(report):
    """Note in a ``report`` rays by numpy alone and compiled, where numba is, and pictures."""
    for name, wanted in (("numpy alone", "0"), ("compiled", "1")):
        with chosen(wanted):
            for n, k in itertools.product((7, 100), (16, 181)):
                if wanted == "0" or find_spec("numba"):
                    case = "{} rays, {}".format(k, name)
                    report.note(case, n, rays_per_second(n, k), "1/s")
    for width, height in ((160, 120), (320, 240)):
        size = "{}x{}".format(width, height)
        seen, told = picture_seconds(width, height)
        report.note("picture of " + size, 7, 1e3 * seen, "ms")
        report.note("messages of a picture of " + size, 7, 1e3 * told, "ms")
    report.close()


def main():
    """Print the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=600, help="pairs of turns of 100 robots")
    text = "only whether what nobody hears costs under 2 %%: exit code 0, or 1 if not, or not known"
    parser.add_argument("--check", action="store_true", help=text)
    parser.add_argument(
        "--stage", action="store_true", help="only what cameras cost a stage, over ROS"
    )
    text = "append rays and pictures, without the rest, to the history"
    parser.add_argument("--keep", action="store_true", help=text)
    given = parser.parse_args()
    if given.keep:
        return note_alone(Report("sensors", keep=True))
    print(
        "load {:.1f} on {} cores, compiled: {}".format(
            os.getloadavg()[0], os.cpu_count(), is_wanted()
        )
    )
    if given.stage:
        return tell_stage_cameras()
    little = [tell_unheard(n, turns) for n, turns in ((7, 5 * given.turns), (100, given.turns))]
    if given.check:
        return 0 if all(little) else 1
    seconds(7, Listens, LASER, 0.2)  # compiles, where that is wanted
    for n, duration in ((7, 10.0), (100, 2.0)):
        took, without = (seconds(n, *run, duration) for run in ((Listens, LASER), (Idle, NONE)))
        text = (
            "{:4d} robots, sonar and laser: {:.0f} x real time, {:.1f} times the CPU time without"
        )
        print(text.format(n, duration / took, took / without))
    note_alone(Report("sensors"))


if __name__ == "__main__":
    sys.exit(main())
