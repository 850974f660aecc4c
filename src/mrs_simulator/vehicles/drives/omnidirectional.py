"""Omnidirectional bases: three or four omni wheels, or four mecanum wheels.

They obey ``vx`` (forward), ``vy`` (to the left) and ``omega``.  The controlled point is the centre
itself.  Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and ``command`` (m, 3), one column for
each of ``AXES``; ``inner`` (m, 3), what ramps: the velocities; ``joints`` (m,), which this drive has
none of.

``rolling`` (w, 3), or (m, w, 3), holds one row per wheel: the speed of its rim is
``rolling @ (vx, vy, omega)``.  Three wheels have a fourth row of zeros, a wheel that never turns.  The
free rollers transmit no force, so wheel forces f [N] along the rims push the body with
``rolling.T @ f``.  Kinematics after Lynch and Park, Modern Robotics (2017), section 13.2.
"""

import functools
from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import clip_commands, cos_sin, displaced
from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.vehicles.drives.differential import rates, ride_height  # noqa: F401, as there
from mrs_simulator.vehicles.drives.wheel_stand import Stand
from mrs_simulator.vehicles.quantities import quantity

AXES = ("linear.x", "linear.y", "angular.z")
LIMIT_AXES = AXES
MEDIUM = "ground"  # in which the robots move: ground, water or air
SECTION = "wheels"  # of a kind's file
ENCODERS = 4  # wheels that are counted, in the order of ``rolling``
POINT = "centre"
JOINTS = False  # whether ``joints`` move
OWN_LIMITS = True  # whether there are limits besides the axes': of the rims
RAMPS = True  # whether inner states ramp towards their targets
LAYOUTS = ("omni", "mecanum")
LARGEST = 100.0  # [m]
SURELY = 0.999  # [-] of a limit: within it whatever is rounded


class OmnidirectionalParameters(NamedTuple):
    """Wheel parameters of a kind; of several kinds each number is a column (m, ...)."""

    rolling: Tuple[Tuple[float, ...], ...]  # (4, 3) [-, -, m]
    inverse: Tuple[Tuple[float, ...], ...]  # (3, 4), its pseudo-inverse
    rim_max: float = np.inf  # [m/s] of a rim
    radius: float = 0.05  # [m]
    joints: Tuple[str, ...] = ()  # in the kind's model, in the order of ``rolling``
    torque: float = 6.0  # [N m] at a wheel
    friction: float = 0.9  # [-]
    easy: float = 0.0  # [m/s, rad/s]: no rim is too fast while no axis is faster than this


# The numbers that the functions below use.
COLUMNS = ("rolling", "inverse", "rim_max", "radius", "torque", "easy")


def read(section):
    """Return the ``OmnidirectionalParameters`` in a kind's ``section``, a ``QuantitySection``."""
    layout = section.text("layout", choices=LAYOUTS)
    rolling = (_read_omni if layout == "omni" else _read_mecanum)(section)
    radius = section.quantity("radius", "m", above=0.0, high=LARGEST)
    fastest = np.inf
    if section.has("speed"):
        fastest = section.quantity("speed", "rad/s", above=0.0)
    section.take("speed")
    count = len(rolling)
    rolling = np.concatenate([rolling, np.zeros((ENCODERS - count, 3))])
    return OmnidirectionalParameters(
        rolling=_plain(rolling),
        inverse=_plain(np.linalg.pinv(rolling)),
        rim_max=fastest * radius,
        radius=radius,
        joints=section.strings("joints", count)
        if section.has("joints")
        else section.take("joints", ()),
        torque=section.quantity("torque", "N m", 6.0, above=0.0),
        friction=section.quantity("friction", "", 0.9, low=0.0),
        easy=SURELY * fastest * radius / float(np.abs(rolling).sum(axis=1).max()),
    )


def _read_omni(section):
    where, given = section.at("angles"), section.take("angles")
    if not isinstance(given, list) or not 3 <= len(given) <= ENCODERS:
        raise unwanted(where, given, "a list of 3 or 4 angles")
    angles = [
        quantity(angle, "rad", "{}[{}]".format(where, index)) for index, angle in enumerate(given)
    ]
    rolling = omni_wheels(
        np.array(angles), section.quantity("distance", "m", above=0.0, high=LARGEST)
    )
    if np.linalg.matrix_rank(rolling) < 3:
        raise unwanted(where, given, "wheels that push in every direction")
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


def rims(numbers, m):
    """Return of the four rims of m robots, (m, 4, 3), what each does at vx and vy, and its limit [m/s]."""
    result = np.empty((m, ENCODERS, 3))
    result[:, :, :2] = np.asarray(_matrix(numbers.rolling))[..., :2]
    result[:, :, 2] = np.reshape(numbers.rim_max, (-1, 1))
    return result


def body_twist(rims, numbers):
    """Return the body twists (m, 3) that fit rim speeds (m, 4) best, by least squares."""
    return np.einsum("...kw,...w->...k", _matrix(numbers.inverse), rims)


def residual(rims, numbers):
    """Return the part of the rim speeds, (m, 4) [m/s], that no motion of a rigid body explains.

    Zero while all wheels roll; of four mecanum wheels it is ``(s, s, -s, -s)/4`` with
    ``s = FL + FR - RL - RR``: a detector of slip.  Three wheels never have any.
    """
    return rims - rim_speeds(body_twist(rims, numbers), None, numbers)


def excess(command, joints, numbers, period):
    """Return by which factor the rims are too fast at each ``command`` (m, 3), (m,).

    Divided by a factor above 1, a command is within the limits and moves the robot along the same path.
    0 where all commands are far within them.
    """
    if _are_easy(command, numbers):
        return np.zeros(len(command))
    return _fastest(command, numbers) / numbers.rim_max


def _fastest(command, numbers):
    """Return the speed of the fastest rim of each robot, (m,) [m/s], at ``command`` (m, 3)."""
    rims = np.einsum("...wk,...k->w...", _matrix(numbers.rolling), command)
    return functools.reduce(np.maximum, np.abs(rims))


def _are_easy(command, numbers):
    """Return whether no rim is too fast by far, in a third of the time that :func:`_fastest` takes."""
    return np.count_nonzero(np.abs(command.T) < numbers.easy) == command.size


def at_limits(command, top, numbers, share):
    """Return where a ``command`` (..., m, 3) has reached ``share`` of its limits, (..., m) bool."""
    rims = np.abs(rim_speeds(command, None, numbers)).max(axis=-1)
    return (np.abs(command) >= share * top).any(axis=-1) | (rims >= share * numbers.rim_max)


def limited(command, top, numbers):
    """Return the commands (m, 3) that the base executes: each axis clipped to ``top``, then the
    twist slowed as a whole until no rim is beyond its limit."""
    return retargeted(clip_commands(command, top), command, None, numbers)


def target(command, inner, limits, numbers):
    """Return the inner states, velocities (m, 3), to which the firmware ramps: those of :func:`limited`."""
    return limited(command, limits.top, numbers)


def retargeted(clipped, command, inner, numbers):
    """Return what :func:`limited` does, of what is ``clipped`` of ``command`` axis by axis, (m, 3) each."""
    if _are_easy(clipped, numbers):
        return clipped
    return (clipped.T / np.maximum(_fastest(clipped, numbers) / numbers.rim_max, 1.0)).T


def blocked(inner, moved):
    """Return the ``inner`` states (m, 3) of robots that moved by ``moved`` (m, 2) [m/s] in a contact.

    ``moved`` is given in the body's frame.  Neither axis is faster than the wheels turn, nor does it go
    the other way.
    """
    result, own = inner.copy(), inner[:, :2]
    result[:, :2] = np.sign(own) * np.clip(np.sign(own) * moved, 0.0, np.abs(own))
    return result


def odometry_pose(pose, rolled, joints, numbers):
    """Return the poses (m, 3) by odometry after wheels ``rolled`` (m, 4) [m]."""
    return displaced(pose, body_twist(rolled, numbers), 1.0)


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


def arm(l, numbers):
    """Return how far [m] the controlled point is ahead of the centre: it is the centre, whatever ``l``."""
    return 0.0


lead = arm  # the point stays there


def command(along, across, joints, l, period, numbers):
    """Return the commands, (m, 3), that move the centres ``along`` and ``across`` the heading, not turning.

    For any velocity and heading, hence theory for point masses holds as it stands.
    """
    result = np.zeros((len(along), 3), order="F")
    result[:, 0], result[:, 1] = along, across
    return result


def velocity(command, joints, l, period, numbers):
    """Return the centres' velocities along and across the heading, (m,) [m/s], under ``command`` (m, 3)."""
    return command[:, 0], command[:, 1]
