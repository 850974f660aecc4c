"""pybullet's window on the world of a stage."""

import time

from mrs_simulator.ros.node.node_parameters import VIEW
from mrs_simulator.ros.node.parameters import read

PERIOD = 0.05  # [s] of wall time between two pictures


class Window:
    """Shows the world where the parameter ``~view`` asks for it, until the user closes it."""

    def __init__(self, world):
        self._world, self._view, self._last = world, None, 0.0
        if read(VIEW):
            self._open()

    def _open(self):
        from mrs_simulator.world.rendering.view import View  # pybullet only where it is used

        world = self._world
        self._view = View(world.team, world.pose, world.obstacles, window=True)

    def reopen(self):
        """Show the robots that the world has now."""
        if self._view is not None:
            self._view.close()
            self._open()

    def show(self):
        """Bring the window up to date at a display's rate."""
        now = time.monotonic()
        if self._view is None or now - self._last < PERIOD:
            return
        self._last = now
        if self._view.open:
            self._view.show(self._world.pose, self._world.spatial, self._world.time)
        else:
            self._view = None  # the user closed it
