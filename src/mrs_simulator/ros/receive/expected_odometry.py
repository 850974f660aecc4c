"""Predicts whose odometry is due, from the stamps of what has come."""

import numpy as np

NEVER = -1  # [ns] the stamp before the first message
PUNCTUAL = 0.9  # [-] of a robot's period after which its next odometry may come
SAME = 1e-6  # [s] by which stamps of the same time may differ


class ExpectedOdometry:
    """When each robot's next odometry is expected: as long after the newest as that came after its own.

    The shorter of its last two periods counts, since a message may be lost.
    """

    def __init__(self, stamps, timeout):
        """``stamps`` (n,) [ns]: of the newest messages, ``NEVER`` before any, as their owner keeps them.

        ``timeout`` [s] by which a stamp may be ahead of the clock.
        """
        self._stamps, self._timeout = stamps, timeout
        self._periods = np.zeros((2, len(stamps)), dtype=np.int64)  # [ns] the last two

    def begin(self, periods):
        """Take in the robots' ``periods`` (n,) [ns], where they are known before any message."""
        self._periods[:] = periods

    def note(self, row, stamp):
        """Odometry of robot ``row`` comes with ``stamp`` [ns]; its owner keeps that afterwards."""
        before = self._stamps[row]
        if NEVER != before < stamp:
            period = stamp - before
            self._periods[:, row] = self._periods[1, row] or period, period

    def note_all(self, rows, stamp):
        """The same of robots ``rows`` (m,), all at once."""
        before = self._stamps[rows]
        later = (before != NEVER) & (before < stamp)
        rows, period = rows[later], stamp - before[later]
        last = self._periods[1, rows]
        self._periods[:, rows] = np.where(last == 0, period, last), period

    def missing(self, rows, now):
        """Return the ``rows`` whose next odometry was due by ``now`` [s] and has not arrived, (m,)."""
        rows = np.asarray(rows, dtype=int)
        stamps = self._stamps[rows]
        age = now - 1e-9 * stamps
        recent = age < np.maximum(PUNCTUAL * 1e-9 * self._periods[:, rows].min(axis=0), SAME)
        # After a restart of the simulator the last stamp lies far ahead of its clock.
        return rows[~((stamps != NEVER) & (-self._timeout < age) & recent)]
