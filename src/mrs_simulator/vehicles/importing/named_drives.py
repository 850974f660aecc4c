"""Robots whose description names no drive: the user names it, and geometry gives the rest.

Wheels are joints that turn about a level axis, and hang from no other wheel.  One that hangs from a joint
with a vertical axis is steered: by a motor on a car, by the ground under a caster.
"""

import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.vehicles.drives.car import STEEPEST
from mrs_simulator.vehicles.drives.omnidirectional import AXES, mecanum_wheels, omni_wheels
from mrs_simulator.vehicles.drives.rotors import GRAVITY
from mrs_simulator.vehicles.importing.assembling import (
    Side,
    above_ground,
    add_torque,
    chosen_outline,
    friction_of,
    in_base,
    is_given,
    is_outlined,
    masses_of,
    note_held,
    outline_of,
    wheel_radius,
)
from mrs_simulator.vehicles.importing.chassis import ASKEW, TURNING, about_origin, gather, joined
from mrs_simulator.vehicles.importing.drive_facts import DriveFacts
from mrs_simulator.vehicles.importing.model_file import model_path, pushed_text, rigid_text
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.importing.shapes import extent
from mrs_simulator.vehicles.importing.xml_reading import Tag
from mrs_simulator.vehicles.quantities import quantity

DRIVES = ("differential", "car", "omnidirectional", "quadrotor")
UNEVEN = 0.05  # [-] of the wheels' distance by which they may stand off their places
PROPERTIES = {
    "arm": ("arm", "m"),
    "kf": ("thrust", "N/rpm^2"),
    "km": ("torque", "N m/rpm^2"),
    "thrust2weight": ("", ""),
    "drag_coeff_xy": ("", ""),
    "drag_coeff_z": ("", ""),
    "max_speed_kmh": ("", ""),
}


class Wheel(NamedTuple):
    """A wheel of a description, in the root's frame."""

    joint: str
    place: np.ndarray  # (3,) [m]
    axis: np.ndarray  # (3,), its length 1
    hinge: str  # the joint that steers it, "" for none


def wheels_of(description):
    """Return the ``Wheel`` list of ``description``, by x from front to rear, then from left to right."""
    above = {joint.child: joint for joint in description.joints.values()}
    found = {}
    for joint in description.joints.values():
        axis = description.places[joint.child][:3, :3] @ joint.axis
        if joint.type in TURNING and abs(axis[2]) < ASKEW:
            found[joint.name] = (joint, axis)
    result = []
    for joint, axis in found.values():
        hinge, parent = "", above.get(joint.parent)
        while parent is not None and parent.name not in found:
            turn = description.places[parent.child][:3, :3] @ parent.axis
            if parent.type in TURNING and abs(turn[2]) > 1.0 - ASKEW:
                hinge = parent.name
            parent = above.get(parent.parent)
        if parent is None:  # else it is a roller of another wheel
            result.append(Wheel(joint.name, description.places[joint.child][:3, 3], axis, hinge))
    return sorted(result, key=lambda wheel: (-round(wheel.place[0], 3), -wheel.place[1]))


def differential_facts(description):
    """Return the ``DriveFacts`` of a robot that drives all wheels which are not steered."""
    wheels = [
        wheel
        for wheel in wheels_of(description)
        if not wheel.hinge and abs(wheel.axis[1]) > 1.0 - ASKEW
    ]
    sides = [[wheel.joint for wheel in wheels if sign * wheel.place[1] > 0] for sign in (1, -1)]
    if not len(sides[0]) == len(sides[1]) > 0:
        wanted = "as many left as right, which turn about y (x points ahead)"
        raise _other_wheels(description, wheels_of(description), wanted)
    return DriveFacts(source=description.where, joints=tuple(map(tuple, sides)))


def _other_wheels(description, wheels, wanted):
    names = ", ".join(shown(wheel.joint) for wheel in wheels) or "none"
    return ScenarioError("{}: wheels: {}; wanted {}".format(description.where, names, wanted))


class Parts(NamedTuple):
    """A robot on wheels in the frame of its drive, level with the axles."""

    radius: float  # [m] of the wheels
    masses: list  # ``Mass`` of base and wheels
    friction: dict  # its key of ``wheels``, if it is known
    content: dict  # keys of the kind that all drives on wheels have


def _parts(description, wheels, centre, packages, given, where, notes):
    """Return the ``Parts`` of a robot on ``wheels``; its frame is at ``centre`` (3,) of the root's."""
    note_held(description, {name for wheel in wheels for name in (wheel.joint, wheel.hinge)}, notes)
    sides = [_side(description, wheel, packages, notes) for wheel in wheels]
    carried = {name for side in sides for name in side.names}
    others = [name for name in description.links if name not in carried]
    frame = transform_at(centre, np.zeros(3))
    base_mass, base = gather(description, others, frame, packages, notes, not is_outlined(given))
    radius = wheel_radius(_wheel_facts(description, given, where), sides, notes)
    shapes = [shape for side in sides for shape in in_base(side.part, side.frame, frame)]
    shapes += base.collisions
    outline = chosen_outline(given, tuple(shapes), radius, 0.0, description.where)
    base = base._replace(collisions=above_ground(base.collisions, radius, notes))
    base_mass, masses = masses_of(description, base_mass, sides, radius, given, where, notes)
    places = [(wheel.place - centre) * (1.0, 1.0, 0.0) for wheel in wheels]
    names = [_name(row) for row in range(len(wheels))]
    rows = zip(names, places, wheels, masses, sides)
    model = pushed_text(
        description.name,
        (base_mass, base),
        [
            (name, place, wheel.axis, bool(wheel.hinge), (mass, side.part))
            for name, place, wheel, mass, side in rows
        ],
        radius,
    )
    masses = [mass._replace(centre=mass.centre + place) for mass, place in zip(masses, places)]
    friction = friction_of(description, sorted(carried))
    return Parts(
        radius,
        [base_mass] + masses,
        {} if friction is None else {"friction": friction},
        _common(description, model, outline, [base_mass] + masses),
    )


def _name(row):
    return "wheel{}".format(row + 1)


def _side(description, wheel, packages, notes):
    names = description.below(description.joints[wheel.hinge or wheel.joint])
    frame = transform_at(wheel.place, np.zeros(3))
    return Side(names, frame, *gather(description, names, frame, packages, notes, needed=False))


def _wheel_facts(description, given, where):
    own = given.get("wheels") if is_given(given, "wheels", "radius") else {}
    radius = quantity(own["radius"], "m", where + ": wheels.radius", above=0.0) if own else None
    return DriveFacts(description.where, ((), ()), radius=radius)


def _common(description, model, outline, masses):
    return {
        "name": description.name,
        "model": model_path(model),
        "body": outline,
        "mass": sum(each.mass for each in masses),
        "inertia": float(about_origin(joined(masses))[2, 2]),
        "sources": {"mass": description.where, "model": description.where},
    }


def _limits(tops, given, where, source):
    """Return the limits ``firmware`` of ``tops``, axis to speed or None; one is to be known or given."""
    for axis, top in tops.items():
        if top is None and not is_given(given, "limits", "firmware", axis, "max"):
            unit = "m/s" if axis.startswith("linear") else "rad/s"
            raise ScenarioError(
                "{}: limits.firmware.{}.max: nothing given, and {} does not give it; wanted a "
                "number [{}]".format(where, axis, source, unit)
            )
    return {"firmware": {axis: {"max": top} for axis, top in tops.items() if top is not None}}


def _rim(description, wheels, radius):
    """Return the greatest speed [m/s] of the wheels' rims, None where their joints have no limit."""
    rate = min(description.joints[wheel.joint].velocity for wheel in wheels)
    return rate * radius if math.isfinite(rate) else None


def car(description, packages, given, where):
    """Return content and notes of a car: two steered wheels in front of two that are not."""
    notes, wheels = [], wheels_of(description)
    front = [wheel for wheel in wheels if wheel.hinge]
    rear = [wheel for wheel in wheels if not wheel.hinge]
    wheelbase = front[0].place[0] - rear[0].place[0] if front and rear else 0.0
    if not (len(front) == len(rear) == 2 and wheelbase > 0.0):
        raise _other_wheels(
            description, wheels, "four, the front two on joints with a vertical axis"
        )
    centre = 0.5 * (rear[0].place + rear[1].place)
    parts = _parts(description, wheels, centre, packages, given, where, notes)
    ahead = joined(parts.masses).centre[0]
    numbers = {
        "wheelbase": float(wheelbase),
        "track": float(rear[0].place[1] - rear[1].place[1]),
        "radius": parts.radius,
        "mass_ahead": float(min(max(ahead, 0.01 * wheelbase), wheelbase)),
        "joints": [_name(wheels.index(wheel)) + "_hinge_joint" for wheel in front],
        **parts.friction,
        **_steering(description, front, given, where),
    }
    limits = _limits(
        {"linear.x": _rim(description, rear, parts.radius)}, given, where, description.where
    )
    content = dict(parts.content, drive="car", wheels=numbers, limits=limits)
    # of one motor, under half of the weight
    add_torque(content, 2, given, description.where, notes)
    return content, notes


def _steering(description, front, given, where):
    """Return angle and rate of the steering by the hinges' limits, where they have any."""
    hinges = [description.joints[wheel.hinge] for wheel in front]
    angle = min(min(abs(each.lower), abs(each.upper)) for each in hinges)
    rate = min(each.velocity for each in hinges)
    result = {"steering_rate": rate} if math.isfinite(rate) else {}
    if math.isfinite(angle) and angle > 0.0:
        return dict(result, steering=min(angle, STEEPEST))
    if not is_given(given, "wheels", "steering"):
        text = "{}: wheels.steering: nothing given, and joint {} has no limits; wanted an angle"
        raise ScenarioError(text.format(where, shown(hinges[0].name)))
    return result


def omnidirectional(description, packages, given, where):
    """Return content and notes of a base on three or four omni wheels, or on four mecanum wheels."""
    notes = []
    wheels = [wheel for wheel in wheels_of(description) if not wheel.hinge]
    if len(wheels) not in (3, 4):
        raise _other_wheels(description, wheels, "three or four that are not steered")
    centre = np.mean([wheel.place for wheel in wheels], axis=0)
    places = np.array([wheel.place[:2] - centre[:2] for wheel in wheels])
    lateral = all(abs(wheel.axis[1]) > 1.0 - ASKEW for wheel in wheels)
    if lateral and len(wheels) == 4:
        layout, rolling = _mecanum(description, places, notes)
    else:
        layout, rolling = _omni(description, wheels, places)
    parts = _parts(description, wheels, centre, packages, given, where, notes)
    rim = _rim(description, wheels, parts.radius)
    tops = [None if rim is None else rim / float(each) for each in np.abs(rolling).max(axis=0)]
    numbers = dict(layout, radius=parts.radius, **parts.friction)
    numbers["joints"] = [_name(row) + "_joint" for row in range(len(wheels))]
    if rim is not None:
        numbers["speed"] = rim / parts.radius
    limits = _limits(dict(zip(AXES, tops)), given, where, description.where)
    content = dict(parts.content, drive="omnidirectional", wheels=numbers, limits=limits)
    add_torque(content, len(wheels), given, description.where, notes)
    return content, notes


def _mecanum(description, places, notes):
    wheelbase, track = 2.0 * np.abs(places).mean(axis=0)
    corners = 0.5 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * (wheelbase, track)
    _check_places(description, places, corners)
    notes.append("{}: four wheels abreast: taken as mecanum wheels".format(description.where))
    layout = {"layout": "mecanum", "wheelbase": float(wheelbase), "track": float(track)}
    return layout, mecanum_wheels(wheelbase, track)


def _omni(description, wheels, places):
    """Return the layout of wheels that stand across the rays from their centre, and how they roll."""
    angles = np.arctan2(places[:, 1], places[:, 0])
    distance = float(np.hypot(*places.T).mean())
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    _check_places(description, places, distance * rays)
    for wheel, ray in zip(wheels, rays):
        if abs(wheel.axis[:2] @ ray) < 1.0 - ASKEW:
            text = (
                "{}: joint {}: turns about ({:.3g}, {:.3g}, {:.3g}); wanted the ray from the centre"
            )
            raise ScenarioError(text.format(description.where, shown(wheel.joint), *wheel.axis))
    layout = {"layout": "omni", "angles": angles.tolist(), "distance": distance}
    return layout, omni_wheels(angles, distance)


def _check_places(description, places, wanted):
    """Raise ``ScenarioError`` for wheels at ``places`` (w, 2) that are not where they are ``wanted``."""
    off = np.hypot(*(places - wanted).T)
    if off.max() > UNEVEN * np.hypot(*wanted.T).max():
        text = "{}: wheels up to {:.3g} m off a circle or a rectangle about their centre"
        raise ScenarioError(text.format(description.where, off.max()))


def quadrotor(description, packages, given, where):
    """Return content and notes of a quadrotor: one rigid body, its rotors from a <properties> tag."""
    notes = []
    note_held(description, (), notes)
    mass, part = gather(description, list(description.links), np.eye(4), packages, notes, True)
    if not mass.mass > 0.0 or not mass.inertia.diagonal().min() > 0.0:
        raise ScenarioError(
            "{}: no link has mass and inertia; wanted <inertial> tags".format(description.where)
        )
    if not part.collisions:
        outline_of((), 0.0, 0.0, description.where)
    low, high = extent(part.collisions)
    frame = transform_at((*mass.centre[:2], low[2]), np.zeros(3))  # where it stands
    mass, part = gather(description, list(description.links), frame, packages, [], True)
    low, high = extent(part.collisions)
    reach = float(np.abs([low[:2], high[:2]]).max())
    outline = {} if is_outlined(given) else {"radius": reach, "height": float(high[2])}
    content = _common(description, rigid_text(description.name, (mass, part)), outline, [mass])
    numbers, fastest = _flight(description, mass.mass)
    numbers["inertia"] = dict(zip(("xx", "yy", "zz"), mass.inertia.diagonal().tolist()))
    tops = dict.fromkeys(("linear.x", "linear.y", "linear.z", "angular.z"))
    tops["linear.x"] = tops["linear.y"] = fastest
    limits = _limits(tops, given, where, description.where)
    return dict(content, drive="quadrotor", flight=numbers, limits=limits), notes


def _flight(description, mass):
    """Return the section ``flight`` in a <properties> tag, and a top speed [m/s] or None.

    As gym-pybullet-drones writes it: thrust ``kf`` and torque ``km`` per rpm^2 of each rotor.
    """
    element = description.xml.find("properties")
    if element is None:
        return {}, None
    tag, result = Tag(element, description.where + ": properties"), {}
    known = {key: tag.number(key, above=0.0) for key in PROPERTIES if element.get(key) is not None}
    for key, (name, unit) in PROPERTIES.items():
        if key in known and name:
            result[name] = "{!r} {}".format(known[key], unit)
    if "kf" in known and "thrust2weight" in known:
        speed = math.sqrt(known["thrust2weight"] * mass * GRAVITY / (4.0 * known["kf"]))
        result["speed"] = "{!r} rpm".format(speed)
    if "drag_coeff_xy" in known and "drag_coeff_z" in known:
        result["drag"] = {"across": known["drag_coeff_xy"], "up": known["drag_coeff_z"]}
    return result, known["max_speed_kmh"] / 3.6 if "max_speed_kmh" in known else None


ASSEMBLED = {"car": car, "omnidirectional": omnidirectional, "quadrotor": quadrotor}
