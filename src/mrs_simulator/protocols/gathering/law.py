"""Gathering and spreading protocols, with what theory claims of their runs."""

import numpy as np

from mrs_simulator.control.array_law import flow_law
from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import (
    Claim,
    Condition,
    by_sample,
    centroid,
    converges_to,
    disagreement,
    invariant,
    rate,
    slope,
    stays_below,
)
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.kinematics import phase_of
from mrs_simulator.core.linear_theorem import Names, linear_theorem
from mrs_simulator.core.stability import Stability
from mrs_simulator.protocols.common import attracting, commands_by, falls, resting
from mrs_simulator.protocols.energies import laplacian_energy
from mrs_simulator.protocols.gathering import equations as gathering_equations
from mrs_simulator.protocols.gathering import published
from mrs_simulator.protocols.gathering.energies import coverage_energy, tension_energy
from mrs_simulator.protocols.linear_errors import LinearErrors
from mrs_simulator.protocols.marching.equations import read_waypoints
from mrs_simulator.protocols.published.laws import Averaging, weights_of

GAIN = Parameter("gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="gain of the law")
PRESENT = 1e-6  # [-] of the largest mode, below which a mode is not in the start
FLOOR = 1e-9  # [-] of the start, below which rounding is all there is
EXACT = {"point_mass": 1e-6, "kinematic": 0.02, "dynamic": 0.02}  # [-] of the team's size
HELD = {"point_mass": 1e-6, "kinematic": 0.005, "dynamic": 0.005}  # [-] of the gain, in a growth
ROUNDING = {"point_mass": 1e-6, "kinematic": 1e-4, "dynamic": 1e-3}  # [-] of a growth, by fidelity


class Containment(LinearErrors, PioneerControl):
    """Followers average over neighbours, the last robots stand: Ji and others, 2008.

    Theorem: if every follower receives from a leader, be it over others, the followers come to
    ``-L_ff^-1 L_fl p_l``, inside the convex hull of the leaders p_l, which stand; at the rate of the
    slowest eigenvalue of ``gain L_ff``.
    """

    PARAMETERS = (
        GAIN,
        Parameter(
            "leaders", 3, "", low=1, meaning="how many robots stand still: the last of the team"
        ),
    )

    DIMENSIONS = (2, 3)
    MEMORYLESS = True
    NAMES = Names(
        "distance from -L_ff^-1 L_fl p_l [m]", "", "decay rate of the followers' error [1/s]"
    )

    def published(self):
        n = len(self.numbers)
        return Averaging(weights_of(self.topology), self.gain, still=range(n - self.leaders, n))

    def checked_parameters(self, given):
        """Return all values; more leaders than robots are refused."""
        values = super().checked_parameters(given)
        if values["leaders"] > len(self.numbers):
            text = "leaders = {}: wanted at most the {} robots"
            raise ValueError(text.format(values["leaders"], len(self.numbers)))
        return values

    @flow_law
    def pointMassLaw(self):
        return gathering_equations.containment_flow(self.gain, self.topology, self.leaders)

    def targets(self, hand):
        """Return where the team ends, (n, d) [m]; None where some follower receives from no leader."""
        if not gathering_equations.all_reached_by_leaders(self.topology, self.leaders):
            return None
        leaders = hand[len(hand) - self.leaders :]
        return np.concatenate(
            [gathering_equations.containment_limit(leaders, self.topology), leaders]
        )

    def error_matrix(self):
        """Return ``gain L``, (n, n) [1/s], with zeros for the leaders."""
        matrix = self.gain * self.topology.laplacian()
        matrix[self.topology.n - self.leaders :] = 0.0
        return matrix

    def energy(self, start):
        """Return ``p^T L p/2`` with leaders that stand, over a directed graph the followers' errors'."""
        if self.topology.directed or self.gain <= 0.0:
            return super().energy(start)
        return laplacian_energy(self.topology, self.gain, standing=self.leaders)

    def claims(self, start):
        """Return the followers' limit, its place in the leaders' hull, and the rate of ``L_ff``."""
        decay, followers = self.theorem().held_rate(self.period), len(start) - self.leaders
        reached = gathering_equations.all_reached_by_leaders(self.topology, self.leaders)
        conditions = [
            Condition(
                "all hear a leader",
                reached,
                "some follower receives from no leader, not even over others",
                necessary=True,
            ),
            attracting(self.gain),
        ]
        if reached and followers:  # else there is an eigenvalue 0, whatever the gain
            why = "it is {:.3g}".format(np.exp(-decay * self.period))
            conditions.append(
                Condition("|1 - gain Tc lambda(L_ff)| < 1", decay > 0.0, why, necessary=True)
            )
        if not followers or not reached:
            return conditions
        corners, floor = start[followers:], resting(self, followers)

        def outside(run):
            return float(gathering_equations.outside_hull(run.hand[-1, :followers], corners).max())

        claims = self.consequences(start, floor=floor, free=False)
        hull = Claim("farthest out of the leaders' hull [m]", 0.0, 1e-3, outside, "at most")
        return [*conditions, *claims[:1], hull, *claims[1:]]


class Rendezvous(PioneerControl):
    """All meet and no edge of the start breaks: Ji and Egerstedt, 2007.

    Theorem: if robots closer than D make a connected graph at the start, no edge of it ever reaches D,
    and all robots meet in the mean of their places.
    """

    PARAMETERS = (
        GAIN._replace(
            default=0.2,
            unit="m/s",
            meaning="gain of every edge; the weight 2/D of short edges makes it gain 2/D [1/s]",
        ),
        Parameter(
            "radius",
            4.0,
            "m",
            **POSITIVE,
            meaning="D: robots closer than this at the start are neighbours for ever",
        ),
    )
    DIMENSIONS = (2, 3)
    KEEPS_CONNECTED = True
    TAKES_EDGES = False
    _pairs = None

    def published(self):
        return published.Rendezvous(self.gain, self.radius)

    def start(self):
        """Forget the edges of the start."""
        self._pairs = None

    def set_parameters(self, given):
        """Set the parameters; the robots within the radius now are neighbours from now on."""
        super().set_parameters(given)
        self.start()

    @flow_law
    def pointMassLaw(self, hand):
        if self._pairs is None:
            self._pairs = gathering_equations.pairs_within(hand, self.radius)
            self.topology = self._edges(self._pairs)
        return gathering_equations.rendezvous_flow(self.gain, self._pairs, self.radius)

    def _edges(self, pairs):
        return Topology(len(self.numbers), (pairs + 1).tolist(), directed=False)

    def energy(self, start):
        """Return the tension of the edges of the start, ``sum d^2/(D - d)``."""
        pairs = gathering_equations.pairs_within(start, self.radius)
        if self.gain <= 0.0 or not len(pairs):
            return None
        return tension_energy(pairs, self.radius, self.gain)

    def graph_at(self, start, hand):
        """Return the edges of the start that are still shorter than D."""
        pairs = gathering_equations.pairs_within(start, self.radius)
        first, second = pairs.T
        whole = np.linalg.norm(hand[first] - hand[second], axis=1) < self.radius
        return self._edges(pairs[whole])

    def claims(self, start):
        """Return claims: edges of the start stay below D, tension falls, all meet in the mean."""
        pairs = gathering_equations.pairs_within(start, self.radius)
        edges = self._edges(pairs)
        step = (
            self.gain
            * self.period
            * gathering_equations.tension_curvature(start, pairs, self.radius)
        )
        conditions = [
            Condition(
                "connected at the start",
                edges.has_spanning_tree(),
                "robots within {:g} m do not make one group".format(self.radius),
                necessary=True,
            ),
            attracting(self.gain),
            Condition(
                "gain Tc curvature of the tension < 2",
                bool(step < 2.0),
                "it is {:.3g}: one command may carry an edge past D".format(step),
            ),
        ]
        near = linear_theorem(self.gain * 2.0 / self.radius * edges.laplacian())

        def longest_edge(hand):
            return gathering_equations.edge_lengths(hand, pairs).max(axis=1, initial=0.0)

        claims = [
            stays_below(by_sample(longest_edge), self.radius, "longest edge of the start [m]"),
            *falls(self.energy(start), "growth of the edge tension [-]"),
            invariant(centroid, 1e-3, "drift of the mean [m]"),
            converges_to(start.mean(axis=0), 0.02, "distance from the mean [m]", free=True),
            rate(
                near.held_rate(self.period), disagreement, 0.02, "decay rate near agreement [1/s]"
            ),
        ]
        return conditions + claims


class CyclicPursuit(PioneerControl):
    """Each robot pursues the next at an angle: Marshall, Broucke and Francis, 2004.

    A law of the plane, in which the angle turns.

    Theorem: with n robots they spiral into one point if the angle is below ``pi/n``, go round a circle
    at ``pi/n``, and spiral out above; the centroid stays. Mode k is multiplied by ``exp(gain (e^(j a)
    (e^(2 pi j k/n) - 1)) t)``.
    """

    PARAMETERS = (
        GAIN._replace(default=0.1),
        Parameter(
            "angle",
            0.0,
            "rad",
            low=-np.pi,
            high=np.pi,
            meaning="a, left of the line of sight to the next robot; a circle at pi/n",
        ),
    )
    TAKES_EDGES = False
    MEMORYLESS = True

    def published(self):
        return published.Pursuit(self.gain, self.angle)

    @flow_law
    def pointMassLaw(self):
        return gathering_equations.pursuit_flow(self.gain, len(self.numbers), self.angle)

    def claims(self, start):
        """Return growth and turn rate of the slowest mode of the start; in, circle or out."""
        n = len(start)
        conditions = [Condition("two robots", n > 1, "none to pursue")]
        modes = np.abs(gathering_equations.pursuit_modes(start)[1:])
        if n < 2 or not modes.any():
            return conditions
        step = np.where(modes > PRESENT * modes.max(), self._factors(n)[1:], 0.0)
        slowest = 1 + int(np.argmax(np.abs(step)))
        exponent = complex(np.log(step[slowest - 1]) / self.period)
        growth, turn = exponent.real, exponent.imag
        # Points on a circle spiral out a little under held commands, robots less: they move on arcs.
        held = HELD[self.fidelity] * abs(self.gain)
        allowed, swayed = (max(0.02 * abs(value), held) for value in (growth, turn))

        def grows(run):
            amplitude = np.abs(gathering_equations.pursuit_modes(run.hand)[:, slowest])
            return _late_growth(run.time, amplitude)

        def turns(run):
            phase = np.unwrap(phase_of(gathering_equations.pursuit_modes(run.hand)[:, slowest]))
            return slope(run.time, phase)

        return conditions + [
            Claim("growth rate of the slowest mode [1/s]", growth, allowed, grows, free=True),
            Claim("turn rate of the slowest mode [rad/s]", turn, swayed, turns, free=True),
            invariant(centroid, 0.02, "drift of the centroid [m]"),
            Claim(
                "distance from the exact solution [-]",
                0.0,
                EXACT[self.fidelity],
                self._off,
                free=True,
            ),
        ]

    def _off(self, run):
        """Return the largest distance from the exact solution at the end as a share of the team's size."""
        exact = self.prediction(run.hand[0], run.time[-1:] - run.time[0])
        size = max(disagreement(exact)[0], FLOOR * disagreement(run.hand[:1])[0])
        return float(np.linalg.norm(run.hand[-1] - exact[0], axis=1).max() / size)

    def prediction(self, start, time):
        """Return the exact solution under held inputs, (m, n, 2) [m], at ``time`` (m,) [s]."""
        factors = self._factors(len(start)) ** commands_by(time, self.period)[:, np.newaxis]
        return gathering_equations.points_of_modes(
            gathering_equations.pursuit_modes(start) * factors
        )

    def stability(self, start):
        """Return how far the angle is from ``pi/n``; None at a gain that drives robots away."""
        if len(start) < 2 or self.links.faults or self.gain <= 0.0:
            return None
        return Stability(r"$a = \pi/n$", 1.0 - abs(self.angle) * len(start) / np.pi)

    def _factors(self, n):
        """Return by what one command multiplies each mode, (n,) complex."""
        return 1.0 + self.period * self.gain * gathering_equations.pursuit_eigenvalues(
            n, self.angle
        )


class Coverage(PioneerControl):
    """Each robot goes to the centroid of its Voronoi cell: Cortes, Martinez, Karatas, Bullo, 2004.

    A law of the plane, over a square or a polygon within it.  Where corners turn inwards, a centroid may
    lie outside.

    Theorem: the locational cost ``sum int_(V_i) |q - p_i|^2 dq`` never grows, and the robots come to a
    centroidal Voronoi configuration: each to the centroid of its own cell.
    """

    PARAMETERS = (
        GAIN,
        Parameter(
            "side",
            20.0,
            "m",
            **POSITIVE,
            meaning="of the square about the origin that is to be covered",
        ),
        Parameter(
            "density",
            "uniform",
            choices=("uniform", "gaussian"),
            meaning="how much each place matters",
        ),
        Parameter("centre_x", 0.0, "m", meaning="of the gaussian density"),
        Parameter("centre_y", 0.0, "m", meaning="of the gaussian density"),
        Parameter(
            "width",
            5.0,
            "m",
            low=0.1,
            meaning="standard deviation of the gaussian density",
            why="a narrower one lies between the samples",
        ),
        Parameter(
            "samples",
            60,
            "",
            low=5,
            high=500,
            meaning="points of the grid along a side of the square",
        ),
        Parameter(
            "polygon",
            "",
            "m",
            meaning="corners of the part of the square that is to be covered, such as a bay; empty: all",
        ),
    )
    TAKES_EDGES = False
    MEMORYLESS = True

    def published(self):
        def weight(x, y):
            away = (x - self.centre_x) ** 2 + (y - self.centre_y) ** 2
            density = np.exp(-0.5 * away / self.width**2) if self.density == "gaussian" else 1.0
            return density * self._are_inside(x + 1.0j * y)

        return published.Coverage(self.gain, self.side, self.samples, weight)

    def _are_inside(self, places):
        """Return whether the polygon's corners go round ``places`` (m,), complex [m], by the angles they
        turn."""
        if not self.polygon:
            return np.ones(len(places), dtype=bool)
        corners = read_waypoints(self.polygon) @ [1.0, 1.0j] - places[:, np.newaxis]
        turned = phase_of(np.roll(corners, -1, axis=1) / corners).sum(axis=1)
        return np.abs(turned) > np.pi

    def set_parameters(self, given):
        """Set the parameters and lay out the grid."""
        super().set_parameters(given)
        self._samples = gathering_equations.square_samples(self.side, self.samples)
        self._density = np.ones(len(self._samples))
        if self.density == "gaussian":
            middle = (self.centre_x, self.centre_y)
            self._density = gathering_equations.gaussian_density(self._samples, middle, self.width)
        if self.polygon:
            corners = read_waypoints(self.polygon)
            self._density = self._density * gathering_equations.inside(self._samples, corners)

    def checked_parameters(self, given):
        """Return all values; a density that is zero all over the square is refused."""
        values = super().checked_parameters(given)
        away = max(abs(values["centre_x"]), abs(values["centre_y"])) - 0.5 * values["side"]
        if values["density"] == "gaussian" and away > 5.0 * values["width"]:
            text = "centre_x, centre_y = {:g}, {:g}: wanted within 5 widths of the square"
            raise ValueError(text.format(values["centre_x"], values["centre_y"]))
        if values["polygon"]:
            corners, half = read_waypoints(values["polygon"]), 0.5 * values["side"]
            samples = gathering_equations.square_samples(values["side"], values["samples"])
            if (
                np.abs(corners).max() > half
                or not gathering_equations.inside(samples, corners).any()
            ):
                raise ValueError(
                    "polygon = {!r}: wanted corners within {:g} m of x = 0 and of y = 0, about samples of "
                    "the square".format(values["polygon"], half)
                )
        return values

    def pointMassLaw(self, hand):
        return self.gain * gathering_equations.coverage(hand, self._samples, self._density)

    def targets(self, hand):
        """Return the cells' centroids ``C_i``, (n, 2) [m]."""
        return gathering_equations.cell_centroids(hand, self._samples, self._density)

    def cost(self, hand):
        """Return the locational cost of each of ``hand`` (m, n, 2), (m,) [m^2]."""
        return self._cost().values(hand)

    def energy(self, start):
        """Return the locational cost."""
        return self._cost() if self.gain > 0.0 else None

    def _cost(self):
        return coverage_energy(self._samples, self._density, self.gain)

    def claims(self, start):
        """Return claims: the cost never grows; each robot ends at its centroid."""
        conditions = [
            attracting(self.gain, "robots are driven away"),
            Condition(
                "gain Tc < 2",
                self.gain * self.period < 2.0,
                "it is {:.3g}".format(self.gain * self.period),
            ),
        ]

        def from_centroid(run):
            last = run.hand[-1]
            return float(np.linalg.norm(self.targets(last) - last, axis=1).max())

        def out_of_square(hand):
            return np.abs(hand).max(axis=(1, 2)) - 0.5 * self.side

        claims = [
            *falls(
                self.energy(start), "growth of the locational cost [-]", ROUNDING[self.fidelity]
            ),
            Claim("distance from the own centroid [m]", 0.0, 0.05, from_centroid),
        ]
        if out_of_square(start[np.newaxis]) <= 0.0:
            claims.append(stays_below(out_of_square, 0.0, "farthest out of the square [m]", 0.01))
        return conditions + claims

    def measures(self, run):
        """Return the locational cost at the start and at the end [m^2]."""
        first, last = self.cost(run.hand[[0, -1]]).tolist()
        return {"cost_at_start": first, "cost_at_end": last}


def _late_growth(time, values):
    """Return the growth rate [1/s] of ``values`` (m,) over the later half of what is not rounding."""
    kept = np.flatnonzero(values > FLOOR * values[0])
    kept = kept[len(kept) // 2 :]
    if len(kept) < 3:
        return None
    return slope(time[kept], np.log(values[kept]))
