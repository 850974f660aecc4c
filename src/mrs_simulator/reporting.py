"""From a run to its figures and its verdict against the protocol's own claims."""

import argparse
import os
import sys

from mrs_simulator.control.library import HOMES
from mrs_simulator.control.loading import choose_protocol, load_protocol
from mrs_simulator.core.recording import read_run_csv
from mrs_simulator.core.scenario import load_scenario
from mrs_simulator.core.verdict import judge, verdict_text, write_verdict
from mrs_simulator.world.robots import limits_of_team

SCENARIO_FILE = "scenario.yaml"


def make_control(scenario, protocol=None):
    """Return the control of the scenario's robots, by ``protocol`` or the one it names."""
    scenario, protocol = choose_protocol(scenario, protocol)
    limits = None if scenario.fidelity == "point_mass" else scenario.limits
    return protocol(
        numbers=range(1, scenario.n + 1),
        topology=scenario.topology,
        limits=limits_of_team(scenario.kinds, limits),
        saturation=scenario.control.saturation,
        parameters=scenario.control.parameters,
        period=1.0 / scenario.control.rate,
        fidelity=scenario.fidelity,
    )


def write_scenario(scenario, out):
    """Write ``scenario.yaml`` beside the run, so that the run can be reported again."""
    with open(os.path.join(out, SCENARIO_FILE), "w", encoding="utf-8") as file:
        file.write(scenario.to_yaml())


def write_report(run, out, formats=("png", "pdf"), control=None):
    """Write the figures and ``verdict.json`` of ``run`` to ``out``; return the verdict.

    ``control`` makes the claims; without one the run is judged by what needs no theory.
    """
    from mrs_simulator.report.figures import figures  # matplotlib is slow to import

    verdict, prediction = judged(run, control)
    os.makedirs(out, exist_ok=True)
    write_verdict(verdict, os.path.join(out, "verdict.json"))
    figures(run, out, formats, prediction)
    return verdict


def judged(run, control=None):
    """Return the verdict on ``run`` and the hand points that theory predicts, (m, n, 2) or None."""
    if control is None:
        return judge(run), None
    start = run.hand[0]
    # A common factor for the whole team only re-times the motion: theory still speaks of it.
    limits = None if control.saturation == "team" else control.limits
    verdict = judge(run, control.claims(start), control.measures(run), limits)
    return verdict, control.prediction(start, run.time - run.time[0])


def read_run(path, scenario_path=None):
    """Return the ``Run`` in ``path``: a run.csv, or a rosbag (``.bag``) of a ROS run.

    The scenario is ``scenario_path``, or ``scenario.yaml`` beside the file; a bag brings its own.
    """
    beside = os.path.join(os.path.dirname(os.path.abspath(path)), SCENARIO_FILE)
    if scenario_path is None and os.path.exists(beside):
        scenario_path = beside
    scenario = load_scenario(scenario_path) if scenario_path else None
    if path.endswith(".bag"):
        from mrs_simulator.report.bag import read_bag  # needs ROS

        return read_bag(path, scenario)
    return read_run_csv(path, scenario)


def control_of(run):
    """Return the control whose claims judge ``run``, None where the scenario names none.

    A scenario that came in a bag may have come from anybody: it names shipped protocols only.
    """
    scenario = run.scenario
    if scenario is None or (not scenario.path and scenario.control.protocol not in HOMES):
        return None
    return make_control(scenario, load_protocol(scenario.control.protocol, beside=scenario.path))


def main(argv=None):
    """Run the command ``report``; exits with 0 passed, 1 failed verdict, 2 bad input."""
    parser = argparse.ArgumentParser(
        prog="report", description="Make the figures and the verdict of a recorded run."
    )
    parser.add_argument("run", help="run.csv, or a rosbag of a ROS run")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the results")
    parser.add_argument("--scenario", help="YAML file; default: scenario.yaml beside the run")
    parser.add_argument("--formats", default="png,pdf", help="of figures: png, pdf, svg")
    arguments = parser.parse_args(argv)
    try:
        run = read_run(arguments.run, arguments.scenario)
        formats = [kind for kind in arguments.formats.split(",") if kind]
        verdict = write_report(run, arguments.out, formats, control_of(run))
    except (ValueError, OSError) as error:
        print("report: {}".format(error), file=sys.stderr)
        sys.exit(2)
    print(verdict_text(verdict))
    print("  figures: {}".format(os.path.abspath(arguments.out)))
    sys.exit(0 if verdict["passed"] else 1)


if __name__ == "__main__":
    main()
