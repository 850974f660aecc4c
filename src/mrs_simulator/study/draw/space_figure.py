"""The figure of a run in space: the paths of the controlled points, and those of theory."""

import mpl_toolkits.mplot3d  # noqa: F401 which registers the projection "3d" before matplotlib 3.2
import numpy as np

from mrs_simulator.study.draw.canvas import styled
from mrs_simulator.study.draw.figure_parts import START_COLOUR, is_seen, robot_colours

SPACE_HEIGHT = 5.4  # [in]
MOST_SAMPLES = 600  # of a path
SHADOW = "#c8c8c8"  # of a path, on the ground


@styled
def draw_in_space(figure, run, prediction=None):
    """Draw the paths of ``run``, whose points have heights, on ``figure``, emptied first; return the axes.

    ``prediction`` (p, n, 3) [m]: the points of theory.
    """
    figure.clear()
    axes = figure.add_subplot(1, 1, 1, projection="3d")
    colours = robot_colours(run.robots)
    chosen = np.unique(np.linspace(0, len(run.time) - 1, MOST_SAMPLES).round().astype(int))
    low, high = _room(run.hand)
    for row, path in enumerate(run.hand[chosen].transpose(1, 2, 0)):
        first = row == 0
        axes.plot(path[0], path[1], low[2], color=SHADOW, lw=0.7, label="Shadow" if first else None)
        axes.plot(*path, color=colours[row], lw=1.3)
        axes.plot(*path[:, -1:], "o", color=colours[row], ms=5.0, label="End" if first else None)
    axes.plot(*run.hand[0].T, "o", ms=3.5, ls="", color=START_COLOUR, label="Start")
    if prediction is not None:
        paths = np.transpose(prediction, (1, 2, 0))
        seen = any(is_seen(path) for path in paths)
        for row, path in enumerate(paths):
            label = "Theory" if seen and not row else None
            axes.plot(*path, color="k", ls=(0, (3, 5)), lw=0.9, label=label)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    if hasattr(axes, "set_box_aspect"):  # matplotlib 3.3
        axes.set_box_aspect(high - low, zoom=0.9)  # or the label of z is cut off
    axes.set(xlabel="$x$ [m]", ylabel="$y$ [m]", zlabel="$z$ [m]")
    axes.legend(loc="upper center", ncol=4)
    return axes


def _room(points):
    """Return the lowest and highest (x, y, z) [m] of the drawing, no side shorter than half of another."""
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    size = np.maximum(1.1 * (high - low), 0.5 * max((high - low).max(), 0.1))
    middle = 0.5 * (low + high)
    low, high = middle - 0.5 * size, middle + 0.5 * size
    if low[2] < 0.0:  # the ground is in sight, and nothing is below it
        low[2], high[2] = 0.0, high[2] - low[2]
    return low, high
