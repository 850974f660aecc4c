"""What theory says of linear laws over edges that are delayed, lossy or switching."""

from typing import Any, NamedTuple

import numpy as np

from mrs_simulator.core.claims import (
    Claim,
    Condition,
    centroid,
    converges_to,
    disagreement,
    ends_at,
    extent,
    invariant,
)
from mrs_simulator.core.edge_faults import kept_edges, turn_steps, up_in
from mrs_simulator.core.graphs import arcs_of
from mrs_simulator.core.spectra import ZERO, spectral_radius
from mrs_simulator.protocols.common import (
    AGREED,
    all_hold,
    attracting,
    below,
    decays_as,
    held_track,
    spanning_tree,
)
from mrs_simulator.protocols.consensus.over_links_equations import (
    agreement,
    points_over_links,
    round_of,
    step_matrix,
)
from mrs_simulator.protocols.energies import laplacian_energy
from mrs_simulator.protocols.linear_errors import LinearErrors
from mrs_simulator.scenario.network.links import Links

MOST_STATES = 600  # [-] rows of a state whose eigenvalues are looked for
LEAST_DECAY = 1e-6  # [-] by which a round must shrink errors, or rounding could do it


class Linear(NamedTuple):
    """A law ``p_i' = gain sum_j a_ij (p_j - p_i - (d_j - d_i))`` over ``links``."""

    topology: Any
    gain: float  # [1/s]
    places: Any  # d_i, (n, d) [m]
    period: float  # [s]
    links: Links
    place: float  # [m] how far a run may end from its limit
    share: float  # [-] by which a decay rate may differ

    @property
    def delays(self):
        """Return the delays in command periods, (n, n)."""
        return np.round(self.links.delay.matrix(self.topology.n) / self.period).astype(int)

    @property
    def losses(self):
        """Return the chance of a loss over each arc, (m,), in the order of ``arcs_of``."""
        rows, columns = arcs_of(self.topology)[0].T
        return self.links.loss.matrix(self.topology.n)[rows, columns]

    @property
    def certain(self):
        """Return whether nothing is left to chance."""
        by_chance = self.links.switches and self.links.switching.order == "random"
        return not by_chance and "lossy" not in self.links.faults

    @property
    def known(self):
        """Return whether nothing is left to chance, and the state is small enough to look into."""
        return self.certain and self.topology.n * (int(self.delays.max()) + 1) <= MOST_STATES

    @property
    def turn(self):
        """Return for how many commands each graph is up."""
        return turn_steps(self.links.switching, self.period) if self.links.switches else 1

    def graphs(self):
        """Return the graphs that are up in turn, the topology alone without switching."""
        if not self.links.switches:
            return [self.topology]
        switching = self.links.switching
        return [
            kept_edges(self.topology, up_in(switching, self.topology, number))
            for number in range(switching.count)
        ]

    def round(self):
        """Return the map of the state over one round of the graphs."""
        both, delays = self.links.carries == "difference", self.delays
        steps = (
            step_matrix(self.gain * graph.adjacency(), delays, self.period, both)
            for graph in self.graphs()
        )
        return round_of(steps, self.turn)

    def track(self, start, time):
        """Return the exact solution, (m, n, d) [m], at ``time`` (m,) [s]; None where chance has a say."""
        if not self.certain:
            return None
        both, share = self.links.carries == "difference", self.gain * self.period
        flows = [(arcs, share * weights) for arcs, weights, _ in map(arcs_of, self.graphs())]
        away = start - self.places
        points = points_over_links(away, flows, self.turn, self.delays, both)
        return self.places + held_track(points, time, self.period)


class AveragingLaw(LinearErrors):
    """Mixin of laws ``u = -gain L (p - r)``, r at rest, also over edges with faults."""

    PLACE, SHARE = AGREED, 0.02  # [m], [-] tolerances over such edges

    def error_matrix(self):
        """Return ``gain L``, (n, n) [1/s]."""
        return self.gain * self.topology.laplacian()

    def energy(self, start):
        """Return ``e^T L e/2``, ``e = p - r``, over a directed graph that of the disagreement."""
        if self.topology.directed or self.gain <= 0.0:
            return super().energy(start)
        return laplacian_energy(self.topology, self.gain, self.reference(0.0))

    def claims_over_links(self, start):
        """Return limit and rate over delayed and switching edges, agreement over lossy ones."""
        return linear_claims(self.over_links(), start)

    def prediction_over_links(self, start, time):
        """Return the exact solution where nothing is left to chance, (m, n, d) [m], else None."""
        law = self.over_links()
        return law and law.track(start, time)

    def over_links(self):
        """Return the law over ``self.links``, a :class:`Linear`, or None."""
        places, accuracy = self.reference(0.0), (self.PLACE, self.SHARE)
        return Linear(self.topology, self.gain, places, self.period, self.links, *accuracy)


def linear_claims(law, start):
    """Return what theory says of a run of the ``Linear`` law from ``start`` (n, d); None for nothing.

    With delays and turns that are known: stability and limit, from the eigenvalues of a round, and the
    rate of the exact solution.
    With losses and turns by chance: agreement with probability one, as long as each robot goes
    towards what others sent and never beyond (Bertsekas and Tsitsiklis, 1989).
    """
    if not law.known and law.links.carries == "difference" and law.links.on_loss == "hold":
        return None
    if not law.known and law.links.carries == "difference" and law.delays.any():
        return None
    conditions = [_joint_tree(law), attracting(law.gain)]
    if not all_hold(conditions):
        return conditions
    if law.known:
        return _known_claims(law, start, conditions)
    return _chance_claims(law, start, conditions)


def _joint_tree(law):
    """Return the condition that the edges over which something comes at some time have a tree."""
    rows, columns = arcs_of(law.topology)[0].T
    adjacency = sum(graph.adjacency() for graph in law.graphs())
    comes = (adjacency[rows, columns] > 0.0) & (law.losses < 1.0)
    name = "jointly a spanning tree" if law.links.switches else "spanning tree"
    return spanning_tree(kept_edges(law.topology, comes))._replace(name=name)


def _from_places(quantity, law):
    """Return the ``quantity`` of the errors ``p - d``."""
    return lambda hand: quantity(hand - law.places)


def _known_claims(law, start, conditions):
    modulus, weights = agreement(law.round(), law.topology.n)
    conditions = conditions + _delay_bound(law)
    why = "errors are multiplied by {:.6g} in each round".format(modulus)
    name = "stable over these edges, with held commands"
    least = LEAST_DECAY * law.turn * law.links.switching.count
    conditions.append(Condition(name, modulus < 1.0 - least, why, necessary=True))
    limit = law.places + weights @ (start - law.places)
    claims = [
        converges_to(limit, law.place, "distance from the limit over these edges [m]", free=True)
    ]
    if modulus > ZERO:
        claims.append(decays_as(law.track, _from_places(disagreement, law), law.share))
    degree = float(np.max(law.topology.in_degree()))
    if law.links.carries == "state" and law.gain * law.period * degree < 1.0:
        claims += _agreement_claims(law, start)
    return conditions + claims


def _delay_bound(law):
    """Return the bound on equal delays of both terms, where it is a theorem: on undirected graphs."""
    receiver, sender = arcs_of(law.topology)[0].T
    ages = np.unique(law.delays[receiver, sender])
    equal = len(ages) == 1 and law.links.carries == "difference" and not law.links.switches
    if not equal or law.topology.directed:
        return []
    bound = np.pi / (2.0 * law.gain * spectral_radius(law.topology))
    return [
        below(
            "tau < pi/(2 gain lambda_max) [s]", float(ages[0]) * law.period, bound, necessary=True
        )
    ]


def _chance_claims(law, start, conditions):
    degree = float(np.max(law.topology.in_degree()))
    conditions = conditions + [below("gain Tc max degree < 1", law.gain * law.period * degree, 1.0)]
    if law.links.on_loss == "hold":  # over an edge that loses all, the start is held for ever
        conditions.append(
            below("loss < 1", float(np.max(law.losses, initial=0.0)), 1.0, necessary=True)
        )
    return conditions + _agreement_claims(law, start) + _mean_claims(law, start)


def _agreement_claims(law, start):
    """Return claims: robots agree within the box of their starts, since none leaves what it received."""
    errors, spread = start - law.places, _from_places(extent, law)
    low, high = errors.min(axis=0), errors.max(axis=0)

    def outside(run):
        away = run.hand - law.places
        return float(np.maximum(low - away, away - high).max())

    # Limits scale each robot's gain by a factor up to 1: the theorem is of such gains too.
    return [
        ends_at(spread, 0.0, law.place, "disagreement at the end, the largest [m]"),
        Claim("way out of the box of the start [m]", 0.0, law.place, outside, "at most"),
    ]


def _mean_claims(law, start):
    """Return the claim that the mean stays, where neighbours act on each other equally and oppositely."""
    alike = law.links.symmetric and law.links.on_loss == "drop"
    alike = alike or "lossy" not in law.links.faults
    if law.topology.directed or not alike or law.delays.any():
        return []
    limit = law.places + (start - law.places).mean(axis=0)
    return [
        invariant(centroid, law.place, "drift of the mean [m]"),
        converges_to(limit, law.place, "distance from the mean's place [m]", free=True),
    ]
