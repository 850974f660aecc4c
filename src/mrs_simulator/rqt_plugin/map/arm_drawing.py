"""Draws arms and what they carry, as they are seen from above."""

import numpy as np

from mrs_simulator.pictures.arms import DARK, WOOD, load_outline, placed_arms
from mrs_simulator.pictures.robots import about_z, rotations
from mrs_simulator.rqt_plugin.map.style import faded, mixed, polygon
from mrs_simulator.rqt_plugin.qt.QtCore import Qt
from mrs_simulator.rqt_plugin.qt.QtGui import QColor, QPen
from mrs_simulator.state.columns import JOINTS, ORIENTATION

ARM = 0.07  # [m] width of an arm
LEAST_ARM = 1.5  # [px] of that
OPACITY = 0.55  # of a load: robots below it are seen


def draw_load(painter, style, frame, load, carried):
    """Draw a ``Load`` where it is ``carried``, a ``LoadState``."""
    outline = load_outline(load, carried)
    wood = QColor.fromRgbF(*WOOD)
    painter.setBrush(faded(wood, OPACITY))
    painter.setPen(QPen(mixed(wood, style.text, 0.4), 1.2 * style.unit))
    painter.drawPolygon(polygon(frame.to_screen(outline)))


def draw_arms(painter, style, frame, team):
    """Draw the arms of a ``MapTeam``, each a line through its joints to its tool."""
    kinds = team.kinds()
    if all(kind.arm is None for kind in team.shapes.distinct):
        return
    state = team.state
    place = np.column_stack([state.pose[:, :2], state.heights])
    turn = rotations(state.orientation) if state.has(ORIENTATION) else about_z(state.pose[:, 2])
    joints = state.joints if state.has(JOINTS) else None
    painter.setBrush(Qt.NoBrush)
    width = max(ARM * frame.scale, LEAST_ARM * style.unit)
    for arms in placed_arms(kinds, place, turn, joints):
        screen = frame.to_screen(arms.links[:, :, :2, 3].reshape(-1, 2)).reshape(
            len(arms.rows), -1, 2
        )
        for row, points in zip(arms.rows.tolist(), screen):
            if team.known[row]:
                for colour, share in ((style.base, 1.6), (QColor.fromRgbF(*DARK), 1.0)):
                    pen = QPen(colour, share * width, Qt.SolidLine, Qt.RoundCap, Qt.RoundJoin)
                    painter.setPen(pen)
                    painter.drawPolyline(polygon(points))
