"""One figure of chosen panels, robots and times of a run."""

import functools
import re
from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.record.recording import Run
from mrs_simulator.study.draw.canvas import HEIGHT, in_style, new_figure, settle, styled
from mrs_simulator.study.draw.compared_panels import (
    NamedRun,
    draw_error,
    lay_curves,
    lay_paths,
    signs_of,
)
from mrs_simulator.study.draw.curve_figures import draw_inputs, draw_states, name_robots, values_of
from mrs_simulator.study.draw.figure_parts import legend_above, predicted_of
from mrs_simulator.study.draw.plane_figure import NAMED, draw_trajectories, trajectories_height
from mrs_simulator.study.draw.style import LookError

PLANE, INPUTS, STATES, ERROR = "trajectories", "inputs", ("x", "y", "z"), "error"
PANELS = (PLANE, *STATES, INPUTS, ERROR)
PANEL_HEIGHT = 0.5 * HEIGHT  # [in] of curves at a page's width
ROOM = 0.45  # [in] for the legend and the times


class Choice(NamedTuple):
    """What a composed figure shows."""

    panels: Tuple[str, ...] = ("x", "y")  # of ``PANELS``, from above
    robots: Tuple[int, ...] = ()  # their numbers, () for all
    between: Optional[Tuple[float, float]] = None  # [s], None for the whole run


def numbers_in(text):
    """Return the numbers that ``text`` lists, such as ``1, 3-5``, in ascending order.

    Raises ``LookError`` for anything else.
    """
    found = set()
    for part in filter(None, re.split(r"[,\s]+", text.strip())):
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", part)
        if not match or int(match.group(2) or match.group(1)) < int(match.group(1)):
            raise LookError("robots {!r}: wanted numbers such as 1,3-5".format(text))
        found.update(range(int(match.group(1)), int(match.group(2) or match.group(1)) + 1))
    return tuple(sorted(found))


def chosen_part(run, choice):
    """Return ``run`` with the robots and times of ``choice`` alone.

    Raises ``LookError`` for robots that it does not have, and for times that hold fewer than two samples.
    """
    rows, samples = np.arange(len(run.robots)), slice(None)
    if choice.robots:
        missing = sorted(set(choice.robots).difference(int(number) for number in run.robots))
        if missing:
            raise LookError("robot {}: wanted those of {}".format(missing[0], _listed(run.robots)))
        rows = np.flatnonzero(np.isin(run.robots, choice.robots))
    if choice.between is not None:
        first, last = choice.between
        samples = np.flatnonzero((run.time >= first) & (run.time <= last))
        if len(samples) < 2:
            text = (
                "between {:g} and {:g} s there are {} samples, wanted 2 at least of {:g} to {:g} s"
            )
            raise LookError(text.format(first, last, len(samples), run.time[0], run.time[-1]))
        samples = slice(samples[0], samples[-1] + 1)
    part = run.at(samples)
    kinds = tuple(np.array(part.kinds)[rows]) if part.kinds else ()
    columns = {} if part.z is None else {"z": part.z[:, rows]}
    arrays = part.pose[:, rows], part.hand[:, rows], part.command[:, rows]
    met = [each for each in run.collisions if part.time[0] <= each.time <= part.time[-1]]
    return Run(
        part.time,
        part.robots[rows],
        *arrays,
        met,
        run.scenario,
        run.meta,
        run.axes,
        kinds,
        **columns,
    )


def _listed(numbers):
    first, last = int(min(numbers)), int(max(numbers))
    return (
        "{} to {}".format(first, last) if last - first + 1 == len(numbers) else str(list(numbers))
    )


def composed_figure(run, choice, prediction, look, error=None, own_name="", others=()):
    """Return the figure of ``choice``, a :class:`Choice`, of ``run``, as ``look``, a ``Look``, has it.

    ``prediction``: of theory for the whole run, as ``figures.figures`` takes it, or None.  ``error``: the
    run's ``TeamError``, or None.  ``own_name``: its name beside ``others``, ``NamedRun``s laid over it,
    without theory but in the panel ``error``; all begin at the same time.  Raises ``LookError`` for what
    the run does not have.
    """
    panels = choice.panels
    for name in panels:
        if name not in PANELS:
            raise LookError(unknown_name("a figure", name, PANELS))
    if not panels or len(set(panels)) < len(panels):
        raise LookError("panels {}: wanted each once, and one at least".format(", ".join(panels)))
    if "z" in panels and run.z is None:
        raise LookError("panel z: no robot of this run leaves the ground")
    runs = [NamedRun(own_name, run, error), *others]
    if ERROR in panels and all(each.error is None for each in runs):
        raise LookError("panel error: the protocol defines no formation error")
    parts = [_part_of(each, run, choice) for each in runs]
    theory = None
    if prediction is not None and not others:
        theory = _theory_of(run, parts[0].run, prediction)
    with in_style(look.style):
        return _figure(parts, panels, theory, look)


def _part_of(each, first, choice):
    """Return the ``NamedRun`` of what is chosen of ``each``, of robots of the ``first`` run."""
    wanted = choice
    if each.run is not first:
        known = set(choice.robots or first.robots.tolist())
        wanted = choice._replace(robots=tuple(sorted(known.intersection(each.run.robots.tolist()))))
        if not wanted.robots:
            raise LookError("{}: has none of the robots that are drawn".format(each.name))
    error = each.error
    if error is not None and choice.between is not None:
        kept = [_between(time, choice) for time in (error.time, (error.theory or [()])[0])]
        theory = error.theory and tuple(part[kept[1]] for part in map(np.asarray, error.theory))
        error = error._replace(
            time=error.time[kept[0]], values=error.values[kept[0]], theory=theory
        )
    return NamedRun(each.name, chosen_part(each.run, wanted), error)


def _between(time, choice):
    first, last = choice.between
    return (np.asarray(time) >= first) & (np.asarray(time) <= last)


def _theory_of(run, part, prediction):
    """Return the ``prediction`` of the robots and times of ``part`` of ``run``; None if none is left."""
    time, hand = predicted_of(run, prediction)
    rows = np.isin(run.robots, part.robots)
    kept = (time >= part.time[0]) & (time <= part.time[-1])
    return {"time": time[kept], "hand": hand[kept][:, rows]} if kept.any() else None


@styled
def _figure(runs, panels, prediction, look):
    """Return the figure of ``panels`` of ``runs``, ``NamedRun``s, settled."""
    heights, counts, run = [], [], runs[0].run
    others = [each.run for each in runs[1:]]
    for name in panels:
        count = len(run.axes) if name == INPUTS else 1
        plane = name == PLANE
        high = (
            trajectories_height(run, prediction, look.width, others)
            if plane
            else look.scaled(PANEL_HEIGHT)
        )
        counts.append(count)
        heights += [high] * count
    figure = new_figure(look.width, sum(heights) + ROOM)
    grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    axes = [figure.add_subplot(grid[row, 0]) for row in range(len(heights))]
    curves, over_time, begin = [], [], 0
    for name, count in zip(panels, counts):
        own, begin = axes[begin : begin + count], begin + count
        _draw_panel(name, own, runs, prediction)
        curves += own if name not in (PLANE, ERROR) else []
        over_time += own if name != PLANE else []
    if curves:
        signs = signs_of(runs) if others else ()
        name_robots(figure, curves, run.robots, signs)
    if over_time:
        figure.align_ylabels(over_time)
    _share_time(curves, axes)
    settle(figure)
    return figure


def _draw_panel(name, axes, runs, prediction):
    """Draw the panel called ``name`` of ``runs`` on ``axes``, one for each input."""
    run, others = runs[0].run, [each.run for each in runs[1:]]
    figure = axes[0].figure
    if name == PLANE:
        draw_trajectories(figure, run, prediction, axes[0], others)
        if others:
            lay_paths(axes[0], runs)
            legend_above(axes[0], ("Start", *NAMED), signs_of(runs))
    elif name == ERROR:
        draw_error(axes[0], runs)
    elif name == INPUTS:
        draw_inputs(figure, run, axes=axes, named=False, marked=bool(others))
        for column, panel in enumerate(axes if others else ()):
            lay_curves(panel, runs, lambda run, k=column: run.command[:, :, k], "steps-post")
    else:
        given = dict(axes=axes[0], named=False, marked=bool(others))
        draw_states(figure, run, name, prediction, **given)
        if others:
            lay_curves(axes[0], runs, functools.partial(values_of, component=name))


def _share_time(curves, axes):
    """Label the times of the lowest of ``curves`` that follow each other among ``axes`` alone."""
    for above, below in zip(axes, axes[1:]):
        if above in curves and below in curves:
            above.set_xlabel("")
            above.tick_params(labelbottom=False)
