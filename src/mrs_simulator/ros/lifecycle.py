"""Start and end of a node."""

import contextlib
import gc
import os
import signal
import socket
import threading
import time

import rospy
import rospy.impl.tcpros_base

from mrs_simulator.ros.registration import keep_registered
from mrs_simulator.ros.unknown_parameters import refuse_unknown, warn_of_unknown

# A GUI may crash or be killed: what it started sees that its parent is gone, and ends.
PARENT = "MRS_SIMULATOR_PARENT"
LOOK_PERIOD = 0.5  # [s] of wall time between two looks for the parent
FAREWELL = 5.0  # [s] of wall time for the last commands and for the master's answer
SILENT_PEERS = 86400  # [s] for which a peer that connects and says nothing is kept waiting
NO_TOPICS_IN_LOG = "/rosout_disable_topics_generation"
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def start_node(name, parameters=(), foreign=False):
    """Join the ROS graph as node ``name``; SIGINT, SIGTERM and SIGHUP end it in good order.

    Raises ``ValueError`` for a parameter on the command line that neither the nodes read nor are
    ``parameters``, names of more; a law of one's own may read ``foreign`` ones.

    rospy's own handlers shut down in the middle of whatever the main thread is at, and can so wait
    for a lock that it holds.  Here the shutdown has a thread of its own; ``rospy.is_shutdown()``
    tells the main loop.
    """
    refuse_unknown(parameters, foreign)
    rospy.init_node(name, disable_signals=True)
    _defer_silent_peers()
    warn_of_unknown(parameters)
    # As long as it is not set, rospy asks the master for it at each log message, and a node whose
    # master is out of reach hangs in the first.
    if not rospy.has_param(NO_TOPICS_IN_LOG):
        rospy.set_param(NO_TOPICS_IN_LOG, False)
    rospy.get_param_cached(NO_TOPICS_IN_LOG)
    keep_registered()
    for number in ENDINGS:
        signal.signal(number, _end)
    if os.environ.get(PARENT) == str(os.getppid()):
        threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()


def _defer_silent_peers():
    """Have the kernel keep connections to this node until their first bytes have come.

    rospy reads each new peer's header in the thread that accepts all of them: one that connects and
    says nothing would keep out every later subscriber.
    """
    server = getattr(rospy.impl.tcpros_base._tcpros_server, "tcp_ros_server", None)
    option = getattr(socket, "TCP_DEFER_ACCEPT", None)  # Linux
    if server is not None and option is not None:
        with contextlib.suppress(OSError):
            server.server_sock.setsockopt(socket.IPPROTO_TCP, option, SILENT_PEERS)


def _end_with_parent(parent):
    while os.getppid() == parent:
        time.sleep(LOOK_PERIOD)
    rospy.signal_shutdown("the program that started this node has ended")


def spare_garbage_collection():
    """Have later collections of garbage pass over everything that is there now, since most of it stays.

    To be called once a node has started up, and where its team has changed.  Looking through what 1000
    robots' topics consist of takes 50 ms and more, during which no thread runs.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()


def run(spin):
    """Call ``spin``; a topic that the shutdown closes while it publishes is no error."""
    spare_garbage_collection()
    try:
        spin()
    except rospy.ROSException:
        # Topics close before is_shutdown() tells.
        if not rospy.core.is_shutdown_requested():
            raise


def _end(number, _frame):
    reason = "signal {}".format(signal.Signals(number).name)
    ending = threading.Thread(target=rospy.signal_shutdown, args=(reason,), daemon=True)
    ending.start()
    threading.Thread(target=_end_without_leave, args=(ending,), daemon=True).start()


def _end_without_leave(ending):
    """End though the master does not answer the node's farewell: it may be out of reach for ever."""
    ending.join(FAREWELL)
    rospy.core._shutdown_flag = True
