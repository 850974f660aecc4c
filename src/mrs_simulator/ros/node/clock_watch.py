"""Detects a missing, stalled or doubled /clock."""

import math
import time

import rospy
from rosgraph_msgs.msg import Clock

from mrs_simulator.ros.node.senders import Senders, doubled_text

SILENCE = 1.0  # [s] of wall time without /clock after which the simulator counts as dead
STANDSTILL = 0.5  # [s] of wall time without progress after which real robots are stopped


class ClockWatch:
    """Listens to /clock, which keeps coming with the same time while a simulator is paused."""

    def __init__(self, wake, real):
        """``wake``: called at each message; ``real``: whether real robots, who know no pause, drive."""
        self._wake = wake
        self._patience = STANDSTILL if real else math.inf
        self._time, self._senders = rospy.Time(), Senders()
        self._came = self._changed = time.monotonic()
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=1)

    def trouble(self):
        """Return why no robot can be driven by simulated time now, or ""."""
        now = time.monotonic()
        if now - self._came > SILENCE:
            return "/clock is silent: no simulator is running"
        doubled = doubled_text(self._senders.doubled())
        if doubled:
            return doubled
        if rospy.get_time() == 0.0:
            return "no simulated time on /clock yet"  # odometry may come before it
        if now - self._changed > self._patience:
            return "simulated time stands still, and real robots do not"
        return ""

    def _on_clock(self, message):
        self._came = time.monotonic()
        self._senders.note("/clock", message)
        if message.clock != self._time:
            self._time, self._changed = message.clock, self._came
        self._wake()
