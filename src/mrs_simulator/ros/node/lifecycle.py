"""Start and end of a node."""

import contextlib
import errno
import os
import signal
import socket
import threading
import time
import types

import rosgraph.xmlrpc
import rospy
import rospy.impl.init
import rospy.impl.tcpros_base
from rospy.impl.masterslave import ROSHandler
from rospy.impl.paramserver import get_param_server_cache

from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.core.program import PARENT
from mrs_simulator.ros.node.registration import keep_registered
from mrs_simulator.ros.node.unknown_parameters import refuse_unknown, warn_of_unknown

LOOK_PERIOD = 0.5  # [s] of wall time between two looks for the parent
FAREWELL = 5.0  # [s] of wall time for the last commands and for the master's answer
HEADER = 10.0  # [s] of wall time in which a peer that connects has to send its header
MOST_PEERS = 100  # [-] that may be about to; with more, the one that connected first is closed
NO_TOPICS_IN_LOG = "/rosout_disable_topics_generation"
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
NAP = 0.005  # [s] of wall time between two looks whether the node is registered
LEAVE = ROSHandler._shutdown  # rospy's


def start_node(name, parameters=(), foreign=False):
    """Join the ROS graph as node ``name``; SIGINT, SIGTERM and SIGHUP end it in good order.

    Raises ``ValueError`` for a parameter on the command line that neither the nodes read nor are
    ``parameters``, names of more; a law of one's own may read ``foreign`` ones.

    rospy's own handlers shut down in the middle of whatever the main thread is at, and can so wait
    for a lock that it holds.  Here the shutdown has a thread of its own; ``rospy.is_shutdown()``
    notifies the main loop.
    """
    refuse_unknown(parameters, foreign)
    hasten_rospy()
    rospy.init_node(name, disable_signals=True)
    _read_log_setting()
    _meet_peers_apart()
    warn_of_unknown(parameters)
    keep_registered()
    for number in ENDINGS:
        signal.signal(number, _end)
    if os.environ.get(PARENT) == str(os.getppid()):
        threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()


def hasten_rospy():
    """Let rospy's nodes begin as soon as they are registered, and end as soon as they are to.

    rospy looks every tenth of a second whether a node is registered.  It tells the thread that connects
    topics to look whether it is to end before it is to, and waits for its next look, half a second later.
    And it closes the socket of the XML-RPC server, and does not end the loop over it: that would poll a
    closed socket, a core busy, from the beginning of the shutdown until the process has ended.
    """
    rospy.impl.init.time = types.SimpleNamespace(sleep=lambda wait: time.sleep(min(wait, NAP)))
    ROSHandler._shutdown = _leave_and_tell
    rosgraph.xmlrpc.ThreadingXMLRPCServer.service_actions = _refuse_closed_socket


def _read_log_setting():
    """Have rospy ask the master neither now nor later for the parameter that each log message goes by.

    As long as it is not set, rospy asks at each message, and a node whose master is out of reach hangs in
    the first.  Where it is set, rospy subscribes to it, and never takes that back: the master would take
    a node that has ended for alive, and tell whoever has its address then to end once its name comes again.
    """
    if not rospy.has_param(NO_TOPICS_IN_LOG):
        rospy.set_param(NO_TOPICS_IN_LOG, False)  # for nodes of others
    get_param_server_cache().set(NO_TOPICS_IN_LOG, rospy.get_param(NO_TOPICS_IN_LOG))


def _leave_and_tell(handler, reason=""):
    left, connecting = LEAVE(handler, reason), handler.reg_man.cond
    with connecting:
        connecting.notify_all()
    return left


def _refuse_closed_socket(server):
    if server.socket.fileno() < 0:
        raise OSError(errno.EBADF, "the server's socket is closed")


def _meet_peers_apart():
    """Have each peer that connects to this node send its header to a thread of its own.

    rospy reads headers in the thread that accepts connections: one peer that never ends its header would
    keep out every later subscriber.
    """
    server = getattr(rospy.impl.tcpros_base._tcpros_server, "tcp_ros_server", None)
    if server is not None:
        server.inbound_handler = Doorkeeper(server.inbound_handler)
        server.server_sock.listen(MOST_PEERS)  # more than rospy's 5 may connect at once


class Doorkeeper:
    """Hands connections to a ``handler``, each in a thread of its own, and closes those that dawdle."""

    def __init__(self, handler, limit=HEADER, most=MOST_PEERS):
        """``handler(sock, address)`` returns once the header is read; ``limit`` [s] of wall time."""
        self._handler, self._limit, self._most = handler, limit, most
        self._lock, self._waiting = threading.Lock(), []

    def __call__(self, sock, address):
        """Take in a connection; return at once."""
        with self._lock:
            self._waiting.append(sock)
            oldest = self._waiting[0] if len(self._waiting) > self._most else None
        if oldest is not None:
            self._turn_away(oldest)
        threading.Thread(target=self._meet, args=(sock, address), daemon=True).start()

    def _meet(self, sock, address):
        timer = threading.Timer(self._limit, self._turn_away, (sock,))
        timer.daemon = True
        timer.start()
        try:
            self._handler(sock, address)
        finally:
            timer.cancel()
            with self._lock:
                if sock in self._waiting:
                    self._waiting.remove(sock)

    def _turn_away(self, sock):
        with self._lock:
            if sock not in self._waiting:
                return  # its header has come
            self._waiting.remove(sock)
            with contextlib.suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)


def _end_with_parent(parent):
    while os.getppid() == parent:
        time.sleep(LOOK_PERIOD)
    rospy.signal_shutdown("the program that started this node has ended")


def run(spin):
    """Call ``spin``; a topic that the shutdown closes while it publishes is no error."""
    spare_garbage_collection()
    try:
        spin()
    except rospy.ROSException:
        # Topics close before is_shutdown() is true.
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
