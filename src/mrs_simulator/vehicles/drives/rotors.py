"""Four rotors on a rigid body: thrust, torque, drag and the lag of their motors.

A rotor at speed n [rad/s] pulls along the body's z axis with ``k n^2`` and turns the body against its own
spin with ``c n^2``.  They sit at the ends of an "x" of arms a, front right first, then clockwise; the
first turns the body counter-clockwise.  With ``s = n^2``,

    thrust   = k (s1 + s2 + s3 + s4),            torque x = k a/sqrt(2) (-s1 - s2 + s3 + s4),
    torque y = k a/sqrt(2) (-s1 + s2 + s3 - s4), torque z = c (s1 - s2 + s3 - s4).

Air that moves against the body with v resists with ``-sum(n) (d, d, d_z) v`` in the body's frame, the
drag of spinning blades (Forster, "System identification of the Crazyflie 2.0 nano quadrocopter", 2015).
Motors follow commanded speeds as first-order lags.

Arrays hold one robot per row and lie in memory column by column.  A number is a scalar where all m robots
have the same, else an array (m,); one of k parts is a tuple, else an array (m, k).
"""

import functools

import numpy as np

GRAVITY = 9.81  # [m/s^2]
ROTORS = 4


def effect_of(arm, thrust, torque):
    """Return ``effect``, the factors of thrust and torques about x, y, z above, a tuple.

    ``arm`` [m] from the centre to each rotor; ``thrust`` k [N s^2] and ``torque`` c [N m s^2].
    """
    lever = thrust * arm / np.sqrt(2.0)
    return thrust, lever, lever, torque


@functools.lru_cache(maxsize=None)
def _upright(values):
    return np.array(values).reshape(-1, 1)


def parts(number):
    """Return a number of k parts as an array (k, 1), or (k, m) where robots differ."""
    return _upright(number) if isinstance(number, tuple) else number.T


def wrench_of(speeds, numbers):
    """Return thrust [N] and torques about x, y, z [N m], (m, 4), of rotors at ``speeds`` (m, 4) [rad/s]."""
    s = (speeds * speeds).T
    right, left = s[0] + s[1], s[2] + s[3]
    first, second = s[0] - s[1], s[2] - s[3]
    result = np.empty(s.shape)
    np.add(left, right, out=result[0])
    np.subtract(left, right, out=result[1])
    np.subtract(second, first, out=result[2])
    np.add(second, first, out=result[3])
    result *= parts(numbers.effect)
    return result.T


def speeds_of(wrench, numbers):
    """Return the rotor speeds (m, 4) [rad/s] that give ``wrench`` (m, 4), or what comes nearest.

    Where a rotor would have to turn faster or slower than it can, thrust gives way to torques, so that
    the robot keeps its attitude; what is still out of reach is cut off.
    """
    t, x, y, z = wrench.T / (ROTORS * parts(numbers.effect))
    right, left = t - x, t + x
    first, second = z - y, z + y
    s = np.empty((ROTORS, len(t)))
    np.add(right, first, out=s[0])
    np.subtract(right, first, out=s[1])
    np.add(left, second, out=s[2])
    np.subtract(left, second, out=s[3])
    least, most = numbers.speed_min**2, numbers.speed_max**2
    lift = np.maximum(least - s.min(axis=0), 0.0)
    lift -= np.maximum(s.max(axis=0) + lift - most, 0.0)
    s += lift
    return np.sqrt(np.minimum(np.maximum(s, least), most)).T


def lagged_speeds(speeds, wanted, numbers, duration):
    """Return rotor speeds (m, 4) after ``duration`` [s] towards ``wanted`` (m, 4), exactly.

    ``n' = (wanted - n)/lag``; without lag they are there at once.
    """
    return (wanted.T + remaining_share(numbers, duration) * (speeds - wanted).T).T


def remaining_share(numbers, duration):
    """Return what is left of an error of rotor speeds after ``duration`` [s], a number or (m,) [-]."""
    lag = np.maximum(numbers.lag, 1e-3 * duration)  # of which nothing is left after the step
    return np.exp(-duration / lag)


def hover_speed(numbers, gravity=GRAVITY):
    """Return the rotor speed [rad/s] at which thrust carries the robot: ``sqrt(m g/(4 k))``."""
    return np.sqrt(numbers.mass * gravity / (ROTORS * _thrust(numbers)))


def _thrust(numbers):
    factor = parts(numbers.effect)[0]
    return factor if len(factor) > 1 else float(factor[0])


def greatest_thrust(numbers):
    """Return the thrust [N] of all rotors at their greatest speed."""
    return ROTORS * _thrust(numbers) * numbers.speed_max**2


def greatest_climb(numbers, gravity=GRAVITY):
    """Return the greatest upward acceleration [m/s^2]: ``(thrust/weight - 1) g``."""
    return greatest_thrust(numbers) / numbers.mass - gravity


def hover_drag(numbers, gravity=GRAVITY):
    """Return the drag while hovering along the body's x, y, z axes, (3, 1) or (3, m) [N s/m]."""
    return ROTORS * hover_speed(numbers, gravity) * parts(numbers.drag)
