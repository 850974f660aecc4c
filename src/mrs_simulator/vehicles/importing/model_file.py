"""The model of an imported robot for physics and displays: one base and two wheels, as a URDF.

``base_link`` lies midway between the wheels at the height of their axle.  The wheels roll on
spheres, stand at the drive's track and turn about y.  Products of inertia are left out.
"""

import atexit
import hashlib
import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np

from mrs_simulator.vehicles.importing.chassis import Mass
from mrs_simulator.vehicles.importing.placing import roll_pitch_yaw
from mrs_simulator.vehicles.importing.shapes import Part

JOINTS = ("left_wheel_joint", "right_wheel_joint")
HINGE = 0.1  # [-] of a steered wheel's mass that its hinge gets
_directory = None  # of this process's models


def model_path(text):
    """Return the path of a file with ``text``, in a directory that ends with this process.

    Its name is the hash of its content: pybullet and others that remember files by name find each
    time what they remember.
    """
    global _directory
    if _directory is None:
        _directory = tempfile.mkdtemp(prefix="mrs_simulator_models_")
        atexit.register(shutil.rmtree, _directory, ignore_errors=True)
    name = hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:24] + ".urdf"
    path = os.path.join(_directory, name)
    if not os.path.exists(path):
        with open(path, "w", encoding="utf-8", errors="replace") as file:
            file.write(text)
    return path


def model_text(name, base, wheels, track, radius):
    """Return the URDF text of a robot.

    ``base``: ``(Mass, Part)``; ``wheels``: the same of the left and of the right one, each in its
    own frame; ``track`` and ``radius`` [m] of the drive.
    """
    sides = zip(JOINTS, wheels, (0.5 * track, -0.5 * track))
    rows = [
        (joint[: -len("_joint")], (0.0, side, 0.0), (0.0, 1.0, 0.0), False, wheel)
        for joint, wheel, side in sides
    ]
    return pushed_text(name, base, rows, radius)


def pushed_text(name, base, wheels, radius):
    """Return the URDF text of a robot on wheels that forces apart from the solver push.

    ``base``: ``(Mass, Part)``; ``wheels``: name, place (3,) [m], axis (3,), whether it is steered, and
    ``(Mass, Part)`` of each.  A steered wheel hangs from ``<name>_hinge_joint``, whose link has the share
    ``HINGE`` of its mass; ``radius`` [m].
    """
    robot = ElementTree.Element("robot", name=name)
    _link(robot, "base_link", *base)
    for wheel, place, axis, steered, (mass, part) in wheels:
        parent = "base_link"
        if steered:
            parent = wheel + "_hinge"
            own = Mass(mass.mass * HINGE, np.zeros(3), mass.inertia * HINGE)
            _link(robot, parent, own, Part((), ()))
            _joint(robot, parent, "base_link", place, (0.0, 0.0, 1.0), parent + "_joint")
            share = 1.0 - HINGE
            mass = mass._replace(mass=mass.mass * share, inertia=mass.inertia * share)
            place = np.zeros(3)
        link = _link(robot, wheel, mass, part._replace(collisions=()))
        geometry = ElementTree.SubElement(ElementTree.SubElement(link, "collision"), "geometry")
        ElementTree.SubElement(geometry, "sphere", radius=repr(radius))
        _joint(robot, wheel, parent, place, axis, wheel + "_joint")
    return ElementTree.tostring(robot, encoding="unicode")


def rigid_text(name, base):
    """Return the URDF text of a robot of one link, ``base``: ``(Mass, Part)``."""
    robot = ElementTree.Element("robot", name=name)
    _link(robot, "base_link", *base)
    return ElementTree.tostring(robot, encoding="unicode")


def _joint(robot, child, parent, place, axis, name):
    joint = ElementTree.SubElement(robot, "joint", name=name, type="continuous")
    ElementTree.SubElement(joint, "origin", xyz=_spelled(place))
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "axis", xyz=_spelled(axis))


def _link(robot, name, mass, part):
    link = ElementTree.SubElement(robot, "link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_spelled(mass.centre))
    ElementTree.SubElement(inertial, "mass", value=repr(float(mass.mass)))
    xx, yy, zz = map(repr, mass.inertia.diagonal().tolist())
    ElementTree.SubElement(inertial, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")
    for kind, shapes in (("visual", part.visuals), ("collision", part.collisions)):
        for shape in shapes:
            _shape(ElementTree.SubElement(link, kind), shape, kind == "visual")
    return link


def _shape(element, shape, coloured):
    ElementTree.SubElement(
        element,
        "origin",
        xyz=_spelled(shape.transform[:3, 3]),
        rpy=_spelled(roll_pitch_yaw(shape.transform)),
    )
    geometry = ElementTree.SubElement(element, "geometry")
    if shape.form == "mesh":
        size = {"filename": shape.mesh, "scale": _spelled(shape.size)}
    elif shape.form == "box":
        size = {"size": _spelled(shape.size)}
    else:
        size = dict(zip(("radius", "length"), map(repr, shape.size.tolist())))
    ElementTree.SubElement(geometry, shape.form, **size)
    if coloured:
        name = "rgba " + _spelled(shape.colour)
        material = ElementTree.SubElement(element, "material", name=name)
        ElementTree.SubElement(material, "color", rgba=_spelled(shape.colour))


def _spelled(values):
    return " ".join(repr(float(value)) for value in values)
