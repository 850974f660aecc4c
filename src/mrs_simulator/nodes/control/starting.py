"""``run``, with which a user's file ends; ROS is imported when it is called."""

import importlib
import sys

from mrs_simulator.protocols.loading import in_progress

INTERRUPTED = 130  # exit code
NODE = "mrs_simulator.nodes.control.program"
WITHOUT_ROS = (
    "pioneer_control: {}: a control node needs ROS (first: source devel/setup.bash of the workspace); "
    "without ROS: mrs-simulator experiment SCENARIO --protocol {} --out DIR"
)


def run(protocol=None, argv=None):
    """Run the control node with ``protocol``, a ``PioneerControl`` subclass.

    A user's file ends with ``run(MyLaw)``, which does nothing while the file is loaded by its name
    for another program; without a class the command line or the scenario names it.
    """
    if in_progress():
        return
    try:
        node = importlib.import_module(NODE)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except ModuleNotFoundError as error:
        sys.exit(WITHOUT_ROS.format(error, sys.argv[0] or "FILE.py"))
    node.run(protocol, argv)
