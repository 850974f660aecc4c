"""The robots on the map: state, shapes and overlaps.  No painting."""

import math

import numpy as np

from mrs_simulator.core.spatial import upright
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.state.columns import FRESH, REAL, Z
from mrs_simulator.state.state_table import StateTable
from mrs_simulator.vehicles import kind
from mrs_simulator.world.contact.bodies import Bodies


class MapTeam:
    """The robots shown: their ``state``, a ``StateTable`` whose poses may be unknown (nan), and shapes."""

    def __init__(self):
        self._kinds, self.load = (), None  # the ``Load`` that they carry together, if any
        self.numbers = None
        self.show(resting((), np.empty((0, 3))))

    def take_kinds(self, kinds):
        """Draw robots 1..n as these ``Kind``s; a team of another size as the first of them."""
        self._kinds = tuple(kinds)
        self._take_shapes()

    def _take_shapes(self):
        known = len(self._kinds) == len(self.numbers)
        usual = self._kinds[:1] or (kind(DEFAULT_KIND),)
        self.shapes = Shapes.of_kinds(self._kinds if known else usual * len(self.numbers))
        self._overlapping = None

    def show(self, state):
        """Put the robots where the ``state`` has them."""
        self.state, self.pose, self.fresh = state, state.pose, state.fresh
        self.real = state.numbers_with(REAL)
        self.known = np.isfinite(self.pose).all(axis=1)
        self._overlapping = None
        if state.robots != self.numbers:
            self.numbers = state.robots
            self._take_shapes()

    def pose_in_degrees(self, row):
        """Return x [m], y [m] and heading [deg] of the robot in ``row``."""
        x, y, theta = self.pose[row].tolist()
        return x, y, math.degrees(math.remainder(theta, 2.0 * math.pi))

    def edit(self, rows, poses_there):
        """Put one robot, or several, upright at ``poses_there`` (3,) or (k, 3), arms of all at home."""
        poses = self.pose.copy()
        poses[rows] = poses_there
        altitude = self.state.z if self.state.has(Z) else None
        flags = {each.name: self.state[each] for each in (FRESH, REAL) if self.state.has(each)}
        self.show(resting(self.numbers, poses, altitude).replace(**flags))

    def kinds(self):
        """Return the robots' kinds, as they are drawn."""
        return tuple(self.shapes.distinct[which] for which in self.shapes.which.tolist())

    def in_space(self, targets, z):
        """Return ``targets`` (n, 2) at heights ``z`` (n,), None: the robots' own, as (n, 3) [m].

        None where there are none, or of another number of robots.
        """
        if targets is None or len(targets) != len(self.numbers):
            return None
        return np.column_stack([targets, self.state.heights if z is None else z])

    @property
    def overlapping(self):
        """Return the set of the numbers of robots that overlap another."""
        if self._overlapping is None:
            rows = np.flatnonzero(self.known)
            hit = []
            if len(rows) > 1:
                first, second = self._bodies(rows).overlaps(*self._places(rows))[:2]
                hit = rows[np.union1d(first, second).astype(int)]
            self._overlapping = {self.numbers[row] for row in hit}
        return self._overlapping

    def touches(self, obstacle):
        """Return whether ``obstacle`` overlaps a robot."""
        rows = np.flatnonzero(self.known)
        if not len(rows):
            return False
        found = self._bodies(rows, (obstacle,)).obstacle_overlaps(*self._places(rows))
        return next(found, None) is not None

    def _places(self, rows):
        return self.pose[rows], self.state.z[rows] if self.state.has(Z) else None

    def _bodies(self, rows, obstacles=()):
        which = self.shapes.which[rows].tolist()
        return Bodies([self.shapes.distinct[place] for place in which], obstacles)


def resting(numbers, poses, altitude=None):
    """Return the ``StateTable`` of robots ``numbers`` at rest at ``poses`` (n, 3), all with recent data.

    ``altitude`` (n,) [m]: their heights, None for robots on the ground.
    """
    spatial = None if altitude is None else upright(poses[:, 2], altitude)
    fresh = np.ones(len(poses), dtype=bool)
    return StateTable(None, numbers, pose=poses, fresh=fresh, spatial=spatial)
