"""Robots selected on the map: keys and menu that move and arrange them together."""

import numpy as np

from mrs_simulator.rqt_plugin.map.arranging import ARRANGEMENTS
from mrs_simulator.rqt_plugin.map.obstacle_keys import ARROWS, FINE_STEP, STEP, KeyActions
from mrs_simulator.rqt_plugin.qt.QtCore import QRectF, Qt
from mrs_simulator.rqt_plugin.qt.QtWidgets import QMenu
from mrs_simulator.rqt_plugin.widgets.guard import guarded


class RobotSelection(KeyActions):
    """The robots of a ``MapView`` that are edited together while its mode is ``poses``."""

    def __init__(self, view):
        self._view, self.numbers, self.menu = view, frozenset(), None

    def rows(self):
        """Return the rows of the robots selected, in order."""
        team = self._view.team.numbers
        return [row for row, number in enumerate(team) if number in self.numbers]

    def rows_with(self, row):
        """Return the rows that a drag of the robot in ``row`` moves: it alone, or all selected."""
        rows = self.rows()
        return rows if row in rows else [row]

    def take(self, numbers):
        """Select the robots ``numbers``."""
        self.numbers = frozenset(numbers)
        self._view.update()

    def toggle(self, number):
        """Select the robot ``number``, or no longer."""
        self.take(self.numbers.symmetric_difference([number]))

    def take_band(self, begin, end):
        """Select the robots whose centres lie between two corners (2,) [px]."""
        team, box = self._view.team, QRectF(*begin, *(end - begin)).normalized()
        places = self._view.frame.to_screen(np.where(np.isfinite(team.pose), team.pose, 0.0))
        inside = [box.contains(x, y) for x, y in places.tolist()]
        self.take(n for n, known, there in zip(team.numbers, team.known, inside) if known and there)

    def _action(self, event):
        key, held = event.key(), event.modifiers() & ~Qt.KeypadModifier
        if (key, held) == (Qt.Key_A, Qt.ControlModifier):
            return lambda: self.take(self._view.team.numbers)
        if not self.numbers or held & ~Qt.ShiftModifier:
            return None
        if key == Qt.Key_Escape:
            return lambda: self.take(())
        if key in ARROWS:
            step = FINE_STEP if held else STEP
            way = np.array([*ARROWS[key], 0.0]) * step
            return lambda: self._arrange(lambda poses: poses + way)
        return None

    def _arrange(self, arrangement):
        rows = self.rows()
        self._view.edit_poses(rows, arrangement(self._view.team.pose[rows]))

    def open_menu(self, number, place):
        """Open the menu of the robots selected, or of robot ``number`` alone, at ``place`` (global)."""
        if number and number not in self.numbers:
            self.take([number])
        self.menu = menu = QMenu(self._view)
        menu.setAttribute(Qt.WA_DeleteOnClose)
        for text, least, arrangement in ARRANGEMENTS:
            entry = menu.addAction(text)
            entry.setEnabled(len(self.numbers) >= least)
            entry.triggered.connect(guarded(lambda *_, do=arrangement: self._arrange(do)))
        menu.addSeparator()
        everybody = menu.addAction("Select all\tCtrl+A")
        everybody.triggered.connect(guarded(lambda *_: self.take(self._view.team.numbers)))
        menu.popup(place)
