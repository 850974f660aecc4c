"""Steps of quadrotors with forces by loops that numba compiles, robot by robot.

With results equal to the bit: they do numpy's operations of ``flight``, ``rotors``, ``flight_control``,
``quadrotor`` and ``quadrotor_forces`` in numpy's order.  Sines, arc tangents and exponentials, which differ
in their last bits, are numpy's, of all robots at once.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.compiled_terms import kept
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

# Rows of the table of parameters: first those of a block, below, from ``JX`` on.
GAIN, STILL_DRAG, CLIMB, SINK, TILT = 30, 33, 36, 37, 38
TABLES = 16  # [-] of parameters that are kept
LANES = 8  # [-] robots that substeps move at once
# Rows of the block that holds them, one array: in several, which might overlap, loops along the lanes
# would not use the processor's vectors.
ROWS = 69
(
    PX, PY, PZ, VX, VY, VZ, QX, QY, QZ, QW, P, Q, R, N0, N1, N2, N3,  # of the ``Flight``
    AX, AY, AZ, TURNS, AIR_X, AIR_Y, AIR_Z, OF_X, OF_Y, OF_Z, OF_W,  # their commands, the wind
    THRUST, EAST, NORTH, UP, CX, CY, CZ, S0, S1, S2, S3,  # ``Acting``, speeds
    # Rows of the table before ``GAIN``.
    JX, JY, JZ, E0, E1, E2, E3, F0, F1, F2, F3, SIDE, _, LENGTHWISE, KX, KY, KZ,
    RX, RY, RZ, DX, DY, DZ, MX, MY, MZ, WEIGHS, LEAST, GREATEST, LAGS,
) = range(0, ROWS * LANES, LANES)  # fmt: skip


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
    m, b = len(turning), np.empty(ROWS * LANES)
    for first in range(0, m, LANES):
        put(place, first, b, PX)
        put(velocity, first, b, VX)
        put(attitude, first, b, QX)
        put(rates, first, b, P)
        put(rotors, first, b, N0)
        put(wanted, first, b, AX)
        put(air, first, b, AIR_X)
        put(table[:GAIN], first, b, JX)
        for lane in range(LANES):
            b[TURNS + lane] = turning[min(first + lane, m - 1)]
        aim_at(halves, first, b)
        for _ in range(count):
            steer(b)
            move(b, step)
        take(place, first, b, PX)
        take(velocity, first, b, VX)
        take(attitude, first, b, QX)
        take(rates, first, b, P)
        take(rotors, first, b, N0)


def put(values, first, b, row):
    """Put ``values`` (k, m) of the robots from ``first`` on into ``b`` from ``row`` on.

    Lanes that are left have the last robot.
    """
    k, m = values.shape
    for part in range(k):
        for lane in range(LANES):
            b[row + part * LANES + lane] = values[part, min(first + lane, m - 1)]


def take(values, first, b, row):
    """Undo ``put``."""
    k, m = values.shape
    for part in range(k):
        for lane in range(min(LANES, m - first)):
            values[part, first + lane] = b[row + part * LANES + lane]


def aim_at(halves, first, b):
    """Put the attitudes that ``attitude_of`` returns, of what ``fly`` is given, into ``b``."""
    c, s, cp, sp, cr, sr = halves
    for lane in range(LANES):
        i = min(first + lane, len(c) - 1)
        b[OF_X + lane] = c[i] * cp[i] * sr[i] - s[i] * sp[i] * cr[i]
        b[OF_Y + lane] = c[i] * sp[i] * cr[i] + s[i] * cp[i] * sr[i]
        b[OF_Z + lane] = s[i] * cp[i] * cr[i] - c[i] * sp[i] * sr[i]
        b[OF_W + lane] = c[i] * cp[i] * cr[i] + s[i] * sp[i] * sr[i]


def steer(b):
    """Put what is ``Acting`` on robots into ``b``, and the rotor speeds that ``rotor_speeds`` wants."""
    for i in range(LANES):
        x, y, z, w = b[QX + i], b[QY + i], b[QZ + i], b[QW + i]
        s0, s1 = b[N0 + i] * b[N0 + i], b[N1 + i] * b[N1 + i]
        s2, s3 = b[N2 + i] * b[N2 + i], b[N3 + i] * b[N3 + i]
        b[THRUST + i] = ((s2 + s3) + (s0 + s1)) * b[E0 + i]
        east, north, up = x * z + w * y, y * z - w * x, 0.5 - x * x - y * y
        east, north, up = east + east, north + north, up + up
        b[EAST + i], b[NORTH + i], b[UP + i] = east, north, up
        p, q, r = b[P + i], b[Q + i], b[R + i]
        jx, jy, jz = b[JX + i], b[JY + i], b[JZ + i]
        hx, hy, hz = jx * p, jy * q, jz * r
        gx, gy, gz = q * hz - r * hy, r * hx - p * hz, p * hy - q * hx
        cx = (((s2 + s3) - (s0 + s1)) * b[E1 + i] - gx) / jx
        cy = (((s2 - s3) - (s0 - s1)) * b[E2 + i] - gy) / jy
        cz = (((s2 - s3) + (s0 - s1)) * b[E3 + i] - gz) / jz
        b[CX + i], b[CY + i], b[CZ + i] = cx, cy, cz
        a, c, d, e = b[OF_X + i], b[OF_Y + i], b[OF_Z + i], b[OF_W + i]
        side = -2.0 if (x * a + y * c) + z * d + w * e < 0.0 else 2.0
        tx = b[KX + i] * (((w * a - e * x) - (y * d - z * c)) * side)
        ty = b[KY + i] * (((w * c - e * y) - (z * a - x * d)) * side)
        tz = b[KZ + i] * (((w * d - e * z) - (x * c - y * a)) * side)
        tz = tz + b[TURNS + i] * up
        tx = b[RX + i] * (tx - p) - b[DX + i] * cx
        ty = b[RY + i] * (ty - q) - b[DY + i] * cy
        tz = b[RZ + i] * (tz - r) - b[DZ + i] * cz
        tx = (jx * min(max(tx, -b[MX + i]), b[MX + i]) + gx) / b[F1 + i]
        ty = (jy * min(max(ty, -b[MY + i]), b[MY + i]) + gy) / b[F2 + i]
        tz = (jz * min(max(tz, -b[MZ + i]), b[MZ + i]) + gz) / b[F3 + i]
        t = b[AX + i] * east + b[AY + i] * north + b[AZ + i] * up
        t = b[WEIGHS + i] * max(t + GRAVITY * up, 0.0) / b[F0 + i]
        s0, s1 = (t - tx) + (tz - ty), (t - tx) - (tz - ty)
        s2, s3 = (t + tx) + (tz + ty), (t + tx) - (tz + ty)
        least, most = b[LEAST + i], b[GREATEST + i]
        t = max(least - min(min(s0, s1), min(s2, s3)), 0.0)
        t = t - max(max(max(s0, s1), max(s2, s3)) + t - most, 0.0)
        b[S0 + i] = math.sqrt(min(max(s0 + t, least), most))
        b[S1 + i] = math.sqrt(min(max(s1 + t, least), most))
        b[S2 + i] = math.sqrt(min(max(s2 + t, least), most))
        b[S3 + i] = math.sqrt(min(max(s3 + t, least), most))


def move(b, step):
    """Move the robots in ``b`` by a ``step`` [s] as ``advanced`` does."""
    half = 0.5 * step
    for i in range(LANES):
        east, north, up = b[EAST + i], b[NORTH + i], b[UP + i]
        x, y, z = b[VX + i] - b[AIR_X + i], b[VY + i] - b[AIR_Y + i], b[VZ + i] - b[AIR_Z + i]
        n0, n1, n2, n3, left = b[N0 + i], b[N1 + i], b[N2 + i], b[N3 + i], b[LAGS + i]
        total, thrust, side = -(n0 + n1 + n2 + n3), b[THRUST + i], b[SIDE + i]
        along = (b[LENGTHWISE + i] - side) * (x * east + y * north + z * up)
        share = step / b[WEIGHS + i]
        x = b[VX + i] + share * (total * (side * x + along * east) + thrust * east)
        y = b[VY + i] + share * (total * (side * y + along * north) + thrust * north)
        z = b[VZ + i] + share * (total * (side * z + along * up) + thrust * up)
        z = z - step * GRAVITY
        b[PX + i], b[PY + i] = b[PX + i] + step * x, b[PY + i] + step * y
        height = b[PZ + i] + step * z
        b[VX + i], b[VY + i], b[VZ + i] = x, y, max(z, 0.0) if height <= 0.0 else z
        b[PZ + i] = 0.0 if height <= 0.0 else height
        b[N0 + i] = b[S0 + i] + left * (n0 - b[S0 + i])
        b[N1 + i] = b[S1 + i] + left * (n1 - b[S1 + i])
        b[N2 + i] = b[S2 + i] + left * (n2 - b[S2 + i])
        b[N3 + i] = b[S3 + i] + left * (n3 - b[S3 + i])
        p, q = b[P + i] + step * b[CX + i], b[Q + i] + step * b[CY + i]
        r = b[R + i] + step * b[CZ + i]
        b[P + i], b[Q + i], b[R + i] = p, q, r
        p, q, r = half * p, half * q, half * r
        x, y, z, w = b[QX + i], b[QY + i], b[QZ + i], b[QW + i]
        a, c = w * p + y * r - z * q + x, w * q + z * p - x * r + y
        d, e = w * r + x * q - y * p + z, -(x * p + y * q + z * r) + w
        size = math.sqrt(a * a + c * c + d * d + e * e)
        b[QX + i], b[QY + i], b[QZ + i], b[QW + i] = a / size, c / size, d / size, e / size


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
    return Loops(*(kept(each) for each in plain_loops()))


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
