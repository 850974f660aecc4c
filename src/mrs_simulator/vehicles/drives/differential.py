"""Differential drive: driven wheels left and right; the unicycle of the paper's equation (1).

Two wheels on one axle, or four wheels that slide when the robot turns (skid steer): then the track is
the effective one, at which wheel speeds give the true turn rate.

It obeys forward speed ``v`` and turn rate ``omega``.  Its controlled point is the hand point, ``l``
ahead of the axle's centre, eq. (2).  Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and
``command`` (m, 2), one column for each of ``AXES``; ``inner`` (m, 2), what ramps: the velocities;
``joints`` (m,), which this drive has none of.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import body_speeds, clip_commands, displaced, wheel_speeds
from mrs_simulator.scenario.reading import unwanted
from mrs_simulator.vehicles.drives.wheel_stand import Stand

AXES = ("linear.x", "angular.z")
LIMIT_AXES = AXES  # that a kind's file gives limits of
MEDIUM = "ground"  # in which the robots move: ground, water or air
SECTION = "wheels"  # of a kind's file
ENCODERS = 2  # wheels that are counted: left, right
POINT = "hand point"
JOINTS = False  # whether ``joints`` move
CLIPPED = True  # whether targets of ramps are commands clipped axis by axis, and nothing else
OWN_LIMITS = False  # whether there are limits besides the axes'
RAMPS = True  # whether inner states ramp towards their targets


class DifferentialParameters(NamedTuple):
    """Wheel parameters of a kind; of several kinds each number is a column (m,)."""

    track: float  # [m] between the wheels; with skid steer the effective one
    radius: float  # [m]
    joints: Tuple[
        str, ...
    ] = ()  # left and right, in the kind's model; with skid steer front and rear
    torque: float = 0.0  # [N m] at a wheel
    friction: float = 0.0  # [-]
    spin_friction: float = 0.0  # [m]
    spacing: float = 0.0  # [m] between left and right wheels of a skid steer
    wheelbase: float = 0.0  # [m] between its front and rear wheels; 0 for two wheels on one axle


# The numbers that the functions below use.
COLUMNS = ("track", "radius", "torque", "spacing", "wheelbase")


def read(section):
    """Return the ``DifferentialParameters`` in a kind's ``section``, a ``QuantitySection``."""
    return DifferentialParameters(
        track=section.quantity("track", "m", above=0.0, high=100.0),
        radius=section.quantity("radius", "m", above=0.0, high=100.0),
        joints=_read_joints(section),
        torque=section.quantity("torque", "N m", 6.0, above=0.0),
        friction=section.quantity("friction", "", 0.9, low=0.0),
        spin_friction=section.quantity("spin_friction", "m", 0.001, low=0.0),
        **_read_skid(section),
    )


def _read_joints(section):
    if not section.has("joints"):
        return section.take("joints", ())
    given = section.take("joints")
    return section.strings("joints", 4 if isinstance(given, list) and len(given) == 4 else 2)


def _read_skid(section):
    """Return where the wheels of a skid steer stand; both keys or neither."""
    keys = ("spacing", "wheelbase")
    given = [key for key in keys if section.has(key)]
    if len(given) == 1:
        missing = keys[1 - keys.index(given[0])]
        raise unwanted(
            section.at(missing), None, "with {} (four wheels), or neither (two)".format(given[0])
        )
    if not given:
        return {key: section.take(key, 0.0) for key in keys}
    return {key: section.quantity(key, "m", above=0.0, high=100.0) for key in keys}


def unlimited(numbers):
    """Return ``numbers`` without limits of the drive's own: it has none."""
    return numbers


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the ground, that of the axles."""
    return numbers.radius


def target(command, inner, limits, numbers):
    """Return the inner states, velocities (m, 2), to which the firmware ramps: clipped commands."""
    return clip_commands(command, limits.top)


def rates(limits, numbers):
    """Return how fast it does, (m, axes) [m/s^2, rad/s^2]."""
    return limits.acceleration


def blocked(inner, moved):
    """Return the ``inner`` states (m, 2) of robots that moved by ``moved`` (m, 2) [m/s] in a contact.

    ``moved`` is given in the body's frame.  A robot is no faster than its wheels turn, and never
    goes the other way.
    """
    result, own = inner.copy(), inner[:, 0]
    result[:, 0] = np.sign(own) * np.clip(np.sign(own) * moved[:, 0], 0.0, np.abs(own))
    return result


def wheel_rates(velocity, joints, numbers):
    """Return the turn rates of the wheels named in ``numbers.joints``, (m, 2) [rad/s]."""
    return (wheel_speeds(velocity, numbers.track).T / numbers.radius).T


def rim_speeds(mean, joints, numbers):
    """Return the speeds of the wheels' rims, (m, 2) [m/s]: left and right, ``v -+ omega track/2``."""
    return wheel_speeds(mean, numbers.track)


def odometry_pose(pose, rolled, joints, numbers):
    """Return the poses (m, 3) by odometry after wheels ``rolled`` (m, 2) [m]."""
    return displaced(pose, body_speeds(rolled, numbers.track), 1.0)


def at_limits(command, top, numbers, share):
    """Return where a ``command`` (..., m, axes) has reached ``share`` of its limits, (..., m) bool."""
    return (np.abs(command) >= share * top).any(axis=-1)


def is_pushed(numbers):
    """Return whether, in motion with forces, wheel forces of ``stand`` push the body.

    Those of a skid steer, whose wheels slide all the time when it turns; two wheels roll in the solver.
    """
    return numbers.wheelbase > 0.0


def stand(joints, numbers):
    """Return the ``Stand`` of skid steers: front left, front right, rear left, rear right.

    Turning without torque, ``y (rim - omega y) = x (omega x)`` for wheels at (+-x, +-y): dry friction
    gives the effective track ``2 (x^2 + y^2)/y``.
    """
    m = len(joints)
    along, across = np.zeros((m, 4, 3)), np.zeros((m, 4, 3))
    along[:, :, 0] = across[:, :, 1] = 1.0
    along[:, :, 2] = np.multiply.outer(np.broadcast_to(numbers.spacing, m), [-0.5, 0.5, -0.5, 0.5])
    across[:, :, 2] = np.multiply.outer(
        np.broadcast_to(numbers.wheelbase, m), [0.5, 0.5, -0.5, -0.5]
    )
    push = np.repeat(np.broadcast_to(numbers.torque / numbers.radius, m), 4).reshape(m, 4)
    return Stand(along, across, np.full((m, 4), 0.25), push, np.zeros(m))


def rim_targets(velocity, joints, numbers):
    """Return the speeds (m, 4) [m/s] at which the motors hold the rims of a skid steer."""
    return np.tile(wheel_speeds(velocity, numbers.track), 2)


def counted(turning, joints, numbers):
    """Return what the encoders count per second, (m, 2) [m/s], of rims ``turning`` (m, 4)."""
    return 0.5 * (turning[:, :2] + turning[:, 2:])


def arm(l, numbers):
    """Return how far [m] the controlled point is ahead of the centre: eq. (2)."""
    return l


lead = arm  # the point stays there


def command(along, across, joints, l, period, numbers):
    """Return the commands (m, 2) that move the hand points ``along`` and ``across`` the heading.

    ``(v, omega) = (along, across/l)``: eq. (7), in which ``R(theta)' u = (along, across)``, (m,) [m/s].
    """
    result = np.empty((len(along), 2), order="F")
    result[:, 0] = along
    np.divide(across, l, result[:, 1])
    return result


def velocity(command, joints, l, period, numbers):
    """Return the hand points' velocities along and across the heading, (m,) [m/s], eq. (3)."""
    return command[:, 0], l * command[:, 1]
