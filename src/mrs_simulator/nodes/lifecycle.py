"""Starting and ending a node."""

import os
import signal
import threading
import time

import rospy

# A GUI may crash or be killed: what it started sees that its parent is gone, and ends.
PARENT = "MRS_SIMULATOR_PARENT"
LOOK_PERIOD = 0.5  # [s] of wall time between two looks for the parent
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
    if os.environ.get(PARENT) == str(os.getppid()):
        threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()


def _end_with_parent(parent):
    while os.getppid() == parent:
        time.sleep(LOOK_PERIOD)
    rospy.signal_shutdown("the program that started this node has ended")


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
