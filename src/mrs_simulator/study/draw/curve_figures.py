"""Coordinates and inputs of every robot against time."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from mrs_simulator.core.kinematics import UNICYCLE_AXES
from mrs_simulator.core.sample_blocks import release
from mrs_simulator.state.columns import ARM
from mrs_simulator.study.draw.canvas import styled
from mrs_simulator.study.draw.figure_parts import (
    MANY_ROBOTS,
    MOST_IN_LEGEND,
    MOST_LINES,
    PALETTE,
    draw_alike,
    draw_many,
    emptied,
    legend_above,
    marks_of,
    most_points,
    points_of,
    predicted_of,
    robot_colours,
    sized,
    thin,
)

INPUTS_HEIGHT, INPUT_HEIGHT = 4.4, 1.05  # [in], and of each input where there are many


@styled
def draw_states(figure, run, component, prediction=None, axes=None, named=True, marked=False):
    """Draw ``component`` (``"x"``, ``"y"`` or ``"z"``) of every robot against time; return the axes.

    On ``axes``, or on ``figure``, emptied first.  ``named``: whether the figure says which line is which
    robot; ``marked``: whether robots of one colour differ by marks, not by dashes.
    """
    column = ("x", "y", "z").index(component)
    axes = emptied(figure, 1)[0] if axes is None else axes
    if component == "z":
        if prediction is not None and predicted_of(run, prediction)[1].shape[2] < 3:
            prediction = None  # theory of the plane
        values = run.z
    else:
        values = points_of(run, prediction)[:, :, column]
    _draw_curves(axes, run, values, marked)
    if prediction is not None:
        time, hand = predicted_of(run, prediction)
        _draw_predicted_curves(axes, time, hand[:, :, column])
    symbol = component if prediction is None else r"\alpha_{}".format(component)
    axes.set_ylabel("${}$ [m]".format(symbol))
    _frame_time(axes, run.time)
    if named:
        name_robots(axes.figure, [axes], run.robots)
    return axes


@styled
def draw_inputs(figure, run, axes=None, named=True, marked=False):
    """Draw the control inputs of every robot against time, v and omega of unicycles; return the axes.

    On ``axes``, one for each input, or on ``figure``, emptied first.  ``named``, ``marked``: as in
    :func:`draw_states`.
    """
    rows = emptied(figure, len(run.axes)) if axes is None else np.atleast_1d(axes)
    if len(rows) != len(run.axes):
        raise ValueError(
            "{} axes for the inputs {}, wanted one each".format(len(rows), ", ".join(run.axes))
        )
    for column, (axes, axis) in enumerate(zip(rows, run.axes)):
        _draw_curves(axes, run, run.command[:, :, column], marked, drawstyle="steps-post")
        _frame_time(axes, run.time)
        axes.set_ylabel(_input_label(axis, run.axes))
        if axes is not rows[-1]:
            axes.set_xlabel("")
    rows[0].figure.align_ylabels(list(rows))
    if named:
        name_robots(rows[0].figure, list(rows), run.robots)
    return tuple(rows)


@styled
def draw_in_panels(figure, run, most=4):
    """Draw coordinates and inputs of every robot against time below each other; return the axes.

    The inputs are left out where all would be more than ``most`` panels.
    """
    points = points_of(run, None)
    drawn = [("$x$ [m]", points[:, :, 0], {}), ("$y$ [m]", points[:, :, 1], {})]
    drawn += [] if run.z is None else [("$z$ [m]", run.z, {})]
    if len(drawn) + len(run.axes) <= most:
        inputs = [run.command[:, :, column] for column in range(len(run.axes))]
        labels = [_input_label(axis, run.axes) for axis in run.axes]
        drawn += [(*each, {"drawstyle": "steps-post"}) for each in zip(labels, inputs)]
    panels = emptied(figure, len(drawn))
    for axes, (label, values, style) in zip(panels, drawn):
        _draw_curves(axes, run, values, **style)
        _frame_time(axes, run.time)
        axes.set_ylabel(label)
        axes.label_outer()
    figure.align_ylabels(list(panels))
    name_robots(figure, list(panels), run.robots)
    return tuple(panels)


def inputs_height(run):
    """Return the height [in] of the figure of the inputs of ``run``, of the usual width."""
    return max(INPUTS_HEIGHT, INPUT_HEIGHT * len(run.axes))


def _input_label(axis, axes):
    """Return the label of one of the ``axes`` of commands: symbol and unit."""
    part, component = axis.split(".")
    if part + "." == ARM:
        return r"$\dot q_{}$ [rad/s]".format(component)
    if part == "linear":
        return "$v$ [m/s]" if axes == UNICYCLE_AXES else "$v_{}$ [m/s]".format(component)
    return r"$\omega$ [rad/s]" if component == "z" else r"$\omega_{}$ [rad/s]".format(component)


def values_of(run, component):
    """Return ``component`` (x, y or z) of the robots' centres, (m, n) [m]."""
    return run.z if component == "z" else run.pose[:, :, ("x", "y").index(component)]


def _draw_curves(axes, run, values, marked=False, **style):
    """Draw one line per column of ``values`` (m, n) against the run's time; ``marked``: as above."""
    many = values.shape[1] > MOST_IN_LEGEND
    style.update({"lw": 0.7, "alpha": 0.6} if many else {"lw": 1.3})
    if len(values) == 1:
        style["marker"] = "o"
    colours, most = robot_colours(run.robots), most_points(values.shape[1])
    if len(values) > most:
        # Steps between thinned samples would be longer than the true ones.
        style["drawstyle"] = "default"
    lines = [thin(run.time, column, most) for column in values.T]
    release()
    if len(lines) > MOST_LINES and len(values) > 1:
        draw_many(axes, lines, color=colours, **style)
        return
    for row, (line, robot) in enumerate(zip(lines, run.robots)):
        dashes = "-" if many or marked or row < len(PALETTE) else (0, (4, 1, 1, 1))
        marks = marks_of(row, len(lines)) if marked else {}
        look = {"color": colours[row], "ls": dashes, **marks, **style}
        axes.plot(*line, label="Robot {}".format(robot), **look)


def _draw_predicted_curves(axes, time, values):
    """Draw theory's ``values`` (p, n) at ``time`` (p,) as dashed black lines."""
    lines = [thin(time, column, most_points(values.shape[1])) for column in values.T]
    draw_alike(axes, lines, "Theory", color="k", ls=(0, (4, 3)), lw=sized(values, 0.8, 0.5))


def name_robots(figure, panels, robots, more=()):
    """Tell which line is which robot: a legend above the first panel, or a colour bar.

    ``more``: handles with labels of their own for the legend.
    """
    if len(robots) <= MOST_IN_LEGEND:
        legend_above(panels[0], more=more)
        return
    least, most = np.min(robots), np.max(robots)
    scale = ScalarMappable(Normalize(least, most), MANY_ROBOTS)
    scale.set_array([])
    ticks = np.unique(np.linspace(least, most, 6).round())
    figure.colorbar(scale, ax=panels, label="Robot", aspect=30, pad=0.02, ticks=ticks)
    if more or "Theory" in panels[0].get_legend_handles_labels()[1]:
        legend_above(panels[0], ("Theory",), more)


def _frame_time(axes, time):
    begin, end = float(time[0]), float(time[-1])
    if end <= begin:
        begin, end = begin - 0.5, begin + 0.5
    axes.set_xlim(begin, end)
    axes.set_xlabel("time [s]")
