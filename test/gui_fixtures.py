"""What the tests of the GUI share: a GUI over a real master, and errors that nobody would see."""

import collections
import os
import sys
import tempfile
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from forked import forker_without_ros, forking_subprocess
from ros_fixtures import log_of

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LOADED = (
    "PyQt5.QtTest",
    "mrs_simulator.nodes.real.preflight",
    "mrs_simulator.rqt_plugin.ros_side.connection",
    "mrs_simulator.rqt_plugin.study_widget",
)
# Two points that agree within their requirement, and what may vary of them.
MEETING = """
title: Two points agree
poses: [[0, 0, 0], [1, 0.5, 0]]
fidelity: point_mass
limits: none
control: {protocol: consensus, rate: 10, saturation: none, parameters: {gain: 0.5}}
topology: {edges: [[1, 2]], directed: false}
duration: 2
requirements:
  near: always(each pair(distance < 2 m))
"""
SEARCHED = """
search:
  poses: {within: [-3, -3, 3, 3], apart: 1}
  control.parameters.gain: [0.2, 0.8]
"""
# Windows that a test has let go: painted once more, they could be collected while they paint.
HELD = collections.deque(maxlen=8)
# A GUI of its own process: rospy joins one master only.
PROGRAM = """
import json, os, sys, time
import rospy
sys.path.append("TESTS")
from forked import OwnForker, forking_subprocess
from mrs_simulator.nodes.real import preflight
from mrs_simulator.rqt_plugin.ros_side import master
preflight.LISTENING = 0.5  # [s]: ten messages of what stands in for a robot
master.LOOK_PERIOD = 0.2  # [s]: tests wait for what it finds
programs = OwnForker() if "FORKED_PROGRAMS" in os.environ else None
from PyQt5.QtWidgets import QApplication
from PyQt5.QtTest import QTest
from PyQt5.QtCore import QPoint, Qt
application = QApplication([])
rospy.init_node("gui", disable_signals=True)
import logging
from mrs_simulator.rqt_plugin.widgets import guard
trouble = []
class Keep(logging.Handler):
    def emit(self, record):
        trouble.append(self.format(record))
guard.LOG.addHandler(Keep())
from mrs_simulator.control import worker_process
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
from mrs_simulator.rqt_plugin.run.edited_scenario import EditedScenario
from mrs_simulator.rqt_plugin.run.processes import PARENT, Processes
from mrs_simulator.rqt_plugin import study_widget
from mrs_simulator.rqt_plugin.curves import drawn
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from gui_tables import judged_row, rows_of
EditedScenario.predict = lambda *_: None  # as with no_predictions
# Most of the window's work while tests wait is pictures that nobody sees.
study_widget.FRAME = 250  # [ms]
drawn.DrawnCurves.tick = drawn._Canvas.draw = lambda *_: None
popen = Processes._open
def forked_open(processes, name, command):
    # Nodes are forks, as are laws: to load each anew takes longer than most of them run.
    if command[:2] != ["rosrun", "mrs_simulator"] or command[2] not in NODES:
        return popen(processes, name, command)
    log = os.path.join(processes.directory, name + ".log")
    open(log, "wb").close()
    script = os.path.join(os.environ["FORKED_PROGRAMS"], command[2])
    environment = dict(os.environ, PYTHONUNBUFFERED="1", **{PARENT: str(programs.pid)})
    return programs.start(script, command[3:], environment, log, log, leads=True)
NODES = "stage", "pioneer_control", "preflight", "record", "report", "experiment", "assure"
if programs is not None:
    Processes._open = forked_open
    worker_process.subprocess = forking_subprocess(programs)
gui = StudyWidget(RosConnection(), Processes(), load_scenario(sys.argv[1]))
gui.resize(1366, 768)
gui.show()

def until(condition, limit=60.0):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        application.processEvents()
        if condition():
            return
        time.sleep(0.02)
    said = gui.messages.toPlainText(), trouble, gui.study.state.lines(), gui.study.state.actions()
    said += (rows_of(gui.preflight),)
    raise SystemExit("\\n".join(["not within {} s".format(limit), *map(str, said)]))

def click(name):
    until(lambda: gui.bar.button(name).isEnabled())
    QTest.mouseClick(gui.bar.button(name), Qt.LeftButton)

def key(letter):
    QTest.keyClick(gui, letter, Qt.ControlModifier)

""".replace("TESTS", os.path.dirname(os.path.abspath(__file__)))
END = """
gui.close_study()
gui.study.processes.wait_closed()
assert not trouble, trouble
print("done", flush=True)
os._exit(0)  # as the window does: the interpreter takes Qt's objects down in any order
"""


def run_gui(ros, code, path, *arguments, limit=240):
    """Run a piece of Python in a GUI's process with the scenario at ``path``; return what it printed."""
    command = [sys.executable, "-c", PROGRAM + code + END, path, *map(str, arguments)]
    name = os.path.basename(tempfile.mkdtemp(prefix="gui", dir=ros.directory))
    process = ros.start(name, command, loaded=LOADED)
    returned = process.wait(limit)
    output = log_of(process)
    assert returned == 0 and output.rstrip().endswith("done"), output[-3000:]
    return output


@pytest.fixture(scope="session")
def app():
    """Return the application, which a widget must not outlive."""
    from PyQt5.QtWidgets import QApplication  # not for the tests without widgets

    return QApplication.instance() or QApplication([])


@pytest.fixture
def gui(ros, tmp_path):
    """Run a piece of Python in a GUI's process; return what it printed."""
    ros.environment["HOME"] = str(tmp_path)
    ros.use_quick_rosrun()

    def run(code, *arguments, scenario="paper_four", limit=240):
        path = os.path.join(ROOT, "scenarios", os.path.splitext(scenario)[0] + ".yaml")
        return run_gui(ros, code, path, *arguments, limit=limit)

    return run


def quiet_study(scenario, processes=None, autosave=None, draws_curves=False):
    """Return the whole GUI with nothing behind it but ``processes``, if given, and timers that stand.

    ``autosave``: where its edits are kept.
    """
    from unittest.mock import MagicMock

    from PyQt5.QtCore import QTimer  # not for the tests without widgets

    from mrs_simulator.rqt_plugin.study_widget import StudyWidget

    connection = MagicMock(master_online=False)
    connection.snapshot.return_value = connection.newest.return_value = None
    connection.is_fresh.return_value, connection.silence.return_value = False, None
    connection.registered = frozenset()
    for take in (connection.take_samples, connection.take_results, connection.take):
        take.return_value = []
    connection.diagnostics.return_value = []
    if processes is None:
        processes = MagicMock()
        processes.is_running.return_value, processes.age.return_value = False, 0.0
        processes.take_ended.return_value, processes.code.return_value = [], None
        processes.output.return_value, processes.is_ending.return_value = "", False
    widget = StudyWidget(connection, processes, scenario, autosave)
    HELD.append(widget)
    widget.study.shelf.home = os.path.join(tempfile.gettempdir(), "no shelf")
    for timer in widget.findChildren(QTimer):
        timer.stop()
    if not draws_curves:
        leave_out_curves(widget)
    return widget


def leave_out_curves(widget):
    """Let the GUI paint no curves: empty ones cost as much as all else that is shown."""
    widget.curves.timer.timeout.disconnect()  # it is started once they are shown
    widget.curves.canvas.draw = lambda: None


def alive(group):
    """Return the ids of the processes of a ``group`` that have not ended."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/{}/stat".format(name)) as file:
                state, _, own = file.read().rpartition(")")[2].split()[:3]
        except OSError:  # it has ended meanwhile
            continue
        if int(own) == group and state != "Z":
            found.append(int(name))
    return found


def shown(widget, width, height):
    """Return the widget, shown in this size and active, so that keys reach it."""
    from PyQt5.QtTest import QTest  # not for the tests without widgets

    widget.resize(width, height)
    widget.show()
    widget.activateWindow()
    assert QTest.qWaitForWindowActive(widget)
    return widget


def wait_shown(condition, limit=120.0, follow=lambda: None, said=lambda: ""):
    """Let the window go on until the condition holds.

    ``follow()`` does before each look what timers would that stand; ``said()``: what a failure tells.
    """
    from PyQt5.QtTest import QTest  # not for the tests without widgets

    end = time.monotonic() + limit
    while True:
        follow()
        if condition():
            return
        assert time.monotonic() < end, said()
        QTest.qWait(10)


def wait_drawn(curves, limit=60.0):
    """Let the window go on until its ``CurvesPanel`` has nothing left to draw."""
    from PyQt5.QtTest import QTest  # not for the tests without widgets

    end = time.monotonic() + limit
    QTest.qWait(20)
    while curves._dirty or curves._prepared is not None or curves._stamp() != curves._drawn:
        assert time.monotonic() < end
        QTest.qWait(20)


@pytest.fixture
def no_hidden_errors(monkeypatch):
    """Fail if a slot or an event handler raised."""
    from PyQt5.QtWidgets import QApplication  # not for the tests without widgets

    from mrs_simulator.rqt_plugin.widgets.guard import LOG

    raised = []
    monkeypatch.setattr(LOG, "exception", lambda *told: raised.append((told, sys.exc_info()[1])))
    yield
    QApplication.instance().processEvents()
    assert raised == []


@pytest.fixture
def forked_programs(monkeypatch):
    """Let a window's programs and its laws be forks: to load each anew takes longer than most run."""
    from mrs_simulator.control import worker_process
    from mrs_simulator.rqt_plugin.run import processes

    forking = forking_subprocess(forker_without_ros())
    monkeypatch.setattr(worker_process, "subprocess", forking)
    monkeypatch.setattr(processes, "subprocess", forking)


# Of a test that looks at predictions all the same.
PREDICTS = pytest.mark.parametrize("no_predictions", [False], indirect=True)


@pytest.fixture
def no_predictions(monkeypatch, request):
    """Let windows compute no predictions, for which each starts an interpreter."""
    if getattr(request, "param", True):
        predict = "mrs_simulator.rqt_plugin.run.edited_scenario.EditedScenario.predict"
        monkeypatch.setattr(predict, lambda *_: None)
