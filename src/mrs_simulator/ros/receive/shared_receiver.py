"""One thread that receives the small messages of many topics.

rospy gives each connection a thread of its own: with a hundred robots' topics most of a node's time is
spent on switching between them.
"""

import contextlib
import select
import threading
import time

import rospy
from rospy.impl.tcpros_base import recv_buff

LOOK_PERIOD = 1.0  # [s] of wall time between two looks whether ROS is shut down
TOGETHER = 0.0005  # [s] of wall time that messages are let come together, as those of a team do
LENGTH = 4  # [-] bytes before each message that state its length


def subscribe(name, kind, callback, argument):
    """Return a ``rospy.Subscriber``, of which only the newest message counts, with rospy's own thread."""
    return rospy.Subscriber(
        name, kind, callback, callback_args=argument, queue_size=1, tcp_nodelay=True
    )


class SharedReceiver:
    """Receives what comes on all topics that it subscribes to, in one thread.

    Whatever goes wrong with a connection is left to rospy, which gets it back.  Where the system has no
    epoll each connection keeps rospy's thread.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._poll = select.epoll() if hasattr(select, "epoll") else None
        self._held = {}  # connection and callback by file number
        self._thread = None

    def subscribe(self, name, kind, callback, argument):
        """Return what ``subscribe`` does; ``callback(message, argument)`` is to be quick."""
        subscriber = subscribe(name, kind, callback, argument)
        topic = subscriber.impl
        add = topic.add_connection

        def add_shared(connection):
            connection.receive_loop = lambda handle: self._take(connection, handle)
            return add(connection)

        if self._poll is not None:
            topic.add_connection = add_shared
        return subscriber

    def _take(self, connection, handle):
        """Receive for ``connection`` from now on; ``handle(messages, connection)`` is rospy's."""
        try:
            connection.socket.setblocking(False)
            _deliver(connection, handle)  # what came together with the connection's header
            with self._lock:
                if self._thread is None:
                    self._thread = threading.Thread(target=self._run, daemon=True)
                    self._thread.start()
                # A connection closed since may have had the same number.
                number = connection.socket.fileno()
                self._held[number] = connection, handle
                self._poll.register(number, select.EPOLLIN)
        except Exception as error:
            _give_back(connection, handle, error)

    def _run(self):
        while not rospy.is_shutdown():
            ready = self._poll.poll(LOOK_PERIOD)
            for number, _ in ready:
                connection, handle = self._held[number]
                try:
                    _receive(connection, handle)
                except Exception as error:
                    self._drop(number, connection)
                    _give_back(connection, handle, error)
            if ready:
                time.sleep(TOGETHER)

    def _drop(self, number, connection):
        with self._lock:
            if self._held[number][0] is connection:
                del self._held[number]
                with contextlib.suppress(OSError):  # closed already
                    self._poll.unregister(number)


def _receive(connection, handle):
    """Read what has come, and call ``handle`` with the messages that are complete."""
    size = connection.protocol.buff_size
    connection.stat_bytes += recv_buff(connection.socket, connection.read_buff, size)
    _deliver(connection, handle)


def _deliver(connection, handle):
    messages = []
    if connection.read_buff.tell() >= LENGTH:
        connection.protocol.read_messages(connection.read_buff, messages, connection.socket)
    if messages and not connection.done:
        connection.stat_num_msg += len(messages)
        for message in messages:
            message._connection_header = connection.header
        if connection.is_latched:
            connection.latch = messages[-1]
        handle(messages, connection)


def _give_back(connection, handle, error):
    """Have rospy go on with ``connection``: it finds the same error, and closes it or connects again."""
    rospy.logdebug("%s: %s", connection.name, error)
    loop = type(connection).receive_loop
    threading.Thread(target=loop, args=(connection, handle), daemon=True).start()
