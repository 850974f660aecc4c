"""Where robots were a moment ago, when their sensors measured.  No Qt."""

from bisect import bisect_left
from collections import deque

from mrs_simulator.core.kinematics import wrap_angle

KEPT = 60  # [-] newest poses, about two seconds of pictures


class RecentPoses:
    """The newest poses of a team, in the order of their times."""

    def __init__(self):
        self._times, self._poses = deque(maxlen=KEPT), deque(maxlen=KEPT)

    def clear(self):
        """Clear everything."""
        self._times.clear()
        self._poses.clear()

    def add(self, time, poses):
        """Add ``poses`` (n, 3) [m, m, rad] of a ``time`` [s]; one that went back begins anew."""
        if self._times and (time < self._times[-1] or len(poses) != len(self._poses[-1])):
            self.clear()
        self._times.append(time)
        self._poses.append(poses)

    def at(self, row, time):
        """Return the pose (3,) of the robot in ``row`` at ``time`` [s], between the poses next to it.

        Before the first and after the last it is these.  Raises ``IndexError`` where there is none.
        """
        place = min(bisect_left(self._times, time), len(self._times) - 1)
        after = self._poses[place][row]
        if place == 0 or time >= self._times[place]:
            return after
        begin, before = self._times[place - 1], self._poses[place - 1][row]
        moved = after - before
        moved[2] = wrap_angle(moved[2])
        return before + (time - begin) / (self._times[place] - begin) * moved
