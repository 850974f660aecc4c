"""A window with the study widget, and the program around it."""

import os
import re
import signal
import socket
import sys

from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.rqt_plugin.qt.QtCore import QSettings, QTimer
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication, QMainWindow
from mrs_simulator.rqt_plugin.shelf.entry import BAG, is_listed, run_at
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.interrupts import from_event_loop
from mrs_simulator.rqt_plugin.widgets.on_screen import OnScreen
from mrs_simulator.rqt_plugin.window.saved_layout import LAYOUT
from mrs_simulator.study.bad_input import BAD_INPUT
from mrs_simulator.study.results.report import RUN_FILE, SCENARIO_FILE

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")  # any of them gives Qt a place to draw
X_SOCKET, X_PORT = "/tmp/.X11-unix/X{}", 6000  # of X servers
X_LIMIT = 3.0  # [s] of wall time for one to answer
KEPT = ("programs", *LAYOUT)  # of the settings, whatever is opened
SIZE = (1280, 740)  # [px] of the window at first


@guarded
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
        OnScreen(self).keep()  # the emergency stop is on it

    def closeEvent(self, event):
        """Keep the settings, end what was started here."""
        self._settings.setValue("geometry", self.saveGeometry())
        for key, value in self.study.save_settings().items():
            self._settings.setValue(key, value)
        self.study.close_study()
        super().closeEvent(event)


def open_application(program, arguments=()):
    """Return the ``QApplication`` of ``program``; exits with 2 where there is no display."""
    if sys.platform.startswith("linux") and not any(map(os.environ.get, SCREENS)):
        # Qt would abort.
        text = "{}: no display: wanted DISPLAY set, or xvfb-run before the command"
        print(text.format(program), file=sys.stderr)
        sys.exit(BAD_INPUT)
    silent = _silent_display()
    if silent:  # the same
        text = (
            "{}: display {} does not answer: wanted one that runs, or xvfb-run before the command"
        )
        print(text.format(program, silent), file=sys.stderr)
        sys.exit(BAD_INPUT)
    application = QApplication([sys.argv[0], *arguments])
    _end_on_signals(application)
    return application


def scenario_of_run(path):
    """Return the path of the run or sweep that ``path`` names, "" for none, and of the scenario to open.

    A run's scenario is the one beside it, "" where there is none.
    """
    is_folder = os.sep in path and os.path.isdir(path)  # else it may be a shipped scenario's name
    if not is_folder and not path.endswith((BAG, RUN_FILE)) and not is_listed(path):
        return "", path
    run = run_at(path)
    beside = os.path.join(run, SCENARIO_FILE)
    return run, beside if os.path.isfile(beside) else ""


def run_window(application, study, name, arguments, run=""):
    """Show the ``StudyWidget`` with the settings kept as ``name`` until it is closed; return the exit code.

    ``arguments``: ``fresh``, to begin without them, and ``scenario``, empty for the last one; ``run``: the
    path of a run to show, "" for none.
    """
    settings = QSettings("mrs_simulator", name)
    if arguments.fresh:
        settings.clear()
    kept = {key: settings.value(key) for key in KEPT}
    if not arguments.scenario:
        kept["scenario"] = settings.value("scenario")
    window = Window(study, settings)
    window.show()
    # A user's law may take its time: the window, and its emergency stop, are there meanwhile.
    study.restore_settings(kept)
    if run:
        study.shelf_control.open(run)
    elif not arguments.scenario:
        study.start.begin()
    spare_garbage_collection()
    return application.exec_()


def end_program(code):
    """End this program at once, with the exit code ``code``.

    Everything has been ended in order; the interpreter takes Qt's objects down in any order, and that can
    crash.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _silent_display():
    """Return the X display that Qt would use and that no server answers, or ""."""
    name = os.environ.get("DISPLAY", "")
    others = os.environ.get("WAYLAND_DISPLAY") or os.environ.get("QT_QPA_PLATFORM")
    found = re.fullmatch(r"(?:unix)?([^:/]*):(\d+)(?:\.\d+)?", name)
    if others or not found or not sys.platform.startswith("linux"):
        return ""
    host, number = found.groups()
    address = X_SOCKET.format(number)
    # With a NUL before it: in the abstract name space.
    places = [(host, X_PORT + int(number))] if host else [address, "\0" + address]
    return "" if any(map(_answers, places)) else name


def _answers(place):
    try:
        family = socket.AF_UNIX if isinstance(place, str) else socket.AF_INET
        with socket.socket(family) as tried:
            tried.settimeout(X_LIMIT)
            tried.connect(place)
    except OSError:
        return False
    return True


def _end_on_signals(application):
    """Close the window on signals; one not yet open, as soon as it is."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, from_event_loop(lambda *_: application.closeAllWindows()))
    # Python sees a signal only when Qt gives it a moment.
    timer = QTimer(application, timeout=lambda: None)
    timer.start(200)
