"""Where theory, or a simulation ahead, has the robots go: faint paths, and rings where these end."""

import numpy as np

from mrs_simulator.pictures import signs
from mrs_simulator.pictures.drawing import Paths, with_opacity
from mrs_simulator.pictures.scene import END_SHOWN, PATH_SHOWN
from mrs_simulator.rqt_plugin.view.painting import draw_layer

WIDTH = 1.4  # [px] of a path
MOST_DRAWN = 20000  # [-] points of all paths


def draw_forecast(painter, style, frame, paths, numbers):
    """Draw ``paths`` (k, n, 2) [m] of the robots ``numbers``; of one point alone the ring."""
    lines = np.moveaxis(frame.to_screen(_thinned(paths)), 1, 0)
    known = np.isfinite(lines).all(axis=(1, 2))
    lines, shades = lines[known], style.shades_of(np.array(numbers)[known], True)
    if not len(lines):
        return
    counts, width = np.full(len(lines), lines.shape[1]), WIDTH * style.unit
    ways = Paths(lines.reshape(-1, 2), counts, with_opacity(shades, PATH_SHOWN), width)
    draw_layer(painter, ways)
    ends = with_opacity(shades, END_SHOWN)
    draw_layer(painter, signs.rings(lines[:, -1], ends, len(numbers), style.unit))


def _thinned(paths):
    stride = max(1, -(-paths[..., 0].size // MOST_DRAWN))
    return np.concatenate([paths[:-1:stride], paths[-1:]])


def paths_in_space(paths, heights):
    """Return ``paths`` (k, n, 2) [m] of n robots at ``heights`` (n,) [m], (p, 3) each, a list."""
    drawn = _thinned(paths)
    level = np.broadcast_to(heights, drawn.shape[:2])[..., np.newaxis]
    return list(np.moveaxis(np.concatenate([drawn, level], axis=2), 1, 0))
