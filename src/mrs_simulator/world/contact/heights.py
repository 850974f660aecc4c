"""Contacts in the third dimension: which heights bodies take, and how they part upwards and downwards."""

import numpy as np


class Heights:
    """How high the robots of a team are, from the undersides on which their positions stand."""

    def __init__(self, team):
        self._tall = np.array([kind.body.height for kind in team.kinds])
        self._flies = team.airborne

    def shared(self, z, first, second):
        """Return how much of their heights pairs of robots at ``z`` (n,) share, (m,) [m]; below 0 apart."""
        top, other = z[first] + self._tall[first], z[second] + self._tall[second]
        return np.minimum(top, other) - np.maximum(z[first], z[second])

    def middle(self, z, first, second):
        """Return the middle (m,) [m] of the heights that pairs of robots share."""
        top, other = z[first] + self._tall[first], z[second] + self._tall[second]
        return 0.5 * (np.minimum(top, other) + np.maximum(z[first], z[second]))

    def part(self, z, first, second, depth, firm):
        """Part pairs upwards and downwards where that is shorter than ``depth`` (m,) across; in place.

        One that flies gives way, two of them half each, but neither below the ground; ``firm`` (n,)
        bool: robots that never do.  Return which pairs are to be parted across, (m,) bool.
        """
        above = z[first] + 0.5 * self._tall[first] >= z[second] + 0.5 * self._tall[second]
        upper, lower = np.where(above, first, second), np.where(above, second, first)
        inside = z[lower] + self._tall[lower] - z[upper]
        gives = self._flies & ~firm
        chosen = (inside < depth) & gives[upper]
        down = np.where(gives[lower], np.minimum(0.5 * inside, z[lower]), 0.0)[chosen]
        np.subtract.at(z, lower[chosen], down)
        np.add.at(z, upper[chosen], inside[chosen] - down)
        return ~chosen

    def part_from_obstacle(self, z, rows, depth, obstacle, free):
        """Lift robots ``rows`` onto ``obstacle`` where that is shorter than ``depth`` (m,) across.

        ``z`` (n,) changes in place; ``free`` (m,) bool: those that give way.  Return which are to be
        pushed across, (m,) bool.
        """
        onto = self._flies[rows] & free & (obstacle.height - z[rows] < depth)
        z[rows[onto]] = obstacle.height
        return ~onto
