"""Quadrotors with forces moved over several steps by loops that numba compiles, the law included.

The numbers are those of ``quadrotor_forces`` but for sines, cosines and arc tangents, which are the C
library's: trajectories agree to rounding, as those of ``stretches`` do.  How many samples a stretch has
changes no bit.
"""

import math

import numpy as np

from mrs_simulator.core.compiled_terms import kept as kept_kernel
from mrs_simulator.core.kinematics import FASTEST
from mrs_simulator.vehicles.drives.compiled_flight import (
    aim,
    compiled_loops,
    fly,
    hold,
    limit,
    plain_loops,
    settle,
)
from mrs_simulator.world.motion.stretch_parts import copy, keep, saturate
from mrs_simulator.world.motion.stretches import DONE, FAR, NEAR, ODD, STALE

TURN = 2.0 * math.pi

term = None  # the law, compiled


def flight_stretch(plan, state, command, bounds, air, times, near, kept, scope, *given):
    """Move n quadrotors by several steps, in place; return ``(steps done, samples kept, room left, why it
    ended)``.

    ``plan``, ``kept`` (m, 7, n) and ``scope`` as of ``stretches.stretch``.  ``state``, of a
    ``QuadrotorState`` whose rotors all work: place, velocity (3, n), attitude (4, n), rates (3, n), rotors
    (4, n), ``against`` (2, n), ``held`` (3, n) and ``aim`` (1, n).  ``command`` (4, n); ``bounds``: its
    limits (4, n), the ``table`` of parameters, and the speeds (n,) from which on rotors are at their
    limits; ``air`` (3, n) [m/s].  ``times``: a step [s], its substeps, their length [s] and after how many
    the velocity's controller works, and ``PLACE_GAIN``, ``LEARNING`` and ``STRONGEST``.  ``near``: room
    and what else ``reached`` takes, and how many coordinates points have.  A step in which something is
    out of the ordinary (``NEAR``) is not made: contact, the ground, a rotor at its limit, a robot upside
    down, numbers that are not finite.
    """
    steps, until, every, ahead, between = plan
    top, (room, contact, dimension) = bounds[0], near
    place, attitude, n, filled = state[0], state[2], command.shape[1], 0
    pose, points, limited = np.empty((3, n)), np.empty((n, dimension)), np.empty((4, n))
    for count in range(1, steps + 1):
        why, room = stepped(state, command, bounds, air, times, room, contact, limited)
        if why != DONE:
            return count - 1, filled, room, why
        if count >= until and (count - until) % every == 0:
            place_all(place, attitude, pose, points)
            if not tell(term(points, *given), points.shape, pose[2], top, scope, limited, command):
                return count, filled, room, ODD
        if count >= ahead and (count - ahead) % between == 0:
            place_all(place, attitude, pose, points)
            if not keep(pose, command, kept[filled]):
                return count, filled, room, FAR
            filled += 1
    return steps, filled, room, DONE


def stepped(state, command, bounds, air, times, room, contact, limited):
    """Make a step; return ``DONE`` and the room left, or why it is not made, and the room there is.

    Arguments as of :func:`flight_stretch`; ``limited`` (4, n) is filled.
    """
    (top, table, fastest), step = bounds, times[0]
    place, held, heading, n = state[0], state[6], state[7], command.shape[1]
    before, after = np.empty((19, n)), np.empty((3, n))
    if limit(command, top, place, limited):
        return NEAR, room
    why = reached(place, state[1], state[2], step, room, contact)
    if why != DONE:
        return why, room
    store(state, before)
    over = flown(state, limited, top, table, air, times, after)
    if is_odd(over, state, fastest):
        restore(state, before)
        return NEAR, room
    for axis in range(3):
        copy(after[axis], held[axis])
    for i in range(n):
        heading[0, i] = wrapped(heading[0, i] + step * limited[3, i])
    return DONE, room - farthest(place, before)


def flown(state, limited, top, table, air, times, after):
    """Let robots fly for a step, as ``quadrotor_forces.flown``; return how many are upside down.

    Fills ``after`` (3, n) with the places that they hold from then on.
    """
    step, count, sub, every, gain, learning, strongest = times
    place, velocity, attitude, rates, rotors, against, held, heading = state
    n, turning = place.shape[1], limited[3]
    angle, cos, sin = np.empty(n), np.empty(n), np.empty(n)
    wanted, keeps = np.empty((3, n)), np.empty((3, n), dtype=np.bool_)
    acceleration, tilt, halves = np.empty((3, n)), np.empty((4, n)), np.empty((6, n))
    for i in range(n):
        angle[i] = heading[0, i] + 0.5 * step * turning[i]
    rows = halves[0], halves[1], halves[2], halves[3], halves[4], halves[5]
    turned(angle, 1.0, cos, sin)
    gains = gain, learning * step, strongest
    hold(limited, top, cos, sin, place, held, against, gains, keeps, wanted)
    for begin in range(0, count, every):
        for i in range(n):
            angle[i] = heading[0, i] + begin * sub * turning[i]
        turned(angle, 1.0, cos, sin)
        aim(table, velocity, wanted, cos, sin, acceleration, tilt)
        turned(angle, 0.5, halves[0], halves[1])
        for pair in range(2):
            for i in range(n):
                cos[i] = math.atan2(tilt[pair, i], tilt[2 + pair, i])
            turned(cos, 0.5, halves[2 + 2 * pair], halves[3 + 2 * pair])
        few = min(every, count - begin)
        fly(
            few,
            sub,
            table,
            place,
            velocity,
            attitude,
            rates,
            rotors,
            acceleration,
            rows,
            turning,
            air,
        )
    return settle(table, place, velocity, attitude, keeps, held, after)


def turned(angle, share, cos, sin):
    """Fill ``cos`` and ``sin`` (n,) with those of a ``share`` of each ``angle`` (n,) [rad]."""
    for i in range(len(angle)):
        cos[i], sin[i] = math.cos(share * angle[i]), math.sin(share * angle[i])


def wrapped(angle):
    """Return an ``angle`` [rad] as ``core.kinematics.wrap_angle`` does."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % TURN - math.pi


def reached(place, velocity, attitude, step, room, contact):
    """Return ``DONE`` where no robot may touch anything in a ``step`` [s], as ``FlightContacts`` has it.

    ``NEAR`` where one may touch the ground, ``STALE`` where ``room`` [m] is to be measured anew: how far
    robots may move before bodies touch each other or obstacles.  ``contact``: reach and half of the height
    (n,) [m] of bodies, and ``MARGIN``, ``LEVEL`` and ``HARD``.
    """
    (reach, half), margin, level, hard = contact[:2], contact[2], contact[3], contact[4]
    greatest, low = 0.0, False
    for i in range(len(reach)):
        x, y, z = velocity[0, i], velocity[1, i], velocity[2, i]
        speed = math.sqrt(x * x + y * y + z * z)
        greatest = max(greatest, speed)
        if place[2, i] + half[i] < reach[i] + margin + step * speed:
            x, y = attitude[0, i], attitude[1, i]
            low |= 1.0 - 2.0 * (x * x + y * y) < level or z < -hard
    if low:
        return NEAR
    return DONE if room > margin + step * greatest else STALE


def store(state, before):
    """Put what ``flown`` changes of ``state`` into ``before`` (19, n)."""
    at = 0
    for part in range(6):
        for axis in range(len(state[part])):
            copy(state[part][axis], before[at])
            at += 1


def restore(state, before):
    """Undo what ``flown`` did."""
    at = 0
    for part in range(6):
        for axis in range(len(state[part])):
            copy(before[at], state[part][axis])
            at += 1


def is_odd(over, state, fastest):
    """Return whether robots are upside down, ``over`` of them, rotors at their limits or states not
    finite."""
    total, rotors, at_limit = 0.0, state[4], False
    for part in range(7):
        for axis in range(len(state[part])):
            for i in range(len(fastest)):
                total += state[part][axis, i]
    for axis in range(4):
        for i in range(len(fastest)):
            at_limit |= rotors[axis, i] > fastest[i]
    return over > 0 or at_limit or not abs(total) < np.inf


def farthest(place, before):
    """Return how far [m] a robot has moved from ``before`` to ``place``, at most."""
    most = 0.0
    for i in range(place.shape[1]):
        x, y, z = place[0, i] - before[0, i], place[1, i] - before[1, i], place[2, i] - before[2, i]
        most = max(most, x * x + y * y + z * z)
    return math.sqrt(most)


def place_all(place, attitude, pose, points):
    """Fill ``pose`` (3, n), with the headings, and ``points`` (n, d), the centres."""
    for i in range(len(points)):
        x, y, z, w = attitude[0, i], attitude[1, i], attitude[2, i], attitude[3, i]
        pose[0, i], pose[1, i] = place[0, i], place[1, i]
        pose[2, i] = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        for axis in range(points.shape[1]):
            points[i, axis] = place[axis, i]


def tell(u, shape, heading, top, scope, wanted, command):
    """Let points have the velocities ``u`` at ``heading`` (n,) by ``command`` (4, n), within its limits.

    Return whether robots can follow, and ``u`` has the ``shape`` (n, d); else no command is given.
    ``top`` (4, n); ``wanted`` (4, n) is filled.
    """
    odd, excess = 0, np.ones(len(heading))
    if u.shape != shape:
        return False
    for i in range(len(heading)):
        cos, sin = math.cos(heading[i]), math.sin(heading[i])
        wanted[0, i] = cos * u[i, 0] + sin * u[i, 1]
        wanted[1, i] = cos * u[i, 1] - sin * u[i, 0]
        wanted[2, i] = u[i, 2] if shape[1] == 3 else 0.0
        wanted[3, i] = 0.0
        for axis in range(3):  # nor is nan
            odd |= not abs(wanted[axis, i]) <= FASTEST
            excess[i] = max(abs(wanted[axis, i]) / top[axis, i], excess[i])
    if odd:
        return False
    saturate(wanted[:2], excess, scope, command[:2])
    saturate(wanted[2:], excess, scope, command[2:])
    return True


def kernels():
    """Return what these functions, which depend on no law, have been compiled to, by them."""
    made = dict(zip(plain_loops(), compiled_loops()))
    return {**made, **{each: kept_kernel(each, made) for each in (stepped, place_all, tell, keep)}}
