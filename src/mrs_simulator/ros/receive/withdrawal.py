"""The end of a topic, without a traceback of rospy's own."""

import contextlib
import socket

from rospy import Subscriber


def withdraw(topic):
    """Unregister ``topic``, a ``rospy.Subscriber`` or anything else that has ``unregister``.

    rospy closes a subscriber's socket before it marks the link as done: a thread that is about to read it
    logs a traceback.  Here the link is marked first and its socket shut down, so that its thread ends by
    itself; the socket is closed with the last reference to it.
    """
    links = topic.impl if isinstance(topic, Subscriber) else None
    if links is not None and links.ref_count == 1:  # no other subscriber shares them
        for link in list(links.connections):
            link.done = True
            with contextlib.suppress(AttributeError, OSError):  # not connected, or ended already
                link.socket.shutdown(socket.SHUT_RDWR)
    topic.unregister()
