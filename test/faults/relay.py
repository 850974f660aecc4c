"""A link that can be disturbed: hands messages on, and from SIGUSR1 to SIGUSR2 does worse.

    relay.py FAULT KIND FROM TO [FROM TO ...]

``FAULT``: delay (2 s), duplicate, reorder (pairs swapped), drop half, drop all, no number or no height
(NaN for x, or z, of the position or the velocity); ``KIND``: Odometry or Twist.
"""

import queue
import signal
import sys
import threading
import time

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

DELAY = 2.0  # [s] of wall time


class Link:
    """One topic handed on to another."""

    faulty = False

    def __init__(self, fault, kind, source, target):
        self._fault, self._held, self._count = fault, None, 0
        self._late = queue.Queue()
        self._publisher = rospy.Publisher(target, kind, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber(source, kind, self._on_message, tcp_nodelay=True)
        threading.Thread(target=self._deliver, daemon=True).start()

    def _on_message(self, message):
        self._count += 1
        for each, delay in self._disturbed(message) if Link.faulty else [(message, 0.0)]:
            self._late.put((time.monotonic() + delay, each))

    def _disturbed(self, message):
        """Return what becomes of ``message``: ``(message, delay [s])`` of each that is sent."""
        if self._fault == "delay":
            return [(message, DELAY)]
        if self._fault == "duplicate":
            return [(message, 0.0)] * 2
        if self._fault == "drop half":
            return [(message, 0.0)] if self._count % 2 else []
        if self._fault == "drop all":
            return []
        if self._fault.startswith("no "):
            part = message.linear if hasattr(message, "linear") else message.pose.pose.position
            setattr(part, "z" if self._fault == "no height" else "x", float("nan"))
            return [(message, 0.0)]
        if self._held is None:
            self._held = message
            return []
        held, self._held = self._held, None
        return [(message, 0.0), (held, 0.0)]

    def _deliver(self):
        while True:
            due, message = self._late.get()
            time.sleep(max(0.0, due - time.monotonic()))
            self._publisher.publish(message)


def switch(on):
    Link.faulty = on


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, lambda *_: switch(True))
    signal.signal(signal.SIGUSR2, lambda *_: switch(False))
    rospy.init_node("relay", anonymous=True)
    fault, kind = sys.argv[1], {"Odometry": Odometry, "Twist": Twist}[sys.argv[2]]
    links = [Link(fault, kind, *pair) for pair in zip(sys.argv[3::2], sys.argv[4::2])]
    rospy.spin()
