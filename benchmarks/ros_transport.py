#!/usr/bin/env python3
"""Odometry out and commands back over ROS at 50 Hz in real time: how many robots two processes carry.

    source build/devel/setup.bash
    python3 benchmarks/ros_transport.py [--topics robots|team] [--sonar] [--record] [--gui] [--keep] [N ...]

Starts a master, the stage and the control node of its own, and with ``--record`` and ``--gui`` the
recorder and the GUI (offscreen).  Round trips, from an odometry's leaving to the arrival of each
robot's next command, and missed periods are those that the stage publishes.  CPU is that of each
process, in shares of a core.  With ``--sonar`` the law hears the sonar of every robot, 16 transducers at
10 Hz; how many readings of each robot came a second of wall time is counted where the law is asked.
"""

import argparse
import os
import socket
import subprocess
import tempfile
import time
import xmlrpc.client

import numpy as np
import yaml
from history import Report

MEASURED = 10.0  # [s] of wall time
SETTLING, GUI_SETTLING = 5.0, 15.0  # [s] of wall time
LIMIT = 60.0  # [s] for the nodes to be up
LAW = """
import time
from mrs_simulator.control.laws.formation import Formation

class Hears(Formation):
    SENSORS = ("sonar",)

    def start(self):
        super().start()
        self.stamps, self.heard, self.begun = dict(), 0, time.monotonic()

    def pointMassLaw(self, hand):
        for number in self.numbers:
            sonar = self.readings[number].sonar
            if sonar.stamp != self.stamps.get(number):
                self.stamps[number] = sonar.stamp
                self.heard += 1
        elapsed = time.monotonic() - self.begun
        if elapsed > 5.0:
            with open(FILE, "w") as file:
                file.write(str(self.heard / elapsed / len(self.numbers)))
            self.heard, self.begun = 0, time.monotonic()
        return super().pointMassLaw(hand)

FILE = {!r}
"""
NODES = ("stage", "pioneer_control", "record", "mrs_gui")
TICKS = os.sysconf("SC_CLK_TCK")


def free_port():
    """Return a port of this host that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def cpu_time(pid):
    """Return the processor time [s] that process ``pid`` has used."""
    with open("/proc/{}/stat".format(pid)) as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


class Status:
    """Keeps what the stage says of its round trips."""

    def __init__(self):
        import rospy

        from mrs_simulator.msg import StageStatus

        self.heard = []
        self._subscriber = rospy.Subscriber("stage/status", StageStatus, self.heard.append)

    def wait(self, wanted, limit=LIMIT):
        """Return the newest status of which ``wanted(status)`` is true."""
        end = time.monotonic() + limit
        while not (self.heard and wanted(self.heard[-1])):
            if time.monotonic() > end:
                raise SystemExit("not within {:g} s; last: {}".format(limit, self.heard[-1:]))
            time.sleep(0.1)
        return self.heard[-1]

    def close(self):
        self._subscriber.unregister()


def commands_for(n, options, folder):
    """Return the command line of each node by name."""
    scenario = os.path.join(folder, "scenario.yaml")
    poses = [[3.0 * (n - 1 - i), 4.0 * (i % 2), 0.0] for i in range(n)]
    with open(scenario, "w") as file:
        yaml.safe_dump({"poses": poses, "limits": "top", "duration": 1e4}, file)
    topics = {"robots": "never", "team": "always"}[options.topics]
    extra = {
        "pioneer_control": ["_team_topics:=" + topics],
        "record": ["--out", os.path.join(folder, "run")],
    }
    if options.sonar:
        law = os.path.join(folder, "law.py")
        with open(law, "w") as file:
            file.write(LAW.format(os.path.join(folder, "heard")))
        extra["pioneer_control"] += ["--protocol", law + ":Hears"]
    chosen = NODES[:2] + NODES[2:3] * options.record
    started = {
        name: ["rosrun", "mrs_simulator", name, "--scenario", scenario] + extra.get(name, [])
        for name in chosen
    }
    if options.gui:
        started["mrs_gui"] = ["rosrun", "mrs_simulator", "mrs_gui"]
    return started


def measure(n, options):
    """Return a row of the table for n robots."""
    folder = tempfile.mkdtemp(prefix="mrs_simulator_bench_")
    environment = dict(os.environ, QT_QPA_PLATFORM="offscreen", HOME=folder)
    status = Status()
    nodes = {}
    try:
        for name, command in commands_for(n, options, folder).items():
            nodes[name] = subprocess.Popen(
                command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
        status.wait(lambda s: s.robots == n and s.round_trip_median > 0.0)
        time.sleep(SETTLING + options.gui * GUI_SETTLING)
        missed = status.heard[-1].missed_periods
        used = [cpu_time(node.pid) for node in nodes.values()]
        begun = time.monotonic()
        del status.heard[:]
        time.sleep(MEASURED)
        elapsed = time.monotonic() - begun
        shares = [(cpu_time(node.pid) - u) / elapsed for node, u in zip(nodes.values(), used)]
        heard = list(status.heard)
        simulated = (heard[-1].header.stamp - heard[0].header.stamp).to_sec()
        periods = n * 50.0 * simulated
        heard_rate = []
        if options.sonar:
            with open(os.path.join(folder, "heard")) as file:
                heard_rate = [float(file.read())]
        return [
            np.mean([s.real_time_factor for s in heard]),
            100.0 * (heard[-1].missed_periods - missed) / periods,
            1e3 * np.median([s.round_trip_median for s in heard]),
            1e3 * np.median([s.round_trip_p99 for s in heard]),
        ] + (shares + heard_rate)
    finally:
        status.close()
        for node in nodes.values():
            node.terminate()
        for node in nodes.values():
            try:
                node.wait(15)
            except subprocess.TimeoutExpired:
                node.kill()


def keep(rows, options):
    """Append ``rows`` by number of robots to the history."""
    report = Report("ros_transport", keep=True)
    attached = ["recorder"] * options.record + ["GUI"] * options.gui + ["sonar"] * options.sonar
    attached = " and ".join(attached)
    what = "topics of {}{}".format(
        {"robots": "each robot", "team": "the team"}[options.topics],
        " with " + attached if attached else "",
    )
    for n, (factor, missed, median, late, stage, control, *_) in rows.items():
        for name, value, unit in (
            ("time lost", 1.0 - factor, "share"),
            ("missed periods", 0.01 * missed, "share"),
            ("round trip, median", median, "ms"),
            ("round trip, p99", late, "ms"),
            ("stage's core", stage, "share"),
            ("control's core", control, "share"),
        ):
            report.note("{}: {}".format(what, name), n, value, unit)
    report.close()


def arguments():
    """Return the command line's choices."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("robots", nargs="*", type=int, default=[7, 50, 100], metavar="N")
    parser.add_argument("--topics", choices=("robots", "team"), default="robots")
    parser.add_argument("--sonar", action="store_true", help="with a law that hears sonar")
    parser.add_argument("--record", action="store_true", help="with the recorder")
    parser.add_argument("--gui", action="store_true", help="with the GUI, offscreen")
    parser.add_argument("--keep", action="store_true", help="append the figures to history.csv")
    return parser.parse_args()


def main():
    """Print the table."""
    options = arguments()
    port = free_port()
    os.environ.update(ROS_MASTER_URI="http://localhost:{}".format(port), ROS_HOSTNAME="localhost")
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)])
    try:
        import rospy

        proxy = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
        for _ in range(100):
            try:
                proxy.setParam("/benchmark", "/use_sim_time", True)
                break
            except OSError:
                time.sleep(0.1)
        rospy.init_node("benchmark", disable_signals=True)
        columns = ["robots", "RTF", "missed %", "median ms", "p99 ms", "stage CPU", "control CPU"]
        columns += ["record CPU"] * options.record + ["GUI CPU"] * options.gui
        columns += ["sonar Hz"] * options.sonar
        print(" ".join("{:>11}".format(column) for column in columns))
        rows = {}
        for n in options.robots:
            rows[n] = measure(n, options)
            row = " ".join("{:11.2f}".format(value) for value in rows[n])
            print("{:11d} {}".format(n, row), flush=True)
        if options.keep:
            keep(rows, options)
    finally:
        master.terminate()
        master.wait()


if __name__ == "__main__":
    main()
