"""What a URDF says of a robot's links and joints, checked."""

from typing import Any, Dict, NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.fields import unknown_name
from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.importing.xml_reading import Tag, parse_xml

JOINT_TYPES = ("fixed", "continuous", "revolute", "prismatic", "floating", "planar")
GREY = (0.6, 0.6, 0.6, 1.0)  # [-] red, green, blue, opacity of what has no material
SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "mesh": ()}


class Shape(NamedTuple):
    """A body of a visual or a collision, placed in its link."""

    form: str  # box, cylinder, sphere or mesh
    # [m] box (3,), cylinder radius and length (2,), sphere radius (1,); mesh: scale
    size: np.ndarray
    transform: np.ndarray  # (4, 4) into the link's frame
    colour: Tuple[float, ...] = GREY
    mesh: str = ""  # the file as the description names it
    where: str = ""  # for error messages


class Link(NamedTuple):
    """A link: mass [kg], its centre (3,) [m], inertia (3, 3) [kg m^2] about the centre, link's axes."""

    name: str
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    visuals: Tuple[Shape, ...]
    collisions: Tuple[Shape, ...]


class Joint(NamedTuple):
    """A joint: ``transform`` (4, 4) takes the child's frame into the parent's."""

    name: str
    type: str
    parent: str
    child: str
    transform: np.ndarray
    axis: np.ndarray  # (3,) of length 1, in the child's frame
    velocity: float  # [rad/s] or [m/s] the greatest, inf where none is given
    lower: float = -np.inf  # [rad] or [m], where the joint ends
    upper: float = np.inf
    effort: float = np.inf  # [N m] or [N] the greatest


class Description(NamedTuple):
    """A robot: links and joints by name, the root link's name, and where each link is."""

    name: str
    where: str  # the file, for error messages
    links: Dict[str, Link]
    joints: Dict[str, Joint]
    root: str
    places: Dict[str, np.ndarray]  # link -> (4, 4) into the root's frame, all joints at 0
    xml: Any  # the root element

    def joint(self, name, where):
        """Return the joint ``name``; ``ScenarioError`` with ``where`` if there is none."""
        if name not in self.joints:
            raise ScenarioError(unknown_name(where + ": joint", name, self.joints))
        return self.joints[name]

    def below(self, joint):
        """Return the names of all links that move with ``joint``."""
        found = [joint.child]
        for name in found:
            found += [each.child for each in self.joints.values() if each.parent == name]
        return found


def read_description(text, where):
    """Return the ``Description`` in the URDF ``text``; ``ScenarioError`` names the link or joint."""
    xml = parse_xml(text, where)
    if xml.tag != "robot":
        raise ScenarioError("{}: <{}>, wanted a <robot>".format(where, xml.tag))
    top = Tag(xml, where)
    colours = _colours(top, {})
    links = _by_name(top, "link", lambda tag, name: _read_link(tag, name, colours))
    joints = _by_name(top, "joint", _read_joint)
    if not links:
        raise ScenarioError("{}: wanted at least one <link>".format(where))
    root = _root(links, joints, where)
    places = _placed_links(links, joints, root, where)
    return Description(xml.get("name", "robot"), where, links, joints, root, places, xml)


def _by_name(top, kind, read):
    result = {}
    for tag in top.children(kind):
        name = tag.attribute("name")
        if name in result:
            raise ScenarioError("{}: the name is taken".format(tag.where))
        result[name] = read(tag, name)
    return result


def _origin(tag):
    origin = tag.child("origin")
    if origin is None:
        return np.eye(4)
    return transform_at(origin.numbers("xyz", 3, "0 0 0"), origin.numbers("rpy", 3, "0 0 0"))


def _colours(tag, known):
    """Return ``known`` colours, name to (4,), with those of the materials in ``tag``."""
    result = dict(known)
    for material in tag.children("material"):
        colour = material.child("color")
        if colour is not None:
            result[material.attribute("name", "")] = tuple(colour.numbers("rgba", 4).tolist())
    return result


def _read_link(tag, name, colours):
    inertial = tag.child("inertial")
    mass, transform, inertia = 0.0, np.eye(4), np.zeros((3, 3))
    if inertial is not None:
        mass = inertial.needed("mass").number("value", low=0.0)
        transform = _origin(inertial)
        if mass > 0.0:
            inertia = _read_inertia(inertial.needed("inertia"))
    turn = transform[:3, :3]
    return Link(
        name=name,
        mass=mass,
        centre=transform[:3, 3],
        inertia=turn @ inertia @ turn.T,
        visuals=tuple(_read_shape(each, colours) for each in tag.children("visual")),
        collisions=tuple(_read_shape(each, colours) for each in tag.children("collision")),
    )


def _read_inertia(tag):
    xx, yy, zz = (tag.number(name, low=0.0) for name in ("ixx", "iyy", "izz"))
    xy, xz, yz = (tag.number(name, "0") for name in ("ixy", "ixz", "iyz"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if np.linalg.eigvalsh(inertia)[0] < -1e-9 * max(xx, yy, zz):
        raise ScenarioError(
            "{}: not that of any body: a principal one is negative".format(tag.where)
        )
    return inertia


def _read_shape(tag, colours):
    geometry = tag.needed("geometry")
    forms = [form for form in SIZES if geometry.child(form) is not None]
    if len(forms) != 1:
        raise ScenarioError("{}: wanted one of {}".format(geometry.where, ", ".join(SIZES)))
    body = geometry.child(forms[0])
    if forms[0] == "mesh":
        size, mesh = body.numbers("scale", 3, "1 1 1"), body.attribute("filename")
    else:
        counts = {"size": 3}
        given = [body.numbers(key, counts.get(key, 1), above=0.0) for key in SIZES[forms[0]]]
        size, mesh = np.concatenate(given), ""
    named = [each.attribute("name", "") for each in tag.children("material")]
    colour = _colours(tag, colours).get(named[0], GREY) if named else GREY
    return Shape(forms[0], size, _origin(tag), colour, mesh, tag.where)


def _read_joint(tag, name):
    kind = tag.attribute("type")
    if kind not in JOINT_TYPES:
        raise ScenarioError(
            "{}: type: {}, wanted one of {}".format(tag.where, shown(kind), ", ".join(JOINT_TYPES))
        )
    axis, limit = tag.child("axis"), tag.child("limit")
    moves = axis is not None and kind != "fixed"  # a fixed joint's axis may be anything
    along = axis.numbers("xyz", 3) if moves else np.array([1.0, 0.0, 0.0])
    length = np.linalg.norm(along)
    if not 0.0 < length < np.inf:
        raise ScenarioError(
            "{}: xyz: its length is {:g}, wanted above 0".format(axis.where, length)
        )
    velocity = effort = np.inf
    if limit is not None and limit.element.get("velocity") is not None:
        velocity = limit.number("velocity", low=0.0) or np.inf
    if limit is not None and limit.element.get("effort") is not None:
        effort = limit.number("effort", low=0.0) or np.inf
    return Joint(
        name=name,
        type=kind,
        parent=tag.needed("parent").attribute("link"),
        child=tag.needed("child").attribute("link"),
        transform=_origin(tag),
        axis=along / length,
        velocity=velocity,
        effort=effort,
        **_read_ends(kind, limit),
    )


def _read_ends(kind, limit):
    """Return where a joint ends, ``lower`` and ``upper`` [rad or m]: nowhere unless its limits say so."""
    if kind not in ("revolute", "prismatic") or limit is None:
        return {}
    if limit.element.get("lower") is None and limit.element.get("upper") is None:
        return {}
    lower, upper = limit.number("lower", "0"), limit.number("upper", "0")
    if lower > upper:
        text = "{}: lower {:g} is above upper {:g}, wanted the other way round"
        raise ScenarioError(text.format(limit.where, lower, upper))
    return {"lower": lower, "upper": upper}


def _root(links, joints, where):
    parents = {}
    for joint in joints.values():
        at = "{}: joint {}".format(where, shown(joint.name))
        for name in (joint.parent, joint.child):
            if name not in links:
                raise ScenarioError(unknown_name(at + ": link", name, links))
        if joint.child in parents:
            text = "{}: link {} is the child of joint {}, too"
            raise ScenarioError(text.format(at, shown(joint.child), shown(parents[joint.child])))
        parents[joint.child] = joint.name
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        found = ", ".join(map(shown, roots[:5])) or "none"
        raise ScenarioError("{}: links without a parent: {}; wanted one".format(where, found))
    return roots[0]


def _placed_links(links, joints, root, where):
    places, beneath = {root: np.eye(4)}, {}
    for joint in joints.values():
        beneath.setdefault(joint.parent, []).append(joint)
    waiting = [root]
    for name in waiting:
        for joint in beneath.get(name, ()):
            places[joint.child] = places[name] @ joint.transform
            waiting.append(joint.child)
    for name in links:
        if name not in places:
            raise ScenarioError("{}: link {} hangs from itself".format(where, shown(name)))
        if not np.all(np.isfinite(places[name])):
            raise ScenarioError("{}: link {} is infinitely far away".format(where, shown(name)))
    return places
