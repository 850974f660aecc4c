"""Robots and beacons in the range of a sensor: RangeBearing."""

from mrs_simulator.ros.message_forms.messages import (
    MessageError,
    RangeBearing,
    range_bearing,
    read_range_bearing,
)
from mrs_simulator.ros.message_forms.sensor_forms.form import Form
from mrs_simulator.sensors.types.beacons import BeaconReading
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading


class Seen(Form):
    """RangeBearing: bearings from the robot's heading."""

    TYPE = "range_bearing"
    MESSAGE = RangeBearing

    @property
    def frame(self):
        """Return where the sensor is, its axes those of the robot."""
        return (*self.mount.place[:3], 0.0)

    def rows(self, reading):
        """Return numbers, ranges and bearings of the robots that each robot sees."""
        return [reading.of(k)[1:4] for k in range(len(reading.ranges))]

    def message(self, item, header):
        """Return the ``RangeBearing`` of numbers, ranges and bearings."""
        return range_bearing(header, *item)

    def reading(self, message, stamp):
        return RangeBearingReading(stamp, *read_range_bearing(message), self.mount.place[:2])


class BeaconsHeard(Seen):
    """RangeBearing: numbers of beacons; bearings are nan where they are not measured."""

    TYPE = "beacons"

    def reading(self, message, stamp):
        """Return the ``BeaconReading``; ``MessageError`` where the mount has no such beacon."""
        numbers, ranges, bearings = read_range_bearing(message)
        count = len(self.mount.settings.points)
        wrong = numbers[(numbers < 1) | (numbers > count)]
        if len(wrong) or len(set(numbers.tolist())) < len(numbers):
            text = "beacons {}, but the mount has each of 1 to {} once"
            raise MessageError(text.format(", ".join(map(str, numbers)), count))
        return BeaconReading(stamp, numbers, ranges, bearings)
