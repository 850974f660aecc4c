"""The figure of two runs laid over each other."""

from mrs_simulator.study.draw.canvas import styled
from mrs_simulator.study.draw.figure_parts import MOST_IN_LEGEND, marks_of, robot_colours


@styled
def draw_comparison(figure, real, simulated, time, apart):
    """Draw the paths of both runs, and below how far apart robots are, (m, n) [m] at ``time`` [s]."""
    figure.clear()
    paths = figure.add_subplot(3, 1, (1, 2))
    below = figure.add_subplot(3, 1, 3)
    is_named = len(real.robots) <= MOST_IN_LEGEND
    for row, colour in enumerate(robot_colours(real.robots)):
        marks = marks_of(row, len(real.robots))
        for run, style in ((simulated, "--"), (real, "-")):
            x, y = run.pose[:, row, :2].T
            paths.plot(x, y, style, color=colour, linewidth=1.0, **marks)
        paths.plot(*real.pose[0, row, :2], "o", color=colour, markersize=3.0)
        label = "robot {}".format(real.robots[row]) if is_named else None
        below.plot(time, apart[:, row], color=colour, linewidth=1.0, label=label, **marks)
    paths.plot([], [], "-", color="black", label="real")
    paths.plot([], [], "--", color="black", label="simulated")
    paths.set_aspect("equal", adjustable="datalim")
    paths.set_xlabel("$x$ [m]")
    paths.set_ylabel("$y$ [m]")
    paths.legend(loc="upper right")
    below.set_xlabel("$t$ [s]")
    below.set_ylabel("apart [m]")
    if is_named:
        below.legend(ncol=4, loc="upper left")
