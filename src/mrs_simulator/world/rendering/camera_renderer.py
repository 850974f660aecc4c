"""What cameras in the scene see, by pybullet's software renderer."""

import math

import numpy as np

from mrs_simulator.sensors.suite import SensorError

NOTHING = 1.0 - 1e-7  # [-] in a buffer of float32, which is as empty at 1 less its last digit


class Eyes:
    """Renders the scene of a team; pybullet and its models are loaded for the first picture."""

    def __init__(self, team, obstacles=()):
        """``team``: the ``vehicles.Team``; ``obstacles``: ``Box`` and ``Cylinder``."""
        self._team, self._obstacles, self._view, self._shown = team, tuple(obstacles), None, None

    def __call__(self, state, eye, ahead, numbers):
        """Return colours (height, width, 3) uint8 and depth (height, width) [m] from ``eye`` (3,) [m].

        ``ahead`` (3,): where it looks; ``numbers``: of a camera.  Depth is along its axis, inf for nothing.
        """
        if self._view is None:
            self._view = self._opened(state)
        if self._shown is not state:  # several cameras look at the same time
            self._view.show(state.pose, state.spatial, state.time)
            self._shown = state
        return self._view.seen(eye, ahead, numbers)

    def _opened(self, state):
        try:
            from mrs_simulator.world.rendering.view import View  # pybullet only where it is used
        except ModuleNotFoundError as error:
            if error.name != "pybullet":
                raise
            text = "camera: the Python package pybullet is missing (pip install pybullet)"
            raise SensorError(text) from None
        return View(self._team, state.pose, self._obstacles)


def depths(buffer, least, most):
    """Return the depth [m] in a ``buffer`` of OpenGL's, 0 at ``least`` and 1 at ``most`` [m], or beyond."""
    buffer = np.asarray(buffer, dtype=float)
    far = least * most / (most - (most - least) * buffer)
    return np.where(buffer < NOTHING, far, np.inf)


def upright_field(numbers):
    """Return the field of view [deg] of a camera from bottom to top, whose pixels are square."""
    return math.degrees(
        2.0 * math.atan(math.tan(0.5 * numbers.view) * numbers.height / numbers.width)
    )
