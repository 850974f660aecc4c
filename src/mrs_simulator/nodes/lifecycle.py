"""Starting and ending a node."""

import signal
import threading

import rospy

ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def start_node(name):
    """Join the ROS graph as node ``name``; SIGINT, SIGTERM and SIGHUP end it in good order.

    rospy's own handlers shut down in the middle of whatever the main thread is at, and can so wait
    for a lock that it holds.  Here the shutdown has a thread of its own; ``rospy.is_shutdown()``
    tells the main loop.
    """
    rospy.init_node(name, disable_signals=True)
    for number in ENDINGS:
        signal.signal(number, _end)


def run(spin):
    """Call ``spin``; a topic that the shutdown closes while it publishes is no error."""
    try:
        spin()
    except rospy.ROSException:
        # Topics close before is_shutdown() tells.
        if not rospy.core.is_shutdown_requested():
            raise


def _end(number, _frame):
    reason = "signal {}".format(signal.Signals(number).name)
    threading.Thread(target=rospy.signal_shutdown, args=(reason,)).start()
