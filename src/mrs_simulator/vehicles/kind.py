"""A kind of robot: one YAML file, read strictly, with its model beside it."""

import math
import os
from typing import Any, Dict, NamedTuple, Optional, Tuple

from mrs_simulator.core.doc_links import explained_by
from mrs_simulator.scenario.reading import ScenarioError, unwanted
from mrs_simulator.vehicles.arms.mounted import Arm, read_arm
from mrs_simulator.vehicles.drives import DRIVES, drive_module
from mrs_simulator.vehicles.quantities import QuantitySection
from mrs_simulator.vehicles.shape import Part, read_shape

PRESETS = ("firmware", "top")
LARGEST = 100.0  # [m] of any robot


class Body(NamedTuple):
    """How far a robot reaches from its centre, [m]; a round one is as long as it is wide."""

    front: float
    rear: float
    width: float
    height: float
    round: bool = False

    @property
    def length(self):
        """Return the length [m]."""
        return self.front + self.rear

    @property
    def reach(self):
        """Return the distance [m] from the centre to the farthest point of the outline."""
        if self.round:
            return self.front
        return math.hypot(max(self.front, self.rear), 0.5 * self.width)


class AxisLimit(NamedTuple):
    """The greatest speed and acceleration of one command axis, in SI units; ``inf`` for none."""

    top: float
    acceleration: float


class Spread(NamedTuple):
    """How far wheels and axes of sound robots are from their commands, at most."""

    gain: float  # [-]
    dead_time: float  # [s]
    bias: float  # [m/s]


# of kinds that do not say
SPREADS = {"kinematic": Spread(0.01, 0.05, 0.001), "dynamic": Spread(0.03, 0.2, 0.005)}


RUN_ON = {"ground": 0.3, "air": 0.7, "water": 4.5}  # [s] of kinds that do not say, by medium


class Kind(NamedTuple):
    """A kind of robot as its file describes it; not to be changed."""

    name: str
    title: str
    drive: str  # name of the module in ``vehicles.drives``
    body: Body
    numbers: Any  # the drive's parameters, such as ``DifferentialParameters``
    limits: Dict[str, Tuple[AxisLimit, ...]]  # preset -> one for each axis of the drive
    mass: float  # [kg]
    inertia: Optional[float]  # [kg m^2] about the vertical through the centre
    model: str  # absolute path of the URDF file, "" for none
    command_timeout: float  # [s] of silence after which the robot stops
    odometry_rate: float  # [Hz] of the real robot's driver
    mounts: Dict[str, Any]  # kept as it was read
    sources: Dict[str, str]  # key path -> where its numbers are from
    notes: Tuple[str, ...] = ()  # what its users should know, among the warnings of a run
    shape: Tuple[Part, ...] = ()  # how it looks where there is no model
    arm: Optional[Arm] = None  # on the base
    spread: Dict[str, Spread] = SPREADS  # by fidelity
    run_on: float = 0.0  # [s] at its speed, by which forces take it off its course as it brakes

    def __hash__(self):
        return hash(self.name)

    @property
    def module(self):
        """Return the drive's module."""
        return drive_module(self.drive)

    @property
    def axes(self):
        """Return the components of ``geometry_msgs/Twist`` that the robot follows."""
        return self.module.AXES


@explained_by("docs/robots_of_your_own.md#from-dimensions")
def read_kind(content, where, directory=""):
    """Return the ``Kind`` in the mapping ``content``, whose bases are merged already.

    ``where`` names it in errors; ``directory``: that of a relative ``model``.
    """
    top = QuantitySection(content, where)
    drive = top.text("drive", choices=DRIVES)
    module = drive_module(drive)
    name = top.text("name")
    numbers = top.section(module.SECTION)
    kind = Kind(
        name=name,
        title=top.text("title", name),
        drive=drive,
        body=_read_body(top.section("body")),
        numbers=module.read(numbers),
        limits=_read_limits(top.section("limits"), module),
        mass=top.quantity("mass", "kg", above=0.0),
        inertia=top.quantity("inertia", "kg m^2", above=0.0) if top.has("inertia") else None,
        model=_read_model(top, directory),
        command_timeout=top.quantity("command_timeout", "s", 0.6, above=0.0),
        odometry_rate=top.quantity("odometry_rate", "Hz", 50.0, above=0.0),
        mounts=_mapping(top, "mounts"),
        sources=_mapping(top, "sources", text=True),
        notes=_texts(top, "notes"),
        shape=read_shape(top.take("shape", []), top.at("shape")),
        arm=read_arm(top.section("arm"), drive, module) if top.has("arm") else None,
        spread=_read_spreads(top.section("spread")),
        run_on=top.quantity("run_on", "s", RUN_ON[module.MEDIUM], low=0.0),
    )
    top.take("inertia")
    top.take("arm", None)
    numbers.done()
    top.done()
    if "mass" in kind.numbers._fields:  # which its functions use
        return kind._replace(numbers=kind.numbers._replace(mass=kind.mass))
    return kind


def _read_body(section):
    height = section.quantity("height", "m", above=0.0, high=LARGEST)
    if section.has("radius"):
        radius = section.quantity("radius", "m", above=0.0, high=LARGEST)
        body = Body(radius, radius, 2.0 * radius, height, True)
    else:
        front, rear = (
            section.quantity(key, "m", low=0.0, high=LARGEST) for key in ("front", "rear")
        )
        body = Body(front, rear, section.quantity("width", "m", above=0.0, high=LARGEST), height)
        if body.length <= 0.0:
            raise ScenarioError(
                "{}: 0 together with front, wanted above 0".format(section.at("rear"))
            )
    section.take("radius")
    section.done()
    return body


def _read_limits(section, module):
    firmware = _read_preset(section.section("firmware"), module)
    top = _read_preset(section.section("top"), module) if section.has("top") else firmware
    section.take("top")
    section.done()
    return {"firmware": firmware, "top": top}


def _read_preset(section, module):
    given = {axis: _read_axis(section.section(axis), axis) for axis in module.LIMIT_AXES}
    section.done()
    # Of an axis that follows from others, as a car's turn rate from its steering, there is none.
    return tuple(given.get(axis, AxisLimit(math.inf, math.inf)) for axis in module.AXES)


def _read_axis(section, axis):
    unit = "m/s" if axis.startswith("linear") else "rad/s"
    top = section.quantity("max", unit, above=0.0)
    # An acceleration left out is none: the robot answers at once.
    acceleration = math.inf
    if section.has("acceleration"):
        acceleration = section.quantity("acceleration", unit + "^2", above=0.0)
    section.take("acceleration")
    section.done()
    return AxisLimit(top, acceleration)


def _read_model(top, directory):
    if not top.has("model"):
        return top.take("model", "")
    path = os.path.join(directory, os.path.expanduser(top.text("model")))
    if not os.path.isfile(path):
        raise unwanted(top.at("model"), path, "a file")
    return os.path.abspath(path)


def _mapping(top, key, text=False):
    value = top.take(key, {})
    if not isinstance(value, dict) or (
        text and not all(isinstance(v, str) for v in value.values())
    ):
        raise unwanted(top.at(key), value, "a mapping{}".format(" of texts" if text else ""))
    return value


def _read_spreads(section):
    result = {
        fidelity: _read_spread(section.section(fidelity), own) for fidelity, own in SPREADS.items()
    }
    section.done()
    return result


def _read_spread(section, own):
    spread = Spread(
        section.quantity("gain", "", own.gain, above=0.0),
        section.quantity("dead_time", "s", own.dead_time, above=0.0),
        section.quantity("bias", "m/s", own.bias, above=0.0),
    )
    section.done()
    return spread


def _texts(top, key):
    value = top.take(key, [])
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise unwanted(top.at(key), value, "a list of texts")
    return tuple(value)
