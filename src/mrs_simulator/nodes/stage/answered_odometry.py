"""Which odometry the robots' commands answer."""

import math
import threading
from collections import deque

import numpy as np

KEPT = 256  # [-] announced commands of each robot that have not come
UNKNOWN = math.nan


class Answers:
    """Commands as they came, with the stamps of the odometry that they answer.

    Those for all robots in one message bear the stamps.  A Twist on a robot's own topic bears none: its
    controller announces each beside it, and the first of those announced with its six numbers, after the
    one before it, is that Twist.  Where another of them has the same numbers it cannot be said which one
    came, and the stamp is not known.
    """

    def __init__(self, n=0):
        """``n``: the number of robots."""
        self._lock = threading.Lock()
        self.begin(n)

    def begin(self, n):
        """Forget everything: there is a team of ``n`` robots."""
        with self._lock:
            # (numbers, stamp) of each row, in the order in which they were sent.
            self._expected = [deque(maxlen=KEPT) for _ in range(n)]
            self._came, self._late = [], []  # (row, numbers, time)
            self._batches = []  # (rows, times, stamps)

    def expect(self, rows, commands, stamps):
        """Take in what commands (m, 6) robots ``rows`` were sent, answering ``stamps`` (m,) [s]."""
        with self._lock:
            n = len(self._expected)
            for row, command, stamp in zip(rows, commands, stamps):
                if 0 <= row < n:
                    self._expected[row].append((tuple(command), stamp))

    def note(self, row, numbers, when):
        """A Twist of these six ``numbers`` came for robot ``row`` at ``when`` [s] of wall time."""
        with self._lock:
            self._came.append((row, numbers, when))

    def note_all(self, rows, when, stamps):
        """Commands for robots ``rows`` came at ``when`` [s], answering ``stamps`` (m,) [s]."""
        with self._lock:
            self._batches.append((np.asarray(rows), np.full(len(rows), when), stamps))

    def take(self):
        """Return rows, times [s] and stamps [s], (m,) each, of what came.

        A stamp is NaN where it is not known.  A Twist may outrun its announcement: it waits for the
        next call.
        """
        with self._lock:
            late, self._late = self._late, []
            came, self._came = self._came, []
            batches, self._batches = self._batches, []
            n = len(self._expected)
            found = [(row, when, self._matched(row, said)) for row, said, when in late]
            for row, said, when in came:
                stamp = self._matched(row, said) if row < n else None
                if stamp is None and row < n:
                    self._late.append((row, said, when))
                else:
                    found.append((row, when, stamp))
        columns = [np.array(column, dtype=float) for column in zip(*found)] or [np.empty(0)] * 3
        rows, times, stamps = (np.concatenate(each) for each in zip(columns, *batches))
        # A late message may still come for a robot that has been taken away.
        kept = (rows >= 0) & (rows < n)
        return rows[kept].astype(int), times[kept], stamps[kept]

    def _matched(self, row, numbers):
        """Return the stamp of the command of robot ``row``, NaN if several may be it, None if none."""
        expected = self._expected[row]
        for place, (said, stamp) in enumerate(expected):
            if said == numbers:
                for _ in range(place + 1):
                    expected.popleft()
                return UNKNOWN if any(numbers == more for more, _ in expected) else stamp
        return None
