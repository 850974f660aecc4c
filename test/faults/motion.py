"""The robots' own motion: written down as it happens, and judged without a word from any node.

As a program it listens to the true poses of a stage, or to the drivers of robots, and appends lines
``[wall, stamp, [x1, x2, ...], [y1, y2, ...]]`` [s, s, m, m] to a file; of robots that leave the ground
with their heights [m] at the end.
"""

import json
import sys
import time

import numpy as np
from table import WATER

SPEED = 0.2  # [m/s] at which the law drives all robots
FASTEST = 0.25  # [m/s] beyond which nobody may ever be
# [s] of the robots' time in which they stop: watchdog 0.6 s, ramp, margin of two rounds.  Boats are
# told for longer, 1.5 s, and have no brake.
LIMITS = {None: 3.0, WATER: 8.0}
REST = 0.01  # [m] that a robot at rest may creep
SLACK = 0.004  # [m] of poses that are rounded
ROUND = 0.05  # [m] the same of robots that tell their poses one after the other, 10 times a second
SPAN = 0.2  # [s] over which it is measured how fast a robot comes down
RECENT = 1.5  # [s] over which it is said whether a robot moves


class Motion:
    """What the file at ``path`` says so far."""

    def __init__(self, path):
        """Read all whole lines."""
        with open(path) as file:
            lines = [json.loads(line) for line in file if line.endswith("\n")]
        self.wall = np.array([line[0] for line in lines])
        self.stamp = np.array([line[1] for line in lines])
        robots = len(lines[0][2]) if lines else 0
        axes = len(lines[0]) - 2 if lines else 2
        self.place = np.array([line[2:] for line in lines], dtype=float)
        self.place = self.place.reshape(len(lines), axes, robots)

    def since(self, wall):
        """Return the motion from ``wall`` [s] on."""
        return self._rows(self.wall >= wall)

    def until(self, wall):
        """Return the motion up to ``wall`` [s]."""
        return self._rows(self.wall <= wall)

    def after(self, stamp):
        """Return the motion later than ``stamp`` [s] of the robots' time."""
        return self._rows(self.stamp > stamp)

    def _rows(self, rows):
        part = object.__new__(Motion)
        part.wall, part.stamp, part.place = self.wall[rows], self.stamp[rows], self.place[rows]
        return part

    @property
    def span(self):
        """Return how much of the robots' time it covers [s]."""
        return float(self.stamp[-1] - self.stamp[0]) if len(self.stamp) else 0.0

    def lives(self):
        """Return the parts between which the robots' time went back: worlds that began anew."""
        cuts = [0, *(np.flatnonzero(np.diff(self.stamp) < 0.0) + 1), len(self.stamp)]
        return [self._rows(slice(a, b)) for a, b in zip(cuts, cuts[1:])]

    def creep(self):
        """Return how far the robot that moved most came [m], in all."""
        if len(self.stamp) < 2:
            return 0.0
        return float(np.ptp(self.place, axis=0).max())

    def moves(self):
        """Return whether every robot has moved as the law says, lately."""
        recent = self.after(self.stamp[-1] - RECENT) if len(self.stamp) else self
        if recent.span < 0.5 * RECENT:
            return False
        way = np.linalg.norm(recent.place[-1] - recent.place[0], axis=0)
        return bool((way > 0.5 * SPEED * recent.span).all())

    def too_fast(self):
        """Return in words when a robot was faster than any may be, or was not anywhere, or ""."""
        if not np.isfinite(self.place).all():
            return "a pose that is not finite"
        # Those of robots have no time in common: they are stamped where they arrive.
        slack = ROUND if (self.stamp == self.wall).all() else SLACK
        for life in self.lives():
            step = np.diff(life.stamp)
            across = np.diff(life.place[:, :2], axis=0)
            way = np.linalg.norm(across, axis=1).max(axis=1, initial=0.0)
            late = np.flatnonzero(way > FASTEST * step + slack)
            if len(late):
                text = "{:.3f} m in {:.3f} s at {:.2f} s"
                return text.format(way[late[0]], step[late[0]], life.stamp[late[0]])
        return ""

    def climb(self):
        """Return how far [m] a robot has ever been from the height at which it began."""
        return max(float(np.abs(p.place[:, 2:] - p.place[:1, 2:]).max()) for p in self.lives())

    def fall(self):
        """Return the greatest speed [m/s] at which a robot came down, over ``SPAN``."""
        fastest = 0.0
        for life in self.lives():
            later = np.searchsorted(life.stamp, life.stamp + SPAN)
            rows = np.flatnonzero(later < len(life.stamp))
            if len(rows):
                down = life.place[rows, 2] - life.place[later[rows], 2]
                time = life.stamp[later[rows]] - life.stamp[rows]
                fastest = max(fastest, float((down.max(axis=1) / time).max()))
        return fastest

    def landed(self):
        """Return whether every robot stands on the ground."""
        return bool(len(self.place) and (self.place[-1, 2] == 0.0).all())


def listen(path, drivers):
    """Write down the motion of a stage's robots, or of the robots behind ``drivers``' topics."""
    import rospy
    from nav_msgs.msg import Odometry

    from mrs_simulator.msg import TeamState

    file, newest = open(path, "a"), {}

    def note(stamp, *places):
        wall = time.monotonic()
        line = [wall, wall if stamp is None else stamp, *map(list, places)]
        file.write(json.dumps(line) + "\n")
        file.flush()

    def on_pose(message, number):
        newest[number] = message.pose.pose.position
        if len(newest) == len(drivers):
            places = [newest[k] for k in sorted(newest)]
            note(None, [p.x for p in places], [p.y for p in places])

    def on_state(message):
        heights = [message.z] if len(message.z) else []
        note(message.header.stamp.to_sec(), message.x, message.y, *heights)

    rospy.init_node("motion", anonymous=True)
    if drivers:
        for number, name in enumerate(drivers):
            rospy.Subscriber(name, Odometry, on_pose, callback_args=number, queue_size=1)
    else:
        rospy.Subscriber("/stage/state", TeamState, on_state)
    rospy.spin()


if __name__ == "__main__":
    listen(sys.argv[1], sys.argv[2:])
