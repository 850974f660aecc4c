"""Exploration as published, for verdicts: see :mod:`protocols.published.sensors`.

Greedy mapping (Koenig, Tovey, Smirnov, 2003) by a team: ways are shortest paths, by Dijkstra, over
cells, which are shared by who is nearest.  A cell is (column by x, row by y); of equals the first counts.
"""

import heapq
import math

import numpy as np

from mrs_simulator.protocols.published.sensors import Sensed, pairs
from mrs_simulator.scenario.surroundings.obstacles import Cylinder

SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))
AROUND = (*SIDES, (1, 1), (1, -1), (-1, 1), (-1, -1))
AHEAD, PATIENCE, ROUNDS = 2, 1.0, 4  # [-] cells, [s] between plans, [-] cells beside ways
NEAREST = 0.7  # [-] of the distance kept by ways, within which none heads for another


class Exploration(Sensed):
    """Each robot goes to the nearest cell that no robot has seen and that it is nearest to."""

    def __init__(self, speed, cell, room, apart):
        self.speed, self.cell, self.room, self.apart = speed, cell, room, apart

    def answers(self, record):
        """Yield ``(row, u)`` at all commands, as long as none is missing in the record."""
        team, known, last = _Team(self, record), record.known, None
        for row in record.rows:
            time = known.time[row] - known.time[0]
            samples, scans = record.readings("laser", row)
            lost = any(k >= 0 and scan is None for k, scan in zip(samples, scans))
            if lost or (last is not None and time - last > 1.5 * record.period):
                return
            last = time
            yield row, pairs(team.velocities(row, time, samples, scans))


class _Grid:
    """Cells among obstacles: ``corner``, complex [m]; ``free`` and ``open`` (a, b) bool."""

    def __init__(self, obstacles, size, room):
        self.size, outlines = size, [_extent(each) for each in obstacles]
        low = [min(o[0][k] for o in outlines) for k in (0, 1)]
        high = [max(o[1][k] for o in outlines) for k in (0, 1)]
        count = [max(1, math.floor((b - a) / size)) for a, b in zip(low, high)]
        corner = [0.5 * (a + b - size * (c - 1)) for a, b, c in zip(low, high, count)]
        self.corner, self.shape = complex(*corner), tuple(count)
        self.middles = self.corner + size * np.add.outer(
            np.arange(count[0]), 1j * np.arange(count[1])
        )
        far = _room(obstacles, self.middles)
        self.free, self.open = far > 0.5 * size, far > max(room, 0.5 * size)

    def cell(self, point):
        """Return the cell next to a ``point``, complex [m]."""
        at = (point - self.corner) / self.size
        return tuple(
            min(max(round(value), 0), count - 1)
            for value, count in zip((at.real, at.imag), self.shape)
        )

    def ways(self, passable, begin):
        """Return the lengths (a, b) [m] of the shortest ways from the cell ``begin``; inf without one."""
        wide = self.shape[1] + 2
        walls = np.pad(passable, 1)
        walls[begin[0] + 1, begin[1] + 1] = True
        can, steps = walls.ravel().tolist(), []
        for dx, dy in AROUND:
            # Python's numbers, which it adds faster than numpy's
            length = float(self.size * np.hypot(dx, dy))
            steps.append((dx * wide + dy, dx * wide, dy, length))
        first = (begin[0] + 1) * wide + begin[1] + 1
        far, heap = [math.inf] * len(can), [(0.0, first)]
        far[first] = 0.0
        while heap:
            length, at = heapq.heappop(heap)
            if length > far[at]:
                continue
            for step, beside_x, beside_y, size in steps:
                to = at + step
                if (
                    length + size < far[to]
                    and can[to]
                    and can[at + beside_x]
                    and can[at + beside_y]
                ):
                    far[to] = length + size
                    heapq.heappush(heap, (far[to], to))
        return np.reshape(far, walls.shape)[1:-1, 1:-1]

    def beside(self, far):
        """Return the ways ``far`` (a, b) [m] also to free cells beside those they lead to."""
        for _ in range(ROUNDS):
            around = np.pad(far, 1, constant_values=math.inf)
            a, b = far.shape
            come = [around[1 - dx : 1 - dx + a, 1 - dy : 1 - dy + b] for dx, dy in SIDES]
            near = np.min(come, axis=0) + self.size
            far = np.where(self.free & ~np.isfinite(far), near, far)
        return far

    def down(self, far, cell):
        """Return the cell next to ``cell`` from which the way ``far`` is shortest."""
        best = cell
        for dx, dy in AROUND:
            other = cell[0] + dx, cell[1] + dy
            inside = 0 <= other[0] < self.shape[0] and 0 <= other[1] < self.shape[1]
            if inside and far[other] < far[best]:
                best = other
        return best


class _Team:
    """What the team knows and plans."""

    def __init__(self, law, record):
        self.law, self.record = law, record
        self.grid = _Grid(record.obstacles, law.cell, law.room)
        self.seen = np.zeros(self.grid.shape, dtype=bool)
        self.samples, self.goals, self.planned, self.ways = {}, {}, -math.inf, None

    def velocities(self, row, time, samples, scans):
        """Return the velocities (n,) [m/s], complex, at a sample of the record."""
        hand = self.record.known.hand[row] @ [1.0, 1j]
        pose = self.record.known.pose[row]
        for robot, (sample, scan) in enumerate(zip(samples, scans)):
            if scan is not None and self.samples.get(robot) != sample:
                self.samples[robot] = sample
                self.seen |= self._shown(pose[robot], scan)
        if time - self.planned >= PATIENCE - 1e-9:
            self._plan(hand)
            self.planned = time
        u = np.array([self._ahead(robot, point) for robot, point in enumerate(hand)])
        near = self.law.apart + self.law.cell
        count = range(len(hand))

        def meets(i, j):
            way = hand[j] - hand[i]
            return abs(way) < near and (u[i] * np.conj(way)).real > 0

        def waits(i):
            before = (j for j in count if j != i and meets(i, j))
            return any(j < i or any(meets(j, k) for k in range(i)) for j in before)

        still = [waits(i) for i in count]
        u, near = np.where(still, 0.0, u), NEAREST * self.law.apart
        comes = [[j for j in count if j != i and meets(j, i)] for i in count]
        for i in count:
            if still[i] and comes[i]:
                from_whom = min(comes[i], key=lambda j: abs(hand[j] - hand[i]))
                u[i] = self._aside(from_whom, hand[i])
        u = np.where([any(meets(i, j) for j in count if j != i) for i in count], 0.0, u)
        if self.record.run.scenario.fidelity == "point_mass":
            return u
        return np.array([self._turning(i, u[i], pose) for i in count])

    def _turning(self, robot, u, pose):
        """Return the velocity ``u`` without its part that backs a unicycle to where it cannot turn."""
        kinds, at = self.record.kinds, pose[:, :2] @ [1.0, 1j]
        kind, heading = kinds[robot], np.exp(1j * pose[robot, 2])
        back = (u * np.conj(heading)).real
        if kind.drive != "differential" or back >= 0.0:
            return u
        way = np.array([0.0, self.record.period * back]) * heading + at[robot]
        rooms = [(*_room(self.record.obstacles, way), kind.body.reach)]
        for other in set(range(len(at))) - {robot}:
            rooms.append((*abs(way - at[other]), kind.body.reach + kinds[other].body.reach))
        cannot = any(then < now and then < wanted for now, then, wanted in rooms)
        return u - back * heading if cannot else u

    def _shown(self, pose, scan):
        turn = np.exp(1j * pose[2])
        way = self.grid.middles - (complex(pose[0], pose[1]) + scan.places[0] * turn)
        rays = len(scan.directions)
        between = (scan.directions[-1] - scan.directions[0]) / max(1, rays - 1) or 1.0
        # Of copies: numpy takes another sine of arrays with gaps.
        bearing = np.arctan2(way.imag.copy(), way.real.copy()) - pose[2] - scan.directions[0]
        ray = np.round(np.mod(bearing + np.pi * 1e-9, 2.0 * np.pi) / between).astype(int)
        free = np.where(np.isfinite(scan.ranges), scan.ranges, scan.most)
        free = np.where(np.isnan(scan.ranges), 0.0, free)
        return self.grid.free & (ray < rays) & (abs(way) < free[np.minimum(ray, rays - 1)])

    def _plan(self, hand):
        grid, law = self.grid, self.law
        cells = [grid.cell(point) for point in hand]
        ways = np.array([grid.beside(grid.ways(grid.open, cell)) for cell in cells])
        for robot, (goal, end, _) in self.goals.items():
            if cells[robot] == end:  # given up, or seen
                self.seen[goal] = True
        mine, self.goals, self.ways = ways.argmin(axis=0), {}, ways
        for robot, way in enumerate(ways):
            left = np.where(grid.free & ~self.seen, way, np.inf)
            own = np.where(mine == robot, left, np.inf)
            left = own if np.isfinite(own).any() else left
            if not np.isfinite(left).any():
                continue
            goal = end = tuple(int(k) for k in np.unravel_index(left.argmin(), left.shape))
            while not grid.open[end] and grid.down(way, end) != end:
                end = grid.down(way, end)
            others = np.delete(hand, robot)[:, np.newaxis, np.newaxis]
            clear = grid.open & (abs(grid.middles - others) > law.apart).all(axis=0)
            back = grid.ways(clear, end)
            if math.isinf(back[cells[robot]]):
                back = grid.ways(grid.open, end)
            self.goals[robot] = goal, end, back

    def _ahead(self, robot, point):
        if robot not in self.goals:
            return 0j
        return self._velocity(point, self.goals[robot][2])

    def _aside(self, other, point):
        """Return the velocity from ``point`` to where it is farther from the robot ``other``."""
        far = self.ways[other]
        return self._velocity(point, np.where(self.grid.open & (far < math.inf), -far, math.inf))

    def _velocity(self, point, lengths):
        cell = self.grid.cell(point)
        for _ in range(AHEAD):
            cell = self.grid.down(lengths, cell)
        way = self.grid.corner + self.grid.size * complex(*cell) - point
        return min(self.law.speed, abs(way) / self.record.period) * way / max(abs(way), 1e-9)


def _extent(obstacle):
    """Return the lower and the upper corner of the upright box around an obstacle."""
    if isinstance(obstacle, Cylinder):
        half = obstacle.radius, obstacle.radius
    else:
        cos, sin = abs(math.cos(obstacle.yaw)), abs(math.sin(obstacle.yaw))
        a, b = 0.5 * obstacle.length, 0.5 * obstacle.width
        half = cos * a + sin * b, sin * a + cos * b
    at = obstacle.x, obstacle.y
    return [p - h for p, h in zip(at, half)], [p + h for p, h in zip(at, half)]


def _room(obstacles, points):
    """Return how far ``points``, complex [m], are outside the nearest obstacle; 0 or less within."""
    return np.min([_clear(each, points) for each in obstacles], axis=0)


def _clear(obstacle, points):
    """Return how far ``points``, complex [m], are outside an obstacle; 0 or less within."""
    way = points - complex(obstacle.x, obstacle.y)
    if isinstance(obstacle, Cylinder):
        return abs(way) - obstacle.radius
    way = way * np.exp(-1j * obstacle.yaw)
    x, y = abs(way.real) - 0.5 * obstacle.length, abs(way.imag) - 0.5 * obstacle.width
    outside = abs(np.maximum(x, 0.0) + 1j * np.maximum(y, 0.0))
    return np.where((x < 0.0) & (y < 0.0), np.maximum(x, y), outside)
