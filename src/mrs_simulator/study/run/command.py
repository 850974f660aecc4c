"""The commands ``experiment`` and ``sweep``: one headless run, or many.

What runs and judges is imported only once a process apart has begun to load what draws.
"""

import argparse
import contextlib
import os
import signal
import sys

from mrs_simulator.core.garbage import loading
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing
from mrs_simulator.scenario.keys import KEYS
from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.scenario.scenario import OVERRIDES, load_scenario, scenario_of_file
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.figure_process import drawing
from mrs_simulator.study.draw.style import add_look, look_of
from mrs_simulator.study.draw.video import add_video, check_video, write_video
from mrs_simulator.study.results.export import add_exports, check_exports, write_exports
from mrs_simulator.verdict.verdict import add_require_verdict, exit_code, verdict_text


@printing
def main(argv=None):
    """Run the command ``experiment``; exits with 2 for bad input, else with the verdict's code."""
    arguments = _arguments(argv)
    with ending("experiment"):
        check_exports(arguments)
        check_video(arguments)
        look, formats = look_of(arguments)
        if arguments.sweep:
            sys.exit(_sweep(arguments))
        with drawing(formats) as apart:
            with loading():
                from mrs_simulator.study.results.report import control_of, read_run
                from mrs_simulator.study.run.experiment import run_experiment

            options = {"progress": sys.stderr.isatty(), "formats": formats, "look": look}
            scenario = _scenario(arguments)
            _tell_doubts([scenario])
            verdict = run_experiment(scenario, arguments.out, **options, apart=apart, announce=_say)
        written = write_exports(arguments, lambda: read_run(arguments.out), verdict)
        written += write_video(arguments, lambda: read_run(arguments.out), control_of)
    print("  figures and data: {}".format(os.path.abspath(arguments.out)))
    for path in written:
        print("  exported: {}".format(os.path.abspath(path)))
    if verdict["ended"] == "interrupted":
        sys.exit(130)
    sys.exit(exit_code(verdict, arguments.require_verdict))


def _say(verdict):
    """Print the ``verdict`` at once: figures may take as long again."""
    print(verdict_text(verdict), flush=True)


@printing
def sweep_main(argv=None):
    """Run the command ``sweep``: as ``experiment --sweep``, with the axes as arguments."""
    arguments = _sweep_arguments(argv)
    with ending("sweep"):
        sys.exit(_sweep(arguments))


@contextlib.contextmanager
def ending(program):
    """End ``program`` with exit code 2 for bad input, and with 130 when it is interrupted."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        with refusing_bad_input(program):
            yield
    except KeyboardInterrupt:
        sys.exit(130)


def _sweep(arguments):
    """Run the sweep and say how many passed, and why not the others; return the exit code."""
    from mrs_simulator.study.run import sweep

    given = {**_given(arguments, ("robots", *OVERRIDES)), **_settings(arguments)}
    axes = map(sweep.read_axis, arguments.sweep)
    part = sweep.read_part(arguments.part) if arguments.part else None
    listed = {}
    runs = sweep.make_runs(scenario_path(arguments.scenario), axes, given, _noting(listed))
    for robots, scenario in sorted(listed.items())[-1:]:
        _tell_added(scenario, robots)
    _tell_doubts(scenario for _, _, scenario in runs)
    if part is not None and part[1] > len(runs):
        raise sweep.SweepError(
            "--part {}: {} runs, wanted no more parts".format(arguments.part, len(runs))
        )
    table = os.path.join(os.path.abspath(arguments.out), sweep.table_name(part))
    options = (arguments.out, arguments.jobs, arguments.scheduler, sys.stderr.isatty())
    boundary = sweep.theorem_boundary(scenario_path(arguments.scenario), given)
    if arguments.plan:
        from mrs_simulator.study.run.sweep_plan import write_plan

        write_plan(runs, boundary, arguments.out)
    try:
        verdicts = sweep.run_sweep(runs, *options, boundary=boundary, part=part)
    except KeyboardInterrupt:
        text = "experiment: interrupted; what has ended is in {}, the same command does the rest"
        print(text.format(table), file=sys.stderr)
        raise
    drawn = any(key.rpartition(".")[2] == "seed" for key in runs[0][1])
    print("\n".join(sweep.summary(verdicts, drawn)))
    print("  table: {}".format(table))
    drawn = (sweep.FIGURE, "figure"), (sweep.MAP, "stability map")
    for name, what in drawn if part is None else ():
        figure = os.path.join(os.path.dirname(table), name + ".png")
        if os.path.exists(figure):
            print("  {}: {}".format(what, figure))
    codes = [exit_code(verdict, arguments.require_verdict) for verdict in verdicts]
    return 1 if 1 in codes else max(codes)


def _noting(listed):
    """Return a function of a scenario and a number of robots that notes the former by the latter."""
    return lambda scenario, robots: listed.setdefault(robots, scenario)


def _scenario(arguments):
    path, names = scenario_path(arguments.scenario), ["robots", "protocol", *OVERRIDES]
    if arguments.set:
        from mrs_simulator.study.run.sweep import content_of

        settings = _settings(arguments)
        robots = settings.pop("robots", arguments.robots)
        scenario = scenario_of_file(content_of(path, settings), path)
        names.remove("protocol")
    else:
        scenario, robots = load_scenario(path), arguments.robots
    if robots is not None:
        _tell_added(scenario, robots)
    return scenario.overridden(**{**_given(arguments, names), "robots": robots})


def _settings(arguments):
    """Return the values that ``--protocol`` and ``--set`` give, by the paths of keys.

    The name of a key of the scenario is that key, unless it is a parameter of the law.
    """
    from mrs_simulator.protocols.loading import choose_protocol
    from mrs_simulator.study.run.sweep import PARAMETERS, PROTOCOL, content_of, read_setting

    own = {PROTOCOL: arguments.protocol} if arguments.protocol else {}
    given = dict(read_setting(text) for text in arguments.set)
    keys = {PARAMETERS + key: key for key in ("robots", *(field.name for field in KEYS))}
    if set(keys) & set(given):
        path = scenario_path(arguments.scenario)
        _, law = choose_protocol(scenario_of_file(content_of(path, own), path))
        declared = {PARAMETERS + each.name for each in law.PARAMETERS}
        given = {key if key in declared else keys.get(key, key): v for key, v in given.items()}
    if type(given.get("robots", 1)) is not int:
        raise unwanted("--set robots", given["robots"], "a whole number")
    return {**own, **given}


def _tell_doubts(scenarios):
    """Say on stderr what looks like a mistake in ``scenarios``, each once, before anything runs."""
    for text in dict.fromkeys(text for scenario in scenarios for text in scenario.warnings()):
        print("experiment: warning: " + text, file=sys.stderr)


def _tell_added(scenario, robots):
    """Say on stderr what robots that the scenario does not have begin with, and that they lack edges."""
    if robots <= scenario.n:
        return
    lonely = ", without edges of the topology" if scenario.topology else ""
    first = scenario.n + 1
    added = "robots {} to {} are" if robots > first else "robot{} is"
    text = "experiment: {} not in the scenario: put where there is room{}"
    print(text.format(added.format(first, robots), lonely), file=sys.stderr)


def _given(arguments, names):
    """Return the ``arguments`` called ``names`` that are given, by name."""
    values = {name: getattr(arguments, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _arguments(argv):
    parser = argparse.ArgumentParser(
        prog=program("experiment"),
        description="Run a scenario headless, as fast as possible, and write run.csv, "
        "figures and verdict.json. Needs no ROS master.",
    )
    _add_scenario(parser)
    add_exports(parser)
    add_look(parser)
    add_video(parser)
    parser.add_argument(
        "--sweep",
        action="append",
        metavar="KEY=VALUES",
        help="run under all values of a scenario's key: control.parameters.k=0.01,0.02, "
        "seed=0..9 or control.parameters.tau=0.1..1.0/10; may be given several times for all "
        "combinations",
    )
    _add_workers(parser)
    return parser.parse_args(argv)


def _sweep_arguments(argv):
    parser = argparse.ArgumentParser(
        prog=program("sweep"),
        description="Run a scenario under all combinations of its keys' values, in parallel, and write "
        "sweep.csv and its figures.",
    )
    _add_scenario(parser)
    text = "control.parameters.k=0.01,0.02, seed=0..9 or control.parameters.tau=0.1..1.0/10"
    parser.add_argument("sweep", nargs="*", metavar="KEY=VALUES", help=text)
    parser.add_argument(
        "--vary", action="append", default=[], metavar="KEY=VALUES", help="the same, as an option"
    )
    _add_workers(parser)
    # Values may stand anywhere between options.
    arguments = parser.parse_intermixed_args(argv)
    arguments.sweep += arguments.vary
    if not arguments.sweep:
        parser.error("nothing varies: wanted KEY=VALUES or --vary KEY=VALUES")
    return arguments


def _add_scenario(parser):
    """Add the arguments that say what is run, and where it is written."""
    parser.add_argument("scenario", help="YAML file, or the name of a shipped one")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the results")
    parser.add_argument("--robots", type=int, metavar="N", help="number of robots")
    parser.add_argument("--protocol", help="a shipped one, package.module:Class or file.py:Class")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated seconds")
    parser.add_argument("--fidelity", help="kinematic, dynamic or point_mass")
    parser.add_argument("--engine", help="of fidelity dynamic: pybullet or planar")
    parser.add_argument("--odometry", help="world or wheel")
    parser.add_argument("--limits", help="firmware, top or none")
    parser.add_argument("--seed", type=int)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the law, gain=0.3, or any key by its path, mismatch.delay=0.2, robots=5",
    )
    add_require_verdict(parser)


def _add_workers(parser):
    """Add the arguments that say where the runs of a sweep are done."""
    parser.add_argument("--jobs", type=at_least(1), metavar="N", help="processes of a sweep")
    parser.add_argument("--scheduler", default="", help="address of a Dask scheduler for a sweep")
    parser.add_argument(
        "--part",
        default="",
        metavar="I/N",
        help="only the I-th of N parts of a sweep, as a job array runs them; afterwards the same command "
        "without it makes table and figures of all",
    )
    parser.add_argument(
        "--plan",
        action="store_true",
        help="write sweep.json before the runs begin: their directories, and what theory says of each",
    )


def at_least(least):
    """Return the type of a command line's argument that is a whole number of at least ``least``."""

    def count(text):
        if not text.isdecimal() or int(text) < least:
            wanted = "{}: wanted a whole number of at least {}".format(text, least)
            raise argparse.ArgumentTypeError(wanted)
        return int(text)

    return count


if __name__ == "__main__":
    main()
