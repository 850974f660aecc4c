"""Dimensions of a team's robots as the map draws them.  No painting."""

from typing import Any, NamedTuple, Tuple

import numpy as np

from mrs_simulator.vehicles.top_view import outline


class Shapes(NamedTuple):
    """The shapes of a team's robots: the distinct kinds, and measures [m] by row, (n,) each."""

    distinct: Tuple[Any, ...]  # ``Kind``s
    which: Any  # of them each robot is
    front: Any
    rear: Any
    half: Any  # of the width
    reach: Any
    length: Any
    round: Any  # bool

    @classmethod
    def of_kinds(cls, kinds):
        """Return the ``Shapes`` of robots of these ``Kind``s."""
        place = {kind: row for row, kind in enumerate(dict.fromkeys(kinds))}
        which = np.array([place[kind] for kind in kinds], dtype=int)
        table = np.array(
            [
                (b.front, b.rear, 0.5 * b.width, b.reach, b.length, b.round)
                for b in (kind.body for kind in place)
            ]
        ).reshape(-1, 6)
        *measures, is_round = table[which].T
        return cls(tuple(place), which, *measures, is_round.astype(bool))

    def of(self, rows):
        """Return the ``Shapes`` of the robots in ``rows``."""
        return Shapes(self.distinct, *(values[rows] for values in self[1:]))

    def by_kind(self):
        """Yield the rows of each kind that there is, and its outline (k, 2) [m]."""
        for place, kind in enumerate(self.distinct):
            rows = np.flatnonzero(self.which == place)
            if len(rows):
                yield rows, outline(kind.body)

    @property
    def farthest(self):
        """Return the greatest reach [m], 0 without robots."""
        return float(self.reach.max(initial=0.0))
