"""Exact spectral quantities of interaction graphs, as used in theorems."""

import functools

import numpy as np

ZERO = 1e-9  # [-] eigenvalues closer to zero than this count as zero


def _once(function):
    """Keep what ``function`` returns of a topology, which never changes; arrays not to be written to."""

    @functools.lru_cache(maxsize=16)
    def kept(topology):
        result = function(topology)
        result.setflags(write=False)
        return result

    return functools.update_wrapper(kept, function)


@_once
def laplacian_eigenvalues(topology):
    """Return the eigenvalues of the Laplacian, (n,), ascending by real part; real if undirected."""
    laplacian = topology.laplacian()
    if not topology.directed:
        return np.linalg.eigvalsh(laplacian)
    return np.sort_complex(np.linalg.eigvals(laplacian))


def algebraic_connectivity(topology):
    """Return ``lambda_2`` [1/s per unit gain]: the second smallest real part; 0 for one robot."""
    values = laplacian_eigenvalues(topology)
    return float(values[1].real) if len(values) > 1 else 0.0


def spectral_radius(topology):
    """Return ``lambda_max``, the largest ``|lambda|`` of the Laplacian."""
    return float(np.max(np.abs(laplacian_eigenvalues(topology))))


def moving(values):
    """Return those of the eigenvalues ``values`` (n,) that are not zero, (m,): of what moves at all."""
    return values[np.abs(values) > ZERO * np.max(np.abs(values), initial=1.0)]


def stable_step(values):
    """Return the bound below which ``p+ = p - eps M p`` decays: least ``2 Re(mu)/|mu|^2``.

    ``values`` (n,): the eigenvalues mu of M, of which those that are zero do not count; inf if all
    are.  Real ones: ``2/lambda_max``.
    """
    mu = moving(values)
    return float(np.min(2.0 * mu.real / np.abs(mu) ** 2, initial=np.inf))


@_once
def left_null_vector(topology):
    """Return ``w``, (n,), with ``w^T L = 0`` and sum 1: the weights of the limit of consensus.

    Non-negative, positive for the roots of the spanning trees: a root that hears nobody has all
    weight, and on a balanced graph all have the same.  Raises ``ValueError`` if the graph has no
    spanning tree: ``w`` is not unique then.
    """
    if not topology.has_spanning_tree():
        raise ValueError("the topology has no spanning tree: consensus has no unique limit")
    deaf = topology.in_degree() == 0.0
    if deaf.any():
        return deaf.astype(float)
    if is_balanced(topology):
        return np.full(topology.n, 1.0 / topology.n)
    _, _, rows = np.linalg.svd(topology.laplacian().T)
    weights = rows[-1] / rows[-1].sum()
    return np.where(np.abs(weights) < ZERO, 0.0, weights)


def is_balanced(topology):
    """Return whether each robot is heard as much as it hears: the mean is then kept."""
    return bool(np.allclose(topology.out_degree(), topology.in_degree(), 1e-12, 0.0))


def sampled_rate(matrix, period):
    """Return the rate [1/s] at which ``p' = -M p`` decays when its input is held for ``period`` [s].

    ``-ln rho / period``, with ``rho`` the largest modulus of the eigenvalues of ``I - period M``
    other than those that belong to the eigenvalues zero of ``M`` (n, n) [1/s]; negative if it grows.
    """
    values = moving(np.linalg.eigvals(np.asarray(matrix, dtype=float)))
    if not len(values):
        return 0.0
    largest = float(np.max(np.abs(1.0 - period * values)))
    return float(-np.log(max(largest, 1e-300)) / period)


def rigidity_matrix(points, pairs):
    """Return the rigidity matrix, (m, 2n), of ``points`` (n, 2) and m ``pairs`` of rows (i, j)."""
    matrix = np.zeros((len(pairs), 2 * len(points)))
    for row, (i, j) in enumerate(pairs):
        apart = np.asarray(points[i]) - np.asarray(points[j])
        matrix[row, 2 * i : 2 * i + 2] = apart
        matrix[row, 2 * j : 2 * j + 2] = -apart
    return matrix


def is_infinitesimally_rigid(points, pairs):
    """Return whether the framework is: rank ``2n - 3`` of the rigidity matrix (n >= 2)."""
    rank = np.linalg.matrix_rank(rigidity_matrix(points, pairs), tol=1e-8)
    return bool(rank == 2 * len(points) - 3)
