"""Pictures of simulated cameras, by pybullet's renderer."""

from mrs_simulator.core.snapshots import Constant
from mrs_simulator.sensors.suite import SensorError
from mrs_simulator.state.columns import SPATIAL


class CameraRenderer(Constant):
    """Renders the scene of a team; pybullet and its models are loaded for the first picture."""

    def __init__(self, team, obstacles=()):
        """``team``: the ``vehicles.Team``; ``obstacles``: ``Box`` and ``Cylinder``."""
        self._team, self._obstacles, self._view, self._shown = team, tuple(obstacles), None, None

    def __call__(self, state, eye, ahead, settings):
        """Return colours (height, width, 3) uint8 and depth (height, width) [m] from ``eye`` (3,) [m].

        ``ahead`` (3,): where it looks; ``settings``: ``CameraSettings``.  Depth is along its axis, inf for
        nothing.
        """
        if self._view is None:
            self._view = self._opened(state)
        if self._shown is not state:  # several cameras look at the same time
            spatial = state.spatial if state.has(SPATIAL) else None
            self._view.show(state.pose, spatial, state.time)
            self._shown = state
        return self._view.seen(eye, ahead, settings)

    def _opened(self, state):
        try:
            from mrs_simulator.world.rendering.view import View  # pybullet only where it is used
        except ModuleNotFoundError as error:
            if error.name != "pybullet":
                raise
            text = "camera: the Python package pybullet is missing (pip install pybullet)"
            raise SensorError(text) from None
        return View(self._team, state.pose, self._obstacles)
