"""Consensus under white noise on velocities and on measurements, with its steady variance."""

import numpy as np

from mrs_simulator.core.claims import Claim, Condition, TooShort
from mrs_simulator.core.edge_terms import gathered
from mrs_simulator.core.fields import Parameter
from mrs_simulator.core.spectra import laplacian_eigenvalues
from mrs_simulator.protocols.common import gain_conditions, spanning_tree
from mrs_simulator.protocols.consensus.equations import consensus
from mrs_simulator.protocols.consensus.law import GAIN
from mrs_simulator.protocols.consensus.memory import SEED, Remembering
from mrs_simulator.protocols.consensus.noise_equations import (
    mean_variance_rate,
    mode_variances,
    modes,
    sampling_error,
)
from mrs_simulator.protocols.consensus.published import Noisy
from mrs_simulator.protocols.published.laws import weights_of

STEADY = "steady variance of the disagreement [m^2]"
DRIFT = "drift of the mean [m]"
TRANSIENT = 6.0  # [-] time constants of the slowest mode after which the start is forgotten
CERTAIN = 4.0  # [-] standard deviations that a measured value may be off
LEAST = 200.0  # [-] time constants of the slowest mode over which a variance is measured


class NoisyConsensus(Remembering):
    """``u = -gain (L (p + nu) + nu_heard) + w`` with white noise: Xiao, Boyd and Kim, 2007.

    w is noise on the velocities, nu that of each robot's position, which it and all that receive it have
    alike, and nu_heard that of each relative position, its listener's alone.

    Theorem: on a connected undirected graph the disagreement does not vanish: its variance settles at
    the sum over the modes of ``q_i/(a_i (2 - a_i))``, with ``a_i = gain Tc lambda_i`` and q_i the
    variance of the noise that enters mode i in each step. The mean wanders as the noise's mean does.
    """

    PARAMETERS = (
        GAIN,
        Parameter(
            "velocity_noise",
            0.05,
            "m/s^0.5",
            low=0.0,
            high=10.0,
            meaning="intensity sigma on the velocities; a sample has the variance sigma^2/Tc",
        ),
        Parameter(
            "robot_noise",
            0.0,
            "m",
            low=0.0,
            high=10.0,
            meaning="standard deviation of each robot's position, as it and its listeners know it",
        ),
        Parameter(
            "listener_noise",
            0.0,
            "m",
            low=0.0,
            high=10.0,
            meaning="standard deviation of each relative position that a listener takes",
        ),
        SEED,
    )

    def published(self):
        """Return the law as published, with the noise of this seed."""
        noise = (self.velocity_noise, self.robot_noise, self.listener_noise)
        return Noisy(weights_of(self.topology), self.gain, noise, self.seed, self.period)

    def begin(self, hand):
        """Begin the noise anew."""
        self._draw = np.random.default_rng(self.seed)

    def law(self, hand):
        """Return the velocities under this command's noise, (n, d) [m/s]."""
        seen = hand + self.robot_noise * self._draw.standard_normal(hand.shape)
        rows, _, weights = self.topology.arcs
        drawn = self.listener_noise * self._draw.standard_normal((len(rows), hand.shape[1]))
        errors = gathered(weights * drawn.T, rows, len(hand))
        push = self._draw.standard_normal(hand.shape) * self.velocity_noise / np.sqrt(self.period)
        return self.gain * (consensus(seen, self.topology) + errors) + push

    def claims(self, start):
        """Return the steady variance, with the error of a run as long as this, and the mean's drift."""
        conditions = [
            Condition("undirected", not self.topology.directed, "modes are not independent"),
            spanning_tree(self.topology),
            *gain_conditions(self.gain, self.period, laplacian_eigenvalues(self.topology)),
        ]
        if not all(condition.holds for condition in conditions) or len(start) < 2:
            return conditions
        return [*conditions, self._steady(), self._drift()]

    def noises(self):
        """Return the noise of each kind by name, as ``noise_equations`` take it."""
        return {
            "velocity": self.velocity_noise,
            "robot": self.robot_noise,
            "listener": self.listener_noise,
        }

    def _steady(self):
        """Return the claim of the steady variance, within what chance allows in so long a run."""
        variances = mode_variances(self.topology, self.gain, self.period, **self.noises())
        values, _ = modes(self.topology)
        factors = np.abs(1.0 - self.gain * self.period * values)
        constant = self.period / -np.log(max(float(factors.max()), 1e-12))
        # Samples that lie closer than a command add nothing; each axis is one trial.
        count = LEAST * constant / self.period
        error = sampling_error(variances, factors, count) / np.sqrt(self.dimension)

        def measured(run):
            late = run.time - run.time[0] >= TRANSIENT * constant
            if not late.any() or run.time[-1] - run.time[late][0] < LEAST * constant:
                wanted = (LEAST + TRANSIENT) * constant
                raise TooShort(
                    "the run is too short for a variance: wanted {:.0f} s".format(wanted)
                )
            return steady_variance(run.hand[late])

        return Claim(STEADY, float(variances.sum()), CERTAIN * error, measured, free=True)

    def _drift(self):
        """Return the claim that the mean stays under noise of robots, and wanders as it should else."""
        given = self.noises()
        rate = mean_variance_rate(
            self.topology, self.gain, given["velocity"], given["listener"], self.period
        )

        def drift(run):
            means = run.hand[[0, -1]].mean(axis=1)
            far = np.sqrt(self.dimension * rate * (run.time[-1] - run.time[0]))
            return float(np.linalg.norm(means[1] - means[0])) / (CERTAIN * far if far else 1.0)

        if rate == 0.0:
            return Claim(DRIFT, 0.0, 1e-6, drift, free=True)
        name = "drift of the mean over {:g} standard deviations [-]".format(CERTAIN)
        return Claim(name, 1.0, 0.0, drift, "at most", free=True)


def steady_variance(hand):
    """Return the mean over samples and axes of ``sum_i (p_i - mean)^2``, from ``hand`` (m, n, d) [m^2]."""
    away = hand - hand.mean(axis=1, keepdims=True)
    return float((away**2).sum(axis=1).mean())
