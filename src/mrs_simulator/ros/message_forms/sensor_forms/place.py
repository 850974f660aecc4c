"""Where a robot is and how it stands: compass, altimeter, satellites, motion capture."""

import math

import numpy as np
from geometry_msgs.msg import PointStamped, PoseStamped, PoseWithCovarianceStamped
from sensor_msgs.msg import MagneticField, NavSatFix, NavSatStatus

from mrs_simulator.core.kinematics import yaw
from mrs_simulator.ros.message_forms.sensor_forms.form import BASE, WORLD, Form, diagonal
from mrs_simulator.sensors.types.inertial import AltimeterReading, CompassReading
from mrs_simulator.sensors.types.position import GpsReading, PoseReading

# Variances: of what is not measured, and the smallest published.
UNKNOWN, LEAST = 1e6, 1e-6  # [m^2, rad^2]
FIELD = 2e-5  # [T] the earth's horizontal field as published, about that of middle latitudes


class Heading(Form):
    """MagneticField: the horizontal part of the earth's field alone, in the robot's axes.

    North is along y of the common frame, as for satellites.
    """

    TYPE = "compass"
    FRAME = BASE
    MESSAGE = MagneticField

    def message(self, item, header):
        """Return the ``MagneticField`` at a heading [rad]."""
        message = MagneticField(header=header)
        message.magnetic_field.x = FIELD * math.sin(item[0])
        message.magnetic_field.y = FIELD * math.cos(item[0])
        message.magnetic_field_covariance = diagonal(FIELD**2 * self.variance())
        return message

    def reading(self, message, stamp):
        field = message.magnetic_field
        return CompassReading(stamp, math.atan2(field.x, field.y))


class Height(Form):
    """PointStamped in the common frame: z is the height."""

    TYPE = "altimeter"
    FRAME = WORLD
    MESSAGE = PointStamped

    def message(self, item, header):
        """Return the ``PointStamped`` at a height [m]."""
        message = PointStamped(header=header)
        message.point.z = item[0]
        return message

    def reading(self, message, stamp):
        return AltimeterReading(stamp, message.point.z)


class Fix(Form):
    """NavSatFix of the antenna."""

    TYPE = "gps"
    MESSAGE = NavSatFix

    def message(self, item, header):
        """Return the ``NavSatFix`` at latitude, longitude [deg] and altitude [m]."""
        found, variance = all(map(math.isfinite, item)), self.variance()
        status = NavSatStatus.STATUS_FIX if found else NavSatStatus.STATUS_NO_FIX
        known, kind = (0.0, NavSatFix.COVARIANCE_TYPE_UNKNOWN)
        if found and variance > 0.0:
            known, kind = variance, NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        status = NavSatStatus(status, NavSatStatus.SERVICE_GPS)
        return NavSatFix(header, status, *item, diagonal(known), kind)

    def reading(self, message, stamp):
        """Return the ``GpsReading``; without a fix it is nan."""
        place = message.latitude, message.longitude, message.altitude
        lost = message.status.status < NavSatStatus.STATUS_FIX
        if lost and all(map(math.isfinite, place)):  # the driver repeats its last fix
            place = (math.nan,) * 3
        return GpsReading(stamp, *place)


class Tracked(Form):
    """PoseStamped in the common frame."""

    TYPE = "motion_capture"
    FRAME = WORLD
    MESSAGE = PoseStamped

    def message(self, item, header):
        """Return the ``PoseStamped`` at x, y [m] and theta [rad]."""
        message = PoseStamped(header=header)
        place, turn = message.pose.position, message.pose.orientation
        place.x, place.y, half = item[0], item[1], 0.5 * item[2]
        turn.z, turn.w = math.sin(half), math.cos(half)
        return message

    def reading(self, message, stamp):
        place, turn = message.pose.position, message.pose.orientation
        return PoseReading(stamp, place.x, place.y, yaw(turn.x, turn.y, turn.z, turn.w))


class TrackedSurely(Tracked):
    """PoseWithCovarianceStamped in the common frame, which filters take."""

    SUFFIX = "_with_covariance"
    MESSAGE = PoseWithCovarianceStamped

    def message(self, item, header):
        """Return the ``PoseWithCovarianceStamped`` at x, y [m] and theta [rad]; the rest is unknown."""
        place, turn = (max(self.variance(name), LEAST) for name in ("position", "heading"))
        message = PoseWithCovarianceStamped(header=header)
        message.pose.pose = super().message(item, header).pose
        covariance = np.diag([place, place, UNKNOWN, UNKNOWN, UNKNOWN, turn])
        message.pose.covariance = covariance.ravel().tolist()
        return message

    def reading(self, message, stamp):
        return super().reading(message.pose, stamp)
