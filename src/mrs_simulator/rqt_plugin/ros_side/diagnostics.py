"""``/diagnostics`` of all nodes, subscribed to only while somebody looks at it."""

import threading
import time
from typing import NamedTuple, Tuple

import rospy

from mrs_simulator.ros.message_forms.defined_types import DiagnosticArray

TOPIC = "/diagnostics"
LEVELS = ("good", "warning", "error", "stale")  # of diagnostic_msgs, by number
OLD, FORGOTTEN = 5.0, 60.0  # [s] of wall time: without a word for so long a part is stale, and gone
MOST_PARTS = 500  # [-] kept


class Part(NamedTuple):
    """What one part of a node said last."""

    name: str  # the node's, with a colon and that of the part
    level: str  # one of ``LEVELS``
    message: str
    values: Tuple[Tuple[str, str], ...]
    age: float  # [s] of wall time
    hardware: str = ""  # what it is said to be of


class DiagnosticsConnection:
    """``watch`` says whether somebody looks; ``follow`` and ``close`` are for one thread alone."""

    def __init__(self):
        self._lock, self._parts = threading.Lock(), {}
        self._wanted, self.subscriber = False, None

    def watch(self, wanted):
        """Listen from now on, or no more."""
        self._wanted = wanted

    def follow(self):
        """Subscribe or withdraw, as is wanted."""
        if self._wanted and self.subscriber is None:
            self.subscriber = rospy.Subscriber(TOPIC, DiagnosticArray, self._keep, queue_size=50)
        elif not self._wanted and self.subscriber is not None:
            self.close()

    def _keep(self, message):
        now = time.monotonic()
        with self._lock:
            for status in message.status:
                if len(self._parts) < MOST_PARTS or status.name in self._parts:
                    values = tuple((each.key, each.value) for each in status.values)
                    told = status.level, status.message, values, now, status.hardware_id
                    self._parts[status.name] = told

    def parts(self):
        """Return the ``Part`` of each that was heard lately, by name."""
        now = time.monotonic()
        with self._lock:
            parts = dict(self._parts)
            for name, part in parts.items():
                if now - part[3] > FORGOTTEN:
                    del self._parts[name]
        return [
            Part(name, _level(level, now - heard), message, values, now - heard, hardware)
            for name, (level, message, values, heard, hardware) in sorted(parts.items())
        ]

    def close(self):
        """Listen no more."""
        if self.subscriber is not None:
            self.subscriber.unregister()
            self.subscriber = None
        with self._lock:
            self._parts.clear()


def _level(level, age):
    """Return the word for the number or byte ``level`` of a part heard ``age`` [s] ago."""
    number = level[0] if isinstance(level, bytes) else int(level)
    return LEVELS[-1] if age > OLD or not 0 <= number < len(LEVELS) else LEVELS[number]
