"""Grids of occupied cells: a scene's map, and the map that overlaid scans give."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.surroundings.maps import (
    FLOOR,
    SERVED,
    WALL,
    obstacles_of,
    trinary_cells,
)
from mrs_simulator.scenario.surroundings.obstacles import clearance, corners, is_flat

CELL = 0.05  # [m] of a scene that no map with cells of its own describes
MARGIN = 1.0  # [m] around its obstacles
ROUNDING = 1e-9  # [m]
MOST_CELLS = 4_000_000  # [-] of such a scene; larger ones have larger cells


class Grid(NamedTuple):
    """Square cells, row by row from the lower left one: ``WALL``, ``FLOOR`` or ``UNKNOWN``."""

    cells: np.ndarray  # (rows, columns) int8, the lowest row first
    side: float  # [m] of a cell
    origin: Tuple[float, float, float]  # x, y [m], yaw [rad] of the lower left corner

    def places(self):
        """Return the centres of all cells, (rows, columns, 2) [m]."""
        rows, columns = self.cells.shape
        x = self.side * (np.arange(columns) + 0.5)
        y = self.side * (np.arange(rows) + 0.5)[:, np.newaxis]
        cos, sin = math.cos(self.origin[2]), math.sin(self.origin[2])
        return np.stack(
            [self.origin[0] + cos * x - sin * y, self.origin[1] + sin * x + cos * y], axis=-1
        )

    def rows_columns(self, points):
        """Return the row and the column in which ``points`` (..., 2) [m] lie, also beyond the grid."""
        cos, sin = math.cos(self.origin[2]), math.sin(self.origin[2])
        away = np.asarray(points, dtype=float) - np.array(self.origin[:2])
        x, y = away[..., 0], away[..., 1]
        column, row = (cos * x + sin * y) / self.side, (cos * y - sin * x) / self.side
        return np.floor(row).astype(int), np.floor(column).astype(int)

    def holds(self, row, column):
        """Return which cells are within the grid, bool."""
        rows, columns = self.cells.shape
        return (row >= 0) & (row < rows) & (column >= 0) & (column < columns)


def scene_grid(scenario):
    """Return the ``Grid`` of the obstacles of ``scenario``, None without any.

    That of a map_server file has its cells; obstacles are drawn into it.  Other scenes have cells of
    ``CELL``, or larger ones.  A cell is occupied if its middle is within half a cell of an obstacle.
    """
    standing = [each for each in obstacles_of(scenario) if not is_flat(each)]
    if scenario.map is not None and scenario.map.file.lower().endswith(SERVED):
        grid = _served_grid(scenario)
        standing = [each for each in scenario.obstacles if not is_flat(each)]
    elif standing:
        grid = empty_grid(np.concatenate([corners(each) for each in standing]))
    else:
        return None
    for obstacle in standing:
        _draw(grid, obstacle)
    return grid


def _served_grid(scenario):
    source = scenario.map.located(scenario.directory)
    cells, side, (x, y, yaw) = trinary_cells(source.file)
    cos, sin = math.cos(source.pose[2]), math.sin(source.pose[2])
    place = source.pose[0] + cos * x - sin * y, source.pose[1] + sin * x + cos * y
    return Grid(np.ascontiguousarray(cells[::-1]), side, (*place, yaw + source.pose[2]))


def empty_grid(points):
    """Return a ``Grid`` of floor that holds ``points`` (m, 2) [m] with ``MARGIN`` around them."""
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    side = max(CELL, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
    low = side * np.floor(low / side)
    columns, rows = (int(math.ceil(each)) for each in (high - low) / side)
    return Grid(np.full((rows, columns), FLOOR, dtype=np.int8), side, (*low.tolist(), 0.0))


def _draw(grid, obstacle):
    """Make the cells of ``grid`` occupied where ``obstacle`` stands."""
    row, column = grid.rows_columns(corners(obstacle))
    within = tuple(
        slice(max(0, int(each.min()) - 1), max(0, int(each.max()) + 2)) for each in (row, column)
    )
    places = grid.places()[within]
    if places.size:
        far, _ = clearance(obstacle, places.reshape(-1, 2))
        near = far.reshape(places.shape[:2]) < 0.5 * grid.side - ROUNDING
        grid.cells[within][near] = WALL
