#!/usr/bin/env python3
"""How the GUI keeps up with moving teams over ROS: frames, share of a core, pauses of its thread.

    source build/devel/setup.bash; python3 benchmarks/gui.py [N ...] [--minutes M] [--display] [--trails P]

Starts a master of its own.  First N robots, published at 50 Hz as the stage publishes them, are shown
on the map with trails, numbers and edges, with the curves hidden and visible: frames of the map
painted a second; CPU of the GUI's process, in shares of a core; the time between beats, due every
5 ms, of a timer in the GUI's thread: 99th percentile and longest; and the most time that this thread
itself was at work between two beats, which tells a busy machine from a busy GUI.  The largest team is
shown with P points of trails too, 100,000 by default, once with the view at rest and once while it is
dragged, so that all trails are drawn anew in each picture; and while its run is saved.  Then the stage
and the control node run a team of N: the real-time factor without the GUI and with it.

--minutes M: one long run with the curves visible; its buffers are bounded if memory [MB] no longer
grows in the second half.  --keep: the figures go to the history too, where runs are compared.
Without --display Qt draws off screen.
"""

import argparse
import gc
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

import numpy as np
import yaml
from history import Report
from ros_transport import cpu_time, free_port

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RATE = 50.0  # [Hz] of the states
STATUS_STEPS = 10, 25  # [-] steps between two statuses: of the stage, of the controller
BEAT = 5  # [ms]
DRAGGED, DRAG_PERIOD = 60.0, 30  # [px] about the middle, [ms] between two moves of the mouse
POINT = 0.05  # [m] between two points of a trail
WAYS = {  # name: curves visible, trails filled, view dragged, run saved
    "no curves": (False, False, False, False),
    "curves": (True, False, False, False),
    "trails": (False, True, False, False),
    "dragged": (False, True, True, False),
    "saving": (False, True, False, True),
}
SETTLE = 6.0  # [s] of wall time before the measurement
LIMIT = 90.0  # [s] for anything to come about
SPEEDS = 0.3, 0.5  # [m/s] forward, [rad/s] the most of a turn
SPACING = 3.0  # [m] between robots at first
COLUMNS = "robots", "shown", "frames/s", "GUI CPU", "p99 ms", "longest ms", "at work ms"
COLUMNS += "MB", "MB grown", "2nd half"
ROW = "{robots:10d} {shown:>10} {frames:10.1f} {cpu:10.2f} {late:10.1f} {longest:10.1f}"
ROW += " {worked:10.1f} {mb:10.0f} {grown:10.1f} {late_grown:10.1f}"


def grid(n):
    """Return the poses (n, 3) at first [m, m, rad]."""
    side = int(math.ceil(math.sqrt(n)))
    row, column = np.divmod(np.arange(n), side)
    return np.column_stack([SPACING * column, SPACING * row, np.arange(n) % 6.0])


# The process that publishes a team


def feed(n):
    """Publish what the stage and the controller of ``n`` wandering robots publish, for ever."""
    import rospy
    from rosgraph_msgs.msg import Clock

    from mrs_simulator.msg import ControlStatus, StageStatus, TeamState

    rospy.init_node("stage", disable_signals=True)
    options = {"tcp_nodelay": True, "queue_size": 10}
    state = rospy.Publisher("/stage/state", TeamState, **options)
    stage = rospy.Publisher("/stage/status", StageStatus, **options)
    control = rospy.Publisher("/pioneer_control/status", ControlStatus, **options)
    clock = rospy.Publisher("/clock", Clock, **options)
    pose, numbers, step, begun = grid(n), list(range(1, n + 1)), 0, time.monotonic()
    fixed = {"command_v": [SPEEDS[0]] * n, "command_omega": [0.0] * n}
    while True:
        now = 1.0 + step / RATE
        stamp = rospy.Time.from_sec(now)
        omega = SPEEDS[1] * np.sin(0.2 * now + np.arange(n))
        pose[:, 2] += omega / RATE
        pose[:, :2] += SPEEDS[0] / RATE * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
        message = TeamState(robot=numbers, vx=fixed["command_v"], omega=omega.tolist(), **fixed)
        message.x, message.y, message.theta = pose.T.tolist()
        message.vy, message.commanded, message.real = [0.0] * n, [True] * n, [False] * n
        message.header.stamp = stamp
        clock.publish(stamp)
        state.publish(message)
        if step % STATUS_STEPS[0] == 0:
            stage.publish(StageStatus(fidelity="kinematic", robots=n, speed=1, real_time_factor=1))
        if step % STATUS_STEPS[1] == 0:
            places = {"target_x": pose[:, 0].tolist(), "target_y": pose[:, 1].tolist()}
            edges = {"hears": numbers[:-1], "heard": numbers[1:], "weight": [1.0] * (n - 1)}
            known = {"protocol": "Formation", "running": True, "directed": True}
            control.publish(ControlStatus(**known, **places, **edges))
        step += 1
        time.sleep(max(0.0, begun + step / RATE - time.monotonic()))


# The process that shows it


def show(n, seconds, way, points):
    """Show what is published for so many seconds; print what was measured as one line of JSON.

    ``way``: one of ``WAYS``; ``points``: of trails, in all.
    """
    import rospy
    from PyQt5.QtCore import QEvent, QObject, Qt, QTimer
    from PyQt5.QtWidgets import QApplication

    from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
    from mrs_simulator.rqt_plugin.run.processes import Processes
    from mrs_simulator.rqt_plugin.study_widget import StudyWidget
    from mrs_simulator.scenario.scenario import scenario_from_dict

    class Paints(QObject):
        count = 0

        def eventFilter(self, _, event):
            self.count += event.type() == QEvent.Paint
            return False

    application = QApplication([])
    rospy.init_node("mrs_gui", disable_signals=True)
    scenario = scenario_from_dict({"poses": grid(n).tolist()}, "benchmark")
    gui = StudyWidget(RosConnection(), Processes(), scenario)
    gui.resize(1366, 768)
    curves, filled, dragged, saved = WAYS[way]
    gui.results_tabs.setCurrentIndex(0 if curves else 3)
    heard, show_snapshot = [], gui.map.show_snapshot

    def listen(snapshot, *passed):
        heard[:] = [snapshot]
        show_snapshot(snapshot, *passed)

    gui.map.show_snapshot = listen
    gui.show()
    gc.collect()
    gc.freeze()  # as the GUI's own window does
    paints, beats = Paints(), []
    gui.map.installEventFilter(paints)
    begin = {}

    def start():
        if not gui.connection.is_fresh("state"):
            raise SystemExit("no states were heard")
        if filled:
            fill(show_snapshot, heard[0], points)
        if dragged:
            drag(gui.map)
        if saved:
            gui.results.save(tempfile.mkdtemp(prefix="mrs_saved_"))
        begin.update(time=time.monotonic(), cpu=cpu_time("self"), paints=paints.count, mb=memory())
        beats.clear()

    def end():
        elapsed = time.monotonic() - begin["time"]
        gaps, worked = 1e3 * np.diff(beats, axis=0).T
        result = {
            "frames": (paints.count - begin["paints"]) / elapsed,
            "cpu": (cpu_time("self") - begin["cpu"]) / elapsed,
            "late": np.percentile(gaps, 99),
            "longest": gaps.max(),
            "worked": worked.max(),
            "mb": memory(),
            "grown": memory() - begin["mb"],
            "late_grown": memory() - begin["half"],
        }
        print(json.dumps(result), flush=True)
        gui.close_study()
        os._exit(0)  # as the GUI's own window does

    heart = QTimer(timerType=Qt.PreciseTimer, interval=BEAT)
    heart.timeout.connect(lambda: beats.append((time.monotonic(), time.thread_time())))
    heart.start()
    QTimer.singleShot(int(1e3 * SETTLE), start)
    halfway = int(1e3 * (SETTLE + seconds / 2.0))
    QTimer.singleShot(halfway, lambda: begin.update(half=memory()))
    QTimer.singleShot(int(1e3 * (SETTLE + seconds)), end)
    application.exec_()


def fill(show_snapshot, newest, points):
    """Give the robots trails of ``points`` in all, which end where they are in the snapshot ``newest``."""
    steps = points // len(newest.robots)
    turns = np.linspace(0.0, 0.05 * steps, steps)[:, np.newaxis] + np.arange(len(newest.robots))
    moves = POINT * np.stack([np.cos(turns), np.sin(turns)], axis=2)
    back = np.cumsum(moves[::-1], axis=0)[::-1]
    for away in back:
        pose = newest.pose.copy()
        pose[:, :2] -= away
        show_snapshot(newest.replace(pose=pose))


def drag(widget):
    """Drag the view of ``widget`` about, for ever."""
    from PyQt5.QtCore import QEvent, QPointF, Qt, QTimer
    from PyQt5.QtGui import QMouseEvent
    from PyQt5.QtWidgets import QApplication

    middle = QPointF(widget.rect().center())

    def send(kind, button):
        turn = 2.0 * time.monotonic()
        at = middle + DRAGGED * QPointF(math.cos(turn), math.sin(turn))
        left, keys = Qt.LeftButton, Qt.NoModifier
        QApplication.sendEvent(widget, QMouseEvent(kind, at, button, left, keys))

    send(QEvent.MouseButtonPress, Qt.LeftButton)
    timer = QTimer(widget, interval=DRAG_PERIOD, timerType=Qt.PreciseTimer)
    timer.timeout.connect(lambda: send(QEvent.MouseMove, Qt.NoButton))
    timer.start()


def memory():
    """Return the resident memory of this process [MB]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


# The process that measures


def part(*arguments, **options):
    """Start this program in another of its parts."""
    command = [sys.executable, os.path.abspath(__file__)] + [str(a) for a in arguments]
    return subprocess.Popen(command, **options)


def ended(processes):
    """End ``processes``."""
    for process in processes:
        process.send_signal(signal.SIGTERM)
    for process in processes:
        try:
            process.wait(15)
        except subprocess.TimeoutExpired:
            process.kill()


def shown(n, seconds, way, points):
    """Return what the GUI's process measured of itself."""
    asked = "--seconds", seconds, "--way", way, "--trails", points
    gui = part(n, "--part", "show", *asked, stdout=-1)
    try:
        output, _ = gui.communicate(timeout=seconds + LIMIT)
    finally:
        ended([gui])
    if gui.returncode:
        raise SystemExit("{} robots: the GUI ended with {}".format(n, gui.returncode))
    return json.loads(output.decode().splitlines()[-1])


NAMES = {"no curves": "curves hidden", "curves": "curves visible"}  # in the history


def print_pictures(sizes, seconds, ways, points=0):
    """Print the table of frames and pauses; return figures for the history.

    With ``points`` of trails also the largest team with that many.
    """
    figures = []
    print(" ".join("{:>10}".format(column) for column in COLUMNS))
    for n in sizes:
        feeder = part(n, "--part", "feed")
        try:
            more = ("trails", "dragged", "saving") if points and n == max(sizes) else ()
            for way in (*ways, *more):
                row = shown(n, seconds, way, points)
                row.update(robots=n, shown=way)
                print(ROW.format(**row), flush=True)
                case = "{}: ".format(NAMES.get(way, way))
                figures.append((case + "pictures", n, row["frames"], "1/s"))
                figures.append((case + "CPU", n, row["cpu"], "share"))
                figures.append((case + "longest at work", n, row["worked"], "ms"))
                figures.append((case + "pause, 99th percentile", n, row["late"], "ms"))
        finally:
            ended([feeder])
    return figures


def factor(seconds):
    """Return the mean real-time factor that the stage reports for so many seconds."""
    import rospy

    from mrs_simulator.msg import StageStatus

    heard = []
    listener = rospy.Subscriber("/stage/status", StageStatus, heard.append)
    time.sleep(seconds)
    listener.unregister()
    if not heard:
        raise SystemExit("no stage was heard within {:g} s".format(seconds))
    return np.mean([status.real_time_factor for status in heard])


def stage_factors(n, seconds):
    """Return the real-time factor of a controlled team of ``n``: without and with the GUI."""
    import rospy

    from mrs_simulator.msg import ControlStatus

    with tempfile.TemporaryDirectory(prefix="mrs_simulator_bench_") as folder:
        path = os.path.join(folder, "scenario.yaml")
        with open(path, "w") as file:
            yaml.safe_dump({"poses": grid(n).tolist(), "duration": 1e5}, file)
        command = ["rosrun", "mrs_simulator"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        nodes = ["stage", "pioneer_control"]
        nodes = [subprocess.Popen(command + [n, "--scenario", path], **quiet) for n in nodes]
        try:
            rospy.wait_for_message("/pioneer_control/status", ControlStatus, LIMIT)
            time.sleep(SETTLE)
            alone = factor(seconds)
            gui = part(n, "--part", "show", "--seconds", seconds + 2.0, stdout=subprocess.DEVNULL)
            nodes.insert(0, gui)
            time.sleep(SETTLE + 2.0)
            return alone, factor(seconds)
        finally:
            ended(nodes)


def print_factors(sizes, seconds):
    """Print the table of real-time factors; return figures for the history."""
    import rospy

    figures = []

    rospy.init_node("benchmark", disable_signals=True)
    print(" ".join("{:>10}".format(name) for name in ("robots", "RTF alone", "with GUI")))
    for n in sizes:
        alone, attended = stage_factors(n, seconds)
        print("{:10d} {:10.3f} {:10.3f}".format(n, alone, attended), flush=True)
        figures.append(("real time lost with the GUI", n, max(0.0, 1.0 - attended), "share"))
    return figures


def with_master(work):
    """Do ``work`` with a master on a free port."""
    port = free_port()
    os.environ.update(ROS_MASTER_URI="http://localhost:{}".format(port), ROS_HOSTNAME="localhost")
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)])
    try:
        proxy, end = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]), time.time() + LIMIT
        while True:
            try:
                proxy.setParam("/benchmark", "/use_sim_time", True)
                break
            except OSError:
                if time.time() > end:
                    raise
                time.sleep(0.1)
        work()
    finally:
        ended([master])


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("robots", nargs="*", type=int, default=[7, 50, 100, 1000])
    parser.add_argument("--minutes", type=float, help="of one long run with curves")
    parser.add_argument("--seconds", type=float, default=10.0, help="of each short run")
    parser.add_argument("--display", action="store_true", help="draw on the DISPLAY")
    parser.add_argument("--no-stage", action="store_true", help="no real-time factors")
    parser.add_argument("--keep", action="store_true", help="add the figures to the history")
    parser.add_argument("--part", choices=("feed", "show"), help=argparse.SUPPRESS)
    parser.add_argument("--way", choices=WAYS, default="no curves", help=argparse.SUPPRESS)
    parser.add_argument(
        "--trails", type=int, default=100000, help="points of trails, 0: no such rows"
    )
    options = parser.parse_args()
    if options.part == "feed":
        feed(options.robots[0])
    elif options.part == "show":
        show(options.robots[0], options.seconds, options.way, options.trails)
    else:
        if not options.display:
            os.environ["QT_QPA_PLATFORM"] = "offscreen"
        with_master(lambda: tables(options))


def tables(options):
    """Print the tables asked for, keep them if that is wanted."""
    if options.minutes:
        print_pictures(options.robots, 60.0 * options.minutes, ("curves",))
        return
    ways, report = ("no curves", "curves"), Report("gui", keep=True) if options.keep else None
    figures = print_pictures(options.robots, options.seconds, ways, options.trails)
    if not options.no_stage:
        figures += print_factors(options.robots, options.seconds)
    if report:
        for figure in figures:
            report.note(*figure)
        report.close()


if __name__ == "__main__":
    main()
