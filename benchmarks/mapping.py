#!/usr/bin/env python3
"""The map that a driven robot's laser makes by known poses, against the map of the scene.

python3 benchmarks/mapping.py [--duration S] [--out map.pgm] SCENARIO

The robots of the scenario drive by its protocol, each with the laser that its kind has room for.  Told are
how many cells scans found occupied, the share of them farther than a cell from any wall, and the share of
the scene's wall cells that rays crossed.
"""

import argparse
import math

import numpy as np

from mrs_simulator.protocols.loading import choose_protocol
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.surroundings.grids import scene_grid
from mrs_simulator.scenario.surroundings.maps import FLOOR, UNKNOWN, WALL
from mrs_simulator.sensors.suite import of_robot
from mrs_simulator.study.run.experiment import Experiment

GREY = {FLOOR: 254, WALL: 0}  # as map_server writes them; what is not known is 205


def driven(scenario, duration):
    """Return ``(pose, reading)`` of every scan of a run of ``duration`` [s]."""
    scenario = scenario.changed(duration=duration)
    scenario, protocol = choose_protocol(scenario, None)
    experiment = Experiment(scenario, protocol)
    suite, world = experiment.sensors, experiment.world
    names = dict.fromkeys(range(scenario.n), (*protocol.SENSORS, "laser"))
    suite.activate(names)
    scans, last = [], None
    for _ in experiment.samples():
        for sensor in suite.active:
            if sensor.mount.name == "laser" and sensor.newest is not last:
                last = sensor.newest
                if last.stamp == world.time:
                    poses = world.pose[sensor.rows].tolist()
                    scans += [(pose, of_robot(last, k)) for k, pose in enumerate(poses)]
    return scans


def scanned_grid(grid, scans):
    """Return the ``Grid`` of ``scans``, with the cells of ``grid``, whose values are ignored.

    ``scans``: ``(pose, reading)`` each, the pose (x, y [m], theta [rad]) in the common frame, and the
    reading of a sonar without a cone or of a laser.  A cell is occupied where a ray ends, free where rays
    pass and none ends, unknown elsewhere.
    """
    ended = np.zeros(grid.cells.shape, dtype=bool)
    passed = np.zeros(grid.cells.shape, dtype=bool)
    for (x, y, theta), reading in scans:
        places, ranges = reading.places, reading.ranges
        valid = ~np.isnan(ranges)
        places, ranges = places[valid], ranges[valid]
        cos, sin = math.cos(theta), math.sin(theta)
        begin = [x, y] + places[:, :2] @ np.array([[cos, sin], [-sin, cos]])
        along = np.column_stack([np.cos(places[:, 2] + theta), np.sin(places[:, 2] + theta)])
        hit = np.isfinite(ranges)
        _mark(ended, grid, begin[hit] + ranges[hit, np.newaxis] * along[hit])
        _mark(passed, grid, _along(begin, along, np.minimum(ranges, reading.most), grid.side))
    cells = np.where(passed, FLOOR, UNKNOWN)
    cells[ended] = WALL
    return grid._replace(cells=cells.astype(np.int8))


def _along(begin, along, ranges, side):
    """Return points (m, 2) along rays, half a cell apart, that end a cell before the rays do."""
    steps = np.arange(0.0, max(0.0, float(ranges.max(initial=0.0)) - side), 0.5 * side)
    ray, step = np.nonzero(steps < ranges[:, np.newaxis] - side)
    return begin[ray] + steps[step, np.newaxis] * along[ray]


def _mark(cells, grid, points):
    row, column = grid.rows_columns(points)
    inside = grid.holds(row, column)
    cells[row[inside], column[inside]] = True


def dilated(cells):
    """Return ``cells`` (rows, columns) bool and the eight neighbours of each that is set."""
    wide = np.pad(cells, 1)
    rows, columns = cells.shape
    around = [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    return np.logical_or.reduce(around)


def disagreement(found, wanted):
    """Return two shares [-] of cells: walls of ``found`` farther than a cell from any of ``wanted``, and
    walls of ``wanted`` that rays crossed, being free in ``found`` and farther than a cell from its walls.

    ``found``, ``wanted``: ``Grid`` with the same cells.
    """
    walls, true = found.cells == WALL, wanted.cells == WALL
    invented = walls & ~dilated(true)
    crossed = true & (found.cells == FLOOR) & ~dilated(walls)
    return invented.sum() / max(1, walls.sum()), crossed.sum() / max(1, true.sum())


def main():
    """Print the comparison; with ``--out`` write the map."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario")
    parser.add_argument("--duration", type=float, default=20.0, help="[s] of simulated time")
    parser.add_argument("--out", help="a .pgm for the map that was found")
    options = parser.parse_args()
    scenario = load_scenario(options.scenario)
    wanted = scene_grid(scenario)
    if wanted is None:
        raise SystemExit("{}: neither a map nor obstacles".format(options.scenario))
    scans = driven(scenario, options.duration)
    found = scanned_grid(wanted, scans)
    invented, crossed = disagreement(found, wanted)
    walls = int((found.cells == WALL).sum())
    print("{} scans, cells of {:g} m: {} occupied".format(len(scans), found.side, walls))
    print("farther than a cell from any wall: {:.2%} of them".format(invented))
    print("walls that rays crossed: {:.2%} of the scene's".format(crossed))
    if options.out:
        grey = np.full(found.cells.shape, 205, dtype=np.uint8)
        for value, shade in GREY.items():
            grey[found.cells == value] = shade
        with open(options.out, "wb") as file:
            file.write("P5\n{1} {0}\n255\n".format(*grey.shape).encode() + grey[::-1].tobytes())


if __name__ == "__main__":
    main()
