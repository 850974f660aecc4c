"""The command ``gui``: coordination studies in one window, without ROS."""

import argparse
import sys

from mrs_simulator.core.program import program
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.bad_input import BAD_INPUT, refusing_bad_input

PAPER = "paper.yaml"  # what is opened first


def main(argv=None):
    """Open the window; exits with 2 for bad input and where there is no Qt or no display."""
    parser = argparse.ArgumentParser(
        prog=program("gui"),
        description="Coordination studies in one window, simulated on this computer without ROS.",
        epilog="Real robots, bags and RViz need ROS: there the same window is mrs_gui, or rqt's plugin.",
    )
    parser.add_argument(
        "scenario",
        nargs="?",
        default="",
        help="YAML file, or the name of a shipped one; or a folder of a run or a sweep, or a run.csv",
    )
    parser.add_argument(
        "--fresh", action="store_true", help="without the settings of the last time"
    )
    arguments = parser.parse_args(argv)
    try:
        from mrs_simulator.rqt_plugin.window.main_window import (
            end_program,
            open_application,
            run_window,
            scenario_of_run,
        )
    except ImportError as error:
        print("{}: {}".format(parser.prog, error), file=sys.stderr)
        sys.exit(BAD_INPUT)
    from mrs_simulator.rqt_plugin.local_side.connection import LocalConnection
    from mrs_simulator.rqt_plugin.local_side.processes import LocalProcesses
    from mrs_simulator.rqt_plugin.run.autosave import Autosave
    from mrs_simulator.rqt_plugin.study_widget import StudyWidget

    with refusing_bad_input(parser.prog):
        run, arguments.scenario = scenario_of_run(arguments.scenario)
        scenario = load_scenario(scenario_path(arguments.scenario or PAPER))
        application = open_application(parser.prog)
        connection = LocalConnection()
        processes = LocalProcesses(connection)
        study = StudyWidget(connection, processes, scenario, Autosave())
        code = run_window(application, study, "gui", arguments, run)
        processes.wait_closed()
    end_program(code)
