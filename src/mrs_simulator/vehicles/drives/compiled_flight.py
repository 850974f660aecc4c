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
    m = len(turning)
    aimed, axis, gyroscopic, change = (
        np.empty((4, m)),
        np.empty((3, m)),
        np.empty((3, m)),
        np.empty((3, m)),
    )
    speeds, thrust, spare = np.empty((4, m)), np.empty(m), np.empty((8, m))
    aim_at(halves, aimed)
    for _ in range(count):
        act(table, attitude, rates, rotors, thrust, axis, gyroscopic, change, spare)
        command(table, attitude, rates, aimed, turning, axis, gyroscopic, change, speeds, spare)
        lift(table, wanted, axis, speeds, spare)
        advance(table, step, place, velocity, rotors, air, thrust, axis, spare)
        turn(step, attitude, rates, change, spare)
        for k in range(4):
            lag(rotors[k], speeds[k], table[LEFT])
        for i in range(m):
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


# The loops below are short, of few arrays each, so that they use the processor's vectors.


def act(table, attitude, rates, rotors, thrust, axis, gyroscopic, change, spare):
    """Fill ``thrust`` (m,) [N], and what else is ``Acting`` on robots, (3, m) each."""
    x, y, z, w = rows_of(attitude)
    m, total = len(thrust), table[EFFECT]
    for k in range(4):
        times(rotors[k], rotors[k], spare[k])
    s0, s1, s2, s3 = rows_of(spare)
    for i in range(m):
        thrust[i] = ((s2[i] + s3[i]) + (s0[i] + s1[i])) * total[i]
    right, ahead, about = change[0], change[1], change[2]
    for i in range(m):
        right[i] = (s2[i] + s3[i]) - (s0[i] + s1[i])
    for i in range(m):
        ahead[i] = (s2[i] - s3[i]) - (s0[i] - s1[i])
    for i in range(m):
        about[i] = (s2[i] - s3[i]) + (s0[i] - s1[i])
    east, north, up = axis[0], axis[1], axis[2]
    for i in range(m):
        east[i] = x[i] * z[i] + w[i] * y[i]
    for i in range(m):
        north[i] = y[i] * z[i] - w[i] * x[i]
    for i in range(m):
        up[i] = 0.5 - x[i] * x[i] - y[i] * y[i]
    for k in range(3):
        twice(axis[k])
        times(table[INERTIA + k], rates[k], spare[k])
    for k in range(3):
        n, a = (k + 1) % 3, (k + 2) % 3
        difference(rates[n], spare[a], rates[a], spare[n], gyroscopic[k])
        quicken(change[k], table[EFFECT + 1 + k], gyroscopic[k], table[INERTIA + k])


def rows_of(values):
    """Return the first four rows of ``values``."""
    return values[0], values[1], values[2], values[3]


def times(a, b, out):
    """Fill ``out`` (m,) with the products of ``a`` and ``b``."""
    for i in range(len(out)):
        out[i] = a[i] * b[i]


def twice(values):
    """Double ``values`` (m,), in place."""
    for i in range(len(values)):
        values[i] = values[i] + values[i]


def difference(a, b, c, d, out):
    """Fill ``out`` (m,) with ``a b - c d``."""
    for i in range(len(out)):
        out[i] = a[i] * b[i] - c[i] * d[i]


def quicken(change, effect, gyroscopic, inertia):
    """Make ``change`` (m,), squares of speeds, the angular acceleration [rad/s^2] about an axis."""
    for i in range(len(change)):
        change[i] = (change[i] * effect[i] - gyroscopic[i]) / inertia[i]


def lag(rotors, speeds, left):
    """Let the speeds of ``rotors`` (m,) follow ``speeds``, as ``lagged_speeds``, in place."""
    for i in range(len(rotors)):
        rotors[i] = speeds[i] + left[i] * (rotors[i] - speeds[i])


def command(table, attitude, rates, aimed, turning, axis, gyroscopic, change, speeds, spare):
    """Fill ``speeds[1:]`` with the torques (3, m) [N m] that ``rotor_speeds`` wants."""
    x, y, z, w = rows_of(attitude)
    a, b, c, d = rows_of(aimed)
    side, other, m = spare[0], spare[1], len(turning)
    for i in range(m):
        side[i] = x[i] * a[i] + y[i] * b[i]
    for i in range(m):
        side[i] = side[i] + z[i] * c[i] + w[i] * d[i]
    for i in range(m):
        side[i] = -2.0 if side[i] < 0.0 else 2.0
    difference(w, a, d, x, speeds[1])
    difference(y, c, z, b, other)
    less(speeds[1], other)
    difference(w, b, d, y, speeds[2])
    difference(z, a, x, c, other)
    less(speeds[2], other)
    difference(w, c, d, z, speeds[3])
    difference(x, b, y, a, other)
    less(speeds[3], other)
    for k in range(3):
        scale(speeds[k + 1], side, table[ATTITUDE + k])
    times(turning, axis[2], other)
    for i in range(m):
        speeds[3, i] = speeds[3, i] + other[i]
    for k in range(3):
        near(speeds[k + 1], rates[k], change[k], table[RATE + k], table[DAMPING + k])
        bound(speeds[k + 1], table[MOST + k], table[INERTIA + k], gyroscopic[k])


def less(values, others):
    """Subtract ``others`` (m,) from ``values``, in place."""
    for i in range(len(values)):
        values[i] = values[i] - others[i]


def scale(values, side, gain):
    """Make ``values`` (m,), half of turns on one ``side``, the rates wanted [rad/s], in place."""
    for i in range(len(values)):
        values[i] = gain[i] * (values[i] * side[i])


def near(wanted, rates, change, gain, damping):
    """Make the rates ``wanted`` (m,) the angular acceleration that brings ``rates`` near, in place."""
    for i in range(len(wanted)):
        wanted[i] = gain[i] * (wanted[i] - rates[i]) - damping[i] * change[i]


def bound(quicker, most, inertia, gyroscopic):
    """Make ``quicker`` (m,) [rad/s^2], at ``most`` as much, a torque [N m], in place."""
    for i in range(len(quicker)):
        quicker[i] = inertia[i] * min(max(quicker[i], -most[i]), most[i]) + gyroscopic[i]


def lift(table, wanted, axis, speeds, spare):
    """Make torques ``speeds[1:]``, and the thrust for ``wanted`` (3, m), rotor speeds, as ``speeds_of``."""
    t, x, y, z = rows_of(speeds)
    east, north, up, mass, m = axis[0], axis[1], axis[2], table[MASS], len(t)
    for i in range(m):
        t[i] = wanted[0, i] * east[i] + wanted[1, i] * north[i] + wanted[2, i] * up[i]
    for i in range(m):
        t[i] = mass[i] * max(t[i] + GRAVITY * up[i], 0.0)
    for k in range(4):
        divide(speeds[k], table[SPLIT + k])
    s0, s1, s2, s3 = rows_of(spare)
    for i in range(m):
        s0[i] = (t[i] - x[i]) + (z[i] - y[i])
    for i in range(m):
        s1[i] = (t[i] - x[i]) - (z[i] - y[i])
    for i in range(m):
        s2[i] = (t[i] + x[i]) + (z[i] + y[i])
    for i in range(m):
        s3[i] = (t[i] + x[i]) - (z[i] + y[i])
    least, most = table[LEAST_SQUARE], table[MOST_SQUARE]
    for i in range(m):
        t[i] = max(least[i] - min(min(s0[i], s1[i]), min(s2[i], s3[i])), 0.0)
    for i in range(m):
        highest = max(max(s0[i], s1[i]), max(s2[i], s3[i]))
        t[i] = t[i] - max(highest + t[i] - most[i], 0.0)
    for k in range(4):
        add(spare[k], t)
    for k in range(4):
        root(spare[k], least, most, speeds[k])


def add(values, others):
    """Add ``others`` (m,) to ``values``, in place."""
    for i in range(len(values)):
        values[i] = values[i] + others[i]


def divide(values, by):
    """Divide ``values`` (m,) ``by`` others, in place."""
    for i in range(len(values)):
        values[i] = values[i] / by[i]


def root(squares, least, most, speeds):
    """Fill ``speeds`` (m,) with the roots of ``squares`` between ``least`` and ``most``."""
    for i in range(len(squares)):
        speeds[i] = math.sqrt(min(max(squares[i], least[i]), most[i]))


def advance(table, step, place, velocity, rotors, air, thrust, axis, spare):
    """Move robots under ``thrust`` (m,) [N] along ``axis`` (3, m), in place, as ``advanced``."""
    r0, r1, r2, r3 = rows_of(rotors)
    vx, vy, vz, along = rows_of(spare)
    east, north, up, m = axis[0], axis[1], axis[2], len(thrust)
    total = spare[4]
    side, upright, mass = table[DRAG], table[DRAG + 2], table[MASS]
    for k in range(3):
        for i in range(m):
            spare[k, i] = velocity[k, i] - air[k, i]
    for i in range(m):
        along[i] = vx[i] * east[i] + vy[i] * north[i] + vz[i] * up[i]
    for i in range(m):
        along[i] = (upright[i] - side[i]) * along[i]
    for i in range(m):
        total[i] = -(r0[i] + r1[i] + r2[i] + r3[i])
    for k in range(3):
        drag(spare[k], side, along, axis[k], total)
        push(velocity[k], step, mass, spare[k], thrust, axis[k])
    for i in range(m):
        velocity[2, i] = velocity[2, i] - step * GRAVITY
    for k in range(3):
        go(place[k], step, velocity[k])


def drag(velocity, side, along, axis, total):
    """Make ``velocity`` (m,) through the air the drag [N], in place, as ``drag_of``."""
    for i in range(len(velocity)):
        velocity[i] = total[i] * (side[i] * velocity[i] + along[i] * axis[i])


def push(velocity, step, mass, force, thrust, axis):
    """Let ``force`` and ``thrust`` (m,) [N] change ``velocity`` [m/s] for a ``step`` [s], in place."""
    for i in range(len(velocity)):
        velocity[i] = velocity[i] + step / mass[i] * (force[i] + thrust[i] * axis[i])


def go(values, step, rate):
    """Let ``values`` (m,) change at ``rate`` for a ``step`` [s], in place."""
    for i in range(len(values)):
        values[i] = values[i] + step * rate[i]


def turn(step, attitude, rates, change, spare):
    """Turn robots by a substep of ``rates``, which ``change``, (3, m) both, in place, as ``turned``."""
    x, y, z, w = rows_of(attitude)
    p, q, r, size = rows_of(spare)
    half, m = 0.5 * step, rates.shape[1]
    after = spare[4:]
    for k in range(3):
        go(rates[k], step, change[k])
        for i in range(m):
            spare[k, i] = half * rates[k, i]
    a, b, c, d = rows_of(after)
    for i in range(m):
        a[i] = w[i] * p[i] + y[i] * r[i] - z[i] * q[i] + x[i]
    for i in range(m):
        b[i] = w[i] * q[i] + z[i] * p[i] - x[i] * r[i] + y[i]
    for i in range(m):
        c[i] = w[i] * r[i] + x[i] * q[i] - y[i] * p[i] + z[i]
    for i in range(m):
        d[i] = -(x[i] * p[i] + y[i] * q[i] + z[i] * r[i]) + w[i]
    for i in range(m):
        size[i] = math.sqrt(a[i] * a[i] + b[i] * b[i] + c[i] * c[i] + d[i] * d[i])
    for k in range(4):
        share(after[k], size, attitude[k])


def share(values, size, part):
    """Fill ``part`` (m,) with ``values`` over ``size``."""
    for i in range(len(values)):
        part[i] = values[i] / size[i]


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
