"""Quadrotors with forces: rigid bodies under four rotors and the controllers of ``flight_control``.

The functions ``begin``, ``flown``, ``state`` and ``stopped`` stand for those of ``quadrotor``, of the same
numbers and commands.  A robot that is not told to rise or sink holds its height.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.core.kinematics import wrap_angle
from mrs_simulator.core.spatial import headings
from mrs_simulator.vehicles.drives import quadrotor
from mrs_simulator.vehicles.drives.flight import Flight, acting, advanced, at_rest
from mrs_simulator.vehicles.drives.flight_control import (
    attitude_of,
    rotor_speeds,
    wanted_acceleration,
)
from mrs_simulator.vehicles.drives.rotors import hover_speed, parts, spun

SUBSTEP = 0.002  # [s] the longest
VELOCITY_EVERY = 5  # [-] substeps from one use of the velocity's controller to the next
HEIGHT_GAIN = 1.5  # [1/s] with which a height is held
STILL_AIR = np.zeros(3)  # [m/s]


class Airborne(NamedTuple):
    """The inner state of m robots."""

    flight: Flight
    aim: np.ndarray  # (m,) [rad], heading that the controllers aim at
    height: np.ndarray  # (m,) [m] that is held while no rising or sinking is asked for

    @property
    def place(self):
        """Return the places (m, 3) [m]."""
        return self.flight.place

    @property
    def velocity(self):
        """Return the velocities (m, 3) [m/s], common frame."""
        return self.flight.velocity


def begin(pose, z, numbers):
    """Return the inner state of robots that hover, or stand, at ``pose`` (m, 3) and ``z`` (m,) [m]."""
    place = np.column_stack([pose[:, :2], z])
    speed = np.where(np.asarray(z) > 0.0, hover_speed(numbers), 0.0)
    return Airborne(at_rest(place, pose[:, 2], speed), pose[:, 2].copy(), np.array(z, dtype=float))


def flown(inner, command, limits, numbers, step, air=STILL_AIR):
    """Return the inner state after ``step`` [s] under ``command`` (m, 4), with forces.

    ``air`` (m, 3) [m/s]: the wind.
    """
    told = quadrotor.possible(command, limits)
    z = inner.place[:, 2]
    stays = quadrotor.stays(z, told)
    told[stays] = 0.0
    wanted = quadrotor.level(told, inner.aim + 0.5 * step * told[:, 3])
    holding = told[:, 2] == 0.0
    # Where it will have come to rest, by the time constant of its climb.
    coming = z + inner.velocity[:, 2] / parts(numbers.velocity_gain)[2]
    height = np.where(holding & ~stays, inner.height, coming)
    most = limits.top[..., 2]
    back = np.minimum(np.maximum(HEIGHT_GAIN * (height - z), -most), most)
    wanted[:, 2] = np.where(holding, back, told[:, 2])
    wanted[z <= 0.0, :2] = 0.0  # straight up from the ground
    flight = moved(inner.flight, wanted, inner.aim, told[:, 3], air, numbers, step)
    if stays.any():
        flight = _resting(inner.flight, flight, stays, numbers, step)
    aim = wrap_angle(inner.aim + step * told[:, 3])
    return Airborne(flight, aim, height)


def _resting(before, after, stays, numbers, step):
    """Return ``after`` where robots that stay, (m,) bool, stand as ``before``, their rotors running out."""
    still = at_rest(before.place, headings(before.attitude))
    still = still._replace(rotors=spun(before.rotors, still.rotors, numbers, step))
    pick = stays[:, np.newaxis]
    return Flight(*(
        np.asfortranarray(np.where(pick, old, new)) for old, new in zip(still, after)
    ))  # fmt: skip


def moved(flight, wanted, heading, turning, air, numbers, duration):
    """Return the ``Flight`` after ``duration`` [s] towards ``wanted`` (m, 3) [m/s], common frame.

    ``heading`` (m,) [rad]: what attitudes aim at, which turns by ``turning`` (m,) [rad/s]; ``air`` (m, 3)
    [m/s]: the wind.  The velocity's controller works every few substeps, the others at each.
    """
    count = max(1, int(np.ceil(duration / SUBSTEP - 1e-9)))
    step = duration / count
    for index in range(count):
        if index % VELOCITY_EVERY == 0:
            acceleration = wanted_acceleration(flight.velocity, wanted, numbers)
            attitude = attitude_of(acceleration, heading + index * step * turning)
        forces = acting(flight, numbers)
        told = rotor_speeds(flight, forces, acceleration, attitude, turning, numbers)
        flight = advanced(flight, forces, told, air, numbers, step)
        if flight.place[:, 2].min() <= 0.0:
            _carry(flight)
    return flight


def _carry(flight):
    """Let the ground carry robots that would sink into it, in place."""
    down = flight.place[:, 2] <= 0.0
    flight.place[down, 2] = 0.0
    flight.velocity[down, 2] = np.maximum(flight.velocity[down, 2], 0.0)


def state(inner):
    """Return poses (m, 3), body twists (m, 3) in the plane, and ``Spatial`` of an inner state."""
    flight = inner.flight
    heading = headings(flight.attitude)
    return quadrotor.seen(flight.place, flight.velocity, heading, flight.attitude, flight.rates)


def stopped(inner, pushed, place, bound):
    """Return the inner state where contacts put robots, as ``quadrotor.stopped`` does."""
    return inner._replace(
        flight=inner.flight._replace(**quadrotor.put(inner, pushed, place, bound))
    )
