"""One thread receives for many connections; whatever goes wrong with one is rospy's business."""

import io
import socket
import struct
import threading

import pytest
from geometry_msgs.msg import Twist, Vector3
from ros_fixtures import wait_until
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub

from mrs_simulator.ros.message_forms.planar_messages import QuickTwist
from mrs_simulator.ros.receive import shared_receiver


class Connection(TCPROSTransport):
    """A connection of rospy to whoever holds ``far``, the socket's other end."""

    def __init__(self, name):
        protocol = TCPROSSub(name, QuickTwist, queue_size=1, tcp_nodelay=True)
        super().__init__(protocol, name)
        self.socket, self.far = socket.socketpair()
        self.header = {"callerid": name}
        self.given_back = threading.Event()

    def receive_loop(self, heard):
        self.given_back.set()


class Subscriber:
    """In the place of ``rospy.Subscriber``: takes any connection."""

    def __init__(self, name, kind, callback, **more):
        self.impl, self.more = self, more
        self.heard = lambda messages, _: [callback(m, more["callback_args"]) for m in messages]

    def add_connection(self, connection):
        return True


@pytest.fixture
def subscribed(monkeypatch):
    """Return what connects a new topic, and all that was heard, ``[(argument, value)]``."""
    monkeypatch.setattr(shared_receiver.rospy, "Subscriber", Subscriber)
    over, opened = threading.Event(), []
    monkeypatch.setattr(shared_receiver.rospy, "is_shutdown", over.is_set)
    monkeypatch.setattr(shared_receiver, "LOOK_PERIOD", 0.01)
    receiver, heard = shared_receiver.SharedReceiver(), []

    def put(message, argument):
        heard.append((argument, message.values[0], message._connection_header["callerid"]))

    def connect(argument, before=b""):
        topic = receiver.subscribe("/topic", QuickTwist, put, argument)
        connection = Connection("peer{}".format(argument))
        opened.append(connection)
        connection.read_buff.write(before)
        assert topic.impl.add_connection(connection)
        connection.receive_loop(topic.heard)  # as the thread does that has connected
        return connection

    yield connect, heard
    over.set()
    if receiver._thread is not None:
        receiver._thread.join()
    for connection in opened:
        connection.socket.close()
        connection.far.close()


def bytes_of(value):
    data = io.BytesIO()
    Twist(Vector3(value, 0.0, 0.0), Vector3()).serialize(data)
    return struct.pack("<I", len(data.getvalue())) + data.getvalue()


def test_one_thread_receives_all_topics(subscribed):
    connect, heard = subscribed
    before = set(threading.enumerate())  # some of which may be about to end
    connections = [connect(k) for k in range(20)]
    assert len(set(threading.enumerate()) - before) == 1
    for k, connection in enumerate(connections):
        connection.far.sendall(bytes_of(float(k)))
    wait_until(lambda: len(heard) == 20)
    assert sorted(heard) == [(k, float(k), "peer{}".format(k)) for k in range(20)]
    assert all(c.stat_num_msg == 1 and c.stat_bytes == 52 for c in connections)


def test_a_message_may_come_in_parts_and_the_others_do_not_wait_for_it(subscribed):
    connect, heard = subscribed
    slow, other = connect(1), connect(2)
    slow.far.sendall(bytes_of(5.0)[:30])
    other.far.sendall(bytes_of(6.0))
    wait_until(lambda: heard == [(2, 6.0, "peer2")])
    slow.far.sendall(bytes_of(5.0)[30:] + bytes_of(7.0)[:3])
    wait_until(lambda: heard[1:] == [(1, 5.0, "peer1")])
    slow.far.sendall(bytes_of(7.0)[3:])
    wait_until(lambda: heard[2:] == [(1, 7.0, "peer1")])


def test_of_what_came_together_the_newest_counts(subscribed):
    connect, heard = subscribed
    connection = connect(1, before=bytes_of(1.0) + bytes_of(2.0))  # with the header
    assert heard == [(1, 2.0, "peer1")]
    connection.is_latched = True
    connection.far.sendall(bytes_of(3.0))
    wait_until(lambda: len(heard) == 2)
    assert connection.latch.values[0] == 3.0


def test_a_connection_that_ends_or_fails_is_given_back_to_rospy(subscribed, monkeypatch):
    connect, heard = subscribed
    ended, broken, closed, good = (connect(k) for k in range(4))
    monkeypatch.setattr(broken.protocol, "read_messages", lambda *_: 1 / 0)
    ended.far.close()
    broken.far.sendall(bytes_of(1.0))
    assert ended.given_back.wait(30.0) and broken.given_back.wait(30.0)
    # A topic that is withdrawn closes its own end; the next connection may get the same number.
    closed.done = True
    closed.socket.close()
    again = connect(9)
    good.far.sendall(bytes_of(4.0))
    again.far.sendall(bytes_of(5.0))
    wait_until(lambda: len(heard) == 2)
    assert sorted(heard) == [(3, 4.0, "peer3"), (9, 5.0, "peer9")]
    assert not good.given_back.is_set() and not again.given_back.is_set()


def test_without_epoll_each_connection_keeps_its_thread(subscribed, monkeypatch):
    connect, heard = subscribed
    monkeypatch.delattr(shared_receiver.select, "epoll")
    receiver = shared_receiver.SharedReceiver()
    topic = receiver.subscribe("/topic", QuickTwist, None, 1)
    connection = Connection("peer")
    topic.impl.add_connection(connection)
    connection.receive_loop(None)
    assert connection.given_back.is_set()  # by the thread of its own
    connection.socket.close()
    connection.far.close()
