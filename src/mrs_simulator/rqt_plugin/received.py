"""The newest that was received of each name, and when; without Qt and ROS."""

import threading
import time

SILENCE = 1.5  # [s] of wall time after which the stage, the controller or a robot counts as silent


class Received:
    """What was received by name, from any thread."""

    def __init__(self):
        self._lock = threading.Lock()
        self._newest, self._received = {}, {}

    def _put(self, name, value):
        """Keep ``value`` as the newest ``name``; for a caller that holds the lock."""
        self._newest[name], self._received[name] = value, time.monotonic()

    def put(self, name, value):
        """Keep ``value`` as the newest ``name``."""
        with self._lock:
            self._put(name, value)

    def newest(self, name):
        """Return what ``Connection.newest`` does."""
        with self._lock:
            return self._newest.get(name)

    def forget(self, name):
        """Drop what was received as ``name``."""
        with self._lock:
            self._received.pop(name, None)
            self._newest.pop(name, None)

    def silence(self, name):
        """Return the wall time [s] since ``name`` was received, None if it never was."""
        with self._lock:
            return time.monotonic() - self._received[name] if name in self._received else None

    def is_fresh(self, name):
        """Return whether ``name`` was received within the last ``SILENCE`` [s] of wall time."""
        with self._lock:
            return time.monotonic() - self._received.get(name, -SILENCE) < SILENCE
