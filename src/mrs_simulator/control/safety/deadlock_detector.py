"""Deadlocks: robots that the safety filter holds still, while no robot near them moves."""

import numpy as np

from mrs_simulator.core.neighbours import lengths

MOVES = 0.02  # [m/s] from which on a robot is wanted to move
HELD = 0.2  # [-] of the wanted speed below which it is held
PATIENCE = 3.0  # [s] for which it is held before that counts as a deadlock
NEARBY = 2.0  # [-] of the safe distance within which another may make room


class DeadlockDetector:
    """Records since when the safety filter has held robots still."""

    def __init__(self, n):
        """``n``: the number of robots."""
        self.since = np.full(n, np.nan)  # [s] when each was held, nan where it is not

    def note(self, time, wanted, velocity, points, distance):
        """Record who is held at ``time`` [s], by what :func:`held_still` takes."""
        held = held_still(wanted, velocity, points, distance)
        self.since[self.since > time] = np.nan  # time went back: another run
        self.since[:] = np.where(held, np.fmin(self.since, time), np.nan)

    def rows(self, time):
        """Return ``(row, since [s])`` of the robots held for ``PATIENCE`` at ``time`` [s], a list."""
        rows = np.flatnonzero(time - self.since >= PATIENCE)
        return [(int(row), float(self.since[row])) for row in rows]


def held_still(wanted, velocity, points, distance):
    """Return which robots are held, (n,) bool, by ``wanted`` and passed ``velocity``, (n, 2) [m/s] each.

    A robot is held where ``MOVES`` or more is wanted, less than ``HELD`` of that is passed, and no robot
    within ``NEARBY`` safe distances moves.
    """
    asked, done = lengths(wanted), lengths(velocity)
    held = (asked >= MOVES) & (done < HELD * asked)
    if held.any():
        goes = done >= np.maximum(MOVES, HELD * asked)
        apart = np.linalg.norm(points[held][:, np.newaxis] - points, axis=2)
        near = apart < NEARBY * (distance if np.ndim(distance) == 0 else distance[held])
        held[held] = ~(near & goes).any(axis=1)
    return held
