"""Consensus: robots agree on a point by averaging over their neighbours.

With each law stand the numbers of its theorem: bounds and rates from the Laplacian's eigenvalues mu.
"""

import numpy as np

from mrs_simulator.core.edge_terms import Flow, difference_sum, edge_sum, weighted
from mrs_simulator.core.spectra import (
    ZERO,
    laplacian_eigenvalues,
    nonzero_eigenvalues,
    stable_step,
    unshared,
)


def consensus(points, topology):
    """Return ``u_i = sum_j a_ij (p_j - p_i)``, (n, d) [m/s], from ``points`` p (n, d) [m].

    On a connected undirected graph the mean stays and disagreement decays at least as fast as
    ``exp(-lambda_2 t)``; on a directed graph with a spanning tree the limit is ``w^T p(0)``, ``w``
    the left null vector of L.  Olfati-Saber and Murray, 2004; Ren and Beard, 2005.
    """
    return difference_sum(points, topology)


# In steps --------------------------------------------------------------------------------------


def discrete_consensus(points, topology, eps):
    """Return ``p+ = p - eps L p``, (n, d) [m], from ``points`` p (n, d) [m]; ``eps`` [-].

    Converges, on a topology with a spanning tree, iff ``eps`` is below :func:`largest_step`.
    Olfati-Saber, Fax and Murray, 2007.
    """
    return points + eps * consensus(points, topology)


def discrete_flow(topology, eps, period):
    """Return the ``Flow`` of velocities [m/s] that make one such step in a ``period`` [s]."""
    first, second, weight = topology.arcs

    def summed(points):
        return (discrete_consensus(points, topology, eps) - points) / period

    return Flow(1.0, weighted, (first, second), (weight * (eps / period),), summed)


def largest_step(topology):
    """Return the bound of ``eps`` [-]: least ``2 Re(mu)/|mu|^2``, undirected ``2/lambda_max``."""
    return stable_step(laplacian_eigenvalues(topology))


# Delayed ---------------------------------------------------------------------------------------


def delayed_consensus(history, topology):
    """Return ``u_i(t) = sum_j a_ij (p_j(t - tau) - p_i(t - tau))``, (n, d) [m/s].

    ``history``: the points (n, d) [m] at the last commands, the oldest first, which is that of
    ``t - tau``.  Stable iff ``tau`` is below ``(pi/2 - |arg mu|)/|mu|`` for all eigenvalues mu of L but
    one 0.  Olfati-Saber and Murray, 2004.
    """
    return consensus(history[0], topology)


# Double integrators ----------------------------------------------------------------------------


def second_order_consensus(points, velocities, topology, g):
    """Return accelerations ``sum_j a_ij ((p_j - p_i) + g (v_j - v_i))``, (n, d) [m/s^2].

    ``points`` p (n, d) [m], ``velocities`` v (n, d) [m/s], ``g`` [s].  With a spanning tree and
    ``g`` above :func:`least_damping` positions and velocities agree: ``p_i`` on
    ``w^T p(0) + t w^T v(0)``.  Ren and Atkins, 2007; the bound is sharp: Yu, Chen and Cao, 2010.
    """
    return consensus(points + g * velocities, topology)


def least_damping(topology):
    """Return the bound of ``g`` [s]: largest ``sqrt(Im(mu)^2/(Re(mu) |mu|^2))``; undirected 0."""
    mu = nonzero_eigenvalues(laplacian_eigenvalues(topology))
    return float(np.max(np.sqrt(mu.imag**2 / (mu.real * np.abs(mu) ** 2)), initial=0.0))


def unshared_motion(topology, g, period=0.0):
    """Return M, (2n-2, 2n-2), of ``x' = -M x``, x the positions and velocities that are not shared.

    ``x = (U^T p, U^T v)``, U = :func:`unshared`.  With a ``period`` T [s] ``x+ = x - T M x`` are the steps
    ``v+ = v + T a, p+ = p + T v+``.
    """
    basis = unshared(topology.n)
    laplacian = basis.T @ topology.laplacian() @ basis
    force = np.hstack([laplacian, g * laplacian])
    return np.vstack([period * force - np.eye(*force.shape, k=len(force)), force])


# Edges that come and go ------------------------------------------------------------------------


def switching_consensus(points, arcs, weights):
    """Return ``u_i = sum_j a_ij(t) (p_j - p_i)``, (n, d) [m/s], from ``points`` (n, d) [m].

    ``arcs`` (m, 2): rows (i, j), i receives from j; ``weights`` (m,): theirs now, 0 for those that are
    down.  It converges if the union of the edges over each interval of some length has a spanning
    tree, and keeps the mean if weights are symmetric at all times.  Jadbabaie, Lin and Morse, 2003;
    Moreau, 2005.
    """
    return edge_sum(weighted, arcs.T, points, weights)


# Broadcasts at events --------------------------------------------------------------------------


def event_thresholds(points, topology, sigma):
    """Return the largest errors ``|p_hat_i - p_i|``, (n,) [m], at which robot i need not broadcast.

    ``sqrt(sigma a (1 - a d_i)/d_i) |z_i|`` with ``z = L p``, ``d_i = sum_j a_ij``, ``0 < sigma < 1``
    and ``0 < a < 1/max d_i``, here ``a = 1/(2 max d_i)``.  Under ``u = -L p_hat``, undirected and
    connected, ``p^T L p`` then decreases: its derivative is at most ``-2 (1 - sigma) sum_i
    (1 - a d_i) |z_i|^2``, so that it decays like ``exp(-(1 - sigma) lambda_2 t)`` or faster.
    Dimarogonas, Frazzoli and Johansson, 2012.
    """
    degree = topology.in_degree()
    a = 0.5 / max(float(np.max(degree)), ZERO)
    share = sigma * a * (1.0 - a * degree) / np.maximum(degree, ZERO)
    return np.sqrt(share) * np.linalg.norm(consensus(points, topology), axis=1)
