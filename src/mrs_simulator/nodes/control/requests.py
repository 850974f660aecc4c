"""What a control node is asked by others: to start, to stop, to take another graph."""

import json
import re
import shlex
import sys
import time

import rospy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from mrs_simulator.control.user_code import TimedOut
from mrs_simulator.core.doc_links import explained_by, with_page
from mrs_simulator.core.graphs import Topology
from mrs_simulator.nodes.control.common_frame import START
from mrs_simulator.record.controller_log import EMERGENCY, LAW_FAILED
from mrs_simulator.ros.node.node_parameters import LEAST_DISTANCE, NODES
from mrs_simulator.ros.node.parameters import is_given, read
from mrs_simulator.ros.node.senders import doubled_text
from mrs_simulator.srv import SetTopology

TOPOLOGY_PAGE = "docs/scenarios.md#graphs"
GOES_ON = "running already"
MOTORS_LIMIT = 1.0  # [s] of wall time that the answer to a start waits for the robots' motors
MOTORS_NAP = 0.02  # [s] of wall time


class Requests:
    """The services ``~start``, ``~stop`` and ``~set_topology``, and the topic ``emergency_stop``."""

    def __init__(self, node):
        """``node``: the ``ControlNode`` that is asked."""
        self._node = node
        self._services = [
            rospy.Service("~start", Trigger, self._on_start),
            rospy.Service("~stop", Trigger, self._on_stop),
            rospy.Service("~set_topology", SetTopology, self._on_set_topology),
        ]
        self._emergency_stop = rospy.Subscriber("emergency_stop", Bool, self._on_emergency_stop)

    def _on_emergency_stop(self, message):
        node = self._node
        pressed = message.data and not node.outlet.emergency
        released = node.outlet.emergency and not message.data
        node.outlet.alarm(message.data)
        if pressed:
            rospy.logerr("pioneer_control: emergency stop")
            node.motors.forget()
            node.stop(EMERGENCY)
        elif released and node.trouble == EMERGENCY:
            start = START.format(rospy.resolve_name("~start"))
            node.trouble = "the emergency stop was released, " + start

    def _on_start(self, _):
        node = self._node
        try:
            node.remake_law()
        except (ValueError, TimedOut) as error:
            return False, "{}: {}".format(LAW_FAILED, with_page(error))
        done, said = node.start()
        end = time.monotonic() + MOTORS_LIMIT
        while done and node.running and node.motors.missing() and time.monotonic() < end:
            time.sleep(MOTORS_NAP)  # most answer at once: the caller gets the result
        if done and said != GOES_ON:
            said = node.who_is_silent() or node.motors.missing() or node.guards.text() or "running"
        return done, said

    def _on_stop(self, _):
        self._node.outlet.shut()
        self._node.stop("stopped by request")
        return who_drives_on(self._node.rivals)

    def _on_set_topology(self, request):
        weights = list(request.weight) or [1.0] * len(request.hears)
        if not len(request.hears) == len(request.heard) == len(weights):
            return False, "{} hears, {} heard, {} weights: wanted as many of each".format(
                len(request.hears), len(request.heard), len(request.weight)
            )
        edges = list(zip(request.hears, request.heard, weights))
        try:
            with explained_by(TOPOLOGY_PAGE):
                self._node.set_topology(Topology(self._node.scenario.n, edges, request.directed))
        except ValueError as error:
            return False, with_page(error)
        return True, "{} edges".format(len(edges))


def who_drives_on(rivals):
    """Return whether no node drives the robots now that this node does not, and words for it.

    ``rivals``: other nodes that may, None where this node sent nothing.
    """
    if rivals is None:
        return True, "stopped; in a dry run nothing was sent"
    if not rivals.look():
        return True, "zero commands sent; the master does not answer which other nodes may drive"
    others = doubled_text(rivals.found())
    if others:
        return False, "zero commands sent, but {}: stop the other too".format(others)
    return True, "stopped, zero commands sent"


def how_to_start(protocol):
    """Return the commands with which real robots under ``protocol`` are checked and started.

    What the preflight reads is given as this node has it, by its command line or by a launch file.
    """
    own = [parameter for parameter in NODES["preflight"] if is_given(parameter)]
    if is_given(LEAST_DISTANCE) and not read(LEAST_DISTANCE):  # none is kept: its own is checked
        own.remove(LEAST_DISTANCE)
    set_here = tuple("_{}:=".format(parameter.name) for parameter in own)
    given = [argument for argument in sys.argv[1:] if not argument.startswith(("__", *set_here))]
    if not any(re.match("--protocol|_protocol:=", argument) for argument in given):
        given += ["--protocol", protocol]
    values = [rospy.get_param("~" + parameter.name) for parameter in own]
    texts = [value if isinstance(value, str) else json.dumps(value) for value in values]
    given += map("".join, zip(set_here, texts))
    check = " ".join(map(shlex.quote, ["rosrun", "mrs_simulator", "preflight", *given]))
    return "{}, then: rosservice call {}".format(check, rospy.resolve_name("~start"))
