#!/usr/bin/env python3
"""What a picture of the 3D view costs: processor time of all threads, by OpenGL and painted.

    xvfb-run -a python3 benchmarks/view.py [N ...] [--pictures K] [--trails P] [--size WxH]

Teams of N robots with trails of P points each, a chain of edges, targets and numbers move a little between
two pictures.  Without a graphics card OpenGL itself runs on the processor, such as by llvmpipe: then the
column of the drawing alone, without the rasterizer's threads, is what is left with one.
"""

import argparse
import os
import time

import numpy as np
from gui import grid

COLUMNS = "robots", "way", "all ms", "own ms", "wall ms", "longest ms"
ROW = "{:10d} {:>10} {:10.1f} {:10.1f} {:10.1f} {:10.1f}"
SPEED = 0.02  # [m] between two pictures
WARM = 3  # [-] pictures before those that count


def scenes(n, count, points):
    """Yield ``count`` scenes of ``n`` robots with trails of so many ``points``."""
    from mrs_simulator.pictures.scene import Scene
    from mrs_simulator.rqt_plugin.map.team import resting
    from mrs_simulator.study.draw.figure_parts import robot_colours
    from mrs_simulator.vehicles import kind

    numbers, begin = tuple(range(1, n + 1)), grid(n)
    shades, kinds = robot_colours(numbers)[:, :3], (kind("pioneer3dx"),) * n
    turns = 0.02 * np.arange(points)[:, np.newaxis] + np.arange(n)
    steps = SPEED * np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=2)
    back = np.cumsum(steps, axis=0) - steps.sum(axis=0)
    trails = np.moveaxis(back + begin * (1.0, 1.0, 0.0), 1, 0)
    edges = [(row, row - 1, 1.0) for row in range(1, n)]
    heading = begin[:, 2]
    ahead = np.column_stack([np.cos(heading), np.sin(heading), 0.0 * heading])
    for step in range(count):
        pose = begin + step * SPEED * ahead
        yield Scene(
            kinds,
            resting(numbers, pose),
            shades,
            trails=tuple(trails),
            targets=begin * (1.0, 1.0, 0.0),
            edges=edges,
        )


def measured(n, options, by_card):
    """Return [ms] a picture: all threads, this one, wall time, the longest; None: no OpenGL."""
    from mrs_simulator.rqt_plugin.view.canvas import Canvas

    canvas, costs = Canvas(), []
    canvas.resize(*(int(side) for side in options.size.split("x")))
    if by_card and canvas.card is None:
        return None
    if by_card:
        canvas.card.suits = lambda scene: True
    else:
        canvas.card = None
    for step, scene in enumerate(scenes(n, WARM + options.pictures, options.trails)):
        if step == WARM:
            clocks = time.process_time(), time.thread_time()
        begun = time.perf_counter()
        canvas.show_scene(scene)
        canvas.grab()
        costs.append(time.perf_counter() - begun)
    ended = time.process_time(), time.thread_time()
    every, own = (1e3 * (b - a) / options.pictures for a, b in zip(clocks, ended))
    return every, own, 1e3 * np.mean(costs[WARM:]), 1e3 * max(costs[WARM:])


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("robots", nargs="*", type=int, default=[7, 20, 100])
    parser.add_argument("--pictures", type=int, default=30)
    parser.add_argument("--trails", type=int, default=500, help="points of each")
    parser.add_argument("--size", default="640x400", help="of the picture, in pixels")
    options = parser.parse_args()
    from PyQt5.QtWidgets import QApplication

    application = QApplication([])
    print(" ".join("{:>10}".format(column) for column in COLUMNS))
    for n in options.robots:
        for way in ("OpenGL", "painted"):
            costs = measured(n, options, way == "OpenGL")
            if costs is None:
                print("{:10d} {:>10}  there is none".format(n, way))
            else:
                print(ROW.format(n, way, *costs), flush=True)
    del application
    os._exit(0)  # the interpreter takes Qt's objects down in any order


if __name__ == "__main__":
    main()
