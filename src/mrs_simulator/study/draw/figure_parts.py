"""What the drawings of a run share: colours, lines of many robots, legends."""

import matplotlib
import numpy as np
from matplotlib.cbook import pts_to_poststep
from matplotlib.cm import viridis
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize, to_hex

from mrs_simulator.core.arrays import are_near
from mrs_simulator.core.sample_blocks import blocks
from mrs_simulator.pictures.palette import START

START_COLOUR = to_hex(START)
# Okabe and Ito's colour-blind-safe palette; its yellow is too faint on white, black is for theory.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b4a3f")
# Lines of the run shown, and of those compared with it.
RUN_DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.5)), (0, (6, 1.5, 1.2, 1.5)), (0, (2.5, 1.2)))
# Without the pale end, which is too faint on white.
MANY_ROBOTS = ListedColormap(viridis(np.linspace(0.0, 0.92, 256)))
FARTHEST_DRAWN = 1e100  # [m], whose differences are numbers
LEAST_EXTENT = 10.0  # [m], of a drawing of robots that stand still
THEORY_REACH = 5.0  # [-] times the run's extent, farther from it than which theory is not drawn
FIRST_MARK, BETWEEN_MARKS = 0.03, 0.13  # [-] of the axes' diagonal
MOST_IN_LEGEND = 12  # above it a colour bar distinguishes robots
MOST_IN_LEGEND_ROW = 6
ENTRY_WIDTH = 1.1  # [in] of one entry of a legend
CHARACTER = 0.065  # [in] of a long one
# above it one artist draws all: each artist costs milliseconds in every file
MOST_LINES = MOST_IN_LEGEND
MOST_POINTS_PER_LINE = 2000
MOST_POINTS = 60000  # over all lines of one panel
# Where a legend lies that covers no data.
ABOVE = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 0.3}


def emptied(figure, rows):
    """Return ``rows`` axes above each other on ``figure``, which is emptied."""
    figure.clear()
    return figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]


def robot_colours(robots):
    """Return a colour (r, g, b, a) for each of ``robots`` (n,), their numbers."""
    if len(robots) <= MOST_IN_LEGEND:
        chosen = [PALETTE[row % len(PALETTE)] for row in range(len(robots))]
        return matplotlib.colors.to_rgba_array(chosen)
    return MANY_ROBOTS(Normalize(np.min(robots), np.max(robots))(np.asarray(robots, dtype=float)))


def marks_of(row, team, run=0):
    """Return the style of a line that tells the robot in a ``row`` from those of its colour, by a shape.

    It is for figures in which dashes tell runs apart, and this is the one at the place ``run``.  {} where
    the colour tells it, in a ``team`` of so many robots.
    """
    if not len(PALETTE) <= row < team <= MOST_IN_LEGEND:
        return {}
    return {"marker": "o", "ms": 4.0, "markevery": (FIRST_MARK + 0.03 * run, BETWEEN_MARKS)}


def draw_alike(axes, lines, label, **style):
    """Draw ``lines``, each (x, y), in one ``style``; the legend names them once, if anything is seen."""
    if not any(is_seen(line) for line in lines):
        label = "_nolegend_"
    if len(lines) > MOST_LINES:
        draw_many(axes, lines, label=label, **style)
        return
    for row, line in enumerate(lines):
        axes.plot(*line, label="_nolegend_" if row else label, **style)


def is_seen(line):
    """Return whether a ``line`` of coordinates, each (p,), shows: whether it has two points, not one."""
    points = np.stack([np.asarray(each, dtype=float) for each in line], axis=1)
    points = points[np.isfinite(points).all(axis=1)]
    return bool(len(points) and np.ptp(points, axis=0).any())


def draw_many(axes, lines, drawstyle="default", **style):
    """Draw ``lines``, each (x, y), as one artist."""
    if drawstyle == "steps-post":
        lines = [pts_to_poststep(*line) for line in lines]
    paths = [np.stack(line, axis=1) for line in lines]
    axes.add_collection(LineCollection(paths, zorder=2, **style))
    axes.autoscale_view()


def thin(time, values, most=MOST_POINTS_PER_LINE):
    """Return ``time`` and ``values`` (m,) with about ``most`` samples, for drawing only.

    Of each stretch of samples the first, lowest, highest and last stay, so no peak is lost.
    """
    if len(values) <= most:
        return time, values
    stretch = -(-4 * len(values) // most)
    begins = np.arange(len(values) // stretch) * stretch
    rest = np.arange(len(begins) * stretch, len(values))
    table = values[: rest[0] if len(rest) else None].reshape(-1, stretch)
    peaks = begins + table.argmin(axis=1), begins + table.argmax(axis=1)
    chosen = np.unique(np.concatenate([begins, begins + stretch - 1, rest, *peaks]))
    return time[chosen], values[chosen]


def most_points(n):
    return min(MOST_POINTS_PER_LINE, max(200, MOST_POINTS // n))


def points_of(run, prediction):
    """Return the points to draw, (m, n, 2) [m]: centres, or hand points to hold against theory."""
    points = run.pose[:, :, :2] if prediction is None else run.hand[:, :, :2]
    # A long run is not copied.
    low, high = extremes(points)
    near = low >= -FARTHEST_DRAWN and high <= FARTHEST_DRAWN
    return points if near else np.clip(points, -FARTHEST_DRAWN, FARTHEST_DRAWN)


def extremes(values):
    """Return the least and the greatest of ``values`` (m, ...) but NaN, looked at part by part."""
    parts = (values[rows] for rows in blocks(len(values), values[0].size))
    ends = [(np.fmin.reduce(part, axis=None), np.fmax.reduce(part, axis=None)) for part in parts]
    lows, highs = zip(*ends)
    return np.fmin.reduce(lows), np.fmax.reduce(highs)


def predicted_of(run, prediction):
    """Return theory's times (p,) [s] and hand points (p, n, d) [m], NaN far away from the run.

    The theory of a law that is not stable goes to infinity, where robots stop at their limits.
    """
    if isinstance(prediction, dict):
        return np.asarray(prediction["time"]), _near(run, np.asarray(prediction["hand"]))
    return run.time, _near(run, np.asarray(prediction))


def _near(run, hand):
    """Return ``hand`` (p, n, d) [m] with NaN where it is far away from what ``run`` shows."""
    corners = list(zip(*map(extremes, np.moveaxis(run.hand, 2, 0))))
    given = np.clip(corners, -FARTHEST_DRAWN, FARTHEST_DRAWN), THEORY_REACH, LEAST_EXTENT
    # A long run is looked at in parts, to save memory.
    if all(are_near(hand[rows], *given).all() for rows in blocks(*hand.shape[:2])):
        return hand
    return np.where(are_near(hand, *given)[..., np.newaxis], hand, np.nan)


def sized(table, few, many):
    """Return a size between ``few``, for a team that a legend can name, and ``many``, for 50."""
    return float(np.interp(table.shape[1], [MOST_IN_LEGEND, 50], [few, many]))


def entry_width(labels):
    """Return the width [in] that entries of a legend with ``labels`` of any length need."""
    return max([ENTRY_WIDTH, *(0.45 + CHARACTER * len(label) for label in labels)])


def legend_of_all(panels):
    """Draw above the first of ``panels`` one legend of what is in any of them."""
    handles = {}
    for axes in panels:
        handles.update(dict(zip(*reversed(axes.get_legend_handles_labels()))))
    panels[0].legend(handles.values(), handles.keys(), ncol=len(handles), **ABOVE)


def legend_above(axes, labels=None, more=(), entry=ENTRY_WIDTH):
    """Put the legend above ``axes``, where it covers no data; only ``labels``, in order, if given.

    ``more``: handles with labels of their own, which come last; ``entry``: least width [in] of an entry.
    """
    handles, names = axes.get_legend_handles_labels()
    handles, names = [*handles, *more], [*names, *(each.get_label() for each in more)]
    named = dict(zip(names, handles))
    last = [each.get_label() for each in more] if labels else []
    shown = [(named[name], name) for name in [*(labels or names), *last] if name in named]
    entry = max(entry, entry_width([each.get_label() for each in more]))
    fitting = int(axes.figure.get_figwidth() / entry + 0.5)
    rows = -(-len(shown) // max(2, min(MOST_IN_LEGEND_ROW, fitting)))
    columns = -(-len(shown) // rows)
    # A legend fills column by column; people read row by row.
    shown = [pair for column in range(columns) for pair in shown[column::columns]]
    axes.legend(*zip(*shown), ncol=columns, **ABOVE)
