"""Odometry and Twist with fast serialisation, for teams of a hundred robots.

The bytes are those of ``nav_msgs/Odometry`` and ``geometry_msgs/Twist``; only what a planar robot
needs is packed and unpacked, where rospy would make and walk some twenty objects for each message.
"""

import math
import struct

import genpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from mrs_simulator.core.kinematics import heading_about_z, turn_about_z, yaw

_LENGTH = struct.Struct("<I")
_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")  # position, orientation
_COVARIANCE = struct.Struct("<36d")
_TWIST = struct.Struct("<6d")  # linear, angular


class PlanarOdometry(Odometry):
    """An odometry message of which pose (x, y, theta) and body twist (vx, vy, omega) count.

    ``lift`` is what a robot above the ground publishes besides: z, the quaternion's x, y, z, w, and vz,
    wx, wy; None on the ground.  Receiving fills ``stamp``, ``frame``, ``planar``, ``body``, ``z``, ``lift``
    and ``length``, that of the quaternion, not the nested fields.
    """

    __slots__ = ("stamp", "frame", "planar", "body", "z", "lift", "length")
    __slots__ += ("_frames", "_covariances", "_known")

    def __init__(self):
        """Make an empty message: the nested fields, which cost the most, are never made."""
        self.lift = None

    def prepare(self, frame, child, pose_covariance, twist_covariance):
        """Fix what does not change from message to message, before the first is sent."""
        self.header = Header()  # rospy counts in it
        frame, child = frame.encode(), child.encode()
        self._frames = _LENGTH.pack(len(frame)) + frame + _LENGTH.pack(len(child)) + child
        self._covariances = _COVARIANCE.pack(*pose_covariance), _COVARIANCE.pack(*twist_covariance)
        # A robot in the air knows what one on the ground has no use for.
        self._known = tuple(
            _COVARIANCE.pack(*known(c)) for c in (pose_covariance, twist_covariance)
        )

    def tell_pose_covariance(self, covariance):
        """Let the next messages have another ``covariance`` (36,) of the pose."""
        of_pose, of_twist = _COVARIANCE.pack(*covariance), self._covariances[1]
        self._covariances = of_pose, of_twist
        self._known = _COVARIANCE.pack(*known(covariance)), self._known[1]

    def serialize(self, buff):
        """Write the message; ``stamp``, ``planar`` and ``body`` are its contents."""
        x, y, theta = self.planar
        vx, vy, omega = self.body
        pose_covariance, twist_covariance = self._covariances
        pose = (x, y, 0.0, 0.0, 0.0, *turn_about_z(theta))
        twist = vx, vy, 0.0, 0.0, 0.0, omega
        if self.lift is not None:
            z, qx, qy, qz, qw, vz, wx, wy = self.lift
            pose, twist = (x, y, z, qx, qy, qz, qw), (vx, vy, vz, wx, wy, omega)
            pose_covariance, twist_covariance = self._known
        buff.write(
            b"".join(
                (
                    _HEADER.pack(self.header.seq, self.stamp.secs, self.stamp.nsecs),
                    self._frames,
                    _POSE.pack(*pose),
                    pose_covariance,
                    _TWIST.pack(*twist),
                    twist_covariance,
                )
            )
        )

    def deserialize(self, data):
        """Read the message; ``genpy.DeserializationError`` if it is cut short."""
        try:
            _, secs, nsecs = _HEADER.unpack_from(data, 0)
            at = _HEADER.size
            begin = at + _LENGTH.size
            at = begin + _LENGTH.unpack_from(data, at)[0]
            frame = data[begin:at]
            at += _LENGTH.size + _LENGTH.unpack_from(data, at)[0]
            x, y, z, qx, qy, qz, qw = _POSE.unpack_from(data, at)
            at += _POSE.size + _COVARIANCE.size
            vx, vy, vz, wx, wy, omega = _TWIST.unpack_from(data, at)
        except struct.error as error:
            raise genpy.DeserializationError(error) from None
        self.stamp, self.frame = genpy.Time(secs, nsecs), frame.decode("utf-8", "replace")
        self.length = math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
        is_planar = qx == qy == 0.0
        theta = heading_about_z(qz, qw) if is_planar else yaw(qx, qy, qz, qw)
        self.planar, self.body = (x, y, theta), (vx, vy, omega)
        self.z, self.lift = z, (z, qx, qy, qz, qw, vz, wx, wy)
        return self


def known(covariance):
    """Return the row-major 6x6 ``covariance`` with z as sure as x, roll and pitch as yaw."""
    result = list(covariance)
    result[14], result[21], result[28] = covariance[0], covariance[35], covariance[35]
    return result


class QuickTwist(Twist):
    """A velocity command as its six numbers, ``values``: linear x, y, z, angular x, y, z."""

    __slots__ = ("values",)

    def __init__(self):
        """Make an empty message, without the nested fields."""

    def serialize(self, buff):
        """Write the message; ``values`` are its contents."""
        buff.write(_TWIST.pack(*self.values))

    def deserialize(self, data):
        """Read the message; ``genpy.DeserializationError`` if it is cut short."""
        try:
            self.values = _TWIST.unpack_from(data, 0)
        except struct.error as error:
            raise genpy.DeserializationError(error) from None
        return self
