"""Wheels that roll and steer and rotors that spin, apart from the bodies that have them."""

import functools
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, wrap_angle
from mrs_simulator.core.spatial import about_z
from mrs_simulator.pictures.solids import kind_parts, model_of
from mrs_simulator.vehicles.importing.placing import transform_at
from mrs_simulator.vehicles.shape import Part

LEVEL, UPRIGHT = 0.1, 0.9  # [-] vertical part of the axis of a wheel at most, of a rotor at least
NEAR_GROUND = 0.2  # [-] of its radius, by which a wheel may be off the ground
FLAT = 0.5  # [-] of its radius, which a rotor is high at most
# [rad/s] at which rotors are drawn: no display shows the hundreds of a true one, by any thrust.
SPIN = 25.0
ALOFT = 0.02  # [m] over the ground, from which on rotors turn
HUB, SPOKE = (0.62, 0.62, 0.62, 1.0), (0.2, 0.2, 0.2, 1.0)
BLADE = (0.12, 0.12, 0.12, 1.0)
SWEPT = 0.3  # [-] opacity of the disc that a rotor sweeps
# Of its radius: a wheel's hub, and length and width of its spokes; the same of a rotor and its blades.
HUB_REACH, SPOKES = 0.65, (1.25, 0.2)
CAP_REACH, BLADES = 0.16, (1.96, 0.18)


class MovingPart(NamedTuple):
    """A wheel or a rotor, that turns about the z axis of its own frame."""

    models: Any  # ``Model``s; those of a rotor are its blades, and the disc that they sweep
    place: Any  # (4, 4) of its frame in that of the robot's place
    radius: float  # [m]
    is_rotor: bool
    is_steered: bool  # it turns about the vertical, too


@functools.lru_cache(maxsize=64)
def parted(kind):
    """Return the ``Model`` of what does not move of a ``Kind``, and its ``MovingPart``s, a tuple."""
    parts, medium = kind_parts(kind), kind.module.MEDIUM
    places = moving_places(kind)
    moving = [parts[place] for place in places]
    rest = [part for place, part in enumerate(parts) if place not in places]
    if not rest:
        return model_of(parts), ()
    steers = getattr(kind.module, "JOINTS", False)
    # Of a car the wheels behind stand below the place of the robot, those that steer are ahead of it.
    ahead = 0.5 * max([part.place[0] for part in moving] + [0.0])
    return model_of(rest), tuple(
        _moving(part, medium, steers and part.place[0] > ahead) for part in moving
    )


def moving_places(kind):
    """Return which of the parts of a ``Kind`` move, a list."""
    medium = kind.module.MEDIUM
    is_one = _is_rotor if medium == "air" else _is_wheel
    return [place for place, part in enumerate(kind_parts(kind)) if is_one(part, medium)]


def _axis(part):
    return transform_at(part.place[:3], part.place[3:])[:3, 2]


def _is_wheel(part, medium):
    if medium != "ground" or part.form != "cylinder" or abs(_axis(part)[2]) > LEVEL:
        return False
    return abs(part.place[2] - part.size[0]) < NEAR_GROUND * part.size[0]


def _is_rotor(part, medium):
    if medium != "air" or part.form != "cylinder" or abs(_axis(part)[2]) < UPRIGHT:
        return False
    return part.size[1] < FLAT * part.size[0]


def _moving(part, medium, is_steered):
    is_rotor = medium == "air"
    models = (_rotor if is_rotor else _wheel)(*part.size, tuple(part.colour))
    place = transform_at(part.place[:3], part.place[3:])
    return MovingPart(models, place, part.size[0], is_rotor, is_steered)


@functools.lru_cache(maxsize=64)
def _wheel(radius, width, colour):
    """Return the model of a wheel whose hub has spokes, by which one sees it turn, a tuple."""
    long, thin = (share * radius for share in SPOKES)
    parts = [
        Part("cylinder", (radius, width), colour=colour),
        Part("cylinder", (HUB_REACH * radius, 1.02 * width), colour=HUB),
        Part("box", (long, thin, 1.05 * width), colour=SPOKE),
        Part("box", (thin, long, 1.05 * width), colour=SPOKE),
    ]
    return (_plain(parts),)


@functools.lru_cache(maxsize=64)
def _rotor(radius, height, _):
    """Return the models of a rotor's blades and of the disc that they sweep, in the robot's colour."""
    thin = 0.3 * height
    blades = [
        Part("box", (*(share * radius for share in BLADES), height), colour=BLADE),
        Part("cylinder", (CAP_REACH * radius, 1.5 * height), colour=BLADE),
    ]
    return _plain(blades), model_of([Part("cylinder", (radius, thin))])


def _plain(parts):
    model = model_of(parts)
    return model._replace(own=np.zeros(len(model.own)))


def frames(part, place, turn, angle, steering=None):
    """Return the frames of a ``MovingPart`` of m robots: places (m, 3) [m] and rotations (m, 3, 3).

    ``place``, ``turn``: of the robots; ``angle`` (m,) [rad] by which the part has turned; ``steering`` (m,)
    [rad] of the wheels that steer.
    """
    own = np.broadcast_to(part.place[:3, :3], turn.shape)
    if steering is not None and part.is_steered:
        own = about_z(steering) @ own
    return place + turn @ part.place[:3, 3], turn @ own @ about_z(angle)


def rolled_angle(part, rolled):
    """Return by how much [rad] a wheel has turned, (m,), of robots that have ``rolled`` (m, 3).

    It rolls by as much as its place has moved across its axis, w = v . (a x z) / r.  The rollers of
    omnidirectional wheels let them slip along that; those of Mecanum wheels, at 45 degrees, are not drawn.
    """
    x, y = part.place[:2, 3]
    across = np.cross(part.place[:3, 2], (0.0, 0.0, 1.0))[:2]
    along, aside, turned = rolled.T
    moved = np.stack([along - y * turned, aside + x * turned], axis=1)
    return moved @ across / part.radius


def spin_angle(place, part, time):
    """Return the angle [rad] of a rotor at ``time`` [s], those beside each other the other way round.

    0 for a robot, at ``place`` (m, 3), that stands on the ground.
    """
    way = np.sign(part.place[0, 3] * part.place[1, 3]) or 1.0
    return np.where(place[:, 2] > ALOFT, way * SPIN * time % (2.0 * np.pi), 0.0)


class Motion(NamedTuple):
    """What the moving parts of n robots follow."""

    place: Any  # (n, 3) [m]
    rolled: Any  # (n, 3) [m, m, rad] gone along and across their headings, and turned
    steering: Any  # (n,) [rad] of wheels that steer, None where it is unknown
    time: float  # [s]

    def of(self, rows):
        """Return the ``Motion`` of the robots in ``rows``."""
        steering = None if self.steering is None else self.steering[rows]
        return Motion(self.place[rows], self.rolled[rows], steering, self.time)

    def frames(self, part, place, turn):
        """Return the frames of a ``MovingPart`` of robots at ``place``, turned by ``turn``."""
        if part.is_rotor:
            angle = spin_angle(self.place, part, self.time)
        else:
            angle = rolled_angle(part, self.rolled)
        return frames(part, place, turn, angle, self.steering)


class Odometer:
    """How far robots have gone along and across their headings, and turned, from picture to picture."""

    def __init__(self):
        self._numbers, self._pose, self._rolled = None, None, None

    def at(self, numbers, pose):
        """Return (n, 3) [m, m, rad] for robots ``numbers`` that are at ``pose`` (n, 3) now."""
        if numbers != self._numbers:
            self._numbers, self._rolled = numbers, np.zeros((len(pose), 3))
            self._pose = np.array(pose, dtype=float)
            return self._rolled
        x, y, turned = (pose - self._pose).T
        turned = wrap_angle(turned)
        cos, sin = cos_sin(self._pose[:, 2] + 0.5 * turned)
        step = np.stack([cos * x + sin * y, cos * y - sin * x, turned], axis=1)
        self._rolled = self._rolled + np.where(np.isfinite(step), step, 0.0)
        self._pose = np.where(np.isfinite(pose), pose, self._pose)
        return self._rolled
