"""What an imported robot's drive is: from gazebo_ros drive plugins, or ``diff_drive_controller``."""

from typing import NamedTuple, Optional, Tuple

from mrs_simulator.scenario.reading import ScenarioError, Section, load_yaml, shown, unwanted
from mrs_simulator.vehicles.importing.xml_reading import Tag, numbers

DIFFERENTIAL, SKID_STEER = "gazebo_ros_diff_drive", "gazebo_ros_skid_steer_drive"
CONTROLLER = "diff_drive_controller/DiffDriveController"
DEEPEST = 8  # [-] namespaces around a controller
SIDES = ("left", "right")


class DriveFacts(NamedTuple):
    """Facts of a differential drive; None where the source does not give them."""

    source: str  # the file and the plugin or controller
    joints: Tuple[Tuple[str, ...], Tuple[str, ...]]  # of the left and the right wheels
    track: Optional[float] = None  # [m]
    track_factor: float = 1.0  # [-]
    radius: Optional[float] = None  # [m]
    radius_factor: float = 1.0  # [-]
    torque: Optional[float] = None  # [N m]
    rim_acceleration: Optional[float] = None  # [m/s^2] of each wheel's rim
    tops: Tuple[Optional[float], Optional[float]] = (None, None)  # [m/s], [rad/s]
    accelerations: Tuple[Optional[float], Optional[float]] = (None, None)  # [m/s^2], [rad/s^2]
    timeout: Optional[float] = None  # [s]
    rate: Optional[float] = None  # [Hz] of odometry
    notes: Tuple[str, ...] = ()


# Tags as gazebo_ros has them in ROS 1, and in ROS 2.
TRACK, DIAMETER = ("wheelSeparation", "wheel_separation"), ("wheelDiameter", "wheel_diameter")
TORQUE, RATE = ("wheelTorque", "torque", "max_wheel_torque"), ("updateRate", "update_rate")
ACCELERATION = ("wheelAcceleration", "max_wheel_acceleration")
WHEELS = {
    DIFFERENTIAL: ((("leftJoint", "left_joint"),), (("rightJoint", "right_joint"),)),
    SKID_STEER: (
        (("leftFrontJoint",), ("leftRearJoint",)),
        (("rightFrontJoint",), ("rightRearJoint",)),
    ),
}


def plugin_facts(description):
    """Return the ``DriveFacts`` of the gazebo_ros drive plugin in ``description``.

    Raises ``ScenarioError`` if there is none, more than one, or a tag is missing or wrong.
    """
    found = [
        (
            kind,
            Tag(plugin, "{}: plugin {}".format(description.where, shown(plugin.get("name", "")))),
        )
        for plugin in description.xml.findall("gazebo/plugin")
        for kind in WHEELS
        if kind in plugin.get("filename", "")
    ]
    if len(found) != 1:
        named = ", ".join(tag.where.rpartition(": ")[2] for _, tag in found) or "none"
        text = (
            "{}: gazebo_ros drive plugins: {}; wanted one (lib{}.so or lib{}.so), or a "
            "controller's file, or import: {{drive: ...}}"
        )
        raise ScenarioError(text.format(description.where, named, DIFFERENTIAL, SKID_STEER))
    kind, tag = found[0]
    acceleration, rate = _number(tag, ACCELERATION, low=0.0), _number(tag, RATE, low=0.0)
    return DriveFacts(
        source=tag.where,
        joints=tuple(tuple(_needed(tag, names) for names in side) for side in WHEELS[kind]),
        track=_needed_number(tag, TRACK),
        radius=0.5 * _needed_number(tag, DIAMETER),
        torque=_number(tag, TORQUE, above=0.0),
        rim_acceleration=acceleration or None,  # the plugin's 0 is none
        rate=rate or None,
    )


def _given(tag, names):
    """Return the text of the first of the tags ``names`` that is there, with its place; or None."""
    for name in names:
        text = tag.text(name)
        if text is not None:
            return text, "{}: {}".format(tag.where, name)
    return None, "{}: {}".format(tag.where, names[0])


def _needed(tag, names):
    text, where = _given(tag, names)
    if text is None:
        raise ScenarioError("{}: nothing given, wanted the name of a joint".format(where))
    return text


def _number(tag, names, **bounds):
    text, where = _given(tag, names)
    return None if text is None else float(numbers(text, 1, where, **bounds)[0])


def _needed_number(tag, names):
    value = _number(tag, names, above=0.0)
    if value is None:
        raise ScenarioError("{}: nothing given, wanted a number [m]".format(_given(tag, names)[1]))
    return value


def controller_facts(path, name=None):
    """Return the ``DriveFacts`` of the ``diff_drive_controller`` in the YAML file at ``path``.

    ``name``: of the controller, needed where there are several.  Raises ``ScenarioError``.
    """
    found = dict(_controllers(load_yaml(path), ()))
    chosen = {key: value for key, value in found.items() if name in (None, key, key.split("/")[-1])}
    if len(chosen) != 1:
        raise ScenarioError(
            "{}: controllers of the type {}: {}; wanted {}".format(
                path,
                CONTROLLER,
                ", ".join(sorted(found)) or "none",
                "one" if name is None else "one called " + shown(name),
            )
        )
    (key, content), notes = chosen.popitem(), []
    section = Section(content, "{}: {}".format(path, key) if key else path)
    tops, accelerations = zip(
        *(_axis(section, *axis, notes) for axis in (("linear", "x"), ("angular", "z")))
    )
    factors = [
        section.number("{}_wheel_radius_multiplier".format(side), 1.0, above=0.0) for side in SIDES
    ]
    radius_factor = section.number("wheel_radius_multiplier", sum(factors) / 2.0, above=0.0)
    if factors[0] != factors[1]:
        notes.append("the wheels' radii differ by their multipliers: their mean is used")
    return DriveFacts(
        source=section.at("left_wheel").rpartition(".")[0] or path,
        joints=tuple(_joint_names(section, "{}_wheel".format(side)) for side in SIDES),
        track=_optional(section, "wheel_separation", above=0.0),
        track_factor=section.number("wheel_separation_multiplier", 1.0, above=0.0),
        radius=_optional(section, "wheel_radius", above=0.0),
        radius_factor=radius_factor,
        tops=tops,
        accelerations=accelerations,
        timeout=_optional(section, "cmd_vel_timeout", above=0.0),
        rate=_optional(section, "publish_rate", above=0.0),
        notes=tuple("{}: {}".format(path, note) for note in notes),
    )


def _controllers(content, above):
    """Yield name and mapping of the differential-drive controllers in ``content``, at any depth."""
    if not isinstance(content, dict):
        return
    kind = content.get("type")
    if kind == CONTROLLER or (kind is None and "left_wheel" in content):
        yield "/".join(above), content
    elif len(above) < DEEPEST:
        for key, value in content.items():
            yield from _controllers(value, above + (str(key),))


def _optional(section, key, **bounds):
    return section.number(key, **bounds) if section.has(key) else None


def _joint_names(section, key):
    value = section.take(key)
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not names or not all(isinstance(each, str) for each in names):
        raise unwanted(section.at(key), value, "a joint's name or a list of them")
    return tuple(names)


def _axis(section, motion, axis, notes):
    """Return top speed and acceleration of an axis, None where the controller does not bound them."""
    both = Section(section.take(motion), section.at(motion))
    limits = Section(both.take(axis), both.at(axis))
    return tuple(_bound(limits, quantity, notes) for quantity in ("velocity", "acceleration"))


def _bound(limits, quantity, notes):
    if not limits.flag("has_{}_limits".format(quantity), False):
        return None
    high = limits.number("max_" + quantity, above=0.0)
    low = limits.number("min_" + quantity, -high, high=0.0)
    if low != -high:
        notes.append(
            "{}: {:g} to {:g}: the lesser is used both ways".format(limits.at(quantity), low, high)
        )
    least = min(high, -low)
    if least == 0.0:
        raise ScenarioError("{}: 0, wanted below 0".format(limits.at("min_" + quantity)))
    return least
