"""Substeps of quadrotors with forces by loops that numba compiles, robot by robot.

With results equal to the bit: they do numpy's operations of ``flight``, ``rotors`` and
``flight_control`` in numpy's order.  Sines, cosines and exponentials, which differ in their last bits, are
not among them.
"""

import functools
import math

import numpy as np

from mrs_simulator.core.compiled_terms import linked
from mrs_simulator.core.compiling import jit
from mrs_simulator.vehicles.drives.flight import Flight
from mrs_simulator.vehicles.drives.rotors import GRAVITY, ROTORS, parts, remaining_share

# Rows of the table of parameters.
INERTIA, EFFECT, SPLIT, DRAG, ATTITUDE, RATE, DAMPING, MOST = 0, 3, 7, 11, 14, 17, 20, 23
MASS, LEAST_SQUARE, MOST_SQUARE, LEFT = 26, 27, 28, 29
TABLES = 16  # [-] of parameters that are kept


def fly(count, step, table, place, velocity, attitude, rates, rotors, wanted, aim, turning, air):
    """Move m robots by ``count`` substeps of ``step`` [s], in place, as ``moved`` does.

    ``table`` (30, m); ``place``, ``velocity``, ``rates`` (3, m), ``attitude`` and ``rotors`` (4, m): their
    ``Flight``; ``wanted`` (3, m) [m/s^2] and ``aim`` (4, m): acceleration and attitude; ``turning`` (m,)
    [rad/s]; ``air`` (3, m) [m/s].
    """
    axis, gyroscopic, change, speeds = np.empty(3), np.empty(3), np.empty(3), np.empty(4)
    for i in range(len(turning)):
        for _ in range(count):
            thrust = act(table, i, attitude, rates, rotors, axis, gyroscopic, change)
            command(
                table, i, attitude, rates, wanted, aim, turning, axis, gyroscopic, change, speeds
            )
            advance(table, i, step, place, velocity, rotors, air, thrust, axis)
            for k in range(3):
                rates[k, i] = rates[k, i] + step * change[k]
            turn(i, step, attitude, rates)
            for k in range(4):
                rotors[k, i] = speeds[k] + table[LEFT, i] * (rotors[k, i] - speeds[k])
            if place[2, i] <= 0.0:
                place[2, i], velocity[2, i] = 0.0, max(velocity[2, i], 0.0)


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


@functools.lru_cache(maxsize=None)
def compiled_fly():
    """Return the compiled ``fly``; ``ValueError`` without numba."""
    return linked(fly, jit(cache=True))


def flown_by(loops, count, step, flight, acceleration, attitude, turning, air, numbers):
    """Return the ``Flight`` after ``count`` substeps of ``step`` [s] by ``loops``, a ``fly``.

    ``acceleration`` (m, 3), ``attitude`` (m, 4) and ``turning`` (m,) as of ``rotor_speeds``; ``air``
    (m, 3), (3,) or a number [m/s].
    """
    m = len(flight.place)
    own = [np.array(each.T, order="C") for each in flight]
    wanted = np.ascontiguousarray(acceleration.T), np.ascontiguousarray(attitude.T)
    wind = np.array(np.broadcast_to(air, (m, 3)).T, order="C")
    turning = np.ascontiguousarray(turning, dtype=float)
    loops(count, step, _table(numbers, step, m), *own, *wanted, turning, wind)
    return Flight(*(each.T for each in own))


_tables = {}  # by identity of the parameters, which are kept, too


def _table(numbers, step, m):
    """Return the parameters ``numbers`` of m robots as ``fly`` takes them, (30, m)."""
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
    singles += (remaining_share(numbers, step),)
    rows += [np.reshape(each, (1, -1)) for each in singles]
    return np.concatenate([np.broadcast_to(each, (len(each), m)) for each in rows])
