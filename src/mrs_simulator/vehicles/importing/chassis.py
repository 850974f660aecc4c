"""The rigid parts of an imported robot: its base and its driven wheels, each with mass and shapes.

All links that no driven wheel carries are joined into one base, whatever their joints, which are
held at 0: a caster slides without friction, an arm is cargo.  Links without mass add none.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, shown
from mrs_simulator.vehicles.importing.placing import inverse_transform
from mrs_simulator.vehicles.importing.shapes import Part, found_shapes

ASKEW = 0.02  # [-] cosine by which a wheel's axis may lean out of the lateral
UNEVEN = 0.05  # [-] of the track by which wheels of a pair may stand off each other
LEAST_WHEELBASE = 1e-3  # [m]
TURNING = ("continuous", "revolute")


class Wheels(NamedTuple):
    """The driven wheels as one pair: where they stand and what they are."""

    centre: np.ndarray  # (3,) [m] in the root's frame: midway between left and right
    track: float  # [m] between left and right
    wheelbase: float  # [m] between front and rear wheels of a skid steer, 0 for one axle
    lefts: Tuple[str, ...]  # the joints' names
    rights: Tuple[str, ...]


class Mass(NamedTuple):
    """Mass [kg], its centre (3,) [m] and inertia (3, 3) [kg m^2] about the centre."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


def find_wheels(description, facts, notes):
    """Return the ``Wheels`` that ``facts`` name in ``description``; ``ScenarioError`` names the joint."""
    sides = [[description.joint(name, facts.source) for name in names] for names in facts.joints]
    names = [joint.name for side in sides for joint in side]
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError("{}: joint {} is named twice".format(facts.source, shown(name)))
    for joint in sides[0] + sides[1]:
        _check_wheel(description, joint, set(names), notes)
    left, right = (
        np.mean([description.places[joint.child][:3, 3] for joint in side], axis=0)
        for side in sides
    )
    track = left[1] - right[1]
    where = "{}: joints {} and {}".format(
        description.where, shown(sides[0][0].name), shown(sides[1][0].name)
    )
    if not track > 1e-4:
        raise ScenarioError(
            "{}: at y = {:g} m and {:g} m; wanted the left wheel left of the right one (y points "
            "left)".format(where, left[1], right[1])
        )
    if np.abs(left - right)[[0, 2]].max() > UNEVEN * track:
        text = "{}: {:g} m apart along x and {:g} m along z; wanted one axle"
        raise ScenarioError(text.format(where, abs(left[0] - right[0]), abs(left[2] - right[2])))
    return Wheels(
        0.5 * (left + right),
        float(track),
        _wheelbase(description, sides),
        *(tuple(joint.name for joint in side) for side in sides),
    )


def _wheelbase(description, sides):
    """Return how far [m] front and rear wheels stand apart; 0 unless each side has two, one behind the
    other."""
    if any(len(side) != 2 for side in sides):
        return 0.0
    ahead = np.array([[description.places[joint.child][0, 3] for joint in side] for side in sides])
    apart = float(np.abs(ahead[:, 0] - ahead[:, 1]).mean())
    return apart if apart > LEAST_WHEELBASE else 0.0


def _check_wheel(description, joint, names, notes):
    where = "{}: joint {}".format(description.where, shown(joint.name))
    if joint.type not in TURNING:
        text = "{}: type {}, wanted one of {} for a driven wheel"
        raise ScenarioError(text.format(where, joint.type, ", ".join(TURNING)))
    axis = description.places[joint.child][:3, :3] @ joint.axis
    if abs(axis[1]) < 1.0 - ASKEW:
        raise ScenarioError(
            "{}: turns about ({:.3g}, {:.3g}, {:.3g}); wanted the y axis of link {}, with x "
            "ahead".format(where, *axis, shown(description.root))
        )
    if axis[1] < 0.0:
        notes.append("{}: its axis points right; taken to turn forwards all the same".format(where))
    above = {each.child: each for each in description.joints.values()}
    parent = above.get(joint.parent)
    while parent is not None:
        if parent.name in names:
            raise ScenarioError(
                "{}: hangs from the wheel joint {}".format(where, shown(parent.name))
            )
        parent = above.get(parent.parent)


def gather(description, names, frame, packages, notes, needed=True):
    """Return the ``Mass`` and the ``Part`` of the links ``names``, in the frame ``frame`` (4, 4).

    ``frame`` is given in the root's frame; ``needed`` as in ``found_shapes``.
    """
    into = inverse_transform(frame)
    links = [(description.links[name], into @ description.places[name]) for name in names]
    parts = [found_shapes(link, place, packages, notes, needed) for link, place in links]
    part = Part(
        tuple(shape for each in parts for shape in each.visuals),
        tuple(shape for each in parts for shape in each.collisions),
    )
    return joined(
        [
            Mass(
                link.mass,
                place[:3, :3] @ link.centre + place[:3, 3],
                place[:3, :3] @ link.inertia @ place[:3, :3].T,
            )
            for link, place in links
        ]
    ), part


def joined(masses):
    """Return the ``Mass`` of all ``masses`` as one rigid body, by the parallel axis theorem."""
    total = sum(each.mass for each in masses)
    if total <= 0.0:
        return Mass(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = sum(each.mass * each.centre for each in masses) / total
    inertia = sum(each.inertia + each.mass * _about(each.centre - centre) for each in masses)
    return Mass(total, centre, inertia)


def about_origin(mass):
    """Return the inertia (3, 3) [kg m^2] of ``mass`` about its frame's origin."""
    return mass.inertia + mass.mass * _about(mass.centre)


def _about(offset):
    """Return the inertia of a unit mass at ``offset`` (3,): ``d.d E - d d^T`` [m^2]."""
    return offset @ offset * np.eye(3) - np.outer(offset, offset)
