"""Exact spectral quantities of interaction graphs, as used in theorems."""

import functools

import numpy as np

ZERO = 1e-9  # [-] eigenvalues closer to zero than this count as zero


def _once(function):
    """Cache what ``function`` returns of a topology, which never changes, as read-only arrays."""

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


def nonzero_eigenvalues(values):
    """Return the eigenvalues among ``values`` (n,) that are not zero, (m,): of the modes that move."""
    return values[np.abs(values) > ZERO * np.max(np.abs(values), initial=1.0)]


def stable_step(values):
    """Return the bound below which ``p+ = p - eps M p`` decays: least ``2 Re(mu)/|mu|^2``.

    ``values`` (n,): the eigenvalues mu of M, of which those that are zero do not count; inf if all
    are.  Real ones: ``2/lambda_max``.
    """
    mu = nonzero_eigenvalues(values)
    return float(np.min(2.0 * mu.real / np.abs(mu) ** 2, initial=np.inf))


@_once
def left_null_vector(topology):
    """Return ``w``, (n,), with ``w^T L = 0`` and sum 1: the weights of the limit of consensus.

    Non-negative, positive for the roots of the spanning trees: a root without neighbours has all
    weight, and on a balanced graph all have the same.  Raises ``ValueError`` if the graph has no
    spanning tree: ``w`` is not unique then.
    """
    if not topology.has_spanning_tree():
        raise ValueError("the topology has no spanning tree: consensus has no unique limit")
    isolated = topology.in_degree() == 0.0
    if isolated.any():
        return isolated.astype(float)
    if is_balanced(topology):
        return np.full(topology.n, 1.0 / topology.n)
    _, _, rows = np.linalg.svd(topology.laplacian().T)
    weights = rows[-1] / rows[-1].sum()
    return np.where(np.abs(weights) < ZERO, 0.0, weights)


def is_balanced(topology):
    """Return whether in-degrees equal out-degrees: the mean is then invariant."""
    return bool(np.allclose(topology.out_degree(), topology.in_degree(), 1e-12, 0.0))


def unshared(n):
    """Return an orthonormal basis, (n, n-1), of what n robots do not share."""
    return np.linalg.qr(np.column_stack([np.ones(n), np.eye(n)[:, : n - 1]]))[0][:, 1:]


def rigidity_matrix(points, pairs):
    """Return the rigidity matrix, (m, d n), of ``points`` (n, d) and m ``pairs`` of rows (i, j).

    Row k holds ``p_i - p_j`` in the columns of robot i and ``p_j - p_i`` in those of j: how fast half of
    the squared length of pair k changes.
    """
    first, second = np.asarray(pairs, dtype=int).reshape(-1, 2).T
    points = np.asarray(points, dtype=float)
    matrix = np.zeros((len(first), *points.shape))
    row, apart = np.arange(len(first)), points[first] - points[second]
    matrix[row, first], matrix[row, second] = apart, -apart
    return matrix.reshape(len(first), points.size)


def is_infinitesimally_rigid(points, pairs):
    """Return whether only motions of the whole framework keep all lengths to first order.

    Rank ``d n - d (d + 1)/2`` of the rigidity matrix of ``points`` (n, d), n >= d; of fewer points
    ``n (n - 1)/2``, all pairs.
    """
    n, d = np.shape(points)
    rank = np.linalg.matrix_rank(rigidity_matrix(points, pairs), tol=1e-8)
    return bool(rank == rigid_rank(n, d))


def rigid_rank(n, d):
    """Return the rank of the rigidity matrix of a rigid framework of n points in d dimensions.

    It is also the least number of edges: ``2n - 3`` in the plane, ``3n - 6`` in space.
    """
    return d * n - d * (d + 1) // 2 if n >= d else n * (n - 1) // 2


def bearing_rigidity_matrix(points, pairs):
    """Return the bearing rigidity matrix, (d m, d n), of ``points`` (n, d) and m ``pairs`` (i, j).

    Blocks ``P(g)/|p_j - p_i|`` in the columns of j, their negative in those of i, with
    ``P(g) = I - g g^T``: how fast bearings change.  Zhao and Zelazo, 2016.
    """
    first, second = np.asarray(pairs, dtype=int).reshape(-1, 2).T
    points = np.asarray(points, dtype=float)
    (n, d), m = points.shape, len(first)
    apart = points[second] - points[first]
    length = np.linalg.norm(apart, axis=1)[:, np.newaxis, np.newaxis]
    g = apart[:, :, np.newaxis] / length
    blocks = (np.eye(d) - g * g.transpose(0, 2, 1)) / length
    matrix = np.zeros((m, n, d, d))
    matrix[np.arange(m), second], matrix[np.arange(m), first] = blocks, -blocks
    return matrix.transpose(0, 2, 1, 3).reshape(d * m, d * n)


def is_infinitesimally_bearing_rigid(points, pairs):
    """Return whether only translation and scaling of ``points`` (n, d) keep all bearings.

    Rank ``d n - d - 1`` of the bearing rigidity matrix.  In the plane that is infinitesimal rigidity; in
    space fewer edges suffice.  Zhao and Zelazo, 2016.
    """
    n, d = np.shape(points)
    rank = np.linalg.matrix_rank(bearing_rigidity_matrix(points, pairs), tol=1e-8)
    return bool(rank == d * n - d - 1)
