#!/usr/bin/env python3
"""Odometry out and commands back over ROS at 50 Hz in real time: how many robots two processes carry.

    source build/devel/setup.bash
    python3 benchmarks/ros_transport.py --all [--keep]
    python3 benchmarks/ros_transport.py [--topics robots|team] [--rate HZ] [--sonar] [--record] [--gui]
                                        [--keep] [N ...]

Starts a master, the stage and the control node of its own, and with ``--record`` and ``--gui`` the
recorder and the GUI (offscreen).  Round trips, from each odometry's leaving to the arrival of the
command of each robot that answers it, and missed periods are those that the stage tells of a run that
begins once all is up.  CPU is that of each process, in shares of a core.  With ``--sonar`` the law hears
the sonar of every robot, 16 transducers at 10 Hz; how many readings of each robot came a second of wall
time is counted where the law is asked.

Before and after each row a plain rospy pair runs for some seconds: one node publishes as many odometry
messages at 50 Hz, on as many topics, another sends each back as it came.  Its round trips are beside
ours, and how many times as long ours are.  Where ``topic_tools`` is installed, its ``relay``, which is
roscpp's, stands in for the second node in a further row of one topic for all.  ``--all``: the table of
docs/benchmarks.md.
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

import numpy as np
import yaml
from history import Report

MEASURED = 10.0  # [s] of wall time
ECHOED, ECHO_SETTLING = 3.0, 1.0  # [s] of wall time, before and after each row
RATE = 50.0  # [Hz] of odometry and commands, where no other is asked for
ALL = (  # topics, robots, recorder, GUI
    ("robots", 7, False, False),
    ("robots", 100, False, False),
    ("robots", 200, False, False),
    ("team", 100, False, False),
    ("team", 1000, False, False),
    ("team", 1000, True, True),
)
SETTLING, GUI_SETTLING = 5.0, 15.0  # [s] of wall time
LIMIT = 60.0  # [s] for the nodes to be up
LAW = """
import time
from mrs_simulator.protocols.formation.law import Formation

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


# A plain pair of nodes ------------------------------------------------------------------------------


def echo_messages(n, topics):
    """Return the type of the messages that make an echo of n robots, and one for each topic."""
    from nav_msgs.msg import Odometry

    from mrs_simulator.ros.message_forms.messages import team_odometry

    if topics == "team":
        message = team_odometry(range(1, n + 1), np.zeros((n, 3)))
        return type(message), [message]
    return Odometry, [Odometry() for _ in range(n)]


def answer(n, topics):
    """Send each message back as it comes, for ever."""
    import rospy

    rospy.init_node("answer", disable_signals=True)
    kind, messages = echo_messages(n, topics)
    for k in range(len(messages)):
        back = rospy.Publisher("/echo/back{}".format(k), kind, queue_size=1, tcp_nodelay=True)
        out = "/echo/out{}".format(k)
        rospy.Subscriber(out, kind, back.publish, queue_size=1, tcp_nodelay=True)
    time.sleep(1e6)


def ask(n, topics, seconds, rate=RATE):
    """Publish at ``rate`` [Hz]; print the round trips [s] of ``seconds`` as one line of JSON."""
    import rospy

    rospy.init_node("ask", disable_signals=True)
    kind, messages = echo_messages(n, topics)
    left, trips = {}, []

    def came(message):
        trips.append((message.header.stamp.secs, time.monotonic()))

    outs = []
    for k in range(len(messages)):
        back, out = "/echo/back{}".format(k), "/echo/out{}".format(k)
        rospy.Subscriber(back, kind, came, queue_size=1, tcp_nodelay=True)
        outs.append(rospy.Publisher(out, kind, queue_size=1, tcp_nodelay=True))
    end = time.monotonic() + LIMIT
    while not all(out.get_num_connections() for out in outs) and time.monotonic() < end:
        time.sleep(0.1)
    begun, cycle = time.monotonic(), 0
    while cycle < (ECHO_SETTLING + seconds) * rate:
        left[cycle] = time.monotonic()
        for out, message in zip(outs, messages):
            message.header.stamp.secs = cycle
            out.publish(message)
        cycle += 1
        time.sleep(max(0.0, begun + cycle / rate - time.monotonic()))
    time.sleep(0.5)
    settled = ECHO_SETTLING * rate
    print(json.dumps([came - left[stamp] for stamp, came in trips if stamp >= settled]))


def echo(n, topics, relayed=False, rate=RATE):
    """Return the round trips [s] of a plain pair of nodes, with roscpp's relay where it is ``relayed``."""
    own = [sys.executable, os.path.abspath(__file__), str(n), "--topics", topics]
    own += ["--rate", str(rate), "--part"]
    relay = ["rosrun", "topic_tools", "relay", "/echo/out0", "/echo/back0"]
    second = subprocess.Popen(relay if relayed else [*own, "answer"], stdout=subprocess.DEVNULL)
    try:
        asked = subprocess.run(
            [*own, "ask"], stdout=subprocess.PIPE, timeout=2.0 * LIMIT, check=True
        )
    finally:
        second.terminate()
        second.wait()
    return json.loads(asked.stdout.decode().splitlines()[-1])


def has_relay():
    """Return whether topic_tools is installed."""
    found = subprocess.run(
        ["catkin_find", "--libexec", "topic_tools", "relay"], capture_output=True
    )
    return bool(found.stdout.strip())


# Ours -----------------------------------------------------------------------------------------------


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
        content = {"poses": poses, "limits": "top", "duration": 1e4}
        if options.rate != RATE:
            content.update(odometry_rate=options.rate, control={"rate": options.rate})
        yaml.safe_dump(content, file)
    topics = {"robots": "never", "team": "always"}[options.topics]
    extra = {
        "stage": ["_paused:=true"],
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
    from std_srvs.srv import SetBool

    folder = tempfile.mkdtemp(prefix="mrs_simulator_bench_")
    environment = dict(os.environ, QT_QPA_PLATFORM="offscreen", HOME=folder)
    trips = echo(n, options.topics, rate=options.rate)
    status = Status()
    nodes = {}
    try:
        for name, command in commands_for(n, options, folder).items():
            nodes[name] = subprocess.Popen(
                command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
        status.wait(lambda s: s.robots == n)
        time.sleep(SETTLING + options.gui * GUI_SETTLING)
        service("stage/pause", SetBool)(False)
        status.wait(lambda s: s.round_trip_median > 0.0)
        used = [cpu_time(node.pid) for node in nodes.values()]
        begun = time.monotonic()
        time.sleep(MEASURED)
        elapsed = time.monotonic() - begun
        shares = [(cpu_time(node.pid) - u) / elapsed for node, u in zip(nodes.values(), used)]
        heard = list(status.heard)
        heard_rate = []
        if options.sonar:
            with open(os.path.join(folder, "heard")) as file:
                heard_rate = [float(file.read())]
    finally:
        status.close()
        ended(nodes.values())
    trips += echo(n, options.topics, rate=options.rate)
    last = heard[-1]
    ours = 1e3 * np.array([last.round_trip_median, last.round_trip_p99])
    plain = 1e3 * np.percentile(trips, (50.0, 99.0))
    factor = np.mean([s.real_time_factor for s in heard if s.round_trip_median > 0.0][10:])
    missed = 100.0 * last.missed_periods / max(1, last.command_periods)
    return [factor, missed, *ours, *plain, *ours / plain, *shares, *heard_rate]


def ended(nodes):
    """End ``nodes``: politely, then for certain."""
    for node in nodes:
        node.terminate()
    for node in nodes:
        try:
            node.wait(15)
        except subprocess.TimeoutExpired:
            node.kill()


def service(name, kind):
    """Return the proxy of a service, once it is there."""
    import rospy

    rospy.wait_for_service(name, LIMIT)
    return rospy.ServiceProxy(name, kind)


def attached(options):
    """Return whose topics are used, and what else runs."""
    more = ["odometry at {:g} Hz".format(options.rate)] * (options.rate != RATE)
    more += ["recorder"] * options.record + ["GUI"] * options.gui + ["sonar"] * options.sonar
    return "topics of {}{}".format(
        {"robots": "each robot", "team": "the team"}[options.topics],
        " with " + " and ".join(more) if more else "",
    )


def keep(rows, report):
    """Append ``rows``, by what was measured and number of robots, to the history by ``report``."""
    for (what, n), (factor, missed, median, late, *rest) in rows.items():
        for name, value, unit in (
            ("time lost", 1.0 - factor, "share"),
            ("missed periods", 0.01 * missed, "share"),
            ("round trip, median", median, "ms"),
            ("round trip, p99", late, "ms"),
            ("round trip, median, over the echo's", rest[2], "x"),
            ("round trip, p99, over the echo's", rest[3], "x"),
            ("stage's core", rest[4], "share"),
            ("control's core", rest[5], "share"),
        ):
            report.note("{}: {}".format(what, name), n, value, unit)
    report.close()


def arguments():
    """Return the command line's choices."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("robots", nargs="*", type=int, default=[7, 50, 100], metavar="N")
    parser.add_argument("--all", action="store_true", help="the table of docs/benchmarks.md")
    parser.add_argument("--topics", choices=("robots", "team"), default="robots")
    text = "[Hz] of odometry and commands, by default %(default)g"
    parser.add_argument("--rate", type=float, default=RATE, help=text)
    parser.add_argument("--sonar", action="store_true", help="with a law that hears sonar")
    parser.add_argument("--record", action="store_true", help="with the recorder")
    parser.add_argument("--gui", action="store_true", help="with the GUI, offscreen")
    parser.add_argument("--keep", action="store_true", help="append the figures to history.csv")
    parser.add_argument("--part", choices=("ask", "answer"), help=argparse.SUPPRESS)
    return parser.parse_args()


COLUMNS = ["RTF", "missed %", "median ms", "p99 ms", "echo median", "echo p99", "x median", "x p99"]
COLUMNS += ["stage CPU", "control CPU"]


def table(options):
    """Print the rows that are asked for; return them by what was measured and number of robots."""
    cases = ALL if options.all else [(None, n, None, None) for n in options.robots]
    rows = {}
    for topics, n, record, gui in cases:
        if topics:
            options.topics, options.record, options.gui = topics, record, gui
        what = attached(options)
        if what not in {known for known, _ in rows}:
            columns = COLUMNS + ["record CPU"] * options.record + ["GUI CPU"] * options.gui
            columns += ["sonar Hz"] * options.sonar
            print("{}\n{:>11}".format(what, "robots"), end=" ")
            print(" ".join("{:>11}".format(column) for column in columns))
        rows[what, n] = measure(n, options)
        row = " ".join("{:11.2f}".format(value) for value in rows[what, n])
        print("{:11d} {}".format(n, row), flush=True)
    if options.all or options.topics == "team":
        print_relays(sorted({n for what, n in rows if "the team" in what}))
    return rows


def print_relays(sizes):
    """Print the round trips of one topic for all with roscpp's relay, where that is installed."""
    if not has_relay():
        print("topic_tools is not installed: no row of roscpp")
        return
    print("one topic for all, sent back by roscpp's relay: robots, median ms, p99 ms")
    for n in sizes:
        median, late = 1e3 * np.percentile(echo(n, "team", relayed=True), (50.0, 99.0))
        print("{:11d} {:11.2f} {:11.2f}".format(n, median, late), flush=True)


def main():
    """Print the table, or be one of the two nodes of the plain pair."""
    options = arguments()
    if options.part:
        n = options.robots[0]
        answer(n, options.topics) if options.part == "answer" else ask(
            n, options.topics, ECHOED, options.rate
        )
        return
    report = Report("ros_transport", keep=True) if options.keep else None
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
        rows = table(options)
        if options.keep:
            keep(rows, report)
    finally:
        master.terminate()
        master.wait()


if __name__ == "__main__":
    main()
