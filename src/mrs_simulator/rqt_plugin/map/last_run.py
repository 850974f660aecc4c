"""The run that has ended, drawn faintly below what will start."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.pictures.scene import Scene
from mrs_simulator.rqt_plugin.map.drawing import draw_robots
from mrs_simulator.rqt_plugin.map.ground import TrailPainter
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.sprites import Sprites
from mrs_simulator.rqt_plugin.map.trails import Trails

FAINT = 0.3  # [-] opacity


class LastRun(NamedTuple):
    """Where the robots of a run ended, and how they got there."""

    scene: Scene  # of the robots
    shapes: Shapes
    trails: Trails

    def draw(self, painter, style, frame, hidden):
        """Draw robots and trails; ``hidden``: the numbers of robots without one, None for all."""
        state = self.scene.state
        painter.save()
        painter.setOpacity(FAINT)
        if hidden is not None:
            place = state.pose[:, :2]
            TrailPainter().begin(painter, style, frame, self.trails, place, state.robots, hidden)
        with np.errstate(invalid="ignore"):
            seen = frame.sees(frame.to_screen(state.pose), self.shapes.farthest * frame.scale)
        shown = seen & np.isfinite(state.pose).all(axis=1)
        draw_robots(painter, style, frame, self.scene, self.shapes, shown, Sprites())
        painter.restore()
