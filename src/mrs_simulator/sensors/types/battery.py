"""Batteries, which drain with use."""

import math
from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.sensors.number_texts import number
from mrs_simulator.sensors.types.sensor import Sensor
from mrs_simulator.vehicles.quantities import quantity

MOST = 1e9  # [J]


class BatterySettings(NamedTuple):
    """Settings of a battery and of what drains it."""

    capacity: float  # [J]
    charge: float  # [-] at the beginning of a run
    idle: float  # [W] at rest
    drive: float  # [J/m] besides, of the way of the centre
    turn: float  # [J/rad] besides, of turning
    voltage: Tuple[float, float]  # [V] empty and full


class BatteryReading(NamedTuple):
    """Charge and voltage."""

    stamp: float  # [s]
    voltage: float  # (...) [V]
    charge: float  # (...) [-] from 0, empty, to 1
    charging: Optional[bool] = None  # whether it is being charged, of real robots that report it

    PER_ROBOT = ("voltage", "charge")

    def text(self):
        """Return the values with their units."""
        parts = [number(self.voltage, 2, " V")]
        if not math.isnan(self.charge):
            parts.append(number(100.0 * self.charge, 0, " %") + " charged")
        if self.charging is not None:
            parts.append("on the charger" if self.charging else "not on the charger")
        return ", ".join(parts)


class Battery(Sensor):
    """A charge that falls by ``idle + drive |v| + turn |omega|`` [W] over the capacity, down to 0.

    Speeds are those at the samples.  The voltage is on a straight line between empty and full, and noisy;
    the charge is not.  An empty battery stops no robot.
    """

    TYPE = "battery"
    QUANTITIES = {"": "V"}
    COLUMNS = {"voltage": 1, "charge": 1}
    RATE = 1.0
    ALWAYS_READ = True  # it drains whether or not it is active

    @staticmethod
    def settings(section):
        """Return the ``BatterySettings`` in a mount's ``section``; defaults are near those of a P3-DX."""
        given, where = section.take("voltage", [11.5, 13.0]), section.at("voltage")
        if not isinstance(given, list) or len(given) != 2:
            raise unwanted(where, given, "[empty, full]")
        low, high = (quantity(each, "V", where, low=0.0) for each in given)
        if low > high:
            raise unwanted(where, given, "that of the empty one first")
        return BatterySettings(
            section.quantity("capacity", "J", 9.0e5, above=0.0, high=MOST),
            section.quantity("charge", "", 1.0, low=0.0, high=1.0),
            section.quantity("idle", "W", 20.0, low=0.0),
            section.quantity("drive", "J/m", 40.0, low=0.0),
            section.quantity("turn", "J/rad", 10.0, low=0.0),
            (low, high),
        )

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self.begin()

    def begin(self):
        """Reset the charge to that at the beginning of a run."""
        self._charge, self._time = np.full(len(self._rows), self._settings.charge), None

    def read(self, state, environment, rng):
        if self._time is not None:
            self._drain(state)
        self._time = state.time
        low, high = self._settings.voltage
        voltage = rng.noisy(low + (high - low) * self._charge)
        return BatteryReading(state.time, voltage, self._charge.copy())

    def _drain(self, state):
        twist, settings = np.abs(state.twist[self._rows]), self._settings
        power = settings.idle + settings.drive * np.hypot(twist[:, 0], twist[:, 1])
        power += settings.turn * twist[:, 2]
        used = power * (state.time - self._time) / settings.capacity
        self._charge = np.maximum(self._charge - used, 0.0)
