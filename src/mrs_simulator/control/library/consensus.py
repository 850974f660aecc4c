"""Consensus protocols, with what theory claims of their runs."""

import numpy as np

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.core.claims import Condition, converges_to, disagreement, invariant, rate
from mrs_simulator.core.parameters import Parameter
from mrs_simulator.core.protocols.consensus import consensus
from mrs_simulator.core.spectra import left_null_vector, sampled_rate, spectral_radius

GAIN = Parameter("gain", 0.5, "1/s", low=-10.0, high=100.0, meaning="gain of every edge")


def spanning_tree(topology):
    """Return the condition that some robot is heard, over others, by all."""
    return Condition("spanning tree", topology.has_spanning_tree(), "no robot is heard by all")


class Consensus(PioneerControl):
    """``u_i = gain sum_j a_ij (p_j - p_i)``: Olfati-Saber and Murray, 2004; Ren and Beard, 2005."""

    PARAMETERS = (GAIN,)

    def pointMassLaw(self, hand):
        """Return the hand points' velocities, (n, 2) [m/s]."""
        return self.gain * consensus(hand, self.topology)

    def claims(self, start):
        """Return limit, invariant and rate: ``w^T p`` is kept and reached, at ``lambda_2``."""
        largest = self.gain * self.period * spectral_radius(self.topology)
        conditions = [
            spanning_tree(self.topology),
            Condition("gain above 0", self.gain > 0.0, "robots are driven apart"),
            Condition("gain Tc lambda_max < 2", largest < 2.0, "it is {:.3g}".format(largest)),
        ]
        if not all(condition.holds for condition in conditions):
            return conditions
        weights = left_null_vector(self.topology)
        decay = sampled_rate(self.gain * self.topology.laplacian(), self.period)

        def weighted_mean(hand):
            return np.einsum("i,mid->md", weights, hand)

        return conditions + [
            converges_to(
                weights @ start, 0.02, "distance from agreement on w^T p(0) [m]", free=True
            ),
            invariant(weighted_mean, 0.01, "drift of w^T p [m]"),
            rate(decay, disagreement, 0.05, "decay rate of the disagreement [1/s]"),
        ]

    def prediction(self, start, time):
        """Return the exact solution under held inputs, (m, n, 2) [m], at ``time`` (m,) [s]."""
        step = np.eye(len(start)) - self.gain * self.period * self.topology.laplacian()
        return powers(step, start, np.floor(np.asarray(time) / self.period + 1e-6).astype(int))


def powers(step, start, counts):
    """Return ``step^k start``, (m, n, 2), for each k of ascending ``counts`` (m,)."""
    track, point, done = np.empty((len(counts),) + start.shape), start, 0
    jumps = {}
    for row, count in enumerate(counts.tolist()):
        jump = count - done
        if jump not in jumps:
            jumps[jump] = np.linalg.matrix_power(step, jump)
        point, done = jumps[jump] @ point, count
        track[row] = point
    return track
