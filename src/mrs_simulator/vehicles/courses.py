"""Predicted courses: under a command held for a while, then braking, by the drives' models.

All motion is that without forces.  Of n robots; ``inner`` states are a list of what ramps, group after
group of a team; places are those of centres.
"""

import functools
from typing import NamedTuple

import numpy as np

from mrs_simulator.core.compiling import same_bits
from mrs_simulator.core.kinematics import cos_sin
from mrs_simulator.core.neighbours import lengths
from mrs_simulator.vehicles.compiled_courses import compiled_courses

BRAKING = 12  # [-] instants at which a braking robot is looked at
HOLDING = 2  # [-] the same under a command that is held
DENSER = 1.5  # [-] exponent by which the first instants of braking lie closer
# [-] time constants after which a robot that stops exponentially is looked at no more
CONSTANTS = 6.0
PLANAR = ("linear.x", "linear.y", "angular.z")
LEAST = 1e-9  # [s] of an interval
WORTH = 4000  # [-] calls of 0.1 ms that take as long as numba takes to load


class Course(NamedTuple):
    """Places at instants 0, ..., k, and how far robots are from straight lines between them."""

    time: np.ndarray  # (k + 1,) [s]
    place: np.ndarray  # (k + 1, n, d) [m]
    # (k, n) [m] by which the model is beside the straight line of each interval, at most
    aside: np.ndarray
    speed: np.ndarray  # (n,) [m/s] while the command is held, at most


class Courses:
    """The courses of a ``Team``."""

    def __init__(self, team):
        self.team = getattr(team, "bases", team)
        self.dimension = team.dimension  # d, of places
        drive = self.team.groups[0].drive
        plain = drive.RAMPS and not drive.JOINTS and drive.MEDIUM != "air"
        plain = plain and not hasattr(drive, "lateness")
        self.ramps_alone = plain and len(self.team.groups) == 1 and set(drive.AXES) <= set(PLANAR)

    def at_rest(self, pose, heights):
        """Return the inner states of robots at rest at ``pose`` (n, 3) and ``heights`` (n,) [m]."""
        return [
            g.drive.begin(pose[g.rows], heights[g.rows], g.numbers)
            if g.drive.MEDIUM == "air"
            else np.zeros((len(g.kinds), len(g.drive.AXES)))
            for g in self.team.groups
        ]

    def followed(self, inner, command, seconds):
        """Return the inner states after ``seconds`` of ``command`` (n, a)."""
        times = np.array([seconds])
        return [
            _ramped(g, own, g.of(command), seconds)
            if g.drive.RAMPS and g.drive.MEDIUM != "air"
            else self._phase(g, own, g.of(command), times)[2]
            for g, own in self._each(inner)
        ]

    def speeds(self, inner):
        """Return the centres' speeds in ``inner`` states, (n,) [m/s]."""
        result = np.zeros(self.team.n)
        for g, own in self._each(inner):
            if g.drive.MEDIUM == "air":
                _, twist, spatial = g.drive.state(own)
                velocity = np.column_stack([twist[:, :2], spatial.twist[:, 0]])
            else:
                velocity = self._velocity(g, own)[:, :2]
            result[g.rows] = lengths(velocity)
        return result

    def _each(self, inner):
        return zip(self.team.groups, inner)

    def course(self, inner, pose, heights, command, hold):
        """Return the ``Course`` from ``pose`` (n, 3) and ``heights`` (n,) until all stand.

        ``command`` (n, a) is held for ``hold`` [s]; then they brake.
        """
        if self.ramps_alone and self.dimension == 2:
            loops = same_bits(compiled_courses, WORTH, 2 + len(pose) // 50)
            if loops is not None:
                return _looped(loops, self.team.groups[0], inner[0], pose, command, hold)
        first, brakes = instants_of(hold)
        held = [self._phase(g, own, g.of(command), first) for g, own in self._each(inner)]
        longest = max(
            (_longest(g, phase[2]) for g, phase in zip(self.team.groups, held)), default=0.0
        )
        then = max(longest, LEAST) * brakes
        time = np.concatenate([[0.0], first, hold + then])
        steps = time[1:] - time[:-1]
        n, count = self.team.n, len(steps)
        chord, aside = np.zeros((count, n, 3)), np.zeros((count, n))
        speed = np.zeros(n)
        for (g, own), phase in zip(self._each(inner), held):
            still = np.zeros((len(g.kinds), len(g.drive.AXES)))
            rest = self._phase(g, phase[2], still, then)
            mean = np.concatenate([phase[0], rest[0]])
            after = np.concatenate([phase[1], rest[1]])
            begun = self._velocity(g, own) if g.drive.MEDIUM != "air" else mean[0]
            ends = np.concatenate([begun[np.newaxis], after])
            moved = _flown if g.drive.MEDIUM == "air" else _rolled
            chord[:, g.rows], aside[:, g.rows] = moved(mean, ends, pose[g.rows, 2], steps)
            left = _left(g, ends[-1])
            aside[-1, g.rows] += left
            linear = slice(None if g.drive.MEDIUM == "air" else 2)
            speed[g.rows] = lengths(ends[: HOLDING + 1, :, linear]).max(axis=0)
        start = np.column_stack([pose[:, :2], heights])[:, : self.dimension]
        place = np.empty((count + 1, n, self.dimension))
        place[0] = start
        place[1:] = start + np.cumsum(chord[:, :, : self.dimension], axis=0)
        return Course(time, place, aside, speed)

    def _phase(self, group, inner, command, times):
        """Return mean velocities over the intervals up to ``times`` (k,) [s], those at their ends, both
        (k, m, 3), and the inner states at the last."""
        if group.drive.MEDIUM == "air":
            return _phase_in_the_air(group, inner, command, times)
        target = group.drive.target(command, inner, group.limits, group.numbers)
        steps = _differences(times)
        if group.drive.RAMPS:
            rates = group.drive.rates(group.limits, group.numbers)
            after, mean = ramps(inner, target, rates, times, steps)
        else:
            after, mean = np.empty((2, len(times)) + inner.shape)
            for k, step in enumerate(steps.tolist()):
                before = after[k - 1] if k else inner
                after[k], mean[k] = group.drive.followed(
                    before, target, group.limits, group.numbers, max(step, LEAST)
                )
        of = self._velocity(group, np.concatenate([mean, after]))
        return of[: len(times)], of[len(times) :], after[-1]

    def _velocity(self, group, inner):
        """Return velocities (..., m, 3) ahead, to the left and about the vertical of ``inner`` states."""
        if group.drive.JOINTS and inner.ndim == 3:
            own = np.stack([group.velocities(each) for each in inner])
        else:
            own = group.velocities(inner)
        result = np.zeros(own.shape[:-1] + (len(PLANAR),))
        for column, axis in enumerate(group.drive.AXES):
            if axis in PLANAR:
                result[..., PLANAR.index(axis)] = own[..., column]
        return result


@functools.lru_cache(maxsize=8)
def instants_of(hold):
    """Return the instants [s] at which a command held for ``hold`` [s] is looked at, and shares of the time
    of braking; not to be written to."""
    shares = (np.arange(1, BRAKING + 1) / BRAKING) ** DENSER
    return np.linspace(0.0, hold, HOLDING + 1)[1:], shares


def _differences(values):
    """Return by how much ``values`` (k, ...) grow from one to the next, from 0 at first."""
    result = np.array(values)
    result[1:] -= values[:-1]
    return result


def _ramped(group, inner, command, seconds):
    """Return the inner states (m, a) after ``seconds`` of ``command`` (m, a), of drives that ramp."""
    rates = group.drive.rates(group.limits, group.numbers)
    change = group.drive.target(command, inner, group.limits, group.numbers) - inner
    return inner + np.copysign(np.minimum(rates * seconds, np.abs(change)), change)


def ramps(inner, target, rates, times, steps):
    """Return ramps from ``inner`` (m, a) to ``target`` at ``rates``, at ``times`` (k,) and their means over
    the intervals ``steps`` (k,) before, (k, m, a) each."""
    change = target - inner
    size, times = np.abs(change), times[:, np.newaxis, np.newaxis]
    reach = np.minimum(rates * times, size)
    after = inner + np.copysign(reach, change)
    # The integral of the error: down at the rate until nothing is left.
    spent = np.minimum(times, size / rates)
    area = size * spent - 0.5 * np.where(np.isinf(rates), 0.0, rates) * spent * spent
    way = target * times - np.copysign(area, change)
    return after, _differences(way) / steps[:, np.newaxis, np.newaxis]


def _looped(loops, group, inner, pose, command, hold):
    """Return the :class:`Course` of a team of one group that ramps in the plane, by ``Loops``."""
    drive, (first, brakes), inner = group.drive, instants_of(hold), np.ascontiguousarray(inner)
    rates = np.ascontiguousarray(
        np.broadcast_to(drive.rates(group.limits, group.numbers), inner.shape)
    )

    def target(command, inner):
        return np.ascontiguousarray(drive.target(command, inner, group.limits, group.numbers))

    aim = target(command, inner)
    held = loops.followed(inner, aim, rates, hold)
    still = target(np.zeros(inner.shape), held)
    then = max(loops.longest(held, still, rates), LEAST) * brakes
    time = np.concatenate([[0.0], first, hold + then])
    m, steps = len(pose), time[1:] - time[:-1]
    x, y, aside = np.empty((m, len(time))), np.empty((m, len(time))), np.empty((m, len(steps)))
    found = x, y, aside, np.empty(m)
    heading, start = np.ascontiguousarray(pose[:, 2]), np.ascontiguousarray(pose[:, :2])
    given = (inner, aim, held, still), rates, columns_of(drive.AXES), heading, start
    loops.roll(*given, (first, then, steps), np.ones(m, dtype=bool), found)
    return Course(time, np.stack([x.T, y.T], axis=2), aside.T, found[3])


@functools.lru_cache(maxsize=8)
def columns_of(axes):
    """Return which of ``PLANAR`` the ``axes`` are, (a,); not to be written to."""
    return np.array([PLANAR.index(axis) for axis in axes])


def _phase_in_the_air(group, inner, command, times):
    """As ``Courses._phase``, of robots that fly: velocities are those of the common frame."""
    drive, mean, before = group.drive, [], 0.0
    for time in times.tolist():
        step = max(time - before, LEAST)
        after = drive.flown(inner, command, group.limits, group.numbers, step)
        mean.append((after.place - inner.place) / step)
        inner, before = after, time
    # At the ends velocities lie between the means before and after: those after stand for them.
    mean = np.stack(mean)
    return mean, mean, inner


def _rolled(mean, ends, heading, steps):
    """Return chords (k, m, 3) and how far motion is ``aside`` (k, m) [m] of robots on the ground or afloat.

    ``mean`` (k, m, 3), ``ends`` (k + 1, m, 3): body velocities over intervals of ``steps`` (k,) [s], and at
    their ends; ``heading`` (m,) [rad] at first.
    """
    steps = steps[:, np.newaxis]
    turn = mean[:, :, 2] * steps
    middle = heading + np.cumsum(turn, axis=0) - 0.5 * turn
    cos, sin = cos_sin(middle)
    shrink = np.sinc(turn / (2.0 * np.pi)) * steps
    chord = np.zeros(mean.shape)
    chord[:, :, 0] = shrink * (cos * mean[:, :, 0] - sin * mean[:, :, 1])
    chord[:, :, 1] = shrink * (sin * mean[:, :, 0] + cos * mean[:, :, 1])
    change = np.abs(ends[1:] - ends[:-1])
    slower, speed = lengths(change[:, :, :2]), lengths(ends[:, :, :2])
    fastest = np.maximum(speed[1:], speed[:-1])
    bend = 0.25 * steps * (slower + fastest * np.abs(turn))
    # Chords take velocity and heading by their means.
    wrong = steps * (0.25 * slower * np.abs(turn) + 0.125 * steps * fastest * change[:, :, 2])
    return chord, bend + np.cumsum(wrong, axis=0)


def _flown(mean, ends, heading, steps):
    """As :func:`_rolled`, of robots that fly along lines at velocities that only grow or only fall."""
    before = np.concatenate([mean[:1], mean[:-1]])
    after = np.concatenate([mean[1:], np.zeros_like(mean[:1])])
    steps = steps[:, np.newaxis]
    bend = 0.25 * steps * np.linalg.norm(after - before, axis=2)
    return mean * steps[:, :, np.newaxis], bend


def _longest(group, inner):
    """Return the time [s] in which the slowest robot of a ``group`` brakes to rest."""
    drive, numbers = group.drive, group.numbers
    if drive.MEDIUM == "air" or not drive.RAMPS:
        late = drive.lateness(numbers) if hasattr(drive, "lateness") else 1.0
        top, acceleration = group.limits
        ramped = np.where(np.isinf(acceleration), 0.0, np.where(np.isinf(top), 0.0, top))
        return CONSTANTS * late + float((ramped / np.maximum(acceleration, 1e-12)).max())
    still = drive.target(np.zeros(inner.shape), inner, group.limits, numbers)
    return float((np.abs(inner - still) / drive.rates(group.limits, numbers)).max(initial=0.0))


def _left(group, velocity):
    """Return the remaining way (m,) [m], or 0 of all, from the last ``velocity`` (m, 3)."""
    if not hasattr(group.drive, "lateness"):
        return 0.0
    late = group.drive.lateness(group.numbers)
    return late * np.linalg.norm(velocity[:, :2], axis=1)
