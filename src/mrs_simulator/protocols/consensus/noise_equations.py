"""Consensus under white noise: the steady variance of the disagreement, mode by mode.

On a connected undirected graph with held commands the mode of eigenvalue ``lambda_i`` (i >= 2) goes
as ``x+ = (1 - a_i) x + input``, ``a_i = kappa lambda_i Tc``, so that white input of variance q leaves
``q/(a_i (2 - a_i))``.  Compare Xiao, Boyd and Kim, "Distributed average consensus with least-mean-square
deviation", 2007, and Bamieh, Jovanovic, Mitra and Patterson, "Coherence in large-scale networks", 2012.
"""

import numpy as np


def modes(topology):
    """Return ``lambda_i`` (n-1,) and unit eigenvectors (n, n-1) of the disagreement, ascending."""
    values, vectors = np.linalg.eigh(topology.laplacian())
    return values[1:], vectors[:, 1:]


def mode_variances(topology, gain, period, velocity=0.0, robot=0.0, listener=0.0):
    """Return the steady variance of each mode of the disagreement per axis, (n-1,) [m^2].

    ``velocity`` [m/sqrt(s)]: intensity sigma of white noise on the velocities, whose samples, held for
    the ``period`` Tc, have the variance ``sigma^2/Tc``:

        sigma^2 / (2 kappa lambda_i (1 - kappa lambda_i Tc/2)).

    ``robot`` [m]: standard deviation of the noise of each robot's position, the same to itself and to
    all that receive it, so that it enters through L as a whole:

        r^2 kappa lambda_i Tc / (2 - kappa lambda_i Tc).

    ``listener`` [m]: standard deviation of the noise of each relative position that a robot takes, its
    own for each edge and direction; with ``Q = diag(sum_j a_ij^2)`` and the eigenvectors ``v_i``

        r^2 kappa Tc (v_i^T Q v_i) / (lambda_i (2 - kappa lambda_i Tc)).

    inf where ``kappa lambda_max Tc >= 2``: nothing is steady then.
    """
    values, vectors = modes(topology)
    a = gain * period * values
    squared = (topology.adjacency() ** 2).sum(axis=1)
    received = np.einsum("ki,k,ki->i", vectors, squared, vectors)
    entering = velocity**2 * period + (a * robot) ** 2 + (gain * period * listener) ** 2 * received
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = entering / (a * (2.0 - a))
    return np.where((a > 0.0) & (a < 2.0), steady, np.inf)


def mean_variance_rate(topology, gain, velocity=0.0, listener=0.0, period=0.0):
    """Return how fast the variance of the team's mean grows per axis [m^2/s].

    ``(sigma^2 + kappa^2 Tc r^2 sum_ij a_ij^2 / n) / n``: noise of a robot enters through L and
    leaves the mean alone, noise of a listener does not.
    """
    n = topology.n
    received = float((topology.adjacency() ** 2).sum())
    return (velocity**2 + gain**2 * period * listener**2 * received / n) / n


def sampling_error(variances, shares, count):
    """Return the standard deviation of the measured ``sum_i x_i^2``, the mean of ``count`` samples.

    ``variances`` (k,) of independent Gaussian modes that keep ``shares`` (k,) of their value from one
    sample to the next: ``x^2`` then keeps ``shares^2``.
    """
    kept = shares**2
    each = 2.0 * variances**2 * (1.0 + kept) / (1.0 - kept) / count
    return float(np.sqrt(each.sum()))
