"""Kinematics of wheeled robots as functions of arrays, one robot per row.

Equation numbers are those of the paper: (1) the unicycle, (2) and (3) its hand point, (7) the
mapping of a point-mass input to the unicycle.  Angles are in rad, counter-clockwise from the x axis
of the common frame (REP 103).

Results lie in memory column by column (``order="F"``): numpy runs along a thousand x eight
times as fast as across a thousand pairs.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.fields import POSITIVE, Parameter

TWIST_AXES = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")
UNICYCLE_AXES = ("linear.x", "angular.z")  # components of a Twist that a unicycle follows: v, omega
DEFAULT_HAND_LENGTH = 0.05  # [m], the paper's l
HAND_LENGTH = Parameter(
    "l",
    DEFAULT_HAND_LENGTH,
    "m",
    **POSITIVE,
    high=10.0,
    meaning="from the wheel-axle centre to the hand point",
    why="the mapping (7) divides by l",
)


FASTEST = 1e12  # [m/s, rad/s] of a wanted velocity: a greater one is mapped with care
ONE_THREAD = 10000  # [-] numbers up to which linear algebra starts no threads
# [rad] changes no turn that is one; sin(TINY_ANGLE)/TINY_ANGLE is 1, where sin(0)/0 is no number.
TINY_ANGLE = 1.2345678e-300
# [-] last ones, by which a quaternion is moved
DIGITS = 0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6


class Limits(NamedTuple):
    """What a robot's firmware allows; ``inf`` means no limit."""

    v_max: float  # [m/s]
    omega_max: float  # [rad/s]
    v_accel: float  # [m/s^2], also the deceleration
    omega_accel: float  # [rad/s^2], also the deceleration


NO_LIMITS = Limits(np.inf, np.inf, np.inf, np.inf)


def max_abs(values):
    """Return the greatest absolute value, a float: nan where one of ``values`` is nan, 0 of none.

    ``np.abs(values).max()`` in half of its time for a few values: argmax does without a reduction.
    """
    size = np.abs(values).ravel(order="K")
    return size.item(size.argmax()) if size.size else 0.0


def are_within(values, bound):
    """Return whether no absolute value of ``values`` exceeds ``bound``, nor is nan.

    The sum of the squares mostly says so, in half of the time of :func:`max_abs`.
    """
    flat = values.ravel(order="K")
    if flat.size < ONE_THREAD and flat.dot(flat) < bound * bound:
        return True
    return max_abs(values) <= bound


def max_of_rows(values):
    """Return the greatest of each row of ``values`` (..., a), nan where one is nan, (...).

    ``values.max(axis=-1)`` of rows of a few numbers, by columns: reduced they take twenty times as long.
    """
    return functools.reduce(np.maximum, (values[..., k] for k in range(values.shape[-1])))


def wrap_angle(angle):
    """Return ``angle`` [rad] brought into [-pi, pi), any shape; one that lies there stays to the bit."""
    angle = np.asarray(angle, dtype=float)
    if max_abs(angle) < np.pi:
        return angle
    outside = (angle < -np.pi) | (angle >= np.pi)
    return np.where(outside, (angle + np.pi) % (2.0 * np.pi) - np.pi, angle)


def yaw(x, y, z, w):
    """Return the heading [rad] in [-pi, pi] of a unit quaternion, whatever its roll and pitch; floats."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def turn_about_z(theta):
    """Return z and w of the unit quaternion of ``theta`` [rad], whose :func:`heading_about_z` is theta.

    To the bit in [-pi, pi]: they are moved by some last digits where sine and cosine miss it.
    """
    half = 0.5 * theta
    z, w = math.sin(half), math.cos(half)
    if math.atan2(z, w) == half:
        return z, w
    z_digit, w_digit = float(np.spacing(z)), float(np.spacing(w))
    for fine in DIGITS:  # those of w move a small turn by less
        for coarse in DIGITS:
            moved = z + coarse * z_digit, w + fine * w_digit
            if math.atan2(*moved) == half:
                return moved
    return z, w


def heading_about_z(z, w):
    """Return the heading [rad] in [-pi, pi] of a quaternion with these z and w, and x and y of 0."""
    if w < 0.0 or (w == 0.0 and z < 0.0):  # the same turn
        z, w = -z, -w
    return 2.0 * math.atan2(z, w)


def cos_sin(angle):
    """Return cosine and sine of ``angle`` [rad], any shape, the same to the bit in every process.

    Of a contiguous copy: where numpy takes a strided array and the result for overlapping, which is
    up to the heap, it calls another routine with other last bits.
    """
    angle = np.asarray(angle, dtype=float, order="C")
    if angle.size == 1:  # contiguous to numpy, whatever its strides are
        angle = angle.copy()
    return np.cos(angle), np.sin(angle)


def direction_of(way):
    """Return the angle [rad] in [-pi, pi] of ``way`` (..., 2), (...), like :func:`cos_sin` of copies."""
    y, x = np.array([way[..., 1], way[..., 0]], dtype=float)
    return np.arctan2(y, x)


def phase_of(z):
    """Return the phase [rad] in [-pi, pi] of complex ``z``, any shape, like :func:`cos_sin` of copies."""
    y, x = np.array([z.imag, z.real])
    return np.arctan2(y, x)


def compose(origin, pose):
    """Return ``pose`` (n, 3), given in frames at ``origin`` (n, 3), in the frame of ``origin``."""
    cos, sin = cos_sin(origin[:, 2])
    result = np.empty(pose.shape, order="F")
    result[:, 0] = origin[:, 0] + cos * pose[:, 0] - sin * pose[:, 1]
    result[:, 1] = origin[:, 1] + sin * pose[:, 0] + cos * pose[:, 1]
    result[:, 2] = wrap_angle(origin[:, 2] + pose[:, 2])
    return result


def origins(common, pose):
    """Return the origins (n, 3) from which ``pose`` (n, 3) is ``common`` (n, 3); undoes ``compose``."""
    result = np.empty(pose.shape, order="F")
    result[:, 2] = wrap_angle(common[:, 2] - pose[:, 2])
    cos, sin = cos_sin(result[:, 2])
    result[:, 0] = common[:, 0] - cos * pose[:, 0] + sin * pose[:, 1]
    result[:, 1] = common[:, 1] - sin * pose[:, 0] - cos * pose[:, 1]
    return result


def relative(origin, pose):
    """Return ``pose`` (n, 3) as seen from frames at ``origin`` (n, 3); undoes ``compose``."""
    cos, sin = cos_sin(origin[:, 2])
    away = pose[:, :2] - origin[:, :2]
    result = np.empty(pose.shape, order="F")
    result[:, 0] = cos * away[:, 0] + sin * away[:, 1]
    result[:, 1] = cos * away[:, 1] - sin * away[:, 0]
    result[:, 2] = wrap_angle(pose[:, 2] - origin[:, 2])
    return result


def fraction_of_motion(moved, fraction):
    """Return where robots are, (n, 3), after a ``fraction`` [-] of the motion ``moved`` (n, 3).

    Both in the frames in which they began; the twist of the motion is constant: with p = x + i y and
    s(a) = sin(a) / a it is ``f e^(i (f - 1) theta / 2) s(f theta / 2) / s(theta / 2) p``.
    """
    half = 0.5 * moved[:, 2]
    scale = fraction * np.sinc(fraction * half / np.pi) / np.sinc(half / np.pi)
    cos, sin = cos_sin((fraction - 1.0) * half)
    result = np.empty(moved.shape, order="F")
    result[:, 0] = scale * (cos * moved[:, 0] - sin * moved[:, 1])
    result[:, 1] = scale * (sin * moved[:, 0] + cos * moved[:, 1])
    result[:, 2] = fraction * moved[:, 2]
    return result


def hand_points(pose, l):
    """Return the hand points, shape (..., 2) [m]: ``alpha = (x + l cos theta, y + l sin theta)``, eq. (2).

    ``pose`` has shape (..., 3) [m, m, rad]; ``l`` [m], () or (..., n), is the distance from the wheel-axle
    centre.
    """
    pose = np.asarray(pose, dtype=float)
    cos, sin = cos_sin(pose[..., 2])
    hand = np.empty(pose.shape[:-1] + (2,), order="F")
    hand[..., 0] = pose[..., 0] + l * cos
    hand[..., 1] = pose[..., 1] + l * sin
    return hand


def unicycle_from_point_mass(u, theta, l):
    """Return ``(v, omega)``, shape (n, 2), that moves the hand point with velocity ``u``, eq. (7).

    ``v = cos(theta) ux + sin(theta) uy`` [m/s],
    ``omega = (-sin(theta) ux + cos(theta) uy) / l`` [rad/s].
    ``u`` has shape (n, 2) [m/s] in the common frame, ``theta`` shape (n,) [rad], ``l`` > 0 [m].
    """
    cos, sin = cos_sin(theta)
    command = np.empty((len(u), 2), order="F")
    command[:, 0] = cos * u[:, 0] + sin * u[:, 1]
    command[:, 1] = (cos * u[:, 1] - sin * u[:, 0]) / l
    return command


def point_mass_from_unicycle(command, theta, l):
    """Return the hand point's velocity, shape (n, 2) [m/s]: ``alpha' = A(theta) (v, omega)``, eq. (3).

    ``A = [[cos, -l sin], [sin, l cos]]``; the inverse of :func:`unicycle_from_point_mass`.
    """
    cos, sin = cos_sin(theta)
    lateral = l * command[:, 1]
    u = np.empty((len(command), 2), order="F")
    u[:, 0] = cos * command[:, 0] - sin * lateral
    u[:, 1] = sin * command[:, 0] + cos * lateral
    return u


def arc(pose, twist, duration):
    """Return the poses, shape (n, 3), after ``duration`` [s], () or (n, 1), of a constant body ``twist``.

    ``twist``: ``(v, omega)``, (n, 2), or ``(vx, vy, omega)``, (n, 3) [m/s, m/s, rad/s].  The exact
    solution of the unicycle (1), ``x' = v cos theta, y' = v sin theta, theta' = omega``, and of
    ``(x', y') = R(theta) (vx, vy)``: with ``D = omega duration`` the centre moves by
    ``duration sin(D/2)/(D/2) R(theta + D/2) (vx, vy)``.  Without ``vy`` both are the same to the bit.
    The heading is not wrapped.
    """
    moved = duration * twist
    moved[:, -1] *= 0.5
    return moved_along_arcs(pose, moved)


def moved_along_arcs(pose, moved):
    """Return the poses that :func:`arc` does; ``moved``: distances [m], and half of the turns [rad]."""
    half = moved[:, -1]
    turn = half + TINY_ANGLE
    share = np.sin(turn) / turn
    middle = pose[:, 2] + half
    cos, sin = np.cos(middle), np.sin(middle)
    along = moved[:, 0] * share
    after = np.empty(pose.shape, order="F")
    x, y = after[:, 0], after[:, 1]
    np.add(pose[:, 0], along * cos, x)
    np.add(pose[:, 1], along * sin, y)
    np.add(middle, half, after[:, 2])
    if moved.shape[1] == 3:
        across = moved[:, 1] * share
        np.subtract(x, across * sin, x)
        np.add(y, across * cos, y)
    return after


def displaced(pose, twist, duration):
    """Return the poses, shape (n, 3), as :func:`arc` does, with headings in [-pi, pi)."""
    return wrapped(arc(pose, twist, duration))


def moved_along_arcs_wrapped(pose, moved):
    """Return the poses, shape (n, 3), as :func:`moved_along_arcs` does, with headings in [-pi, pi)."""
    return wrapped(moved_along_arcs(pose, moved))


def wrapped(after):
    """Bring the headings of poses ``after`` (n, 3) into [-pi, pi), in place; return them."""
    heading = after[:, 2]
    if not max_abs(heading) < np.pi:  # seldom
        heading[:] = wrap_angle(heading)
    return after


def clip_commands(command, top):
    """Return commands, (n, 2), clipped to ``top`` (2,) [m/s, rad/s] one by one, as firmware does."""
    return np.minimum(np.maximum(command, -top), top)


def ramp(velocity, target, acceleration, duration):
    """Return the velocity after ``duration`` [s] of a linear ramp, and the mean velocity over it.

    Every component of ``velocity`` moves towards ``target`` by at most ``acceleration * duration``
    and then holds.  The mean, ``v1 - (v1 - v0) t_ramp / (2 duration)`` with ``t_ramp = |v1 - v0| /
    acceleration``, times ``duration`` is the exact distance.  All shapes (n, 2); ``acceleration``
    may be ``inf``.
    """
    return ramped(velocity, target, Reach.of(acceleration * duration))


class Reach(NamedTuple):
    """How far velocities change at most, (n, a): to either side, and doubled."""

    down: np.ndarray
    up: np.ndarray
    both: np.ndarray

    @classmethod
    def of(cls, reach):
        """Return the ``Reach`` of changes up to ``reach`` (n, a)."""
        return cls(-reach, reach, reach + reach)


def ramped(velocity, target, reach):
    """Return what :func:`ramp` does, for a step of which ``reach``, a :class:`Reach`, is known."""
    change = target - velocity
    np.maximum(change, reach.down, change)
    np.minimum(change, reach.up, change)
    mean = np.abs(change)
    mean *= change
    mean /= reach.both
    change += velocity
    np.subtract(change, mean, mean)
    return change, mean


def scaled(command, excess, scope="robot"):
    """Return commands (n, a) divided by the factors ``excess`` (n,) by which they are beyond limits.

    Each robot's by its own with ``scope="robot"``, all by the greatest with ``"team"``; factors up
    to 1 change nothing.
    """
    excess = np.maximum(excess, 1.0)
    if scope == "team":
        return command / excess.max(initial=1.0)
    return command / excess[:, np.newaxis]


def wheel_speeds(command, track):
    """Return the rim speeds of the left and right wheel, shape (n, 2) [m/s]: ``v -+ omega track/2``."""
    lateral = 0.5 * track * command[:, 1]
    rims = np.empty(command.shape, order="F")
    rims[:, 0], rims[:, 1] = command[:, 0] - lateral, command[:, 0] + lateral
    return rims


def body_speeds(wheels, track):
    """Return ``(v, omega)``, shape (n, 2), of rim speeds (left, right); inverse of ``wheel_speeds``."""
    left, right = wheels[:, 0], wheels[:, 1]
    body = np.empty(wheels.shape, order="F")
    body[:, 0], body[:, 1] = 0.5 * (left + right), (right - left) / track
    return body
