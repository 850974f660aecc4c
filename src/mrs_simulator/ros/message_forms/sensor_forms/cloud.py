"""PointCloud without a Python object for each point."""

import struct

import genpy
import numpy as np
from sensor_msgs.msg import PointCloud
from std_msgs.msg import Header

_HEADER, _COUNT = struct.Struct("<III"), struct.Struct("<I")


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
