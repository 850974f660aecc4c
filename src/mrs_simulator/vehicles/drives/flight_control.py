"""Controllers that quadrotors carry: velocity to attitude, attitude to rates, rates to torques, rotors.

    a = k_v (v_wanted - v) + drag(v)/m,      thrust vector f = m (a + g e),
    w_wanted = k_R theta,                           theta: the turn from the attitude to that of f,
    torque = J (k_w (w_wanted - w) - k_d w') + w x J w.

``k_d`` works on the angular acceleration, which robots have from their differentiated gyro.  About level,
with motors of lag T, the turn phi about one axis then obeys

    T phi''' + (1 + k_d) phi'' + k_w phi' + k_w k_R phi = k_w k_R phi_wanted,

so that ``k_R = p/3``, ``k_w = 3 p^2 T``, ``k_d = 3 p T - 1`` puts all three poles to -p: the attitude is as
quick as wanted whatever the motors' lag, as long as they have the thrust.  Without that term the loop is
unstable from ``k_R > 1/T`` on (Routh), and badly damped long before.
"""

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.drives.rotors import (
    GRAVITY,
    greatest_climb,
    hover_drag,
    parts,
    speeds_of,
)

SINKING = 0.5  # [-] of gravity: greatest commanded downward acceleration
CLIMBING = 0.8  # [-] of the greatest upward acceleration, the rest is left for torques


def poles_at(pole, lag):
    """Return the gains ``k_R, k_w`` [1/s] and ``k_d`` [-] that put the three poles of attitude to -pole."""
    return pole / 3.0, 3.0 * pole * pole * lag, 3.0 * pole * lag - 1.0


def wanted_acceleration(velocity, wanted, numbers):
    """Return the accelerations (m, 3) [m/s^2] that bring ``velocity`` (m, 3) to ``wanted`` (m, 3).

    Within what tilt and thrust allow; ``k_v (v_wanted - v)`` and what the drag in still air takes.
    """
    result = parts(numbers.velocity_gain) * (wanted - velocity).T
    result += hover_drag(numbers) / numbers.mass * velocity.T
    up = np.minimum(result[2], CLIMBING * greatest_climb(numbers))
    up = result[2] = np.maximum(up, -numbers.sinking)
    across = np.sqrt(result[0] * result[0] + result[1] * result[1])
    most = np.tan(numbers.tilt_max) * (GRAVITY + up)
    result[:2] *= most / np.maximum(across, most)
    return result.T


def attitude_of(acceleration, heading):
    """Return the attitudes (m, 4) whose thrust gives ``acceleration`` (m, 3) at ``heading`` (m,) [rad].

    Turned by the heading, then nose down by ``pitch``, then over to the right by ``roll``: the body's x
    axis, seen from above, points along the heading whatever the tilt.
    """
    cos, sin = cos_sin(heading)
    ax, ay, up = acceleration[:, 0], acceleration[:, 1], acceleration[:, 2] + GRAVITY
    ahead, left = cos * ax + sin * ay, cos * ay - sin * ax
    pitch = np.arctan2(ahead, up)
    roll = np.arctan2(-left, np.sqrt(ahead * ahead + up * up))
    (c, s), (cp, sp), (cr, sr) = (cos_sin(0.5 * angle) for angle in (heading, pitch, roll))
    result = np.empty((4, len(ax)))
    result[0] = c * cp * sr - s * sp * cr
    result[1] = c * sp * cr + s * cp * sr
    result[2] = s * cp * cr - c * sp * sr
    result[3] = c * cp * cr + s * sp * sr
    return result.T


def turn_to(attitude, wanted):
    """Return the turns (m, 3) [rad, for small ones] from ``attitude`` to ``wanted``, both (m, 4).

    Twice the vector part of the quaternion between them, the shorter way round; body frame.
    """
    x, y, z, w = attitude.T
    a, b, c, d = wanted.T
    result = np.empty((3, len(x)))
    result[0] = w * a - d * x - (y * c - z * b)
    result[1] = w * b - d * y - (z * a - x * c)
    result[2] = w * c - d * z - (x * b - y * a)
    result *= np.where((attitude * wanted).T.sum(axis=0) < 0.0, -2.0, 2.0)
    return result.T


def rotor_speeds(flight, forces, acceleration, attitude, turning, numbers):
    """Return the commanded rotor speeds (m, 4) [rad/s] in the state ``flight``.

    ``forces``: what is ``Acting``; ``acceleration`` (m, 3) wanted; ``attitude`` (m, 4) wanted, which
    changes by ``turning`` (m,) [rad/s] about the vertical.
    """
    wanted = parts(numbers.attitude_gain) * turn_to(flight.attitude, attitude).T
    wanted[2] += turning * forces.axis[:, 2]
    change = parts(numbers.rate_gain) * (wanted - flight.rates.T)
    change -= parts(numbers.rate_damping) * forces.change.T
    most = parts(numbers.turning_max)
    change = np.minimum(np.maximum(change, -most), most)
    wrench = np.empty((4, len(turning)))
    np.add(parts(numbers.inertia) * change, forces.gyroscopic.T, out=wrench[1:])
    # Only what lies along the rotors' axis can be had at once.
    along = (acceleration * forces.axis).T.sum(axis=0) + GRAVITY * forces.axis[:, 2]
    wrench[0] = numbers.mass * np.maximum(along, 0.0)
    return speeds_of(wrench.T, numbers)
