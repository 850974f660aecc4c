"""Wheel encoders."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.sensors.number_texts import number
from mrs_simulator.sensors.types.sensor import Sensor


class EncoderReading(NamedTuple):
    """Distances that wheels have rolled since the run began."""

    stamp: float  # [s]
    travel: np.ndarray  # (..., wheels) [m], as the drive counts them: left and right of an axle

    PER_ROBOT = ("travel",)

    def text(self):
        """Return the distances with their unit."""
        return ", ".join(number(value, 3, " m") for value in self.travel)


class Encoders(Sensor):
    """The distance that each wheel's rim has rolled; ``quantum`` is that of one count."""

    TYPE = "encoders"
    QUANTITIES = {"": "m"}
    RATE = 50.0

    @staticmethod
    def check(kind, where):
        """Raise ``ScenarioError`` where robots of ``kind`` have no wheels."""
        if kind.module.ENCODERS == 0:
            raise ScenarioError("{}: encoders, but a {} has no wheels".format(where, kind.title))

    @staticmethod
    def columns(settings, kind):
        """Return the number of wheels."""
        return {"travel": kind.module.ENCODERS}

    def __init__(self, mount, rows, team):
        """``rows`` (m,) of robots of one drive with this ``mount``."""
        super().__init__(mount, rows, team)
        every = np.arange(team.n)
        (self._group,) = (g for g, group in enumerate(team.groups) if rows[0] in every[group.rows])
        own = every[team.groups[self._group].rows]
        self._inside = np.searchsorted(own, rows)

    def read(self, state, environment, rng):
        travel = state.travel[self._group][self._inside]
        return EncoderReading(state.time, rng.noisy(travel))
