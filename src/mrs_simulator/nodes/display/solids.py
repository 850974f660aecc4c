"""Robots as solid parts for RViz: a marker for each part of the model of a robot's kind."""

import functools
from typing import Any, NamedTuple, Tuple

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from mrs_simulator.core.spatial import quaternion_product, rotated
from mrs_simulator.vehicles.importing.placing import roll_pitch_yaw
from mrs_simulator.vehicles.visuals import part_transforms, visual_parts, volume

FORMS = {"box": Marker.CUBE, "cylinder": Marker.CYLINDER, "sphere": Marker.SPHERE}


class Model(NamedTuple):
    """The parts of one kind, p of them."""

    forms: Tuple[int, ...]  # types of markers
    scales: Tuple[Tuple[float, ...], ...]  # [m] along x, y, z
    colours: Tuple[Any, ...]  # None for the part that has the robot's own: the largest
    places: Any  # (p, 3) [m] in the robot's frame
    turns: Any  # (p, 4), unit quaternions


@functools.lru_cache(maxsize=64)
def model(kind):
    """Return the ``Model`` of a ``Kind``."""
    parts = visual_parts(kind)
    largest = int(np.argmax([volume(part) for part in parts]))
    made = model_of(parts)
    return made._replace(colours=made.colours[:largest] + (None,) + made.colours[largest + 1 :])


def model_of(parts):
    """Return the ``Model`` of ``parts``, each in its own colour."""
    transforms = part_transforms(parts)
    colours = [ColorRGBA(*part.colour) for part in parts]
    return Model(
        tuple(FORMS[part.form] for part in parts),
        tuple(_scale(part) for part in parts),
        tuple(colours),
        transforms[:, :3, 3],
        np.array([turn_of(each) for each in transforms]),
    )


def _scale(part):
    size = part.size
    if part.form == "box":
        return size
    across = 2.0 * size[0]
    return (across, across, size[1] if part.form == "cylinder" else across)


def turn_of(transform):
    """Return the unit quaternion (4,) of a ``transform`` (4, 4)."""
    x, y, z = (
        np.append(np.sin(0.5 * angle) * axis, np.cos(0.5 * angle))
        for angle, axis in zip(roll_pitch_yaw(transform), np.eye(3))
    )
    return quaternion_product(z, quaternion_product(y, x))


def solids(of_kind, place, turn, colour):
    """Return the markers of a robot of the ``Model`` at ``place`` (3,) [m], turned by ``turn`` (4,)."""
    places = (np.asarray(place) + rotated(turn, of_kind.places)).tolist()
    turns = quaternion_product(turn, of_kind.turns).tolist()
    markers = []
    for row, form in enumerate(of_kind.forms):
        marker = Marker(type=form, action=Marker.ADD, color=of_kind.colours[row] or colour)
        marker.scale.x, marker.scale.y, marker.scale.z = of_kind.scales[row]
        marker.pose = Pose(Point(*places[row]), Quaternion(*turns[row]))
        markers.append(marker)
    return markers
