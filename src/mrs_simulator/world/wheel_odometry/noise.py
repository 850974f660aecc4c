"""Random streams of sensors: each robot's own, or one of a whole team."""

import numpy as np

BLOCK = 256  # [-] draws made at a time of each robot's stream


class TeamStream:
    """One stream for all robots: what a robot draws depends on how many there are."""

    def __init__(self, seed, n, count):
        """Each draw is of ``count`` numbers for each of ``n`` robots."""
        self._shape, self._draw = (n, count), np.random.default_rng(seed)

    def draw(self):
        """Return standard normal numbers, (n, count)."""
        return self._draw.standard_normal(self._shape)


class RobotStreams:
    """A stream for each robot and sensor, independent of the rest of the team."""

    def __init__(self, seed, rows, sensor, count):
        """``rows``: of the robots in the team; ``sensor``: a number for each kind of sensor.

        Each draw is of ``count`` numbers for each robot.
        """
        self._count, self._next = count, BLOCK
        self._draws = [np.random.default_rng((seed, int(row) + 1, sensor)) for row in rows]

    def draw(self):
        """Return standard normal numbers, (m, count)."""
        if self._next == BLOCK:
            shape = BLOCK, self._count
            self._block = np.stack([each.standard_normal(shape) for each in self._draws], axis=1)
            self._next = 0
        self._next += 1
        return self._block[self._next - 1]
