"""The robots' own motion: written down as it happens, and judged without a word from any node.

As a program it listens to the true poses of a stage, or to the drivers of robots, and appends lines
``[wall, stamp, [x1, x2, ...], [y1, y2, ...]]`` [s, s, m, m] to a file.
"""

import json
import sys
import time

import numpy as np

SPEED = 0.2  # [m/s] at which the law drives all robots
FASTEST = 0.25  # [m/s] beyond which nobody may ever be
LIMIT = (
    3.0  # [s] of the robots' time in which they stop: watchdog 0.6 s, ramp, margin of two rounds
)
REST = 0.01  # [m] that a robot at rest may creep
SLACK = 0.004  # [m] of poses that are rounded
ROUND = 0.05  # [m] the same of robots that tell their poses one after the other, 10 times a second
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
        places = [[line[2], line[3]] for line in lines]
        self.place = np.array(places, dtype=float).reshape(len(lines), 2, robots)

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
            way = np.linalg.norm(np.diff(life.place, axis=0), axis=1).max(axis=1, initial=0.0)
            late = np.flatnonzero(way > FASTEST * step + slack)
            if len(late):
                text = "{:.3f} m in {:.3f} s at {:.2f} s"
                return text.format(way[late[0]], step[late[0]], life.stamp[late[0]])
        return ""


def listen(path, drivers):
    """Write down the motion of a stage's robots, or of the robots behind ``drivers``' topics."""
    import rospy
    from nav_msgs.msg import Odometry

    from mrs_simulator.msg import TeamState

    file, newest = open(path, "a"), {}

    def note(stamp, x, y):
        wall = time.monotonic()
        file.write(json.dumps([wall, wall if stamp is None else stamp, list(x), list(y)]) + "\n")
        file.flush()

    def on_pose(message, number):
        newest[number] = message.pose.pose.position
        if len(newest) == len(drivers):
            places = [newest[k] for k in sorted(newest)]
            note(None, [p.x for p in places], [p.y for p in places])

    rospy.init_node("motion", anonymous=True)
    if drivers:
        for number, name in enumerate(drivers):
            rospy.Subscriber(name, Odometry, on_pose, callback_args=number, queue_size=1)
    else:
        rospy.Subscriber(
            "/stage/state", TeamState, lambda m: note(m.header.stamp.to_sec(), m.x, m.y)
        )
    rospy.spin()


if __name__ == "__main__":
    listen(sys.argv[1], sys.argv[2:])
