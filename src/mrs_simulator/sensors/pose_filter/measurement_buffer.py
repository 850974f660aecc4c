"""What a filter was told of late, in order of time: what comes late is taken in where it belongs."""

import bisect
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import part_of, relative


class Move(NamedTuple):
    """Robots ``rows`` (m,) moved by ``moved`` (m, 3) in their frames, from ``start`` to ``end`` [ns]."""

    start: int
    end: int
    rows: np.ndarray
    moved: np.ndarray

    @property
    def time(self):
        """Return when it is known, [ns]."""
        return self.end

    def split(self, time):
        """Return the moves up to ``time`` [ns] and from there on, at the same twist."""
        part = part_of(self.moved, (time - self.start) / (self.end - self.start))
        rest = relative(part, self.moved)
        return self._replace(end=time, moved=part), self._replace(start=time, moved=rest)


class Put(NamedTuple):
    """Robots ``rows`` (m,) were put to ``pose`` (m, 3) at ``time`` [ns]."""

    time: int
    rows: np.ndarray
    pose: np.ndarray


class Look(NamedTuple):
    """The sensor ``name`` of robots ``rows`` (m,) measured ``values`` (m, k) at ``time`` [ns]."""

    time: int
    name: str
    rows: np.ndarray
    values: np.ndarray


class Story:
    """The events of a filter, and its states between them."""

    def __init__(self, filtered, reach):
        """``filtered``: a ``Filter``; ``reach`` [ns]: how late an event may come."""
        self._filter, self.reach = filtered, reach
        self._keys, self._events, self._before = [], [], []  # sorted; the states before each event
        self._dirty, self._count, self._oldest = 0, 0, None

    def begin(self, time):
        """Nothing is told of before ``time`` [ns]."""
        self._oldest = time

    def add(self, event, order):
        """Take in an ``event``; of equal times the lower ``order`` comes first.

        Return False, and leave it out, where it comes too late.
        """
        if event.time < self._oldest:
            return False
        if isinstance(event, Look):
            self._split_at(event)
        self._insert(event, order)
        return True

    def again_from(self, time):
        """Reckon anew whatever ends later than ``time`` [ns]: it is known better now."""
        self._dirty = min(self._dirty, bisect.bisect_right(self._keys, (time, np.inf)))

    def tell(self, apply, until):
        """Let the filter take in what is new, and what follows that, by ``apply(event)``; forget the old.

        ``until`` [ns]: up to when all is known but what may come late.
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

    def _split_at(self, look):
        """Split the moves of the robots of ``look`` in which it falls."""
        first = bisect.bisect_right(self._keys, (look.time, np.inf))
        cut = [
            at
            for at, event in enumerate(self._events[first:], first)
            if isinstance(event, Move)
            and event.start < look.time
            and np.isin(event.rows, look.rows).any()
        ]
        for k, at in enumerate(cut):  # each first part comes before all that are still to be cut
            before, self._events[at + k] = self._events[at + k].split(look.time)
            self._insert(before, -1)
