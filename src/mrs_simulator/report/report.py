"""From a run to its figures and verdict; the command ``report`` does it from a recording."""

import argparse
import os
import sys

from mrs_simulator.core.recording import read_run_csv
from mrs_simulator.core.scenario import load_scenario
from mrs_simulator.core.verdict import judge, verdict_text, write_verdict

SCENARIO_FILE = "scenario.yaml"


def write_scenario(scenario, out):
    """Write ``scenario.yaml`` beside the run, so that the run can be reported again."""
    with open(os.path.join(out, SCENARIO_FILE), "w", encoding="utf-8") as file:
        file.write(scenario.to_yaml())


def write_report(run, out, formats=("png", "pdf")):
    """Write the figures and ``verdict.json`` of ``run`` to ``out``; return the verdict."""
    from mrs_simulator.report.figures import figures  # matplotlib is slow to import

    verdict = judge(run)
    os.makedirs(out, exist_ok=True)
    write_verdict(verdict, os.path.join(out, "verdict.json"))
    figures(run, out, formats)
    return verdict


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


def main(argv=None):
    """Run the command ``report``; exits with 0 passed, 1 failed verdict, 2 bad input."""
    parser = argparse.ArgumentParser(
        prog="report", description="Make the figures and the verdict of a recorded run."
    )
    parser.add_argument("run", help="run.csv, or a rosbag of a ROS run")
    parser.add_argument("--out", required=True, metavar="DIR", help="directory for the results")
    parser.add_argument("--scenario", help="YAML file; default: scenario.yaml beside the run")
    arguments = parser.parse_args(argv)
    try:
        run = read_run(arguments.run, arguments.scenario)
        verdict = write_report(run, arguments.out)
    except (ValueError, OSError) as error:
        print("report: {}".format(error), file=sys.stderr)
        sys.exit(2)
    print(verdict_text(verdict))
    print("  figures: {}".format(os.path.abspath(arguments.out)))
    sys.exit(0 if verdict["passed"] else 1)


if __name__ == "__main__":
    main()
