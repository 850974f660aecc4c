"""The command ``figure``: one figure of chosen panels, robots and times of a recorded run."""

import argparse
import os

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import FORMATS, LookError, add_width_and_style, look
from mrs_simulator.study.results.report import control_of, read_run
from mrs_simulator.study.results.stamp import stamp_of

PANELS_HELP = "from above: trajectories, x, y, z, inputs; default: x,y"


@printing
def main(argv=None):
    """Run the command ``figure``; exits with 2 for bad input."""
    parser = argparse.ArgumentParser(
        prog=program("figure"),
        description="Draw chosen panels, robots and times of a recorded run as one figure.",
    )
    parser.add_argument("run", help="run.csv or its directory, or a rosbag of a ROS run")
    parser.add_argument("--out", metavar="FILE", required=True, help="its ending: .png, .pdf, .svg")
    parser.add_argument("--panels", default="x,y", help=PANELS_HELP)
    parser.add_argument("--robots", default="", help="their numbers, such as 1,3-5; default: all")
    parser.add_argument(
        "--between",
        nargs=2,
        type=float,
        metavar=("FROM", "TO"),
        help="[s] of the run; default: all",
    )
    parser.add_argument("--no-theory", action="store_true", help="leave out what theory predicts")
    parser.add_argument("--scenario", help="as for report; default: scenario.yaml beside the run")
    add_width_and_style(parser)
    arguments = parser.parse_args(argv)
    with refusing_bad_input("figure"):
        path = _draw(arguments)
    print("  figure: {}".format(os.path.abspath(path)))


def _draw(arguments):
    """Write the figure; return its path."""
    kind = os.path.splitext(arguments.out)[1][1:]
    if kind not in FORMATS:
        wanted = "--out {}: wanted a file that ends in .{}"
        raise LookError(wanted.format(arguments.out, ", .".join(FORMATS)))
    given = arguments.scenario and scenario_path(arguments.scenario)
    run = read_run(arguments.run, given)
    # matplotlib is slow to import: after what may be refused without it.
    from mrs_simulator.study.draw.canvas import save
    from mrs_simulator.study.draw.composed_figure import Choice, composed_figure, numbers_in

    panels = tuple(name.strip() for name in arguments.panels.split(",") if name.strip())
    between = tuple(arguments.between) if arguments.between else None
    choice = Choice(panels, numbers_in(arguments.robots), between)
    own_look = look(arguments.width, arguments.style)
    prediction = None if arguments.no_theory else _prediction(run)
    figure = composed_figure(run, choice, prediction, own_look)
    os.makedirs(os.path.dirname(os.path.abspath(arguments.out)), exist_ok=True)
    return save(figure, arguments.out, stamp_of(run.scenario))


def _prediction(run):
    """Return the points that theory predicts for ``run``, None without a law."""
    control = control_of(run)
    if control is None:
        return None
    from mrs_simulator.verdict.judging import judged

    return judged(run.in_space(control.dimension), control)[1]


if __name__ == "__main__":
    main()
