"""Shows the moment of the time cursor, where it is not the newest, on map and curves."""

import re
import time

import numpy as np

from mrs_simulator.rqt_plugin.map.trails import Trails
from mrs_simulator.rqt_plugin.replay.time_cursor import TimeCursor
from mrs_simulator.rqt_plugin.widgets.guard import guarded
from mrs_simulator.rqt_plugin.window.past_law import PastLaw

MOST_PASSED = 400  # [-] samples through which trails lead


@guarded
class Replay:
    """Keeps map and curves at the moment of its ``cursor``; the simulation goes on meanwhile."""

    def __init__(self, panels, study, history, live):
        self.cursor = TimeCursor(history, panels)
        self._panels, self._study = panels, study
        self._history = self._own = history  # of the run shown, and that of the window
        self._live, self._law = live, PastLaw(panels, study, history, live)
        self._shown, self._before = None, time.monotonic()
        panels.curves.time_chosen.connect(guarded(self.cursor.go))
        panels.verdict.row_chosen.connect(self._on_check)

    def end(self):
        """Ask nothing more of the law."""
        self._law.forget()

    def show_run(self, history):
        """Show the run in ``history`` from now on, at any moment of it; None: the window's own."""
        self._history = history or self._own
        self._law.forget()
        self._shown, self._live.is_held = None, not self.is_own
        self.cursor.take_history(self._history)

    def show_newest(self):
        """Show the newest sample of the window's own run, with its trails, and go on from there."""
        row = len(self._own.time) - 1
        self._panels.map.show_past(self._state(row), self._trails(row))
        self._live.go_on(self._state(row))

    @property
    def is_own(self):
        """Return whether the run shown is that of the window."""
        return self._history is self._own

    @property
    def is_shown(self):
        """Return whether the map shows a moment of the ``cursor``."""
        return self._shown is not None

    def _on_check(self, check):
        """Go to the moment, and choose the robot, on which a check of the verdict hung."""
        moment, robot = self._decided(check)
        if robot in self._history.numbers:
            self._panels.map.robot_clicked.emit(robot)
        if moment is not None and self.cursor.span is not None:
            self.cursor.go(self._history.begin + moment)

    def _decided(self, check):
        """Return the time [s] since the run began and the robot on which ``check`` hung.

        None and 0 where that is not known: a value at the end has no moment of its own.
        """
        collisions = self._history.collisions
        if check["name"] == "collisions" and collisions:
            begun = self._history.begin
            return collisions[0].time - begun, int(re.sub(r"\D", "", collisions[0].first) or 0)
        named = re.search(r"\brobot(\d+)", check.get("member") or check["note"] or "")
        moment = check.get("time")
        if moment is None and check["name"].startswith("settling time"):
            moment = check["measured"]
        return moment, int(named.group(1)) if named else 0

    def show_frame(self):
        """Let a replay go on, and show its moment."""
        now = time.monotonic()
        passed, self._before = now - self._before, now
        self.cursor.pass_time(passed)
        if self.is_own:
            self._show_own()
        else:
            self._show(self.cursor.row)
        self._panels.curves.show_moment(self.cursor.time)
        if not self.cursor.is_past:
            self._panels.time_line.show_moment()

    def _show_own(self):
        """Show a moment of the window's own run, or let it go on."""
        if self._shown is not None and not self._panels.map.is_past:  # it shows an edit
            self._shown, self._live.is_held = None, False
            self._law.forget()
            self.cursor.follow()
        if self.cursor.is_past:
            if self._shown is None and not self._targets_stand():
                self._panels.map.show_targets(None)
            self._show(self.cursor.row)
            self._law.ask(self.cursor.row)
        elif self._shown is not None:
            self._shown = None
            self.show_newest()
            self._law.ask(len(self._own.time) - 1)
        self._law.follow()

    def _show(self, row):
        key = float(self._history.time[row]), self._history.cleared
        if key != self._shown:
            self._shown, self._live.is_held = key, True
            self._panels.map.show_past(self._state(row), self._trails(row))

    def _targets_stand(self):
        """Return whether the targets shown were those of the start: else they are not known of then."""
        shown, first = self._panels.map.targets, self._study.edited.derived.targets
        return shown is None or (
            first is not None and len(first) == len(shown) and np.allclose(first[:, :2], shown)
        )

    def _state(self, row):
        state = self._history.state.at(row)
        return state.replace(fresh=np.ones(len(state.robots), dtype=bool))

    def _trails(self, row):
        """Return the trails up to the sample ``row``, from where robots first moved."""
        first = min(self._history.first_row(), row)
        rows = np.unique(np.linspace(first, row, min(MOST_PASSED, row - first + 1)).astype(int))
        state, trails = self._history.state.at(rows), Trails(len(self._history.numbers))
        for places, heights in zip(state.pose[:, :, :2], state.heights):
            trails.add(places, heights)
        return trails
