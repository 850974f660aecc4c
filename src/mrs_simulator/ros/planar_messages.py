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

from mrs_simulator.core.kinematics import yaw

_LENGTH = struct.Struct("<I")
_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")  # position, orientation
_COVARIANCE = struct.Struct("<36d")
_TWIST = struct.Struct("<6d")  # linear, angular


class PlanarOdometry(Odometry):
    """An odometry message of which pose (x, y, theta) and body twist (vx, vy, omega) count.

    Receiving fills ``stamp``, ``frame``, ``planar``, ``body`` and ``length``, that of the quaternion,
    not the nested fields.
    """

    __slots__ = ("stamp", "frame", "planar", "body", "length", "_frames", "_covariances")

    def __init__(self):
        """Make an empty message: the nested fields, which cost the most, are never made."""

    def prepare(self, frame, child, pose_covariance, twist_covariance):
        """Fix what does not change from message to message, before the first is sent."""
        self.header = Header()  # rospy counts in it
        frame, child = frame.encode(), child.encode()
        self._frames = _LENGTH.pack(len(frame)) + frame + _LENGTH.pack(len(child)) + child
        self._covariances = _COVARIANCE.pack(*pose_covariance), _COVARIANCE.pack(*twist_covariance)

    def serialize(self, buff):
        """Write the message; ``stamp``, ``planar`` and ``body`` are its contents."""
        x, y, theta = self.planar
        vx, vy, omega = self.body
        pose_covariance, twist_covariance = self._covariances
        half = 0.5 * theta
        buff.write(
            b"".join(
                (
                    _HEADER.pack(self.header.seq, self.stamp.secs, self.stamp.nsecs),
                    self._frames,
                    _POSE.pack(x, y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half)),
                    pose_covariance,
                    _TWIST.pack(vx, vy, 0.0, 0.0, 0.0, omega),
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
            x, y, _, qx, qy, qz, qw = _POSE.unpack_from(data, at)
            at += _POSE.size + _COVARIANCE.size
            vx, vy, _, _, _, omega = _TWIST.unpack_from(data, at)
        except struct.error as error:
            raise genpy.DeserializationError(error) from None
        self.stamp, self.frame = genpy.Time(secs, nsecs), frame.decode("utf-8", "replace")
        self.length = math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
        self.planar, self.body = (x, y, yaw(qx, qy, qz, qw)), (vx, vy, omega)
        return self


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
