"""A 3D view of the team: pybullet's own window, or pictures by its software renderer.

The view is a pybullet world of its own into which poses are written: it shows every fidelity alike
and does not slow the motion's solver.
"""

import ctypes
import functools
import os

import numpy as np
import pybullet

from mrs_simulator.scenario.surroundings.moving_obstacles import obstacles_at
from mrs_simulator.vehicles import Team
from mrs_simulator.world.contact.movers import ObstacleMover
from mrs_simulator.world.contact.scene import add_looks, add_obstacle, mass_centre
from mrs_simulator.world.rendering.pinhole import depths, upright_field
from mrs_simulator.world.rendering.renderers import SOFTWARE, chosen_renderer

FIELD_OF_VIEW = 50.0  # [deg] of pictures, from bottom to top
WINDOW_FIELD_OF_VIEW = 90.0  # [deg] pybullet's own
ASPECT = 4.0 / 3.0  # [-] width over height of the window and of most pictures
FRAME_MARGIN = 1.5  # [m] in view around the team
PITCH, YAW = -45.0, 0.0  # [deg] where the camera looks from at first: the south, from above
GROUND_COLOUR = [0.87, 0.89, 0.87, 1.0]
GROUND_MARGIN = 4.0  # [m] of ground around robots and obstacles
FLOOR = 0.005  # [m] half of its thickness: its top is at 0
STEEP = 0.999  # [-] height of a direction from which on the vertical is no way up in a picture
NEAR, FAR = 0.1, 1000.0  # [m] clipping planes


class ViewError(RuntimeError):
    """No window can be opened; the message says why."""


class View:
    """Robots and obstacles as they look, at given poses."""

    def __init__(self, kinds, poses, obstacles=(), window=False):
        """``window``: open pybullet's window, which needs a display; else for pictures only."""
        if window:
            _need_display(os.environ.get("DISPLAY"))
        self._client = pybullet.connect(pybullet.GUI if window else pybullet.DIRECT)
        if self._client < 0:
            raise ViewError("pybullet's window could not be opened (one per process, OpenGL 3.3)")
        self._renderer = None if window else chosen_renderer(self._client)
        self._configure(pybullet.COV_ENABLE_GUI, False)
        # The window would draw itself after each body.
        self._configure(pybullet.COV_ENABLE_RENDERING, False)
        poses = np.asarray(poses, dtype=float)
        self._kinds = Team.of(kinds).kinds
        self._bodies = [
            add_looks(self._client, kind, pose) for kind, pose in zip(self._kinds, poses)
        ]
        self._ahead = [mass_centre(self._client, body) for body in self._bodies]
        if window:
            self._paint_chassis()
        self._add_floor(poses, obstacles)
        self._obstacles = tuple(obstacles)
        bodies = [add_obstacle(self._client, obstacle) for obstacle in self._obstacles]
        self._movers = ObstacleMover(self._client, self._obstacles, bodies)
        self.look_at(*_framing(poses, WINDOW_FIELD_OF_VIEW if window else FIELD_OF_VIEW))
        self._configure(pybullet.COV_ENABLE_RENDERING, True)

    def _configure(self, what, on):
        pybullet.configureDebugVisualizer(what, int(on), physicsClientId=self._client)

    def _paint_chassis(self):
        """Give each chassis the colour of its first part: the window has one colour for a link."""
        for body, kind in zip(self._bodies, self._kinds):
            if kind.shape or not kind.model:
                continue
            colour = pybullet.getVisualShapeData(body, physicsClientId=self._client)[0][7]
            pybullet.changeVisualShape(body, -1, rgbaColor=colour, physicsClientId=self._client)

    def _add_floor(self, poses, obstacles):
        places = np.array(poses[:, :2].tolist() + [[thing.x, thing.y] for thing in obstacles])
        low, high = places.min(axis=0), places.max(axis=0)
        half = 0.5 * (high - low) + GROUND_MARGIN
        floor = pybullet.createVisualShape(
            pybullet.GEOM_BOX,
            halfExtents=[half[0], half[1], FLOOR],
            rgbaColor=GROUND_COLOUR,
            specularColor=[0.0, 0.0, 0.0],
            physicsClientId=self._client,
        )
        middle = 0.5 * (low + high)
        pybullet.createMultiBody(
            0.0, -1, floor, [middle[0], middle[1], -FLOOR], physicsClientId=self._client
        )

    def show(self, poses, spatial=None, time=0.0):
        """Put the robots at ``poses`` (n, 3), and obstacles on tracks where they are at ``time`` [s].

        ``spatial``: where robots are above the ground, and tilted.
        """
        if self._movers:
            self._movers.put(obstacles_at(self._obstacles, time))
        places = np.asarray(poses, dtype=float).tolist()
        for row, (body, kind, ahead, (x, y, theta)) in enumerate(
            zip(self._bodies, self._kinds, self._ahead, places)
        ):
            z, turn = 0.0, [0.0, 0.0, np.sin(0.5 * theta), np.cos(0.5 * theta)]
            if spatial is not None:
                z, turn = spatial.z[row], spatial.orientation[row].tolist()
            inside = [ahead[0], ahead[1], kind.module.ride_height(kind.numbers) + ahead[2]]
            place, _ = pybullet.multiplyTransforms([x, y, z], turn, inside, [0.0, 0.0, 0.0, 1.0])
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

    def seen(self, eye, ahead, numbers):
        """Return colours (height, width, 3) uint8 and depth (height, width) [m] from ``eye`` (3,) [m].

        ``ahead`` (3,): along its axis, which is not upright; ``numbers``: of a ``sensors.types.camera``.
        """
        up = [0.0, 0.0, 1.0] if abs(ahead[2]) < STEEP else [*-np.sign(ahead[2]) * ahead[:2], 0.0]
        if not np.any(up):
            up = [1.0, 0.0, 0.0]
        size, renderer = (numbers.width, numbers.height), self._renderer or SOFTWARE
        _, _, rgba, buffer, _ = pybullet.getCameraImage(
            *size,
            pybullet.computeViewMatrix(eye.tolist(), (eye + ahead).tolist(), up),
            _pinhole(numbers, renderer),
            lightDirection=[-3.0, -5.0, 10.0],
            shadow=0,
            renderer=renderer,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        colours = np.reshape(np.asarray(rgba, dtype=np.uint8), (size[1], size[0], 4))[:, :, :3]
        return colours, depths(np.reshape(buffer, size[::-1]), numbers.least, numbers.most)

    @property
    def open(self):
        """Return whether the window is still there."""
        return self._client >= 0 and bool(pybullet.isConnected(self._client))

    def close(self):
        """Disconnect from pybullet; closing twice does no harm."""
        if self.open:
            pybullet.disconnect(physicsClientId=self._client)
        self._client = -1


def _pinhole(numbers, renderer):
    """Return OpenGL's projection for the ``settings`` of a camera, whose axis meets the picture's middle.

    The software renderer looks half a pixel aside of the middles of pixels, which is made up for.
    """
    width, height = numbers.width, numbers.height
    matrix = list(
        pybullet.computeProjectionMatrixFOV(
            upright_field(numbers), width / height, numbers.least, numbers.most
        )
    )
    if renderer == SOFTWARE:
        matrix[8] += 1.0 / width
        matrix[9] += 1.0 / height
    return matrix


@functools.lru_cache(maxsize=None)
def _need_display(name):
    """Return a connection to the X server ``name``; ``ViewError`` if none answers.

    pybullet would end the process.  The connection is kept: a virtual server starts anew when its
    last client leaves, and refuses further ones meanwhile.
    """
    if not name:
        raise ViewError("pybullet's window needs a display: DISPLAY is not set")
    try:
        x11 = ctypes.CDLL("libX11.so.6")
    except OSError as error:
        raise ViewError("pybullet's window needs a display: {}".format(error)) from None
    x11.XOpenDisplay.argtypes, x11.XOpenDisplay.restype = [ctypes.c_char_p], ctypes.c_void_p
    display = x11.XOpenDisplay(name.encode())
    if not display:
        raise ViewError("pybullet's window needs a display: {} does not answer".format(name))
    return display


def _framing(poses, field_of_view):
    """Return the middle of the team and the distance [m] from which all of it is in view."""
    low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
    across, along = 0.5 * (high - low) + FRAME_MARGIN
    slope = np.tan(np.radians(0.5 * field_of_view))
    pitch = np.radians(-PITCH)
    # The near edge of the team is the widest and the lowest in the picture.
    distance = max(across / ASPECT, along * np.sin(pitch)) / slope + along * np.cos(pitch)
    return 0.5 * (low + high), float(distance)
