"""Consensus over edges that switch and fail, with what theory claims of its runs."""

import numpy as np

from mrs_simulator.core.claims import (
    centroid,
    converges_to,
    disagreement,
    ends_at,
    extent,
    invariant,
)
from mrs_simulator.core.edge_faults import turn_steps, up_in
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.graphs import arcs_of
from mrs_simulator.core.spectra import ZERO
from mrs_simulator.protocols.common import AGREED, attracting, below, decays_as, spanning_tree
from mrs_simulator.protocols.consensus.equations import switching_consensus
from mrs_simulator.protocols.consensus.law import GAIN, never_grows
from mrs_simulator.protocols.consensus.memory import SEED, Solved
from mrs_simulator.protocols.consensus.over_links import Linear
from mrs_simulator.protocols.consensus.over_links_equations import agreement
from mrs_simulator.protocols.consensus.published import Switching
from mrs_simulator.protocols.published.laws import weights_of
from mrs_simulator.scenario.network import links

SETS = Parameter(
    "sets",
    1,
    low=1,
    high=1000,
    meaning="edge k of the topology is up in turn k mod sets; 1: no switching",
)
DWELL = Parameter(
    "dwell",
    0.5,
    "s",
    **POSITIVE,
    high=1000.0,
    meaning="length of a turn, rounded to whole command periods",
)
LOSS = Parameter(
    "loss",
    0.0,
    low=0.0,
    high=1.0,
    open_high=True,
    meaning="chance that an edge is down during one command",
)
SYMMETRIC = Parameter(
    "symmetric",
    True,
    meaning="an undirected edge is lost in both directions, or in each for itself",
)


class SwitchingConsensus(Solved):
    """``u_i = gain sum_j a_ij(t) (p_j - p_i)``: Jadbabaie, Lin, Morse, 2003; Moreau, 2005.

    The edges of the topology are dealt out to ``sets`` that are up in turn for ``dwell`` each; of
    those up each is lost with the chance ``loss``, drawn anew for each command.

    Theorem: all robots agree if every union of the graphs over one round has a spanning tree, and no
    robot passes the mean of its neighbours, ``gain Tc max degree < 1``. Over undirected graphs the mean
    is kept, and the disagreement never grows.
    """

    PARAMETERS = (GAIN, SETS, DWELL, LOSS, SYMMETRIC, SEED)
    TAKES_EDGES = False  # it switches and drops them by itself
    JUMPS = True

    def published(self):
        """Return the law as published, with the losses of this seed."""
        turn = max(1, int(round(self.dwell / self.period)))
        return Switching(
            weights_of(self.topology), self.topology.edges, self.gain, turn, self.sets, self.loss,
            self.symmetric, self.seed, self.period, self.topology.directed,
        )  # fmt: skip

    @property
    def _switching(self):
        return links.Switching(sets=self.sets, dwell=self.dwell)

    def begin(self, hand):
        """Seed the losses."""
        self._draw = np.random.default_rng(self.seed)

    def law(self, hand):
        """Return the velocities over the edges that are up now."""
        arcs, weights, edges = arcs_of(self.topology)
        turn = int(round(self.time / self.period)) // turn_steps(self._switching, self.period)
        up = up_in(self._switching, self.topology, turn % self.sets) & self._arrives(edges)
        return self.gain * switching_consensus(hand, arcs, weights * up)

    def _arrives(self, edges):
        if self.symmetric:
            return self._draw.random(len(self.topology.edges))[edges] >= self.loss
        return self._draw.random(len(edges)) >= self.loss

    # What theory says of a run -------------------------------------------------------------------

    def claims(self, start):
        """Return agreement, and as far as the edges' law is known its place and rate."""
        degree = float(np.max(self.topology.in_degree()))
        conditions = [
            # All sets come up in turn, so that the union over one round is the whole topology.
            spanning_tree(self.topology)._replace(name="jointly a spanning tree"),
            attracting(self.gain),
            below("gain Tc max degree < 1", self.gain * self.period * degree, 1.0),
        ]
        if not conditions[0].holds:
            return conditions
        claims = [
            ends_at(extent, 0.0, AGREED, "final extent [m]", free=True),
            never_grows(extent, "growth of the extent [-]", self.period),
        ]
        if not self.topology.directed and (self.symmetric or self.loss == 0.0):
            claims += [
                invariant(centroid, 0.01, "drift of the mean [m]"),
                converges_to(start.mean(axis=0), AGREED, "distance from the mean [m]", free=True),
                never_grows(disagreement, "growth of the disagreement [-]", self.period),
            ]
        if self.loss == 0.0:
            claims += self._round_claims(start)
        return conditions + claims

    def _round_claims(self, start):
        """Return the limit of rounds of turns, by the map of a round, and their rate."""
        law = self._without_losses(start)
        modulus, weights = agreement(law.round(), len(start))
        limit = converges_to(weights @ start, AGREED, "distance from the limit [m]", free=True)
        return [limit] + ([decays_as(law.track, disagreement)] if modulus > ZERO else [])

    def _without_losses(self, start):
        places, turns = np.zeros_like(start), links.Links(switching=self._switching)
        return Linear(self.topology, self.gain, places, self.period, turns, AGREED, 0.02)
