"""The program ``pioneer_control``: a control node from the command line, or from a user's file."""

import signal
import sys
import threading

from mrs_simulator.control.worker_process import ForkServer
from mrs_simulator.nodes.control.law_client import LawService, is_shipped, speaks_ros
from mrs_simulator.nodes.control.node import ControlNode
from mrs_simulator.protocols.loading import choose_protocol
from mrs_simulator.ros.node import lifecycle
from mrs_simulator.ros.node.arguments import RUN_ARGUMENTS, parse, scenario_from
from mrs_simulator.ros.node.node_parameters import LAW_PROCESS
from mrs_simulator.ros.node.parameters import read
from mrs_simulator.study.bad_input import refusing_bad_input


def run(protocol=None, argv=None):
    """Run the control node with ``protocol``, a ``PioneerControl`` subclass.

    Without one the command line or the scenario names it.
    """
    # Until the node has handlers of its own, an interrupt ends it without a traceback.
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    argv = sys.argv[1:] if argv is None else argv
    local = {k: v for k, v in RUN_ARGUMENTS.items() if protocol is None or k != "protocol"}
    with refusing_bad_input("pioneer_control"):
        arguments = parse("Control of a team of robots over ROS.", local, argv, "pioneer_control")
        scenario, protocol = choose_protocol(scenario_from(arguments), protocol)
        # Before there are threads, which no fork survives.
        fork_server = None if is_shipped(protocol) else ForkServer(lambda: LawService(protocol))
        own = [parameter.name for parameter in protocol.PARAMETERS]
        foreign = protocol.__module__.partition(".")[0] != "mrs_simulator"
        lifecycle.start_node("pioneer_control", own, foreign)
        apart = read(LAW_PROCESS, not speaks_ros(protocol))
        node = ControlNode(scenario, protocol, fork_server if apart else None)
    lifecycle.run(node.spin)


def main():
    """Run the node ``pioneer_control``."""
    run()
