"""Formations: robots take a shape, given by displacements, distances or bearings between neighbours.

``points`` p and ``places`` d are (n, 2) [m]; only differences of places matter.  Edges (i, j) say
that i hears j, ``p_ij = p_i - p_j`` and ``g_ij = (p_j - p_i)/|p_j - p_i|``.
"""

import numpy as np

SHAPES = ("line", "circle", "vee", "grid")


def shape_places(shape, n, size):
    """Return where n robots stand in ``shape``, (n, 2) [m], about their centroid, facing along x.

    ``size`` [m] is the distance from one robot to the next.  ``line``: along x, robot 1 in front;
    ``circle``: counter-clockwise from the front; ``vee``: robot 1 at the tip, the others behind it
    in turn to its left and right; ``grid``: rows side by side, the first in front.
    """
    row = np.arange(n)
    if shape == "line":
        places = np.stack([-row, 0 * row], axis=1) * size
    elif shape == "circle":
        angle = 2.0 * np.pi * row / n
        radius = size / (2.0 * np.sin(np.pi / n)) if n > 1 else 0.0
        places = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    elif shape == "vee":
        rank, side = (row + 1) // 2, np.where(row % 2, 1, -1)
        places = np.stack([-rank, rank * side], axis=1) * size * np.sqrt(0.5)
    elif shape == "grid":
        width = int(np.ceil(np.sqrt(n)))
        places = np.stack([-(row // width), -(row % width)], axis=1) * size
    else:
        raise ValueError("shape {!r}: wanted one of {}".format(shape, ", ".join(SHAPES)))
    return places - places.mean(axis=0)


def displacement_formation(points, places, topology):
    """Return ``u_i = sum_j a_ij (p_j - p_i - (d_j - d_i))``, (n, 2) [m/s].

    With a spanning tree ``p -> d + w^T (p(0) - d)``, ``w`` the left null vector of L; on an
    undirected graph the centroid stays and the error decays at ``lambda_2``.  Oh, Park, Ahn, 2015.
    """
    away = points - places
    return topology.neighbour_sum(away) - topology.in_degree()[:, np.newaxis] * away


def distance_formation(points, places, topology):
    """Return ``u_i = -sum_j a_ij (|p_ij|^2 - d_ij^2) p_ij``, (n, 2) [m^3], ``d_ij = |d_i - d_j|``.

    The gradient descent of :func:`distance_potential` on an undirected graph: the centroid stays.
    Where the target is infinitesimally rigid (at least 2n - 3 edges) its lengths are reached from
    nearby, exponentially.  Krick, Broucke, Francis, 2009.
    """
    hears, heard, weight = topology.arcs
    excess = length_excess(points[np.newaxis], places, topology)[0]
    return _summed(
        -(weight * excess)[:, np.newaxis] * (points[hears] - points[heard]), hears, points
    )


def length_excess(points, places, topology):
    """Return ``|p_ij|^2 - d_ij^2``, (m, arcs) [m^2], of ``points`` (m, n, 2)."""
    hears, heard, _ = topology.arcs
    wanted = np.sum((places[hears] - places[heard]) ** 2, axis=-1)
    return np.sum((points[:, hears] - points[:, heard]) ** 2, axis=-1) - wanted


def distance_potential(points, places, topology):
    """Return ``V = 1/4 sum_edges a_ij (|p_ij|^2 - d_ij^2)^2``, (m,) [m^4], of ``points`` (m, n, 2)."""
    weight = topology.arcs[2]
    # Each undirected edge is there in both directions.
    return 0.125 * length_excess(points, places, topology) ** 2 @ weight


def distance_hessian(points, topology):
    """Return the Hessian of the potential where all lengths are right, (2n, 2n) [m^2].

    ``2 R^T W R``, with R the rigidity matrix of ``points`` (n, 2): errors decay at its eigenvalues.
    """
    hears, heard, weight = topology.arcs
    apart = points[hears] - points[heard]
    return _block_laplacian(apart[:, :, np.newaxis] * apart[:, np.newaxis], topology, 2.0 * weight)


def bearings(points, topology):
    """Return ``g_ij``, (..., arcs, 2), of ``points`` (..., n, 2); zero where two points coincide."""
    hears, heard, _ = topology.arcs
    towards = points[..., heard, :] - points[..., hears, :]
    length = np.linalg.norm(towards, axis=-1, keepdims=True)
    return towards / np.where(length > 0.0, length, 1.0)


def bearing_formation(points, places, topology):
    """Return ``u_i = -sum_j a_ij P(g_ij) g*_ij``, (n, 2), ``P(g) = I - g g^T``, ``g*`` of ``places``.

    On an undirected graph centroid and scale ``sqrt(sum |p_i - c|^2)`` stay; where the target is
    infinitesimally rigid the bearings converge to ``g*`` from almost everywhere.  Zhao, Zelazo,
    2016.
    """
    hears, _, weight = topology.arcs
    have, want = bearings(points, topology), bearings(places, topology)
    across = want - np.sum(have * want, axis=1, keepdims=True) * have
    return _summed(-weight[:, np.newaxis] * across, hears, points)


def bearing_leaders(points, places, topology, leaders=2):
    """Return ``u_i = -sum_j a_ij P(g*_ij)(p_i - p_j)``, (n, 2) [m]; the first ``leaders`` stand still.

    Where ``B_ff`` of :func:`bearing_laplacian` is regular, the followers reach the one formation
    with these bearings that fits the leaders, ``-B_ff^-1 B_fl p_l``.  Zhao, Zelazo, 2016.
    """
    hears, heard, weight = topology.arcs
    want, apart = bearings(places, topology), points[hears] - points[heard]
    across = apart - np.sum(apart * want, axis=1, keepdims=True) * want
    velocity = _summed(-weight[:, np.newaxis] * across, hears, points)
    velocity[:leaders] = 0.0
    return velocity


def bearing_laplacian(places, topology, over_length=False):
    """Return the bearing Laplacian B, (2n, 2n): blocks ``-a_ij P(g*_ij)``, rows sum to zero.

    ``over_length`` divides each weight by ``|d_j - d_i|`` [m]: the linearisation of
    :func:`bearing_formation` about ``places``.
    """
    hears, heard, weight = topology.arcs
    if over_length:
        weight = weight / np.linalg.norm(places[heard] - places[hears], axis=1)
    g = bearings(places, topology)
    projections = np.eye(2) - g[:, :, np.newaxis] * g[:, np.newaxis]
    return _block_laplacian(projections, topology, weight)


def fitted_to_leaders(points, places, topology, leaders=2):
    """Return the formation (n, 2) with the bearings of ``places`` and the leaders of ``points``."""
    laplacian, known = bearing_laplacian(places, topology), 2 * leaders
    followers = np.linalg.solve(
        laplacian[known:, known:], -laplacian[known:, :known] @ points[:leaders].ravel()
    )
    return np.concatenate([points[:leaders], followers.reshape(-1, 2)])


def scale(points):
    """Return ``sqrt(sum |p_i - c|^2)``, (...) [m], of ``points`` (..., n, 2), c their centroid."""
    return np.linalg.norm(points - points.mean(axis=-2, keepdims=True), axis=(-2, -1))


def _summed(terms, hears, points):
    total = np.zeros_like(points, dtype=float)
    np.add.at(total, hears, terms)
    return total


def _block_laplacian(blocks, topology, weight):
    """Return the (2n, 2n) matrix with ``-weight blocks`` (arcs, 2, 2) beside its block diagonal."""
    hears, heard, _ = topology.arcs
    blocks = weight[:, np.newaxis, np.newaxis] * blocks
    matrix = np.zeros((topology.n, topology.n, 2, 2))
    np.add.at(matrix, (hears, heard), -blocks)
    np.add.at(matrix, (hears, hears), blocks)
    return matrix.transpose(0, 2, 1, 3).reshape(2 * topology.n, 2 * topology.n)
