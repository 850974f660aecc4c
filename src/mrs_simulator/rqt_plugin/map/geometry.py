"""Geometry of the map without painting: projection, trails, shapes, edges.

Positions are arrays, one point per row, in metres unless they are said to be on the screen [px].
"""

import math
from typing import NamedTuple

import numpy as np
from python_qt_binding.QtCore import QRectF

from mrs_simulator.study.figures import ROBOT_SHAPE

SCALES = (0.01, 5000.0)  # [px/m], least and most
LEAST_EXTENT = 3.0  # [m], of what a fitted view shows
MARGIN = 0.08  # around a fitted view, as a share of its larger side

TRAIL_SPACING = 0.03  # [m] that a robot moves before its trail gets another point
TRAIL_POINTS = 3000  # [-] of one robot
ALL_TRAIL_POINTS = 4000000  # [-] of all robots
TRAIL_PIXELS = 2.5  # [px] between the points of a trail that are drawn

LEAST_ROBOT = 10.0  # [px]; a smaller one is drawn as an arrow of ARROW
ARROW = 13.0  # [px]
GRIP = 6.0  # [px] about a robot or an edge that belongs to it


class Frame:
    """Where the plane lies on the screen: y points up, both axes have one scale."""

    def __init__(self):
        self.centre = np.zeros(2)  # [m], in the middle of the area
        self.scale = 50.0  # [px/m]
        self.area = QRectF(0.0, 0.0, 100.0, 100.0)  # [px]

    def about_origin(self):
        """Return a frame of the same scale that shows the origin at (0, 0) [px]."""
        result = Frame()
        result.scale, result.area = self.scale, QRectF(-1.0, -1.0, 2.0, 2.0)
        return result

    def _middle(self):
        return np.array([self.area.center().x(), self.area.center().y()])

    def to_screen(self, points):
        """Return ``points`` (..., 2) [m] on the screen [px]."""
        shifted = np.asarray(points, dtype=float)[..., :2] - self.centre
        return shifted * (self.scale, -self.scale) + self._middle()

    def to_plane(self, points):
        """Return the ``points`` (..., 2) of the screen [px] in the plane [m]."""
        shifted = np.asarray(points, dtype=float) - self._middle()
        return shifted / (self.scale, -self.scale) + self.centre

    def pan(self, shift):
        """Move the drawing by ``shift`` (2,) [px]."""
        self.centre = self.centre - np.asarray(shift) / (self.scale, -self.scale)

    def zoom(self, factor, at):
        """Enlarge by ``factor``; the point ``at`` (2,) [px] stays where it is."""
        held = self.to_plane(at)
        self.scale = float(np.clip(self.scale * factor, *SCALES))
        self.centre = self.centre + held - self.to_plane(at)

    def look_at(self, low, high, padding=0.0):
        """Show the rectangle from ``low`` to ``high`` [m], with a margin and ``padding`` [px]."""
        size = np.maximum(np.subtract(high, low), LEAST_EXTENT)
        size = size + 2.0 * MARGIN * size.max()
        room = np.array([self.area.width(), self.area.height()])
        room = np.maximum(room - 2.0 * padding, 0.5 * room)
        self.centre = 0.5 * np.add(low, high)
        self.scale = float(np.clip(np.min(room / size), *SCALES))

    def bounds(self):
        """Return the corners (low, high) [m] of what is in view."""
        half = 0.5 * np.array([self.area.width(), self.area.height()]) / self.scale
        return self.centre - half, self.centre + half

    def sees(self, screen, margin=0.0):
        """Return which points ``screen`` (n, 2) [px] lie in the area, or ``margin`` about it."""
        area = self.area.adjusted(-margin, -margin, margin, margin)
        low, high = (area.left(), area.top()), (area.right(), area.bottom())
        return ((screen >= low) & (screen <= high)).all(axis=1)


class Trails:
    """Where the robots have been, of bounded size: when full, every other point is let go."""

    def __init__(self, n):
        self._most = max(10, min(TRAIL_POINTS, ALL_TRAIL_POINTS // max(1, n)))
        self._points = np.zeros((n, min(64, self._most), 2))
        self._spacing = np.full(n, TRAIL_SPACING)
        self._low, self._high = np.full((n, 2), np.inf), np.full((n, 2), -np.inf)
        self.count = np.zeros(n, dtype=int)

    def add(self, position):
        """Add the ``position`` (n, 2) of those robots that have moved far enough."""
        with np.errstate(invalid="ignore"):
            far = np.hypot(*(position - self.last()).T) >= self._spacing
        rows = np.flatnonzero((far | (self.count == 0)) & np.isfinite(position).all(axis=1))
        if not len(rows):
            return
        if self.count[rows].max() == self._points.shape[1]:
            self._make_room()
        self._points[rows, self.count[rows]] = position[rows]
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
        return self._points[:, 0].copy()

    def last(self):
        """Return the newest points (n, 2) of the trails; without meaning for robots without one."""
        return self._points[np.arange(len(self.count)), np.maximum(self.count - 1, 0)]

    def path(self, row, stride=1):
        """Return every ``stride``-th point (m, 2) of one robot's trail."""
        return self._points[row, : self.count[row] : stride]

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


# Shapes on the screen


def placed(shape, pose, frame):
    """Return the ``shape`` (k, 2) [m] of the robots' frame at each pose on the screen, (n, k, 2)."""
    return frame.to_screen(pose[:, np.newaxis, :2] + _turned(shape, pose[:, 2]))


def _turned(shape, theta):
    shape, cos, sin = np.asarray(shape), np.cos(theta), np.sin(theta)
    x = np.outer(cos, shape[:, 0]) - np.outer(sin, shape[:, 1])
    return np.stack([x, np.outer(sin, shape[:, 0]) + np.outer(cos, shape[:, 1])], axis=2)


def outlines(pose, frame, unit, shapes):
    """Return the outline of each robot on the screen: its footprint, or an arrow; (k, 2) each."""
    result, small = [None] * len(pose), are_arrows(frame, unit, shapes)
    for rows, shape in shapes.by_kind():
        arrow = ARROW * unit / frame.scale * np.array(ROBOT_SHAPE)
        outline = arrow if len(rows) and small[rows[0]] else shape.outline
        for row, points in zip(rows.tolist(), placed(outline, pose[rows], frame)):
            result[row] = points
    return result


def are_arrows(frame, unit, shapes):
    """Return which robots (n,) are too small to be drawn to scale."""
    return shapes.length * frame.scale < LEAST_ROBOT * unit


def clearance(pose, toward, frame, unit, shapes):
    """Return how far [px] each robot's body reaches ``toward`` (n, 2), unit vectors of the plane."""
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    along = cos * toward[:, 0] + sin * toward[:, 1]
    across = cos * toward[:, 1] - sin * toward[:, 0]
    ends = np.where(along > 0.0, shapes.front, shapes.rear)
    with np.errstate(divide="ignore"):
        reach = np.minimum(ends / np.abs(along), shapes.half / np.abs(across))
    reach = np.where(shapes.round, shapes.front, reach) * frame.scale + unit
    return np.where(are_arrows(frame, unit, shapes), 0.55 * ARROW * unit, reach)


def apart(places, width, height):
    """Return rows of ``places`` (n, 2) [px] about which boxes of that size do not touch, by order."""
    taken, rows = {}, []
    for row, (x, y) in enumerate(places.tolist()):
        column, line = int(x // width), int(y // height)
        near = [(column + i, line + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        others = [taken[cell] for cell in near if cell in taken]
        if all(abs(x - u) >= width or abs(y - v) >= height for u, v in others):
            taken[column, line] = x, y
            rows.append(row)
    return rows


def nice_step(least):
    """Return the smallest of 1, 2, 5 times a power of ten that is at least ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * 0.999999)


def robot_at(pose, frame, unit, at, shapes):
    """Return the row of the robot of ``pose`` (n, 3) at ``at`` (2,) [px], -1 for none."""
    apart = frame.to_plane(at) - pose[:, :2]
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    along = cos * apart[:, 0] + sin * apart[:, 1]
    across = np.abs(cos * apart[:, 1] - sin * apart[:, 0])
    pad, away = GRIP * unit / frame.scale, np.hypot(along, across)
    # A comparison with nan, a pose that is not known, is false.
    with np.errstate(invalid="ignore"):
        within = (along < shapes.front + pad) & (along > -shapes.rear - pad)
        within &= across < shapes.half + pad
        within |= away * frame.scale < ARROW * unit
    return int(np.argmin(np.where(within, away, np.inf))) if within.any() else -1


# Edges


class Segments(NamedTuple):
    """Edges on the screen, from the body of the robot heard to that of the one that hears."""

    place: np.ndarray  # (m,) in the list of edges
    weight: np.ndarray  # (m,)
    begin: np.ndarray  # (m, 2) [px]
    end: np.ndarray  # (m, 2) [px]


class Edges:
    """A topology as it is shown: edges (i, j, weight), robot i hears robot j."""

    def __init__(self, edges=(), directed=True):
        self.list = [(int(i), int(j), float(*weight or (1.0,))) for i, j, *weight in edges]
        self.directed = bool(directed)
        self._numbers, self._rows = None, ()

    def holds(self, i, j):
        """Return whether there is an edge between these robots, that way if directed."""
        pairs = {edge[:2] for edge in self.list}
        return (i, j) in pairs or (not self.directed and (j, i) in pairs)

    def _table(self, numbers):
        """Return rows that hear (m,), rows heard, weights, and places in the list."""
        if self._numbers != numbers:
            rows = {number: row for row, number in enumerate(numbers)}
            known = [
                (rows[i], rows[j], weight, place)
                for place, (i, j, weight) in enumerate(self.list)
                if i in rows and j in rows
            ]
            hears, heard, weight, place = np.array(known, dtype=float).reshape(-1, 4).T
            self._numbers = numbers
            self._rows = hears.astype(int), heard.astype(int), weight, place.astype(int)
        return self._rows

    def segments(self, numbers, pose, frame, unit, shapes, most=None):
        """Return the ``Segments`` in view, and k: of more than ``most`` edges, only one in k."""
        table = self._table(numbers)
        stride = 1 if most is None else max(1, len(table[0]) // most)
        hears, heard, weight, place = (column[::stride] for column in table)
        columns = hears, heard, weight, place
        return _segments(pose, *columns, frame, unit, shapes), stride

    def at(self, numbers, pose, frame, unit, at, shapes):
        """Return the edge at ``at`` (2,) [px], None for none; of two, that with its head near."""
        segments = self.segments(numbers, pose, frame, unit, shapes)[0]
        if not len(segments.place):
            return None
        away = _distances(at, segments.begin, segments.end)
        best = int(np.argmin(away + 1e-3 * np.hypot(*(segments.end - at).T)))
        return self.list[segments.place[best]] if away[best] <= GRIP * unit else None


def _segments(pose, hears, heard, weight, place, frame, unit, shapes):
    first, second = frame.to_screen(pose[heard]), frame.to_screen(pose[hears])
    area, low, high = frame.area, np.minimum(first, second), np.maximum(first, second)
    seen = (low <= (area.right(), area.bottom())) & (high >= (area.left(), area.top()))
    index = np.flatnonzero(seen.all(axis=1))
    apart = second[index] - first[index]
    length = np.maximum(np.hypot(*apart.T), 1e-9)
    toward = apart / length[:, np.newaxis]
    up = toward * (1.0, -1.0)
    begins, ends = heard[index], hears[index]
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
