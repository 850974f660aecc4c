"""A subscription ends without a traceback, wherever the thread that reads it is at that moment."""

import socket
import threading

import pytest
import rospy
import rospy.impl.tcpros_base
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.topics import _SubscriberImpl
from std_msgs.msg import Empty

from mrs_simulator.ros.receive.withdrawal import withdraw


class Held(socket.socket):
    """A socket whose reader goes on, and ends, at once after it has been closed."""

    def close(self):
        super().close()
        self.go.set()
        if threading.current_thread() is not self.reader:
            self.reader.join(1.0)


@pytest.fixture
def link(monkeypatch):
    """Return a subscriber, the thread that reads its only link, and what rospy logged as errors."""
    errors = []
    monkeypatch.setattr(rospy.impl.tcpros_base, "rospyerr", errors.append)
    monkeypatch.setattr(rospy.impl.tcpros_base, "is_shutdown", lambda: False)
    topic = _SubscriberImpl("/topic", Empty)
    topic.ref_count = 1
    subscriber = object.__new__(rospy.Subscriber)
    subscriber.callback = None
    subscriber.impl, subscriber.resolved_name, subscriber.reg_type = topic, "/topic", "sub"
    manager = type("Manager", (), {"release_impl": lambda *_: topic.close()})()
    monkeypatch.setattr(rospy.topics, "get_topic_manager", lambda: manager)
    near, far = socket.socketpair()
    held = Held(near.family, near.type, fileno=near.detach())
    held.go, at_gate = threading.Event(), threading.Event()
    transport = TCPROSTransport(TCPROSSub("/topic", Empty), "/topic")
    transport.socket = held
    receive = transport.receive_once

    def receive_when_let():
        at_gate.set()
        assert held.go.wait(60.0)
        return receive()

    transport.receive_once = receive_when_let
    topic.connections = [transport]
    held.reader = threading.Thread(target=transport.receive_loop, args=(None,), daemon=True)
    held.reader.start()
    assert at_gate.wait(60.0)
    yield subscriber, held, errors
    held.go.set()
    held.reader.join(60.0)
    far.close()


def test_a_reader_that_is_about_to_read_ends_without_a_traceback(link):
    subscriber, held, errors = link
    withdraw(subscriber)
    held.go.set()
    held.reader.join(60.0)
    assert not held.reader.is_alive() and errors == []
    assert subscriber.impl is None


def test_a_link_that_others_share_stays(link):
    subscriber, _, _ = link
    topic = subscriber.impl
    topic.ref_count = 2
    (shared,) = topic.connections
    topic.close = lambda: None
    withdraw(subscriber)
    assert not shared.done and subscriber.impl is None
    shared.done = True
    shared.socket.shutdown(socket.SHUT_RDWR)
