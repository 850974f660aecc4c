"""What decides how a stage starts: other stages, and the rate of odometry."""

import rospy

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.ros.node import node_parameters as declared
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.node.rivals import Rivals, wait_for_end

PREDECESSOR = 5.0  # [s] of wall time that a stage before this one has to end


def odometry_rate(scenario, usual):
    """Return the rate of odometry [Hz], or "kinds": the scenario's, or ``~odom_rate``, else ``usual``."""
    if scenario.odometry_rate is None:
        return read(declared.ODOM_RATE, usual)
    if is_given(declared.ODOM_RATE):
        text = "odom_rate = {:g}: the scenario's odometry_rate is {}; wanted one of them"
        raise ValueError(text.format(read(declared.ODOM_RATE), scenario.odometry_rate))
    return scenario.odometry_rate


@explained_by("docs/troubleshooting.md#on-ros")
def only_stage():
    """Return the ``Rivals`` on /clock; ``ValueError`` names another node that publishes the time.

    One that is about to end, as in a restart, is waited for.
    """
    rivals = Rivals(["/clock"])
    if not wait_for_end(rivals, PREDECESSOR):
        other = next(node for node in rivals.found()["/clock"] if node != rospy.get_name())
        text = "/clock: {0} publishes it already, and simulates; end it first (rosnode kill {0})"
        raise ValueError(text.format(other))
    return rivals
