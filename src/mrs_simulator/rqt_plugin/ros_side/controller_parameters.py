"""Parameters of the controller that the check of real robots needs too, without Qt."""

import rospy

from mrs_simulator.ros.node.node_parameters import NODES, REAL
from mrs_simulator.rqt_plugin.run.study_state import USUAL_TOPIC

CONTROLLER = "/pioneer_control"
SHARED = tuple(
    p.name for p in NODES["preflight"] if p in NODES["pioneer_control"] and p is not REAL
)


def has_simulated_time():
    """Return whether ``/use_sim_time`` is true."""
    return bool(rospy.get_param("/use_sim_time", False))


def controller_arguments(topics):
    """Return the arguments that give ``preflight`` the controller's topics and parameters."""
    given = rospy.get_param(CONTROLLER, {})
    arguments = [
        "_{}:={}".format(name, given[name]) for name in SHARED if given.get(name, "") != ""
    ]
    if given.get("min_distance"):  # 0: the controller has none, the check its own
        arguments.append("_min_distance:={}".format(given["min_distance"]))
    if not given.get("odom_topic"):
        for number, topic in sorted(topics.items()):
            usual = USUAL_TOPIC.format(number)
            arguments += ["{}:={}".format(usual, topic)] if topic != usual else []
    return arguments
