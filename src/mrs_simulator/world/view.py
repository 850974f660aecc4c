"""A 3D view of the team: pybullet's own window, or pictures by its software renderer.

The view is a pybullet world of its own into which poses are written: it shows every fidelity alike
and does not slow the motion's solver.
"""

import os

import numpy as np
import pybullet

from mrs_simulator.world.robots import robot_kind
from mrs_simulator.world.scene import add_obstacle, add_robot, mass_centre

FIELD_OF_VIEW = 50.0  # [deg]
PITCH, YAW = -45.0, 0.0  # [deg] where the camera looks from at first: the south, from above
GROUND_COLOUR = [0.87, 0.89, 0.87, 1.0]
GROUND_MARGIN = 4.0  # [m] of ground around the team
NEAR, FAR = 0.1, 1000.0  # [m] clipping planes


class ViewError(RuntimeError):
    """No window can be opened; the message says why."""


class View:
    """Robots and obstacles as they look, at given poses."""

    def __init__(self, kinds, poses, obstacles=(), window=False):
        """``window``: open pybullet's window, which needs a display; else for pictures only."""
        if window and not os.environ.get("DISPLAY"):
            raise ViewError("pybullet's window needs a display: DISPLAY is not set")
        self._client = pybullet.connect(pybullet.GUI if window else pybullet.DIRECT)
        if self._client < 0:
            raise ViewError("pybullet's window could not be opened (one per process, OpenGL 3.3)")
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=self._client)
        poses = np.asarray(poses, dtype=float)
        self._kinds = [robot_kind(kind) for kind in kinds]
        self._bodies = [
            add_robot(self._client, kind, pose) for kind, pose in zip(self._kinds, poses)
        ]
        self._ahead = [mass_centre(self._client, body) for body in self._bodies]
        self._add_floor(poses)
        for obstacle in obstacles:
            add_obstacle(self._client, obstacle)
        self.look_at(*_framing(poses))

    def _add_floor(self, poses):
        low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
        half = 0.5 * (high - low) + GROUND_MARGIN
        floor = pybullet.createVisualShape(
            pybullet.GEOM_BOX,
            halfExtents=[half[0], half[1], 0.005],
            rgbaColor=GROUND_COLOUR,
            physicsClientId=self._client,
        )
        middle = 0.5 * (low + high)
        pybullet.createMultiBody(
            0.0, -1, floor, [middle[0], middle[1], -0.01], physicsClientId=self._client
        )

    def show(self, poses):
        """Put the robots at ``poses`` (n, 3)."""
        for body, kind, ahead, (x, y, theta) in zip(
            self._bodies, self._kinds, self._ahead, np.asarray(poses, dtype=float).tolist()
        ):
            cos, sin = np.cos(theta), np.sin(theta)
            place = [
                x + ahead[0] * cos - ahead[1] * sin,
                y + ahead[0] * sin + ahead[1] * cos,
                kind.WHEEL_RADIUS + ahead[2],
            ]
            turn = [0.0, 0.0, np.sin(0.5 * theta), np.cos(0.5 * theta)]
            pybullet.resetBasePositionAndOrientation(
                body, place, turn, physicsClientId=self._client
            )

    def look_at(self, target, distance, yaw=YAW, pitch=PITCH):
        """Aim the camera at ``target`` (x, y) from ``distance`` [m], ``yaw`` and ``pitch`` in degrees."""
        self._camera = ([float(target[0]), float(target[1]), 0.0], float(distance), yaw, pitch)
        pybullet.resetDebugVisualizerCamera(
            distance, yaw, pitch, self._camera[0], physicsClientId=self._client
        )

    def picture(self, width=640, height=480):
        """Return what the camera sees, (height, width, 3) uint8, by the software renderer."""
        target, distance, yaw, pitch = self._camera
        _, _, rgba, _, _ = pybullet.getCameraImage(
            width,
            height,
            pybullet.computeViewMatrixFromYawPitchRoll(target, distance, yaw, pitch, 0.0, 2),
            pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, width / height, NEAR, FAR),
            lightDirection=[-3.0, -5.0, 10.0],
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        return np.reshape(np.asarray(rgba, dtype=np.uint8), (height, width, 4))[:, :, :3]

    @property
    def open(self):
        """Return whether the window is still there."""
        return self._client >= 0 and bool(pybullet.isConnected(self._client))

    def close(self):
        """Disconnect from pybullet; closing twice does no harm."""
        if self.open:
            pybullet.disconnect(physicsClientId=self._client)
        self._client = -1


def _framing(poses):
    low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
    distance = 3.0 + 1.2 * float(np.max(high - low))
    return 0.5 * (low + high), distance
