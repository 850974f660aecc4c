"""Vessels on the water in three degrees of freedom: surge, sway and yaw.

    M v' + C(v) v + D(v) v = tau,      p' = R(theta) v + (V_x, V_y, 0),

v = (u, v, r) the velocity through the water in the body's frame, x ahead, y to the left; V the current,
uniform and steady, with which the inertia of the water moves too, so that it is in neither M nor C.

    M = [[m1, 0, 0], [0, m2, s], [0, s, m3]],   D = diag(d + d2 |v|),
    C = [[0, 0, c], [0, 0, m1 u], [-c, -m1 u, 0]],  c = -(m2 v + s r).

C does no work and D takes energy away: ``v' M v/2`` never grows without forces.  Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control (2011), chapters 6 to 8; of y to the left instead of
starboard and z up instead of down M, C and D are the same.

Arrays hold one robot per row, in memory column by column; numbers are as ``rotors`` has them.
"""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin, wrap_angle
from mrs_simulator.vehicles.drives.rotors import parts


def resistance(velocity, numbers, drag=None):
    """Return ``(C(v) + D(v)) v``, (m, 3) [N, N, N m], of ``velocity`` (m, 3) through the water.

    ``drag``: the :func:`damping` at ``velocity``, where it is known.
    """
    u, v, r = velocity.T
    m1, m2, _, s = parts(numbers.inertia)
    result = (damping(velocity, numbers) if drag is None else drag).T * velocity.T
    turning = m2 * v + s * r
    result[0] -= turning * r
    result[1] += m1 * u * r
    result[2] += (turning - m1 * v) * u
    return result.T


def damping(velocity, numbers):
    """Return the diagonal of ``D(v)``, (m, 3)."""
    return (parts(numbers.linear) + parts(numbers.quadratic) * np.abs(velocity.T)).T


def moved(velocity, force, numbers, duration):
    """Return velocities (m, 3) through the water after ``duration`` [s] of ``force`` (m, 3) [N, N, N m].

    By the trapezoidal rule with C and D as they are at the beginning,

        (M + h/2 (C + D)) (v_after - v) = h (force - (C + D) v),

    under which the energy never grows either: it changes by the work of ``force - D v`` at the mean of both
    velocities, and C does none.
    """
    m1, m2, m3, s = parts(numbers.inertia)
    half = 0.5 * duration
    drag = damping(velocity, numbers)
    d1, d2, d3 = half * drag.T
    u, v, r = velocity.T
    turning, ahead = -half * (m2 * v + s * r), half * m1 * u
    b1, b2, b3 = duration * (force - resistance(velocity, numbers, drag)).T
    a1, a2 = m1 + d1, m2 + d2
    to_sway, from_sway = s + ahead, s - ahead
    result = np.empty((3, len(u)))
    result[2] = (b3 + turning * b1 / a1 - from_sway * b2 / a2) / (
        m3 + d3 + turning * turning / a1 - from_sway * to_sway / a2
    )
    result[0] = (b1 - turning * result[2]) / a1
    result[1] = (b2 - to_sway * result[2]) / a2
    result += velocity.T
    return result.T


def drifted(pose, mean, current, duration):
    """Return the poses (m, 3) after ``duration`` [s] of ``mean`` velocities (m, 3) through the water.

    ``current`` (2,) or (m, 2) [m/s], common frame.  Exact while both hold; the heading is wrapped.
    """
    half = 0.5 * duration * mean[:, 2]
    if half.all():
        share = duration * np.sin(half) / half
    else:
        share = np.full(len(half), float(duration))
        np.divide(duration * np.sin(half), half, out=share, where=half != 0.0)
    cos, sin = cos_sin(pose[:, 2] + half)
    after = np.empty(pose.shape, order="F")
    after[:, 0] = pose[:, 0] + share * (cos * mean[:, 0] - sin * mean[:, 1])
    after[:, 1] = pose[:, 1] + share * (sin * mean[:, 0] + cos * mean[:, 1])
    along, across = duration * np.asarray(current).T
    after[:, 0] += along
    after[:, 1] += across
    after[:, 2] = wrap_angle(pose[:, 2] + 2.0 * half)
    return after


def into_body(vectors, theta, turn=None):
    """Return ``vectors`` (2,) or (m, 2), of the common frame, in the bodies' frames, (m, 2).

    ``turn``: cosine and sine of ``theta``, where they are known.
    """
    cos, sin = cos_sin(theta) if turn is None else turn
    x, y = np.asarray(vectors).T
    result = np.empty((2, len(cos)))
    result[0] = cos * x + sin * y
    result[1] = cos * y - sin * x
    return result.T


def over_ground(velocity, theta, current, turn=None):
    """Return the velocities over ground in the body's frame, (m, 3), of those through the water.

    ``theta`` (m,) [rad]; ``current`` (2,) or (m, 2) [m/s], common frame; ``turn`` as of :func:`into_body`.
    """
    result = velocity.copy(order="F")
    result[:, :2] += into_body(current, theta, turn)
    return result


def energy(velocity, numbers):
    """Return ``v' M v/2`` [J], (m,)."""
    u, v, r = velocity.T
    m1, m2, m3, s = parts(numbers.inertia)
    return 0.5 * (m1 * u * u + m2 * v * v + m3 * r * r) + s * v * r


def wind_force(air, numbers):
    """Return the wind's force (m, 3) [N, N, N m] at ``air`` (m, 2) [m/s], body frame, relative to the boat.

    ``X = a |x| x,  Y = b |y| y,  N = -2 c x y``, as the simulator VRX has it.
    """
    x, y = air.T
    ahead, aside, turn = parts(numbers.wind)
    result = np.empty((3, len(x)))
    result[0] = ahead * np.abs(x) * x
    result[1] = aside * np.abs(y) * y
    result[2] = -2.0 * turn * x * y
    return result.T
