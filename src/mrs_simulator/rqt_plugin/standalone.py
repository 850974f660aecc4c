"""The GUI in a window of its own, for systems without rqt."""

import argparse
import os
import signal
import subprocess
import sys
import time
from urllib.parse import urlparse

import rosgraph
import rospy

from mrs_simulator.core.doc_links import with_page
from mrs_simulator.ros.node.arguments import DIRECTORY_MEANING, RUN_ARGUMENTS, scenario_from
from mrs_simulator.ros.node.diagnostics import OK, Diagnostics, Health
from mrs_simulator.ros.node.lifecycle import spare_garbage_collection
from mrs_simulator.rqt_plugin.qt.QtCore import QSettings, QTimer
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication, QMainWindow
from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
from mrs_simulator.rqt_plugin.ros_side.controller_parameters import SHARED
from mrs_simulator.rqt_plugin.run.autosave import Autosave
from mrs_simulator.rqt_plugin.run.processes import Processes
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.interrupts import from_event_loop
from mrs_simulator.study.programs import BAD_INPUT

ARGUMENTS = dict(
    RUN_ARGUMENTS, scenario="YAML file (default: the last one)", directory=DIRECTORY_MEANING
)
PARAMETERS = (
    "parameters: the GUI reads none of its own.  Those of the nodes that it starts are listed by "
    "stage --help and pioneer_control --help.  Its check of real robots takes those below "
    "/pioneer_control on the parameter server: {}."
)
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")  # any of them gives Qt a place to draw
MASTER_LIMIT = 15.0  # [s] for a master that is started here
SIZE = (1280, 740)  # [px] of the window at first


class Window(QMainWindow):
    """The study widget with a frame, and settings that survive a restart."""

    def __init__(self, study, settings):
        super().__init__()
        self._settings, self.study = settings, study
        self.setWindowTitle(study.windowTitle())
        self.setCentralWidget(study)
        self.resize(*SIZE)
        geometry = settings.value("geometry")
        if geometry is not None:
            self.restoreGeometry(geometry)

    @guarded
    def closeEvent(self, event):
        """Keep the settings, end what was started here."""
        self._settings.setValue("geometry", self.saveGeometry())
        for key, value in self.study.save_settings().items():
            self._settings.setValue(key, value)
        self.study.close_study()
        super().closeEvent(event)


def main():
    """Run the GUI; without a master one is started on this host, and ended with the window."""
    parser = argparse.ArgumentParser(
        prog="mrs_gui",
        description="Coordination studies in one window.",
        epilog=PARAMETERS.format(", ".join(SHARED)),
    )
    parser.add_argument(
        "--fresh", action="store_true", help="without the settings of the last time"
    )
    # Those of the controller that a launch file starts beside it: the check is to be of the same run.
    for name, meaning in ARGUMENTS.items():
        parser.add_argument("--" + name, default="", help=meaning)
    arguments, rest = parser.parse_known_args(rospy.myargv()[1:])
    _refuse_parameters()
    if os.path.isdir(arguments.directory):
        os.chdir(arguments.directory)
    if not any(os.environ.get(name) for name in SCREENS):
        # Qt would abort.
        print(
            "mrs_gui: no display: wanted DISPLAY set, or xvfb-run before the command",
            file=sys.stderr,
        )
        sys.exit(BAD_INPUT)
    application = QApplication([sys.argv[0]] + rest)
    _end_on_signals(application)
    master = None if rosgraph.is_master_online() else _start_master()
    try:
        scenario = scenario_from(arguments)
        rospy.init_node("mrs_gui", anonymous=True, disable_signals=True)
        Diagnostics(lambda: [Health("", OK, "open", {})])
        settings = QSettings("mrs_simulator", "mrs_gui")
        if arguments.fresh:
            settings.clear()
        processes = Processes()
        study = StudyWidget(RosConnection(), processes, scenario, Autosave())
        kept = {key: settings.value(key) for key in ("across", "down", "shown", "programs")}
        if not arguments.scenario:
            kept["scenario"] = settings.value("scenario")
        window = Window(study, settings)
        window.show()
        # A user's law may take its time: the window, and its emergency stop, are there meanwhile.
        study.restore_settings(kept)
        spare_garbage_collection()
        code = application.exec_()
        processes.wait_closed()
    except (ValueError, OSError) as error:
        print("mrs_gui: {}".format(with_page(error)), file=sys.stderr)
        code = 2
    finally:
        rospy.signal_shutdown("window closed")
        if master is not None:
            _end_master(master)
    sys.stdout.flush()
    sys.stderr.flush()
    # Everything has been ended in order; the interpreter takes Qt's objects down in any order, and
    # that can crash.
    os._exit(code)


def _refuse_parameters():
    """End with a message if a ROS parameter is given, which would not be read."""
    for argument in sys.argv[1:]:
        name, assigned, _ = argument.partition(":=")
        if assigned and name.startswith("_") and not name.startswith("__"):
            text = "mrs_gui: {}: the GUI reads no parameters, wanted an option that --help lists"
            print(text.format(argument), file=sys.stderr)
            sys.exit(BAD_INPUT)


def _start_master():
    """Start a master where ``ROS_MASTER_URI`` says, for this host alone unless ``ROS_HOSTNAME`` is set."""
    os.environ.setdefault("ROS_HOSTNAME", "localhost")
    port = urlparse(rosgraph.get_master_uri()).port or 11311
    master = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    end = time.monotonic() + MASTER_LIMIT
    while not rosgraph.is_master_online():
        if master.poll() is not None or time.monotonic() > end:
            master.kill()
            raise OSError(
                "no ROS master at {}, and none could be started".format(rosgraph.get_master_uri())
            )
        time.sleep(0.1)
    return master


def _end_master(master):
    master.terminate()
    try:
        master.wait(MASTER_LIMIT)
    except subprocess.TimeoutExpired:
        master.kill()
        master.wait()


def _end_on_signals(application):
    """Close the window on signals; one not yet open, as soon as it is."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, from_event_loop(lambda *_: application.closeAllWindows()))
    # Python sees a signal only when Qt gives it a moment.
    timer = QTimer(application)
    timer.timeout.connect(lambda: None)
    timer.start(200)


if __name__ == "__main__":
    main()
