"""The run's buttons: simulation, controller, speed, emergency stop."""

import contextlib
import functools
import math

from mrs_simulator.rqt_plugin.qt.QtCore import Qt, Signal
from mrs_simulator.rqt_plugin.qt.QtGui import QKeySequence
from mrs_simulator.rqt_plugin.qt.QtWidgets import (
    QComboBox,
    QFrame,
    QMenu,
    QPushButton,
    QShortcut,
    QToolButton,
    QWidget,
)
from mrs_simulator.rqt_plugin.run.duration_field import DurationField
from mrs_simulator.rqt_plugin.widgets.flow_layout import FlowLayout
from mrs_simulator.rqt_plugin.widgets.guard import guarded

SPEEDS = ("0.1", "0.5", "1", "2", "5", "10", "20", "0")
# name, text, key, what it does
ACTIONS = (
    (
        "run",
        "Run",
        "F5",
        "Run the scenario from its beginning for the duration beside, and judge the run",
    ),
    (
        "simulate",
        "Start simulation",
        "Ctrl+R",
        "Start the stage with this scenario, or attach to the running one",
    ),
    ("pause", "Pause", "Ctrl+P", "Pause or resume simulated time"),
    ("step", "Step", "Ctrl+.", "Advance a paused simulation by one step"),
    (
        "reset",
        "Reset",
        "Ctrl+0",
        "Stop the controller, and return the robots to their initial poses",
    ),
    ("end", "End", "Ctrl+E", "End the simulation that was started here"),
    (
        "preflight",
        "Check robots",
        "Ctrl+K",
        "Check that all robots publish odometry, are in place and keep their distance, now and predicted",
    ),
    ("control", "Start controller", "Ctrl+G", "Start the controller, which runs the protocol"),
    ("stop", "Stop controller", "Ctrl+T", "Stop the controller: all robots get zero commands"),
    ("bag", "Record bag", "Ctrl+B", "Start or end a rosbag of the run in ~/mrs_runs"),
    ("save", "Save...", "Ctrl+S", "Save data, figures, verdict and scenario"),
)
SINGLE = ("simulate", "control", "stop", "preflight")  # in a menu, unless robots are real
# In the menu too where they would take another line, the first of them first.
FOLDED = ("preflight", "bag", "step", "end", "reset", "stop", "simulate", "control")
# Beside "Save...": name, text, what it does
EXPORTS = (
    ("video", "Save with a video...", "As Save, with an animation beside its curves"),
    ("film", "Save with a video in 3D...", "As Save, with an animation in space beside its curves"),
    ("map", "Picture of the map...", "PNG, or PDF of vectors"),
    ("view", "Picture of the 3D view...", "PNG, or PDF of vectors"),
    ("curves", "Picture of the curves...", "PNG, PDF or SVG"),
    (
        "figure",
        "Compose a figure...",
        "Chosen panels, robots and times of the run saved last, and the command that draws them",
    ),
    ("table", "Copy the curves", "The curves shown as CSV, for a spreadsheet"),
)
EXPORT = "export "  # before the name of one of them, in what is asked
FASTER, SLOWER = ("Ctrl++", "Ctrl+="), ("Ctrl+-",)
SPEED_TIP = "Simulated over wall time; max: as fast as possible ({} faster, {} slower)".format(
    FASTER[0], SLOWER[0]
)
BREAKS = ("preflight", "bag")  # a gap before these
EMERGENCY_KEY = "F8"
UNDO_KEY, REDO_KEY = "Ctrl+Z", "Ctrl+Shift+Z"  # a field that is being edited takes them first
RED = "QPushButton { background: #c00000; color: white; font-weight: bold; padding: 4px 12px; }"


@guarded
class RunBar(QWidget):
    """Buttons with shortcuts that work inside the plugin alone; the emergency stop's works everywhere.

    What is used less goes to the menu *More* where it would take another line; what has no room then is in
    another line.  The emergency stop keeps its corner.
    """

    asked = Signal(str)  # the name of an action
    speed_chosen = Signal(float)  # simulated over wall time, 0: as fast as possible
    emergency = Signal(bool)  # pressed, or released
    undo_asked, redo_asked = Signal(), Signal()

    def __init__(self, owner, parent=None):
        """``owner``: the widget within which the shortcuts work."""
        super().__init__(parent)
        self._row = row = FlowLayout(self)
        row.setContentsMargins(2, 2, 2, 2)
        self._buttons, self._tips, self._entries = {}, {"speed": SPEED_TIP}, {}
        self._keys = {}
        # whether SINGLE have buttons; what does not exist
        self._singly, self._absent = False, set()
        for name, text, key, meaning in ACTIONS:
            if name in BREAKS:
                row.add_gap(_line())
            row.addWidget(self._button(owner, name, text, key, meaning))
            if name == "run":
                self.duration = DurationField()
                row.addWidget(self.duration)
            if name == "end":
                row.addWidget(self._build_speed(owner))
                row.addWidget(self._build_menu())
        self._emphasize(self._buttons["run"])
        self._add_exports(self._buttons["save"])
        row.add_corner(self._build_emergency())
        self._fold()
        self._stop_key = None
        _shortcut(UNDO_KEY, owner, self.undo_asked.emit)
        _shortcut(REDO_KEY, owner, self.redo_asked.emit)

    def _build_emergency(self):
        self._stop_all = QPushButton("EMERGENCY STOP", checkable=True, styleSheet=RED)
        self.is_emergency = self._stop_all.isChecked
        text = "All robots stop and stay so until released ({}, from every window)"
        self._stop_all.setToolTip(text.format(EMERGENCY_KEY))
        self._stop_all.toggled.connect(self._on_emergency)
        return self._stop_all

    def bind_keys(self, window):
        """Take the emergency stop's key from ``window``, and any other window of the application.

        To be called again whenever that may be another window, as when rqt floats a dock: a shortcut
        of the plugin itself sleeps while the plugin has no focus, or lies behind another tab.
        """
        if self._stop_key is not None:
            with contextlib.suppress(RuntimeError):  # it has gone with its window
                if self._stop_key.parent() is window:
                    return
                self._stop_key.deleteLater()
                self._stop_key.setEnabled(False)
        self._stop_key = QShortcut(QKeySequence(EMERGENCY_KEY), window)
        self._stop_key.setContext(Qt.ApplicationShortcut)
        for signal in (self._stop_key.activated, self._stop_key.activatedAmbiguously):
            signal.connect(self._press)

    def release_keys(self):
        """Leave the emergency stop's key to others."""
        if self._stop_key is not None:
            with contextlib.suppress(RuntimeError):
                self._stop_key.setEnabled(False)
                self._stop_key.deleteLater()
            self._stop_key = None

    def _button(self, owner, name, text, key, meaning):
        self._tips[name], self._keys[name] = "{} ({})".format(meaning, key), key
        button = QToolButton(text=text, toolTip=self._tips[name])
        button.clicked.connect(guarded(lambda *_: self.asked.emit(name)))
        _shortcut(key, owner, button.click)
        self._buttons[name] = button
        return button

    @staticmethod
    def _emphasize(button):
        font = button.font()
        font.setBold(True)
        button.setFont(font)  # a style sheet would change the size only once it is shown
        button.setText("\u25b6 " + button.text())

    def _build_menu(self):
        self.more, menu = QToolButton(text="More", popupMode=QToolButton.InstantPopup), QMenu(self)
        self.more.setToolTip("Start and stop simulation and controller, each by itself, and others")
        menu.setToolTipsVisible(True)
        for name, text, key, _ in ACTIONS:
            if name in FOLDED:
                self._entries[name] = entry = menu.addAction("{}\t{}".format(text, key))
                entry.triggered.connect(guarded(lambda *_, name=name: self.asked.emit(name)))
        self.more.setMenu(menu)
        return self.more

    def _add_exports(self, button):
        """Offer the other ways to take results away in a menu of the ``button``."""
        self.exports = menu = QMenu(self, toolTipsVisible=True)
        for name, text, meaning in EXPORTS:
            entry = menu.addAction(text)
            entry.setToolTip(meaning)
            entry.triggered.connect(guarded(lambda *_, n=name: self.asked.emit(EXPORT + n)))
        button.setMenu(menu)
        button.setPopupMode(QToolButton.MenuButtonPopup)

    def show_singly(self, shown):
        """Show, beside their menu, the buttons that start and stop one program each."""
        if self._singly != shown:
            self._singly = shown
            self._fold()

    def resizeEvent(self, event):
        """Put into the menu what would take another line."""
        super().resizeEvent(event)
        self._fold()

    def _fold(self):
        """Show as many buttons as the fewest possible lines hold; the others are in the menu."""
        always = self._absent if self._singly else self._absent.union(SINGLE)
        may_be = [name for name in FOLDED if name not in always]
        lines = [self._lines(always.union(may_be[:count])) for count in range(len(may_be) + 1)]
        hidden = always.union(may_be[: lines.index(min(lines))])
        for name, button in self._buttons.items():
            button.setHidden(name in hidden)
        for name, entry in self._entries.items():
            entry.setVisible(name in hidden and name not in self._absent)
        self.more.setHidden(not any(entry.isVisible() for entry in self._entries.values()))

    def _lines(self, hidden):
        widgets = [self._buttons[name] for name in hidden]
        menu = [] if hidden.difference(self._absent) else [self.more]
        return self._row.count_lines(self.width(), [*widgets, *menu])

    def _build_speed(self, owner):
        self._speed = QComboBox(toolTip=SPEED_TIP)
        for speed in SPEEDS:
            self._speed.addItem("max" if speed == "0" else "{} \u00d7".format(speed), float(speed))
        self._speed.setCurrentIndex(SPEEDS.index("1"))
        self._speed.activated.connect(guarded(lambda *_: self.speed_chosen.emit(self.speed())))
        for keys, steps in ((FASTER, 1), (SLOWER, -1)):
            for key in keys:
                _shortcut(key, owner, functools.partial(self._change_speed, steps))
        return self._speed

    def _change_speed(self, steps):
        """Choose the next faster speed, or with -1 the next slower one."""
        offered = [self._speed.itemData(index) for index in range(self._speed.count())]
        offered.sort(key=lambda speed: speed or math.inf)
        wanted = offered.index(self.speed()) + steps
        if self._speed.isEnabled() and 0 <= wanted < len(offered):
            self.set_speed(offered[wanted])
            self.speed_chosen.emit(self.speed())

    @guarded
    def _press(self, *_):
        # The key only ever stops; releasing is a deliberate click.
        self._stop_all.setChecked(True)

    def _on_emergency(self, on):
        self._stop_all.setText("RELEASE STOP" if on else "EMERGENCY STOP")
        self.emergency.emit(on)

    def speed(self):
        """Return the speed chosen."""
        return float(self._speed.currentData())

    def set_speed(self, speed):
        """Show ``speed``; one that is not in the list is added."""
        index = self._speed.findData(float(speed))
        if index < 0:
            self._speed.addItem("{:g} \u00d7".format(speed), float(speed))
            index = self._speed.count() - 1
        self._speed.setCurrentIndex(index)

    def set_enabled(self, name, enabled, remark=""):
        """Enable or disable the action ``name``, or "speed"; ``remark``: why, in the tooltip."""
        widget = self.button(name)
        widget.setEnabled(enabled)
        if name in self._entries:
            self._entries[name].setEnabled(enabled)
        tip = self._tips[name]
        if remark:
            tip += "\n{}{}".format("" if enabled else "Not now: ", remark)
        if tip != widget.toolTip():
            widget.setToolTip(tip)
            if name in self._entries:
                self._entries[name].setToolTip(tip)

    def hide_absent(self, absent):
        """Hide the buttons of actions that are ``absent``."""
        self._absent.update(name for name in absent if name in self._buttons)
        self._fold()

    def show_duration(self, duration):
        """Show that the next run lasts for ``duration`` [s]."""
        before = self.duration.width()
        self.duration.show_duration(duration)
        if self.duration.width() != before:
            self._fold()

    def set_paused(self, paused):
        """Show what the pause button would do now."""
        self._buttons["pause"].setText("Go on" if paused else "Pause")

    def set_recording(self, recording):
        """Show what the bag button would do now."""
        text = "End bag" if recording else "Record bag"
        self._buttons["bag"].setText(text)
        self._entries["bag"].setText("{}\t{}".format(text, self._keys["bag"]))

    def set_emergency(self, on):
        """Show the state of the emergency stop; no signal."""
        if on != self._stop_all.isChecked():
            self._stop_all.blockSignals(True)
            self._stop_all.setChecked(on)
            self._stop_all.setText("RELEASE STOP" if on else "EMERGENCY STOP")
            self._stop_all.blockSignals(False)

    def button(self, name):
        """Return the button of the action ``name``; "emergency" and "speed" are there too."""
        others = {"emergency": self._stop_all, "speed": self._speed}
        return others[name] if name in others else self._buttons[name]


def _shortcut(key, owner, action):
    shortcut = QShortcut(QKeySequence(key), owner, activated=guarded(lambda *_: action()))
    # Of this plugin alone: rqt's other plugins keep their keys.
    shortcut.setContext(Qt.WidgetWithChildrenShortcut)


def _line():
    line = QFrame(frameShape=QFrame.VLine, frameShadow=QFrame.Plain)
    line.setEnabled(False)  # pale in every theme
    line.setFixedHeight(line.fontMetrics().height())
    return line
