"""A topology on the map: its edges on the screen, and the one under the mouse."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.rqt_plugin.map.geometry import REACH, clearance


class Segments(NamedTuple):
    """Edges on the screen, from the sender's body to the receiver's."""

    place: np.ndarray  # (m,) in the list of edges
    weight: np.ndarray  # (m,)
    begin: np.ndarray  # (m, 2) [px]
    end: np.ndarray  # (m, 2) [px]


class Edges:
    """A topology on the map: edges (i, j, weight), robot i receives from robot j."""

    def __init__(self, edges=(), directed=True):
        self.list = [(int(i), int(j), float(*weight or (1.0,))) for i, j, *weight in edges]
        self.directed = bool(directed)
        self._numbers, self._rows = None, ()

    def holds(self, i, j):
        """Return whether there is an edge between these robots, that way if directed."""
        pairs = {edge[:2] for edge in self.list}
        return (i, j) in pairs or (not self.directed and (j, i) in pairs)

    def described(self, edge):
        """Return in words what the ``edge`` is."""
        how = "receives from robot" if self.directed else "and robot"
        return "Robot {0} {3} {1}, weight a({0}, {1}) = {2:g}".format(*edge, how)

    def segment_of(self, edge, numbers, pose, frame, unit, shapes):
        """Return where the ``edge`` begins and ends, (2,) [px] each; None where it is not in view."""
        segments = self.segments(numbers, pose, frame, unit, shapes)[0]
        found = [row for row, at in enumerate(segments.place) if self.list[at] == edge]
        return (segments.begin[found[0]], segments.end[found[0]]) if found else None

    def _table(self, numbers):
        """Return the receivers' rows, the senders' rows, weights and indices in the list, (m,) each."""
        if self._numbers != numbers:
            rows = {number: row for row, number in enumerate(numbers)}
            known = [
                (rows[i], rows[j], weight, place)
                for place, (i, j, weight) in enumerate(self.list)
                if i in rows and j in rows
            ]
            receiver, sender, weight, place = np.array(known, dtype=float).reshape(-1, 4).T
            self._numbers = numbers
            self._rows = receiver.astype(int), sender.astype(int), weight, place.astype(int)
        return self._rows

    def segments(self, numbers, pose, frame, unit, shapes, most=None):
        """Return the ``Segments`` in view, and k: of more than ``most`` edges, only one in k."""
        table = self._table(numbers)
        stride = 1 if most is None else max(1, len(table[0]) // most)
        receiver, sender, weight, place = (column[::stride] for column in table)
        columns = receiver, sender, weight, place
        return _segments(pose, *columns, frame, unit, shapes), stride

    def at(self, numbers, pose, frame, unit, at, shapes):
        """Return the edge at ``at`` (2,) [px], None for none; of two, that with its head near."""
        segments = self.segments(numbers, pose, frame, unit, shapes)[0]
        if not len(segments.place):
            return None
        away = _distances(at, segments.begin, segments.end)
        best = int(np.argmin(away + 1e-3 * np.hypot(*(segments.end - at).T)))
        return self.list[segments.place[best]] if away[best] <= REACH * unit else None


def _segments(pose, receiver, sender, weight, place, frame, unit, shapes):
    first, second = frame.to_screen(pose[sender]), frame.to_screen(pose[receiver])
    area, low, high = frame.area, np.minimum(first, second), np.maximum(first, second)
    seen = (low <= (area.right(), area.bottom())) & (high >= (area.left(), area.top()))
    index = np.flatnonzero(seen.all(axis=1))
    apart = second[index] - first[index]
    length = np.maximum(np.hypot(*apart.T), 1e-9)
    toward = apart / length[:, np.newaxis]
    up = toward * (1.0, -1.0)
    begins, ends = sender[index], receiver[index]
    gap_first = clearance(pose[begins], up, frame, unit, shapes.of(begins))
    gap_second = clearance(pose[ends], -up, frame, unit, shapes.of(ends))
    apart = gap_first + gap_second < length
    index, toward = index[apart], toward[apart]
    begin = first[index] + gap_first[apart, np.newaxis] * toward
    end = second[index] - gap_second[apart, np.newaxis] * toward
    return Segments(place[index], weight[index], begin, end)


def _distances(point, begin, end):
    """Return how far ``point`` (2,) is from each segment between ``begin`` and ``end`` (m, 2)."""
    along = end - begin
    length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-12)
    share = np.clip(np.einsum("ij,ij->i", point - begin, along) / length, 0.0, 1.0)
    return np.hypot(*(begin + share[:, np.newaxis] * along - point).T)
