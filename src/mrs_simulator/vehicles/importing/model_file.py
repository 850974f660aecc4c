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

from mrs_simulator.vehicles.importing.placing import roll_pitch_yaw

JOINTS = ("left_wheel_joint", "right_wheel_joint")
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
    robot = ElementTree.Element("robot", name=name)
    _link(robot, "base_link", *base)
    sides = zip(JOINTS, wheels, (0.5 * track, -0.5 * track))
    for joint_name, (mass, part), side in sides:
        link_name = joint_name[: -len("_joint")]
        link = _link(robot, link_name, mass, part._replace(collisions=()))
        geometry = ElementTree.SubElement(ElementTree.SubElement(link, "collision"), "geometry")
        ElementTree.SubElement(geometry, "sphere", radius=repr(radius))
        joint = ElementTree.SubElement(robot, "joint", name=joint_name, type="continuous")
        ElementTree.SubElement(joint, "origin", xyz=_spelled((0.0, side, 0.0)))
        ElementTree.SubElement(joint, "parent", link="base_link")
        ElementTree.SubElement(joint, "child", link=link_name)
        ElementTree.SubElement(joint, "axis", xyz="0 1 0")
    return ElementTree.tostring(robot, encoding="unicode")


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
