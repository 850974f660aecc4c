"""Formations that move, with what theory claims of their runs."""

import copy
import functools

import numpy as np

from mrs_simulator.control.array_law import of_samples
from mrs_simulator.control.twists import twists_of
from mrs_simulator.core.claims import (
    FEWEST_FITTED,
    NEGLIGIBLE,
    Claim,
    Condition,
    NothingDecays,
    decay_rate,
    slope,
)
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.kinematics import UNICYCLE_AXES, direction_of, wrap_angle
from mrs_simulator.core.linear_theorem import Accuracy, Names, linear_theorem
from mrs_simulator.core.spectra import left_null_vector, unshared
from mrs_simulator.protocols.common import all_hold, attracting, below, spanning_tree
from mrs_simulator.protocols.energies import error_energy
from mrs_simulator.protocols.linear_errors import Tracking
from mrs_simulator.protocols.marching import equations as laws
from mrs_simulator.protocols.published.laws import weights_of
from mrs_simulator.protocols.shapes import published
from mrs_simulator.protocols.shapes.equations import scale
from mrs_simulator.protocols.shapes.law import GAIN, SHAPE, SIZE, Shaped, without_rates
from mrs_simulator.protocols.shapes.published import Separations, along, on_path

LAST = 5  # [-] a fifth of the run, at its end, must be without error
SETTLED = 30.0  # [-] times the error that is left at the end: above it, an error still decays
SMALL = 0.01  # [-] of an error's start, down to which its rate is fitted

ANCHORED = Names("distance from the path's places [m]", "", "")
FREE = Names("", "drift of the centre from the path [m]", "")
IN_A_ROW = 0.05  # [-] of the rate of who follows a follower, whose commands are held, too
# [-] of what held commands add to the rate of points, that robots which turn meanwhile may be off it
HELD = 2.0
LINEAR = 0.7  # [rad] by which one command may turn a robot that the linearised law is to hold of
SPEED = Parameter("speed", 0.4, "m/s", low=0.0, high=10.0, meaning="along the path")
RADIUS = Parameter(
    "radius",
    4.0,
    "m",
    **POSITIVE,
    high=1e4,
    meaning="of the circle, of the eight's two, and of the polygon's rounded corners",
)


class Marching(Tracking, Shaped):
    """A formation on a path: feed-forward of the wanted places' velocity, and the displacement law.

    In space the path is level, at height 0.

    Theorem: with feed-forward the robots take their places on the path without a steady error, if the
    graph has a spanning tree and ``Tc < 2/(gain lambda_max + anchor)``. Without it, on a straight line
    along a chain, the i-th robot behind the leader lags by ``i v/gain``.
    """

    PARAMETERS = (
        GAIN,
        SHAPE._replace(default="vee"),
        SIZE._replace(default=2.0),
        Parameter("path", "circle", choices=laws.PATHS, meaning="which way the formation goes"),
        SPEED,
        RADIUS,
        Parameter("waypoints", "0 0, 16 0, 16 12, 0 12", "m", meaning="corners of the polygon"),
        Parameter("turning", True, meaning="the formation turns with the path's heading"),
        Parameter(
            "swing", 0.0, low=0.0, high=0.9, meaning="share by which the size swings about its mean"
        ),
        Parameter(
            "swing_period", 20.0, "s", low=0.1, high=1e4, meaning="of one swing of the size"
        ),
        Parameter(
            "anchor",
            0.0,
            "1/s",
            low=0.0,
            high=100.0,
            meaning="gain to the place on the path; at 0 the path begins where the formation is",
        ),
        Parameter("feed_forward", True, meaning="all know the wanted velocity, not only leaders"),
    )  # fmt: skip

    def published(self):
        places, weights = self.published_places(), weights_of(self._given_topology or self.topology)
        path = _published_path(self)

        @functools.lru_cache(maxsize=2)  # where one command ends the next begins
        def wanted(time):
            swing = 1.0 + self.swing * np.sin(2.0 * np.pi * time / self.swing_period)
            return along(path(self.speed * time), places, swing, self.turning)

        blind = np.logical_and(not self.feed_forward, weights.any(axis=1))
        return published.Marching(weights, self.gain, self.anchor, wanted, self.period, blind)

    def checked_parameters(self, given):
        """Return all values; waypoints that make no path are refused."""
        values = super().checked_parameters(given)
        _path_of(values)
        return values

    def set_parameters(self, given):
        """Set the parameters and lay out the path."""
        super().set_parameters(given)
        self._path = _path_of(self.parameters)

    def wanted(self, time):
        time = self._begun + np.asarray(time, dtype=float)
        swing = 1.0 + self.swing * np.sin(2.0 * np.pi * time / self.swing_period)
        return laws.reference(self._path, self.places(), self.speed * time, swing, self.turning)

    def pointMassLaw(self, hand):
        now, then = self.wanted([self.time, self.time + self.period])
        # The mean velocity while the command is held leaves no error of its own.
        velocity = (then - now) / self.period
        if not self.feed_forward:
            velocity[self._listens()] = 0.0
        return laws.marching(hand, now, velocity, self.topology, self.gain, self.anchor)

    @of_samples
    def targets(self, hand):
        now = super().targets(hand)
        if self.anchor > 0.0:
            return now
        if not self.topology.has_spanning_tree():
            return None
        return now + (left_null_vector(self.topology) @ (hand - now))[..., np.newaxis, :]

    # What theory says of a run -------------------------------------------------------------------

    def error_matrix(self):
        """Return ``gain L + anchor I``, (n, n) [1/s]; None where no lag is known to be steady."""
        needed = [spanning_tree(self.topology), *self._straight()]
        if not self.feed_forward and (self.gain == 0.0 or not all_hold(needed)):
            return None
        return self._matrix()

    def _matrix(self):
        return self.gain * self.topology.laplacian() + self.anchor * np.eye(self.topology.n)

    def reference(self, time):
        """Return the wanted places, without feed-forward less the lags, (m, n, d) [m]."""
        return self._behind(self.wanted(time))

    def _behind(self, wanted):
        """Return ``wanted`` (..., n, d) less the lags."""
        behind = np.array(wanted)
        if not self.feed_forward:
            behind[..., 0] -= self._lag()
        return behind

    def energy(self, start):
        """Return ``e^T P e`` of the errors, without feed-forward of what is off the lags."""
        matrix = self.error_matrix()
        if self.gain <= 0.0 or not self.topology.has_spanning_tree() or matrix is None:
            return None
        # of the whole march, also of one that is resumed
        wanted = type(self).published(self).wanted

        lag = self._behind(0.0 * self.places())

        def error(hand, velocity, time):
            return hand - wanted(self._begun + time) - lag

        return error_energy(matrix / self.gain, self.gain, error, moving=True)

    def claims(self, start):
        """Return the claim on the steady error: none, or without feed-forward its known value."""
        conditions = [
            attracting(self.gain),
            below(
                "Tc < 2/(gain lambda_max + anchor) [s]",
                self.period,
                linear_theorem(self._matrix()).longest_period,
                necessary=True,
            ),
            spanning_tree(self.topology),
        ]
        if not self.feed_forward:
            conditions += self._straight()
        if not all_hold(conditions[2:]) or (self.gain == 0.0 and not self.feed_forward):
            return conditions  # with gain 0 nothing bounds the lag
        claims = self._no_error(start) if self.feed_forward else self._lags()
        return conditions + without_rates(claims, self.fidelity)

    def _listens(self):
        """Return who follows, (n,) bool: also while its edges are down."""
        return (self._given_topology or self.topology).in_degree() > 0.0

    def _straight(self):
        straight = self.path == "line" and self.swing == 0.0
        alone = int(np.sum(~self._listens())) == 1
        return [
            Condition("straight path", straight, "without feed-forward the lag keeps changing"),
            Condition("no anchor", self.anchor == 0.0, "it changes the lag"),
            Condition("one leader", alone, "wanted one robot that receives from none and so leads"),
        ]

    def _lag(self):
        """Return how far each robot lags, (n,) [m]: ``i v_d/kappa`` for follower i of a chain."""
        return linear_theorem(self._matrix(), self.speed * self._listens()).offset

    def _lags(self):
        lag, leader = self._lag(), int(np.flatnonzero(~self._listens())[0])

        def lags(run):
            behind = self.errors(run)[:, :, 0]
            return behind[:, leader, np.newaxis] - behind

        def off(run):
            error = self.errors(run)[-1]
            error[:, 0] += lag
            return float(np.linalg.norm(error - error[leader], axis=1).max())

        def drift(run):
            error = self.errors(run)[:, leader]
            return float(np.linalg.norm(error - error[0], axis=1).max())

        last, allowed = int(np.argmax(lag)), self.tolerance
        return [
            Claim(
                "lag of robot {} [m]".format(self.numbers[last]),
                float(lag[last]),
                allowed.rest,
                lambda run: float(lags(run)[-1, last]),
            ),
            Claim("worst difference from the lags [m]", 0.0, allowed.rest, off),
            Claim("drift of the leader from its path [m]", 0.0, allowed.place, drift, free=True),
        ]

    def _no_error(self, start):
        receiver, sender, _ = self.topology.arcs
        allowed = self.tolerance

        def displacement(run):
            errors = self.errors(run)[-max(1, len(run.time) // LAST) :]
            worst = [
                np.linalg.norm(e[receiver] - e[sender], axis=1).max(initial=0.0) for e in errors
            ]
            return float(max(worst))

        accuracy = Accuracy(allowed.place, allowed.place)
        claims = [Claim("steady displacement error [m]", 0.0, allowed.rest, displacement)]
        names = ANCHORED if self.anchor > 0.0 else FREE
        claims += self.consequences(start, accuracy, names=names, free=False)
        apart = self._apart()
        if len(self.numbers) > 1 and not apart.is_defective:
            decay = apart.held_rate(self.period)
            claims.append(
                Claim(
                    "decay rate of the error [1/s]",
                    decay,
                    allowed.rate * decay,
                    lambda run: settling_rate(run.time, scale(self.errors(run))),
                    # Turning robots leave millimetres before the slowest mode is alone.
                    "equal" if self.fidelity == "point_mass" else "at least",
                    free=True,
                )
            )
        return claims

    def _apart(self):
        """Return the ``LinearTheorem`` of what the robots' errors do not share."""
        basis = unshared(len(self.numbers))
        return linear_theorem(basis.T @ self._matrix() @ basis)


class LeaderFollower(Shaped):
    """l-psi control: each follower keeps separation and bearing to one robot; Desai et al., 2001.

    The robot that receives from none leads along the path; a follower knows its leader's ``(v, omega)``.  A
    law of unicycles in the plane.

    Theorem: linearised by its inputs, the law has separation and bearing decay to what is wanted at the
    rates ``k1`` and ``k2``, if every follower receives from one robot, all are led by one, and that one
    moves ahead.
    """

    PARAMETERS = (
        Parameter("k1", 0.5, "1/s", low=-10.0, high=100.0, meaning="gain of the separation"),
        Parameter("k2", 0.8, "1/s", low=-10.0, high=100.0, meaning="gain of the bearing"),
        SHAPE._replace(default="vee"),
        SIZE._replace(default=2.0),
        Parameter("path", "circle", choices=laws.PATHS[:3], meaning="which way the leader goes"),
        SPEED,
        RADIUS,
    )

    DIMENSIONS = (2,)
    TAKES_EDGES = False  # a follower has no law without its leader
    MEMORYLESS = False  # its leader knows the time

    def resumed(self, time, memory):
        """Return the law itself: what it claims is of the poses that robots have then."""
        return copy.copy(self)

    def published(self):
        """Return the law as published; None where robots receive from several."""
        weights, places = weights_of(self.topology) > 0.0, self.published_places()
        if weights.sum(axis=1).max() > 1:
            return None
        leader = np.where(weights.any(axis=1), weights.argmax(axis=1), np.arange(len(places)))
        away = (places - places[leader]) @ [1.0, 1j]
        gains, path = (self.k1, self.k2), _published_path(self)
        return Separations(leader, away, gains, path, self.speed, self.period)

    _pose = None

    def set_parameters(self, given):
        super().set_parameters(given)
        self._path = _path_of(self.parameters)

    def calculateControlLaw(self, pos_map):
        """Return each robot's ``Twist``, leaders first: a follower's law has its leader's command."""
        pose = self._pose = np.array([pos_map[number] for number in self.numbers])
        leader, levels = tree(self.topology)
        separation, bearing = self.wanted()
        axes = self.team.axes
        columns = [axes.index(axis) for axis in UNICYCLE_AXES]
        command, every = np.zeros((len(pose), 2)), np.zeros((len(pose), len(axes)))
        for depth, rows in enumerate(levels):
            chosen = self._leader_command() if depth == 0 else laws.leader_follower(
                pose[rows], pose[leader[rows]], command[leader[rows]],
                separation[rows], bearing[rows], self.k1, self.k2, self.l,
            )  # fmt: skip
            every[np.ix_(rows, columns)] = chosen
            # What a leader cannot do, its followers need not follow.
            scope = "robot" if self.saturation == "robot" else "none"
            every[rows] = self.saturated(every, scope)[rows]
            command[rows] = every[np.ix_(rows, columns)]
        return dict(zip(self.numbers, twists_of(every, axes)))

    def _leader_command(self):
        """Return the ``(v, omega)`` with which a leader follows the path, (1, 2)."""
        way = self.speed * np.array([self.time, self.time + self.period])
        now, then = self._path.at(way)[:, 2]
        return np.array([[self.speed, (then - now) / self.period]])

    def wanted(self):
        """Return each follower's separation (n,) [m] and bearing (n,) [rad] to its leader."""
        leader, _ = tree(self.topology)
        places = self.places()
        away = places - places[leader]
        return np.linalg.norm(away, axis=1), direction_of(away)

    def targets(self, hand):
        """Return where the hand points ``hand`` (n, 2) are wanted beside their leaders, (n, 2) [m]."""
        if self._pose is None or len(self._pose) != len(hand):
            return None
        leader, _ = tree(self.topology)
        separation, bearing = self.wanted()
        angle = self._pose[leader, 2] + bearing
        towards = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        places = self._pose[leader, :2] + separation[:, np.newaxis] * towards
        follows = (leader != np.arange(len(hand)))[:, np.newaxis]
        return np.where(follows, places, hand)

    # What theory says of a run -------------------------------------------------------------------

    def claims(self, start):
        """Return claims: separation and bearing are reached, at the rates k1 and k2."""
        in_degree = np.bincount(self.topology.arcs[0], minlength=self.topology.n)
        largest = max(self.k1, self.k2) * self.period
        conditions = [
            spanning_tree(self.topology),
            Condition(
                "one leader each",
                bool(in_degree.max() <= 1),
                "a follower receives from several robots",
            ),
            Condition(
                "k1 and k2 above 0", min(self.k1, self.k2) > 0.0, "errors grow", necessary=True
            ),
            Condition("k Tc < 2", largest < 2.0, "it is {:.3g}".format(largest), necessary=True),
            Condition("moving forward", self.speed > 0.0, "followers' headings are not stable"),
            Condition("robots with headings", self.fidelity != "point_mass", "points do not turn"),
        ]
        if not all_hold(conditions):
            return conditions
        allowed = self.tolerance
        names = (("separation", "m", self.k1), ("bearing", "rad", self.k2))
        _, levels = tree(self.topology)
        accuracy = allowed.rate if len(levels) <= 2 else max(allowed.rate, IN_A_ROW)
        claims, rates = [], []
        for column, (name, unit, gain) in enumerate(names):
            worst = functools.partial(self._worst, column=column)
            text = "worst {} error at the end [{}]".format(name, unit)
            claims.append(Claim(text, 0.0, allowed.rest, worst))
            decay = float(-np.log(max(abs(1.0 - gain * self.period), 1e-300)) / self.period)
            measured = functools.partial(self._rate, column=column)
            text = "decay rate of the {} error [1/s]".format(name)
            close = max(accuracy * decay, HELD * (decay - gain))
            rates.append(Claim(text, decay, close, measured, free=True))
        return conditions + without_rates(claims + rates, self.fidelity)

    def _worst(self, run, column):
        return float(np.abs(self._errors(run)[column][-1]).max(initial=0.0))

    def _rate(self, run, column):
        turn = self.period * np.abs(run.command[:-1, :, run.axes.index("angular.z")]).max(axis=1)
        first = int(np.flatnonzero(np.append(True, turn > LINEAR))[-1])  # sample after the last
        error = np.linalg.norm(self._errors(run)[column], axis=1)
        if 2 * first > len(error):  # robots do not come near where the law is linear
            first = 0
        return first_rate(run.time[first:], error[first:])

    def _errors(self, run):
        """Return the followers' errors of separation [m] and bearing [rad], (m, followers) each."""
        leader, _ = tree(self.topology)
        separation, bearing = self.wanted()
        follows = leader != np.arange(len(leader))
        apart, psi = laws.separation_and_bearing(
            run.pose[:, follows], run.pose[:, leader[follows]], self.l
        )
        return apart - separation[follows], wrap_angle(psi - bearing[follows])


@functools.lru_cache(maxsize=8)
def tree(topology):
    """Return whom each robot follows, (n,) rows, itself for a leader, and the rows at each depth.

    The first of several neighbours; robots that follow each other in a ring
    have no depth.
    """
    receiver, sender, _ = topology.arcs
    leader = np.arange(topology.n)
    leader[receiver[::-1]] = sender[::-1]
    levels, placed = [], leader == np.arange(topology.n)
    while placed.any():
        levels.append(np.flatnonzero(placed))
        known = np.concatenate(levels)
        placed = np.isin(leader, known)
        placed[known] = False
    return leader, levels


def settling_rate(time, values):
    """Return the rate [1/s] at which ``values`` (m,) decay until what stays of them is reached."""
    values = np.asarray(values)
    left = float(np.median(values[-max(1, len(values) // 10) :]))
    small = np.flatnonzero(values < SETTLED * left)
    end = max(1, small[0]) if len(small) else len(values)
    return decay_rate(time[:end], values[:end])


def first_rate(time, values):
    """Return the rate [1/s] at which ``values`` (m,) decay to a hundredth; None if they do not.

    Held commands couple separation and bearing a little: of what is left later, the slower decays.
    Raises ``NothingDecays`` for values that begin at zero.
    """
    if values[0] <= NEGLIGIBLE:
        raise NothingDecays
    small = np.flatnonzero(values < SMALL * values[0])
    if not len(small) or small[0] < FEWEST_FITTED:
        return None
    return slope(time[: small[0]], -np.log(values[: small[0]]))


def _published_path(control):
    """Return the control's path as ``on_path`` has it, a function of the way along it [m]."""
    corners = []
    if control.path == "polygon":
        pairs = control.waypoints.split(",")
        corners = [tuple(map(float, pair.split())) for pair in pairs]
    return functools.partial(on_path, control.path, control.radius, corners)


def _path_of(values):
    name = values["path"]
    waypoints = laws.read_waypoints(values["waypoints"]) if name == "polygon" else ()
    return laws.make_path(name, values["radius"], waypoints)
