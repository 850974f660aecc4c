#!/usr/bin/env python3
"""Per-robot topics over ROS at 50 Hz both ways, in real time: how many robots two processes carry.

    source build/devel/setup.bash; python3 benchmarks/ros_transport.py [N ...]

Starts a master, the stage and the control node of its own.  For some robots it listens to odometry
and commands: the round trip is from an odometry's arrival here to that of the next command; a period
without a command is missed.  CPU is that of each process, in shares of a core.
"""

import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client

import numpy as np
import yaml

PERIOD = 0.02  # [s]
MEASURED = 10.0  # [s] of wall time
LIMIT = 60.0  # [s] for the nodes to be up
LOOKED_AT = 5  # [-] robots listened to
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


class Listener:
    """Times odometry and commands of one robot."""

    def __init__(self, robot):
        import rospy

        from mrs_simulator.nodes.wire import PlanarOdometry, PlanarTwist

        self.heard, self.trips, self.odometry, self.commands = None, [], 0, 0
        self.lock = threading.Lock()
        name = "/robot{}".format(robot)
        options = {"queue_size": 1, "tcp_nodelay": True}
        rospy.Subscriber(name + "/odom", PlanarOdometry, self.on_odometry, **options)
        rospy.Subscriber(name + "/cmd_vel", PlanarTwist, self.on_command, **options)

    def on_odometry(self, _):
        with self.lock:
            self.heard, self.odometry = time.monotonic(), self.odometry + 1

    def on_command(self, _):
        with self.lock:
            self.commands += 1
            if self.heard is not None:
                self.trips.append(time.monotonic() - self.heard)
                self.heard = None

    def clear(self):
        with self.lock:
            self.trips, self.odometry, self.commands = [], 0, 0


def measure(n):
    """Return a row of the table for n robots."""
    import rospy

    from mrs_simulator.msg import StageStatus

    folder = tempfile.mkdtemp(prefix="mrs_simulator_bench_")
    scenario = os.path.join(folder, "scenario.yaml")
    poses = [[3.0 * (n - 1 - i), 4.0 * (i % 2), 0.0] for i in range(n)]
    with open(scenario, "w") as file:
        yaml.safe_dump({"poses": poses, "limits": "top", "duration": 1e5}, file)
    nodes = [
        subprocess.Popen(
            ["rosrun", "mrs_simulator", name, "--scenario", scenario],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for name in ("stage", "pioneer_control")
    ]
    try:
        listeners = [Listener(r) for r in np.unique(np.linspace(1, n, LOOKED_AT, dtype=int))]
        end = time.monotonic() + LIMIT
        while not all(listener.commands > 10 for listener in listeners):
            if time.monotonic() > end:
                raise SystemExit("{} robots: no commands within {:g} s".format(n, LIMIT))
            time.sleep(0.1)
        time.sleep(3.0)
        for listener in listeners:
            listener.clear()
        used = [cpu_time(node.pid) for node in nodes]
        begun = time.monotonic()
        time.sleep(MEASURED)
        elapsed = time.monotonic() - begun
        shares = [(cpu_time(node.pid) - u) / elapsed for node, u in zip(nodes, used)]
        factor = rospy.wait_for_message("stage/status", StageStatus, 5.0).real_time_factor
        trips = 1e3 * np.concatenate([listener.trips for listener in listeners])
        wanted = len(listeners) * elapsed / PERIOD
        missed = 1.0 - sum(listener.commands for listener in listeners) / wanted
        return factor, missed, np.median(trips), np.percentile(trips, 99), shares
    finally:
        for node in nodes:
            node.terminate()
        for node in nodes:
            try:
                node.wait(15)
            except subprocess.TimeoutExpired:
                node.kill()


def main():
    """Print the table."""
    sizes = [int(text) for text in sys.argv[1:]] or [7, 50, 100]
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
        columns = ("robots", "RTF", "missed %", "median ms", "p99 ms", "stage CPU", "control CPU")
        print(" ".join("{:>11}".format(column) for column in columns))
        for n in sizes:
            factor, missed, median, late, (stage, control) = measure(n)
            print(
                "{:11d} {:11.2f} {:11.2f} {:11.2f} {:11.2f} {:11.2f} {:11.2f}".format(
                    n, factor, 100.0 * missed, median, late, stage, control
                )
            )
    finally:
        master.terminate()
        master.wait()


if __name__ == "__main__":
    main()
