"""A floor as cells of a grid: which are free, how far they are by free ways, and which a scan has seen."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import direction_of
from mrs_simulator.protocols.exploration.compiled_ways import compiled_lengths, lengths
from mrs_simulator.scenario.surroundings.obstacles import least_clearance

STEPS = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)]
FAR = np.inf
FOUND = 300  # [-] cells to which Python finds ways in 0.1 ms, about


class Floor(NamedTuple):
    """Square cells of a floor: row by x, column by y."""

    corner: np.ndarray  # (2,) [m] of the first cell's middle
    size: float  # [m] of a cell
    free: np.ndarray  # (a, b) bool, cells whose middle is farther than half a side from obstacles
    open: np.ndarray  # (a, b) bool, cells in whose middle there is room for a robot
    middles: np.ndarray  # (a, b, 2) [m]

    def cell(self, point):
        """Return row and column of the cell nearest to a ``point`` (2,) [m]."""
        near = ((point - self.corner) / self.size).tolist()
        return tuple(min(max(round(at), 0), n - 1) for at, n in zip(near, self.free.shape))


def floor_of(obstacles, size, room):
    """Return the ``Floor`` among ``obstacles``, all that lies in the box about them.

    ``size`` [m] of cells; ``room`` [m] that a robot's centre keeps from obstacles.
    """
    middle = np.array([[each.x, each.y] for each in obstacles])
    reach = np.array([_reach(each) for each in obstacles])
    low, high = (middle - reach).min(axis=0), (middle + reach).max(axis=0)
    shape = np.maximum(np.floor((high - low) / size).astype(int), 1)
    corner = 0.5 * (low + high - size * (shape - 1))
    middles = corner + size * np.stack(np.indices(shape), axis=-1)
    places = middles.reshape(-1, 2)
    far = least_clearance(obstacles, places).reshape(shape)
    return Floor(corner, size, far > 0.5 * size, far > max(room, 0.5 * size), middles)


def _reach(obstacle):
    """Return half the sides (2,) [m] of the upright box around an obstacle."""
    if hasattr(obstacle, "radius"):
        return np.full(2, obstacle.radius)
    cos, sin = abs(np.cos(obstacle.yaw)), abs(np.sin(obstacle.yaw))
    half = 0.5 * obstacle.length, 0.5 * obstacle.width
    return np.array([cos * half[0] + sin * half[1], sin * half[0] + cos * half[1]])


def ways(open_cells, size, begin):
    """Return how far it is over ``open_cells`` (a, b) bool from the cell ``begin``, (a, b) [m].

    Steps lead to the eight cells around one, not past a corner; inf where none lead.
    """
    passable = np.zeros(np.add(open_cells.shape, 2), dtype=bool)
    passable[1:-1, 1:-1] = open_cells
    passable[begin[0] + 1, begin[1] + 1] = True  # a robot is where it is
    row, cells = passable.shape[1], passable.ravel()
    first = (begin[0] + 1) * row + begin[1] + 1
    steps = tuple((dx * row, dy, float(size * np.hypot(dx, dy))) for dx, dy in STEPS)
    found = same_bits(compiled_lengths, size=1 + cells.size // FOUND)
    far = lengths(cells.tolist(), first, steps) if found is None else found(cells, first, steps)
    return far.reshape(passable.shape)[1:-1, 1:-1]


def beside(far, free, size, rounds=4):
    """Return ``far`` (a, b) [m] also of ``free`` cells near to those that ways lead to.

    Of two free cells side by side both are half a side from any wall: none is between them.
    """
    padded = np.full(np.add(far.shape, 2), FAR)
    padded[1:-1, 1:-1], far = far, padded[1:-1, 1:-1]
    a, b = far.shape
    around = [padded[1 - dx : 1 - dx + a, 1 - dy : 1 - dy + b] for dx, dy in STEPS[:4]]
    for _ in range(rounds):
        left = free & np.isinf(far)
        if not left.any():
            break
        come = np.min(around, axis=0) + size
        far[left] = come[left]
    return far


def downhill(far, cell, steps):
    """Return the cell (2,) where ``steps`` steps from ``cell`` down the ways ``far`` (a, b) lead."""
    for _ in range(steps):
        around = [cell] + [
            (cell[0] + dx, cell[1] + dy)
            for dx, dy in STEPS
            if 0 <= cell[0] + dx < far.shape[0] and 0 <= cell[1] + dy < far.shape[1]
        ]
        cell = min(around, key=lambda each: far[each])
    return cell


def seen_by(floor, pose, reading, cells):
    """Return those of the ``cells`` (k,), counted row after row, that a scan shows.

    They are before what the ray next to their direction met.  ``pose`` (3,): x, y [m], theta [rad] of the
    robot; ``reading``: of its laser.
    """
    angle = reading.places[:, 2]
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x, y = reading.places[0, :2]
    origin = pose[:2] + [cos * x - sin * y, sin * x + cos * y]
    way = floor.middles.reshape(-1, 2)[cells] - origin
    far = np.hypot(way[:, 0], way[:, 1])
    (near,) = (far < reading.most).nonzero()
    if not len(near):
        return near
    cells, way, far = cells[near], way[near], far[near]
    bearing = direction_of(way) - pose[2] - angle[0]
    bearing = np.mod(bearing + np.pi * 1e-9, 2.0 * np.pi)
    step = (angle[-1] - angle[0]) / max(1, len(angle) - 1) or 1.0
    ray = np.rint(bearing / step).astype(int)
    within = ray < len(angle)
    # not less than nan, of a ray that tells nothing
    return cells[within & (far < reading.ranges[np.minimum(ray, len(angle) - 1)])]
