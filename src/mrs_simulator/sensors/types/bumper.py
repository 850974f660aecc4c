"""Bumpers: sections of a robot's rim that feel contacts."""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.sensors.types.sensor import Sensor

MOST = 32  # [-] sections ahead, and behind


class BumperSettings(NamedTuple):
    """Numbers of sections ahead and behind."""

    front: int
    rear: int


class BumperReading(NamedTuple):
    """Which sections are pressed, each from the robot's left to its right."""

    stamp: float  # [s]
    front: np.ndarray  # (..., front) bool
    rear: np.ndarray  # (..., rear) bool

    PER_ROBOT = ("front", "rear")

    def text(self):
        """Return the numbers of the sections that are pressed."""
        parts = [
            "{} {}".format(side, ", ".join(str(k + 1) for k in np.flatnonzero(sections)))
            for side, sections in (("front", self.front), ("rear", self.rear))
            if np.any(sections)
        ]
        return "pressed: " + "; ".join(parts) if parts else "nothing is touched"


class Bumper(Sensor):
    """A section is pressed where a contact of the last step is seen from the middle of the outline.

    The front sections share the directions from 90 deg on the left to 90 deg on the right equally, the rear
    ones those behind.
    """

    TYPE = "bumper"
    VARIES = True

    @staticmethod
    def settings(section):
        return BumperSettings(
            *(section.whole(key, 5, low=0, high=MOST) for key in ("front", "rear"))
        )

    @staticmethod
    def columns(settings, kind):
        """Return the numbers of sections by name."""
        return settings._asdict()

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self._k = {"robot{}".format(row + 1): k for k, row in enumerate(rows.tolist())}
        bodies = [team.kinds[row].body for row in rows]
        self._ahead = np.array([0.5 * (body.front - body.rear) for body in bodies])

    def read(self, state, environment, rng):
        front, rear = (np.zeros((len(self._rows), count), dtype=bool) for count in self._settings)
        for first, second, x, y, *_ in state.contacts:
            for name in (first, second):
                k = self._k.get(name)
                if k is not None:
                    self._press(front[k], rear[k], self._bearing(state, k, x, y))
        return BumperReading(state.time, front, rear)

    def _bearing(self, state, k, x, y):
        """Return the direction [rad] of the point (x, y) from the middle of a robot's outline."""
        own_x, own_y, theta = state.pose[self._rows[k]].tolist()
        own_x += self._ahead[k] * math.cos(theta)
        own_y += self._ahead[k] * math.sin(theta)
        return float(wrap_angle(math.atan2(y - own_y, x - own_x) - theta))

    @staticmethod
    def _press(front, rear, bearing):
        """Press the section in which ``bearing`` [rad] lies; on a border that to the left of it."""
        ahead = abs(bearing) <= 0.5 * math.pi
        sections = front if ahead else rear
        if not len(sections):
            return
        turned = 0.5 * math.pi - bearing if ahead else (bearing - 0.5 * math.pi) % (2.0 * math.pi)
        sections[min(int(turned / math.pi * len(sections)), len(sections) - 1)] = True
