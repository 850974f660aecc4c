"""The GUI in a window of its own, for systems without rqt."""

import argparse
import os
import subprocess
import sys
import time
from urllib.parse import urlparse

import rosgraph
import rospy

from mrs_simulator.core.doc_links import with_page
from mrs_simulator.ros.node.arguments import DIRECTORY_MEANING, RUN_ARGUMENTS, scenario_from
from mrs_simulator.ros.node.diagnostics import OK, Diagnostics, Health
from mrs_simulator.ros.node.lifecycle import hasten_rospy
from mrs_simulator.rqt_plugin.ros_side.connection import RosConnection
from mrs_simulator.rqt_plugin.ros_side.controller_parameters import SHARED
from mrs_simulator.rqt_plugin.run.autosave import Autosave
from mrs_simulator.rqt_plugin.run.processes import Processes
from mrs_simulator.rqt_plugin.shelf.entry import run_at
from mrs_simulator.rqt_plugin.study_widget import StudyWidget
from mrs_simulator.rqt_plugin.window.main_window import (
    end_program,
    open_application,
    run_window,
    scenario_of_run,
)
from mrs_simulator.study.bad_input import BAD_INPUT, refusing_bad_input

ARGUMENTS = dict(
    RUN_ARGUMENTS, scenario="YAML file (default: the last one)", directory=DIRECTORY_MEANING
)
PARAMETERS = (
    "parameters: the GUI reads none of its own.  Those of the nodes that it starts are listed by "
    "stage --help and pioneer_control --help.  Its check of real robots takes those below "
    "/pioneer_control on the parameter server: {}."
)
MASTER_LIMIT = 15.0  # [s] for a master that is started here


def main():
    """Run the GUI; without a master one is started on this host, and ended with the window."""
    parser = argparse.ArgumentParser(
        prog="mrs_gui",
        description="Coordination studies in one window.",
        epilog=PARAMETERS.format(", ".join(SHARED)),
    )
    parser.add_argument(
        "--fresh", action="store_true", help="without the settings of the last time"
    )
    # Those of the controller that a launch file starts beside it: the check is to be of the same run.
    for name, meaning in ARGUMENTS.items():
        parser.add_argument("--" + name, default="", help=meaning)
    parser.add_argument(
        "run",
        nargs="?",
        default="",
        help="a run to show: its folder, its run.csv, or a bag; or the folder of a sweep",
    )
    arguments, rest = _parsed(parser)
    _refuse_parameters()
    if os.path.isdir(arguments.directory):
        os.chdir(arguments.directory)
    with refusing_bad_input("mrs_gui"):
        run, beside = scenario_of_run(run_at(arguments.run)) if arguments.run else ("", "")
    arguments.scenario = arguments.scenario or beside
    application = open_application("mrs_gui", rest)
    master = None if rosgraph.is_master_online() else _start_master()
    try:
        scenario = scenario_from(arguments)
        hasten_rospy()
        rospy.init_node("mrs_gui", anonymous=True, disable_signals=True)
        Diagnostics(lambda: [Health("", OK, "open", {})])
        processes = Processes()
        study = StudyWidget(RosConnection(), processes, scenario, Autosave())
        code = run_window(application, study, "mrs_gui", arguments, run)
        processes.wait_closed()
    except (ValueError, OSError) as error:
        print("mrs_gui: {}".format(with_page(error)), file=sys.stderr)
        code = 2
    finally:
        rospy.signal_shutdown("window closed")
        if master is not None:
            _end_master(master)
    end_program(code)


def _parsed(parser):
    """Return the arguments, and a list of those for Qt; the value of an option of Qt's is no run."""
    given = rospy.myargv()[1:]
    arguments, rest = parser.parse_known_args(given)
    before = given[max(0, given.index(arguments.run) - 1)] if arguments.run else ""
    if before in rest:
        rest.insert(rest.index(before) + 1, arguments.run)
        arguments.run = ""
    return arguments, rest


def _refuse_parameters():
    """End with a message if a ROS parameter is given, which would not be read."""
    for argument in sys.argv[1:]:
        name, assigned, _ = argument.partition(":=")
        if assigned and name.startswith("_") and not name.startswith("__"):
            text = "mrs_gui: {}: the GUI reads no parameters, wanted an option that --help lists"
            print(text.format(argument), file=sys.stderr)
            sys.exit(BAD_INPUT)


def _start_master():
    """Start a master where ``ROS_MASTER_URI`` says, for this host alone unless ``ROS_HOSTNAME`` is set."""
    os.environ.setdefault("ROS_HOSTNAME", "localhost")
    port = urlparse(rosgraph.get_master_uri()).port or 11311
    master = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    end = time.monotonic() + MASTER_LIMIT
    while not rosgraph.is_master_online():
        if master.poll() is not None or time.monotonic() > end:
            master.kill()
            raise OSError(
                "no ROS master at {}, and none could be started".format(rosgraph.get_master_uri())
            )
        time.sleep(0.1)
    return master


def _end_master(master):
    master.terminate()
    try:
        master.wait(MASTER_LIMIT)
    except subprocess.TimeoutExpired:
        master.kill()
        master.wait()


if __name__ == "__main__":
    main()
