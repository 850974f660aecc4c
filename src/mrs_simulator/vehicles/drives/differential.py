"""Differential drive: two driven wheels on one axle; the unicycle of the paper's equation (1).

It obeys forward speed ``v`` and turn rate ``omega``.  Its controlled point is the hand point, ``l``
ahead of the axle's centre, eq. (2).  Of m robots: ``pose`` (m, 3) [m, m, rad]; ``velocity`` and
``command`` (m, 2), one column for each of ``AXES``; ``joints`` (m,), which this drive has none of.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mrs_simulator.core.kinematics import (
    arc,
    body_speeds,
    clip_commands,
    hand_points,
    point_mass_from_unicycle,
    ramp,
    unicycle_from_point_mass,
    wheel_speeds,
    wrap_angle,
)

AXES = ("linear.x", "angular.z")
SECTION = "wheels"  # of a kind's file
ENCODERS = 2  # wheels that are counted: left, right
POINT = "hand point"


class Numbers(NamedTuple):
    """What a kind tells of its wheels; of several kinds each number is a column (m,)."""

    track: float  # [m] between the wheels; with skid steer the effective one
    radius: float  # [m]
    joints: Tuple[str, str] = ()  # left and right, in the kind's model
    torque: float = 0.0  # [N m] at a wheel
    friction: float = 0.0  # [-]
    spin_friction: float = 0.0  # [m]


COLUMNS = ("track", "radius")  # the numbers that the functions below use


def read(section):
    """Return the ``Numbers`` in a kind's ``section``, a ``QuantitySection``."""
    return Numbers(
        track=section.quantity("track", "m", above=0.0, high=100.0),
        radius=section.quantity("radius", "m", above=0.0, high=100.0),
        joints=section.strings("joints", 2)
        if section.has("joints")
        else section.take("joints", ()),
        torque=section.quantity("torque", "N m", 6.0, above=0.0),
        friction=section.quantity("friction", "", 0.9, low=0.0),
        spin_friction=section.quantity("spin_friction", "m", 0.001, low=0.0),
    )


def ride_height(numbers):
    """Return the height [m] of the model's base_link above the ground: that of the wheels' axle."""
    return numbers.radius


def ramped(velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 2), joints (m,) and mean velocity (m, 2) of the firmware's next ``step`` [s].

    Commands are clipped to ``limits.top`` and ramped by ``limits.acceleration``, (2,) or (m, 2).
    """
    velocity, mean = ramp(velocity, clip_commands(command, limits.top), limits.acceleration, step)
    return velocity, joints, mean


def move(pose, velocity, joints, command, limits, numbers, step):
    """Return velocity (m, 2), joints (m,), mean velocity (m, 2) and pose (m, 3) after ``step`` [s].

    The velocities are those of :func:`ramped`; the arc is that of the mean velocity, exact while the
    velocity holds.
    """
    velocity, joints, mean = ramped(velocity, joints, command, limits, numbers, step)
    after = arc(pose, mean, step)
    after[:, 2] = wrap_angle(after[:, 2])
    return velocity, joints, mean, after


def fill_twist(twist, velocity, joints, numbers):
    """Write the body twists (m, 3), vx, vy [m/s], omega [rad/s], of ``velocity`` into ``twist``."""
    twist[:, 0], twist[:, 2] = velocity[:, 0], velocity[:, 1]


def farthest(mean):
    """Return the greatest speed [m/s] of a centre at the ``mean`` velocities (m, 2)."""
    return float(np.abs(mean[:, 0]).max(initial=0.0))


def top_speed(limits):
    """Return the speed [m/s] that no robot of these ``limits`` exceeds."""
    return float(np.max(limits.top[..., 0]))


def blocked(velocity, moved):
    """Return the velocities (m, 2) of robots that a contact let move by ``moved`` (m, 2) [m/s].

    ``moved`` is given in the body's frame.  A robot is no faster than its wheels turn, and never
    goes the other way.
    """
    result, own = velocity.copy(), velocity[:, 0]
    result[:, 0] = np.sign(own) * np.clip(np.sign(own) * moved[:, 0], 0.0, np.abs(own))
    return result


def wheel_rates(velocity, joints, numbers):
    """Return the turn rates of the wheels named in ``numbers.joints``, (m, 2) [rad/s]."""
    return (wheel_speeds(velocity, numbers.track).T / numbers.radius).T


def rim_speeds(mean, joints, numbers):
    """Return the speeds of the wheels' rims, (m, 2) [m/s]: left and right, ``v -+ omega track/2``."""
    return wheel_speeds(mean, numbers.track)


def reckoned(pose, rolled, joints, numbers):
    """Return the poses (m, 3) that odometry makes of wheels that ``rolled`` (m, 2) [m] further."""
    after = arc(pose, body_speeds(rolled, numbers.track), 1.0)
    after[:, 2] = wrap_angle(after[:, 2])
    return after


def excess(command, top, numbers):
    """Return by which factor each ``command`` (m, 2) is beyond ``top``, (m,); up to 1 within."""
    share = np.abs(command) / top
    return np.maximum(share[:, 0], share[:, 1])


def point(pose, joints, l, numbers):
    """Return the hand points (m, 2) [m], eq. (2)."""
    return hand_points(pose, l)


def command(velocity, pose, joints, l, period, numbers):
    """Return the commands (m, 2) that give the hand points ``velocity`` (m, 2) [m/s], eq. (7)."""
    return unicycle_from_point_mass(velocity, pose[:, 2], l)


def velocity(command, pose, joints, l, period, numbers):
    """Return the hand points' velocities (m, 2) [m/s] under ``command`` (m, 2), eq. (3)."""
    return point_mass_from_unicycle(command, pose[:, 2], l)
