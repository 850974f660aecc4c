"""Dynamics of vessels: inner state, controllers, thrusters, hull, wind and waves.

Speed controllers as real boats carry them, of the error e of u and of r each,

    force = k_f wanted + k_p e + k_i int e dt + k_d e',

e' of the measured velocity, behind a first-order filter of ``FILTER``; the integral waits while the
thrusters saturate.  ``numbers`` are those of ``vessel``.
"""

import functools
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.drives import hydrodynamics, thrusters
from mrs_simulator.vehicles.drives.rotors import parts

FILTER = 0.1  # [s] time constant of measured accelerations
SHORT = 1e-6  # [N, N m] beyond rounding by which thrusters saturate
SUBSTEP = 0.02  # [s] at most


class VesselState(NamedTuple):
    """The inner state of m vessels, arrays in memory column by column."""

    velocity: np.ndarray  # (m, 3) [m/s, m/s, rad/s] through the water, body frame
    command: np.ndarray  # (m, 2) of the thrusters, in force
    integral: np.ndarray  # (m, 2) [m, rad] of the errors of u and r
    slope: np.ndarray  # (m, 2) [m/s^2, rad/s^2] of u and r, filtered


def begin(m):
    """Return the ``VesselState`` of m vessels at rest in the water."""
    return VesselState(*(np.zeros((m, width), order="F") for width in (3, 2, 2, 2)))


def _gain(numbers, index):
    """Return the gains ``index`` of u and r, (2, 1) or (2, m)."""
    if isinstance(numbers.gains, tuple):
        return _columns(numbers.gains)[index]
    return numbers.gains[:, :, index].T


@functools.lru_cache(maxsize=None)
def _columns(gains):
    return np.array(gains).T.reshape(len(gains[0]), -1, 1)


def responses(numbers):
    """Return the time constants [s] of u and r under their controllers, (2, 1) or (2, m)."""
    inertia, linear = parts(numbers.inertia)[[0, 2]], parts(numbers.linear)[[0, 2]]
    return (inertia + _gain(numbers, 3)) / (linear + _gain(numbers, 1))


def thruster_commands(vessel, wanted, numbers, efforts=None):
    """Return the thruster commands (m, 2) of the controllers for ``wanted`` (m, 2) u and r, and where,
    (2, m) bool, thrusters saturate.

    ``efforts`` (m, 4): direct commands of the left and right thruster, force ahead [N] and torque [N m],
    that replace the controllers' output, nan where they do not; None: nowhere.
    """
    error = (wanted - vessel.velocity[:, ::2]).T
    effort = _gain(numbers, 0) * wanted.T + _gain(numbers, 1) * error
    effort += _gain(numbers, 2) * vessel.integral.T - _gain(numbers, 3) * vessel.slope.T
    if efforts is not None:
        effort = np.where(np.isnan(efforts[:, 2:].T), effort, efforts[:, 2:].T)
    given = thrusters.allocated(effort[0], effort[1], numbers)
    left, right = given.T
    short = np.empty(effort.shape, dtype=bool)
    short[0] = np.abs(left + right - effort[0]) > SHORT
    short[1] = np.abs(numbers.arm * (right - left) - effort[1]) > SHORT
    command = thrusters.command_for(given, numbers)
    if efforts is not None:  # integrals wait where controllers do not act
        direct = ~np.isnan(efforts[:, :2])
        command = np.where(direct, efforts[:, :2], command)
        short |= ~np.isnan(efforts[:, 2:].T) | direct.any(axis=1)
    return command, short


def thrust_force(vessel, numbers):
    """Return the thrusters' force (m, 3) [N, N, N m] on the body."""
    left, right = thrusters.thrust(vessel.command, numbers).T
    result = np.zeros((3, len(left)))
    result[0], result[2] = left + right, numbers.arm * (right - left)
    return result.T


def advanced(vessel, force, numbers, duration, wanted, efforts=None):
    """Return the ``VesselState`` after ``duration`` [s], at most ``SUBSTEP``, and the mean velocity (m, 3).

    ``force`` (m, 3) [N, N, N m]: of wind and waves; ``wanted`` (m, 2): u and r for the controllers;
    ``efforts`` as of :func:`thruster_commands`.
    """
    command, short = thruster_commands(vessel, wanted, numbers, efforts)
    error = wanted - vessel.velocity[:, ::2]
    integral = vessel.integral + duration * np.where(short.T, 0.0, error)
    vessel = vessel._replace(
        command=thrusters.after_lag(vessel.command, command, numbers, duration)
    )
    total = force + thrust_force(vessel, numbers)
    velocity = hydrodynamics.moved(vessel.velocity, total, numbers, duration)
    slope = (velocity - vessel.velocity)[:, ::2] / duration
    share = np.exp(-duration / FILTER)
    after = vessel._replace(
        velocity=velocity, integral=integral, slope=slope + share * (vessel.slope - slope)
    )
    return after, 0.5 * (velocity + vessel.velocity)


def moved_with_forces(pose, vessel, wanted, numbers, disturbances, step, efforts=None):
    """Return poses (m, 3) and states after ``step`` [s] with forces, towards u and r ``wanted`` (m, 2).

    ``disturbances``: the ``Disturbances`` of these robots; ``efforts`` as of :func:`thruster_commands`.
    """
    count = max(1, int(np.ceil(step / SUBSTEP - 1e-9)))
    waves = wave_force(disturbances.waves, numbers)
    for _ in range(count):
        turn = cos_sin(pose[:, 2])
        ground = hydrodynamics.over_ground(vessel.velocity, pose[:, 2], disturbances.current, turn)
        air = hydrodynamics.into_body(disturbances.wind, pose[:, 2], turn) - ground[:, :2]
        force = hydrodynamics.wind_force(air, numbers) + waves
        vessel, mean = advanced(vessel, force, numbers, step / count, wanted, efforts)
        pose = hydrodynamics.drifted(pose, mean, disturbances.current, step / count)
    return pose, vessel


def axis_velocity(vessel):
    """Return u and r (m, 2) of the inner state."""
    return vessel.velocity[:, [0, 2]]


def twist_of(vessel):
    """Return the body twists (m, 3) through the water: vx, vy [m/s], omega [rad/s]."""
    return vessel.velocity


def stopped(vessel, pushed, moved):
    """Return the state of robots, ``pushed`` (m,) bool of which moved by ``moved`` (k, 2) in contacts.

    [m/s] through the water, in the body's frame: no faster than they went, nor the other way.
    """
    velocity = vessel.velocity.copy(order="F")
    own = velocity[pushed, :2]
    velocity[pushed, :2] = np.sign(own) * np.clip(np.sign(own) * moved, 0.0, np.abs(own))
    return vessel._replace(velocity=velocity)


def wave_force(waves, numbers):
    """Return the force (m, 3) [N, N, N m] of ``waves`` (m, 2) [m], aside and about the vertical."""
    aside, turn = parts(numbers.waves)
    result = np.zeros((3, len(waves)))
    result[1], result[2] = aside * waves[:, 0], turn * waves[:, 1]
    return result.T
