"""What a node does once it has started up."""

import gc
import socket
import threading
import time
import weakref

import pytest
import rosgraph.xmlrpc
import rospy.impl.init
from ros_fixtures import PATIENCE, wait_until
from rospy.impl.masterslave import ROSHandler

from mrs_simulator.core.garbage import spare_garbage_collection
from mrs_simulator.ros.node.lifecycle import Doorkeeper, hasten_rospy


class Ring:
    def __init__(self):
        self.me = self


def test_what_is_there_is_spared_until_it_is_looked_through_anew():
    gc.unfreeze()
    try:
        ring = Ring()
        spare_garbage_collection()
        assert gc.get_freeze_count() > 0
        gone = weakref.ref(ring)
        del ring
        gc.collect()
        assert gone() is not None
        spare_garbage_collection()
        assert gone() is not None
        spare_garbage_collection(anew=True)
        assert gone() is None
    finally:
        gc.unfreeze()


@pytest.fixture
def hastened(monkeypatch):
    """``hasten_rospy``, until the test ends."""
    monkeypatch.setattr(rosgraph.xmlrpc.ThreadingXMLRPCServer, "service_actions", None)
    monkeypatch.setattr(ROSHandler, "_shutdown", None)
    monkeypatch.setattr(rospy.impl.init, "time", None)
    hasten_rospy()


def test_a_server_ends_when_its_node_shuts_down(hastened):
    node = rosgraph.xmlrpc.XmlRpcNode()
    serving = threading.Thread(target=node.run, daemon=True)
    serving.start()
    wait_until(lambda: node.uri)
    node.shutdown("test")
    serving.join(PATIENCE)
    assert not serving.is_alive()


class Patient(threading.Condition):
    """One that waits until it is told, however short a wait is asked for."""

    def wait(self, _timeout=None):
        self.waits = True
        return super().wait()


def test_who_connects_topics_ends_when_its_node_shuts_down(hastened):
    handler = ROSHandler("/test", "")
    handler.reg_man.cond = connecting = Patient()
    running = threading.Thread(target=handler.reg_man.run, daemon=True)
    running.start()
    wait_until(lambda: hasattr(connecting, "waits"))
    handler._shutdown("test")
    running.join(PATIENCE)
    assert not running.is_alive()


def test_a_node_looks_often_whether_it_is_registered(hastened):
    begun = time.monotonic()
    rospy.impl.init.time.sleep(PATIENCE)
    assert time.monotonic() - begun < 0.5 * PATIENCE


def test_peers_without_a_header_keep_none_out():
    met, pairs = [], [socket.socketpair() for _ in range(4)]

    def handler(sock, address):
        met.append((address, sock.recv(4)))

    keeper = Doorkeeper(handler, limit=3.0, most=3)
    for address, (ours, _) in enumerate(pairs[:3]):
        keeper(ours, address)
    pairs[2][1].send(b"head")
    wait_until(lambda: met == [(2, b"head")])  # though two before it say nothing
    assert pairs[2][1].send(b"more") == 4
    for address, (_, theirs) in enumerate(pairs[:2]):  # closed in the end
        theirs.settimeout(PATIENCE)
        assert theirs.recv(1) == b"" and wait_until(lambda a=address: (a, b"") in met)


def test_of_too_many_peers_without_a_header_the_first_is_closed():
    pairs = [socket.socketpair() for _ in range(3)]
    keeper = Doorkeeper(lambda sock, _: sock.recv(4), limit=PATIENCE, most=2)
    for ours, _ in pairs:
        keeper(ours, None)
    first = pairs[0][1]
    first.settimeout(PATIENCE)
    assert first.recv(1) == b""
    for _, theirs in pairs[1:]:
        theirs.settimeout(0.05)
        with pytest.raises(socket.timeout):
            theirs.recv(1)
        theirs.send(b"head")
