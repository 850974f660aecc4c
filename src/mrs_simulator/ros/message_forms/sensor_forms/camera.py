"""Cameras: Image of colours and depths, CameraInfo."""

import math

import numpy as np
from sensor_msgs.msg import CameraInfo, Image

from mrs_simulator.core.spatial import quaternion_product
from mrs_simulator.ros.message_forms.messages import MessageError
from mrs_simulator.ros.message_forms.sensor_forms.form import OPTICAL, Form
from mrs_simulator.sensors.types.camera import CameraReading

LEVEL_OPTICS = (-0.5, 0.5, -0.5, 0.5)  # [-] quaternion of optical axes in those of a level mount
FARTHEST_RAW = 65535  # [mm] that a depth of 16 bits can express


class CameraForm(Form):
    """Messages of a camera, in its optical frame (REP 103): x to the right, y down, z ahead."""

    TYPE = "camera"
    FRAME = OPTICAL

    def blank(self):
        """Return a black picture without depth."""
        size = self.mount.settings.height, self.mount.settings.width
        return np.zeros((*size, 3), dtype=np.uint8), np.zeros(size)

    @property
    def optics(self):
        """Return the orientation of the optical frame in the mount's, (4,) x, y, z, w."""
        half = 0.5 * self.mount.settings.down
        lowered = np.array([0.0, math.sin(half), 0.0, math.cos(half)])
        return quaternion_product(lowered, np.array(LEVEL_OPTICS))

    def pixels(self, message, kinds):
        """Return the pixels of an ``Image`` (height, width, ...), of an encoding among ``kinds``, dtypes.

        Raises ``MessageError`` for other encodings and sizes.
        """
        numbers = self.mount.settings
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
        """Return the ``CameraReading``; its depth, which ``Depths`` provides, is nan."""
        triples = self.pixels(message, {"rgb8": np.dtype((np.void, 3))})
        image = np.ascontiguousarray(triples).view(np.uint8).reshape(*triples.shape, 3)
        unknown = np.full(triples.shape, np.nan)
        return CameraReading(stamp, image, unknown, self.mount.settings.intrinsics)


class Depths(CameraForm):
    """Image 32FC1 of depths [m] (REP 118): inf where nothing is, nan where it is not known."""

    MESSAGE = Image
    SUFFIX = "_depth"
    FILLS = ("depth",)

    @staticmethod
    def fits(settings):
        """Return whether the depth is measured."""
        return settings.has_depth

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
        return CameraReading(stamp, black, depth, self.mount.settings.intrinsics)


class RawDepths(Depths):
    """Image 16UC1 of depths [mm], as cameras publish them: 0 where nothing is, or beyond its range."""

    SUFFIX = "_depth_raw"
    FILLS = ()

    def message(self, item, header):
        depth = 1e3 * np.asarray(item[1])
        known = np.isfinite(depth) & (depth <= FARTHEST_RAW)
        millimetres = np.rint(np.where(known, depth, 0.0)).astype("<u2")
        return _image(header, "16UC1", np.ascontiguousarray(millimetres))


class Pinhole(CameraForm):
    """CameraInfo of a camera without distortion."""

    MESSAGE = CameraInfo
    SUFFIX = "_info"

    def message(self, item, header):
        numbers = self.mount.settings
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
    fits = staticmethod(Depths.fits)


def _image(header, encoding, pixels):
    height, width = pixels.shape[:2]
    step = pixels.nbytes // height
    return Image(header, height, width, encoding, 0, step, pixels.tobytes())
