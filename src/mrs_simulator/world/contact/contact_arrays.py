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
        """Return the ``PairsBegun`` of the ``pairs`` (k,) of robots that begin to touch at ``time`` [s]."""
        rows = self.first[pairs], self.second[pairs]
        return PairsBegun(np.full(len(pairs), time), *rows, *self._pairs[0][pairs].T)

    def __len__(self):
        return len(self.first) + len(self.others)

    def __getitem__(self, k):
        k = range(len(self))[k]
        return self.pair(k) if k < len(self.first) else self.others[k - len(self.first)]


class PairsBegun(NamedTuple):
    """The starts of contacts of k pairs of robots, as arrays: a crowd has 100,000 before anybody looks."""

    time: np.ndarray  # (k,) [s]
    first: np.ndarray  # (k,) rows
    second: np.ndarray
    x: np.ndarray  # (k,) [m] in the common frame
    y: np.ndarray

    def collisions(self):
        """Return the ``Collision``s."""
        names = (map(robot_name, rows.tolist()) for rows in (self.first, self.second))
        values = self.time.tolist(), *names, self.x.tolist(), self.y.tolist(), itertools.repeat(0.0)
        # Of a named tuple's own constructor it would take twice as long.
        return list(map(tuple.__new__, itertools.repeat(Collision), zip(*values)))


def collisions_of(begun):
    """Return the ``Collision``s of ``begun``, of such and of ``PairsBegun``, in its order."""
    found = []
    for each in begun:
        found += each.collisions() if isinstance(each, PairsBegun) else [each]
    return found


@functools.lru_cache(maxsize=MOST_ROBOTS)
def robot_name(row):
    """Return the name of the robot in ``row``."""
    return "robot{}".format(row + 1)
