"""Which bounds robots would break before they stand, by their drives' own models, without forces."""

import itertools

import numpy as np

from mrs_simulator.core.compiling import in_time
from mrs_simulator.core.neighbours import close_pairs, least_distances
from mrs_simulator.vehicles.courses import Courses

LATENCY = 0.1  # [s] between a command and its effect, and between a pose and its odometry, together
LEAST_STEP = 1e-6  # [m] by which a robot must come nearer to a bound to break it
SETTLED = 30.0  # [s] after which a commanded speed is reached
LINEAR = ("linear.x", "linear.y", "linear.z")
LEVEL = ("linear.x", "linear.y")
UPRIGHT = ("linear.z",)
HIGH = 1000.0  # [m] above the ground, far from it
HALVINGS = 30  # [-] of the interval in which a speed is sought


def held_for(period, odometry_rate):
    """Return for how long [s] robots go on before a zero acts: period, odometry's gap and latency."""
    return period + 1.0 / odometry_rate + LATENCY


class Stopping:
    """Follows the robots' speeds by the commands passed, and looks ahead until all would stand."""

    def __init__(self, team, hold):
        """``hold`` [s]: for how long robots may go on before a zero command acts."""
        self._courses, self._hold = Courses(team), hold
        self._width = len(self._courses.team.axes)
        self._inner = self._given = self._time = None

    def note(self, command, now):
        """Take in the ``command`` (n, a) in force from ``now`` [s] on."""
        self._given, self._time = np.array(command[:, : self._width]), now

    def stand(self):
        """Take in that zero has been in force since the last command."""
        if self._given is not None:
            self._given = np.zeros_like(self._given)

    def courses(self, command, pose, now):
        """Return the ``Course`` under the last command and under ``command`` (n, a), a list.

        Both are held and then braked from ``pose``, (n, 3) or (n, 4), at ``now`` [s].
        """
        heights = pose[:, 3] if pose.shape[1] > 3 else np.zeros(len(pose))
        self._courses.dimension = 3 if pose.shape[1] > 3 else 2
        self._follow(pose, heights, now)
        known = self._inner, pose[:, :3], heights
        command = command[:, : self._width]
        wanted = [command] if self._given is None else [self._given, command]
        with in_time():
            return [self._courses.course(*known, each, self._hold) for each in wanted]

    def _follow(self, pose, heights, now):
        rest = self._courses.at_rest(pose[:, :3], heights)
        if self._time is None or now < self._time:
            self._inner, self._given = rest, None
        elif now > self._time:
            self._inner = self._courses.followed(self._inner, self._given, now - self._time)
        # Robots that fly go on from where they are, not from where they should be.
        self._inner = [
            own._replace(place=at.place, heading=at.heading) if hasattr(own, "heading") else own
            for own, at in zip(self._inner, rest)
        ]
        self._time = now


def leaving(course, fence):
    """Return ``{row: place}`` of the robots whose ``course`` goes farther beyond ``fence`` [m] than now."""
    if fence is None:
        return {}
    columns = min(course.place.shape[2], len(fence) // 2)
    ends = [[0, 2], [1, 3], [4, 5]][:columns]
    low, high = np.array([[fence[i] for i in pair] for pair in ends]).T
    place = course.place[:, :, :columns]
    excess = np.maximum(low - place, place - high)
    farther = excess[1:] > excess[0] + LEAST_STEP
    beyond = (farther & (excess[1:] + course.aside[:, :, np.newaxis] > 0.0)).any(axis=(0, 2))
    return {row: place[-1, row] for row in np.flatnonzero(beyond).tolist()}


def approaching(course, distance, stands=False):
    """Return ``(i, j, d)`` of the pairs that come to d < ``distance`` [m], and nearer than now.

    Each pair once; where j ``stands``, as if it stopped now for a cause of its own, each in both orders.
    """
    known = np.flatnonzero(np.isfinite(course.place).all(axis=(0, 2)))
    if distance <= 0.0 or len(known) < 2:
        return []
    place, aside = course.place[:, known], course.aside[:, known]
    way = np.linalg.norm(np.diff(place, axis=0), axis=2).sum(axis=0) + aside.max(axis=0)
    first, second = close_pairs(place[0], distance + 2.0 * float(way.max()))
    others, beside = place, aside
    if stands:
        first, second = np.concatenate([first, second]), np.concatenate([second, first])
        others, beside = place[:1], np.zeros_like(aside)
    apart = others[:, second] - place[:, first]
    least = least_distances(apart)
    nearer = least < np.linalg.norm(apart[0], axis=1) - LEAST_STEP
    reached = np.where(nearer, least - aside[:, first] - beside[:, second], np.inf).min(axis=0)
    hit = reached < distance
    return list(
        zip(
            known[first[hit]].tolist(),
            known[second[hit]].tolist(),
            np.maximum(reached[hit], 0.0).tolist(),
        )
    )


def stopping_ways(team, speed, hold, axes=LINEAR):
    """Return how far (n,) [m] robots run on from ``speed`` [m/s], one or (n,), held for ``hold`` [s].

    That is farthest of both ways along those of their ``axes`` along which they move.
    """
    courses, ways = Courses(team), np.zeros(getattr(team, "bases", team).n)
    courses.dimension = 3
    pose, heights = np.zeros((len(ways), 3)), np.full(len(ways), HIGH)
    own = list(courses.team.axes)
    for axis, sign in itertools.product(axes, (1.0, -1.0)):
        if axis not in own:
            continue
        command = np.zeros((len(ways), len(own)))
        command[:, own.index(axis)] = sign * np.asarray(speed)
        inner = courses.followed(courses.at_rest(pose, heights), command, SETTLED)
        course = courses.course(inner, pose, heights, command, hold)
        way = np.linalg.norm(np.diff(course.place, axis=0), axis=2).sum(axis=0)
        ways = np.maximum(ways, way + course.aside[-1])
    return ways


def stopping_way(team, speed, hold, axes=LINEAR):
    """Return how far [m] the slowest to stop runs on, as :func:`stopping_ways`."""
    return float(stopping_ways(team, speed, hold, axes).max())


def greatest_speed(team, way, hold, top, axes=LINEAR):
    """Return the greatest speed [m/s] up to ``top`` from which all stand within ``way`` [m]."""
    return greatest(lambda speed: stopping_way(team, speed, hold, axes) <= way, top)


def greatest(holds, top):
    """Return the greatest number up to ``top`` for which ``holds``, which does for all that are less."""
    if holds(top):
        return top
    low, high = 0.0, top
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
