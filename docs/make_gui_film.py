#!/usr/bin/env python3
"""Make the film of a study in the GUI, docs/images/study.webm: python3 docs/make_gui_film.py [FILE]

A minute in the window without ROS: a scenario is chosen, changed by mouse, run and judged; another gain is
compared; a moment is asked what if; a sweep shows where theory holds.  Needs ffmpeg, and no display.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
# With no settings of the user's.
os.environ["HOME"] = tempfile.mkdtemp(prefix="mrs_simulator_film_")

import numpy as np
from PyQt5.QtCore import QEvent, QPoint, QPointF, QRect, Qt
from PyQt5.QtGui import QColor, QFont, QImage, QMouseEvent, QPainter, QPolygonF
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLineEdit

from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.window.main_window import open_application
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path

DOCS = os.path.dirname(os.path.abspath(__file__))
SIZE, STRIP = (1366, 860), 44  # [px] of the window, and height of the words below it
RATE = 8  # [Hz] of frames
LIMIT = 120.0  # [s] of wall time for anything to come about
ARROW = ((0, 0), (0, 17), (4, 13.5), (7, 20), (10, 18.5), (7, 12.5), (12.5, 12.5))  # [px]
PAPER, INK, HALO = "#ffffff", "#1d2733", "#e69f00"
NONE, NONE_PRESSED = Qt.NoModifier, Qt.NoButton


class Film:
    """A window that is used by a mouse, frame by frame; words below say what is done."""

    def __init__(self, application, gui, path):
        self.application, self.gui = application, gui
        self._at, self._words, self._down = np.array([SIZE[0] * 0.6, SIZE[1] * 0.5]), "", False
        self.frames = 0
        size = "{}x{}".format(SIZE[0], SIZE[1] + STRIP)
        command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
        command += ["-s", size, "-r", str(RATE), "-i", "-", "-c:v", "libvpx-vp9", "-crf", "38"]
        command += ["-b:v", "0", "-g", "80", "-pix_fmt", "yuv420p", "-vf", "scale=1138:-2", path]
        self._encoder = subprocess.Popen(command, stdin=subprocess.PIPE)

    def close(self):
        """End the file."""
        self._encoder.stdin.close()
        if self._encoder.wait():
            raise SystemExit("ffmpeg failed")

    def until(self, condition):
        """Let the window go on until ``condition()`` is true."""
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise SystemExit("nothing to film within {:g} s: {}".format(LIMIT, self._words))
            self.application.processEvents()
            time.sleep(0.003)

    def rest(self, seconds):
        """Let the window go on for so long [s] of wall time, unseen."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end)

    def say(self, words):
        """Show ``words`` from now on."""
        self._words = words

    def hold(self, seconds):
        """Show what there is for ``seconds`` of the film."""
        self.rest(0.2)
        picture = self._picture()
        for _ in range(int(round(seconds * RATE))):
            self._write(picture)

    def watch(self, value, step, end):
        """Take a frame each time that ``value()`` has grown by ``step``, until it is ``end``."""
        for wanted in np.arange(value(), end, step):
            self.until(lambda wanted=wanted: value() >= wanted)
            self._write(self._picture())

    def move(self, widget, at=None, seconds=0.6):
        """Move the mouse over ``widget``, to ``at`` [px] in it or its middle."""
        goal = self._place(widget, at)
        count = max(2, int(round(seconds * RATE)))
        begin = self._at
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            self._at = begin + (goal - begin) * (3.0 - 2.0 * share) * share**2
            self._write(self._picture())

    def click(self, widget, at=None):
        """Move to ``widget``, and press the left button there."""
        self.move(widget, at)
        self._down = True
        self._write(self._picture())
        self._down = False
        QTest.mouseClick(widget, Qt.LeftButton, NONE, at or widget.rect().center())
        self.hold(0.4)

    def drag(self, widget, begin, end, seconds=1.2, stops=8):
        """Drag from ``begin`` to ``end`` [px] in ``widget``."""
        self.move(widget, begin)
        self._down = True
        QTest.mousePress(widget, Qt.LeftButton, NONE, begin)
        for share in np.linspace(0.0, 1.0, stops + 1)[1:]:
            at = begin + (end - begin) * share
            event = QMouseEvent(QEvent.MouseMove, QPointF(at), NONE_PRESSED, Qt.LeftButton, NONE)
            self.application.sendEvent(widget, event)
            self._at = self._place(widget, at)
            self.rest(0.35)  # what follows the mouse is computed meanwhile
            for _ in range(max(1, int(round(seconds * RATE / stops)))):
                self._write(self._picture())
        QTest.mouseRelease(widget, Qt.LeftButton, NONE, end)
        self._down = False
        self.hold(0.3)

    def type(self, field, text):
        """Type ``text`` into ``field`` in place of what it has, and Return."""
        self.click(field)
        QTest.keyClick(field, Qt.Key_A, Qt.ControlModifier)
        for letter in text:
            QTest.keyClicks(field, letter)
            self._write(self._picture())
        QTest.keyClick(field, Qt.Key_Return)
        self.hold(0.4)

    def tab(self, tabs, name):
        """Click on the tab ``name`` of ``tabs``."""
        bar = tabs.tabBar()
        (index,) = (i for i in range(tabs.count()) if tabs.tabText(i).startswith(name))
        self.move(bar, bar.tabRect(index).center())
        self.click(bar, bar.tabRect(index).center())  # which another tab's new text may have moved

    def _place(self, widget, at):
        at = widget.rect().center() if at is None else at
        window = widget.window()
        point = widget.mapTo(window, QPoint(int(at.x()), int(at.y())))
        corner = QPoint(0, 0) if window is self.gui else self._corner(window)
        return np.array([point.x() + corner.x(), point.y() + corner.y()], dtype=float)

    def _corner(self, dialog):
        return QPoint((SIZE[0] - dialog.width()) // 2, (SIZE[1] - dialog.height()) // 2)

    def _picture(self):
        """Return the frame: the window, what lies over it, the mouse, and the words."""
        self.application.processEvents()
        image = QImage(SIZE[0], SIZE[1] + STRIP, QImage.Format_RGB888)
        image.fill(QColor(PAPER))
        painter = QPainter(image)
        painter.setRenderHint(QPainter.Antialiasing)
        painter.drawPixmap(0, 0, self.gui.grab())
        for window in self.application.topLevelWidgets():
            if window is not self.gui and window.isVisible() and window.windowTitle():
                painter.fillRect(QRect(0, 0, *SIZE), QColor(0, 0, 0, 90))
                painter.drawPixmap(self._corner(window), window.grab())
        self._draw_mouse(painter)
        painter.fillRect(0, SIZE[1], SIZE[0], STRIP, QColor(INK))
        painter.setPen(QColor(PAPER))
        font = QFont(self.gui.font())
        font.setPixelSize(19)
        painter.setFont(font)
        painter.drawText(QRect(16, SIZE[1], SIZE[0] - 32, STRIP), Qt.AlignVCenter, self._words)
        painter.end()
        return image

    def _draw_mouse(self, painter):
        painter.save()
        painter.translate(QPointF(*self._at))
        if self._down:
            painter.setPen(Qt.NoPen)
            halo = QColor(HALO)
            halo.setAlpha(140)
            painter.setBrush(halo)
            painter.drawEllipse(QPointF(0.0, 0.0), 15.0, 15.0)
        painter.setPen(QColor(PAPER))
        painter.setBrush(QColor(INK))
        painter.drawPolygon(QPolygonF([QPointF(*corner) for corner in ARROW]))
        painter.restore()

    def _write(self, image):
        bits = image.constBits().asarray(image.byteCount())
        rows = np.frombuffer(bits, dtype=np.uint8).reshape(image.height(), image.bytesPerLine())
        self._encoder.stdin.write(rows[:, : 3 * image.width()].tobytes())
        self.frames += 1


def main():
    """Write the film to the file that the command line names, or to its place."""
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(DOCS, "images", "study.webm")
    application = open_application("gui")
    connection = LocalConnection()
    gui = StudyWidget(connection, LocalProcesses(connection), load_scenario(scenario_path("paper")))
    gui.files.memory.change(tour=False)
    gui.resize(*SIZE)
    gui.show()
    gui.right.setSizes([60 * SIZE[1] // 100, 40 * SIZE[1] // 100])
    film = Film(application, gui, path)
    try:
        for scene in (choose, change, run, look_in_space, compare, what_if, sweep):
            scene(film, gui)
        film.hold(2.0)
        film.close()
    finally:
        gui.close_study()
        gui.study.processes.wait_closed()
        shutil.rmtree(os.environ["HOME"], ignore_errors=True)
    seconds, size = film.frames / RATE, os.path.getsize(path) / 1e6
    print("{}: {:.0f} s, {:.1f} MB".format(path, seconds, size), flush=True)
    os._exit(0)  # as the window does: the interpreter takes Qt's objects down in any order


def choose(film, gui):
    """Open a shipped scenario by its card."""
    film.say("Choose a scenario: robots, law and theorem")
    gui.start.begin()
    picker = gui.start.picker
    film.until(lambda: picker.list.count() > 5)
    film.rest(4.0)  # pictures of the cards
    film.hold(1.5)
    field = picker.findChild(QLineEdit)
    film.move(field)
    for letter in "circle by disp":
        QTest.keyClicks(field, letter)
        film.hold(0.12)
    film.hold(0.6)
    QTest.keyClick(field, Qt.Key_Return)
    film.until(lambda: gui.start.picker is None)
    film.hold(1.5)


def change(film, gui):
    """Move a robot, and add an edge."""
    film.say("Place robots and draw the graph by mouse; faint lines are where theory has them go")
    film.click(gui.modes["poses"])
    film.drag(gui.map, place_of(gui, 1), place_of(gui, 1) + QPoint(-40, -45))
    film.click(gui.modes["edges"])
    film.drag(gui.map, place_of(gui, 2), place_of(gui, 5), stops=6)
    film.click(gui.modes["look"])
    film.hold(0.8)


def run(film, gui):
    """Run the scenario with a verdict that goes along."""
    film.say("Run: each claim of the theorem is followed while the robots move")
    film.tab(gui.results_tabs, "Verdict")
    gui.bar.set_speed(2)
    film.click(gui.bar.button("run"))
    film.until(lambda: len(gui.history.time) > 2)
    film.watch(lambda: gui.history.time[-1], 0.5, 0.95 * gui.scenario.duration)
    film.until(lambda: gui.verdict.verdict)
    film.say("PASSED: predicted and measured, claim by claim, with the margin of each")
    film.hold(2.5)


def look_in_space(film, gui):
    """Play the run again in three dimensions."""
    film.say("Any moment again, on the map and in 3D")
    film.tab(gui.results_tabs, "3D")
    for moment in np.linspace(0.0, 8.0, 20):
        gui.replay.cursor.go(moment)
        gui.replay.show_frame()
        film.rest(0.1)
        film._write(film._picture())
    film.hold(0.5)
    gui.replay.cursor.follow()


def compare(film, gui):
    """Run another gain, and lay both runs over each other."""
    from mrs_simulator.rqt_plugin.protocol.parameter_form import ParameterForm

    film.say("Another gain, and both runs over each other")
    film.tab(gui.settings_tabs, "Protocol")
    film.type(gui.protocol.findChild(ParameterForm)._rows["gain"].editor, "0.2")
    gui.bar.set_speed(0)
    runs = gui.shelf.list
    film.click(gui.bar.button("run"))
    film.until(lambda: len(runs.runs.entries) == 2 and gui.results.of_run())
    film.until(lambda: all(entry.outcome for entry in runs.runs.entries))
    film.hold(1.0)
    film.tab(gui.settings_tabs, "Runs")
    box = runs.itemDelegate().box(runs.visualRect(runs.runs.index(1)))
    film.click(runs.viewport(), box.center())
    film.until(lambda: gui.map.ghosts)
    film.hold(2.5)
    runs.clear_compared()
    film.hold(0.3)


def what_if(film, gui):
    """Ask what if a robot were elsewhere, at a moment of the run."""
    film.say("What if? Drag a robot: its future is simulated at once, as ghosts")
    film.click(gui.modes["ahead"])
    gui.replay.cursor.go(2.0)
    film.rest(6.0)  # the first look takes the law's imports
    at = place_of(gui, 4)
    film.drag(gui.map, at, at + QPoint(-70, 55), seconds=2.5, stops=10)
    film.hold(1.5)
    film.click(gui.modes["look"])


def sweep(film, gui):
    """Sweep gain and delay, with theory's boundary."""
    film.say("Sweep two parameters: the dashed line is where theory says that it breaks")
    scenario = load_scenario(scenario_path("delayed_consensus"))
    gui.editing.take(scenario._replace(fidelity="point_mass", duration=30.0))
    gui.right.setSizes([SIZE[1] // 2, SIZE[1] // 2])
    film.tab(gui.results_tabs, "Sweep")
    ends = (("gain", "0.2", "1.4"), ("tau", "0.1", "1.2"))
    for form, (name, low, high) in zip(gui.sweep.axes, ends):
        form.choose(name)
        form.low.setText(low)
        form.high.setText(high)
        form.count.setValue(9)
    film.hold(0.8)
    film.click(gui.sweep.start)
    known = gui.sweep_control.cells.known
    film.watch(lambda: len(known()), 4, 81)
    film.until(lambda: gui.sweep.start.isEnabled())
    gui.sweep.quantity.setCurrentText("growth rate")
    film.hold(2.0)
    film.say("A click on a cell opens its run")
    film.click(gui.sweep.map, QPoint(int(0.6 * gui.sweep.map.width()), gui.sweep.map.height() // 2))
    film.hold(2.0)


def place_of(gui, number):
    """Return where the robot ``number`` is on the map, as a ``QPoint``."""
    row = list(gui.map.team.numbers).index(number)
    x, y = gui.map.team.pose[row, :2]
    return QPoint(*map(int, gui.map.to_screen(x, y)))


if __name__ == "__main__":
    main()
