"""Broad phase of the contacts: robots that may touch something soon, by circles around their bodies."""

import numpy as np

from mrs_simulator.core.neighbours import squared
from mrs_simulator.scenario.surroundings.obstacles import clearance
from mrs_simulator.world.contact.collisions import VerletList

MARGIN = 0.02  # [m] between two outlines, below which they may touch
APART = 0.07  # [m] beyond that, from which on two that were near no longer are


class BroadPhase:
    """Robots with a ``reach`` (n,) [m] each, among obstacles."""

    def __init__(self, reach, obstacles):
        self._reach = np.array(reach, dtype=float)
        self.stand(obstacles)
        self._widen(1.0)
        self.moved_elsewhere()

    def stand(self, obstacles):
        """Let ``obstacles`` be all there are, where they are."""
        self._obstacles, self._room = list(obstacles), 0.0

    def _widen(self, gap):
        """Let pairs be listed that are up to ``gap`` [m] apart."""
        self._gap, self._list = gap, VerletList(2.0 * float(self._reach.max()) + gap)

    def list_anew(self):
        """Let pairs be listed anew when they are asked for again."""
        self._list.clear()

    def moved_elsewhere(self):
        """To be called when robots were put to new places."""
        self.list_anew()
        # [m] that each may move before any two are near, and may have moved
        self._room = self._way = 0.0

    @property
    def room(self):
        """Return how far [m] each may move before any two are near, and may have moved by the last step
        from where that was so."""
        return self._room, self._way

    @room.setter
    def room(self, room):
        self._room, self._way = room

    def near(self, place, way, before):
        """Return the robots at ``place`` (n, 2) that are near something, (n,) bool; None for no robot.

        ``way`` [m]: how far each moves in the coming step at most; ``before`` (n,) bool: which of them were
        near, and are so until they are ``APART``.
        """
        self._room -= self._way
        self._way = way
        if self._room > way:
            return None
        if MARGIN + APART + 2.0 * way > self._gap:
            self._widen(2.0 * (MARGIN + APART + 2.0 * way))
        near = np.zeros(len(place), dtype=bool)
        first, second = self._list.pairs(place)
        gaps = np.sqrt(squared(place[second] - place[first]))
        gaps -= self._reach[first] + self._reach[second]
        limit = MARGIN + 2.0 * way + APART * (before[first] & before[second])
        close = gaps < limit
        near[first[close]] = near[second[close]] = True
        room = 0.5 * (float(gaps.min(initial=np.inf)) - MARGIN)
        for obstacle in self._obstacles:
            gap = clearance(obstacle, place)[0] - self._reach
            near |= gap < MARGIN + way + APART * before
            room = min(room, float(gap.min()) - MARGIN)
        if near.any():
            self._room = 0.0
            return near
        self._room = min(room, self._list.room(place))
        return None
