"""One URDF of a base and its arm, for motion with forces."""

import copy
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

from mrs_simulator.vehicles.arms.models import data_file
from mrs_simulator.vehicles.importing.xml_reading import numbers_text, parse_xml, read_text

SHORT, THICK = 0.02, 0.05  # [m] length from which a link is touched; radius of what is touched
PREFIX = "arm/"  # of the arm's links and joints
LIGHTEST = "0.001", "1e-6"  # [kg], [kg m^2] of links without a mass, which pybullet takes for 1 kg


def assembled(kind):
    """Return the text of a URDF of the base of ``kind`` with its arm on it.

    What others touch of a link is a cylinder from its joint to the next one, or to the tool.  Joints that
    do not move the tool, such as those of fingers, are fixed.
    """
    base = parse_xml(read_text(kind.model), kind.model)
    for mesh in base.iter("mesh"):
        given = mesh.get("filename", "")
        if "://" not in given:
            mesh.set("filename", os.path.join(os.path.dirname(kind.model), given))
    path = data_file(kind.arm.model.file)
    arm = parse_xml(read_text(path), path)
    ends = _root(base), PREFIX + _root(arm)
    rods = _rods(kind.arm.chain)
    for link in arm.findall("link"):
        base.append(_bare(link))
        if link.get("name") in rods:
            base[-1].append(rods[link.get("name")])
    for joint in arm.findall("joint"):
        base.append(_prefixed(joint, kind.arm.model.joints))
    x, y, z, yaw = kind.arm.mount
    z -= kind.module.ride_height(kind.numbers)
    mount = ElementTree.SubElement(base, "joint", name=PREFIX + "mount", type="fixed")
    ElementTree.SubElement(
        mount, "origin", xyz="{} {} {}".format(x, y, z), rpy="0 0 {}".format(yaw)
    )
    ElementTree.SubElement(mount, "parent", link=ends[0])
    ElementTree.SubElement(mount, "child", link=ends[1])
    return ElementTree.tostring(base, encoding="unicode")


def _bare(link):
    """Return a link with its mass alone."""
    result = ElementTree.Element("link", name=PREFIX + link.get("name"))
    inertial = link.find("inertial")
    if inertial is not None:
        result.append(inertial)
        return result
    mass, inertia = LIGHTEST
    inertial = ElementTree.SubElement(result, "inertial")
    ElementTree.SubElement(inertial, "mass", value=mass)
    crossed = {"ixy": "0", "ixz": "0", "iyz": "0"}
    ElementTree.SubElement(inertial, "inertia", ixx=inertia, iyy=inertia, izz=inertia, **crossed)
    return result


def _rods(chain):
    """Return the ``collision`` of each moved link of a ``chain`` that is long enough, by its name."""
    ends = [each[:3, 3] for each in chain.before[1:]] + [chain.tool[:3, 3]]
    found = {}
    for name, end in zip(chain.links, ends):
        length = float(np.linalg.norm(end))
        if length < SHORT:
            continue
        x, y, z = end / length
        # z of the cylinder comes to lie along the link: pitch, then yaw.
        turn = 0.0, float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x))
        rod = ElementTree.Element("collision")
        where = {"xyz": numbers_text(0.5 * end), "rpy": numbers_text(turn)}
        ElementTree.SubElement(rod, "origin", where)
        geometry = ElementTree.SubElement(rod, "geometry")
        size = {"radius": repr(THICK), "length": repr(length)}
        ElementTree.SubElement(geometry, "cylinder", size)
        found[name] = rod
    return found


def _prefixed(joint, moving):
    result = copy.deepcopy(joint)
    if joint.get("name") not in moving:
        result.set("type", "fixed")
        for tag in ("mimic", "limit", "axis"):
            for each in result.findall(tag):
                result.remove(each)
    result.set("name", PREFIX + joint.get("name"))
    for tag in ("parent", "child"):
        end = result.find(tag)
        end.set("link", PREFIX + end.get("link"))
    for each in result.findall("dynamics"):
        result.remove(each)
    return result


def _root(robot):
    """Return the name of the link of ``robot`` that is no joint's child and no arm's."""
    below = {joint.find("child").get("link") for joint in robot.findall("joint")}
    names = [link.get("name") for link in robot.findall("link")]
    return next(n for n in names if n not in below and not n.startswith(PREFIX))
