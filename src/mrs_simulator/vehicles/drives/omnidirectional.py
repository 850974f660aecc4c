"""Omnidirectional bases: three or four omni wheels, or four mecanum wheels.

They obey ``vx`` (forward), ``vy`` (to the left) and ``omega``.  The controlled point is the centre
itself.  Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and ``command`` (m, 3), one column for
each of ``AXES``; ``joints`` (m,), which this drive has none of.

``rolling`` (w, 3), or (m, w, 3), holds one row per wheel: the speed of its rim is
``rolling @ (vx, vy, omega)``.  Three wheels have a fourth row of zeros, a wheel that never turns.  The
free rollers transmit no force, so wheel forces f [N] along the rims push the body with
``rolling.T @ f``.  Kinematics after Lynch and Park, Modern Robotics (2017), section 13.2.
"""

import functools
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import clip_commands, cos_sin, ramp, wrap_angle
from mrs_simulator.core.reading import ScenarioError, shown
from mrs_simulator.vehicles.drives.stand import Stand
from mrs_simulator.vehicles.quantities import quantity

AXES = ("linear.x", "linear.y", "angular.z")
LIMIT_AXES = AXES
MEDIUM = "ground"  # in which the robots move: ground, water or air
SECTION = "wheels"  # of a kind's file
ENCODERS = 4  # wheels that are counted, in the order of ``rolling``
POINT = "centre"
JOINTS = False  # whether ``joints`` move
LAYOUTS = ("omni", "mecanum")
LARGEST = 100.0  # [m]


class Numbers(NamedTuple):
    """What a kind tells of its wheels; of several kinds each number is a column (m, ...)."""

    rolling: Tuple[Tuple[float, ...], ...]  # (4, 3) [-, -, m]
    inverse: Tuple[Tuple[float, ...], ...]  # (3, 4), its pseudo-inverse
    rim_max: float = np.inf  # [m/s] of a rim
    radius: float = 0.05  # [m]
    joints: Tuple[str, ...] = ()  # in the kind's model, in the order of ``rolling``
    torque: float = 6.0  # [N m] at a wheel
    friction: float = 0.9  # [-]


# The numbers that the functions below use.
COLUMNS = ("rolling", "inverse", "rim_max", "radius", "torque")


def read(section):
    """Return the ``Numbers`` in a kind's ``section``, a ``QuantitySection``."""
    layout = section.text("layout", choices=LAYOUTS)
    rolling = (_read_omni if layout == "omni" else _read_mecanum)(section)
    radius = section.quantity("radius", "m", above=0.0, high=LARGEST)
    fastest = np.inf
    if section.has("speed"):
        fastest = section.quantity("speed", "rad/s", above=0.0)
    section.take("speed")
    count = len(rolling)
    rolling = np.concatenate([rolling, np.zeros((ENCODERS - count, 3))])
    return Numbers(
        rolling=_plain(rolling),
        inverse=_plain(np.linalg.pinv(rolling)),
        rim_max=fastest * radius,
        radius=radius,
        joints=section.strings("joints", count)
        if section.has("joints")
        else section.take("joints", ()),
        torque=section.quantity("torque", "N m", 6.0, above=0.0),
        friction=section.quantity("friction", "", 0.9, low=0.0),
    )


def _read_omni(section):
    where, given = section.at("angles"), section.take("angles")
    if not isinstance(given, list) or not 3 <= len(given) <= ENCODERS:
        raise ScenarioError("{}: {}, wanted a list of 3 or 4 angles".format(where, shown(given)))
    angles = [
        quantity(angle, "rad", "{}[{}]".format(where, index)) for index, angle in enumerate(given)
    ]
    rolling = omni_wheels(
        np.array(angles), section.quantity("distance", "m", above=0.0, high=LARGEST)
    )
    if np.linalg.matrix_rank(rolling) < 3:
        raise ScenarioError(
            "{}: {}, wanted wheels that push in every direction".format(where, shown(given))
        )
    return rolling


def _read_mecanum(section):
    return mecanum_wheels(
        *(section.quantity(key, "m", above=0.0, high=LARGEST) for key in ("wheelbase", "track"))
    )


@functools.lru_cache(maxsize=None)
def _array(rows):
    return np.array(rows)


def _matrix(numbers):
    """Return one matrix, in tuples, or those of many robots, (m, ...), as an array."""
    return _array(numbers) if isinstance(numbers, tuple) else numbers


def _plain(matrix):
    return tuple(map(tuple, matrix.tolist()))


def unlimited(numbers):
    """Return ``numbers`` without the wheels' own limits."""
    return numbers._replace(rim_max=np.inf)


def omni_wheels(angles, distance):
    """Return ``rolling`` (w, 3) of omni wheels at ``angles`` (w,) [rad], ``distance`` [m] from the centre.

    A wheel at angle a stands across the ray from the centre and drives counter-clockwise:
    ``rim = -sin(a) vx + cos(a) vy + distance omega``.
    """
    cos, sin = cos_sin(angles)
    return np.stack([-sin, cos, np.full(len(cos), float(distance))], axis=-1)


def mecanum_wheels(wheelbase, track):
    """Return ``rolling`` (4, 3) of mecanum wheels, front left, front right, rear left, rear right.

    ``wheelbase`` and ``track`` [m]: between the axles, and between left and right wheels.  Rollers at
    45 deg, seen from above along the diagonals through the centre (the usual "X"): with
    ``k = (wheelbase + track)/2`` the front left rim has ``vx - vy - k omega``, and so on.
    """
    k = 0.5 * (wheelbase + track)
    return np.array([[1.0, -1.0, -k], [1.0, 1.0, k], [1.0, 1.0, -k], [1.0, -1.0, k]])


def rim_speeds(mean, joints, numbers):
    """Return the speeds of the wheels' rims, (m, 4) [m/s], at body twists ``mean`` (m, 3)."""
    return np.einsum("...wk,...k->...w", _matrix(numbers.rolling), mean)


def body_twist(rims, numbers):
    """Return the body twists (m, 3) that fit rim speeds (m, 4) best, by least squares."""
    return np.einsum("...kw,...w->...k", _matrix(numbers.inverse), rims)


def residual(rims, numbers):
    """Return the part of the rim speeds, (m, 4) [m/s], that no motion of a rigid body explains.

    Zero while all wheels roll; of four mecanum wheels it is ``(s, s, -s, -s)/4`` with
    ``s = FL + FR - RL - RR``: a detector of slip.  Three wheels never have any.
    """
    return rims - rim_speeds(body_twist(rims, numbers), None, numbers)


def top_speed_along(direction, numbers):
    """Return the greatest speed, (m,) [m/s], that the rims allow in ``direction`` (m,) [rad] of the
    body, not turning."""
    cos, sin = cos_sin(direction)
    along = np.stack([cos, sin, np.zeros_like(cos)], axis=-1)
    return numbers.rim_max / np.abs(rim_speeds(along, None, numbers)).max(axis=1)


def excess(command, joints, top, numbers, period):
    """Return by which factor each ``command`` (m, 3) is beyond the limits, (m,); up to 1 within.

    ``top`` (3,) or (m, 3): of the axes; the rims have theirs.  Divided by a factor above 1, a command
    is within all limits and moves the robot along the same path.
    """
    rims = np.maximum.reduce(np.abs(rim_speeds(command, joints, numbers)), axis=1)
    return np.maximum(np.maximum.reduce(np.abs(command) / top, axis=1), rims / numbers.rim_max)


def at_limits(command, top, numbers, share):
    """Return where a ``command`` (..., m, 3) has reached ``share`` of its limits, (..., m) bool."""
    rims = np.abs(rim_speeds(command, None, numbers)).max(axis=-1)
    return (np.abs(command) >= share * top).any(axis=-1) | (rims >= share * numbers.rim_max)


def slowed(command, factor, joints, numbers):
    """Return the commands (m, 3) divided by ``factor``, a number or (m,)."""
    return command / np.reshape(factor, (-1, 1))


def limited(command, top, numbers):
    """Return commands (m, 3) as the base carries them out: each axis clipped to ``top``, then the
    twist slowed as a whole until no rim is beyond its limit."""
    clipped = clip_commands(command, top)
    rims = np.maximum.reduce(np.abs(rim_speeds(clipped, None, numbers)), axis=1)
    return clipped / np.maximum(rims / numbers.rim_max, 1.0)[:, np.newaxis]


def displaced(pose, twist, duration):
    """Return the poses, (m, 3), after ``duration`` [s] of constant body ``twist`` (m, 3).

    The exact solution of ``x' = R(theta) (vx, vy), theta' = omega``: with ``D = omega duration`` the
    centre moves by ``duration sin(D/2)/(D/2) R(theta + D/2) (vx, vy)``.  The heading is wrapped.
    """
    half = 0.5 * duration * twist[:, 2]
    share = np.full(len(half), float(duration))
    np.divide(duration * np.sin(half), half, out=share, where=half != 0.0)
    middle = pose[:, 2] + half
    cos, sin = np.cos(middle), np.sin(middle)
    after = np.empty(pose.shape, order="F")
    after[:, 0] = pose[:, 0] + share * (cos * twist[:, 0] - sin * twist[:, 1])
    after[:, 1] = pose[:, 1] + share * (sin * twist[:, 0] + cos * twist[:, 1])
    after[:, 2] = wrap_angle(middle + half)
    return after


def move(pose, velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 3), joints (m,), mean velocity (m, 3) and pose (m, 3) after ``step`` [s].

    Commands are limited as :func:`limited` does; every axis ramps by ``limits.acceleration``; the pose
    moves by the mean twist, exactly while the twist holds.
    """
    velocity, joints, mean = ramped(velocity, joints, command, limits, numbers, step)
    return velocity, joints, mean, displaced(pose, mean, step)


def ramped(velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 3), joints (m,) and mean velocity (m, 3) after ``step`` [s]: ``move`` but for
    the pose."""
    target = limited(command, limits.top, numbers)
    velocity, mean = ramp(velocity, target, limits.acceleration, step)
    return velocity, joints, mean


def fill_twist(twist, velocity, joints, numbers):
    """Write the body twists (m, 3), vx, vy [m/s], omega [rad/s], of ``velocity`` into ``twist``."""
    twist[:] = velocity


def farthest(mean):
    """Return the greatest speed [m/s] of a centre at the ``mean`` velocities (m, 3)."""
    return float(np.hypot(mean[:, 0], mean[:, 1]).max(initial=0.0))


def top_speed(limits):
    """Return the speed [m/s] that no robot of these ``limits`` exceeds."""
    return float(np.max(np.hypot(limits.top[..., 0], limits.top[..., 1])))


def blocked(velocity, moved):
    """Return the velocities (m, 3) of robots that a contact let move by ``moved`` (m, 2) [m/s].

    ``moved`` is given in the body's frame.  Neither axis is faster than the wheels turn, nor does it go
    the other way.
    """
    result, own = velocity.copy(), velocity[:, :2]
    result[:, :2] = np.sign(own) * np.clip(np.sign(own) * moved, 0.0, np.abs(own))
    return result


def reckoned(pose, rolled, joints, numbers):
    """Return the poses (m, 3) that odometry makes of wheels that ``rolled`` (m, 4) [m] further."""
    return displaced(pose, body_twist(rolled, numbers), 1.0)


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the ground: that of the axles."""
    return numbers.radius


def is_pushed(numbers):
    """Return whether, in motion with forces, wheel forces of ``stand`` push the body: always."""
    return True


def stand(joints, numbers):
    """Return the ``Stand`` of the robots, m as ``joints`` (m,); each wheel carries the same weight.

    Along the rollers' axles the contact gives its whole friction; a rim at an angle to them, as that of
    a mecanum wheel, its share.
    """
    along = np.broadcast_to(np.asarray(numbers.rolling, dtype=float), (len(joints), ENCODERS, 3))
    slant = np.hypot(along[:, :, 0], along[:, :, 1])
    there = slant > 0.0
    weight = there / there.sum(axis=1)[:, np.newaxis] / np.where(there, slant, 1.0)
    push = there * np.reshape(np.asarray(numbers.torque) / numbers.radius, (-1, 1))
    return Stand(along, np.zeros_like(along), weight, push, np.zeros(len(joints)))


def rim_targets(velocity, joints, numbers):
    """Return the speeds (m, 4) [m/s] at which the motors hold the rims at ``velocity`` (m, 3)."""
    return rim_speeds(velocity, joints, numbers)


def counted(turning, joints, numbers):
    """Return what the encoders count per second, (m, 4) [m/s], of rims that turn so: the same."""
    return turning


def joints_after(command, joints, numbers, period):
    """Return ``joints`` (m,): there are none."""
    return joints


def lead(l, numbers):
    """Return how far [m] the controlled point is from the centre: it is the centre."""
    return 0.0


def joints_seen(pose, point, l, numbers):
    """Return the ``joints`` (m,) of robots at ``pose`` with these points: there are none."""
    return np.zeros(len(pose))


def point(pose, joints, l, numbers):
    """Return the controlled points, (..., m, 2) [m]: the centres themselves, whatever ``l``."""
    return pose[..., :2].copy(order="F")


def command(velocity, pose, joints, l, period, numbers):
    """Return the commands, (m, 3), that move the centres with ``velocity`` (m, 2) [m/s], not turning.

    ``(vx, vy) = R(theta)' velocity``, ``omega = 0``: for any velocity and heading, hence theory for
    point masses holds as it stands.
    """
    cos, sin = cos_sin(pose[:, 2])
    result = np.zeros((len(pose), 3), order="F")
    result[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
    result[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0]
    return result


def velocity(command, pose, joints, l, period, numbers):
    """Return the velocity of the centres, (m, 2) [m/s], under ``command`` (m, 3)."""
    cos, sin = cos_sin(pose[:, 2])
    result = np.empty((len(pose), 2), order="F")
    result[:, 0] = cos * command[:, 0] - sin * command[:, 1]
    result[:, 1] = sin * command[:, 0] + cos * command[:, 1]
    return result
