"""Quadrotors: they obey ``vx`` (ahead), ``vy`` (to the left), ``vz`` (up) and the turn rate of the heading.

Velocities are level: ahead is where the heading points, whatever the tilt.  The controlled point is the
centre.  Of m robots: ``wanted`` and ``velocity`` (m, 3) [m/s] in the common frame.

Without forces the velocity follows the one wanted with a time constant T, and no faster than the greatest
tilt allows,

    v' = e min(1/T, A/|e|),   e = v_wanted - v,   A = g tan(tilt_max),

across; up and down apart from that, with their own T and A.  With forces it is that of a rigid body under
four rotors, ``flight`` and ``flight_control``, in substeps of at most ``SUBSTEP``.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.drives import flight_control
from mrs_simulator.vehicles.drives.flight import acting, advanced
from mrs_simulator.vehicles.drives.following import AT_ONCE, shrunk
from mrs_simulator.vehicles.drives.rotors import (
    GRAVITY,
    effect_of,
    greatest_climb,
    parts,
)

AXES = ("linear.x", "linear.y", "linear.z", "angular.z")
LIMIT_AXES = AXES
SECTION = "flight"  # of a kind's file
POINT = "centre"
SUBSTEP = 0.002  # [s] the longest of the motion with forces
VELOCITY_EVERY = 5  # [-] substeps from one use of the velocity's controller to the next
STEEPEST = 1.2  # [rad] of any tilt


class Numbers(NamedTuple):
    """What a kind tells of its flight; of several kinds each number is a column (m, ...).

    Parts are those of x, y and z, of the body's frame where it matters; ``effect`` as in ``rotors``.
    """

    inertia: Tuple[float, ...]  # (3,) [kg m^2]
    effect: Tuple[float, ...]  # (4,) [N s^2, N m s^2, ...]
    speed_max: float  # [rad/s] of a rotor
    speed_min: float  # [rad/s]
    lag: float  # [s] of the motors
    drag: Tuple[float, ...]  # (3,) [kg], force per velocity and sum of the rotors' speeds
    velocity_gain: Tuple[float, ...]  # (3,) [1/s]
    attitude_gain: Tuple[float, ...]  # (3,) [1/s]
    rate_gain: Tuple[float, ...]  # (3,) [1/s]
    rate_damping: Tuple[float, ...]  # (3,) [-]
    turning_max: Tuple[float, ...]  # (3,) [rad/s^2] that controllers ask for
    tilt_max: float  # [rad]
    response: Tuple[float, ...]  # (3,) [s], time constants of motion without forces
    sinking: float = flight_control.SINKING * GRAVITY  # [m/s^2], greatest acceleration downwards
    mass: float = np.nan  # [kg], the kind's


COLUMNS = Numbers._fields  # the numbers that the functions below use


def read(section):
    """Return the ``Numbers`` in a kind's ``section``, a ``QuantitySection``, but for the mass."""
    inertia, drag, response = (section.section(key) for key in ("inertia", "drag", "response"))
    effect = effect_of(
        section.quantity("arm", "m", above=0.0, high=10.0),
        section.quantity("thrust", "N s^2", above=0.0),
        section.quantity("torque", "N m s^2", above=0.0),
    )
    lag = section.quantity("motor_lag", "s", above=0.0, high=1.0)
    tilt, turn = _gains(section.section("poles"), lag)
    numbers = Numbers(
        inertia=tuple(inertia.quantity(key, "kg m^2", above=0.0) for key in ("xx", "yy", "zz")),
        effect=effect,
        speed_max=section.quantity("speed", "rad/s", above=0.0),
        speed_min=section.quantity("least_speed", "rad/s", 0.0, low=0.0),
        lag=lag,
        drag=_thrice(drag, "kg", low=0.0),
        velocity_gain=_thrice(section.section("velocity_gain"), "1/s", above=0.0),
        attitude_gain=(tilt[0], tilt[0], turn[0]),
        rate_gain=(tilt[1], tilt[1], turn[1]),
        rate_damping=(tilt[2], tilt[2], turn[2]),
        turning_max=(np.inf,) * 3,
        tilt_max=section.quantity("tilt", "rad", above=0.0, high=STEEPEST),
        response=_thrice(response, "s", above=0.0),
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
        tilt_max=0.5 * np.pi, response=(AT_ONCE,) * 3, sinking=np.inf, speed_max=np.inf
    )


def level(command, heading):
    """Return the velocities (m, 3) [m/s] in the common frame of ``command`` (m, 4) at ``heading`` (m,)."""
    cos, sin = cos_sin(heading)
    result = np.empty((len(heading), 3), order="F")
    result[:, 0] = cos * command[:, 0] - sin * command[:, 1]
    result[:, 1] = sin * command[:, 0] + cos * command[:, 1]
    result[:, 2] = command[:, 2]
    return result


def along_heading(velocity, heading):
    """Return ``velocity`` (m, 3), of the common frame, along and across the ``heading`` (m,) and up."""
    cos, sin = cos_sin(heading)
    result = np.empty(velocity.shape, order="F")
    result[:, 0] = cos * velocity[:, 0] + sin * velocity[:, 1]
    result[:, 1] = cos * velocity[:, 1] - sin * velocity[:, 0]
    result[:, 2] = velocity[:, 2]
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
    left, mean = shrunk(size, response[[0, 2]], most, duration)
    shares = np.zeros((2,) + size.shape)
    np.divide(left, size, out=shares[0], where=size > 0.0)
    np.divide(mean, size, out=shares[1], where=size > 0.0)
    left, mean = shares[:, [0, 0, 1]]
    return (wanted.T - left * error).T, (wanted.T - mean * error).T


def flown(flight, wanted, heading, turning, air, numbers, duration):
    """Return the ``flight.Flight`` after ``duration`` [s] with forces, towards ``wanted`` (m, 3) [m/s].

    ``heading`` (m,) [rad]: what attitudes aim at, which turns by ``turning`` (m,) [rad/s]; ``air`` (m, 3)
    [m/s]: the wind.  The velocity's controller works every few substeps, the others at each.
    """
    count = max(1, int(np.ceil(duration / SUBSTEP - 1e-9)))
    step = duration / count
    for index in range(count):
        if index % VELOCITY_EVERY == 0:
            acceleration = flight_control.wanted_acceleration(flight.velocity, wanted, numbers)
            attitude = flight_control.attitude_of(acceleration, heading + index * step * turning)
        forces = acting(flight, numbers)
        told = flight_control.rotor_speeds(flight, forces, acceleration, attitude, turning, numbers)
        flight = advanced(flight, forces, told, air, numbers, step)
    return flight
