"""Finds several publishers on a topic meant for one, by the connections of the messages."""

import threading
import time

WINDOW = 1.0  # [s] of wall time within which two nodes count as publishing at the same time


class Senders:
    """Finds topics on which more than one node publishes."""

    def __init__(self):
        self._lock = threading.Lock()
        self._received = {}  # {topic: {node: when last}}

    def note(self, topic, message):
        """Take in that ``message`` came on ``topic``; one that no connection brought is left out."""
        header = getattr(message, "_connection_header", None)
        if header:
            with self._lock:
                nodes_seen = self._received.setdefault(topic, {})
                nodes_seen[header.get("callerid", "a node without a name")] = time.monotonic()

    def doubled(self):
        """Return ``{topic: [nodes]}`` of the topics on which several nodes publish now, sorted."""
        with self._lock:
            since = time.monotonic() - WINDOW
            found = {}
            for topic, nodes_seen in self._received.items():
                if len(nodes_seen) > 1:
                    nodes = sorted(node for node, when in nodes_seen.items() if when >= since)
                    if len(nodes) > 1:
                        found[topic] = nodes
            return found


def doubled_text(doubled):
    """Return the text that names the nodes of ``doubled`` ``{topic: [nodes]}``, "" for none."""
    by_nodes = {}
    for topic, nodes in sorted(doubled.items()):
        by_nodes.setdefault(tuple(nodes), []).append(topic)
    return "; ".join(
        "{} all publish {}{}".format(
            " and ".join(nodes),
            topics[0],
            " and {} more".format(len(topics) - 1) if topics[1:] else "",
        ).replace("all publish", "both publish" if len(nodes) == 2 else "all publish")
        for nodes, topics in by_nodes.items()
    )
