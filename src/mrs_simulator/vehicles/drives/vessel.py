"""Vessels with two thrusters: commands are the speed through the water ``u`` and the turn rate ``r``.

With forces they are bodies in water (``hydrodynamics``) with speed controllers (``vessel_dynamics``).
Without forces u and r follow with the time constant of their controllers, ``(M + k_d)/(d + k_p)``, and the
boat does not slip sideways.

**The controlled point** lies at the bow, ``ahead + l`` before the centre along the heading, and moves
through the water with

    (cos, sin) u + (ahead + l) (-sin, cos) r,

as the hand point of a unicycle does.  The current comes on top: it is not in the commands, so that under
``u = -k (p - p*)`` the point rests ``V/k`` from where it should; and sideways slip, which steady motion has
none of.

Of m robots: ``command`` (m, 2), a column for each of ``AXES``; ``inner`` (m, 2): u and r.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import clip_commands
from mrs_simulator.vehicles.drives import thrusters
from mrs_simulator.vehicles.drives.car import odometry_pose, rim_speeds  # noqa: F401, as there
from mrs_simulator.vehicles.drives.differential import blocked, rates  # noqa: F401
from mrs_simulator.vehicles.drives.velocity_lag import remaining_error
from mrs_simulator.vehicles.drives.vessel_dynamics import (  # noqa: F401, of the drive too
    axis_velocity,
    begin,
    moved_with_forces,
    responses,
    stopped,
    twist_of,
)

AXES = ("linear.x", "angular.z")
LIMIT_AXES = AXES
SECTION = "hull"  # of a kind's file
MEDIUM = "water"
POINT = "point ahead of the bow"
JOINTS = False  # whether ``joints`` move
OWN_LIMITS = True  # whether there are limits besides the axes': backwards
RAMPS = False  # whether inner states ramp towards their targets: they follow their controllers
ENCODERS = 2  # distance through the water [m] by the log, and angle turned [rad] by the gyro


class VesselParameters(NamedTuple):
    """Hull and thruster parameters of a kind; of several kinds each number is a column (m, ...)."""

    inertia: Tuple[float, ...]  # (4,) m1, m2 [kg], m3 [kg m^2], s [kg m], added mass included
    linear: Tuple[float, ...]  # (3,) damping, [N s/m, N s/m, N m s]
    quadratic: Tuple[float, ...]  # (3,) [N s^2/m^2, ...]
    wind: Tuple[float, ...]  # (3,) [N s^2/m^2, N s^2/m^2, N s^2/m]
    waves: Tuple[float, ...]  # (2,) force aside [N/m] and torque [N], per m of significant height
    point: float  # [m] of the bow ahead of the centre
    arm: float  # [m] of a thruster from the middle
    curve: str  # one of ``thrusters.CURVES``
    ahead: float  # greatest command
    astern: float
    factor_ahead: float  # of the curve
    factor_astern: float
    lag: float  # [s] of the thrusters
    gains: Tuple[Tuple[float, ...], ...]  # (2, 4): of u and r each k_f, k_p, k_i, k_d
    most: float = np.nan  # [N] of a thruster, which follows from its curve
    least: float = np.nan  # [N], astern, below 0
    backward: float = np.inf  # [m/s], greatest speed backwards where it is less than forwards


COLUMNS = VesselParameters._fields  # the numbers that the functions below use


def read(section):
    """Return the ``VesselParameters`` in a kind's ``section``, a ``QuantitySection``."""
    inertia, linear, quadratic, wind, waves, thrust = (
        section.section(key)
        for key in ("inertia", "linear", "quadratic", "wind", "waves", "thrusters")
    )
    gains = section.section("gains")
    curve = thrust.text("curve", choices=thrusters.CURVES)
    units = (
        ("N", "") if curve == "linear" else ("N s^2", "rad/s") if curve == "square" else ("", "")
    )
    numbers = VesselParameters(
        inertia=tuple(
            inertia.quantity(key, unit, **bounds)
            for key, unit, bounds in (
                ("surge", "kg", {"above": 0.0}),
                ("sway", "kg", {"above": 0.0}),
                ("yaw", "kg m^2", {"above": 0.0}),
                ("sway_yaw", "kg m", {"default": 0.0}),
            )
        ),
        linear=_each(linear, ("N s/m", "N s/m", "N m s")),
        quadratic=_each(quadratic, ("N s^2/m^2", "N s^2/m^2", "N m s^2"), default=0.0),
        wind=_each(wind, ("N s^2/m^2", "N s^2/m^2", "N s^2/m"), default=0.0),
        waves=(
            waves.quantity("sway", "N/m", 0.0, low=0.0),
            waves.quantity("yaw", "N", 0.0, low=0.0),
        ),
        point=section.quantity("bow", "m", low=0.0, high=100.0),
        arm=thrust.quantity("arm", "m", above=0.0, high=100.0),
        curve=curve,
        ahead=thrust.quantity("ahead", units[1], 1.0, above=0.0),
        astern=thrust.quantity("astern", units[1], 1.0, low=0.0),
        factor_ahead=1.0
        if curve == "logistic"
        else thrust.quantity("thrust_ahead", units[0], above=0.0),
        factor_astern=1.0
        if curve == "logistic"
        else thrust.quantity("thrust_astern", units[0], above=0.0),
        lag=thrust.quantity("lag", "s", 0.0, low=0.0, high=10.0),
        gains=tuple(_gains(gains.section(key)) for key in ("surge", "yaw")),
        backward=section.quantity("backward", "m/s", above=0.0)
        if section.has("backward")
        else section.take("backward", np.inf),
    )
    for each in (inertia, linear, quadratic, wind, waves, thrust, gains):
        each.done()
    most, least = thrusters.ends(numbers)
    return numbers._replace(most=most, least=least)


def _each(section, units, **default):
    return tuple(
        section.quantity(key, unit, low=0.0, **default)
        for key, unit in zip(("surge", "sway", "yaw"), units)
    )


def _gains(section):
    gains = tuple(section.quantity(key, "", 0.0, low=0.0) for key in ("kf", "kp", "ki", "kd"))
    section.done()
    return gains


def unlimited(numbers):
    """Return ``numbers`` of robots that answer at once, for motion without forces."""
    gains = np.array(numbers.gains)
    gains[..., 3] = 0.0
    if isinstance(numbers.gains, tuple):
        return numbers._replace(
            inertia=(0.0,) * 4, gains=tuple(map(tuple, gains.tolist())), backward=np.inf
        )
    return numbers._replace(inertia=np.zeros_like(numbers.inertia), gains=gains, backward=np.inf)


def _possible(command, limits, numbers):
    """Return ``command`` (m, 2) clipped to the greatest speeds."""
    result = clip_commands(command, limits.top)
    result[:, 0] = np.maximum(result[:, 0], -numbers.backward)
    return result


def target(command, inner, limits, numbers):
    """Return the inner states, u and r (m, 2), that controllers track: those within limits."""
    return _possible(command, limits, numbers)


def followed(inner, wanted, limits, numbers, step):
    """Return u and r (m, 2), and mean u and r (m, 2), after ``step`` [s] without forces."""
    error = (wanted - inner).T
    left, mean = remaining_error(
        np.abs(error), responses(numbers), limits.acceleration.T.reshape(2, -1), step
    )
    return (wanted.T - np.copysign(left, error)).T, (wanted.T - np.copysign(mean, error)).T


def forced(pose, inner, command, limits, numbers, disturbances, step, efforts=None):
    """Return poses (m, 3) and ``VesselState`` after ``step`` [s] with forces under ``command`` (m, 2).

    ``disturbances``: the ``Disturbances`` of these robots; ``efforts`` (m, 4): direct
    thruster commands, as of ``vessel_dynamics.thruster_commands``.
    """
    return moved_with_forces(
        pose, inner, _possible(command, limits, numbers), numbers, disturbances, step, efforts
    )


def excess(command, joints, numbers, period):
    """Return by which factor each ``command`` (m, 2) is beyond the limit backwards, (m,)."""
    return command[:, 0] / -numbers.backward


def at_limits(command, top, numbers, share):
    """Return where a ``command`` (..., m, 2) has reached ``share`` of its limits, (..., m) bool."""
    u = command[..., 0]
    fast = (u >= share * top[..., 0]) | (-u >= share * np.minimum(numbers.backward, top[..., 0]))
    return fast | (np.abs(command[..., 1]) >= share * top[..., 1])


def arm(l, numbers):
    """Return how far [m] the controlled point is ahead of the centre."""
    return numbers.point + l


lead = arm  # the point stays there


def command(along, across, joints, l, period, numbers):
    """Return the commands (m, 2) that move the points ``along`` and ``across`` the heading, (m,) [m/s],
    through the water."""
    result = np.empty((len(along), 2), order="F")
    result[:, 0], result[:, 1] = along, across / arm(l, numbers)
    return result


def velocity(command, joints, l, period, numbers):
    """Return the points' velocities along and across the heading, (m,) [m/s], through the water."""
    return command[:, 0], arm(l, numbers) * command[:, 1]


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the water: it lies on the waterline."""
    return 0.0


def lateness(numbers):
    """Return the greatest lag [s] of speeds: their greatest time constant."""
    return float(responses(numbers).max())
