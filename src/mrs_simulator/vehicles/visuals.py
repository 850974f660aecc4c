"""Visuals of a kind of robot for displays: solid parts, and a URDF.

Both are data alone: of a kind that came over a topic no file is opened.
"""

import functools
from xml.etree import ElementTree

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.importing.xml_reading import numbers_text
from mrs_simulator.vehicles.portable import model_shape
from mrs_simulator.vehicles.shape import outline_parts, ride_height

SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


@functools.lru_cache(maxsize=64)
def visual_parts(kind):
    """Return the ``Part`` tuple of a ``Kind``, in the frame of a robot's centre on the ground.

    Parts of its shape or model, else its outline and nose.
    """
    parts = kind.shape
    if not parts and kind.model:
        try:
            parts = model_shape(kind.model)
        except (ScenarioError, OSError):
            parts = ()
    up = ride_height(kind)
    return tuple(
        part._replace(place=(*part.place[:2], part.place[2] + up, *part.place[3:]))
        for part in parts or outline_parts(kind)
    )


def part_transforms(parts):
    """Return where ``parts`` are in their robot's frame, transforms (p, 4, 4)."""
    return np.array([transform_at(part.place[:3], part.place[3:]) for part in parts])


def volume(part):
    """Return the volume [m^3] of the box around ``part``."""
    size = part.size
    if part.form == "box":
        return float(np.prod(size))
    return float((2.0 * size[0]) ** 2 * (size[1] if part.form == "cylinder" else 2.0 * size[0]))


def description(kind):
    """Return the URDF of one link ``base_link`` that looks as the ``Kind`` does, on the ground.

    Only that link's transform is needed to show it, whatever joints the robot has.
    """
    robot = ElementTree.Element("robot", name=kind.name)
    link = ElementTree.SubElement(robot, "link", name="base_link")
    for place, part in enumerate(visual_parts(kind)):
        visual = ElementTree.SubElement(link, "visual")
        where = {"xyz": numbers_text(part.place[:3]), "rpy": numbers_text(part.place[3:])}
        ElementTree.SubElement(visual, "origin", where)
        geometry = ElementTree.SubElement(visual, "geometry")
        sizes = (numbers_text(part.size),) if part.form == "box" else map(repr, part.size)
        ElementTree.SubElement(geometry, part.form, dict(zip(SIZES[part.form], sizes)))
        material = ElementTree.SubElement(visual, "material", name="part_{}".format(place))
        ElementTree.SubElement(material, "color", rgba=numbers_text(part.colour))
    return ElementTree.tostring(robot, encoding="unicode")
