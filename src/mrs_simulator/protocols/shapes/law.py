"""Formations given by displacements, distances or bearings, with what theory claims of their runs."""

from typing import NamedTuple

import numpy as np

from mrs_simulator.control.array_law import flow_law, of_samples
from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import (
    NEGLIGIBLE,
    RATE_FLOOR,
    Claim,
    Condition,
    by_sample,
    centroid,
    converges_to,
    decay_rate,
    ends_at,
    invariant,
    rate,
)
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.linear_theorem import NAMES, Accuracy, linear_theorem
from mrs_simulator.core.spectra import (
    is_infinitesimally_bearing_rigid,
    is_infinitesimally_rigid,
    laplacian_eigenvalues,
    left_null_vector,
    rigid_rank,
)
from mrs_simulator.protocols.common import all_hold, falls, gain_conditions, resting, spanning_tree
from mrs_simulator.protocols.consensus.over_links import AveragingLaw
from mrs_simulator.protocols.linear_errors import LinearErrors
from mrs_simulator.protocols.published.laws import Averaging, shape_of, weights_of
from mrs_simulator.protocols.shapes import equations as laws
from mrs_simulator.protocols.shapes.energies import bearing_energy, length_energy
from mrs_simulator.protocols.shapes.published import Bearings, BearingsWithLeaders, Distances

LEADERS = 2  # [-] robots that stand still under the law of bearings with leaders
FLAT = 1e-6  # [m] of a singular value of points, below which they lie in fewer dimensions
FAR = 1e-3  # [-] by which a bearing between leaders may be off
RIGID = 1e-6  # [-] of the largest eigenvalue, below which a mode leaves lengths as they are
# [-] of the squares of lengths, by which they may be off where modes decay one by one
LINEAR = 1e-2
AT_REST = 1e-3  # [-] of the edges' terms, of which less is left where they cancel
MOST_BEFORE = 100  # [-] commands until the potential may have fallen far enough
TURNED = 2.0  # [-] of a mode's size, by which it grows again only where others feed it
ALIKE = 1e-6  # [-] by which eigenvalues of one mode may differ

GAIN = Parameter("gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="gain of every edge")
SHAPE = Parameter("shape", "circle", choices=laws.SHAPES, meaning="the formation's shape")
SIZE = Parameter("size", 3.0, "m", **POSITIVE, high=1e3, meaning="from one robot to the next")


class Tolerances(NamedTuple):
    """How far a run may be from theory, by what moves the robots.

    On full dynamics: what slip may cost at most.  The worst of the shipped runs, for each: 0.11 m, 0.12 m,
    0.036 m, 0.025 and 0.01.
    """

    place: float  # [m] of a limit or a path, which slip at the start may move
    drift: float  # [m] of an invariant
    rest: float  # [m], [rad] of what is zero at the end, wherever that is
    share: float  # [-] of a bearing, a scale
    rate: float  # [-]


TOLERANCES = {
    "point_mass": Tolerances(0.01, 1e-6, 0.01, 0.01, 0.02),
    "kinematic": Tolerances(0.05, 0.05, 0.05, 0.02, 0.02),
    "dynamic": Tolerances(0.15, 0.15, 0.05, 0.05, 0.02),
}


class Shaped(PioneerControl):
    """What the laws share that take a shape: its parameters and places."""

    PARAMETERS = (GAIN, SHAPE, SIZE)
    DIMENSIONS = (2, 3)
    MEMORYLESS = True

    def published_places(self):
        """Return where the robots stand in the shape, (n, d) [m], reckoned independently."""
        return shape_of(self.shape, len(self.numbers), self.size, self.dimension)

    def set_parameters(self, given):
        super().set_parameters(given)
        n = len(self.numbers)
        self._places = laws.shape_places(self.shape, n, self.size, self.dimension)

    def places(self):
        """Return where the robots stand in the shape, (n, d) [m], about the origin."""
        return self._places

    @property
    def tolerance(self):
        """Return the ``Tolerances`` for what moves the robots."""
        return TOLERANCES[self.fidelity]

    @property
    def accuracy(self):
        """Return of these what a linear theorem asks for, ``Accuracy``."""
        allowed = self.tolerance
        return Accuracy(allowed.place, allowed.drift, allowed.rate)


def without_rates(claims, fidelity):
    """Return ``claims``, on full dynamics without rates: friction leaves millimetres that never decay."""
    return [
        claim for claim in claims if fidelity != "dynamic" or not claim.name.startswith("decay")
    ]


def undirected(topology):
    """Return the condition that robots receive from each other with the same weight."""
    adjacency = topology.adjacency()
    holds = bool(np.allclose(adjacency, adjacency.T))
    return Condition(
        "undirected graph", holds, "some robot does not receive from one to which it sends"
    )


def rigid(places, topology):
    """Return the condition that lengths fix the target: infinitesimally rigid.

    That takes 2n - 3 edges in the plane, 3n - 6 in space.
    """
    pairs = linked_pairs(topology)
    wanted = rigid_rank(*places.shape)
    return _fixed(len(places) > 1 and is_infinitesimally_rigid(places, pairs), pairs, wanted)


def rigid_by_bearings(places, topology):
    """Return the condition that bearings fix the target but for its place and size.

    Each edge fixes d - 1 of the d n - d - 1 numbers that are left.
    """
    pairs, (n, d) = linked_pairs(topology), places.shape
    wanted = -((d + 1 - d * n) // (d - 1))
    return _fixed(n > 1 and is_infinitesimally_bearing_rigid(places, pairs), pairs, wanted)


def linked_pairs(topology):
    """Return the pairs (i, j) of rows, i < j, of which one receives from the other."""
    receiver, sender, _ = topology.arcs
    return sorted({(min(pair), max(pair)) for pair in zip(receiver.tolist(), sender.tolist())})


def _fixed(holds, pairs, wanted):
    why = "{} edges, wanted at least {}".format(len(pairs), wanted)
    if len(pairs) >= wanted:
        why = "{} edges, but the shape still bends to first order".format(len(pairs))
    return Condition("rigid target", bool(holds), why)


def spread_as(places, start):
    """Return the condition that ``start`` spans as many dimensions as ``places`` (n, d), or more.

    Robots on one line stay on it under the gradient of lengths, and in space those of one plane in it.
    """
    wanted, have = (np.linalg.svd(p - p.mean(axis=0), compute_uv=False) for p in (places, start))
    dimensions = int(np.count_nonzero(wanted > FLAT))
    held = ("at one place", "at one place", "on one line", "in one plane")[dimensions]
    spread = not dimensions or have[dimensions - 1] > FLAT
    return Condition("start not " + held, bool(spread), "robots would stay on it", necessary=True)


class DisplacementFormation(AveragingLaw, Shaped):
    """``u_i = gain sum_j a_ij (p_j - p_i - (d_j - d_i))``: Oh, Park, Ahn, 2015.

    Theorem: over a graph with a spanning tree the robots take the shape d, at the place where ``w^T p``
    has been from the start; on an undirected graph that is their centroid. The error decays at ``gain
    lambda_2``. Held commands ask for ``|1 - gain Tc mu| < 1``.
    """

    NAMES = NAMES._replace(limit="distance from d + w^T (p(0) - d) [m]", kept="drift of w^T p [m]")

    def published(self):
        return Averaging(weights_of(self.topology), self.gain, self.published_places())

    @flow_law
    def pointMassLaw(self):
        return laws.displacement_flow(self.gain, self.places(), self.topology)

    @of_samples
    def targets(self, hand):
        """Return ``d + w^T (hand - d)``, (n, d) [m]: where the law ends from here."""
        if not self.topology.has_spanning_tree():
            return None
        places = self.places()
        return places + (left_null_vector(self.topology) @ (hand - places))[..., np.newaxis, :]

    def reference(self, time):
        """Return the places of the shape, (n, d) [m]."""
        return self.places()

    def claims(self, start):
        """Return limit, invariant and rate: ``w^T p`` is kept, errors decay at ``lambda_2``."""
        conditions = [spanning_tree(self.topology)]
        if not all_hold(conditions):
            return conditions
        conditions += gain_conditions(self.gain, self.period, laplacian_eigenvalues(self.topology))
        floor = resting(self, len(start))
        return [
            *conditions,
            displacement_error(self.places(), self.topology, self.tolerance.rest),
            *self.consequences(start, self.accuracy, floor=floor),
        ]

    def claims_over_links(self, start):
        """Return what :class:`Consensus` does, of the errors ``p - d``."""
        claims = super().claims_over_links(start)
        return claims if claims is None else without_rates(claims, self.fidelity)

    def over_links(self):
        return super().over_links()._replace(place=self.tolerance.place, share=self.tolerance.rate)


def displacement_error(places, topology, tolerance):
    """Claim that the run ends with all displacements between neighbours as in ``places`` (n, d)."""
    receiver, sender, _ = topology.arcs

    def worst(hand):
        away = hand - places
        return np.linalg.norm(away[:, receiver] - away[:, sender], axis=2).max(axis=1, initial=0.0)

    return ends_at(worst, 0.0, tolerance, "worst displacement error at the end [m]")


class DistanceFormation(Shaped):
    """``u_i = -gain sum_j a_ij (|p_ij|^2 - d_ij^2) p_ij``: Krick, Broucke, Francis, 2009.

    Theorem: if the wanted shape is infinitesimally rigid, robots that start near enough to it reach its
    lengths, exponentially; the centroid stays, and the potential ``sum (|p_ij|^2 - d_ij^2)^2/4`` falls.
    The theorem is local: from elsewhere the robots may come to rest at other lengths.
    """

    PARAMETERS = (
        Parameter(
            "gain", 0.01, "1/(m^2 s)", low=-10.0, high=100.0, meaning="gain of every edge"
        ),
        SHAPE,
        SIZE,
    )  # fmt: skip

    def published(self):
        return Distances(weights_of(self.topology), self.gain, self.published_places())

    @flow_law
    def pointMassLaw(self):
        return laws.distance_flow(self.gain, self.places(), self.topology)

    @of_samples
    def targets(self, hand):
        """Return the shape, (n, d) [m], turned, mirrored and moved to lie closest to ``hand``."""
        places, middle = self.places(), hand.mean(axis=-2, keepdims=True)
        left, _, right = np.linalg.svd(places.T @ (hand - middle))
        return middle + places @ (left @ right)

    def energy(self, start):
        """Return the sum over edges of ``a_ij (|p_ij|^2 - d_ij^2)^2/4`` on an undirected graph."""
        if self.topology.directed or self.gain <= 0.0:
            return None
        return length_energy(self.topology, self.places(), self.gain)

    def claims(self, start):
        """Return claims: the potential falls, the centroid stays, lengths are reached at their rate."""
        places, topology, allowed = self.places(), self.topology, self.tolerance
        values = np.linalg.eigvalsh(laws.distance_hessian(places, topology))
        conditions = [
            undirected(topology),
            rigid(places, topology),
            spread_as(places, start),
        ] + gain_conditions(self.gain, self.period, values)
        if all_hold(conditions):
            conditions.append(self._descends(start))

        claims = [
            *falls(self.energy(start), "growth of the potential [-]"),
            ends_at(
                self._worst_length, 0.0, allowed.rest, "worst length error at the end [m]"
            )._replace(outside=self._rests_elsewhere),
            invariant(centroid, allowed.drift, "drift of the centroid [m]"),
            Claim("decay rate over theory's [-]", 1.0, allowed.rate, self._rate, free=True),
        ]
        return conditions + without_rates(claims, self.fidelity)

    def _descends(self, start):
        """Return the condition that the potential falls from ``start`` (n, d) though commands are held.

        It does where ``gain Tc`` is below 2 over its curvature.  A start from which the first commands
        lower the potential so far that this holds from there on will do, too.
        """
        places, topology, points, before = self.places(), self.topology, start, np.inf
        for _ in range(MOST_BEFORE):
            potential = laws.length_potential(points, places, topology)
            step = self.gain * self.period * laws.potential_curvature(potential, places, topology)
            if step < 2.0 or not potential < before:
                break
            way = laws.descent(points, places, topology)
            points, before = points + self.gain * self.period * way, potential
        why = "it is {:.3g}: the start is so far from the shape that commands overshoot".format(
            step
        )
        return Condition("gain Tc curvature of the potential < 2", bool(step < 2.0), why)

    def _worst_length(self, hand):
        receiver, sender, _ = self.topology.arcs
        places = self.places()
        wanted = np.linalg.norm(places[receiver] - places[sender], axis=1)
        off = np.linalg.norm(hand[:, receiver] - hand[:, sender], axis=2) - wanted
        return np.abs(off).max(axis=1, initial=0.0)

    def _rests_elsewhere(self, hand):
        """Return that robots rest at ``hand`` (n, d) with wrong lengths, whose terms cancel; else ""."""
        # Of the law's own lengths, whatever is claimed of them.
        off = DistanceFormation._worst_length(self, hand[np.newaxis])[0]
        at_rest = laws.imbalance(hand, self.places(), self.topology) < AT_REST
        if off <= self.tolerance.rest or not at_rest:
            return ""
        text = "the theorem is local, and from this start the law rests at lengths that are {:.2g} m off"
        return text.format(off)

    def _rate(self, run):
        """Return the decay rate of the lengths over that about the shape which was reached.

        A shape may be reached turned over in parts, with all lengths right and another rate.  It is that of
        the lengths' slowest mode.
        """
        matrix = self.gain * laws.distance_hessian(run.hand[-1], self.topology)
        values, modes = np.linalg.eigh(matrix) if np.isfinite(matrix).all() else (np.zeros(1), None)
        stiff = values > RIGID * values.max(initial=0.0)
        if not stiff.any():
            return None
        slowest = modes[:, stiff & (values < values[stiff].min() * (1.0 + ALIKE))]
        patterns = laws.lengthening(run.hand[-1], slowest, self.topology)

        places, topology = self.places(), self.topology

        def excesses(hand):
            excess = laws.length_excess(hand, places, topology)
            return np.linalg.norm(excess, axis=1), np.linalg.norm(excess @ patterns, axis=1)

        whole, slow = by_sample(lambda hand: np.transpose(excesses(hand)))(run.hand).T
        linear = np.flatnonzero(whole <= LINEAR * excesses(np.zeros_like(run.hand[:1]))[0])
        if not len(linear):
            return None
        begin = linear[0]
        if self.fidelity == "point_mass":
            begin += _last_turn(slow[begin:])
        measured = decay_rate(run.time[begin:], slow[begin:])
        near = linear_theorem(matrix)
        return measured / near.held_rate(self.period) if measured and near.rate else None


def _last_turn(values):
    """Return from which row on ``values`` (m,) fall that passed near zero before, 0 where none did.

    A mode that a start nearly lacks is what products of the others make of it at first, of either sign.
    """
    low = np.flatnonzero(values <= RATE_FLOOR * values[0])
    values = values[: low[0] if len(low) else None]
    later = np.maximum.accumulate(values[::-1])[::-1]
    dips = np.flatnonzero(later > TURNED * values)
    return dips[-1] + int(values[dips[-1] :].argmax()) if len(dips) else 0


class BearingFormation(Shaped):
    """``u_i = -gain sum_j a_ij P(g_ij) g*_ij``: Zhao, Zelazo, 2016, by bearings alone.

    Theorem: if the bearings fix the shape (it is infinitesimally bearing rigid) and the graph is
    undirected, the robots reach its bearings from almost everywhere, and their centroid and their scale
    stay as they were. Robots are supposed never to meet.
    """

    PARAMETERS = (
        Parameter("gain", 1.0, "m/s", low=-10.0, high=100.0, meaning="gain of every edge"),
        SHAPE,
        SIZE._replace(meaning="from one robot to the next; only the shape's bearings matter"),
    )

    def published(self):
        return Bearings(weights_of(self.topology), self.gain, self.published_places())

    @flow_law
    def pointMassLaw(self):
        return laws.bearing_flow(self.gain, self.places(), self.topology)

    @of_samples
    def targets(self, hand):
        """Return the shape, (n, d) [m], with the centroid and the scale of ``hand``."""
        places, size = self.places(), laws.scale(hand)[..., np.newaxis, np.newaxis]
        return hand.mean(axis=-2, keepdims=True) + places * (size / laws.scale(places))

    def energy(self, start):
        """Return ``|p - p*|^2/2`` on an undirected graph."""
        if self.topology.directed or self.gain <= 0.0:
            return None
        places = self.published_places()
        middle, size = start.mean(axis=0), np.sqrt(((start - start.mean(axis=0)) ** 2).sum())
        goal = middle + places * (size / max(np.sqrt((places**2).sum()), 1e-300))
        return bearing_energy(self.topology, goal, self.gain)

    def claims(self, start):
        """Return claims: bearings are reached at their rate; centroid and scale stay."""
        places, topology, allowed = self.places(), self.topology, self.tolerance
        spread = bool(laws.scale(start) > NEGLIGIBLE)
        apart = Condition("robots begin apart", spread, "no bearing leads out of one place")
        conditions = [undirected(topology), rigid_by_bearings(places, topology), apart]
        if not all_hold(conditions):
            return conditions
        limit = self.targets(start)
        matrix = laws.bearing_laplacian(limit, topology, over_length=True)
        conditions += gain_conditions(self.gain, self.period, np.linalg.eigvalsh(matrix))
        size = laws.scale(start)
        share = allowed.share + self._growth(start, limit)
        # A scale that is off by a share moves the outermost robot by that share.
        reach = allowed.place + share * np.linalg.norm(limit - limit.mean(0), axis=1).max()

        def relative_scale(hand):
            return laws.scale(hand) / size

        def bearing_distance(hand):
            # Modes about another scale decay as much slower as it is larger, to which held commands lead.
            return by_sample(self._bearing_distance)(hand) ** relative_scale(hand)[-1]

        claims = [
            bearing_error(places, topology, allowed.share),
            converges_to(limit, reach, "distance from place [m]", free=True),
            invariant(centroid, allowed.drift, "drift of the centroid [m]"),
            invariant(relative_scale, share, "drift of the scale [-]"),
            rate(
                linear_theorem(self.gain * matrix).held_rate(self.period),
                bearing_distance,
                allowed.rate,
                "decay rate of the bearings' error [1/s]",
            ),
        ]
        return conditions + without_rates(claims, self.fidelity)

    def _growth(self, start, limit):
        """Return by which share held commands let the scale grow at most, inf where they may for ever.

        Velocities are across ``p - c``: a command adds ``Tc^2 |u|^2`` to the squared scale.  With s_ij
        the sine between a bearing and the wanted one, p* the points of ``limit``, l* their distances and
        lambda the largest eigenvalue of the Laplacian with the weights ``a_ij/l_ij*``,

            V = |p - p*|^2/2,   V' = -gain sum a_ij l_ij* s_ij^2,   |u|^2 <= -V' gain lambda,

        so that all commands add ``q/(2 - q) |p(0) - p*|^2`` at most, with ``q = Tc gain lambda``.
        """
        receiver, sender, weight = self.topology.arcs
        weight = weight / np.linalg.norm(limit[receiver] - limit[sender], axis=1)
        laplacian = np.diag(np.bincount(receiver, weight, len(limit)))
        laplacian[receiver, sender] -= weight
        q = self.period * self.gain * np.linalg.eigvalsh(laplacian).max()
        if q >= 2.0:
            return np.inf
        added = q / (2.0 - q) * np.sum((start - limit) ** 2) / laws.scale(start) ** 2
        return float(np.sqrt(1.0 + added) - 1.0)

    def _bearing_distance(self, hand):
        off = laws.bearings(hand, self.topology) - laws.bearings(self.places(), self.topology)
        return np.linalg.norm(off, axis=(1, 2))


def bearing_error(places, topology, tolerance):
    """Claim that the run ends with the bearings of ``places`` (n, d)."""
    wanted = laws.bearings(places, topology)

    def worst(hand):
        off = np.linalg.norm(laws.bearings(hand, topology) - wanted, axis=2)
        return off.max(axis=1, initial=0.0)

    return ends_at(worst, 0.0, tolerance, "worst bearing error at the end [-]")


class BearingLeaders(LinearErrors, Shaped):
    """``u_i = -gain sum_j a_ij P(g*_ij)(p_i - p_j)``, robots 1 and 2 still: Zhao, Zelazo, 2016.

    Theorem: if the bearings and the two leaders' places leave one target alone (the followers' block of
    the bearing Laplacian is invertible), the followers reach it, exponentially, from everywhere.
    """

    PARAMETERS = (GAIN, SHAPE, SIZE._replace(meaning="from one robot to the next; leaders fix it"))
    NAMES = NAMES._replace(limit="distance from the unique target [m]", kept="")

    def published(self):
        weights = weights_of(self.topology)
        return BearingsWithLeaders(weights, self.gain, self.published_places(), LEADERS)

    @flow_law
    def pointMassLaw(self):
        return laws.leaders_flow(self.gain, self.places(), self.topology, LEADERS)

    def targets(self, hand):
        """Return the one formation, (n, d) [m], with the wanted bearings that fits the leaders."""
        if not self._unique().holds:
            return None
        return laws.fitted_to_leaders(hand, self.places(), self.topology, LEADERS)

    def claims(self, start):
        """Return claims: the unique target and its bearings are reached, at the rate of ``B_ff``."""
        conditions = [self._unique()]
        if not all_hold(conditions):
            return conditions
        values = np.linalg.eigvals(self._follower_matrix())
        conditions += gain_conditions(self.gain, self.period, values)
        conditions.append(self._leaders_fit(start))
        floor = resting(self, len(start) - LEADERS)
        claims = self.consequences(start, self.accuracy, floor=floor, free=False)
        bearings = bearing_error(self.places(), self.topology, self.tolerance.share)
        return [*conditions, *claims[:1], bearings, *claims[1:]]

    def error_matrix(self):
        """Return ``gain B``, (n d, n d) [1/s], B the bearing Laplacian with zeros for the leaders."""
        matrix = self.gain * laws.bearing_laplacian(self.places(), self.topology)
        matrix[: self.dimension * LEADERS] = 0.0
        return matrix

    def reference(self, time):
        """Return the places of the shape, (n, d) [m], where all bearings are as wanted."""
        return self.places()

    def _follower_matrix(self):
        known = self.dimension * LEADERS
        return laws.bearing_laplacian(self.places(), self.topology)[known:, known:]

    def _unique(self):
        matrix = self._follower_matrix()
        holds = len(matrix) > 0 and np.linalg.matrix_rank(matrix, tol=1e-9) == len(matrix)
        return Condition("unique target", bool(holds), "B_ff is singular: more edges are wanted")

    def _leaders_fit(self, start):
        have, want = (points[1] - points[0] for points in (start, self.places()))
        lengths = np.linalg.norm(have) * np.linalg.norm(want)
        # The entries of a cross product, in any number of dimensions, each twice.
        across = np.outer(have, want) - np.outer(want, have)
        off = np.linalg.norm(across) / np.sqrt(2.0) + np.maximum(0.0, -(have @ want))
        why = "robot 2 is not seen from robot 1 as in the shape: no formation has these bearings"
        return Condition("leaders fit the shape", bool(off <= FAR * lengths), why)
