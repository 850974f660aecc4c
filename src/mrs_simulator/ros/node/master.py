"""The ROS master, which a node asks again and again at little cost."""

import collections
import http.client
import xmlrpc.client

import rosgraph
import rospy

ANSWER_LIMIT = 1.0  # [s] of wall time for each answer
FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error)


class Master:
    """Asks the master; one thread at a time."""

    def __init__(self):
        self._transports = collections.defaultdict(Transport)

    def ask(self, function, *arguments):
        """Return what the master's ``function`` returns; the same object while its answer is the same.

        Raises one of ``FAILURES``, as where there is no master.
        """
        return asked(rosgraph.get_master_uri(), self._transports[function], function, *arguments)


def asked(uri, transport, function, *arguments):
    """Return what ``function`` of the master or node at ``uri`` returns; raises one of ``FAILURES``."""
    with xmlrpc.client.ServerProxy(uri, transport=transport) as server:
        code, text, value = getattr(server, function)(rospy.get_name(), *arguments)
    if code != 1:
        raise OSError(text)
    return value


class Transport(xmlrpc.client.Transport):
    """Parses an answer only where its text is another than that of the last.

    The master's of a thousand robots takes 30 ms, for which all threads of a node would wait each second.
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
