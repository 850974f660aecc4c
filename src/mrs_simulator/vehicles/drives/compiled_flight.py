"""Steps of quadrotors with forces by loops that numba compiles, robot by robot.

With results equal to the bit: they do numpy's operations of ``flight``, ``rotors``, ``flight_control``,
``quadrotor`` and ``quadrotor_forces`` in numpy's order.  Sines, arc tangents and exponentials, which differ
in their last bits, are numpy's, of all robots at once.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.vehicles.drives.flight import Flight
from mrs_simulator.vehicles.drives.flight_control import CLIMBING
from mrs_simulator.vehicles.drives.rotors import (
    GRAVITY,
    ROTORS,
    greatest_climb,
    hover_drag,
    parts,
    remaining_share,
)

# Rows of the table of parameters.
INERTIA, EFFECT, SPLIT, DRAG, ATTITUDE, RATE, DAMPING, MOST = 0, 3, 7, 11, 14, 17, 20, 23
MASS, LEAST_SQUARE, MOST_SQUARE, LEFT = 26, 27, 28, 29
GAIN, STILL_DRAG, CLIMB, SINK, TILT = 30, 33, 36, 37, 38
TABLES = 16  # [-] of parameters that are kept


class Loops(NamedTuple):
    """The loops that ``quadrotor_forces`` calls, compiled or not."""

    limit: Any
    hold: Any
    aim: Any
    fly: Any
    settle: Any


def limit(command, top, place, limited):
    """Fill ``limited`` (4, m) with ``command`` (4, m) as ``possible`` has it; return how many robots stay.

    ``top`` (4, m): the limits; ``place`` (3, m) [m].
    """
    stay = 0
    for i in range(command.shape[1]):
        share = max(abs(command[0, i]) / top[0, i], abs(command[1, i]) / top[1, i])
        share = max(max(share, abs(command[2, i]) / top[2, i]), 1.0)
        for k in range(3):
            limited[k, i] = command[k, i] / share
        limited[3, i] = min(max(command[3, i], -top[3, i]), top[3, i])
        stay += place[2, i] <= 0.0 and limited[2, i] <= 0.0
    return stay


def hold(limited, top, cos, sin, place, held, against, gains, keeps, wanted):
    """Fill ``wanted`` (3, m) [m/s] as ``level`` and ``_keep_place``, ``keeps`` (3, m), ``against`` (2, m).

    ``cos``, ``sin`` (m,) of the headings; ``place``, ``held`` (3, m) [m]; ``gains``: ``PLACE_GAIN``,
    ``LEARNING`` times the step, and ``STRONGEST``.
    """
    place_gain, learning, strongest = gains
    for i in range(limited.shape[1]):
        x, y = limited[0, i], limited[1, i]
        wanted[0, i], wanted[1, i] = cos[i] * x - sin[i] * y, sin[i] * x + cos[i] * y
        wanted[2, i] = limited[2, i]
        flies = place[2, i] > 0.0
        keeps[0, i] = keeps[1, i] = x == 0.0 and y == 0.0 and flies
        keeps[2, i] = limited[2, i] == 0.0
        for k in range(3):
            away = held[k, i] - place[k, i] if keeps[k, i] else 0.0
            back = place_gain * away
            if k < 2:
                drift = against[k, i] + learning * away
                against[k, i] = min(max(drift, -strongest), strongest)
                back += against[k, i]
            if keeps[k, i]:
                wanted[k, i] = min(max(back, -top[k, i]), top[k, i])
            if k < 2 and not flies:
                wanted[k, i] = 0.0


def aim(table, velocity, wanted, cos, sin, acceleration, tilt):
    """Fill ``acceleration`` (3, m) as ``wanted_acceleration``, and of the tilts of ``attitude_of`` what the
    arc tangents are taken of: ``tilt`` (4, m), upper parts of pitch and roll, and lower ones.

    ``velocity``, ``wanted`` (3, m) [m/s]; ``cos``, ``sin`` (m,) of the headings.
    """
    for i in range(len(cos)):
        for k in range(3):
            acceleration[k, i] = table[GAIN + k, i] * (wanted[k, i] - velocity[k, i])
            acceleration[k, i] += table[STILL_DRAG + k, i] * velocity[k, i]
        up = max(min(acceleration[2, i], table[CLIMB, i]), table[SINK, i])
        x, y = acceleration[0, i], acceleration[1, i]
        most = table[TILT, i] * (GRAVITY + up)
        share = most / max(math.sqrt(x * x + y * y), most)
        x, y = x * share, y * share
        acceleration[0, i], acceleration[1, i], acceleration[2, i] = x, y, up
        ahead, left, up = cos[i] * x + sin[i] * y, cos[i] * y - sin[i] * x, up + GRAVITY
        tilt[0, i], tilt[1, i] = ahead, -left
        tilt[2, i], tilt[3, i] = up, math.sqrt(ahead * ahead + up * up)


def fly(count, step, table, place, velocity, attitude, rates, rotors, wanted, halves, turning, air):
    """Move m robots by ``count`` substeps of ``step`` [s], in place, as ``moved`` does.

    ``table`` (39, m); ``place``, ``velocity``, ``rates`` (3, m), ``attitude`` and ``rotors`` (4, m): their
    ``Flight``; ``wanted`` (3, m) [m/s^2]: the acceleration; ``halves``: cosines and sines (m,) of half of
    heading, pitch and roll at which they aim; ``turning`` (m,) [rad/s]; ``air`` (3, m) [m/s].
    """
    aimed = np.empty((4, len(turning)))
    aim_at(halves, aimed)
    axis, gyroscopic, change, speeds = np.empty(3), np.empty(3), np.empty(3), np.empty(4)
    for i in range(len(turning)):
        for _ in range(count):
            thrust = act(table, i, attitude, rates, rotors, axis, gyroscopic, change)
            command(
                table, i, attitude, rates, wanted, aimed, turning, axis, gyroscopic, change, speeds
            )
            advance(table, i, step, place, velocity, rotors, air, thrust, axis)
            for k in range(3):
                rates[k, i] = rates[k, i] + step * change[k]
            turn(i, step, attitude, rates)
            for k in range(4):
                rotors[k, i] = speeds[k] + table[LEFT, i] * (rotors[k, i] - speeds[k])
            if place[2, i] <= 0.0:
                place[2, i], velocity[2, i] = 0.0, max(velocity[2, i], 0.0)


def aim_at(halves, aimed):
    """Fill ``aimed`` (4, m) with the attitudes that ``attitude_of`` returns, of what ``fly`` is given."""
    c, s, cp, sp, cr, sr = halves
    for i in range(len(c)):
        aimed[0, i] = c[i] * cp[i] * sr[i] - s[i] * sp[i] * cr[i]
        aimed[1, i] = c[i] * sp[i] * cr[i] + s[i] * cp[i] * sr[i]
        aimed[2, i] = s[i] * cp[i] * cr[i] - c[i] * sp[i] * sr[i]
        aimed[3, i] = c[i] * cp[i] * cr[i] + s[i] * sp[i] * sr[i]


def act(table, i, attitude, rates, rotors, axis, gyroscopic, change):
    """Return the thrust [N] of robot ``i``, and fill what else is ``Acting`` on it, (3,) each."""
    s0, s1 = rotors[0, i] * rotors[0, i], rotors[1, i] * rotors[1, i]
    s2, s3 = rotors[2, i] * rotors[2, i], rotors[3, i] * rotors[3, i]
    right, left, first, second = s0 + s1, s2 + s3, s0 - s1, s2 - s3
    x, y, z, w = attitude[0, i], attitude[1, i], attitude[2, i], attitude[3, i]
    axis[0], axis[1], axis[2] = x * z + w * y, y * z - w * x, 0.5 - x * x - y * y
    change[0], change[1], change[2] = left - right, second - first, second + first
    for k in range(3):
        axis[k] += axis[k]
        n, a = (k + 1) % 3, (k + 2) % 3
        later = rates[n, i] * (table[INERTIA + a, i] * rates[a, i])
        gyroscopic[k] = later - rates[a, i] * (table[INERTIA + n, i] * rates[n, i])
        torque = change[k] * table[EFFECT + 1 + k, i]
        change[k] = (torque - gyroscopic[k]) / table[INERTIA + k, i]
    return (left + right) * table[EFFECT, i]


def command(table, i, attitude, rates, wanted, aim, turning, axis, gyroscopic, change, speeds):
    """Fill ``speeds`` (4,) [rad/s], the commanded rotor speeds of robot ``i``, as ``rotor_speeds``."""
    x, y, z, w = attitude[0, i], attitude[1, i], attitude[2, i], attitude[3, i]
    a, b, c, d = aim[0, i], aim[1, i], aim[2, i], aim[3, i]
    t0 = w * a - d * x - (y * c - z * b)
    t1 = w * b - d * y - (z * a - x * c)
    t2 = w * c - d * z - (x * b - y * a)
    side = -2.0 if x * a + y * b + z * c + w * d < 0.0 else 2.0
    r0 = table[ATTITUDE, i] * (t0 * side)
    r1 = table[ATTITUDE + 1, i] * (t1 * side)
    r2 = table[ATTITUDE + 2, i] * (t2 * side) + turning[i] * axis[2]
    speeds[1], speeds[2], speeds[3] = r0, r1, r2
    for k in range(3):
        quicker = table[RATE + k, i] * (speeds[k + 1] - rates[k, i])
        quicker -= table[DAMPING + k, i] * change[k]
        quicker = min(max(quicker, -table[MOST + k, i]), table[MOST + k, i])
        speeds[k + 1] = table[INERTIA + k, i] * quicker + gyroscopic[k]
    along = wanted[0, i] * axis[0] + wanted[1, i] * axis[1] + wanted[2, i] * axis[2]
    speeds[0] = table[MASS, i] * max(along + GRAVITY * axis[2], 0.0)
    for k in range(4):
        speeds[k] /= table[SPLIT + k, i]
    right, left = speeds[0] - speeds[1], speeds[0] + speeds[1]
    first, second = speeds[3] - speeds[2], speeds[3] + speeds[2]
    s0, s1, s2, s3 = right + first, right - first, left + second, left - second
    least, most = table[LEAST_SQUARE, i], table[MOST_SQUARE, i]
    lift = max(least - min(min(s0, s1), min(s2, s3)), 0.0)
    lift -= max(max(max(s0, s1), max(s2, s3)) + lift - most, 0.0)
    speeds[0], speeds[1] = s0 + lift, s1 + lift
    speeds[2], speeds[3] = s2 + lift, s3 + lift
    for k in range(4):
        speeds[k] = math.sqrt(min(max(speeds[k], least), most))


def advance(table, i, step, place, velocity, rotors, air, thrust, axis):
    """Move robot ``i`` by a substep under ``thrust`` [N] along ``axis`` (3,), in place, as ``advanced``."""
    total = -(rotors[0, i] + rotors[1, i] + rotors[2, i] + rotors[3, i])
    vx, vy, vz = velocity[0, i] - air[0, i], velocity[1, i] - air[1, i], velocity[2, i] - air[2, i]
    side = table[DRAG, i]
    along = (table[DRAG + 2, i] - side) * (vx * axis[0] + vy * axis[1] + vz * axis[2])
    share = step / table[MASS, i]
    velocity[0, i] += share * (total * (side * vx + along * axis[0]) + thrust * axis[0])
    velocity[1, i] += share * (total * (side * vy + along * axis[1]) + thrust * axis[1])
    velocity[2, i] += share * (total * (side * vz + along * axis[2]) + thrust * axis[2])
    velocity[2, i] -= step * GRAVITY
    for k in range(3):
        place[k, i] += step * velocity[k, i]


def turn(i, step, attitude, rates):
    """Turn the ``attitude`` of robot ``i`` by a substep of its ``rates``, in place, as ``turned``."""
    x, y, z, w = attitude[0, i], attitude[1, i], attitude[2, i], attitude[3, i]
    half = 0.5 * step
    p, q, r = half * rates[0, i], half * rates[1, i], half * rates[2, i]
    a, b = w * p + y * r - z * q + x, w * q + z * p - x * r + y
    c, d = w * r + x * q - y * p + z, -(x * p + y * q + z * r) + w
    size = math.sqrt(a * a + b * b + c * c + d * d)
    attitude[0, i], attitude[1, i] = a / size, b / size
    attitude[2, i], attitude[3, i] = c / size, d / size


def settle(table, place, velocity, attitude, keeps, held, after):
    """Fill ``after`` (3, m) with the places that robots hold from now on; return how many are upside down.

    ``keeps`` (3, m) bool: those that stay ``held`` (3, m) [m]; the others come to rest.
    """
    over = 0
    for i in range(place.shape[1]):
        for k in range(3):
            coming = place[k, i] + velocity[k, i] / table[GAIN + k, i]
            after[k, i] = held[k, i] if keeps[k, i] else coming
        x, y = attitude[0, i], attitude[1, i]
        over += 1.0 - 2.0 * (x * x + y * y) < 0.0
    return over


@functools.lru_cache(maxsize=None)
def compiled_loops():
    """Return the :class:`Loops`, compiled; ``ValueError`` without numba."""
    return Loops(*(linked(each, jit(cache=True)) for each in plain_loops()))


def plain_loops():
    """Return the :class:`Loops` as Python runs them, to be compared with."""
    return Loops(limit, hold, aim, fly, settle)


def moved_by(loops, plan, flight, wanted, heading, turning, air, numbers):
    """Return the ``Flight`` after a step by ``loops``, as ``quadrotor_forces.moved``.

    ``plan``: how many substeps of how many seconds, and after how many the velocity's controller works.
    """
    count, step, every = plan
    m, begins = len(flight.place), range(0, count, every)
    own = [np.array(each.T, order="C") for each in flight]
    wind = columns_of(air, (m, 3))
    wanted, turning = np.ascontiguousarray(wanted.T), np.ascontiguousarray(turning, dtype=float)
    table, acceleration, tilt = table_of(numbers, step, m), np.empty((3, m)), np.empty((4, m))
    angles = heading + np.multiply.outer(np.array(begins) * step, turning)
    cos, sin = cos_sin(np.concatenate([angles, 0.5 * angles]))
    for k, begin in enumerate(begins):
        loops.aim(table, own[1], wanted, cos[k], sin[k], acceleration, tilt)
        (cp, cr), (sp, sr) = cos_sin(0.5 * np.arctan2(tilt[:2], tilt[2:]))
        halves = cos[len(begins) + k], sin[len(begins) + k], cp, sp, cr, sr
        few = min(every, count - begin), step
        loops.fly(*few, table, *own, acceleration, halves, turning, wind)
    return Flight(*(each.T for each in own))


def columns_of(values, shape):
    """Return the columns, contiguous, of ``values`` that have the ``shape`` (m, k), or are to have it."""
    values = np.asarray(values, dtype=float)
    values = values if values.shape == shape else np.broadcast_to(values, shape)
    return np.ascontiguousarray(values.T)


_tables = {}  # by identity of the parameters, which are kept, too


def table_of(numbers, step, m):
    """Return the parameters ``numbers`` of m robots as ``fly`` takes them, (39, m)."""
    key = id(numbers), step, m
    if key not in _tables:
        if len(_tables) >= TABLES:
            _tables.clear()
        _tables[key] = numbers, _new_table(numbers, step, m)
    return _tables[key][1]


def _new_table(numbers, step, m):
    names = "attitude_gain", "rate_gain", "rate_damping", "turning_max"
    gains = [parts(getattr(numbers, name)) for name in names]
    effect = parts(numbers.effect)
    rows = [parts(numbers.inertia), effect, ROTORS * effect, parts(numbers.drag), *gains]
    singles = numbers.mass, numbers.speed_min**2, numbers.speed_max**2
    rows += _columns(*singles, remaining_share(numbers, step))
    rows += [parts(numbers.velocity_gain), hover_drag(numbers) / numbers.mass]
    rows += _columns(CLIMBING * greatest_climb(numbers), -numbers.sinking, np.tan(numbers.tilt_max))
    return np.concatenate([np.broadcast_to(each, (len(each), m)) for each in rows])


def _columns(*singles):
    return [np.reshape(each, (1, -1)) for each in singles]
