"""Sonars and lasers: PointCloud, PointCloud2, Range and LaserScan."""

import numpy as np
from sensor_msgs.msg import LaserScan, PointCloud2, PointField, Range

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_forms.cloud import Cloud
from mrs_simulator.ros.message_forms.sensor_forms.form import Form
from mrs_simulator.sensors.placing import echoes
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.sensors.types.ranging import RangeReading

SILENT = 1e-5  # [m] short of the greatest distance, from which on there was no echo
ASIDE = 0.05  # [m] by which an echo may lie beside its transducer's direction
TURNED = 1e-3  # [rad] by which all rays may be turned from the mount's, or one step


class SonarCloud(Form):
    """Echoes in the robot's axes, z 0, in a frame at the sonar's height, as RosAria publishes them.

    No echo is published as the greatest distance, a lost one as nan.  RosAria publishes one
    that has not fired yet, or is not there, at the robot's centre: it is lost, too.
    """

    TYPE = "sonar"
    MESSAGE = Cloud

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        self._places, self._most = places_of(mount), mount.settings.most
        self._along = np.column_stack(cos_sin(self._places[:, 2]))

    @property
    def frame(self):
        """Return where the frame lies: straight above the robot's centre."""
        return (0.0, 0.0, self.mount.place[2], 0.0)

    def rows(self, reading):
        """Return points (m, K, 3) [m]."""
        points = np.zeros((*reading.ranges.shape, 3), dtype=np.float32)
        points[..., :2] = echoes(np.minimum(reading.ranges, self._most), self._places)
        return points

    def message(self, item, header):
        return Cloud(header, item)

    def reading(self, message, stamp):
        """Return the ``RangeReading`` in a PointCloud; one without an echo of any is refused."""
        count = len(self._places)
        if len(message.points) != count:
            text = "{} echoes, but the mount has {} transducers"
            raise MessageError(text.format(len(message.points), count))
        points = np.asarray(message.points, dtype=float)[:, :2]
        silent = (points == 0.0).all(axis=1)
        if silent.all():
            raise MessageError("no transducer has fired yet")
        way = np.where(silent[:, np.newaxis], np.nan, points - self._places[:, :2])
        ranges = (way * self._along).sum(axis=1)
        aside = way[:, 0] * self._along[:, 1] - way[:, 1] * self._along[:, 0]
        wrong = np.flatnonzero((np.abs(aside) > ASIDE) | (ranges < -ASIDE))
        if len(wrong):
            text = "echo {} at ({:.3g}, {:.3g}) m is not where the mount's transducer looks"
            raise MessageError(text.format(wrong[0] + 1, *message.points[wrong[0]][:2]))
        ranges[ranges > self._most - SILENT] = np.inf
        cone = 0.5 * self.mount.settings.cone
        return RangeReading(stamp, np.maximum(ranges, 0.0), self._places, self._most, cone)


class SonarCloud2(SonarCloud):
    """The same points as PointCloud2: x, y, z of float32."""

    SUFFIX = "_pointcloud2"
    MESSAGE = PointCloud2
    FIELDS = [
        PointField(name=name, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, name in enumerate("xyz")
    ]

    def message(self, item, header):
        return PointCloud2(
            header=header,
            height=1,
            width=len(item),
            fields=self.FIELDS,
            point_step=12,
            row_step=12 * len(item),
            data=np.ascontiguousarray(item, dtype="<f4").tobytes(),
            is_dense=bool(np.isfinite(item).all()),
        )


class SonarRange(Form):
    """The distance of a single transducer, ahead in its own frame; inf without an echo."""

    TYPE = "sonar"
    SUFFIX = "_range"
    MESSAGE = Range

    @staticmethod
    def fits(settings):
        """Return whether there is a single transducer."""
        return len(settings.transducers) == 1

    @property
    def frame(self):
        """Return where the transducer is, and looks."""
        x, y, yaw_angle = places_of(self.mount)[0].tolist()
        return (x, y, self.mount.place[2], yaw_angle)

    def rows(self, reading):
        """Return the distances (m,) [m]."""
        return reading.ranges[:, 0].tolist()

    def message(self, item, header):
        numbers = self.mount.settings
        return Range(
            header, Range.ULTRASOUND, numbers.cone, numbers.least, numbers.most, float(item)
        )


class Scan(Form):
    """A LaserScan: inf where nothing is within the greatest distance, nan where a ray is lost."""

    TYPE = "laser"
    MESSAGE = LaserScan

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        numbers = mount.settings
        self._places, self._most = places_of(mount), numbers.most
        spans = max(1, numbers.rays - 1)
        self._fixed = dict(
            angle_min=numbers.first,
            angle_max=numbers.last if numbers.rays > 1 else numbers.first,
            angle_increment=(numbers.last - numbers.first) / spans,
            scan_time=1.0 / mount.rate,
            range_min=numbers.least,
            range_max=numbers.most,
        )

    def rows(self, reading):
        """Return the distances of each robot, lists [m]."""
        return reading.ranges.tolist()

    def message(self, item, header):
        return LaserScan(
            header=header, time_increment=0.0, ranges=item, intensities=[], **self._fixed
        )

    def reading(self, message, stamp):
        """Return the ``RangeReading`` in a LaserScan; what drivers mark as ignored is lost."""
        rays = len(self._places)
        if len(message.ranges) != rays:
            text = "{} rays, but the mount has {}"
            raise MessageError(text.format(len(message.ranges), rays))
        first, step = self._fixed["angle_min"], self._fixed["angle_increment"]
        turned = abs(message.angle_min - first) + rays * abs(message.angle_increment - step)
        if not turned <= max(step, TURNED):
            text = "rays from {:.4g} rad every {:.4g} rad, but the mount has {:.4g} and {:.4g}"
            raise MessageError(text.format(message.angle_min, message.angle_increment, first, step))
        ranges, most = np.array(message.ranges), np.float32(self._most)
        ranges[ranges < max(message.range_min, 0.0)] = np.nan
        ranges[ranges >= (min(message.range_max, most) if message.range_max > 0.0 else most)] = (
            np.inf
        )
        return RangeReading(stamp, ranges, self._places, self._most)


def places_of(mount):
    """Return x, y [m] and direction [rad] of each ray of a sonar or laser ``mount``, (K, 3)."""
    return TYPES[mount.type](mount, np.zeros(1, dtype=int), None).places
