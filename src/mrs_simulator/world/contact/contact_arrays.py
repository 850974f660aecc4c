"""Contacts of one step: those of robots with each other as arrays, which one by one cost too much."""

import functools
import itertools
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
        rows = self.first[pairs], self.second[pairs]
        return begun_at(np.full(len(pairs), time), *rows, *self._pairs[0][pairs].T)

    def __len__(self):
        return len(self.first) + len(self.others)

    def __getitem__(self, k):
        k = range(len(self))[k]
        return self.pair(k) if k < len(self.first) else self.others[k - len(self.first)]


def begun_at(times, first, second, x, y):
    """Return the ``Collision``s of pairs of robots in rows, (k,), that begin at ``times`` (k,) [s]."""
    names = (map(robot_name, rows.tolist()) for rows in (first, second))
    values = times.tolist(), *names, x.tolist(), y.tolist(), itertools.repeat(0.0)
    # Of a named tuple's own constructor it would take twice as long.
    return list(map(tuple.__new__, itertools.repeat(Collision), zip(*values)))


@functools.lru_cache(maxsize=MOST_ROBOTS)
def robot_name(row):
    """Return the name of the robot in ``row``."""
    return "robot{}".format(row + 1)
