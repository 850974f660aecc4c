"""A drive for tests: a point that flies; it obeys velocities along its heading and up, by ramps.

Registered under the name ``hoverer`` by the fixture ``hoverer`` of ``flying_fixtures``.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import clip_commands, cos_sin, ramp, wrap_angle
from mrs_simulator.core.spatial import upright

AXES = LIMIT_AXES = ("linear.x", "linear.y", "linear.z", "angular.z")
MEDIUM, ENCODERS, POINT = "air", 0, "centre"
JOINTS, OWN_LIMITS, RAMPS = False, False, True
SECTION = "flight"
FALL = 0.3  # [m/s] at which a robot comes down that has heard nothing
HOVER = 1.0  # [s] for which it stays where it is before


class HovererParameters(NamedTuple):
    lean: float  # [rad s/m] of pitch for a speed ahead
    joints: tuple = ()


class Inner(NamedTuple):
    place: np.ndarray  # (m, 3)
    heading: np.ndarray  # (m,)
    velocity: np.ndarray  # (m, 4), as AXES
    lean: np.ndarray  # (m,), of the kinds


COLUMNS = ("lean",)


def read(section):
    return HovererParameters(section.quantity("lean", "", 0.1, low=0.0))


def unlimited(numbers):
    return numbers


def begin(pose, z, numbers):
    m = len(pose)
    lean = np.broadcast_to(numbers.lean, m)
    return Inner(np.column_stack([pose[:, :2], z]), pose[:, 2].copy(), np.zeros((m, 4)), lean)


def flown(inner, command, limits, numbers, step):
    velocity, mean = ramp(
        inner.velocity, clip_commands(command, limits.top), limits.acceleration, step
    )
    cos, sin = cos_sin(inner.heading)
    place = inner.place.copy()
    place[:, 0] += step * (cos * mean[:, 0] - sin * mean[:, 1])
    place[:, 1] += step * (sin * mean[:, 0] + cos * mean[:, 1])
    place[:, 2] += step * mean[:, 2]
    return Inner(place, wrap_angle(inner.heading + step * mean[:, 3]), velocity, inner.lean)


def state(inner):
    pose = np.column_stack([inner.place[:, :2], inner.heading])
    v = inner.velocity
    spatial = upright(inner.heading, inner.place[:, 2])
    half = 0.5 * inner.lean * v[:, 0]
    z, w = spatial.orientation[:, 2].copy(), spatial.orientation[:, 3].copy()
    spatial.orientation[:] = np.column_stack(
        [-z * np.sin(half), w * np.sin(half), z * np.cos(half), w * np.cos(half)]
    )
    spatial.twist[:, 0] = v[:, 2]
    return pose, v[:, [0, 1, 3]], spatial


def stopped(inner, pushed, place, most):
    most = np.broadcast_to(most, (len(pushed), 3))
    velocity, where = inner.velocity.copy(), inner.place.copy()
    where[pushed] = place[pushed]
    across = np.hypot(most[pushed, 0], most[pushed, 1])[:, np.newaxis]
    velocity[pushed, :2] = np.clip(velocity[pushed, :2], -across, across)
    velocity[pushed, 2] = np.clip(velocity[pushed, 2], -most[pushed, 2], most[pushed, 2])
    return inner._replace(place=where, velocity=velocity)


def silent(seconds, numbers):
    """Hover, then come down."""
    command = np.zeros((len(seconds), 4))
    command[seconds > HOVER, 2] = -FALL
    return command


def at_limits(command, top, numbers, share):
    return (np.abs(command) >= share * top).any(axis=-1)


def lead(l, numbers):
    return 0.0


def arm(l, numbers):
    return 0.0


def command(along, across, joints, l, period, numbers):
    return np.column_stack([along, across, 0.0 * along, 0.0 * along])


def velocity(command, joints, l, period, numbers):
    return command[:, 0], command[:, 1]


def ride_height(numbers):
    return 0.0
