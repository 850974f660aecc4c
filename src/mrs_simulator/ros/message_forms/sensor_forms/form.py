"""A form: how one type of sensor is published in one type of message."""

import numpy as np

from mrs_simulator.sensors.noise import NOISELESS
from mrs_simulator.sensors.pose_filter.pose_measurements import offset, white
from mrs_simulator.sensors.types import TYPES

# Frames: the mount's, the robot's, the common one, and a camera's with z ahead and x to the right.
OWN, BASE, WORLD, OPTICAL = "own", "base", "world", "optical"
OPTICAL_FRAME = "_optical_frame"  # after the mount's frame


class Form:
    """What the forms have in common; ``frame`` (x, y, z [m], yaw [rad]) is that of ``OWN`` on the robot."""

    TYPE = ""  # of sensor
    PUBLISHED = True  # whether the stage does
    # whether drivers of real robots may publish it instead of what is listened to
    BY_DRIVERS = False
    SUFFIX = ""  # of the topic, after the mount's name
    FRAME = OWN
    MESSAGE = None
    FILLS = ()  # fields of the first form's reading that this one provides instead
    PROVIDES = ()  # fields that this one provides, where it is not all
    SUFFICES = True  # whether these alone are a reading

    def __init__(self, mount, kind):
        """``mount`` on a robot of ``kind``."""
        self.mount, self.kind = mount, kind
        self.noise = dict(mount.noise)

    @staticmethod
    def fits(settings):
        """Return whether sensors with these ``settings`` have this form."""
        return True

    @property
    def frame(self):
        """Return where the frame ``OWN`` lies on the robot: x, y, z [m], yaw [rad]."""
        return self.mount.place

    def rows(self, reading):
        """Return what the messages of the robots of ``reading`` are made of, one item for each."""
        return [list(row) for row in zip(*(getattr(reading, name) for name in reading.PER_ROBOT))]

    def blank(self):
        """Return an item as long as any of ``rows``, of zeros; of samples that differ one is needed."""
        columns = TYPES[self.TYPE].columns(self.mount.settings, self.kind)
        return [np.zeros(width) if width > 1 else 0.0 for width in columns.values()]

    def message(self, item, header):
        """Return the message of one robot's ``item`` of ``rows``."""
        raise NotImplementedError

    def reading(self, message, stamp):
        """Return the reading in ``message``; ``MessageError`` says why it cannot be this sensor's."""
        raise NotImplementedError

    def joined(self, reading, before):
        """Return the ``reading`` of this form; fields that it does not provide are those of ``before``."""
        if before is None or not self.PROVIDES:
            return reading
        provided = {name: getattr(reading, name) for name in ("stamp", *self.PROVIDES)}
        return before._replace(**provided)

    def variance(self, quantity=""):
        """Return the mean square of the errors of the sensor's ``quantity``, when a run begins.

        Of white noise, rounding and a bias; 0, which says unknown, where there is none of them.
        """
        noise = self.noise.get(quantity, NOISELESS)
        return white(noise) + offset(noise)


def diagonal(variance):
    """Return the covariance, 9 numbers, of three components of one ``variance``."""
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
