"""Following a trajectory through points, with what theory claims of such runs."""

import math

import numpy as np

from mrs_simulator.core.claims import Claim, decay_rate
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.protocols.common import attracting, below
from mrs_simulator.protocols.linear_errors import Tracking
from mrs_simulator.protocols.shapes.law import SHAPE, SIZE, Shaped
from mrs_simulator.protocols.shapes.published import Marching, least_snap
from mrs_simulator.protocols.trajectory import equations as laws

SAMPLES = 2000  # at which accelerations are looked at
MOST = 1e6  # [m] of a waypoint
SLOW = 1e-3  # [m/s] at which a robot's lateness is asked
SWINGS = "4 gain T = {:.2g} is above 1: robots that are late by T = {:.2g} s may swing"
RATE = "decay rate of the error [1/s]"


class Trajectory(Tracking, Shaped):
    """Minimum-snap trajectory through waypoints, followed in formation: feed-forward and a gain.

    Of one waypoint it is a step: the team is wanted there at once.

    Theorem: robots that follow a velocity late by T stay within ``e(0) + T max|r''|/gain`` of the
    trajectory r, as long as ``4 gain T <= 1``; at its end, where r rests, the error decays at ``gain``.
    """

    PARAMETERS = (
        Parameter(
            "gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="to the place on the trajectory"
        ),
        Parameter(
            "waypoints", "0 0, 4 0, 4 3", "m", meaning="passed one after the other, d numbers each"
        ),
        Parameter("speed", 0.5, "m/s", **POSITIVE, high=10.0, meaning="mean, between two of them"),
        SHAPE,
        SIZE._replace(default=1.0),
    )
    TAKES_EDGES = True

    def published(self):
        """Return the law as published: a march without edges."""
        n, places = len(self.numbers), self.published_places()
        points = read_waypoints(self.waypoints, self.dimension)
        curve = least_snap(points, self.speed)

        def wanted(time):
            return curve(time) + places

        blind = np.zeros(n, dtype=bool)
        return Marching(np.zeros((n, n)), 0.0, self.gain, wanted, self.period, blind)

    def checked_parameters(self, given):
        """Return all values; waypoints that make no path are refused."""
        values = super().checked_parameters(given)
        read_waypoints(values["waypoints"], self.dimension)
        return values

    def set_parameters(self, given):
        super().set_parameters(given)
        points = read_waypoints(self.waypoints, self.dimension)
        self._curve = laws.minimum_snap(points, self.speed)

    def wanted(self, time):
        path = self._curve.at(self._begun + np.asarray(time, dtype=float))
        return path[:, np.newaxis] + self.places()

    def pointMassLaw(self, hand):
        now, then = self.wanted([self.time, self.time + self.period])
        return laws.following(hand, now, (then - now) / self.period, self.gain)

    # What theory says of a run -------------------------------------------------------------------

    def error_matrix(self):
        """Return ``gain I``, (n, n) [1/s]."""
        return self.gain * np.eye(len(self.numbers))

    def claims(self, start):
        """Return claims: the error stays below its bound and vanishes, at a known rate."""
        step = 2.0 / self.gain if self.gain > 0.0 else math.inf
        conditions = [
            attracting(self.gain),
            below("Tc < 2/gain [s]", self.period, step, necessary=True),
        ]
        if self.gain <= 0.0:
            return conditions
        claims = [
            self._bounded(start),
            Claim(
                "distance from the last place at the end [m]", 0.0, self.tolerance.place, self._end
            ),
        ]
        shrinks = 1.0 - self.gain * self.period
        if self.fidelity == "point_mass" and shrinks > 0.0 and self._errors_at(start).max() > SLOW:
            decay = -math.log(shrinks) / self.period
            claims.append(Claim(RATE, decay, self.tolerance.rate * decay, self._decay, free=True))
        return conditions + claims

    def _bounded(self, start):
        """Return the claim on the tracking error."""
        late = self._lateness()
        time = np.linspace(self._begun, max(self._curve.times[-1], self._begun), SAMPLES)
        fastest = float(np.linalg.norm(self._curve.at(time, 2), axis=1).max())
        bound = laws.tracking_bound(self._errors_at(start).max(), fastest, self.gain, late)
        swings = SWINGS.format(4.0 * self.gain * late, late) if math.isnan(bound) else ""
        # Held commands follow chords of the trajectory.
        chord = fastest * self.period**2
        return Claim(
            "tracking error [m]",
            0.0 if swings else float(bound),
            chord + (1e-6 if self.fidelity == "point_mass" else self.tolerance.place),
            lambda run: float(np.linalg.norm(self.errors(run), axis=2).max()),
            "at most",
            free=True,
            unproved=swings,
        )

    def _lateness(self):
        """Return by how much [s] the robots are late, with the time for which a command is held."""
        if self.fidelity == "point_mass":
            return 0.0
        if self.fidelity == "kinematic":
            return self.team.lateness + self.period
        return float(self.team.tracking(np.full(self.team.n, SLOW)).max()) / SLOW + self.period

    def _errors_at(self, start):
        return np.linalg.norm(start - self.wanted([0.0])[0], axis=1)

    def _end(self, run):
        last = self._curve.last + self.places()
        return float(np.linalg.norm(run.hand[-1] - last, axis=1).max())

    def _decay(self, run):
        size = np.linalg.norm(self.errors(run), axis=2).max(axis=1)
        return decay_rate(run.time, size)


def read_waypoints(text, dimension):
    """Return the waypoints (k, d) [m] in ``text``, such as ``"0 0 1, 4 0 2"``; ``ValueError``."""
    try:
        points = np.array([[float(value) for value in row.split()] for row in text.split(",")])
    except ValueError:
        points = np.empty((0, 0))
    fits = points.ndim == 2 and points.size and points.shape[1] == dimension
    if not fits or not np.isfinite(points).all() or np.abs(points).max() > MOST:
        wanted = "wanted points of {} numbers each, as in '{}, {}'"
        examples = " ".join("0" * dimension), " ".join("4321"[:dimension])
        raise ValueError("waypoints = {!r}: ".format(text) + wanted.format(dimension, *examples))
    if len(points) > 1 and np.linalg.norm(np.diff(points, axis=0), axis=1).min() < SLOW:
        raise ValueError("waypoints = {!r}: wanted no two of them in one place".format(text))
    return points
