"""A window with the study widget, and the program around it."""

import os
import signal
import sys

from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.rqt_plugin.qt.QtCore import QSettings, QTimer
from mrs_simulator.rqt_plugin.qt.QtWidgets import QApplication, QMainWindow
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.widgets.interrupts import from_event_loop
from mrs_simulator.study.programs import BAD_INPUT

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")  # any of them gives Qt a place to draw
KEPT = ("across", "down", "shown", "programs")  # of the settings, whatever is opened
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


def open_application(program, arguments=()):
    """Return the ``QApplication`` of ``program``; exits with 2 where there is no display."""
    if sys.platform.startswith("linux") and not any(map(os.environ.get, SCREENS)):
        # Qt would abort.
        text = "{}: no display: wanted DISPLAY set, or xvfb-run before the command"
        print(text.format(program), file=sys.stderr)
        sys.exit(BAD_INPUT)
    application = QApplication([sys.argv[0], *arguments])
    _end_on_signals(application)
    return application


def run_window(application, study, name, arguments):
    """Show the ``StudyWidget`` with the settings kept as ``name`` until it is closed; return the exit code.

    ``arguments``: ``fresh``, to begin without them, and ``scenario``, empty for the last one.
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


def _end_on_signals(application):
    """Close the window on signals; one not yet open, as soon as it is."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, from_event_loop(lambda *_: application.closeAllWindows()))
    # Python sees a signal only when Qt gives it a moment.
    timer = QTimer(application)
    timer.timeout.connect(lambda: None)
    timer.start(200)
