"""Certificate that robots can brake without touching: commands pass only if it holds after them.

At each command the robots' courses are looked at, ``vehicles.courses``: the command held for a period, and
then braking.  Of a pair that might touch on the way, or a robot that might touch what stands there, all
robots go slower, and at last only turn; if they might touch even so, they brake, which was safe at their
last passed command.
``docs/safety.md`` has the proof.
"""

import numpy as np

from mrs_simulator.control.safety.distances import squash
from mrs_simulator.control.safety.nearest_velocities import Brakes, filter_loops, pairs_within
from mrs_simulator.core.neighbours import least_distances, lengths
from mrs_simulator.vehicles.courses import Courses

LATE = 1.0  # [-] periods by which commands may come late
EXACT = 1e-3  # [m] by which robots may be beside their courses, whatever they do
SOON = 0.1  # [s] in which it is forgotten at the soonest how fast robots were
AHEAD = 0.3  # [s] by which robots react to each other sooner than they have to
FASTEST = 100.0  # [m/s] of robots without limits, afterwards
# [-] of its speed at which a robot is let go, one after the other
SHARES = (1.0, 0.5, 0.2, 0.05, 0.0)
STEEPEST = 4.0  # [-] of a share over the next one, but for the last
BRAKES = len(SHARES)  # what comes after these: it does not even turn


class WayOut:
    """Predicts the robots' speeds by their commands so far, and certifies commands that leave a way out."""

    def __init__(self, team, radii, period, fidelity):
        """``radii`` (n,) [m] of the discs, or balls, that bodies fill; ``period`` [s] of commands;
        ``fidelity``: what moves the robots."""
        self._courses, self._period, self._radii = Courses(team), period, radii
        self._width = len(self._courses.team.axes)
        self._linear = np.array([a.startswith("linear") for a in self._courses.team.axes])
        self._squash = squash(team)
        self._run_on = _run_on(self._courses.team, fidelity)  # (n,) [s], None without forces
        self._slowness, self._late = _slowness(self._courses.team)
        self.brakes = Brakes(self._slowness, self._late + AHEAD)
        if self._run_on is not None:
            self.brakes = Brakes(self._slowness, self._late + self._run_on + AHEAD)
        self._inner = self._given = self._time = self._speed = self._seen = None
        self._ran = np.zeros(team.n)  # [m/s]

    def certified(self, command, pose, heights, time, obstacles, gap=None):
        """Return ``command`` (n, a) without the parts that would leave no way out, at ``time`` [s].

        ``pose`` (n, 3), ``heights`` (n,) [m]; ``obstacles``: the ``Surroundings`` that stand; ``gap`` (n,)
        [m]: known lower bounds of how far bodies are from these, to compute less.
        """
        own = command[:, : self._width]
        self._know(pose, heights, time)
        speed = np.maximum(self._speed, lengths(own[:, self._linear]))
        speed = np.minimum(speed, self._courses.team.speeds[:, 0])
        place = np.column_stack([pose[:, :2], heights])[:, : self._courses.dimension]
        pairs, single = self._near(place, self._ways(speed), obstacles, gap)
        if len(pairs[0]) or single.any():
            own = self._let(own, pose, heights, pairs, single, obstacles)
            command = np.concatenate([own, command[:, self._width :]], axis=1)
        self._given, self._time = np.array(own), time
        return command

    @property
    def ramps_alone(self):
        """Return whether robots of one drive ramp along the plane, and nothing else counts."""
        known = self._run_on is None and self._squash is None
        return known and self._courses.ramps_alone and self._courses.dimension == 2

    @property
    def columns(self):
        """Return how robots brake: slowness (n,) [s^2/m], lateness (n,) [s] and that of ``brakes``."""
        return self._slowness, self._late, self.brakes.late

    def known(self, time):
        """Return the inner states (n, a), command (n, a) and speeds (n,) that were known last, and how long
        [s] before ``time``: below 0 where robots are at rest.

        Of robots that ramp alone.
        """
        if self._time is None or time < self._time:
            n = len(self._radii)
            still = np.zeros((n, self._width))
            return still, still, np.zeros(n), -1.0
        return self._inner[0], self._given, self._speed, time - self._time

    def note(self, inner, command, speeds, time):
        """Record inner states, a ``command`` that leaves a way out, and speeds, at ``time`` [s].

        Of robots that ramp alone.
        """
        self._inner, self._given, self._speed, self._time = [inner], command, speeds, time

    @property
    def speeds(self):
        """Return the robots' speeds (n,) [m/s] as they were known at the last command."""
        return self._speed

    def course(self, command, pose, heights, time):
        """Return the ``Course`` of ``command`` (n, a) at ``time`` [s], which robots obey from now on."""
        self._know(pose, heights, time)
        self._given, self._time = np.array(command), time
        return self._courses.course(self._inner, pose, heights, command, self._period)

    def may_have_acted(self, command, place, obstacles):
        """Return whether :meth:`certified` may have changed ``command`` (n, a), at ``place`` (n, d).

        Something is near then at the speed of a greater share, of a robot without speed at the top one.
        """
        speed = np.linalg.norm(command[:, : self._width][:, self._linear], axis=1)
        top = np.minimum(self._courses.team.speeds[:, 0], FASTEST)
        ways = self._ways(np.where(speed == 0.0, top, np.minimum(top, STEEPEST * speed)))
        (first, second), single = self._near(place, ways, obstacles)
        return bool(len(first) or single.any())

    def _know(self, pose, heights, time):
        """Let the inner states be those at ``time`` [s]; at rest where it went back or nothing is known."""
        if self._time is None or time < self._time:
            self._inner, self._speed = self._courses.at_rest(pose, heights), np.zeros(len(pose))
            self._ran = np.zeros(len(pose))
        elif time > self._time:
            self._inner = self._courses.followed(self._inner, self._given, time - self._time)
            self._speed = self._courses.speeds(self._inner)
            if self._run_on is not None:
                self._speed = self._with_seen(pose, heights, time - self._time)
        if self._run_on is not None:
            self._seen = np.column_stack([pose[:, :2], heights])

    def _with_seen(self, pose, heights, seconds):
        """Return the speeds (n,) [m/s] of the model, or those seen in the last ``seconds``, or before.

        What runs on is faster than the model; that it was is forgotten as slowly as it may run on.
        """
        way = np.column_stack([pose[:, :2], heights]) - self._seen
        fades = np.exp(-seconds / (SOON + self._run_on + 2.0 * self._late))
        self._ran = np.maximum(np.linalg.norm(way, axis=1) / seconds, self._ran * fades)
        return np.maximum(self._speed, self._ran)

    def _ways(self, speed):
        """Return how far [m] robots at ``speed`` (n,) [m/s] get until they stand, errors included."""
        way = speed * (self._period + self._late) + 0.5 * speed * speed * self._slowness
        late = LATE * self._period if self._run_on is None else LATE * self._period + self._run_on
        return way + EXACT + late * speed

    def _near(self, place, ways, obstacles, gap=None):
        """Return rows of pairs that may meet, two of (p,), and who may meet an obstacle, (n,) bool."""
        seen = place if self._squash is None else place * self._squash
        reach = self._radii + ways
        first, second = pairs_within(
            filter_loops(len(self._radii)), seen, 2.0 * float(reach.max()) + EXACT
        )
        apart = lengths(seen[first] - seen[second])
        near = apart < reach[first] + reach[second]
        if gap is None or (gap < ways).any():
            gap = obstacles.least_gaps(place, self._radii)
        return (first[near], second[near]), gap < ways

    def _let(self, command, pose, heights, pairs, single, obstacles):
        """Return what of ``command`` (n, a) leaves a way out."""
        level, shares = np.zeros(len(pose), dtype=int), np.array([*SHARES, 0.0])
        first, second = pairs
        while True:
            now = np.where(self._linear, command * shares[level, np.newaxis], command)
            now[level == BRAKES] = 0.0
            course = self._courses.course(self._inner, pose, heights, now, self._period)
            free = self._free(course)
            hit = self._meet(course, free, first, second)
            hit &= (level[first] < BRAKES) | (level[second] < BRAKES)
            stop = np.zeros(len(pose), dtype=bool)
            stop[first[hit]] = stop[second[hit]] = True
            stop |= single & (level < BRAKES) & self._strike(course, free, obstacles, single)
            if not stop.any():
                return now
            level = np.where(stop, np.minimum(level + 1, BRAKES), level)

    def _free(self, course):
        """Return how far (k, n) [m] robots may be from the straight lines of their ``course``."""
        may = course.aside + EXACT + LATE * self._period * course.speed
        if self._run_on is None:
            return may
        # Neither the robot nor its course is faster than that.
        since = np.minimum(2.0 * course.time[1:, np.newaxis], self._run_on)
        return may + since * np.maximum(course.speed, self._speed)

    def _meet(self, course, free, first, second):
        """Return which pairs may touch, (p,) bool."""
        place = course.place if self._squash is None else course.place * self._squash
        loops = filter_loops(len(self._radii))
        if loops is not None and place.shape[2] == 2:
            by_robot = place[:, :, 0].T, place[:, :, 1].T, (self._radii + free).T
            return loops.meet(*map(np.ascontiguousarray, by_robot), first, second)
        least = least_distances(place[:, first] - place[:, second])
        room = self._radii + free
        return (least < room[:, first] + room[:, second]).any(axis=0)

    def _strike(self, course, free, obstacles, single):
        """Return which robots may touch what stands, or leave the arena, (n,) bool."""
        result = np.zeros(len(single), dtype=bool)
        rows = np.flatnonzero(single)
        if not len(rows):
            return result
        place = course.place[:, rows]
        gap, out = obstacles.gaps(place, self._radii[rows], rows)  # (o, k + 1, m), (o, k + 1, m, d)
        move = place[1:] - place[:-1]
        # What is convex lies behind the line through its point nearest to either end.
        ahead = gap[:, :-1] + np.minimum((out[:, :-1] * move).sum(axis=3), 0.0)
        behind = gap[:, 1:] - np.maximum((out[:, 1:] * move).sum(axis=3), 0.0)
        least = np.maximum(ahead, behind).min(axis=0)
        result[rows] = (least < free[:, rows]).any(axis=0)
        return result


def _run_on(team, fidelity):
    """Return for how long at their speed robots run on, (n,) [s], or None without forces."""
    if fidelity != "dynamic":
        return None
    return np.array([each.run_on for each in team.kinds])


def _slowness(team):
    """Return by what robots at a speed v get ``v^2/2`` times that far while they brake, (n,) [s^2/m], and
    by what time [s] they are late beside that, (n,)."""
    slowness, late = np.zeros(team.n), np.zeros(team.n)
    for g in team.groups:
        linear = [k for k, axis in enumerate(g.drive.AXES) if axis.startswith("linear")]
        acceleration = np.broadcast_to(g.limits.acceleration, (len(g.kinds), len(g.drive.AXES)))
        slowness[g.rows] = (1.0 / acceleration[:, linear]).max(axis=1)
        if hasattr(g.drive, "lateness"):
            late[g.rows] = g.drive.lateness(g.numbers)
        if hasattr(g.drive, "tracking"):  # which counts the steepest tilt
            late[g.rows] += 1.0
    return slowness, late
