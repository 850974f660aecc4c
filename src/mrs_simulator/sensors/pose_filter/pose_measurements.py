"""Measurement models of sensors of the pose: expected values at a pose, their slopes, and their noise.

A measurement has ``values(reading)``, k numbers of a robot's reading, nan where they are lost;
``expected(pose)``, those of robots at ``pose`` (m, 3), (m, k), and their slopes by the pose, (m, k, 3);
``variances`` (k,) of the white noise; ``first``, ``walks`` (k,): variances of the biases at first, and how
fast they grow [1/s]; ``angular`` (k,) bool; and ``groups`` of values that are lost together.
"""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, direction_of, wrap_angle
from mrs_simulator.sensors.noise import NOISELESS
from mrs_simulator.sensors.types.position import local_place

NEAREST = 1e-6  # [m] a beacon at the sensor itself has no direction


def white(noise):
    """Return the variance of the noise that is independent from sample to sample; ``quantum^2 / 12``
    for rounding."""
    return noise.stddev**2 + noise.quantum**2 / 12.0


def offset(noise):
    """Return the variance of the bias at first: of a fixed one, of unknown sign, its own square."""
    return noise.bias**2 + noise.bias_stddev**2


class Measurement:
    """What all measurements have in common."""

    QUANTITIES, ANGULAR = ("",), (False,)

    def __init__(self, mount, repeated=1):
        """``mount`` of the sensor; ``repeated``: how often its ``QUANTITIES`` follow each other."""
        noise = dict(mount.noise)
        self.place = mount.place[:2]
        each = [noise.get(quantity, NOISELESS) for quantity in self.QUANTITIES * repeated]
        self.variances = np.array([white(one) for one in each])
        self.first = np.array([offset(one) for one in each])
        self.walks = np.array([one.bias_walk**2 for one in each])
        self.angular = np.array(self.ANGULAR * repeated)
        self.groups = [list(range(len(each)))]

    @property
    def is_biased(self):
        """Return whether its values have biases, which are to be estimated."""
        return bool((self.first + self.walks).any())

    def off(self, measured, pose):
        """Return how far ``measured`` (m, k) are from what is expected at ``pose``, and the slopes."""
        expected, slope = self.expected(pose)
        off = measured - expected
        off[:, self.angular] = wrap_angle(off[:, self.angular])
        return off, slope


class HeadingMeasurement(Measurement):
    """A compass: theta."""

    ANGULAR = (True,)

    def values(self, reading):
        """Return the heading [rad]."""
        return [reading.heading]

    def expected(self, pose):
        """Return the headings (m, 1) [rad], and their slopes."""
        return pose[:, 2:], np.tile(np.eye(3)[2:], (len(pose), 1, 1))


class PoseMeasurement(Measurement):
    """Motion capture: x, y, theta."""

    QUANTITIES, ANGULAR = ("position", "position", "heading"), (False, False, True)

    def values(self, reading):
        """Return the pose [m, m, rad]."""
        return [reading.x, reading.y, reading.theta]

    def expected(self, pose):
        """Return the poses (m, 3), and their slopes."""
        return pose, np.tile(np.eye(3), (len(pose), 1, 1))


class PositionMeasurement(Measurement):
    """Satellites: the antenna's place, x and y."""

    QUANTITIES, ANGULAR = ("", ""), (False, False)

    def __init__(self, mount):
        super().__init__(mount)
        self._origin = mount.settings.origin

    def values(self, reading):
        """Return the place [m] in the common frame."""
        return local_place(reading, self._origin)[:2]

    def expected(self, pose):
        """Return the antennas' places (m, 2) [m], and their slopes."""
        return carried_place(pose, self.place)


class BeaconMeasurement(Measurement):
    """Ranges, and bearings where they are measured, of K beacons at known places."""

    def __init__(self, mount):
        self._beacons = np.array(mount.settings.points)
        with_bearing = mount.settings.bearing
        self.QUANTITIES = ("range", "bearing") if with_bearing else ("range",)
        self.ANGULAR = (False, True) if with_bearing else (False,)
        super().__init__(mount, len(self._beacons))
        self.groups = [[k] for k in range(len(self.variances))]

    def values(self, reading):
        """Return range [m], and bearing [rad], of each beacon; nan of those not seen."""
        result = np.full((len(self._beacons), len(self.QUANTITIES)), np.nan)
        seen = np.asarray(reading.numbers, dtype=int) - 1
        result[seen, 0] = reading.ranges
        if len(self.QUANTITIES) > 1:
            result[seen, 1] = reading.bearings
        return result.ravel()

    def expected(self, pose):
        """Return ``|b - a|`` and ``atan2(b - a) - theta`` of beacons b seen from a, (m, k), and slopes."""
        origin, carried = carried_place(pose, self.place)
        way = self._beacons - origin[:, np.newaxis]
        far = np.maximum(np.hypot(way[..., 0], way[..., 1]), NEAREST)
        by_origin = -way / far[..., np.newaxis]  # (m, K, 2)
        values, slopes = [far], [by_origin @ carried]
        if len(self.QUANTITIES) > 1:
            values.append(wrap_angle(direction_of(way) - pose[:, 2:]))
            across = np.stack([way[..., 1], -way[..., 0]], axis=-1) / far[..., np.newaxis] ** 2
            slope = across @ carried
            slope[..., 2] -= 1.0
            slopes.append(slope)
        m, k = len(pose), len(self.variances)
        return np.stack(values, axis=2).reshape(m, k), np.stack(slopes, axis=2).reshape(m, k, 3)


def carried_place(pose, place):
    """Return where ``place`` (2,) [m] of robots at ``pose`` (m, 3) is, (m, 2), and its slope (m, 2, 3)."""
    expected, slope = pose[:, :2].copy(), np.tile(np.eye(3)[:2], (len(pose), 1, 1))
    cos, sin = cos_sin(pose[:, 2])
    x, y = place
    ahead, aside = cos * x - sin * y, sin * x + cos * y
    expected[:, 0] += ahead
    expected[:, 1] += aside
    slope[:, 0, 2], slope[:, 1, 2] = -aside, ahead
    return expected, slope


MEASUREMENTS = {
    "beacons": BeaconMeasurement,
    "compass": HeadingMeasurement,
    "gps": PositionMeasurement,
    "motion_capture": PoseMeasurement,
}
