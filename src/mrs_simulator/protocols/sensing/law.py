"""Protocols of robots that know nothing but what their own sensors measure, in their own frames."""

import functools

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.arrays import read_only
from mrs_simulator.core.claims import (
    Claim,
    Condition,
    NothingDecays,
    TooShort,
    by_sample,
    extent,
    stays_below,
)
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import direction_of, wrap_angle
from mrs_simulator.protocols.common import attracting
from mrs_simulator.protocols.sensing import equations as laws
from mrs_simulator.protocols.sensing import published
from mrs_simulator.scenario.surroundings.obstacles import least_clearance
from mrs_simulator.sensors.mounts import fitted_mounts

MET = 0.05  # [m] extent of a team that has met
SPACED = 0.03  # [m] of ranges at the end of a run
CASCADE = 1.5  # [-] time constants for which an error waits for that of the robot before
# [rad] from straight aside, and from straight ahead, of transducers that are listened to
SIDEWAYS = 0.35
SIGMAS = 3.0  # [-] standard deviations that noise may be off by
LATE = 0.015  # [-] times the decay time of errors: readings later than that change it
NOISE = 0.05  # [m] ten times that of distances from a wall: a start below it shows no rate
GAIN = Parameter("gain", 0.5, "1/s", **POSITIVE, high=10.0, meaning="of each error")


class Sensing(PioneerControl):
    """What laws by own sensors share: each robot's law by itself, in its own frame."""

    LOCAL_FRAMES = True
    TAKES_EDGES = False  # who is sensed is a neighbour
    MEMORYLESS = True

    def own_point(self, robot):
        """Return the controlled point (2,) [m] of a ``robot`` in its own frame."""
        lead = self.team.lead(self.l)
        return np.array([lead if np.isscalar(lead) else lead[self.numbers.index(robot)], 0.0])

    @property
    def _leads(self):
        return np.broadcast_to(self.team.lead(self.l), len(self.numbers))

    def _sensors(self):
        """Return the ``Mount`` of each robot that the law reads."""
        mounts = fitted_mounts(self.team, self._sensor_changes)
        return [{mount.name: mount for mount in own}[self.SENSORS[0]] for own in mounts]

    def _noise(self, quantity=""):
        """Return the standard deviations (n,) of a ``quantity`` of the robots' readings."""
        return np.array([dict(mount.noise)[quantity].stddev for mount in self._sensors()])

    def _unbiased(self):
        """Return the condition that readings are off by chance alone, and none is lost."""
        noises = [noise for mount in self._sensors() for _, noise in mount.noise]
        off = [any((n.bias, n.bias_stddev, n.bias_walk, n.dropout)) for n in noises]
        late = max(noise.latency for noise in noises)
        holds = not any(off) and self.gain * late <= LATE
        why = "sensors lose readings, or are biased or late: theory knows none of it"
        return Condition("readings off by chance alone", holds, why)

    def _wander(self, stddev):
        """Return what errors (n,) that decay at the gain are off by for noise ``stddev`` (n,) of each.

        ``e+ = (1 - gain Tc) e + gain Tc w`` has the variance ``gain Tc/2`` times that of w.
        """
        return SIGMAS * stddev * np.sqrt(0.5 * self.gain * self.period)


def settled(rate, begun, constants=0.0):
    """Return a decorator of measures of what has settled, from ``begun`` to ``SPACED``, at ``rate`` [1/s].

    ``constants``: further times of 1/rate.  In a shorter run the measure raises ``TooShort``.
    """
    least = (np.log(max(1.0, begun / SPACED)) + constants) / rate

    def of(measure):
        def measured(run):
            if run.time[-1] - run.time[0] < least:
                raise TooShort("wanted a run of {:.3g} s".format(least))
            return measure(run)

        return measured

    return of


class LimitedVisibility(Sensing):
    """All meet, seeing others by range and bearing within ``radius``: Ando and others, 1999.

    No robot knows who is who, where it is, or where north is: each goes to the centre of the smallest
    circle about those that it sees, no farther than V/2 from the middle of the way to each.

    Theorem: if each sees all others within V, robots that do so at the start do so for ever, and a team
    that is connected so meets.
    """

    SENSORS = ("neighbours",)
    KEEPS_CONNECTED = True
    PARAMETERS = (
        GAIN,
        Parameter(
            "radius",
            4.0,
            "m",
            **POSITIVE,
            meaning="V, within which robots see each other, the range of the sensor",
        ),
    )

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the velocity (2,) [m/s] of one robot in its own frame."""
        seen = self.readings[robot].neighbours
        if seen is None:
            return np.zeros(2)
        near = seen.points[seen.ranges <= self.radius]
        return laws.limited_visibility(near, self.radius, self.gain, self.period)

    def published(self):
        """Return the law by what each should have seen."""
        return published.LimitedVisibility(self.gain, self.radius, self.period)

    def graph_at(self, start, hand):
        """Return who sees whom."""
        first, second = self._pairs(hand)
        edges = np.column_stack([first, second]) + 1
        return Topology(len(hand), edges.tolist(), directed=False)

    def _pairs(self, hand):
        first, second = np.triu_indices(len(hand), 1)
        near = np.linalg.norm(hand[first] - hand[second], axis=1) <= self.radius
        return first[near], second[near]

    def _sees_all_within(self):
        """Return the condition that each robot sees all others within the radius, whatever their bearing.

        Whom it does not see it may leave: of such a team the theorem says nothing, neither that it meets
        nor that it does not.
        """
        why = ""
        for robot, mount in zip(self.numbers, self._sensors()):
            seen = mount.settings
            if seen.most < self.radius:
                why = "up to {:g} m, the radius is {:g} m".format(seen.most, self.radius)
            elif seen.view < 2.0 * np.pi:
                why = "in a part of the directions alone"
            elif seen.occlusion:
                why = "none behind another's body: occlusion"
            elif any(noise.dropout for _, noise in mount.noise):
                why = "not all of the time: dropout"
            if why:
                why = "robot{} sees others {}".format(robot, why)
                break
        return Condition("all within the radius are seen", not why, why)

    def claims(self, start):
        """Return claims: robots in view of each other at the start stay so, and all meet."""
        first, second = self._pairs(start)
        conditions = [
            Condition(
                "connected at the start",
                self.graph_at(start, start).has_spanning_tree(),
                "robots within {:g} m do not make one group".format(self.radius),
                necessary=True,
            ),
            Condition(
                "gain Tc <= 1",
                self.gain * self.period <= 1.0,
                "robots go beyond the circle's centre",
            ),
            Condition(
                "points are centres",
                bool(self.fidelity == "point_mass" or not self._leads.any()),
                "what is seen of a robot is not the point that is controlled",
            ),
            self._sees_all_within(),
        ]

        def farthest(hand):
            return np.linalg.norm(hand[:, first] - hand[:, second], axis=2).max(axis=1, initial=0.0)

        name = "farthest of two that saw each other [m]"

        @settled(self.gain, float(extent(start[np.newaxis])[0]), 0.5 * len(start))
        def last(run):
            return float(extent(run.hand[-1:])[0])

        return conditions + [
            stays_below(by_sample(farthest), self.radius, name, 1e-6),
            Claim("extent of the team at the end [m]", 0.0, MET, last),
        ]


class WallFollowing(Sensing):
    """A line of robots follows a wall to the left, by sonar alone.

    The distance to the wall and the angle against it come from the transducers that look straight to the
    left; those ahead sense the robot in front, to which a gap is kept: ``speed + gain (gap - wanted)``.
    The first robot has none before it, and goes at ``speed``; what is farther than two gaps does not count.

    Theorem: along a straight wall, whose normal is within the cones, errors obey ``e' = -gain e``, each
    gap's driven by that of the robot before: all decay.
    """

    SENSORS = ("sonar",)
    PARAMETERS = (
        GAIN,
        Parameter("distance", 1.0, "m", low=0.1, high=3.0, meaning="of controlled points from the wall"),
        Parameter("speed", 0.3, "m/s", low=0.0, high=5.0, meaning="along the wall"),
        Parameter("gap", 0.8, "m", low=0.1, high=2.0, meaning="to the body of the robot in front"),
    )  # fmt: skip

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the velocity (2,) [m/s] of one robot in its own frame."""
        sonar_reading = self.readings[robot].sonar
        if sonar_reading is None:
            return np.zeros(2)
        speed = self.speed + self._gap_error(sonar_reading) * self.gain
        aside = to_the_left(sonar_reading.places)
        ranges = sonar_reading.ranges[aside]
        if not np.isfinite(ranges).all():
            return np.array([speed, 0.0])
        front, rear = ((*sonar_reading.places[k, :2], sonar_reading.ranges[k]) for k in aside)
        distance, angle = laws.wall_beside(front, rear)
        distance -= self.own_point(robot)[0] * np.sin(angle)
        return laws.along_wall(speed, self.gain * (distance - self.distance), angle)

    def _gap_error(self, sonar_reading):
        """Return how much farther than wanted the robot in front is [m], 0 without one."""
        ahead = sonar_reading.ranges[ahead_of(sonar_reading.places)]
        nearest = np.min(ahead[np.isfinite(ahead)], initial=np.inf)
        return nearest - self.gap if nearest < 2.0 * self.gap else 0.0

    def published(self):
        """Return the law by what each sonar should have read."""
        numbers = self.gain, self.distance, self.speed, self.gap
        return published.WallFollowing(*numbers, self._leads)

    def claims(self, start):
        """Return the distance from the wall, its rate, and the gaps at the end."""
        beside = Condition("a wall", bool(self.obstacles), "nothing stands in the scene")
        if not beside.holds:
            return [beside]
        decay = float(-np.log1p(-self.gain * self.period) / self.period)
        conditions = [beside, attracting(self.gain), self._unbiased()]
        if self.gain * self.period >= 1.0:
            return conditions

        def off(hand):
            return np.linalg.norm(self.from_wall(hand) - self.distance, axis=-1)

        ready = settled(self.gain, float(off(start[np.newaxis])[0]), CASCADE * (len(start) - 1))
        deviation = self._rate_deviation(self.from_wall(start) - self.distance)
        wander = np.linalg.norm(self._wander(self._noise_of_approach() / self.gain))

        @ready
        def spacing(run):
            return float(np.abs(self.gaps(run.pose[-1]) - self.gap).max(initial=0.0))

        @ready
        def last(run):
            return float(off(run.hand[-1:])[0])

        @ready
        def decays(run):
            away = self.from_wall(run.hand) - self.distance
            if np.linalg.norm(away[0]) <= NOISE:
                raise NothingDecays("the distances begin below {:g} m".format(NOISE))
            # Noise of the sonars weighs least where the distance is large.
            left = (away[1:] * away[:-1]).sum() / (away[:-1] ** 2).sum()
            return float(-np.log(left) * (len(away) - 1) / (run.time[-1] - run.time[0]))

        return conditions + [
            Claim(
                "distance from where the wall is wanted, at the end [m]", 0.0, SPACED + wander, last
            ),
            Claim(
                "decay rate of the distances [1/s]",
                decay,
                0.02 * decay + SIGMAS * deviation,
                decays,
                free=True,
            ),
            Claim(
                "worst gap from the wanted at the end [m]", 0.0, SPACED + self._gap_noise(), spacing
            ),
        ]

    def _noise_of_approach(self):
        """Return how far noise of the sonars lets each velocity to the wall be off, (n,) [m/s].

        With ranges f and r of the foremost and the rearmost transducer, B apart, the wall seems nearer by
        ``f + (x - l)(r - f)/B`` and turned by ``(r - f)/B``: the point goes to the wall at ``gain e + w``,
        ``w = gain f + c (r - f)``, ``c = (gain (x - l) - speed)/B``.
        """
        across = []
        for sonar, l in zip(self._sensors(), self._leads):
            places = np.array(sonar.settings.transducers, dtype=float)
            front, rear = places[to_the_left(places), 0]
            across.append((self.gain * (front - l) - self.speed) / (front - rear))
        return self._noise() * np.hypot(self.gain - np.array(across), across)

    def _rate_deviation(self, away):
        """Return the standard deviation [1/s] of the rate of errors that begin at ``away`` (n,) [m].

        It is that of a least-squares fit of each error to the one before; their squares sum to
        ``away^2/(2 gain Tc)``.
        """
        squares = float(away @ away)
        spread = np.linalg.norm(self._noise_of_approach() * away)
        return np.sqrt(2.0 * self.gain * self.period) * spread / squares if squares else np.inf

    def _gap_noise(self):
        """Return how far gaps may be off by noise [m]: they are kept to the nearest of K echoes."""
        ahead = max(np.count_nonzero(ahead_of(m.settings.transducers)) for m in self._sensors())
        noise = self._noise()
        return float((self._wander(noise) + noise * np.sqrt(2.0 * np.log(max(1, ahead)))).max())

    def from_wall(self, hand):
        """Return the distances (..., n) [m] of points ``hand`` (..., n, 2) from the nearest obstacle."""
        points = np.reshape(hand, (-1, 2))
        far = least_clearance(self.obstacles, points)
        return far.reshape(np.shape(hand)[:-1])

    def gaps(self, pose):
        """Return from each robot's foremost transducers to the body before it, (n - 1,) [m]."""
        rear = np.array([kind.body.rear for kind in self.team.kinds])
        x = [max(t[0] for t in sonar.settings.transducers) for sonar in self._sensors()]
        apart = np.linalg.norm(np.diff(pose[:, :2], axis=0), axis=1)
        return apart - rear[:-1] - np.array(x)[1:]

    def measures(self, run):
        """Return the gaps at the end [m]."""
        return {"gaps_at_end": self.gaps(run.pose[-1]).tolist()}


def ahead_of(places):
    """Return which of ``places`` (K, 3) look ahead, (K,) bool."""
    return _listened_to(np.array(places, dtype=float).tobytes())[0]


def to_the_left(places):
    """Return the rows of the foremost and the rearmost of ``places`` (K, 3) that look to the left.

    Raises ``ValueError`` where fewer than two do.
    """
    aside = _listened_to(np.array(places, dtype=float).tobytes())[1]
    if len(aside) < 2:
        raise ValueError("sonar: {} transducers look to the left, wanted two".format(len(aside)))
    return aside


@functools.lru_cache(maxsize=16)
def _listened_to(numbers):
    """Return which of the places in these bytes look ahead, (K,) bool, and rows of those to the left.

    Of the latter the foremost and the rearmost where there are two.
    """
    places = np.frombuffer(numbers).reshape(-1, 3)
    ahead = np.abs(wrap_angle(places[:, 2])) < SIDEWAYS
    aside = np.flatnonzero(np.abs(wrap_angle(places[:, 2] - 0.5 * np.pi)) < SIDEWAYS)
    if len(aside) > 1:
        foremost, rearmost = np.argmax(places[aside, 0]), np.argmin(places[aside, 0])
        aside = aside[[foremost, rearmost]]
    return read_only(ahead), aside.tolist()


class SensedFollowing(Sensing):
    """A convoy: each robot follows the one with the number before its own, by range and bearing.

    ``u = gain (|z| - distance) z/|z|``, z from the own point to the centre that is seen; unknown is how
    fast the robot before is.  The first drives at ``speed`` and ``turn``.  Who is not seen is waited for.

    Theorem: ranges end where the speeds are the same, on a straight way at ``distance + speed/gain``, on
    a circle where ``r^2 = R^2 + (distance + turn R/gain)^2``, r and R the radii on which the centre that is
    followed and the point that follows go.
    """

    SENSORS = ("neighbours",)
    PARAMETERS = (
        GAIN,
        Parameter("distance", 1.0, "m", **POSITIVE, high=100.0, meaning="of robots at rest"),
        Parameter("speed", 0.3, "m/s", low=0.0, high=20.0, meaning="of the first"),
        Parameter("turn", 0.0, "rad/s", low=-3.0, high=3.0, meaning="of the first, with a heading"),
        Parameter("view", 2.0 * np.pi, "rad", low=0.1, high=2.0 * np.pi, meaning="field of view"),
    )  # fmt: skip

    def neighbourLaw(self, robot, theta, neighbours):
        """Return the velocity (2,) [m/s] of one robot in its own frame."""
        own = self.own_point(robot)
        if robot == self.numbers[0]:
            return np.array([self.speed, own[0] * self.turn])
        seen = self.readings[robot].neighbours
        before = self.numbers[self.numbers.index(robot) - 1]
        if seen is None or before not in seen.numbers:
            return np.zeros(2)
        return laws.towards(
            seen.points[np.argmax(seen.numbers == before)] - own, self.distance, self.gain
        )

    def published(self):
        """Return the law by what each should have seen."""
        numbers = self.gain, self.distance, self.speed, self.turn
        return published.SensedFollowing(*numbers, self._leads)

    def claims(self, start):
        """Return the ranges at the end, and that each keeps sight of the robot before it."""
        ranges = laws.steady_ranges(self.speed, self.turn, self._leads, self.distance, self.gain)
        conditions = [
            Condition("two robots", len(start) > 1, "none follows"),
            Condition("gain Tc < 1", self.gain * self.period < 1.0, "robots overshoot"),
            Condition("a circle wide enough", ranges is not None, "followers stop within it"),
            Condition(
                "headings that follow the way",
                bool(self.turn == 0.0 or (self.fidelity != "point_mass" and self._leads.all())),
                "points and bases that keep their headings drive no circle",
            ),
            self._unbiased(),
        ]
        if not all(condition.holds for condition in conditions):
            return conditions

        begun = np.linalg.norm(np.diff(start, axis=0), axis=1) - ranges
        wander = float(self._wander(self._noise("range")).max())

        @settled(self._slowest(ranges), float(np.abs(begun).max()), CASCADE * len(ranges))
        def off(run):
            return float(np.abs(self._seen(run)[0][-1] - ranges).max())

        def widest(run):
            return float(np.abs(self._seen(run)[1]).max())

        return conditions + [
            Claim("worst range from the steady one at the end [m]", 0.0, SPACED + wander, off),
            Claim("largest bearing of the robot before [rad]", 0.5 * self.view, 0.0, widest, "at most"),
        ]  # fmt: skip

    def _slowest(self, ranges):
        """Return the rate [1/s] at which the robots settle to ``ranges`` (n - 1,) [m].

        Errors along the line of sight decay at the gain, and errors across it at ``gain (1 - distance/r)``;
        on a straight way ranges have none of the latter.
        """
        return self.gain * (1.0 if self.turn == 0.0 else 1.0 - self.distance / float(ranges.min()))

    @staticmethod
    def _seen(run):
        """Return ranges from points and bearings from headings to the robots before, (m, n - 1) each."""
        way = run.pose[:, :-1, :2] - run.hand[:, 1:]
        from_centre = run.pose[:, :-1, :2] - run.pose[:, 1:, :2]
        angle = direction_of(from_centre)
        return np.hypot(way[..., 0], way[..., 1]), wrap_angle(angle - run.pose[:, 1:, 2])

    def measures(self, run):
        """Return the ranges at the end [m]."""
        return {"ranges_at_end": self._seen(run)[0][-1].tolist()}
