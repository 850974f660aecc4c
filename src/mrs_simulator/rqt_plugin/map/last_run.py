"""The run that has ended, drawn faintly below what will start."""

from typing import NamedTuple

from mrs_simulator.pictures.scene import Scene
from mrs_simulator.rqt_plugin.map.drawing import draw_faint
from mrs_simulator.rqt_plugin.map.ground import TrailPainter
from mrs_simulator.rqt_plugin.map.shapes import Shapes
from mrs_simulator.rqt_plugin.map.trails import Trails

FAINT = 0.3  # [-] opacity


class LastRun(NamedTuple):
    """Where the robots of a run ended, and how they got there."""

    scene: Scene  # of the robots
    shapes: Shapes
    trails: Trails

    def draw(self, painter, style, frame, hidden):
        """Draw robots and trails; ``hidden``: the numbers of robots without one, None for all."""
        if hidden is not None:
            state = self.scene.state
            team = state.pose[:, :2], state.robots, hidden
            painter.save()
            painter.setOpacity(FAINT)
            TrailPainter().begin(painter, style, frame, self.trails, *team)
            painter.restore()
        draw_faint(painter, style, frame, self.scene, self.shapes, FAINT)
