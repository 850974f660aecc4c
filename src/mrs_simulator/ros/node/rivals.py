"""Finds other nodes that publish what one node alone may publish."""

import socket
import threading
import time

import rospy

from mrs_simulator.ros.node.master import ANSWER_LIMIT, FAILURES, Master, Transport, asked

LOOK_PERIOD = 1.0  # [s] of wall time between two looks at the master
NAP = 0.05  # [s] likewise, while a node waits for the end of another


class Rivals:
    """Other living nodes that publish ``topics``; it asks the master in a thread of its own."""

    def __init__(self, topics):
        """``topics``: their names, remapped as this node's; the first look is done on return."""
        self.topics = [rospy.resolve_name(topic) for topic in topics]
        self._found, self._master = {}, Master()
        self._looks = 0  # that the master answered
        self._changed, self._asked = threading.Condition(), threading.Event()
        self._look()
        threading.Thread(target=self._watch, daemon=True).start()

    def found(self):
        """Return ``{topic: [nodes]}`` of the topics that others publish too, this node among them."""
        return self._found

    def look(self, limit=2.0 * ANSWER_LIMIT):
        """Look again; return whether the master answered within ``limit`` [s] of wall time."""
        with self._changed:
            before = self._looks
            self._asked.set()
            return self._changed.wait_for(lambda: self._looks > before, limit)

    def _watch(self):
        while not rospy.is_shutdown():
            self._asked.wait(LOOK_PERIOD)
            self._asked.clear()
            self._look()

    def _look(self):
        me = rospy.get_name()
        try:
            published = dict(self._master.ask("getSystemState")[0])
            others = {
                topic: [node for node in published.get(topic, ()) if node != me]
                for topic in self.topics
            }
            living = {node: _is_alive(self._master, node) for node in set().union(*others.values())}
        except FAILURES:
            return  # without a master no new publisher appears
        found = {
            topic: sorted([me, *(node for node in nodes if living[node])])
            for topic, nodes in others.items()
            if any(living[node] for node in nodes)
        }
        with self._changed:
            self._found = found
            self._looks += 1
            self._changed.notify_all()


def _is_alive(master, node):
    """Return whether ``node`` lives: one that was killed stays registered."""
    try:
        asked(master.ask("lookupNode", node), Transport(), "getPid")
    except (socket.timeout, TimeoutError):  # one and the same from Python 3.10 on
        return True  # it takes connections: it may go on at any time
    except FAILURES:
        return False
    return True


def wait_for_end(rivals, limit):
    """Return whether no other node publishes the topics of ``rivals`` within ``limit`` [s]."""
    end = time.monotonic() + limit
    while rivals.found() and time.monotonic() < end:
        rivals.look()
        time.sleep(NAP)
    return not rivals.found()
