"""Pacing simulated time against the wall clock, and measuring the factor achieved."""

import time

LARGEST_DEBT = 0.2  # [s] of wall time; a stall beyond this is forgotten, not caught up in a burst
UNHURRIED = 2.0  # [-] times real time, at which numpy keeps up
WINDOW = 1.0  # [s] of wall time over which the achieved factor is measured


class Pacer:
    """Says when the next step of simulated time is due."""

    def __init__(self, speed):
        """``speed``: simulated over wall time, 0 = as fast as possible."""
        self.real_time_factor = 0.0
        self._window_start = time.monotonic()
        self._window_simulated = 0.0
        self.set_speed(speed)

    def set_speed(self, speed):
        """Change the speed from now on."""
        self.speed = speed
        self._due = time.monotonic()

    def resume(self):
        """Start counting from now, after a pause."""
        self._due = time.monotonic()

    @property
    def unhurried(self):
        """Return whether steps are watched, and so slow that none has to be compiled."""
        return 0.0 < self.speed <= UNHURRIED

    def wait(self):
        """Return the wall time [s] until the next step is due; 0 if it is."""
        return 0.0 if self.speed == 0.0 else max(0.0, self._due - time.monotonic())

    def stepped(self, duration):
        """Count a step of ``duration`` [s] of simulated time."""
        now = time.monotonic()
        if self.speed > 0.0:
            self._due = max(self._due, now - LARGEST_DEBT) + duration / self.speed
        self._window_simulated += duration
        self.measure()

    def measure(self):
        """Bring ``real_time_factor`` up to date; also to be called while nothing moves."""
        now = time.monotonic()
        if now - self._window_start >= WINDOW:
            self.real_time_factor = self._window_simulated / (now - self._window_start)
            self._window_start, self._window_simulated = now, 0.0
