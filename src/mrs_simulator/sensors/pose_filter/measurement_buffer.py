"""Recent events of a filter in order of time: those that come late are inserted where they belong."""

import bisect
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import fraction_of_motion, relative


class Move(NamedTuple):
    """Robots ``rows`` (m,) moved by ``moved`` (m, 3) in their frames, from ``start`` to ``end`` [ns]."""

    start: int
    end: int
    rows: np.ndarray
    moved: np.ndarray

    @property
    def time(self):
        """Return the end, [ns]."""
        return self.end

    def split(self, time):
        """Return the moves until ``time`` [ns] and after it, at the same twist."""
        part = fraction_of_motion(self.moved, (time - self.start) / (self.end - self.start))
        rest = relative(part, self.moved)
        return self._replace(end=time, moved=part), self._replace(start=time, moved=rest)


class Relocation(NamedTuple):
    """Robots ``rows`` (m,) were put to ``pose`` (m, 3) at ``time`` [ns]."""

    time: int
    rows: np.ndarray
    pose: np.ndarray


class Observation(NamedTuple):
    """The sensor ``name`` of robots ``rows`` (m,) measured ``values`` (m, k) at ``time`` [ns]."""

    time: int
    name: str
    rows: np.ndarray
    values: np.ndarray


class MeasurementBuffer:
    """The events of a filter, and its states between them."""

    def __init__(self, filtered, reach):
        """``filtered``: a ``Filter``; ``reach`` [ns]: how late an event may come."""
        self._filter, self.reach = filtered, reach
        self._keys, self._events, self._before = [], [], []  # sorted; the states before each event
        self._dirty, self._count, self._oldest = 0, 0, None

    def begin(self, time):
        """Begin at ``time`` [ns]: events before it are too late."""
        self._oldest = time

    def add(self, event, order):
        """Insert an ``event``, of equal times by ``order``; return False where it is too late for that."""
        if event.time < self._oldest:
            return False
        if isinstance(event, Observation):
            self._split_at(event)
        self._insert(event, order)
        return True

    def replay_from(self, time):
        """Apply all events after ``time`` [ns] again at the next :meth:`replay`."""
        self._dirty = min(self._dirty, bisect.bisect_right(self._keys, (time, np.inf)))

    def replay(self, apply, until):
        """Go back to the first new event and ``apply(event)`` to it and all that follow; drop old events.

        ``until`` [ns]: the time by which all events have come, except late ones.
        """
        if self._dirty < len(self._events):
            if self._dirty < len(self._before):
                self._filter.state = self._before[self._dirty]
            del self._before[self._dirty :]
            for event in self._events[self._dirty :]:
                self._before.append(self._filter.state)
                apply(event)
            self._dirty = len(self._events)
        self._forget(until - self.reach)

    def _forget(self, before):
        old = bisect.bisect_left(self._keys, (before,))
        if old:
            self._oldest = self._keys[old - 1][0]
            for kept in (self._keys, self._events, self._before):
                del kept[:old]
            self._dirty -= old

    def _insert(self, event, order):
        self._count += 1
        key = (event.time, order, self._count)
        at = bisect.bisect(self._keys, key)
        self._keys.insert(at, key)
        self._events.insert(at, event)
        self._dirty = min(self._dirty, at)

    def _split_at(self, seen):
        """Split the moves of the robots of an ``Observation`` at its time."""
        first = bisect.bisect_right(self._keys, (seen.time, np.inf))
        cut = [
            at
            for at, event in enumerate(self._events[first:], first)
            if isinstance(event, Move)
            and event.start < seen.time
            and np.isin(event.rows, seen.rows).any()
        ]
        for k, at in enumerate(cut):  # each first part comes before all that are still to be cut
            before, self._events[at + k] = self._events[at + k].split(seen.time)
            self._insert(before, -1)
