"""``/diagnostics`` of all nodes, subscribed to only while they are shown."""

import threading
import time
from typing import NamedTuple, Tuple

import rospy

from mrs_simulator.ros.message_forms.defined_types import DiagnosticArray
from mrs_simulator.ros.receive.withdrawal import withdraw

TOPIC = "/diagnostics"
LEVELS = ("good", "warning", "error", "stale")  # of diagnostic_msgs, by number
# [s] of wall time: without a message for so long a part is stale, and dropped
OLD, FORGOTTEN = 5.0, 60.0
MOST_PARTS = 500  # [-] kept


class Part(NamedTuple):
    """The last status of one part of a node."""

    name: str  # the node's, with a colon and that of the part
    level: str  # one of ``LEVELS``
    message: str
    values: Tuple[Tuple[str, str], ...]
    age: float  # [s] of wall time
    hardware: str = ""  # the hardware's identifier


class DiagnosticsConnection:
    """``watch`` switches it; ``follow`` and ``close`` are called by one thread only."""

    def __init__(self):
        self._lock, self._parts = threading.Lock(), {}
        self._wanted, self.subscriber = False, None

    def watch(self, wanted):
        """Subscribe from now on, or no longer, at the next ``follow``."""
        self._wanted = wanted

    def follow(self):
        """Subscribe or unsubscribe, as ``watch`` asked for."""
        if self._wanted and self.subscriber is None:
            self.subscriber = rospy.Subscriber(
                TOPIC, DiagnosticArray, self.on_message, queue_size=50
            )
        elif not self._wanted and self.subscriber is not None:
            self.close()

    def on_message(self, message):
        """Keep the statuses in ``message``."""
        now = time.monotonic()
        with self._lock:
            for status in message.status:
                if len(self._parts) < MOST_PARTS or status.name in self._parts:
                    values = tuple((each.key, each.value) for each in status.values)
                    part = status.level, status.message, values, now, status.hardware_id
                    self._parts[status.name] = part

    def parts(self):
        """Return the ``Part``s received within ``FORGOTTEN`` [s], sorted by name."""
        now = time.monotonic()
        with self._lock:
            parts = dict(self._parts)
            for name, part in parts.items():
                if now - part[3] > FORGOTTEN:
                    del self._parts[name]
        return [
            Part(name, _level(level, now - received), message, values, now - received, hardware)
            for name, (level, message, values, received, hardware) in sorted(parts.items())
        ]

    def close(self):
        """Unsubscribe."""
        if self.subscriber is not None:
            withdraw(self.subscriber)
            self.subscriber = None
        with self._lock:
            self._parts.clear()


def _level(level, age):
    """Return the name of the number or byte ``level`` of a part received ``age`` [s] ago."""
    number = level[0] if isinstance(level, bytes) else int(level)
    return LEVELS[-1] if age > OLD or not 0 <= number < len(LEVELS) else LEVELS[number]
