"""pybullet's window on the world of a stage."""

import time

from mrs_simulator.nodes.stage.part import StagePart
from mrs_simulator.ros.node.node_parameters import VIEW
from mrs_simulator.ros.node.parameters import read

PERIOD = 0.05  # [s] of wall time between two pictures


class Window(StagePart):
    """Shows the world where the parameter ``~view`` asks for it, until the user closes it."""

    def __init__(self, world):
        self._world, self._last = world, 0.0
        self._view, self._team = None, None  # the team that it shows
        self._is_wanted = read(VIEW)

    def follow_team(self, scenario):
        """Show the robots that the world has now, if they are others."""
        world = self._world
        if not self._is_wanted or self._team is world.team:
            return
        if self._view is not None:
            self._view.close()
        from mrs_simulator.world.rendering.view import View  # pybullet only where it is used

        self._view = View(world.team, world.pose, world.obstacles, window=True)
        self._team = world.team

    def show(self):
        """Bring the window up to date at a display's rate."""
        now = time.monotonic()
        if self._view is None or now - self._last < PERIOD:
            return
        self._last = now
        if self._view.open:
            self._view.show(self._world.pose, self._world.spatial, self._world.time)
        else:
            self._view, self._is_wanted = None, False  # the user closed it
