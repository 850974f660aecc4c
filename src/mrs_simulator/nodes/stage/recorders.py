"""Recorders for which a stage waits: all that they subscribe to, not the state alone."""

import time

import rospy

RESTING = 0.3  # [s] of wall time without another connection, after which recorders are complete


class Recorders:
    """Whether as many as wanted subscribe to the state, and to whatever else they record.

    A bag's recorder subscribes to topics one after another, in any order: it is complete when no
    further connection has come for a while.
    """

    def __init__(self, wanted, connections=None, clock=time.monotonic):
        """``wanted``: their number; ``connections()``: how many this node has now; ``clock()`` [s]."""
        self._wanted, self._clock = wanted, clock
        self._connections = connections or _connections
        self._last, self._since = None, 0.0

    def missing(self, subscribed, name):
        """Return what is waited for while ``subscribed`` subscribe to the state ``name``, or ""."""
        if not self._wanted:
            return ""
        if subscribed < self._wanted:
            return "{:g} recorders on {}".format(self._wanted - subscribed, name)
        now, count = self._clock(), self._connections()
        if count != self._last:
            self._last, self._since = count, now
        return "the recorders' other topics" if now - self._since < RESTING else ""


def _connections():
    return len(rospy.topics.get_topic_manager().get_pub_sub_info())
