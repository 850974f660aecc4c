"""Laws for robots that a current carries, with what theory claims of their runs."""

import numpy as np

from mrs_simulator.core.claims import Claim, Condition, converges_to, rate
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.linear_theorem import Names, linear_theorem
from mrs_simulator.core.spectra import left_null_vector
from mrs_simulator.protocols.common import all_hold, below, spanning_tree
from mrs_simulator.protocols.consensus.memory import Resumable
from mrs_simulator.protocols.currents import equations as laws
from mrs_simulator.protocols.currents import published
from mrs_simulator.protocols.published.laws import weights_of
from mrs_simulator.protocols.shapes.law import GAIN, SHAPE, SIZE, Shaped, without_rates

OFFSET = "offset from the stations, the largest [m]"
NAMES = Names("distance from where the current leaves them [m]", "", "decay rate [1/s]")
LAST = 5  # [-] a fifth of the run, at its end, over which speeds are measured

PLACE = [
    Parameter(axis, 0.0, "m", low=-1e4, high=1e4, meaning="of the formation's centre")
    for axis in ("x", "y")
]
INTEGRAL = Parameter(
    "integral", 0.0, "1/s^2", low=0.0, high=100.0, meaning="gain of the integral of the error"
)
MOST = Parameter(
    "most", 1.0, "m/s", low=0.0, high=20.0, meaning="that the integral makes up for at most"
)


class Integrating(Resumable, Shaped):
    """A law of the plane with an integral, in a current."""

    DIMENSIONS = (2,)
    MEMORYLESS = False
    IN_CURRENT = True

    def begin(self, hand):
        """Begin without anything integrated."""
        self._integral = 0.0

    def law(self, hand):
        u, self._integral = self._next(hand, self._integral)
        return u


class StationKeeping(Integrating):
    """``u_i = gain sum_j a_ij (e_j - e_i) - anchor e_i - integral z_i``, ``z_i' = e_i``, on stations.

    ``e_i`` is the error from the robot's station, its place in a shape about (x, y).  A current that
    carries all robots by V leaves ``V/anchor`` downstream without integral action, and nothing with it;
    without an anchor the shape is kept, and goes with the current.

    Theorem: the error comes to ``V/anchor``, and with an integral to 0, if every eigenvalue of the loop
    under held commands lies inside the unit circle; with an integral the robots must be faster than the
    current.
    """

    PARAMETERS = (
        GAIN._replace(low=0.0, default=0.0),
        Parameter("anchor", 0.1, "1/s", low=0.0, high=100.0, meaning="gain to the own station"),
        INTEGRAL,
        MOST,
        SHAPE,
        SIZE,
        *PLACE,
    )

    def published(self):
        stations = self.published_places() + [self.x, self.y]
        weights = weights_of(self._given_topology or self.topology)
        gains = self.gain, self.anchor, self.integral
        return published.StationKeeping(weights, gains, self.most, stations, self.period)

    def stations(self):
        """Return where the robots are wanted, (n, 2) [m]."""
        return self.places() + [self.x, self.y]

    def targets(self, hand):
        """Return where the robots are wanted, (n, 2) [m]; None for a formation that drifts."""
        return self.stations() if self.anchor > 0.0 else None

    def _next(self, hand, integral):
        error = hand - self.stations()
        gains = self.gain, self.anchor, self.integral
        u = laws.station_keeping(error, integral, self.topology, *gains)
        return u, laws.integrated(integral, error, self.period, self._longest())

    def _longest(self):
        """Return how long [m s] the integral of an error may be."""
        return self.most / self.integral if self.integral else 0.0

    # What theory says of a run -------------------------------------------------------------------

    def claims(self, start):
        """Return the offset that is left, and how fast the rest decays."""
        if self.anchor <= 0.0:
            return self._drifting()
        theorem = self._theorem()
        largest = float(np.exp(-self.period * theorem.held_rate(self.period)))
        name = "largest eigenvalue of the held loop < 1 [-]"
        conditions = [below(name, largest, 1.0, necessary=True)]
        if self.integral > 0.0:
            fastest = float(np.linalg.norm(self.carried, axis=1).max())
            conditions.append(below("current < most [m/s]", fastest, self.most, necessary=True))
        if not all_hold(conditions):
            return conditions
        stations, left = self.stations(), theorem.offset[: len(start)]
        away = converges_to(stations, self.tolerance.place, OFFSET)
        away = away._replace(
            predicted=float(np.linalg.norm(left - stations, axis=1).max()), place=left
        )
        if self.integral > 0.0:
            claims = [converges_to(left, self.tolerance.place, NAMES.limit)]
        else:
            claims = theorem.consequences(start, self.period, self.accuracy, NAMES, free=False)
        return conditions + without_rates([away, *claims], self.fidelity)

    def _theorem(self):
        """Return the ``LinearTheorem`` of places and, if any, integrals of the errors."""
        eye, stations = np.eye(len(self.numbers)), self.stations()
        pull = self.gain * self.topology.laplacian() + self.anchor * eye
        push = pull @ stations + self.carried
        if self.integral == 0.0:
            return linear_theorem(pull, push)
        matrix = np.block([[pull, self.integral * eye], [-eye, 0.0 * eye]])
        return linear_theorem(matrix, np.concatenate([push, -stations]))

    def _drifting(self):
        """Return what is said of a formation without an anchor: its shape is kept, and it drifts."""
        alike = Condition(
            "one current", bool(np.ptp(self.carried, axis=0).max() == 0.0), "some are not carried"
        )
        still = Condition("no integral", self.integral == 0.0, "nothing is there to be kept to")
        weights, places = left_null_vector(self.topology), self.places()
        receiver, sender, _ = self.topology.arcs

        def shape(run):
            away = run.hand[-1] - places
            return float(np.linalg.norm(away[receiver] - away[sender], axis=1).max(initial=0.0))

        def speed(run):
            first = -max(2, len(run.time) // LAST)
            way = weights @ (run.hand[-1] - run.hand[first])
            return float(np.linalg.norm(way) / (run.time[-1] - run.time[first]))

        wanted, place = float(np.linalg.norm(self.carried[0])), self.tolerance.place
        return [
            spanning_tree(self.topology),
            alike,
            still,
            Claim("worst displacement error at the end [m]", 0.0, place, shape),
            Claim("speed of w^T p [m/s]", wanted, 0.02 + 0.02 * wanted, speed),
        ]


class LineOfSight(Integrating):
    """Each robot follows a line of its own at a constant speed, aiming ``ahead`` of itself on the line.

    ``u = U (ahead, -(e + sigma z))/|...|`` in the path's frame, e the cross-track error.  Across a current
    it leaves ``ahead V/sqrt(U^2 - V^2)``; with sigma above 0, ``z' = ahead e/((e + sigma z)^2 + ahead^2)``,
    nothing.  Lines are parallel, through the places of the shape.

    Theorem: if the robots are faster than the current across their line, the cross-track error decays
    to ``ahead V/sqrt(U^2 - V^2)``, and to 0 with the integral; for small errors at the rate ``U
    ahead^2/(ahead^2 + e^2)^(3/2)``.
    """

    PARAMETERS = (
        Parameter("speed", 1.0, "m/s", **POSITIVE, high=20.0, meaning="through the water"),
        Parameter("ahead", 5.0, "m", **POSITIVE, high=1e3, meaning="to the point aimed at"),
        Parameter("sigma", 0.0, "m/s", low=0.0, high=20.0, meaning="gain of the integral"),
        Parameter("heading", 0.0, "rad", low=-np.pi, high=np.pi, meaning="of the lines"),
        SHAPE._replace(default="line"),
        SIZE,
        *PLACE,
    )  # fmt: skip

    def published(self):
        numbers = self.heading, self.speed, self.ahead, self.sigma
        return published.LineOfSight(
            self.published_places(), (self.x, self.y), numbers, self.period
        )

    def _axes(self):
        """Return the unit vectors along the lines and to their left, (2, 2), one in each row."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        return np.array([[cos, sin], [-sin, cos]])

    def across(self, hand):
        """Return the cross-track errors (..., n) [m], positive to the left of the lines."""
        turned = self.places() @ self._axes() + [self.x, self.y]
        return (hand - turned) @ self._axes()[1]

    def _next(self, hand, integral):
        across = self.across(hand)
        direction = laws.line_of_sight(across, integral, self.ahead, self.sigma)
        after = laws.sight_integrated(across, integral, self.ahead, self.sigma, self.period)
        return self.speed * direction @ self._axes(), after

    # What theory says of a run -------------------------------------------------------------------

    def claims(self, start):
        """Return the cross-track error that is left, how fast the rest decays, and the speed along."""
        along, aside = (self.carried @ self._axes().T).T
        conditions = [
            below("current across the line < speed [m/s]", float(np.abs(aside).max()), self.speed, True)
        ]  # fmt: skip
        if not all_hold(conditions):
            return conditions
        through = np.sqrt(self.speed**2 - aside**2)
        aim = self.ahead * aside / through
        rest = aim if self.sigma == 0.0 else np.zeros_like(aim)
        allowed = self.tolerance

        def speed(run):
            first = -max(2, len(run.time) // LAST)
            way = (run.hand[-1] - run.hand[first]) @ self._axes()[0]
            return float(np.abs(way / (run.time[-1] - run.time[first]) - through - along).max())

        claims = [
            Claim(
                "cross-track error, the largest [m]",
                float(np.abs(rest).max()),
                allowed.place,
                lambda run: float(np.abs(self.across(run.hand[-1])).max()),
            ),
            Claim(
                NAMES.limit,
                0.0,
                allowed.place,
                lambda run: float(np.abs(self.across(run.hand[-1]) - rest).max()),
            ),
            Claim("difference of a speed along the line [m/s]", 0.0, 0.02 * self.speed, speed),
        ]
        if self.sigma == 0.0:
            steep = self.speed * self.ahead**2 / np.hypot(self.ahead, aim) ** 3
            slowest = float(-np.log1p(-self.period * steep.min()) / self.period)
            error = lambda hand: np.linalg.norm(self.across(hand) - rest, axis=-1)  # noqa: E731
            claims.append(rate(slowest, error, allowed.rate))
        return conditions + without_rates(claims, self.fidelity)
