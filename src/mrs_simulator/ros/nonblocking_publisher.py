"""Publisher for many topics of small messages that never waits for a slow subscriber.

rospy hands each message to a thread of its own for each subscriber, and lets that thread run at once:
with a hundred robots that is most of a publisher's work.
"""

import select
import socket
import threading
import warnings

import rospy

LOOK_PERIOD = 1.0  # [s] of wall time between two looks whether a connection is still there


def prompt_publisher(name, kind, first=None, listener=None):
    """Return a ``rospy.Publisher`` that writes at once to each subscriber that reads.

    One that does not gets the newest message alone, once there is room for it, and delays no other.
    ``first``: returns the message that a new connection is to begin with, or None; ``listener``: a
    ``rospy.SubscribeListener``.
    """
    with warnings.catch_warnings():
        # Without a size rospy makes no queue, and warns of writing that may block: none of ours does.
        warnings.simplefilter("ignore", SyntaxWarning)
        publisher = rospy.Publisher(name, kind, subscriber_listener=listener)
    topic = publisher.impl
    add = topic.add_connection

    def add_prompt(connection):
        # rospy does so only where the subscriber asks for it, and its own subscriber of /clock does not:
        # each small message would wait until the one before is acknowledged, for 40 ms at most.
        connection.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = NonblockingConnection(connection)
        added = add(connection)
        with topic.publock:  # what is published next may not overtake what is the newest now
            message = first and first()
            if message is not None:
                topic.publish(message, connection_override=connection)
        return added

    topic.add_connection = add_prompt
    return publisher


class NonblockingConnection:
    """A rospy connection that never blocks its writer; in the place of rospy's QueuedConnection."""

    def __init__(self, connection):
        """``connection``: rospy's transport to one subscriber."""
        self._connection = connection
        self._room = select.poll()
        self._room.register(connection.fileno(), select.POLLOUT)
        self._changed = threading.Condition()
        self._newest, self._thread = None, None
        self._late = False  # whether the thread has something to write
        self.left_out = 0  # messages so far for which a newer one was written

    def __getattr__(self, name):
        return getattr(self._connection, name)

    def write_data(self, data):
        """Write ``data`` now if there is room, else leave it to a thread, in place of what waits there."""
        with self._changed:
            if not self._late and self._room.poll(0):
                return self._connection.write_data(data)
            self.left_out += self._newest is not None
            self._late, self._newest = True, data
            if self._thread is None:
                self._thread = threading.Thread(target=self._write_late, daemon=True)
                self._thread.start()
            self._changed.notify()
        return True

    def _write_late(self):
        while not self._connection.done:
            with self._changed:
                if self._newest is None:
                    self._late = False
                    self._changed.wait(LOOK_PERIOD)
                data, self._newest = self._newest, None
            if data is not None:
                try:
                    self._connection.write_data(data)
                except Exception as error:  # it closes the connection, which is all there is to do
                    rospy.logdebug("%s: %s", self._connection.name, error)
                    return
