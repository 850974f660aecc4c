"""A run as it would go on, drawn as ghosts over the one that is shown."""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.pictures.scene import GHOST_SHOWN, ghosts_at
from mrs_simulator.rqt_plugin.map.drawing import draw_faint
from mrs_simulator.rqt_plugin.map.forecast import draw_forecast, paths_in_space


class LookAhead(NamedTuple):
    """Where the robots begin and end, and how they get there."""

    pose: Any  # (k, n, 3) [m, m, rad]
    moved: tuple = ()  # rows of robots that are put elsewhere at the beginning

    def in_space(self, scene):
        """Return the same as ``Ghosts`` in the ``scene`` of the robots, at the heights of these."""
        state, shades = scene.state, np.asarray(scene.shades)
        moved, heights = list(self.moved), state.heights
        rows = moved + list(range(len(state.robots)))
        pose = np.concatenate([self.pose[0, moved], self.pose[-1]])
        paths = paths_in_space(self.pose[..., :2], heights)
        kinds = [scene.kinds[row] for row in rows]
        return ghosts_at(kinds, pose, heights[rows], shades[rows], paths, shades)

    def draw(self, painter, style, frame, scene, shapes):
        """Draw paths, robots at their ends, and those put elsewhere where they begin.

        ``scene``: the ``Scene`` of the robots, with their ``shapes``.
        """
        draw_forecast(painter, style, frame, self.pose[..., :2], scene.state.robots)
        for row, rows in ((0, self.moved), (-1, None)):
            ghosts = scene._replace(state=scene.state.replace(pose=self.pose[row]))
            draw_faint(painter, style, frame, ghosts, shapes, GHOST_SHOWN, rows)
