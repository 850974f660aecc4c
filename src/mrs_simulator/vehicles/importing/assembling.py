"""The content of a kind's file, made of a robot's description and what is known of its drive."""

import math

import numpy as np

from mrs_simulator.scenario.reading import ScenarioError, number, shown
from mrs_simulator.vehicles.importing.chassis import Mass, about_origin, find_wheels, gather
from mrs_simulator.vehicles.importing.model_file import JOINTS, model_path, model_text
from mrs_simulator.vehicles.importing.shapes import extent
from mrs_simulator.vehicles.quantities import quantity

OFF = 0.05  # [-] by which the drive's numbers may differ from the description's without a word
BELOW = 0.1  # [-] of a wheel's radius that a body may reach below the ground
WHEEL_SHARE = 0.02  # [-] of the robot's mass that a wheel without mass gets
AXES = ("linear.x", "angular.z")
UNITS = ("m/s", "rad/s")
BODY = ("front", "rear", "width", "height")
TORQUE, FRICTION = 6.0, 0.9  # [N m] at a wheel, [-]: of kinds that give none
GRAVITY = 9.81  # [m/s^2]


def assembled(description, facts, packages, given, where):
    """Return the content of the kind and the notes, as ``imported`` does."""
    notes = list(facts.notes)
    wheels = find_wheels(description, facts, notes)
    note_held(description, wheels.lefts + wheels.rights, notes)
    frame = np.eye(4)
    frame[:3, 3] = wheels.centre
    outlined = is_outlined(given)
    sides = [
        side_of(description, names, packages, notes) for names in (wheels.lefts, wheels.rights)
    ]
    driven = {name for side in sides for name in side.names}
    others = [name for name in description.links if name not in driven]
    base_mass, base = gather(description, others, frame, packages, notes, not outlined)
    radius = wheel_radius(facts, sides, notes)
    spacing = _spacing(facts, wheels, notes)
    track = _track(facts, wheels, spacing, notes)
    placed = [shape for side in sides for shape in in_base(side.part, side.frame, frame)]
    shapes = base.collisions + tuple(placed)
    outline = chosen_outline(given, shapes, radius, wheels.track, description.where)
    base = base._replace(collisions=above_ground(base.collisions, radius, notes))
    base_mass, wheel_masses = masses_of(description, base_mass, sides, radius, given, where, notes)
    every = [base_mass] + [
        mass._replace(centre=mass.centre + side.frame[:3, 3] - wheels.centre)
        for mass, side in zip(wheel_masses, sides)
    ]
    content = {
        "name": description.name,
        "drive": "differential",
        "model": model_path(
            model_text(
                description.name,
                (base_mass, base),
                [(mass, side.part) for mass, side in zip(wheel_masses, sides)],
                spacing if wheels.wheelbase else track,
                radius,
            )
        ),
        "body": outline,
        "mass": sum(each.mass for each in every),
        "inertia": float(sum(about_origin(each)[2, 2] for each in every)),
        "wheels": {"track": track, "radius": radius, "joints": list(JOINTS)},
        "limits": {"firmware": _limits(description, facts, wheels, radius, track, given, where)},
    }
    friction = friction_of(description, [names for side in sides for names in side.names])
    if friction is not None:
        content["wheels"]["friction"] = friction
    if facts.torque is not None:
        content["wheels"]["torque"] = facts.torque
    else:
        count = len(wheels.lefts + wheels.rights)
        add_torque(content, count, given, description.where, notes)
    if wheels.wheelbase:
        content["wheels"].update(spacing=spacing, wheelbase=wheels.wheelbase)
    for key, value in (("command_timeout", facts.timeout), ("odometry_rate", facts.rate)):
        if value is not None:
            content[key] = value
    content["sources"] = _sources(content, facts, description)
    return content, tuple(notes)


def is_outlined(given):
    """Return whether the keys ``given`` hold a whole ``body``."""
    body = given.get("body")
    return isinstance(body, dict) and (
        {"radius", "height"} <= body.keys() or set(BODY) <= body.keys()
    )


def chosen_outline(given, shapes, radius, track, where):
    """Return the content of ``body`` that ``given`` lacks, of the collision ``shapes``."""
    if is_outlined(given):
        return {}
    outline = outline_of(shapes, radius, track, where)
    body = given.get("body")
    return {"height": outline["height"]} if isinstance(body, dict) and "radius" in body else outline


def note_held(description, driven, notes):
    """Add to ``notes`` the joints that are held: all but those called ``driven``."""
    for joint in description.joints.values():
        if joint.type != "fixed" and joint.name not in driven:
            text = "{}: joint {} ({}) is held at 0"
            notes.append(text.format(description.where, shown(joint.name), joint.type))


class Side:
    """The driven wheel of one side, or the pair of them as one: links, frame, mass and shapes."""

    def __init__(self, names, frame, mass, part):
        self.names, self.frame, self.mass, self.part = names, frame, mass, part


def side_of(description, joints, packages, notes):
    """Return the ``Side`` of the wheels on ``joints``, with all that they carry."""
    children = [description.joints[name].child for name in joints]
    frame = np.eye(4)
    frame[:3, 3] = np.mean([description.places[name][:3, 3] for name in children], axis=0)
    names = [link for name in joints for link in description.below(description.joints[name])]
    mass, part = gather(description, names, frame, packages, notes, needed=False)
    return Side(names, frame, mass, part)


def in_base(part, frame, base):
    """Return the collision shapes of a wheel's ``part`` in the frame of the base; both level."""
    shift = np.eye(4)
    shift[:3, 3] = frame[:3, 3] - base[:3, 3]
    return [shape._replace(transform=shift @ shape.transform) for shape in part.collisions]


def wheel_radius(facts, sides, notes):
    """Return the wheels' radius [m]: as the drive says, else that of their collision shapes."""
    drawn = [
        shape.size[0]
        for side in sides
        for shape in side.part.collisions
        if shape.form in ("cylinder", "sphere")
    ]
    if facts.radius is None and not drawn:
        raise ScenarioError(
            "{}: wheel_radius: nothing given, and link {} has no cylinder or sphere as its "
            "collision".format(facts.source, shown(sides[0].names[0]))
        )
    radius = facts.radius if facts.radius is not None else float(np.mean(drawn))
    if drawn and abs(np.mean(drawn) - radius) > OFF * radius:
        text = "{}: the wheels' radius is {:g} m, but their collision shapes have {:g} m"
        notes.append(text.format(facts.source, radius, np.mean(drawn)))
    return float(radius * facts.radius_factor)


def _spacing(facts, wheels, notes):
    """Return how far [m] left and right wheels are apart: as the drive says, else as they stand."""
    spacing = wheels.track if facts.track is None else facts.track
    if abs(spacing - wheels.track) > OFF * wheels.track:
        text = "{}: the track is {:g} m, but the wheels stand {:g} m apart"
        notes.append(text.format(facts.source, spacing, wheels.track))
    return float(spacing)


def _track(facts, wheels, spacing, notes):
    """Return the track [m] at which wheel speeds give the turn rate.

    The drive's track, times its multiplier.  Four wheels that slide, at ``(+-x, +-y)``, under a drive that
    has no multiplier: the effective one of dry friction, ``2 (x^2 + y^2)/y``.
    """
    if not wheels.wheelbase or facts.track_factor != 1.0:
        return spacing * facts.track_factor
    track = spacing + wheels.wheelbase**2 / spacing
    text = (
        "{}: four wheels {:g} m and {:g} m apart, which slide in turns: their effective track is "
        "{:.4g} m; a wheels.track of your own goes over it"
    )
    notes.append(text.format(facts.source, spacing, wheels.wheelbase, track))
    return track


def outline_of(shapes, radius, track, where):
    """Return front, rear, width and height [m] of what the collision ``shapes`` and the wheels take."""
    if not shapes:
        raise ScenarioError(
            "{}: no link has a collision shape; wanted one, or the key body, since it says how "
            "large the robot is".format(where)
        )
    low, high = extent(shapes)
    low = np.minimum(low, [-radius, -0.5 * track, -radius])
    high = np.maximum(high, [radius, 0.5 * track, radius])
    values = (high[0], -low[0], 2.0 * max(high[1], -low[1]), high[2] + radius)
    return {key: round(float(value), 9) for key, value in zip(BODY, values)}


def above_ground(shapes, radius, notes):
    """Return ``shapes``, those lifted that reach a little below the wheels' lowest point."""
    result = []
    for shape in shapes:
        below = -radius - extent([shape])[0][2]
        if below > BELOW * radius:
            text = "{}: reaches {:.3g} m below the wheels' lowest point, wanted above it"
            raise ScenarioError(text.format(shape.where, below))
        if below > 0.0:
            raised = shape.transform.copy()
            raised[2, 3] += below
            shape = shape._replace(transform=raised)
            if below > 5e-4:
                notes.append("{}: lifted by {:.2g} m onto the ground".format(shape.where, below))
        result.append(shape)
    return tuple(result)


def masses_of(description, base, sides, radius, given, where, notes):
    """Return the ``Mass`` of the base and those of the wheels, together the mass ``given`` if it is."""
    total = base.mass + sum(side.mass.mass for side in sides)
    wanted = total
    if given.get("mass") is not None:
        wanted = quantity(given["mass"], "kg", where + ": mass", above=0.0)
    elif total <= 0.0:
        text = "{}: no link has a mass; wanted <inertial> tags, or the key mass"
        raise ScenarioError(text.format(description.where))
    if base.mass <= 0.0:
        base = _block(wanted * (1.0 - len(sides) * WHEEL_SHARE), radius)
        notes.append(
            "{}: no link but the wheels has a mass: a block of {:g} kg stands for them".format(
                description.where, base.mass
            )
        )
    wheels = [side.mass if side.mass.mass > 0.0 else None for side in sides]
    for row, side in enumerate(sides):
        if wheels[row] is None:
            wheels[row] = _disc(WHEEL_SHARE * (wanted if total <= 0.0 else total), radius)
            notes.append(
                "{}: link {} has no mass: it gets {:g} kg".format(
                    description.where, shown(side.names[0]), wheels[row].mass
                )
            )
    parts = [base] + wheels
    for part, name in zip(parts, [description.root] + [side.names[0] for side in sides]):
        if not part.inertia.diagonal().min() > 0.0:
            raise ScenarioError(
                "{}: link {}: inertia 0 with {:g} kg, wanted above 0".format(
                    description.where, shown(name), part.mass
                )
            )
    scale = wanted / sum(part.mass for part in parts)
    if given.get("mass") is None:
        scale = 1.0
    scaled = [Mass(part.mass * scale, part.centre, part.inertia * scale) for part in parts]
    return scaled[0], scaled[1:]


def _block(mass, radius):
    """Return a cube as long as a wheel is high, of ``mass`` [kg]."""
    return Mass(mass, np.zeros(3), mass * (2.0 * radius) ** 2 / 6.0 * np.eye(3))


def _disc(mass, radius):
    """Return a wheel, a solid disc that turns about y, of ``mass`` [kg] and ``radius`` [m]."""
    return Mass(mass, np.zeros(3), mass * radius**2 * np.diag([0.25, 0.5, 0.25]))


def friction_of(description, wheel_links):
    """Return the wheels' least coefficient of friction [-] in <gazebo> tags, None if none is given."""
    found = []
    for element in description.xml.findall("gazebo"):
        if element.get("reference") in wheel_links and element.findtext("mu1"):
            name = shown(element.get("reference"))
            where = "{}: gazebo {}: mu1".format(description.where, name)
            try:
                value = float(element.findtext("mu1"))
            except ValueError:
                value = element.findtext("mu1")
            found.append(number(value, where, low=0.0))
    return min(found) if found else None


def add_torque(content, count, given, where, notes):
    """Add the torque of ``count`` motors to a kind's ``content`` and to ``notes``, if 6 N m are too weak.

    Motors are strong enough if their wheels can slip, ``T = mu m g r/count``: the wheels of a skid steer
    slide as it turns.
    """
    wheels = content["wheels"]
    if is_given(given, "wheels", "torque"):
        return
    grip = wheels.get("friction", FRICTION) * content["mass"] * GRAVITY / count
    torque = grip * wheels["radius"]
    if torque > TORQUE:
        text = (
            "{}: motors: no torque given; {:.3g} N m at each of {} wheels, by which they can slip"
        )
        notes.append(text.format(where, torque, count))
        wheels["torque"] = torque


def _limits(description, facts, wheels, radius, track, given, where):
    """Return the limits that are known, by axis; ``ScenarioError`` if a top speed is not given either."""
    rate = min(description.joints[name].velocity for name in wheels.lefts + wheels.rights)
    tops = list(facts.tops)
    accelerations = list(facts.accelerations)
    # Both wheels at their limit, forwards or against each other.
    for row, factor in enumerate((1.0, 2.0 / track)):
        if tops[row] is None and math.isfinite(rate):
            tops[row] = rate * radius * factor
        if accelerations[row] is None and facts.rim_acceleration is not None:
            accelerations[row] = facts.rim_acceleration * factor
    result = {}
    for axis, unit, top, acceleration in zip(AXES, UNITS, tops, accelerations):
        if top is None and not is_given(given, "limits", "firmware", axis, "max"):
            text = (
                "{}: limits.firmware.{}.max: nothing given, and neither {} nor the wheel joints' "
                "limit velocity gives it; wanted a number [{}]"
            )
            raise ScenarioError(text.format(where, axis, facts.source, unit))
        found = {"max": top, "acceleration": acceleration}
        result[axis] = {key: value for key, value in found.items() if value is not None}
    return result


def is_given(given, *path):
    """Return whether the keys ``given`` hold something at ``path``."""
    for key in path:
        given = given.get(key) if isinstance(given, dict) else None
    return given is not None


def _sources(content, facts, description):
    drive = ("wheels", "limits", "command_timeout", "odometry_rate")
    shapes = ("body", "mass", "inertia")
    sources = {key: facts.source for key in drive if key in content}
    sources.update({key: description.where for key in shapes if content.get(key)})
    return sources
