"""Quadrotors with forces: rigid bodies under four rotors and the controllers of ``flight_control``.

The functions ``begin``, ``flown``, ``state`` and ``stopped`` replace those of ``quadrotor``, for the same
parameters and commands.

A robot without a vertical velocity command holds its height, and one without a horizontal one its
place: its controllers' velocity set point is then

    v_wanted = k_p e + c,   c' = k_i e,   e = p_held - p,

with a horizontal ``c`` that cancels steady wind.  Under velocity commands wind makes an error of its drag
over the velocity's gain.

A lost rotor gives no thrust; the body moves under the other three.  Motors of a robot that turns upside
down are cut, as by the supervisors of real ones; without motors it falls and tumbles.
"""

from typing import NamedTuple, Optional

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import cos_sin, wrap_angle
from mrs_simulator.core.spatial import headings
from mrs_simulator.vehicles.drives import quadrotor
from mrs_simulator.vehicles.drives.compiled_flight import (
    columns_of,
    compiled_loops,
    moved_by,
    table_of,
)
from mrs_simulator.vehicles.drives.flight import Flight, acting, advanced, at_rest, upright_share
from mrs_simulator.vehicles.drives.flight_control import (
    attitude_of,
    rotor_speeds,
    wanted_acceleration,
)
from mrs_simulator.vehicles.drives.rotors import hover_speed, lagged_speeds, parts

SUBSTEP = 0.002  # [s] the longest
VELOCITY_EVERY = 5  # [-] substeps from one use of the velocity's controller to the next
PLACE_GAIN = 1.5  # [1/s] k_p, of place and height
LEARNING = 0.5  # [1/s^2] k_i, of a place in wind
STRONGEST = 1.0  # [m/s] greatest c, against windup where contacts hold a robot
STILL_AIR = np.zeros(3)  # [m/s]
WORTH = 600  # [-] steps that take numpy as long as numba takes to load
AT_LIMIT = 0.99  # [-] of a rotor's greatest speed, from which on it is at its limit


class QuadrotorState(NamedTuple):
    """The inner state of m robots."""

    flight: Flight
    aim: np.ndarray  # (m,) [rad], heading that the controllers aim at
    # (m, 3) [m], the place held while no horizontal, or vertical, velocity is commanded
    held: np.ndarray
    against: np.ndarray  # (m, 2) [m/s], c: the wind's drift to cancel where a place is held
    working: Optional[np.ndarray] = None  # (m, 4) bool, rotors that work; None: all

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
    aim, still = pose[:, 2].copy(), np.zeros((len(pose), 2))
    return QuadrotorState(at_rest(place, pose[:, 2], speed), aim, place.copy(), still)


def flown(inner, command, limits, numbers, step, air=STILL_AIR, touch=None):
    """Return the inner state after ``step`` [s] under ``command`` (m, 4), with forces.

    ``air`` (m, 3) [m/s]: the wind; ``touch(before, after, step)``: the ``Flight`` after a substep that
    contacts make of ``after``, None while nothing is within reach.
    """
    if inner.working is None and touch is None:
        loops = same_bits(compiled_loops, WORTH, size=0)  # ``moved`` counts steps
        after = loops and _flown_by(loops, inner, command, limits, numbers, step, air)
        if after is not None:
            return after
    limited = quadrotor.possible(command, limits)
    if inner.working is not None:
        limited[~inner.working.any(axis=1)] = 0.0
    z = inner.place[:, 2]
    stays = quadrotor.stays(z, limited)
    limited[stays] = 0.0
    wanted = quadrotor.level(limited, inner.aim + 0.5 * step * limited[:, 3])
    keeps, against = _keep_place(inner, wanted, limited, limits, step)
    wanted[z <= 0.0, :2] = 0.0  # straight up from the ground
    working = inner.working
    flight = moved(
        inner.flight, wanted, inner.aim, limited[:, 3], air, numbers, step, working, touch
    )
    if stays.any():
        flight = _resting(inner.flight, flight, stays, numbers, step)
    aim = wrap_angle(inner.aim + step * limited[:, 3])
    over = upright_share(flight.attitude) < 0.0
    if over.any():
        working = quadrotor.without(working, len(aim), over, slice(None))
    # Where it would come to rest, by the time constants of its velocities.
    coming = flight.place + flight.velocity / parts(numbers.velocity_gain).T
    held = np.where(keeps & ~stays[:, np.newaxis], inner.held, coming)
    return QuadrotorState(flight, aim, held, against, working)


def _flown_by(loops, inner, command, limits, numbers, step, air):
    """Return what :func:`flown` does by ``loops``; None where robots stay on the ground, or turn over."""
    m, place = len(inner.aim), np.ascontiguousarray(inner.place.T)
    top = columns_of(limits.top, (m, 4))
    limited, wanted, held = np.empty((4, m)), np.empty((3, m)), np.empty((3, m))
    if loops.limit(np.ascontiguousarray(command.T), top, place, limited):
        return None
    keeps, against = np.empty((3, m), dtype=bool), np.array(inner.against.T, order="C")
    gains = PLACE_GAIN, LEARNING * step, STRONGEST
    turning, before = limited[3], np.ascontiguousarray(inner.held.T)
    turned = cos_sin(inner.aim + 0.5 * step * turning)
    loops.hold(limited, top, *turned, place, before, against, gains, keeps, wanted)
    flight = moved(inner.flight, wanted.T, inner.aim, turning, air, numbers, step)
    table = table_of(numbers, *substeps(step)[1:], m)
    where = (each.T for each in flight[:3])
    if loops.settle(table, *where, keeps, before, held):
        return None
    return QuadrotorState(flight, wrap_angle(inner.aim + step * turning), held.T, against.T)


def stretched(function, plan, inner, command, limits, numbers, step, air, near, kept, *given):
    """Return the inner state after several steps of ``step`` [s], and what else ``function`` returns.

    ``function``: ``flight_stretches.flight_stretch``, which has ``plan``, ``near`` and ``kept``;
    ``command`` (m, 4), which is changed in place; ``air`` (m, 3) [m/s].  All rotors work.
    """
    m, (count, sub) = len(inner.aim), substeps(step)
    parts_of = *inner.flight, inner.against, inner.held, inner.aim[:, np.newaxis]
    state = tuple(np.array(each.T, order="C") for each in parts_of)
    obeyed = np.array(command.T, order="C")
    fastest = np.array(np.broadcast_to(AT_LIMIT * numbers.speed_max, m), dtype=float)
    bounds = columns_of(limits.top, (m, 4)), table_of(numbers, sub, m), fastest
    times = step, count, sub, VELOCITY_EVERY, PLACE_GAIN, LEARNING, STRONGEST
    wind = columns_of(air, (m, 3))
    result = function(plan, state, obeyed, bounds, wind, times, near, kept, *given)
    command[:] = obeyed.T
    *flight, against, held, aim = (each.T for each in state)
    return QuadrotorState(Flight(*flight), aim[:, 0], held, against), result


def substeps(duration):
    """Return how many substeps a step of ``duration`` [s] has, and how long they are [s]."""
    count = max(1, int(np.ceil(duration / SUBSTEP - 1e-9)))
    return count, duration / count


def _keep_place(inner, wanted, limited, limits, step):
    """Set ``wanted`` (m, 3) to hold robots' places where ``limited`` (m, 4) commands no velocity, in place.

    Return which coordinates are held, (m, 3) bool, and ``against``.
    """
    across = ~limited[:, :2].any(axis=1) & (inner.place[:, 2] > 0.0)
    keeps = np.column_stack([across, across, limited[:, 2] == 0.0])
    away = np.where(keeps, inner.held - inner.place, 0.0)
    against = inner.against + LEARNING * step * away[:, :2]
    against = np.minimum(np.maximum(against, -STRONGEST), STRONGEST)
    back, most = PLACE_GAIN * away, limits.top[..., :3]
    back[:, :2] += against
    back = np.minimum(np.maximum(back, -most), most)
    wanted[:] = np.where(keeps, back, wanted)
    return keeps, against


def lost(inner, row, rotor):
    """Return the inner state in which robot ``row`` has lost a ``rotor``, which stops at once."""
    rotors = inner.flight.rotors.copy(order="F")
    rotors[row, rotor] = 0.0
    return quadrotor.lost(inner, row, rotor)._replace(flight=inner.flight._replace(rotors=rotors))


powerless = quadrotor.powerless


def powered(inner, rows):
    """Return the inner state in which the motors of robots ``rows`` turn again, aiming where they head."""
    aim = inner.aim.copy()
    aim[rows] = headings(inner.flight.attitude)[rows]
    return quadrotor.powered(inner._replace(aim=aim), rows)


def upside_down(inner):
    """Return which robots, (m,) bool, are upside down."""
    return upright_share(inner.flight.attitude) < 0.0


def saturated(inner, numbers):
    """Return which robots, (m,) bool, have a rotor that turns as fast as it can."""
    return inner.flight.rotors.max(axis=1) > AT_LIMIT * numbers.speed_max


def _resting(before, after, stays, numbers, step):
    """Return ``after`` where robots that stay, (m,) bool, stand as ``before``, their rotors running out.

    Upside down, if they were.
    """
    heading = headings(before.attitude)
    still = at_rest(before.place, heading)
    over = upright_share(before.attitude) < 0.0
    if over.any():
        x, y, z, w = still.attitude.T
        still.attitude[over] = np.stack([w, z, x, y], axis=1)[over]  # rolled over by pi
    still = still._replace(rotors=lagged_speeds(before.rotors, still.rotors, numbers, step))
    pick = stays[:, np.newaxis]
    return Flight(*(
        np.asfortranarray(np.where(pick, old, new)) for old, new in zip(still, after)
    ))  # fmt: skip


def moved(flight, wanted, heading, turning, air, numbers, duration, working=None, touch=None):
    """Return the ``Flight`` after ``duration`` [s] towards ``wanted`` (m, 3) [m/s], common frame.

    ``heading`` (m,) [rad]: what attitudes aim at, which turns by ``turning`` (m,) [rad/s]; ``air`` (m, 3)
    [m/s]: the wind; ``working`` and ``touch`` as of :func:`flown`.  The velocity's controller works every
    few substeps, the others at each.
    """
    count, step = substeps(duration)
    if working is None and touch is None:
        loops = same_bits(compiled_loops, WORTH)
        if loops is not None:
            plan = count, step, VELOCITY_EVERY
            return moved_by(loops, plan, flight, wanted, heading, turning, air, numbers)
    for index in range(count):
        if index % VELOCITY_EVERY == 0:
            acceleration = wanted_acceleration(flight.velocity, wanted, numbers)
            attitude = attitude_of(acceleration, heading + index * step * turning)
        forces = acting(flight, numbers)
        speeds = rotor_speeds(flight, forces, acceleration, attitude, turning, numbers)
        if working is not None:
            speeds = np.where(working, speeds, 0.0)
        before, flight = flight, advanced(flight, forces, speeds, air, numbers, step)
        if working is not None:
            _keep_energy(before, flight, ~working.any(axis=1), numbers)
        if touch is not None:
            flight = touch(before, flight, step)
        if flight.place[:, 2].min() <= 0.0:
            _carry(flight)
    return flight


def _keep_energy(before, after, free, numbers):
    """Limit the rotational energy of bodies that turn freely, (m,) bool, to that before, in place.

    Nothing adds to ``w J w`` where no rotor turns them; a substep of first order would.
    """
    was, now = (
        (parts(numbers.inertia) * (each.rates * each.rates).T).sum(axis=0)
        for each in (before, after)
    )
    grown = free & (now > was)
    after.rates[grown] *= np.sqrt(was[grown] / now[grown])[:, np.newaxis]


def _carry(flight):
    """Stop robots at the ground, in place."""
    down = flight.place[:, 2] <= 0.0
    flight.place[down, 2] = 0.0
    flight.velocity[down, 2] = np.maximum(flight.velocity[down, 2], 0.0)


def state(inner):
    """Return poses (m, 3), body twists (m, 3) in the plane, and ``Spatial`` of an inner state."""
    flight = inner.flight
    heading = headings(flight.attitude)
    return quadrotor.seen(flight.place, flight.velocity, heading, flight.attitude, flight.rates)


def stopped(inner, pushed, place, bound):
    """Return the inner state after contacts, as ``quadrotor.stopped`` does."""
    return inner._replace(
        flight=inner.flight._replace(**quadrotor.put(inner, pushed, place, bound))
    )
