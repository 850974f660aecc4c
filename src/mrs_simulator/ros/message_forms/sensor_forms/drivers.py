"""Sensors as p2os_driver publishes them, which has messages of its own."""

import numpy as np

from mrs_simulator.ros.message_forms.defined_types import P2osBattery, SonarArray
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_forms.form import Form
from mrs_simulator.ros.message_forms.sensor_forms.ranging import SILENT, places_of
from mrs_simulator.sensors.types.battery import BatteryReading
from mrs_simulator.sensors.types.ranging import RangeReading


class Distances(Form):
    """SonarArray: the distance of each transducer up to the last that has fired.

    No echo is published as the greatest distance; of transducers beyond the last nothing is known.
    """

    TYPE = "sonar"
    PUBLISHED = False
    BY_DRIVERS = True
    MESSAGE = SonarArray

    def reading(self, message, stamp):
        places, numbers = places_of(self.mount), self.mount.settings
        received = np.asarray(message.ranges, dtype=float)
        if not len(received):
            raise MessageError("no distances: is the driver's parameter use_sonar true?")
        if len(received) > len(places):
            text = "{} distances, but the mount has {} transducers"
            raise MessageError(text.format(len(received), len(places)))
        ranges = np.full(len(places), np.nan)
        ranges[: len(received)] = np.where(
            received > numbers.most - SILENT, np.inf, np.maximum(received, 0.0)
        )
        return RangeReading(stamp, ranges, places, numbers.most, 0.5 * numbers.cone)


class P2osVoltage(Form):
    """BatteryState of p2os_msgs: the voltage [V] alone."""

    TYPE = "battery"
    PUBLISHED = False
    BY_DRIVERS = True
    SUFFIX = "_state"
    MESSAGE = P2osBattery
    PROVIDES = ("voltage",)

    def reading(self, message, stamp):
        return BatteryReading(stamp, message.voltage, np.nan)
