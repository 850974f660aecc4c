"""What a stage waits for before its first step: commands, and recorders of all that they subscribe to."""

import time

import rospy

from mrs_simulator.ros.node.node_parameters import WAIT_FOR_CONTROL, WAIT_FOR_RECORDERS
from mrs_simulator.ros.node.parameters import read

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


class Readiness:
    """Waits for commands and recorders, as the node's parameters say."""

    def __init__(self):
        self._control = read(WAIT_FOR_CONTROL)
        self._recorders = Recorders(read(WAIT_FOR_RECORDERS))

    def missing(self, stage):
        """Return what is missing, a list of texts, to be asked until there is nothing."""
        lockstep = stage.lockstep
        waits = []
        silent = stage.topics.uncommanded() if (self._control or lockstep) else []
        if silent:
            waits.append("commands for {} of {} robots".format(len(silent), stage.world.n))
        if lockstep and stage.topics.unlistened():
            waits.append("a listener to each robot's odometry")
        elif lockstep and not lockstep.settled():
            waits.append("the first commands")
        missing = self._recorders.missing(*stage.topics.recorders())
        waits += [missing] if missing else []
        return waits
