"""Panels of a composed figure in which several runs are laid over each other: each in its own line."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D

from mrs_simulator.study.draw.canvas import styled
from mrs_simulator.study.draw.figure_parts import (
    PALETTE,
    RUN_DASHES,
    entry_width,
    is_seen,
    legend_above,
    marks_of,
    robot_colours,
    thin,
)
from mrs_simulator.study.draw.log_ticks import label_log

# [-] width of theory among several runs, in widths of the run's; its opacity
BROAD, PALE = 3.0, 0.35
WIDTH = 1.2  # [points]
EARLIER = 0.5  # [-] opacity of where a compared run ends


class TeamError(NamedTuple):
    """The formation error of a run, and theory's where there is one."""

    time: Any  # (m,) [s]
    values: Any  # (m,) [m]
    theory: Any = None  # (time (p,) [s], error (p,) [m]), or None


class NamedRun(NamedTuple):
    """One of the runs of a figure."""

    name: str
    run: Any  # a ``recording.Run``
    error: Any = None  # a ``TeamError``, None where it has none


def run_line(place):
    """Return the line style of the run at ``place``: 0 the first, then those compared with it."""
    return RUN_DASHES[place % len(RUN_DASHES)]


def signs_of(runs):
    """Return lines for a legend that names the ``runs``, ``NamedRun``s, by their lines."""
    look = {"color": "k", "lw": WIDTH}
    return [
        Line2D([], [], ls=run_line(place), label=r.name, **look) for place, r in enumerate(runs)
    ]


@styled
def lay_paths(axes, runs):
    """Lay the paths of the ``runs`` after the first over those of the first, which are on ``axes``."""
    own = runs[0].run
    colours = dict(zip(own.robots.tolist(), robot_colours(own.robots)))
    for place, each in enumerate(runs):
        points = each.run.pose[:, :, :2]
        for row, number in enumerate(each.run.robots.tolist()):
            line = points[:, row].T
            if is_seen(line):
                axes.plot(*line, color=colours[number], ls=run_line(place), lw=WIDTH, zorder=2.2)
            axes.plot(*points[-1, row], ".", color=colours[number], alpha=EARLIER, zorder=3.5)


@styled
def lay_curves(axes, runs, values_of, drawstyle="default"):
    """Lay the curves of the ``runs`` after the first over those of the first, which are on ``axes``.

    ``values_of``: of a ``Run`` (m, n).
    """
    own = runs[0].run
    colours = robot_colours(own.robots)
    rows = {each: i for i, each in enumerate(own.robots.tolist())}
    for place, each in enumerate(runs[1:], 1):
        for column, number in enumerate(each.run.robots.tolist()):
            line = thin(each.run.time, values_of(each.run)[:, column])
            look = {"color": colours[rows[number]], "ls": run_line(place), "lw": WIDTH}
            look.update(marks_of(rows[number], len(rows), place))
            axes.plot(*line, drawstyle=drawstyle, **look)
    axes.set_xlim(own.time[0], max(each.run.time[-1] for each in runs))


@styled
def draw_error(axes, runs):
    """Draw the formation error of ``runs`` beside theory's on ``axes``; of several each under its name."""
    for place, each in enumerate(runs):
        if each.error is None:
            continue
        colour, name = PALETTE[place % len(PALETTE)], each.name if len(runs) > 1 else "Run"
        line = {"color": colour, "ls": run_line(place)}
        axes.plot(*_positive(each.error.time, each.error.values), lw=WIDTH, label=name, **line)
        if each.error.theory is None:
            continue
        theory = _positive(*each.error.theory)
        if len(runs) > 1:
            line.update(lw=BROAD * WIDTH, alpha=PALE, zorder=1.8)
            axes.plot(*theory, label="Theory, {}".format(name), **line)
        else:
            axes.plot(*theory, color="k", ls=(0, (4, 3)), lw=0.8, label="Theory")
    axes.set_yscale("log")
    label_log(axes.yaxis)
    axes.set_ylabel("formation error [m]")
    axes.set_xlabel("time [s]")
    ends = [each.error.time[[0, -1]] for each in runs if each.error is not None]
    axes.set_xlim(np.min(ends), np.max(ends))
    labels = axes.get_legend_handles_labels()[1]
    legend_above(axes, entry=entry_width(labels))


def _positive(time, values):
    """Return ``time`` and ``values``, thinned, with NaN for what has no logarithm."""
    values = np.asarray(values, dtype=float)
    return thin(np.asarray(time), np.where(values > 0.0, values, np.nan))
