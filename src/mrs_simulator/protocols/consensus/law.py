"""Consensus protocols without memory, with what theory claims of their runs."""

import numpy as np

from mrs_simulator.control.array_law import flow_law
from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Condition, decreases
from mrs_simulator.core.edge_terms import difference_flow
from mrs_simulator.core.fields import Parameter
from mrs_simulator.core.linear_theorem import Accuracy, Names
from mrs_simulator.core.spectra import laplacian_eigenvalues
from mrs_simulator.core.stability import Stability, share_left
from mrs_simulator.protocols.common import AGREED, DECAY, below, gain_conditions, spanning_tree
from mrs_simulator.protocols.consensus.equations import discrete_flow, largest_step
from mrs_simulator.protocols.consensus.over_links import AveragingLaw
from mrs_simulator.protocols.published.laws import Averaging, weights_of

GAIN = Parameter("gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="gain of every edge")
EPS = Parameter(
    "eps",
    0.2,
    low=-10.0,
    high=100.0,
    meaning="share of the differences removed by each command",
    why="converges below 2/lambda_max",
)
NAMES = Names("distance from agreement on w^T p(0) [m]", "drift of w^T p [m]", DECAY)
ACCURACY = Accuracy(place=AGREED, kept=0.01)


def never_grows(quantity, name, period):
    """Claim that the ``quantity`` never grows from one command to a later one.

    While a command is held, it may fall below its next value and rise again.
    """
    claim = decreases(quantity, name, free=True)

    def growth(run):
        count = (run.time - run.time[0]) / period
        rows = np.flatnonzero(np.abs(count - np.round(count)) < 1e-6)
        return claim.measure(run._replace(time=run.time[rows], hand=run.hand[rows]))

    return claim._replace(measure=growth)


class Consensus(AveragingLaw, PioneerControl):
    """``u_i = gain sum_j a_ij (p_j - p_i)``: Olfati-Saber and Murray, 2004; Ren and Beard, 2005.

    Theorem: over a graph with a spanning tree all robots come to ``w^T p(0)``, which ``w^T p`` keeps; w
    is the left null vector of L with sum 1, on an undirected graph ``1/n``. There the disagreement
    decays at ``gain lambda_2``. Commands held for Tc ask for ``|1 - gain Tc mu| < 1`` of every
    eigenvalue mu of L but one 0.
    """

    PARAMETERS = (GAIN,)
    DIMENSIONS = (2, 3)
    MEMORYLESS = True
    NAMES = NAMES
    THRESHOLD = r"$\kappa T_c = 2/\lambda_{\max}$"

    def published(self):
        return Averaging(weights_of(self.topology), self.gain)

    @flow_law
    def pointMassLaw(self):
        return difference_flow(self.gain, self.topology)

    def claims(self, start):
        """Return limit, invariant and rate: ``w^T p`` is kept and reached, at ``lambda_2``."""
        conditions = [spanning_tree(self.topology), *self._converging()]
        if not self.topology.has_spanning_tree():
            return conditions
        return conditions + self.consequences(start, ACCURACY)

    def _converging(self):
        return gain_conditions(self.gain, self.period, laplacian_eigenvalues(self.topology))

    def stability(self, start):
        """Return how far ``gain Tc`` is from ``2/lambda_max``; None over edges with faults."""
        if self.links.faults:
            return None
        margin = share_left(self.gain * self.period, largest_step(self.topology))
        return Stability(self.THRESHOLD, margin)


class DiscreteConsensus(Consensus):
    """``p+ = p - eps L p``, one step each command: Olfati-Saber, Fax and Murray, 2007.

    Theorem: over a graph with a spanning tree all robots come to ``w^T p(0)`` if ``eps`` is above 0 and
    ``|1 - eps mu| < 1`` for every eigenvalue mu of L but one 0; on an undirected graph, ``eps <
    2/lambda_max``. The slowest mode shrinks by ``max |1 - eps mu|`` in each step.
    """

    PARAMETERS = (EPS,)
    THRESHOLD = r"$\varepsilon = 2/\lambda_{\max}$"

    @property
    def gain(self):
        """Return the gain [1/s] of consensus with such commands, eps over the period."""
        return self.eps / self.period

    @flow_law
    def pointMassLaw(self):
        """Return the velocities (n, d) [m/s] that make one step in ``self.period``."""
        return discrete_flow(self.topology, self.eps, self.period)

    def _converging(self):
        return [
            Condition("eps above 0", self.eps > 0.0, "robots are driven apart", necessary=True),
            below("eps < 2/lambda_max", self.eps, largest_step(self.topology), necessary=True),
        ]
