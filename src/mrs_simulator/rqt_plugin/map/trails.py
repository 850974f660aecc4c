"""Where robots have been, as far as the map draws it."""

import math

import numpy as np

TRAIL_SPACING = 0.03  # [m] that a robot moves before its trail gets another point
TRAIL_POINTS = 3000  # [-] of one robot
ALL_TRAIL_POINTS = 4000000  # [-] of all robots
TRAIL_PIXELS = 2.5  # [px] between the points of a trail that are drawn


class Trails:
    """Where the robots have been, of bounded size: when full, every other point is let go."""

    def __init__(self, n):
        self._most = max(10, min(TRAIL_POINTS, ALL_TRAIL_POINTS // max(1, n)))
        self._points = np.zeros((n, min(64, self._most), 3))
        self._spacing = np.full(n, TRAIL_SPACING)
        self._low, self._high = np.full((n, 2), np.inf), np.full((n, 2), -np.inf)
        self.count = np.zeros(n, dtype=int)

    def add(self, position, z):
        """Add the ``position`` (n, 2) [m] of those robots that have moved far enough; ``z`` (n,) [m]."""
        place = np.column_stack([position, z])
        with np.errstate(invalid="ignore"):
            far = np.sqrt(np.square(place - self._newest()).sum(axis=1)) >= self._spacing
        rows = np.flatnonzero((far | (self.count == 0)) & np.isfinite(place).all(axis=1))
        if not len(rows):
            return
        if self.count[rows].max() == self._points.shape[1]:
            self._make_room()
        self._points[rows, self.count[rows]] = place[rows]
        self.count[rows] += 1
        self._low[rows] = np.minimum(self._low[rows], position[rows])
        self._high[rows] = np.maximum(self._high[rows], position[rows])

    def _make_room(self):
        held = self._points.shape[1]
        if held < self._most:
            more = min(held, self._most - held)
            self._points = np.concatenate([self._points, np.zeros_like(self._points[:, :more])], 1)
            return
        for row in np.flatnonzero(self.count == held):
            kept = self._points[row, ::2].copy()
            self._points[row, : len(kept)] = kept
            self.count[row] = len(kept)
            self._spacing[row] *= 2.0

    @property
    def begun(self):
        """Return the number of robots that have a trail."""
        return int(np.count_nonzero(self.count))

    def first(self):
        """Return where the trails (n, 2) begin; without meaning for robots that have none."""
        return self._points[:, 0, :2].copy()

    def last(self):
        """Return the newest points (n, 2) of the trails; without meaning for robots without one."""
        return self._newest()[:, :2]

    def _newest(self):
        return self._points[np.arange(len(self.count)), np.maximum(self.count - 1, 0)]

    def path(self, row, stride=1):
        """Return every ``stride``-th point (m, 2) of one robot's trail."""
        return self._points[row, : self.count[row] : stride, :2]

    def path_in_space(self, row):
        """Return the points (m, 3) [m] of one robot's trail."""
        return self._points[row, : self.count[row]]

    def stride(self, row, scale):
        """Return the stride that leaves what can be seen at ``scale`` [px/m]."""
        apart = self._spacing[row] * scale
        return 1 if apart >= TRAIL_PIXELS else int(2 ** math.ceil(math.log2(TRAIL_PIXELS / apart)))

    def bounds(self):
        """Return the least and greatest coordinates (2 m, 2) of the m robots that have a trail."""
        held = self.count > 0
        return np.concatenate([self._low[held], self._high[held]])

    def in_view(self, frame):
        """Return the rows of the robots whose trails may be seen."""
        low, high = frame.bounds()
        margin = self._spacing[:, np.newaxis]  # to where the robot is now
        seen = (self._low <= high + margin) & (self._high >= low - margin)
        return np.flatnonzero(seen.all(axis=1) & (self.count > 0))


def trails_of(team, trails, hidden):
    """Return the robots' ``trails`` up to where they are now, (m, 3) [m] each; none of those ``hidden``."""
    now = np.column_stack([team.pose[:, :2], team.state.heights])
    paths = map(trails.path_in_space, range(len(now)))
    return tuple(
        np.concatenate([path, now[row : row + 1]])
        if len(path) and team.numbers[row] not in hidden
        else np.empty((0, 3))
        for row, path in enumerate(paths)
    )
