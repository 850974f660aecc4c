#!/usr/bin/env python3
"""Run a team with GUI, recorder and bag for a long time, and say what grew, lagged or stopped.

    python3 test/soak.py [--minutes 60] [--robots 50] [--warm-up 10] [--keep]

At speed 1, over ROS.  Exits with 1 where the memory of a program grew by more than 2 % after the
warm-up, where samples are missing from ``run.csv`` or from the bag, where the stage or the controller
fell behind, or where a robot that was told to move stood.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
sys.path[:0] = [HERE, os.path.join(HERE, "faults")]

from motion import RECENT, Motion  # noqa: E402
from ros_fixtures import Ros, log_of, wait_until  # noqa: E402

GROWTH = 0.02  # [-] of resident memory after the warm-up
LEAST_GROWTH = 1 << 21  # [bytes] below which nothing is said to grow: a few pages of a thread
RATE = 0.98  # [-] of simulated over wall time
GAP = 1.5  # [-] periods between two samples
LOOK = 5.0  # [s] of wall time between two looks
LONGEST_START = 180.0  # [s]

LAW = """
import numpy as np

from mrs_simulator import PioneerControl, make_twist


class Circles(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.2, 0.1) for number in pos_map}
"""


def memory(process):
    """Return the resident memory [bytes] of ``process`` and what it has started; 0 if it is gone."""
    total = 0
    for number in family(process.pid):
        try:
            with open("/proc/{}/statm".format(number)) as file:
                total += int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, IndexError):
            continue
    return total


def family(number):
    """Return the process ``number`` and all below it."""
    found = [number]
    for parent in found:
        try:
            with open("/proc/{0}/task/{0}/children".format(parent)) as file:
                found += map(int, file.read().split())
        except OSError:
            continue
    return found


def grown(samples, warm_up):
    """Return by how much memory grew, [-] and [bytes], from the warm-up's end, by medians of fifths.

    ``samples``: (time [s], bytes); a peak for a moment is no growth.
    """
    late = np.array([size for when, size in samples if when >= warm_up], dtype=float)
    if len(late) < 5:
        return 0.0, 0.0
    part = max(1, len(late) // 5)
    first, last = np.median(late[:part]), np.median(late[-part:])
    return last / first - 1.0, last - first


def gaps(stamps, period):
    """Return how many samples are missing between ``stamps`` [s] that should be ``period`` apart."""
    step = np.diff(stamps)
    return int(np.sum(np.round(step[step > GAP * period] / period) - 1))


def stood(motion):
    """Return how many of the robots' seconds a robot stood that should drive, after the first."""
    total, stamp = 0.0, motion.stamp[0] + RECENT if len(motion.stamp) else 0.0
    while len(motion.stamp) and stamp + 1.0 < motion.stamp[-1]:
        rows = (motion.stamp >= stamp) & (motion.stamp < stamp + 1.0)
        place = motion.place[rows]
        if len(place) > 1 and np.ptp(place, axis=0).max(axis=0).min() < 0.02:
            total += 1.0
        stamp += 1.0
    return total


def judged(figures):
    """Return in words what is wrong with ``figures``, a list."""
    wrong = [
        "{} grew by {:.1%}, {:.1f} MB".format(name, share, size / 1e6)
        for name, (share, size) in figures["grown"].items()
        if share > GROWTH and size > LEAST_GROWTH
    ]
    for name in figures["ended"]:
        wrong.append("{} ended".format(name))
    for name in ("missing from run.csv", "missing from the bag"):
        if figures[name]:
            wrong.append("{} samples {}".format(figures[name], name))
    if figures["rate"] < RATE:
        wrong.append("simulated time went at {:.3f} of wall time".format(figures["rate"]))
    if figures["stood"]:
        wrong.append("robots stood for {:.0f} s".format(figures["stood"]))
    return wrong


class Soak:
    """The programs of one soak."""

    def __init__(self, directory, robots, minutes):
        """Start them all."""
        self.directory, self.seconds = directory, 60.0 * minutes
        with open(os.path.join(directory, "circles.py"), "w") as file:
            file.write(LAW)
        scenario = os.path.join(directory, "scenario.yaml")
        with open(scenario, "w") as file:
            file.write(
                "robots: {}\nposes: {{layout: grid, spacing: 6.0}}\nduration: {}\n"
                "control: {{protocol: circles.py:Circles}}\n".format(robots, self.seconds)
            )
        self.track, self.out = os.path.join(directory, "motion"), os.path.join(directory, "out")
        open(self.track, "w").close()
        self.ros = Ros(directory)
        self.ros.environment["QT_QPA_PLATFORM"] = "offscreen"
        run = ["--scenario", scenario]
        bag = ["rosbag", "record", "--tcpnodelay", "-O", os.path.join(directory, "run.bag")]
        topics = ["/clock", "/stage/state", "/stage/collisions", "/stage/scenario"]
        self.programs = {
            "stage": self.ros.node(
                "stage", *run, "_wait_for_control:=true", "_wait_for_recorders:=3"
            ),
            "recorder": self.ros.node("record", *run, "--out", self.out),
            "bag": self.ros.start("bag", bag + topics),
            "GUI": self.ros.node("mrs_gui", *run),
        }
        watch = os.path.join(HERE, "faults", "motion.py")
        self.ros.start("motion", [sys.executable, watch, self.track])
        self.programs["controller"] = self.ros.node("pioneer_control", *run)

    def run(self, warm_up):
        """Wait for the time that was asked for; return the figures."""
        wait_until(lambda: os.path.getsize(self.track) > 0, LONGEST_START)
        begin, looks = time.monotonic(), {name: [] for name in self.programs}
        ended = []
        while time.monotonic() - begin < self.seconds:
            time.sleep(LOOK)
            for name, process in self.programs.items():
                if process.poll() is None:
                    looks[name].append((time.monotonic() - begin, memory(process)))
                elif name not in ended and time.monotonic() - begin < self.seconds - 30.0:
                    ended.append(name)
        return self._figures(looks, ended, warm_up)

    def _figures(self, looks, ended, warm_up):
        motion = Motion(self.track)
        span = motion.wall[-1] - motion.wall[0]
        path = os.path.join(self.out, "run.csv")
        times = np.unique(np.genfromtxt(path, delimiter=",", skip_header=1, usecols=0))
        self.ros.stop(self.programs["bag"])
        return {
            "minutes": self.seconds / 60.0,
            "grown": {name: grown(samples, warm_up) for name, samples in looks.items()},
            "memory": {name: samples[-1][1] for name, samples in looks.items() if samples},
            "ended": ended,
            "rate": float(motion.span / span),
            "missing from run.csv": gaps(times, 0.1),
            "missing from the bag": self._missing_from_bag(motion),
            "stood": stood(motion),
        }

    def _missing_from_bag(self, motion):
        import rosbag

        with rosbag.Bag(os.path.join(self.directory, "run.bag")) as bag:
            stamps = [m.header.stamp.to_sec() for _, m, _ in bag.read_messages(["/stage/state"])]
        return gaps(np.array(stamps), float(np.median(np.diff(motion.stamp))))

    def close(self):
        """End all programs."""
        self.ros.close()


def main():
    """Soak as the command line says; exits with 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--robots", type=int, default=50)
    parser.add_argument("--warm-up", type=float, default=10.0, help="[min], default: 10")
    parser.add_argument("--keep", action="store_true", help="keep the files, and say where")
    arguments = parser.parse_args()
    directory = tempfile.mkdtemp(prefix="mrs_soak_")
    soak = Soak(directory, arguments.robots, arguments.minutes)
    try:
        figures = soak.run(min(60.0 * arguments.warm_up, 0.5 * soak.seconds))
    except BaseException:
        for process in soak.ros.processes:
            if hasattr(process, "log"):
                print(log_of(process)[-500:], file=sys.stderr)
        raise
    finally:
        soak.close()
        if arguments.keep:
            print("files: {}".format(directory))
        else:
            shutil.rmtree(directory, ignore_errors=True)
    wrong = judged(figures)
    figures["commit"] = subprocess.check_output(
        ["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], text=True
    ).strip()
    print(json.dumps(figures, indent=1))
    print("\n".join("WRONG: " + text for text in wrong) or "nothing wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
