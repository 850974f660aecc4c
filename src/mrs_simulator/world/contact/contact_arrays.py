"""Contacts of one step: those of robots with each other as arrays, which one by one cost too much."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mrs_simulator.record.recording import Collision
from mrs_simulator.scenario.scenario import MOST_ROBOTS


class Contact(NamedTuple):
    """Two bodies that overlap: names, where [m], how deep [m]."""

    first: str
    second: str
    x: float
    y: float
    depth: float
    z: float = 0.0


class Touches(Sequence):
    """``Contact``s of pairs of robots, rows ``first`` < ``second`` (m,), and of ``others`` after them.

    ``middle`` (m, 2) [m], ``depth`` (m,) [m] and ``z`` (m,) [m] are the pairs'.
    """

    def __init__(self, first=(), second=(), middle=(), depth=(), z=()):
        self.first, self.second = np.asarray(first, dtype=int), np.asarray(second, dtype=int)
        self.others = []
        self._pairs = middle, depth, z

    def pair(self, k):
        """Return the ``Contact`` of the k-th pair of robots."""
        names = (robot_name(rows[k]) for rows in (self.first, self.second))
        middle, depth, z = self._pairs
        return Contact(*names, *middle[k].tolist(), float(depth[k]), float(z[k]))

    def starts(self, pairs, time):
        """Return the ``Collision``s of the ``pairs`` (k,) of robots that begin to touch at ``time`` [s]."""
        columns = self.first[pairs], self.second[pairs], self._pairs[0][pairs]
        return [
            Collision(time, robot_name(first), robot_name(second), x, y)
            for first, second, (x, y) in zip(*(each.tolist() for each in columns))
        ]

    def __len__(self):
        return len(self.first) + len(self.others)

    def __getitem__(self, k):
        k = range(len(self))[k]
        return self.pair(k) if k < len(self.first) else self.others[k - len(self.first)]


@functools.lru_cache(maxsize=MOST_ROBOTS)
def robot_name(row):
    """Return the name of the robot in ``row``."""
    return "robot{}".format(row + 1)
