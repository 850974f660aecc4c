"""Arms and what they carry as markers for RViz."""

import functools

from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from mrs_simulator.core.spatial import rotations
from mrs_simulator.nodes.display.solids import model_of, solids, turn_of
from mrs_simulator.pictures.arms import DARK, WOOD, arm_parts, placed_arms
from mrs_simulator.ros.message_forms.messages import load_pose

MOST_OF_ARM = 64  # [-] markers of one arm
LINE = 0.05  # [m] width of an arm that is drawn as a line


def arm_markers(kinds, place, turn, joints, solid):
    """Return ``(row, markers)`` of each robot that has an arm.

    Robots are at ``place`` (n, 3) [m], turned by ``turn`` (n, 4), ``joints`` (n, 1 + k) [rad] as of a
    ``State``.  Not ``solid`` ones are a line through the joints.
    """
    found = []
    for arms in placed_arms(kinds, place, rotations(turn), joints):
        for row, links in zip(arms.rows.tolist(), arms.links):
            found.append((row, _solid(arms.model, links) if solid else [_line(links)]))
    return found


@functools.lru_cache(maxsize=None)
def _models(model):
    return tuple(map(model_of, arm_parts(model)))


def _solid(model, links):
    markers = []
    for each, link in zip(_models(model), links):
        markers += solids(each, link[:3, 3], turn_of(link), None)
    return markers


def _line(links):
    line = Marker(type=Marker.LINE_STRIP, action=Marker.ADD, color=ColorRGBA(*DARK))
    line.scale.x, line.pose.orientation.w = LINE, 1.0
    line.points = [Point(*each) for each in links[:, :3, 3].tolist()]
    return line


def load_marker(load, carried):
    """Return the marker of a ``Load`` where it is ``carried``."""
    box = Marker(type=Marker.CUBE, action=Marker.ADD, color=ColorRGBA(*WOOD))
    box.scale, box.pose = Vector3(*load.size), load_pose(carried)
    return box
