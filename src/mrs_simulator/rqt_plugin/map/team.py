"""The robots on the map: numbers, poses and overlaps.  No painting."""

import numpy as np

from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.scenario.scenario import DEFAULT_KIND
from mrs_simulator.vehicles import kind
from mrs_simulator.world.contact.bodies import Bodies


class MapTeam:
    """Robots ``numbers``, one per row, with poses (n, 3) [m, m, rad] of which some may be unknown (nan)."""

    def __init__(self):
        self._kinds, self.load = (), None  # the ``Load`` that they carry together, if any
        self.begin((), np.empty((0, 3)))

    def begin(self, numbers, poses):
        """Show robots ``numbers`` on the ground at ``poses`` (n, 3)."""
        self.numbers = numbers
        self._take_shapes()
        self.place(poses, np.ones(len(poses), dtype=bool))

    def take_kinds(self, kinds):
        """Draw robots 1..n as these ``Kind``s; a team of another size as the first of them."""
        self._kinds = tuple(kinds)
        self._take_shapes()

    def _take_shapes(self):
        known = len(self._kinds) == len(self.numbers)
        usual = self._kinds[:1] or (kind(DEFAULT_KIND),)
        self.shapes = Shapes.of_kinds(self._kinds if known else usual * len(self.numbers))
        self._overlapping = None

    def place(self, poses, fresh, real=frozenset(), spatial=None):
        """Put the robots at ``poses`` (n, 3), arms at home.

        ``fresh`` (n,) bool: which have recent data; ``real``: the numbers of robots that are not simulated;
        ``spatial``: what poses leave out, of robots off the ground.
        """
        self.pose, self.fresh, self.real = poses, fresh, real
        self.joints = None  # [rad] of arms, None: at home
        self.carried = None  # a ``LoadState``, None where the load's pose is unknown
        fits = spatial is not None and len(spatial.z) == len(poses)
        self.spatial = spatial if fits else None
        self.z = spatial.z if fits else None  # [m], None: on the ground
        self.known = np.isfinite(poses).all(axis=1)
        self._overlapping = None

    def kinds(self):
        """Return the robots' kinds, as they are drawn."""
        return tuple(self.shapes.distinct[which] for which in self.shapes.which.tolist())

    def heights(self):
        """Return the heights (n,) [m], 0 of robots on the ground."""
        return np.zeros(len(self.numbers)) if self.z is None else self.z

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
        return self.pose[rows], None if self.z is None else self.z[rows]

    def _bodies(self, rows, obstacles=()):
        which = self.shapes.which[rows].tolist()
        return Bodies([self.shapes.distinct[place] for place in which], obstacles)
