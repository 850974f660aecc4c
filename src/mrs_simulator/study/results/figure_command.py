"""The command ``figure``: one figure of chosen panels, robots and times of a recorded run."""

import argparse
import os

import numpy as np

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.record.run_changes import changed_by
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import FORMATS, LookError, add_width_and_style, look
from mrs_simulator.study.results.report import control_of, read_run
from mrs_simulator.study.results.stamp import stamp_of

PANELS_HELP = "from above: trajectories, x, y, z, inputs, error; default: x,y"
MOST_ERRORS = 2000  # [-] samples of which the formation error is drawn


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
    parser.add_argument(
        "--compare",
        nargs="+",
        default=[],
        metavar="RUN",
        help="runs that are laid over it, each in a line of its own",
    )
    parser.add_argument(
        "--names",
        nargs="+",
        default=[],
        metavar="NAME",
        help="of the run and those of --compare; default: those of their directories",
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
    from mrs_simulator.study.draw.compared_panels import NamedRun
    from mrs_simulator.study.draw.composed_figure import ERROR, Choice, composed_figure, numbers_in

    panels = tuple(name.strip() for name in arguments.panels.split(",") if name.strip())
    between = tuple(arguments.between) if arguments.between else None
    choice = Choice(panels, numbers_in(arguments.robots), between)
    own_look = look(arguments.width, arguments.style)
    with_theory, with_error = not arguments.no_theory, ERROR in panels
    runs = [run, *(_begun_at(run.time[0], read_run(path)) for path in arguments.compare)]
    errors = [_error(each, with_theory) if with_error else None for each in runs]
    first, *others = map(NamedRun, _names(arguments), runs, errors)
    prediction = _prediction(run) if with_theory and not others else None
    given = first.error, first.name, others
    figure = composed_figure(run, choice, prediction, own_look, *given)
    os.makedirs(os.path.dirname(os.path.abspath(arguments.out)), exist_ok=True)
    return save(figure, arguments.out, stamp_of(run.scenario))


def _names(arguments):
    """Return the names of the run and of those compared with it."""
    paths = [arguments.run, *arguments.compare]
    names = list(arguments.names) or [os.path.basename(os.path.abspath(path)) for path in paths]
    if len(names) != len(paths):
        raise LookError("--names: {} names, wanted {}".format(len(names), len(paths)))
    if len(set(names)) < len(names):
        raise LookError(
            "--names: wanted one for each run, all different: {}".format(", ".join(names))
        )
    return names


def _error(run, with_theory):
    """Return the ``TeamError`` of ``run``, None where its law has none."""
    from mrs_simulator.study.draw.compared_panels import TeamError
    from mrs_simulator.study.run.law_answers import errors, prediction

    if run.scenario is None or run.meta.get("unknown_law"):
        return None
    changes = run.meta.get("changes", [])
    rows = np.unique(np.linspace(0, len(run.time) - 1, MOST_ERRORS).astype(int))
    values = errors(changed_by(run.scenario, changes), run.pose[rows])
    if values is None:
        return None
    theory = None
    if with_theory:
        found = prediction(run.scenario._replace(poses=run.pose[0].copy()))
        if found.error is not None:
            kept = found.time <= (changes[0].time if changes else np.inf)
            theory = found.time[kept] + run.time[0], found.error[kept]
    return TeamError(run.time[rows], values, theory)


def _begun_at(begin, run):
    """Return ``run`` as if it had begun at ``begin`` [s]."""
    run.time = run.time - run.time[0] + begin
    return run


def _prediction(run):
    """Return the points that theory predicts for ``run``, None without a law."""
    control = control_of(run)
    if control is None:
        return None
    from mrs_simulator.verdict.judging import judged

    return judged(run.in_space(control.dimension), control)[1]
