"""Flocking protocols, with what theory claims of their runs; all but Vicsek's also in space."""

import copy

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Claim, Condition, TooShort
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.neighbours import least_distance
from mrs_simulator.protocols.common import attracting, below, level
from mrs_simulator.protocols.flocking import equations as flocking_equations
from mrs_simulator.protocols.flocking import published
from mrs_simulator.protocols.flocking.energies import agreement_energy, flock_energy
from mrs_simulator.protocols.flocking.published import (
    AlphaGamma,
    Boids,
    Headings,
    random_directions,
)

SEED = Parameter("seed", 0, "", low=0, meaning="of the random numbers: the same ones, the same run")
RADIUS = Parameter("radius", 3.0, "m", **POSITIVE, meaning="robots closer than this are neighbours")
# A command is held for a period: a step of that length may add this share of the start.
ENERGY = {"point_mass": 1e-6, "kinematic": 1e-4, "dynamic": 1e-3}  # [-]
FLOOR = 1e-9  # [-] of the start, below which rounding is all there is
RESOLVED = 1e-6  # [-] of the start, above which a decay from command to command shows
FASTEST = "decay of velocities over its bound [-]"
STATISTICS = 0.05  # [-] by which a mean over ``FEWEST`` commands may differ
FEWEST = 100


class DoubleIntegrator(PioneerControl):
    """A law that gives accelerations; the velocity commanded is their sum."""

    DIMENSIONS = (2, 3)
    TAKES_EDGES = False
    _velocity = None

    def start(self):
        """Begin with the velocities of the start again."""
        self._velocity = None

    def first_velocity(self, n):
        """Return the velocities (n, d) [m/s] of the n robots at the start."""
        return np.zeros((n, self.dimension))

    def accelerations(self, hand, velocity):
        """Return the accelerations (n, d) [m/s^2] at ``hand`` (n, d) [m] and ``velocity`` (n, d)."""
        raise NotImplementedError

    def pointMassLaw(self, hand):
        """Return the hand points' velocities, (n, d) [m/s]: one period of acceleration further."""
        if self._velocity is None:
            self.begin(hand)
        self._velocity = self._velocity + self.period * self.accelerations(hand, self._velocity)
        return self._velocity

    def begin(self, hand):
        """Remember what the law needs of the start ``hand`` (n, d)."""
        self._velocity = self.first_velocity(len(hand))


class Flocking(DoubleIntegrator):
    """Algorithm 2: keep a distance, agree on velocity, follow a virtual leader: Olfati-Saber, 2006.

    Theorem: the energy ``sum psi + c1 |p - p_r|^2/2 + |v - v_r|^2/2`` never grows, so that no robot
    leaves a ball about the virtual leader, and all velocities come to the leader's.
    """

    PARAMETERS = (
        Parameter("distance", 2.0, "m", **POSITIVE, meaning="d, wanted between neighbours"),
        Parameter("reach", 2.8, "m", **POSITIVE, meaning="r, that of a neighbour"),
        Parameter(
            "strength", 1.0, "m/s^2", **POSITIVE, high=100.0, meaning="a = b of the pair force"
        ),
        Parameter("alignment", 1.0, "1/s", low=-10.0, high=100.0, meaning="with the neighbours"),
        Parameter("c1", 0.1, "1/s^2", low=-10.0, high=100.0, meaning="pull to the virtual leader"),
        Parameter("c2", 0.6, "1/s", low=-10.0, high=100.0, meaning="towards its velocity"),
        Parameter("leader_vx", 0.4, "m/s", meaning="velocity of the virtual leader"),
        Parameter("leader_vy", 0.0, "m/s", meaning="velocity of the virtual leader"),
        Parameter("start_speed", 0.3, "m/s", low=0.0, meaning="of the robots at the start"),
        SEED,
    )

    def published(self):
        n, leader = len(self.numbers), level([self.leader_vx, self.leader_vy], self.dimension)
        first = random_directions(self.seed, n, self.start_speed, self.dimension)
        return AlphaGamma(
            first, self.period, self.distance, self.reach, self.strength, self.alignment, self.c1,
            self.c2, leader,
        )  # fmt: skip

    def checked_parameters(self, given):
        """Return all values; a range within the wanted distance is refused."""
        values = super().checked_parameters(given)
        if values["reach"] <= values["distance"]:
            text = "reach = {:g}: wanted above the distance {:g} m"
            raise ValueError(text.format(values["reach"], values["distance"]))
        return values

    def set_parameters(self, given):
        super().set_parameters(given)
        self._lattice = flocking_equations.Lattice(
            self.distance, self.reach, self.strength, self.strength
        )

    def first_velocity(self, n):
        """Return ``start_speed`` in random directions, (n, d) [m/s]."""
        return self.start_speed * drawn_directions(self.seed, n, self.dimension)

    def begin(self, hand):
        """The virtual leader starts in the middle of the team."""
        super().begin(hand)
        self._middle = hand.mean(axis=0)

    def accelerations(self, hand, velocity):
        """Return the accelerations of algorithm 2, (n, d) [m/s^2]."""
        leader = self._leader(self._middle, self.time)
        return flocking_equations.flocking(
            hand, velocity, self._lattice, self.alignment, leader, self.c1, self.c2
        )

    def _leader(self, middle, time):
        velocity = level([self.leader_vx, self.leader_vy], self.dimension)
        return np.stack([middle + time * velocity, velocity])

    def energy(self, start):
        """Return the flock's energy about the virtual leader."""
        if min(self.alignment, self.c1, self.c2) <= 0.0:
            return None
        leader = level([self.leader_vx, self.leader_vy], self.dimension)
        return flock_energy(self, start.mean(axis=0), leader)

    def claims(self, start):
        """Return claims: energy falls, velocities converge to the leader's, the flock stays near it."""
        gains = {name: getattr(self, name) for name in ("alignment", "c1", "c2")}
        wrong = ", ".join(name for name, gain in gains.items() if gain <= 0.0)
        conditions = [Condition("gains above 0", not wrong, wrong + " is not")]
        if wrong:
            return conditions
        held = flocking_equations.held_flock(
            len(start), self._lattice, self.alignment, self.c1, self.c2, self.period
        )
        conditions.append(below("Tc (c^2 + k)/(2 c) of all modes < 1", held, 1.0))
        middle, moving = start.mean(axis=0), self._leader(start[0], 0.0)[1]

        def energy(hand, velocity, time):
            leader = self._leader(middle, time)
            return flocking_equations.flocking_energy(
                hand, velocity, self._lattice, leader, self.c1
            )

        def growth(run):
            # Of points at the next command, until which the velocity is held.
            held, time = self.velocities(run), run.time - run.time[0] + self.period
            rows = zip(run.hand + self.period * held, held, time)
            values = np.array([energy(*row) for row in rows])
            return float(np.diff(values).max(initial=0.0) / values[0])

        def farthest(run):
            leader = middle + (run.time - run.time[0])[:, np.newaxis] * moving
            return float(np.linalg.norm(run.hand - leader[:, np.newaxis], axis=2).max())

        def slip(run):
            return float(np.linalg.norm(self.velocities(run)[-1] - moving, axis=1).max())

        begin = energy(start, self.first_velocity(len(start)), 0.0)
        ball, allowed = float(np.sqrt(2.0 * begin / self.c1)), ENERGY[self.fidelity]
        return [
            *conditions,
            Claim("velocity differs from the leader's [m/s]", 0.0, 0.02, slip),
            Claim("growth of the energy [-]", 0.0, allowed, growth, "at most", True),
            Claim("farthest from the leader [m]", ball, 0.0, farthest, "at most", True),
        ]

    def graph_at(self, start, hand):
        """Return the graph of all within the reach of each other."""
        return Topology.proximity(hand, self.reach)

    def measures(self, run):
        """Return order and least distance of the flock, and into how many groups it ever split.

        That a flock keeps together was seen by Olfati-Saber in simulations, not proved.
        """
        return dict(
            flock_measures(self, run),
            most_groups=max(flocking_equations.groups(hand, self.reach) for hand in run.hand),
        )


class CuckerSmale(DoubleIntegrator):
    """Velocities agree, over all distances, the less the farther: Cucker and Smale, 2007.

    Theorem: for ``beta <= 1/2``, or a start that is slow enough, velocities agree exponentially at
    their mean, which is kept, and the flock's diameter stays bounded. They agree at no less than gain times
    the weight of the largest distance, and at no more than that of the least.
    """

    PARAMETERS = (
        Parameter("gain", 1.0, "1/s", low=-10.0, high=100.0, meaning="K, of the agreement"),
        Parameter("beta", 0.4, "", low=0.0, high=5.0, meaning="how fast it falls with distance"),
        Parameter("reach", 1.0, "m", **POSITIVE, meaning="distance from which on it falls"),
        Parameter("drift", 0.4, "m/s", meaning="common velocity at the start, along the x axis"),
        Parameter("start_speed", 0.5, "m/s", low=0.0, meaning="of each robot besides that"),
        SEED,
    )

    def published(self):
        n = len(self.numbers)
        first = random_directions(self.seed, n, self.start_speed, self.dimension)
        first[:, 0] += self.drift
        return published.CuckerSmale(first, self.period, self.gain, self.beta, self.reach)

    def energy(self, start):
        """Return ``sum |v_i - mean v|^2/2``."""
        return agreement_energy(self.gain, self.beta, self.reach) if self.gain > 0.0 else None

    _first = None  # [m/s] velocities that are known, of a run that begins in motion

    def resumed(self, time, memory):
        """Return the law that begins with the velocities in ``memory``."""
        rest = copy.copy(self)
        rest._first = memory[0]
        return rest

    def first_velocity(self, n):
        """Return the drift and ``start_speed`` in random directions, (n, d) [m/s]."""
        if self._first is not None:
            return self._first
        own = self.start_speed * drawn_directions(self.seed, n, self.dimension)
        return own + level([self.drift, 0.0], self.dimension)

    def accelerations(self, hand, velocity):
        return self.gain * flocking_equations.cucker_smale(hand, velocity, self.beta, self.reach)

    def claims(self, start):
        """Return that the spread of velocities falls at least as fast, and the flock grows no
        larger, than theory bounds, and that the mean velocity stays."""
        first = self.first_velocity(len(start))
        size, spread = flocking_equations.diameter(start), flocking_equations.diameter(first)
        conditions = [
            attracting(self.gain, "velocities are driven apart"),
            Condition(
                "gain Tc < 1",
                self.gain * self.period < 1.0,
                "it is {:.3g}".format(self.gain * self.period),
            ),
        ]
        if not conditions[0].holds:
            return conditions
        bound = flocking_equations.flock_bound(size, spread, self.gain, self.beta, self.reach)
        conditions.append(
            Condition(
                "beta <= 1/2 or a slow start",
                self.beta <= 0.5 or bool(np.isfinite(bound)),
                "beta is {:g} and velocities differ by {:.3g} m/s".format(self.beta, spread),
            )
        )
        slowest = self.gain * float(flocking_equations.communication(bound, self.beta, self.reach))

        def over_bound(run):
            allowed = np.exp(-slowest * (run.time - run.time[0]))
            ratio = self._spreads(run) / spread / np.maximum(allowed, FLOOR)
            return float(np.max(ratio[1:], initial=0.0))  # the first is 1 by construction

        def sizes(run):
            return max(flocking_equations.diameter(hand) for hand in run.hand)

        def drift(run):
            mean = self.velocities(run).mean(axis=1)
            return float(np.linalg.norm(mean - first.mean(axis=0), axis=1).max())

        claims = [
            Claim("drift of the mean velocity [m/s]", 0.0, 1e-6, drift, free=True),
            Claim(
                "growth of the velocity spread [-]",
                0.0,
                1e-9,
                lambda run: float(np.diff(self._spreads(run)).max(initial=0.0)),
                "at most",
                True,
            ),
        ]
        if spread > 0.0:
            claims += [
                Claim("velocity spread over its bound [-]", 1.0, 1e-6, over_bound, "at most", True),
                Claim(FASTEST, 1.0, 1e-6, self._fastest, "at most", True),
                Claim("largest diameter of the flock [m]", bound, 1e-6, sizes, "at most", True),
            ]
        return conditions + [claim for claim in claims if np.isfinite(claim.predicted)]

    def _spreads(self, run):
        return np.array([flocking_equations.diameter(v) for v in self.velocities(run)])

    def _fastest(self, run):
        """Return the largest rate [-] at which velocities agree, over that of the least distance."""
        velocities, time = self.velocities(run), run.time
        apart = np.linalg.norm(velocities - velocities.mean(axis=1, keepdims=True), axis=(1, 2))
        kept = np.flatnonzero(apart[1:] > RESOLVED * apart[0])
        step = np.diff(time)[kept]
        # Until the next sample two robots come nearer by what their velocities differ at most.
        nearest = np.array([least_distance(hand) for hand in run.hand])[kept]
        nearest = np.maximum(nearest - step * self._spreads(run)[kept], 0.0)
        weight = flocking_equations.communication(nearest, self.beta, self.reach)
        commands = np.rint(step / self.period)
        allowed = -commands * np.log1p(-self.gain * self.period * weight)
        return float(np.max(np.log(apart[kept] / apart[kept + 1]) / allowed, initial=0.0))

    def measures(self, run):
        """Return order and least distance of the flock, and the spread of velocities [m/s]."""
        first, last = self.velocities(run)[[0, -1]]
        spread = {
            "velocity_spread_at_start": flocking_equations.diameter(first),
            "velocity_spread_at_end": flocking_equations.diameter(last),
        }
        return dict(flock_measures(self, run), **spread)


class Vicsek(PioneerControl):
    """Constant speed, the mean heading of the neighbours and noise: Vicsek and others, 1995.

    One update for each command: the rate of commands is the model's clock.  A law of the plane: its
    headings and their noise are angles.

    Theorem: no convergence is claimed. While all robots receive from all, the mean square of the order is
    ``s^2 + (1 - s^2)/n`` with ``s = sin(eta/2)/(eta/2)``; where they receive from fewer it is at most that.
    """

    PARAMETERS = (
        RADIUS,
        Parameter("speed", 0.3, "m/s", **POSITIVE, meaning="of every robot"),
        Parameter(
            "noise",
            0.5,
            "rad",
            low=0.0,
            high=2.0 * np.pi,
            meaning="eta: each heading is disturbed by up to half of it, either way, at each command",
        ),
        SEED,
    )
    TAKES_EDGES = False
    _headings = None

    def published(self):
        """Return the law as published, with the noise of this seed."""
        n = len(self.numbers)
        return Headings(n, self.radius, self.speed, self.noise, self.seed, self.period)

    def start(self):
        """Begin with the headings and the random numbers of the start again."""
        self._headings = None

    def pointMassLaw(self, hand):
        if self._headings is None:
            self._draw = np.random.default_rng(self.seed)
            self._headings = self._draw.uniform(-np.pi, np.pi, len(hand))
        disturbance = self._draw.uniform(-0.5 * self.noise, 0.5 * self.noise, len(hand))
        self._headings = self.update(hand, disturbance)
        return self.speed * directions(self._headings)

    def update(self, hand, disturbance):
        """Return the new headings, (n,) [rad]."""
        return flocking_equations.vicsek(hand, self._headings, self.radius, disturbance)

    def graph_at(self, start, hand):
        """Return the graph of all within the radius of each other."""
        return Topology.proximity(hand, self.radius)

    def claims(self, start):
        """Return the bound on the order parameter, its exact mean where all hear all."""
        wanted = flocking_equations.vicsek_order(self.noise, len(start))

        def root_mean_square(run, samples=None):
            values = flocking_equations.order(self.velocities(run)[:samples])
            return float(np.sqrt(np.mean(values**2)))

        def while_all_hear_all(run):
            wide = [flocking_equations.diameter(hand) >= self.radius for hand in run.hand]
            end = wide.index(True) if any(wide) else len(wide)
            if run.time[end - 1] - run.time[0] < (FEWEST - 1.5) * self.period:
                text = "too short for a mean while all hear all: wanted {:.3g} s"
                raise TooShort(text.format(FEWEST * self.period))
            return root_mean_square(run, end)

        claims = [
            Claim(
                "root mean square order [-]", wanted, STATISTICS, root_mean_square, "at most", True
            )
        ]
        if flocking_equations.diameter(start) < self.radius:
            name = "the same while all hear all [-]"
            claims.append(Claim(name, wanted, STATISTICS, while_all_hear_all, free=True))
        return claims

    def measures(self, run):
        """Return order and least distance of the flock."""
        return flock_measures(self, run)


class Reynolds(DoubleIntegrator):
    """Separation, alignment and cohesion: Reynolds, 1987.

    Theorem: none is known; the run is measured, and its commands are held to the published law.
    """

    PARAMETERS = (
        RADIUS._replace(default=5.0),
        Parameter(
            "separation", 1.0, "m^2/s^2", low=-10.0, high=100.0, meaning="away from neighbours"
        ),
        Parameter("alignment", 0.5, "1/s", low=-10.0, high=100.0, meaning="with their velocity"),
        Parameter("cohesion", 0.1, "1/s^2", low=-10.0, high=100.0, meaning="towards their middle"),
        Parameter("speed", 0.5, "m/s", **POSITIVE, meaning="the highest; half the lowest"),
        SEED,
    )

    def published(self):
        """Return the law in the form that ``flocking_equations.reynolds`` documents."""
        first = random_directions(self.seed, len(self.numbers), self.speed, self.dimension)
        gains = (self.separation, self.alignment, self.cohesion)
        return Boids(first, self.period, self.radius, gains, self.speed)

    def first_velocity(self, n):
        """Return ``speed`` in random directions, (n, d) [m/s]."""
        return self.speed * drawn_directions(self.seed, n, self.dimension)

    def accelerations(self, hand, velocity):
        """Return the accelerations of the three rules, (n, d) [m/s^2]."""
        return flocking_equations.reynolds(
            hand, velocity, self.radius, self.separation, self.alignment, self.cohesion
        )

    def pointMassLaw(self, hand):
        """Return the hand points' velocities, (n, d) [m/s], at no less than half the speed."""
        free = super().pointMassLaw(hand)
        self._velocity = flocking_equations.within_speeds(free, 0.5 * self.speed, self.speed)
        return self._velocity

    def graph_at(self, start, hand):
        """Return the graph of all within the radius of each other."""
        return Topology.proximity(hand, self.radius)

    def measures(self, run):
        """Return order and least distance of the flock."""
        return flock_measures(self, run)


def flock_measures(control, run):
    """Return the order parameter at start and end, and the least distance [m] of two hand points."""
    first, last = flocking_equations.order(control.velocities(run)[[0, -1]]).tolist()
    least = min(least_distance(hand) for hand in run.hand)
    found = {"order_at_start": first, "order_at_end": last}
    return dict(found, least_distance=least if np.isfinite(least) else None)


def drawn_directions(seed, n, dimension):
    """Return n unit vectors (n, d) drawn from all directions alike."""
    draw = np.random.default_rng(seed)
    if dimension == 2:
        return directions(draw.uniform(-np.pi, np.pi, n))
    drawn = draw.standard_normal((n, dimension))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def directions(headings):
    """Return the unit vectors (n, 2) along ``headings`` (n,) [rad]."""
    return np.stack([np.cos(headings), np.sin(headings)], axis=1)
