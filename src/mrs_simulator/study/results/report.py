"""Figures and verdict of a run."""

import argparse
import contextlib
import difflib
import math
import os
import sys

from mrs_simulator.control.user_code import call, print_raised
from mrs_simulator.core.claims import proved
from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing, write_text
from mrs_simulator.protocols import HOMES
from mrs_simulator.protocols.loading import load_protocol
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Recorder, RunError, read_run_csv
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import refusing_bad_input
from mrs_simulator.study.draw.style import Look, add_look, look_of
from mrs_simulator.study.draw.video import add_video, check_video, write_video
from mrs_simulator.study.results.export import add_exports, check_exports, write_exports
from mrs_simulator.study.results.ro_crate import CRATE_FILE
from mrs_simulator.study.results.stamp import portable_yaml, stamp_of
from mrs_simulator.study.run.sensor_files import FILE
from mrs_simulator.verdict.certificates import certificate_curves
from mrs_simulator.verdict.judging import judged
from mrs_simulator.verdict.verdict import (
    add_require_verdict,
    exit_code,
    verdict_text,
    write_verdict,
)

RUN_FILE, SCENARIO_FILE, VERDICT_FILE = "run.csv", "scenario.yaml", "verdict.json"
PROVENANCE_FILE = "provenance.json"
OF_RUNS = (VERDICT_FILE, PROVENANCE_FILE, CRATE_FILE)  # what would speak of the run before
CERTIFICATES, VIEW = "certificates", "view"
RUN_ENDINGS = (".csv", ".bag")
VIDEOS = ("run.mp4", "run.gif")
FIGURES = ("trajectories", "x_states", "y_states", "inputs", CERTIFICATES)
FIGURES += ("z_states", "trajectories_in_space")  # of robots off the ground
SETTLED = 0.02  # [-] share of what decays that is left when it counts as settled


def begin_run(scenario, out, robots=None, report=None, layout=None, kept=0, memory=None):
    """Return the ``Recorder`` of a new run in the directory ``out``, beside its ``scenario.yaml``.

    ``robots``: their numbers, by default those of the scenario; ``layout``: the ``Layout`` of their
    columns, by default that of unicycles; ``report``: what the recorder calls with a text when its disk is
    full, and when there is room again; ``kept``: of how many samples it keeps the numbers, and ``memory``:
    where.  The report on an earlier run there goes: it is not one on this.
    """
    robots = range(1, scenario.n + 1) if robots is None else robots
    path = os.path.join(out, RUN_FILE)
    options = {"layout": layout, "kept": kept, "memory": memory}
    recorder = Recorder(path, robots, scenario.hand_length, report, **options)
    remove_results(out)
    write_scenario(scenario, out)
    return recorder


def remove_results(out):
    """Remove what was made of an earlier run in the directory ``out``."""
    for name in os.listdir(out):
        if name in OF_RUNS or is_result(name) or name in VIDEOS:
            os.remove(os.path.join(out, name))


def is_result(name):
    """Return whether a file called ``name`` is a figure of a run, or readings of its sensors."""
    stem, _, kind = name.partition(".")
    drawn = stem in (*FIGURES, VIEW) and kind in ("png", "pdf", "svg")
    return drawn or (stem.startswith(FILE.partition("{}")[0]) and kind == "csv")


def write_scenario(scenario, out):
    """Write ``scenario.yaml`` to ``out``, so that it can be run, or reported on, again; return its path."""
    path = os.path.join(out, SCENARIO_FILE)
    write_text(path, portable_yaml(scenario))
    return path


def write_report(
    run, out, formats=("png", "pdf"), control=None, look=None, apart=None, announce=None
):
    """Write the figures and ``verdict.json`` of ``run`` to ``out``; return the verdict.

    ``control`` makes the claims; without one the run is judged by what needs no theory.  ``look``: how
    figures look, a ``style.Look``, which gets the stamp of the run's scenario where it has none; ``apart``:
    the ``figure_process.Drawing`` that draws them, None to draw them here; ``announce``: called with the
    verdict as soon as its file is written, before figures are.
    """
    run = run if control is None else run.in_space(control.dimension)
    os.makedirs(out, exist_ok=True)
    if formats:
        look = look or Look()
        look = look._replace(stamp=look.stamp or stamp_of(run.scenario))
    if apart is not None and apart.is_able:
        return _write_at_once(run, out, formats, control, look, apart, announce)
    verdict, prediction = judged(run, control)
    _publish(verdict, out, announce)
    if not formats:
        return verdict
    from mrs_simulator.study.draw.figures import figures  # matplotlib is slow to import

    figures(run, out, formats, prediction, look)
    curves = _certificates(run, control)
    if curves:
        from mrs_simulator.study.draw.certificate_figure import save_certificates

        save_certificates(curves, out, formats, look)
    return verdict


def _publish(verdict, out, announce):
    """Write the ``verdict`` to ``out``, and call ``announce`` with it, unless that is None."""
    write_verdict(verdict, os.path.join(out, VERDICT_FILE))
    if announce is not None:
        announce(verdict)


def _write_at_once(run, out, formats, control, look, apart, announce):
    """Judge ``run`` while ``apart`` draws it."""

    def draw(prediction):
        apart.figures(run, out, formats, prediction, look)

    verdict, _ = judged(run, control, draw)
    _publish(verdict, out, announce)
    curves = _certificates(run, control)
    if curves:
        apart.certificates(curves, out, formats, look)
    apart.finish()
    return verdict


def _certificates(run, control):
    """Return the curves that the protocol shows beside theory; a fault of its is printed, and no more."""
    try:
        return call(certificate_curves, control, run) if control is not None else []
    except Exception as error:
        print_raised(error)
        return []


def predicted_settling(control, start):
    """Return in words how long theory says that the team takes from hand points ``start`` (n, d).

    A claimed settling time, or the time for which ``SETTLED`` is left at a claimed decay rate; "" where
    the protocol claims neither, or its conditions do not hold.
    """
    claims = proved(call(control.all_claims, start))
    for claim in claims:
        if claim.name.startswith("settling time"):
            return "{:.3g} s, its settling time".format(claim.predicted)
    for claim in claims:
        if "decay rate" in claim.name and "[1/s]" in claim.name and claim.predicted > 0.0:
            seconds = -math.log(SETTLED) / claim.predicted
            return "{:.3g} s to {:g} %, at {:.3g} /s".format(
                seconds, 100 * SETTLED, claim.predicted
            )
    return ""


def read_run(path, scenario_file=None):
    """Return the ``Run`` in ``path``: a run.csv, its directory, or a rosbag (``.bag``) of a ROS run.

    The scenario is in ``scenario_file``, or ``scenario.yaml`` beside the file; a bag brings its own.
    """
    if not os.path.exists(path):
        raise RunError(_missing(path))
    path = os.path.join(path, RUN_FILE) if os.path.isdir(path) else path
    beside = os.path.join(os.path.dirname(os.path.abspath(path)), SCENARIO_FILE)
    if scenario_file is None and os.path.exists(beside):
        scenario_file = beside
    scenario = load_scenario(scenario_file) if scenario_file else None
    if path.endswith(".bag"):
        from mrs_simulator.study.results.bag_reading import read_bag  # needs ROS

        run = read_bag(path, scenario)
    else:
        run = read_run_csv(path, scenario)
    if scenario is not None and len(run.robots) != scenario.n:
        text = "{}: {} robots, but the scenario {} has {}; wanted the run's own, by --scenario"
        raise RunError(text.format(path, len(run.robots), scenario_file, scenario.n))
    return run


def _missing(path):
    """Return the message that ``path`` has no run, with the nearest one in the nearest directory."""
    above, name = os.path.split(os.path.normpath(path))
    if os.path.splitext(name)[1] in RUN_ENDINGS and not os.path.isdir(above or "."):
        above, name = os.path.split(above)  # of the run's directory, not of its file
    near = difflib.get_close_matches(name, _runs_in(above or "."), n=1)
    hint = "; did you mean {!r}?".format(os.path.join(above, near[0])) if near else ""
    return "{}: no such run{}".format(path, hint)


def _runs_in(directory):
    """Return the names of the runs in ``directory``: directories with a run.csv, and files of runs."""
    with contextlib.suppress(OSError):
        return [
            name
            for name in sorted(os.listdir(directory))
            if os.path.splitext(name)[1] in RUN_ENDINGS
            or os.path.exists(os.path.join(directory, name, RUN_FILE))
        ]
    return []


def control_of(run):
    """Return the control whose claims judge ``run``, None where the scenario names none.

    A scenario that came in a bag may have come from anybody: it names shipped protocols only; nor is a law
    made from a name that only a topic reported.
    """
    scenario = run.scenario
    if scenario is None or (not scenario.path and scenario.control.protocol not in HOMES):
        return None
    if run.meta.get("unknown_law"):
        return None
    return make_control(scenario, load_protocol(scenario.control.protocol, beside=scenario.path))


@printing
def main(argv=None):
    """Run the command ``report``; exits with 2 for bad input, else with the verdict's code."""
    parser = argparse.ArgumentParser(
        prog=program("report"), description="Make the figures and the verdict of a recorded run."
    )
    parser.add_argument("run", nargs="?", help="run.csv or its directory, or a rosbag of a ROS run")
    parser.add_argument(
        "--compare",
        nargs=2,
        metavar=("REAL_RUN", "SIMULATED_RUN"),
        help="lay a run on robots over its simulation, and estimate what differs",
    )
    parser.add_argument(
        "--out", metavar="DIR", help="directory for the results; default: the run's"
    )
    parser.add_argument(
        "--scenario",
        help="YAML file, or the name of a shipped one; default: scenario.yaml beside the run",
    )
    add_look(parser)
    add_video(parser)
    add_require_verdict(parser)
    add_exports(parser)
    arguments = parser.parse_args(argv)
    if (arguments.run is None) == (arguments.compare is None):
        parser.error("wanted a run, or --compare REAL_RUN SIMULATED_RUN")
    if arguments.compare:
        if arguments.out is None:
            parser.error("--compare: wanted --out DIR")
        _compare(arguments)
        return
    if arguments.out is None:
        run = arguments.run
        arguments.out = run if os.path.isdir(run) else os.path.dirname(os.path.abspath(run))
    with refusing_bad_input("report"):
        check_exports(arguments)
        check_video(arguments)
        given = arguments.scenario and scenario_path(arguments.scenario)
        run = read_run(arguments.run, given)
        look, formats = look_of(arguments)
        verdict = write_report(run, arguments.out, formats, control_of(run), look)
        exported = write_exports(arguments, lambda: run, verdict)
        exported += write_video(arguments, lambda: run, control_of)
    print(verdict_text(verdict))
    print("  figures: {}".format(os.path.abspath(arguments.out)))
    for path in exported:
        print("  exported: {}".format(os.path.abspath(path)))
    sys.exit(exit_code(verdict, arguments.require_verdict))


def _compare(arguments):
    from mrs_simulator.study.results.compare import comparison_text, write_comparison

    with refusing_bad_input("report"):
        given = arguments.scenario and scenario_path(arguments.scenario)
        real, simulated = [read_run(path, given) for path in arguments.compare]
        _, formats = look_of(arguments)
        result = write_comparison(real, simulated, arguments.out, formats)
    print(comparison_text(result))
    print("  figure and values: {}".format(os.path.abspath(arguments.out)))
