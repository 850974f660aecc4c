"""Readings of sensors as messages, in types, frames and units of the usual drivers, and back.

A form tells one type of sensor in one type of message.  It is made for a mount, as those who publish and
those who listen both know it, so that what a message leaves out, such as where a transducer is, comes
from there.  Distances and directions are float32 in most messages; all else is told to the last digit.
"""

import math
import struct

import genpy
import numpy as np
import rospy
from geometry_msgs.msg import PointStamped, PoseStamped
from sensor_msgs.msg import (
    BatteryState,
    CameraInfo,
    Image,
    Imu,
    JointState,
    LaserScan,
    MagneticField,
    NavSatFix,
    NavSatStatus,
    PointCloud,
    PointCloud2,
    PointField,
    Range,
)
from std_msgs.msg import Float32, Float64, Header

from mrs_simulator.core.kinematics import cos_sin, yaw
from mrs_simulator.core.spatial import product
from mrs_simulator.ros.defined_types import BumperState
from mrs_simulator.ros.messages import (
    MessageError,
    RangeBearing,
    range_bearing,
    read_range_bearing,
)
from mrs_simulator.sensors.types import TYPES
from mrs_simulator.sensors.types.battery import BatteryReading
from mrs_simulator.sensors.types.beacons import BeaconReading
from mrs_simulator.sensors.types.bumper import BumperReading
from mrs_simulator.sensors.types.camera import CameraReading
from mrs_simulator.sensors.types.encoders import EncoderReading
from mrs_simulator.sensors.types.inertial import AltimeterReading, CompassReading, ImuReading
from mrs_simulator.sensors.types.placing import echoes
from mrs_simulator.sensors.types.position import GpsReading, PoseReading
from mrs_simulator.sensors.types.range_bearing import RangeBearingReading
from mrs_simulator.sensors.types.ranging import RangeReading

# Frames: the mount's, the robot's, the common one, and a camera's with z ahead and x to the right.
OWN, BASE, WORLD, OPTICAL = "own", "base", "world", "optical"
OPTICAL_FRAME = "_optical_frame"  # after the mount's frame
LEVEL_OPTICS = (-0.5, 0.5, -0.5, 0.5)  # [-] quaternion of optical axes in those of a level mount
FARTHEST_RAW = 65535  # [mm] that a depth of 16 bits can tell
SILENT = 1e-5  # [m] short of the greatest distance, from which on nothing was heard
ASIDE = 0.05  # [m] by which an echo may lie beside its transducer's direction
TURNED = 1e-3  # [rad] by which all rays may be turned from the mount's, or one step
FIELD = 2e-5  # [T] the earth's horizontal field as it is told, about that of middle latitudes
_HEADER, _COUNT = struct.Struct("<III"), struct.Struct("<I")


class Form:
    """What the forms have in common; ``frame`` (x, y, z [m], yaw [rad]) is that of ``OWN`` on the robot."""

    SUFFIX = ""  # of the topic, after the mount's name
    FRAME = OWN
    MESSAGE = None
    FILLS = ()  # fields of the first form's reading that this one tells instead

    def __init__(self, mount, kind):
        """``mount`` on a robot of ``kind``."""
        self.mount, self.kind = mount, kind
        self.noise = dict(mount.noise)

    @property
    def frame(self):
        """Return where the frame ``OWN`` lies on the robot: x, y, z [m], yaw [rad]."""
        return self.mount.place

    def rows(self, reading):
        """Return what the messages of the robots of ``reading`` are made of, one item for each."""
        return [list(row) for row in zip(*(getattr(reading, name) for name in reading.PER_ROBOT))]

    def message(self, item, header):
        """Return the message of one robot's ``item`` of ``rows``."""
        raise NotImplementedError

    def reading(self, message, stamp):
        """Return the reading in ``message``; ``MessageError`` says why it cannot be this sensor's."""
        raise NotImplementedError

    def variance(self, quantity=""):
        """Return the variance of the sensor's white noise."""
        return self.noise[quantity].stddev ** 2 if quantity in self.noise else 0.0


class Cloud(PointCloud):
    """A PointCloud whose ``points`` are an array (K, 3) float32, written and read at once."""

    __slots__ = ()

    def __init__(self, header=None, points=None):
        self.header, self.points, self.channels = header, points, []

    def serialize(self, buff):
        """Write the message."""
        header = self.header
        frame = header.frame_id.encode()
        parts = (
            _HEADER.pack(header.seq, header.stamp.secs, header.stamp.nsecs),
            _COUNT.pack(len(frame)) + frame,
            _COUNT.pack(len(self.points)),
            np.ascontiguousarray(self.points, dtype="<f4").tobytes(),
            _COUNT.pack(0),
        )
        buff.write(b"".join(parts))

    def deserialize(self, data):
        """Read the message, without its channels; ``DeserializationError`` if it is cut short."""
        try:
            seq, secs, nsecs = _HEADER.unpack_from(data, 0)
            begin = _HEADER.size + _COUNT.size
            at = begin + _COUNT.unpack_from(data, _HEADER.size)[0]
            (count,) = _COUNT.unpack_from(data, at)
            self.points = np.frombuffer(data, "<f4", 3 * count, at + _COUNT.size).reshape(-1, 3)
        except (struct.error, ValueError) as error:
            raise genpy.DeserializationError(error) from None
        frame = data[begin:at].decode("utf-8", "replace")
        self.header, self.channels = Header(seq, genpy.Time(secs, nsecs), frame), []
        return self


class SonarCloud(Form):
    """Echoes in the robot's axes, z 0, in a frame at the sonar's height, as RosAria tells them.

    One that hears nothing is told at the greatest distance, one that is lost as nan.
    """

    MESSAGE = Cloud

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        self._places, self._most = places_of(mount), mount.numbers.most
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
        """Return the ``Cloud`` of the points ``item`` (K, 3)."""
        return Cloud(header, item)

    def reading(self, message, stamp):
        """Return the ``RangeReading`` in a PointCloud."""
        count = len(self._places)
        if len(message.points) != count:
            text = "{} echoes, but the mount has {} transducers"
            raise MessageError(text.format(len(message.points), count))
        way = np.asarray(message.points, dtype=float)[:, :2] - self._places[:, :2]
        ranges = (way * self._along).sum(axis=1)
        aside = way[:, 0] * self._along[:, 1] - way[:, 1] * self._along[:, 0]
        wrong = np.flatnonzero((np.abs(aside) > ASIDE) | (ranges < -ASIDE))
        if len(wrong):
            text = "echo {} at ({:.3g}, {:.3g}) m is not where the mount's transducer looks"
            raise MessageError(text.format(wrong[0] + 1, *message.points[wrong[0]][:2]))
        ranges[ranges > self._most - SILENT] = np.inf
        cone = 0.5 * self.mount.numbers.cone
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
        """Return the ``PointCloud2`` of the points ``item`` (K, 3)."""
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
    """The distance of a single transducer, ahead in its own frame; inf where nothing is heard."""

    SUFFIX = "_range"
    MESSAGE = Range

    @property
    def frame(self):
        """Return where the transducer is, and looks."""
        x, y, yaw_angle = places_of(self.mount)[0].tolist()
        return (x, y, self.mount.place[2], yaw_angle)

    def rows(self, reading):
        """Return the distances (m,) [m]."""
        return reading.ranges[:, 0].tolist()

    def message(self, item, header):
        """Return the ``Range`` of one distance."""
        numbers = self.mount.numbers
        return Range(
            header, Range.ULTRASOUND, numbers.cone, numbers.least, numbers.most, float(item)
        )


class Scan(Form):
    """A LaserScan: inf where nothing is within the greatest distance, nan where a ray is lost."""

    MESSAGE = LaserScan

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        numbers = mount.numbers
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
        """Return the ``LaserScan`` of the distances ``item``."""
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


class Seen(Form):
    """RangeBearing: bearings from the robot's heading."""

    MESSAGE = RangeBearing

    @property
    def frame(self):
        """Return where the sensor is, its axes those of the robot."""
        return (*self.mount.place[:3], 0.0)

    def rows(self, reading):
        """Return numbers, ranges and bearings of those that each robot sees."""
        return [reading.of(k)[1:4] for k in range(len(reading.ranges))]

    def message(self, item, header):
        """Return the ``RangeBearing`` of numbers, ranges and bearings."""
        return range_bearing(header, *item)

    def reading(self, message, stamp):
        """Return the ``RangeBearingReading``."""
        return RangeBearingReading(stamp, *read_range_bearing(message), self.mount.place[:2])


class BeaconsHeard(Seen):
    """RangeBearing: numbers of beacons; bearings are nan where they are not measured."""

    def reading(self, message, stamp):
        """Return the ``BeaconReading``; ``MessageError`` where the mount has no such beacon."""
        numbers, ranges, bearings = read_range_bearing(message)
        count = len(self.mount.numbers.points)
        wrong = numbers[(numbers < 1) | (numbers > count)]
        if len(wrong) or len(set(numbers.tolist())) < len(numbers):
            text = "beacons {}, but the mount has each of 1 to {} once"
            raise MessageError(text.format(", ".join(map(str, numbers)), count))
        return BeaconReading(stamp, numbers, ranges, bearings)


class Bumpers(Form):
    """BumperState of RosAria: the front and the rear sections, from the robot's left to its right."""

    SUFFIX = "_state"
    MESSAGE = BumperState

    def message(self, item, header):
        """Return the ``BumperState`` of the sections that are pressed."""
        return BumperState(header, *(each.tolist() for each in item))

    def reading(self, message, stamp):
        """Return the ``BumperReading``."""
        told = message.front_bumpers, message.rear_bumpers
        if tuple(map(len, told)) != tuple(self.mount.numbers):
            text = "{} front and {} rear sections, but the mount has {} and {}"
            raise MessageError(text.format(*map(len, told), *self.mount.numbers))
        return BumperReading(stamp, *(np.array(each, dtype=bool) for each in told))


class Wheels(Form):
    """JointState: how far each wheel has turned [rad]; what counts no wheels of the model, in metres."""

    FRAME = BASE
    MESSAGE = JointState

    def __init__(self, mount, kind):
        super().__init__(mount, kind)
        self.names, self._radius = counted_joints(kind)

    def message(self, item, header):
        """Return the ``JointState`` of the distances rolled, [m]."""
        turned = (np.asarray(item[0]) / self._radius).tolist()
        return JointState(header=header, name=self.names, position=turned)

    def reading(self, message, stamp):
        """Return the ``EncoderReading``; other joints of the message are left out."""
        known = dict(zip(message.name, message.position))
        for name in self.names:
            if name not in known:
                told = ", ".join(message.name) or "none"
                raise MessageError("joints {}, wanted {} too".format(told, name))
        turned = np.array([known[name] for name in self.names])
        return EncoderReading(stamp, turned * self._radius)


def counted_joints(kind):
    """Return the names of the joints that a kind's encoders count, and the radius [m] of the wheels."""
    count, joints = kind.module.ENCODERS, tuple(getattr(kind.numbers, "joints", ()))
    if kind.module.JOINTS or len(joints) < count:  # they are not those of the wheels
        return ["encoder{}".format(k + 1) for k in range(count)], 1.0
    return list(joints[:count]), kind.numbers.radius


class Inertia(Form):
    """Imu without an orientation: specific force and turn rates at the centre, in the robot's axes."""

    FRAME = BASE
    MESSAGE = Imu

    def message(self, item, header):
        """Return the ``Imu`` of acceleration and turn rate."""
        message = Imu(header=header)
        message.orientation_covariance[0] = -1.0  # there is none
        force, rate = message.linear_acceleration, message.angular_velocity
        (force.x, force.y, force.z), (rate.x, rate.y, rate.z) = item
        message.linear_acceleration_covariance = _diagonal(self.variance("acceleration"))
        message.angular_velocity_covariance = _diagonal(self.variance("rate"))
        return message

    def reading(self, message, stamp):
        """Return the ``ImuReading``."""
        force, rate = message.linear_acceleration, message.angular_velocity
        values = (force.x, force.y, force.z), (rate.x, rate.y, rate.z)
        return ImuReading(stamp, *map(np.array, values))


class Heading(Form):
    """MagneticField: the horizontal part of the earth's field alone, in the robot's axes.

    North is along y of the common frame, as for satellites.
    """

    FRAME = BASE
    MESSAGE = MagneticField

    def message(self, item, header):
        """Return the ``MagneticField`` at a heading [rad]."""
        message = MagneticField(header=header)
        message.magnetic_field.x = FIELD * math.sin(item[0])
        message.magnetic_field.y = FIELD * math.cos(item[0])
        message.magnetic_field_covariance = _diagonal(FIELD**2 * self.variance())
        return message

    def reading(self, message, stamp):
        """Return the ``CompassReading``."""
        field = message.magnetic_field
        return CompassReading(stamp, math.atan2(field.x, field.y))


class Height(Form):
    """PointStamped in the common frame: z is the height."""

    FRAME = WORLD
    MESSAGE = PointStamped

    def message(self, item, header):
        """Return the ``PointStamped`` at a height [m]."""
        message = PointStamped(header=header)
        message.point.z = item[0]
        return message

    def reading(self, message, stamp):
        """Return the ``AltimeterReading``."""
        return AltimeterReading(stamp, message.point.z)


class Fix(Form):
    """NavSatFix of the antenna."""

    MESSAGE = NavSatFix

    def message(self, item, header):
        """Return the ``NavSatFix`` at latitude, longitude [deg] and altitude [m]."""
        found = all(map(math.isfinite, item))
        status = NavSatStatus.STATUS_FIX if found else NavSatStatus.STATUS_NO_FIX
        return NavSatFix(
            header,
            NavSatStatus(status, NavSatStatus.SERVICE_GPS),
            *item,
            _diagonal(self.variance()),
            NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN,
        )

    def reading(self, message, stamp):
        """Return the ``GpsReading``; without a fix it is nan."""
        told = message.latitude, message.longitude, message.altitude
        lost = message.status.status < NavSatStatus.STATUS_FIX
        if lost and all(map(math.isfinite, told)):  # where the driver believed to be last
            told = (math.nan,) * 3
        return GpsReading(stamp, *told)


class Tracked(Form):
    """PoseStamped in the common frame."""

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
        """Return the ``PoseReading``."""
        place, turn = message.pose.position, message.pose.orientation
        return PoseReading(stamp, place.x, place.y, yaw(turn.x, turn.y, turn.z, turn.w))


def places_of(mount):
    """Return x, y [m] and direction [rad] of each ray of a sonar or laser ``mount``, (K, 3)."""
    return TYPES[mount.type](mount, np.zeros(1, dtype=int), None).places


def _diagonal(variance):
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]


class Charge(Form):
    """BatteryState with voltage and charge alone."""

    MESSAGE = BatteryState

    def message(self, item, header):
        """Return the ``BatteryState`` at a voltage [V] and a charge [-]."""
        voltage, charge = item
        return BatteryState(
            header=header,
            voltage=voltage,
            percentage=charge,
            current=math.nan,
            capacity=math.nan,
            design_capacity=math.nan,
            present=True,
        )

    def reading(self, message, stamp):
        """Return the ``BatteryReading``."""
        return BatteryReading(stamp, message.voltage, message.percentage)


class Voltage(Form):
    """The voltage [V] alone, as RosAria tells it."""

    SUFFIX = "_voltage"
    MESSAGE = Float64

    def message(self, item, header):
        """Return the ``Float64``, which has no header."""
        return Float64(item[0])


class StateOfCharge(Form):
    """The charge alone, from 0 to 1, as RosAria tells it."""

    SUFFIX = "_state_of_charge"
    MESSAGE = Float32

    def message(self, item, header):
        """Return the ``Float32``, which has no header."""
        return Float32(item[1])


class CameraForm(Form):
    """What is told of a camera, in its optical frame (REP 103): x to the right, y down, z ahead."""

    FRAME = OPTICAL

    @property
    def optics(self):
        """Return the orientation of the optical frame in the mount's, (4,) x, y, z, w."""
        half = 0.5 * self.mount.numbers.down
        lowered = np.array([0.0, math.sin(half), 0.0, math.cos(half)])
        return product(lowered, np.array(LEVEL_OPTICS))

    def pixels(self, message, kinds):
        """Return the pixels of an ``Image`` (height, width, ...), of an encoding among ``kinds``, dtypes.

        Raises ``MessageError`` for other encodings and sizes.
        """
        numbers = self.mount.numbers
        size = numbers.height, numbers.width
        if (message.height, message.width) != size or message.encoding not in kinds:
            text = "{} of {} x {}, wanted {} of {} x {}"
            came = message.encoding, message.width, message.height
            raise MessageError(text.format(*came, " or ".join(kinds), *size[::-1]))
        kind = np.dtype(kinds[message.encoding])
        kind = kind.newbyteorder(">") if message.is_bigendian else kind
        wanted = kind.itemsize * size[0] * size[1]
        if len(message.data) != wanted:
            raise MessageError("{} bytes, wanted {}".format(len(message.data), wanted))
        return np.frombuffer(message.data, kind).reshape(size)


class Colours(CameraForm):
    """Image rgb8 of a camera."""

    MESSAGE = Image

    def message(self, item, header):
        """Return the ``Image`` of a picture and its depth."""
        return _image(header, "rgb8", np.ascontiguousarray(item[0]))

    def reading(self, message, stamp):
        """Return the ``CameraReading``; its depth, which ``Depths`` tells, is nan."""
        triples = self.pixels(message, {"rgb8": np.dtype((np.void, 3))})
        image = np.ascontiguousarray(triples).view(np.uint8).reshape(*triples.shape, 3)
        unknown = np.full(triples.shape, np.nan)
        return CameraReading(stamp, image, unknown, self.mount.numbers.intrinsics)


class Depths(CameraForm):
    """Image 32FC1 of depths [m] (REP 118): inf where nothing is, nan where it is not known."""

    MESSAGE = Image
    SUFFIX = "_depth"
    FILLS = ("depth",)

    def message(self, item, header):
        """Return the ``Image`` of a picture's depth."""
        return _image(header, "32FC1", np.ascontiguousarray(item[1], dtype="<f4"))

    def reading(self, message, stamp):
        """Return the ``CameraReading``, its picture black; 16UC1 [mm], 0 for nothing, is read as well."""
        raw = self.pixels(message, {"32FC1": "<f4", "16UC1": "<u2"})
        depth = raw.astype(float)
        if message.encoding == "16UC1":
            depth = np.where(raw > 0, 1e-3 * depth, np.nan)
        black = np.zeros((*depth.shape, 3), dtype=np.uint8)
        return CameraReading(stamp, black, depth, self.mount.numbers.intrinsics)


class RawDepths(Depths):
    """Image 16UC1 of depths [mm], as cameras tell them: 0 where nothing is, or farther than it can tell."""

    SUFFIX = "_depth_raw"
    FILLS = ()

    def message(self, item, header):
        """Return the ``Image`` of a picture's depth."""
        depth = 1e3 * np.asarray(item[1])
        known = np.isfinite(depth) & (depth <= FARTHEST_RAW)
        millimetres = np.rint(np.where(known, depth, 0.0)).astype("<u2")
        return _image(header, "16UC1", np.ascontiguousarray(millimetres))


class Pinhole(CameraForm):
    """CameraInfo of a camera without distortion."""

    MESSAGE = CameraInfo
    SUFFIX = "_info"

    def message(self, item, header):
        """Return the ``CameraInfo``."""
        numbers = self.mount.numbers
        fx, fy, cx, cy = numbers.intrinsics
        return CameraInfo(
            header=header,
            height=numbers.height,
            width=numbers.width,
            distortion_model="plumb_bob",
            D=[0.0] * 5,
            K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        )


class DepthPinhole(Pinhole):
    """The same beside the depth, which the same pinhole sees."""

    SUFFIX = "_depth_info"


def _image(header, encoding, pixels):
    height, width = pixels.shape[:2]
    step = pixels.nbytes // height
    return Image(header, height, width, encoding, 0, step, pixels.tobytes())


# Of each type of sensor; the first is listened to, with those that ``FILLS`` what it leaves out.
FORMS = {
    "altimeter": (Height,),
    "battery": (Charge, Voltage, StateOfCharge),
    "beacons": (BeaconsHeard,),
    "bumper": (Bumpers,),
    "camera": (Colours, Depths, RawDepths, Pinhole, DepthPinhole),
    "compass": (Heading,),
    "encoders": (Wheels,),
    "gps": (Fix,),
    "imu": (Inertia,),
    "laser": (Scan,),
    "motion_capture": (Tracked,),
    "range_bearing": (Seen,),
    "sonar": (SonarCloud, SonarCloud2),
}


def forms_of(mount, kind):
    """Return the forms of the ``mount`` on a robot of ``kind``."""
    kinds = FORMS[mount.type]
    if mount.type == "camera" and not mount.numbers.has_depth:
        kinds = tuple(form for form in kinds if not form.SUFFIX.startswith(Depths.SUFFIX))
    if mount.type == "sonar" and len(mount.numbers.transducers) == 1:
        kinds = (*kinds, SonarRange)
    return [form(mount, kind) for form in kinds]


def parts_of(mount, kind):
    """Return the forms that make up a reading of the ``mount``; the others fill fields of the first."""
    first, *others = forms_of(mount, kind)
    return [first, *(form for form in others if form.FILLS)]


def topic_of(number, form):
    """Return the name of the topic of ``form`` of the robot ``number``."""
    return "/robot{}/{}{}".format(number, form.mount.name, form.SUFFIX)


def listened_topic(pattern, number, form):
    """Return the topic of ``form`` of the robot ``number`` by ``pattern``: {} its number, * the sensor.

    Raises ``ValueError`` for a pattern without the latter.
    """
    if pattern.count("*") != 1:
        text = "parameter {} = {!r}: wanted one * for the sensor's name"
        raise ValueError(text.format(rospy.resolve_name("~sensor_topic"), pattern))
    return pattern.replace("{}", str(number)).replace("*", form.mount.name + form.SUFFIX)
