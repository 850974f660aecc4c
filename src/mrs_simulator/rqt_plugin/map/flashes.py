"""Collisions that the map shows for a moment."""

import collections
import time

import numpy as np

from mrs_simulator.rqt_plugin.map.marks import FLASH
from mrs_simulator.rqt_plugin.qt.QtCore import QTimer
from mrs_simulator.rqt_plugin.widgets.guard import guarded

FLASH_PERIOD = 40  # [ms]
MOST_FLASHES = 50


class Flashes:
    """Places that flash for ``FLASH`` [s]; ``changed`` is called while they fade."""

    def __init__(self, parent, changed):
        self._held = collections.deque(maxlen=MOST_FLASHES)
        self._changed = changed
        self._timer = QTimer(parent, interval=FLASH_PERIOD, timeout=self.fade)

    def add(self, x, y):
        """Let (x, y) [m] flash from now on."""
        self._held.append((time.monotonic(), np.array([x, y], dtype=float)))
        self._timer.start()
        self._changed()

    def clear(self):
        """Let nothing flash any more."""
        self._held.clear()

    def ages(self):
        """Return what flashes: for how long [s], and where (2,) [m]."""
        now = time.monotonic()
        return [(now - begun, place) for begun, place in self._held]

    @property
    def is_active(self):
        """Return whether something is fading."""
        return self._timer.isActive()

    @guarded
    def fade(self, *_):
        """Forget what has flashed for long enough."""
        while self._held and time.monotonic() - self._held[0][0] >= FLASH:
            self._held.popleft()
        if not self._held:
            self._timer.stop()
        self._changed()
