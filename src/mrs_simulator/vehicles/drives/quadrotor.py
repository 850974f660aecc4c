"""Quadrotors: commands are ``vx`` (ahead), ``vy`` (to the left), ``vz`` (up) and the heading's turn rate.

Velocities are level: ahead is where the heading points, whatever the tilt.  The controlled point is the
centre.  Of m robots: ``wanted`` and ``velocity`` (m, 3) [m/s] in the common frame.

Without forces the velocity follows the one wanted with a time constant T, and no faster than the greatest
tilt allows,

    v' = e min(1/T, A/|e|),   e = v_wanted - v,   A = g tan(tilt_max),

across; up and down apart from that, with their own T and A.  With forces, in ``quadrotor_forces``, it is
that of a rigid body under four rotors, whose controller has the gain ``k_v = 1/T``: one constant for both.
Of a body whose attitude follows through three poles at -p, the velocity is

    V/V_wanted = 1/(T s (1 + s/p)^3 + 1) = 1 - T s + ...,

so that places come to lie ``v T`` behind, as without forces, whatever p.

A command of zero is to hover at the place.  On the ground a robot stays until it is commanded to rise.

A robot with a lost rotor, or with its motors off, cannot fly: without forces it falls freely, ignores
commands, and lies where it falls.
"""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from mrs_simulator.core.kinematics import clip_commands, cos_sin, ramp, wrap_angle
from mrs_simulator.core.spatial import Spatial
from mrs_simulator.vehicles.drives import flight_control
from mrs_simulator.vehicles.drives.differential import at_limits  # noqa: F401, as there
from mrs_simulator.vehicles.drives.omnidirectional import arm, lead  # noqa: F401
from mrs_simulator.vehicles.drives.rotors import GRAVITY, ROTORS, effect_of, greatest_climb, parts
from mrs_simulator.vehicles.drives.velocity_lag import NO_LAG, remaining_error

AXES = ("linear.x", "linear.y", "linear.z", "angular.z")
LIMIT_AXES = AXES
SECTION = "flight"  # of a kind's file
WITH_FORCES = "mrs_simulator.vehicles.drives.quadrotor_forces"  # builds on this module
MEDIUM = "air"
POINT = "centre"
JOINTS, OWN_LIMITS, RAMPS, ENCODERS = False, False, True, 0  # nothing rolls, no joints move
HOVER = 5.0  # [s] for which a robot without commands hovers before it lands
LANDING = 0.3  # [m/s] at which it comes down then
CLIMBING, NEARING = 0.5, 1.5  # [m/s, 1/s] of a take-off: as fast, and as quickly there
STEEPEST = 1.2  # [rad] of any tilt


class QuadrotorParameters(NamedTuple):
    """Flight parameters of a kind; of several kinds each number is a column (m, ...).

    Parts are those of x, y and z, of the body's frame where it matters; ``effect`` as in ``rotors``.
    """

    inertia: Tuple[float, ...]  # (3,) [kg m^2]
    effect: Tuple[float, ...]  # (4,) [N s^2, N m s^2, ...]
    speed_max: float  # [rad/s] of a rotor
    speed_min: float  # [rad/s]
    lag: float  # [s] of the motors
    drag: Tuple[float, ...]  # (3,) [kg], force per velocity and sum of the rotors' speeds
    velocity_gain: Tuple[float, ...]  # (3,) [1/s], 1/response
    attitude_gain: Tuple[float, ...]  # (3,) [1/s]
    rate_gain: Tuple[float, ...]  # (3,) [1/s]
    rate_damping: Tuple[float, ...]  # (3,) [-]
    turning_max: Tuple[float, ...]  # (3,) [rad/s^2] of the controllers
    tilt_max: float  # [rad]
    response: Tuple[float, ...]  # (3,) [s], time constants of velocities
    sinking: float = flight_control.SINKING * GRAVITY  # [m/s^2], greatest acceleration downwards
    mass: float = np.nan  # [kg], the kind's
    downwash: float = 1.0  # [-] ratio of vertical to horizontal clearance between robots


COLUMNS = QuadrotorParameters._fields  # the numbers that the functions below use


def read(section):
    """Return the ``QuadrotorParameters`` in a kind's ``QuantitySection``, but for the mass."""
    inertia, drag, response = (section.section(key) for key in ("inertia", "drag", "response"))
    effect = effect_of(
        section.quantity("arm", "m", above=0.0, high=10.0),
        section.quantity("thrust", "N s^2", above=0.0),
        section.quantity("torque", "N m s^2", above=0.0),
    )
    lag = section.quantity("motor_lag", "s", above=0.0, high=1.0)
    tilt, turn = _gains(section.section("poles"), lag)
    times = _thrice(response, "s", above=0.0)
    numbers = QuadrotorParameters(
        inertia=tuple(inertia.quantity(key, "kg m^2", above=0.0) for key in ("xx", "yy", "zz")),
        effect=effect,
        speed_max=section.quantity("speed", "rad/s", above=0.0),
        speed_min=section.quantity("least_speed", "rad/s", 0.0, low=0.0),
        lag=lag,
        drag=_thrice(drag, "kg", low=0.0),
        velocity_gain=tuple(1.0 / time for time in times),
        attitude_gain=(tilt[0], tilt[0], turn[0]),
        rate_gain=(tilt[1], tilt[1], turn[1]),
        rate_damping=(tilt[2], tilt[2], turn[2]),
        turning_max=(np.inf,) * 3,
        tilt_max=section.quantity("tilt", "rad", above=0.0, high=STEEPEST),
        response=times,
        downwash=section.number("downwash", 1.0, low=1.0, high=100.0),
    )
    for each in (inertia, drag, response):
        each.done()
    return numbers


def _thrice(section, unit, **bounds):
    """Return the parts of x, y and z of a number given ``across`` and ``up``."""
    across, up = (section.quantity(key, unit, **bounds) for key in ("across", "up"))
    section.done()
    return across, across, up


def _gains(section, lag):
    poles = [section.quantity(key, "rad/s", above=1.0 / (3.0 * lag)) for key in ("tilt", "turn")]
    section.done()
    return [flight_control.poles_at(pole, lag) for pole in poles]


def unlimited(numbers):
    """Return ``numbers`` of robots that answer at once, without forces."""
    return numbers._replace(
        tilt_max=0.5 * np.pi, response=(NO_LAG,) * 3, sinking=np.inf, speed_max=np.inf
    )


def level(command, heading):
    """Return the velocities (m, 3) [m/s] in the common frame of ``command`` (m, 4) at ``heading`` (m,)."""
    cos, sin = cos_sin(heading)
    result = np.empty((len(heading), 3), order="F")
    result[:, 0] = cos * command[:, 0] - sin * command[:, 1]
    result[:, 1] = sin * command[:, 0] + cos * command[:, 1]
    result[:, 2] = command[:, 2]
    return result


def followed(velocity, wanted, numbers, duration):
    """Return velocities and mean velocities, (m, 3) each, after ``duration`` [s] of holding ``wanted``.

    The exact solution of the equation above: the error shrinks along a line, by A a second down to A T,
    from there on exponentially.
    """
    error = (wanted - velocity).T
    response = parts(numbers.response)
    across = np.sqrt(error[0] * error[0] + error[1] * error[1])
    size = np.stack([across, np.abs(error[2])])
    most = np.empty(size.shape)
    most[0] = GRAVITY * np.tan(numbers.tilt_max)
    climbing = flight_control.CLIMBING * greatest_climb(numbers)
    most[1] = np.where(error[2] < 0.0, numbers.sinking, climbing)
    left, mean = remaining_error(size, response[[0, 2]], most, duration)
    shares = np.zeros((2,) + size.shape)
    np.divide(left, size, out=shares[0], where=size > 0.0)
    np.divide(mean, size, out=shares[1], where=size > 0.0)
    left, mean = shares[:, [0, 0, 1]]
    return (wanted.T - left * error).T, (wanted.T - mean * error).T


class VelocityState(NamedTuple):
    """The inner state of m robots without forces, arrays in memory column by column."""

    place: np.ndarray  # (m, 3) [m], common frame
    velocity: np.ndarray  # (m, 3) [m/s], common frame
    heading: np.ndarray  # (m,) [rad]
    turning: np.ndarray  # (m,) [rad/s]
    acceleration: np.ndarray  # (m, 3) [m/s^2], mean over the last step, which shows in the tilt
    working: Optional[np.ndarray] = None  # (m, 4) bool, rotors that work; None: all


def begin(pose, z, numbers):
    """Return the inner state of robots that hover, or stand, at ``pose`` (m, 3) and ``z`` (m,) [m]."""
    place, zeros = np.empty((len(pose), 3), order="F"), np.zeros((len(pose), 3), order="F")
    place[:, :2], place[:, 2] = pose[:, :2], z
    return VelocityState(place, zeros, pose[:, 2].copy(), np.zeros(len(pose)), zeros)


def possible(command, limits):
    """Return ``command`` (m, 4) slowed to the greatest speed, all of its velocity alike, and turn rate."""
    top = limits.top
    share = np.maximum((np.abs(command[:, :3]) / top[..., :3]).max(axis=1), 1.0)
    result = clip_commands(command, top)
    result[:, :3] = command[:, :3] / share[:, np.newaxis]
    return result


def stays(z, command):
    """Return which robots at heights ``z`` (m,) stand on the ground, not commanded to rise, (m,) bool."""
    return (z <= 0.0) & (command[:, 2] <= 0.0)


def flown(inner, command, limits, numbers, step):
    """Return the inner state after ``step`` [s] under ``command`` (m, 4), without forces.

    The command is taken along the heading in the middle of the step.
    """
    limited = possible(command, limits)
    limited[stays(inner.place[:, 2], limited)] = 0.0
    acceleration = limits.acceleration[..., 3]
    turning, mean_turning = ramp(inner.turning, limited[:, 3], acceleration, step)
    middle = inner.heading + 0.5 * step * mean_turning
    velocity, mean = followed(inner.velocity, level(limited, middle), numbers, step)
    after = VelocityState(
        inner.place + step * mean,
        velocity,
        wrap_angle(inner.heading + step * mean_turning),
        turning,
        (velocity - inner.velocity) / step,
        inner.working,
    )
    return after if inner.working is None else _fallen(inner, after, step)


def _fallen(before, after, step):
    """Return ``after`` where robots with a failed rotor fall, ``v' = -g e``, and do not turn."""
    falls = ~before.working.all(axis=1)
    place, velocity = after.place.copy(order="F"), after.velocity.copy(order="F")
    velocity[falls] = before.velocity[falls] - [0.0, 0.0, step * GRAVITY]
    place[falls] = before.place[falls] + 0.5 * step * (before.velocity[falls] + velocity[falls])
    down = falls & (place[:, 2] <= 0.0)
    place[down, 2], velocity[down] = 0.0, 0.0
    still, heading = np.where(falls, 0.0, after.turning), after.heading.copy()
    heading[falls] = before.heading[falls]
    shown = np.where(falls[:, np.newaxis], 0.0, after.acceleration)
    return after._replace(
        place=place, velocity=velocity, heading=heading, turning=still, acceleration=shown
    )


def without(working, m, rows, rotors):
    """Return which rotors (m, 4) bool work where those of ``rows`` fail, of ``working`` before.

    ``rotors``: indices or a slice.
    """
    working = np.ones((m, ROTORS), dtype=bool) if working is None else working.copy()
    working[rows, rotors] = False
    return working


def lost(inner, row, rotor):
    """Return the inner state in which robot ``row`` has lost a ``rotor``, its index."""
    return inner._replace(working=without(inner.working, len(inner.place), row, rotor))


def powerless(inner, rows):
    """Return the inner state in which the motors of robots ``rows``, (m,) bool or indices, are off."""
    return inner._replace(working=without(inner.working, len(inner.place), rows, slice(None)))


def powered(inner, rows):
    """Return the inner state in which the motors of robots ``rows`` turn again, as on a workbench."""
    if inner.working is None:
        return inner
    working = inner.working.copy()
    working[rows] = True
    return inner._replace(working=None if working.all() else working)


def state(inner):
    """Return poses (m, 3), body twists (m, 3) in the plane, and ``Spatial`` of an inner state."""
    attitude = flight_control.attitude_of(_tilting(inner), inner.heading)
    rates = np.zeros((len(inner.heading), 3), order="F")
    rates[:, 2] = inner.turning
    return seen(inner.place, inner.velocity, inner.heading, attitude, rates)


def _tilting(inner):
    """Return the accelerations (m, 3) that show in the tilt: none on the ground or without a lag."""
    size = np.sqrt((inner.acceleration[:, :2] ** 2).sum(axis=1))
    shown = (size < GRAVITY * np.tan(STEEPEST)) & (inner.place[:, 2] > 0.0)
    return np.where(shown[:, np.newaxis], inner.acceleration, 0.0)


def seen(place, velocity, heading, attitude, rates):
    """Return poses (m, 3), body twists (m, 3) in the plane, and ``Spatial``.

    ``place`` and ``velocity`` (m, 3) in the common frame; ``attitude`` (m, 4), of which ``heading`` (m,)
    is; ``rates`` (m, 3) [rad/s] and the twist are in the body's frame.
    """
    body = into_body(velocity, attitude)
    pose, twist, rest = (np.empty(place.shape, order="F") for _ in range(3))
    pose[:, :2], pose[:, 2] = place[:, :2], heading
    twist[:, :2], twist[:, 2] = body[:, :2], rates[:, 2]
    rest[:, 0], rest[:, 1:] = body[:, 2], rates[:, :2]
    return pose, twist, Spatial(place[:, 2].copy(), attitude, rest)


def into_body(vectors, attitude):
    """Return ``vectors`` (m, 3), of the common frame, in the frames of bodies with ``attitude`` (m, 4)."""
    x, y, z, w = attitude.T
    a, b, c = vectors.T
    # v - 2 w (q x v) + 2 q x (q x v), q the vector part.
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    result = np.empty((3, len(a)))
    result[0] = a - w * p + (y * r - z * q)
    result[1] = b - w * q + (z * p - x * r)
    result[2] = c - w * r + (x * q - y * p)
    return result.T


def stopped(inner, pushed, place, bound):
    """Return the inner state after contacts put the robots ``pushed`` (m,) bool at ``place`` (m, 3) [m].

    ``bound`` (3,) or (m, 3) [m/s]: no component of their velocity in the common frame is faster.
    """
    return inner._replace(**put(inner, pushed, place, bound))


def put(inner, pushed, place, bound):
    """Return place and velocity of an inner state after contacts, by name."""
    where, velocity = inner.place.copy(order="F"), inner.velocity.copy(order="F")
    where[pushed] = np.asarray(place)[pushed]
    bound = np.broadcast_to(bound, velocity.shape)[pushed]
    velocity[pushed] = np.minimum(np.maximum(velocity[pushed], -bound), bound)
    return {"place": where, "velocity": velocity}


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the position: it lies there."""
    return 0.0


def command(along, across, joints, l, period, numbers):
    """Return the commands (m, 4) that move the centres with ``along`` and ``across`` (m,) [m/s], the
    velocity ahead and to the left: level, and not turning."""
    result = np.zeros((len(along), 4), order="F")
    result[:, 0], result[:, 1] = along, across
    return result


def velocity(command, joints, l, period, numbers):
    """Return the centres' velocity ahead and to the left, (m,) each [m/s], under ``command`` (m, 4)."""
    return command[:, 0], command[:, 1]


def tracking(speed, numbers):
    """Return the greatest lag [m] behind a velocity of ``speed`` (m,) [m/s], commanded from rest.

    It is also the way to stop.  With forces the velocity follows by 1/k_v, the attitude by
    1/k_R; ``e' = -min(e/T, A)`` from e loses ``e T``, or from ``e > A T`` on ``e^2/(2 A) + A T^2/2``.
    """
    slow = 1.0 / parts(numbers.velocity_gain) + 1.0 / parts(numbers.attitude_gain)
    time = slow[:2].max(axis=0)
    most = GRAVITY * np.tan(numbers.tilt_max)
    ramped = np.maximum(speed - most * time, 0.0)
    return speed * time + 0.5 * ramped * ramped / most


def landing(count, numbers):
    """Return the commands (m, 4) with which ``count`` robots come down where they are."""
    result = np.zeros((count, 4))
    result[:, 2] = -LANDING
    return result


def climbing(z, height, numbers):
    """Return the commands (m, 4) of robots at ``z`` (m,) [m] that take off to ``height`` (m,) [m].

    ``vz = k (height - z)``, no faster than ``CLIMBING``.
    """
    result = np.zeros((len(z), 4))
    result[:, 2] = np.minimum(np.maximum(NEARING * (height - z), -CLIMBING), CLIMBING)
    return result


def silent(seconds, numbers):
    """Return the commands (m, 4) of robots silent for ``seconds`` (m,) too long: hover, then land."""
    return landing(len(seconds), numbers) * (seconds > HOVER)[:, np.newaxis]


def lateness(numbers):
    """Return the greatest lag [s] of velocities: their greatest time constant."""
    return float(parts(numbers.response).max())
