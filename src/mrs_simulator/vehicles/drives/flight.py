"""Rigid bodies in the air under four rotors: their state and its integration.

    p' = v,   m v' = thrust b - m g e + drag,   q' = q (w, 0)/2,   J w' = torque - w x J w,

p and v in the common frame, q the attitude, b the body's z axis in the common frame, e upwards, w the
rates in the body's frame, J diagonal.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.drives.rotors import GRAVITY, ROTORS, lagged_speeds, parts, wrench_of

NEXT, AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])  # axes after each, in turn


class Flight(NamedTuple):
    """The state of m robots, arrays in memory column by column."""

    place: np.ndarray  # (m, 3) [m] centre of mass, common frame
    velocity: np.ndarray  # (m, 3) [m/s], common frame
    attitude: np.ndarray  # (m, 4), unit quaternions x, y, z, w of the body's frame
    rates: np.ndarray  # (m, 3) [rad/s], body frame
    rotors: np.ndarray  # (m, 4) [rad/s]


class Acting(NamedTuple):
    """What acts on the bodies in a state."""

    thrust: np.ndarray  # (m,) [N]
    axis: np.ndarray  # (m, 3), the body's z axis in the common frame
    gyroscopic: np.ndarray  # (m, 3) [N m], w x J w
    change: np.ndarray  # (m, 3) [rad/s^2], w'


def at_rest(place, heading, speed=0.0):
    """Return the ``Flight`` of robots at ``place`` (m, 3) [m], upright at ``heading`` (m,) [rad].

    ``speed`` [rad/s] of all rotors: 0 for robots that stand.
    """
    place = np.array(place, dtype=float, order="F")
    m = len(place)
    attitude = np.zeros((m, 4), order="F")
    attitude[:, 3], attitude[:, 2] = cos_sin(0.5 * np.asarray(heading, dtype=float))
    rotors = np.zeros((m, ROTORS), order="F")
    rotors += np.reshape(speed, (-1, 1))
    return Flight(place, np.zeros((m, 3), order="F"), attitude, np.zeros((m, 3), order="F"), rotors)


def upward(attitude):
    """Return the body's z axis in the common frame, (m, 3)."""
    x, y, z, w = attitude.T
    result = np.empty((3, len(x)))
    np.add(x * z, w * y, out=result[0])
    np.subtract(y * z, w * x, out=result[1])
    np.subtract(0.5 - x * x, y * y, out=result[2])
    result += result
    return result.T


def upright_share(attitude):
    """Return how far up the body's z axis points, (m,) [-]: 1 upright, below 0 upside down."""
    x, y = attitude.T[:2]
    return 1.0 - 2.0 * (x * x + y * y)


def acting(flight, numbers):
    """Return what is ``Acting`` on robots in the state ``flight``."""
    wrench = wrench_of(flight.rotors, numbers).T
    rates = flight.rates.T
    inertia = parts(numbers.inertia)
    momentum = inertia * rates
    # An axis' part of w x J w: of the two after it.
    gyroscopic = rates[NEXT] * momentum[AFTER] - rates[AFTER] * momentum[NEXT]
    change = (wrench[1:] - gyroscopic) / inertia
    return Acting(wrench[0], upward(flight.attitude), gyroscopic.T, change.T)


def drag_of(velocity, axis, rotors, numbers):
    """Return the drag (m, 3) [N] at ``velocity`` (m, 3) through the air, common frame.

    ``axis`` (m, 3): the body's z axis; ``rotors`` (m, 4) [rad/s].
    """
    velocity, axis, factor = velocity.T, axis.T, parts(numbers.drag)
    total = -rotors.T.sum(axis=0)
    along = (factor[2] - factor[0]) * (velocity * axis).sum(axis=0)
    return (total * (factor[0] * velocity + along * axis)).T


def turned(attitude, rates, duration):
    """Return the attitudes (m, 4) after ``duration`` [s] of ``rates`` (m, 3) [rad/s], of unit length.

    Of first order and normalised: a turn by ``a = |w| duration`` errs by a^3/12.
    """
    x, y, z, w = attitude.T
    p, q, r = 0.5 * duration * rates.T
    result = np.empty((4, len(x)))
    result[0] = w * p + y * r - z * q
    result[1] = w * q + z * p - x * r
    result[2] = w * r + x * q - y * p
    result[3] = -(x * p + y * q + z * r)
    result += attitude.T
    result /= np.sqrt((result * result).sum(axis=0))
    return result.T


def advanced(flight, forces, wanted, air, numbers, duration):
    """Return the ``Flight`` after ``duration`` [s], a few ms, under rotor commands ``wanted`` (m, 4).

    ``forces``: what is ``Acting`` now; ``air`` (m, 3) [m/s]: the wind, or 0.0.  Symplectic Euler:
    velocities first, then places.
    """
    force = drag_of(flight.velocity - air, forces.axis, flight.rotors, numbers).T
    force += forces.thrust * forces.axis.T
    velocity = (flight.velocity.T + duration / numbers.mass * force).T
    velocity[:, 2] -= duration * GRAVITY
    rates = flight.rates + duration * forces.change
    return Flight(
        flight.place + duration * velocity,
        velocity,
        turned(flight.attitude, rates, duration),
        rates,
        lagged_speeds(flight.rotors, wanted, numbers, duration),
    )
