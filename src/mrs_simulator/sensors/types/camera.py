"""Cameras: colours and depth, through a pinhole."""

import math
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.sensors.placing import carried
from mrs_simulator.sensors.types.ranging import read_range
from mrs_simulator.sensors.types.sensor import Sensor

MOST = 2048  # [-] pixels of a side


class CameraSettings(NamedTuple):
    """Settings of a camera."""

    width: int  # [-] pixels
    height: int
    view: float  # [rad] field of view, from the left edge to the right
    down: float  # [rad] by which it looks below the level
    least: float  # [m] along its axis
    most: float
    has_depth: bool = True

    @property
    def intrinsics(self):
        """Return fx, fy, cx, cy [pixels]: (x, y, z) to the right, down, ahead is at u = fx x/z + cx, v."""
        focal = 0.5 * self.width / math.tan(0.5 * self.view)
        return focal, focal, 0.5 * (self.width - 1), 0.5 * (self.height - 1)


class CameraReading(NamedTuple):
    """A picture, from the top left on, and its depth."""

    stamp: float  # [s]
    image: np.ndarray  # (..., height, width, 3) uint8, red, green, blue
    # (..., height, width) [m] along the camera's axis, inf where nothing is, nan: unknown
    depth: np.ndarray
    intrinsics: Tuple[float, ...]  # fx, fy, cx, cy [pixels]

    PER_ROBOT = ("image", "depth")

    def text(self):
        """Return the size of the picture."""
        height, width = self.image.shape[:2]
        return "picture of {} \u00d7 {} pixels".format(width, height)


class Camera(Sensor):
    """Pictures of the scene, rendered when they are due and the camera is active.

    The camera stands level, ``down`` apart, also on a robot that tilts; it sees its own robot's body.
    """

    TYPE = "camera"
    QUANTITIES = {"depth": "m"}
    RATE = 5.0

    @staticmethod
    def settings(section):
        least, most = read_range(section, 0.05, 30.0)
        return CameraSettings(
            section.whole("width", 160, low=1, high=MOST),
            section.whole("height", 120, low=1, high=MOST),
            section.quantity(
                "view", "rad", math.radians(60.0), above=0.0, high=math.radians(170.0)
            ),
            section.quantity("down", "rad", 0.0, low=-0.5 * math.pi, high=0.5 * math.pi),
            max(least, 1e-3),
            most,
            section.flag("depth", True),
        )

    def __init__(self, mount, rows, team):
        super().__init__(mount, rows, team)
        self._place = mount.place

    def read(self, state, environment, rng):
        settings, pose = self._settings, state.pose[self._rows]
        place = carried(pose, np.array([self._place[:2]]))[:, 0]
        height = state.heights[self._rows] + self._place[2]
        level, up = math.cos(settings.down), -math.sin(settings.down)
        cos, sin = cos_sin(pose[:, 2] + self._place[3])
        ahead = np.stack([level * cos, level * sin, np.full(len(cos), up)], axis=1)
        centres = np.column_stack([place, height])
        pictures = [environment.picture(state, *each, settings) for each in zip(centres, ahead)]
        image, depth = (np.stack(each) for each in zip(*pictures))
        depth = rng.noisy(np.where(depth < settings.most, depth, np.inf), "depth")
        if not settings.has_depth:
            depth = np.full_like(depth, np.nan)
        return CameraReading(state.time, image, depth, settings.intrinsics)
