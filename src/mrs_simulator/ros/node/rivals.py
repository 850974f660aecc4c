"""Finds other nodes that publish what one node alone may publish."""

import contextlib
import http.client
import threading
import time
import xmlrpc.client

import rosgraph
import rospy

LOOK_PERIOD = 1.0  # [s] of wall time between two looks at the master
NAP = 0.05  # [s] likewise, while a node waits for the end of another
ANSWER_LIMIT = 1.0  # [s] of wall time for each answer
FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error)


class Rivals:
    """Other living nodes that publish ``topics``; it asks the master in a thread of its own."""

    def __init__(self, topics):
        """``topics``: their names, remapped as this node's; the first look is done on return."""
        self.topics = [rospy.resolve_name(topic) for topic in topics]
        self._found, self._transport = {}, _Transport()
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
            with _proxy(rosgraph.get_master_uri(), self._transport) as master:
                published = dict(_answer(master.getSystemState(me))[0])
                others = {
                    topic: [node for node in published.get(topic, ()) if node != me]
                    for topic in self.topics
                }
                living = {
                    node: _is_alive(master, me, node) for node in set().union(*others.values())
                }
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


class _Transport(xmlrpc.client.Transport):
    """Parses an answer only where its text is another than that of the last.

    The master's of a thousand robots takes 30 ms, for which the loop of a node would wait each second.
    """

    accept_gzip_encoding = False  # the same answer is another text when it is packed later

    def __init__(self):
        super().__init__()
        self._last = None, None  # a text, and what it says

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = ANSWER_LIMIT
        return connection

    def parse_response(self, response):
        text = response.read()
        if text != self._last[0]:
            parser, unmarshaller = self.getparser()
            parser.feed(text)
            parser.close()
            self._last = text, unmarshaller.close()
        return self._last[1]


@contextlib.contextmanager
def _proxy(uri, transport=None):
    with xmlrpc.client.ServerProxy(uri, transport=transport or _Transport()) as proxy:
        yield proxy


def _answer(reply):
    code, text, value = reply
    if code != 1:
        raise OSError(text)
    return value


def _is_alive(master, me, node):
    """Return whether ``node`` lives: one that was killed stays registered."""
    try:
        with _proxy(_answer(master.lookupNode(me, node))) as other:
            _answer(other.getPid(me))
    except TimeoutError:
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
