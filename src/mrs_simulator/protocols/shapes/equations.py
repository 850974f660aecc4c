"""Formations: robots take a shape, given by displacements, distances or bearings between neighbours.

``points`` p and ``places`` d are (n, d) [m], in the plane or in space; only differences of places matter.
Over an edge (i, j) robot i receives from j, ``p_ij = p_i - p_j`` and ``g_ij = (p_j - p_i)/|p_j - p_i|``.
"""

import numpy as np

from mrs_simulator.core.edge_terms import apart, difference_flow, edge_flow, inner, unit
from mrs_simulator.protocols.common import level

SHAPES = ("line", "circle", "vee", "grid")


def shape_places(shape, n, size, dimension=2):
    """Return where n robots stand in ``shape``, (n, d) [m], about their centroid, facing along x.

    ``size`` [m] is the distance from one robot to the next.  ``line``: along x, robot 1 in front;
    ``circle``: counter-clockwise from the front; ``vee``: robot 1 at the tip, the others behind it
    in turn to its left and right; ``grid``: rows side by side, the first in front.  In space, d =
    ``dimension`` = 3, a grid is cubic, layer on layer; the other shapes lie level.
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
        places = np.stack(_grid_cells(row, n, dimension), axis=1) * size
    else:
        raise ValueError("shape {!r}: wanted one of {}".format(shape, ", ".join(SHAPES)))
    return level(places - places.mean(axis=0), dimension)


def _grid_cells(row, n, dimension):
    """Return the cells of ``row`` (n,) in a grid as wide as it is long, and in space as it is high."""
    width = int(np.ceil(np.round(n ** (1.0 / dimension), 9)))
    if dimension == 2:
        return -(row // width), -(row % width)
    return -(row // width % width), -(row % width), row // width**2


def displacement_flow(gain, places, topology):
    """Return the ``Flow`` ``u_i = gain sum_j a_ij (p_j - p_i - (d_j - d_i))``, (n, d) [m/s].

    With a spanning tree ``p -> d + w^T (p(0) - d)``, ``w`` the left null vector of L; on an
    undirected graph the centroid stays and the error decays at ``lambda_2``.  Oh, Park, Ahn, 2015.
    """
    return difference_flow(gain, topology, places)


def distance_flow(gain, places, topology):
    """Return the ``Flow`` ``u_i = -gain sum_j a_ij (|p_ij|^2 - d_ij^2) p_ij``, ``d_ij = |d_i - d_j|``.

    (n, d) [m^3] per gain, the gradient descent of ``sum_edges a_ij (|p_ij|^2 - d_ij^2)^2/4`` on an
    undirected graph: the centroid stays.
    Where the target is infinitesimally rigid (at least 2n - 3 edges, in space 3n - 6) its lengths are
    reached from nearby, exponentially.  Krick, Broucke, Francis, 2009.
    """
    wanted = apart(places, topology.arcs)
    return edge_flow(gain, spring, topology.arcs, topology.arcs[2], inner(wanted, wanted))


def spring(apart, weight, wanted):
    """Return the term ``a_ij (|p_ij|^2 - d_ij^2) (p_j - p_i)``, ``wanted`` (m,) being ``d_ij^2``."""
    return weight * (inner(apart, apart) - wanted) * apart


def length_excess(points, places, topology):
    """Return ``|p_ij|^2 - d_ij^2``, (m, arcs) [m^2], of ``points`` (m, n, d)."""
    receiver, sender, _ = topology.arcs
    wanted = np.sum((places[receiver] - places[sender]) ** 2, axis=-1)
    return np.sum((points[:, receiver] - points[:, sender]) ** 2, axis=-1) - wanted


def imbalance(points, places, topology):
    """Return ``sum_i |sum_j f_ij| / sum_ij |f_ij|`` of the terms of :func:`distance_flow`.

    At ``points`` (n, d): 0 where all robots rest though lengths are wrong, 1 without terms.
    """
    terms, sums = _descent(points, places, topology)
    whole = np.linalg.norm(terms, axis=1).sum()
    return float(np.linalg.norm(sums, axis=1).sum() / whole) if whole > 0.0 else 1.0


def descent(points, places, topology):
    """Return minus the gradient (n, d) [m^3] of :func:`length_potential`, by which a theorem is checked.

    It shares nothing with the law, which is to be that.
    """
    return _descent(points, places, topology)[1]


def _descent(points, places, topology):
    """Return the terms (arcs, d) and the sums (n, d) of minus the gradient of the potential."""
    receiver, sender, weight = topology.arcs
    excess = weight * length_excess(points[np.newaxis], places, topology)[0]
    terms, sums = excess[:, np.newaxis] * (points[sender] - points[receiver]), np.zeros_like(points)
    np.add.at(sums, receiver, terms)
    return terms, sums


def lengthening(points, modes, topology):
    """Return ``a_ij p_ij . (v_i - v_j)``, (arcs, k) [m], of ``modes`` v (d n, k) of ``points`` (n, d).

    Of modes of :func:`distance_hessian`: the :func:`length_excess` that decays with each is along it.
    """
    receiver, sender, weight = topology.arcs
    along = points[receiver] - points[sender]
    moved = modes.reshape(points.shape + (-1,))
    apart = moved[receiver] - moved[sender]
    return weight[:, np.newaxis] * np.einsum("ad,adk->ak", along, apart)


def distance_hessian(points, topology):
    """Return the Hessian of the potential where all lengths are right, (d n, d n) [m^2].

    ``2 R^T W R``, with R the rigidity matrix of ``points`` (n, d): errors decay at its eigenvalues.
    """
    receiver, sender, weight = topology.arcs
    along = points[receiver] - points[sender]
    return _block_laplacian(along[:, :, np.newaxis] * along[:, np.newaxis], topology, 2.0 * weight)


def length_potential(points, places, topology):
    """Return ``V = sum_edges a_ij (|p_ij|^2 - d_ij^2)^2/4`` [m^4] of ``points`` (n, d), each edge once."""
    excess = length_excess(points[np.newaxis], places, topology)[0]
    return 0.125 * float(topology.arcs[2] @ excess**2)


def potential_curvature(potential, places, topology):
    """Return a bound [m^2] on the curvature of V wherever V is at most ``potential`` [m^4].

    Along x, |x| = 1, it is ``sum a_ij (e_ij |x_ij|^2 + 2 (p_ij . x_ij)^2)``, ``e_ij = |p_ij|^2 -
    d_ij^2``, at most ``sum a_ij (2 d_ij^2 + 3 e_ij) |x_ij|^2``; there, with ``|x_ij|^2 <= 2``,

        sum a_ij e_ij |x_ij|^2 <= 2 sqrt(V) sqrt(sum a_ij |x_ij|^4) <= 2 sqrt(2 V lambda_max(L)).

    A step of gradient descent below 2 over it never makes V grow.
    """
    receiver, sender, weight = topology.arcs
    squares = np.sum((places[receiver] - places[sender]) ** 2, axis=-1)
    stiff, plain = (
        _block_laplacian(each[:, np.newaxis, np.newaxis], topology, weight)
        for each in (2.0 * squares, np.ones_like(squares))
    )
    at_rest, largest = (np.linalg.eigvalsh(each)[-1] for each in (stiff, plain))
    return float(at_rest + 6.0 * np.sqrt(2.0 * potential * largest))


def bearings(points, topology):
    """Return ``g_ij``, (..., arcs, d), of ``points`` (..., n, d); zero where two points coincide."""
    receiver, sender, _ = topology.arcs
    towards = points[..., sender, :] - points[..., receiver, :]
    length = np.linalg.norm(towards, axis=-1, keepdims=True)
    return towards / np.where(length > 0.0, length, 1.0)


def bearing_flow(gain, places, topology):
    """Return the ``Flow`` ``u_i = -gain sum_j a_ij P(g_ij) g*_ij``, (n, d), ``P(g) = I - g g^T``.

    ``g*``: of ``places``.  On an undirected graph centroid and scale ``sqrt(sum |p_i - c|^2)`` stay; where
    the target is infinitesimally bearing rigid the bearings converge to ``g*`` from almost everywhere.
    Zhao, Zelazo, 2016.
    """
    wanted = unit(apart(places, topology.arcs))
    return edge_flow(gain, off_bearing, topology.arcs, topology.arcs[2], wanted)


def off_bearing(apart, weight, wanted):
    """Return the term ``-a_ij P(g_ij) g*_ij``, ``wanted`` (d, m) being ``g*_ij``."""
    have = unit(apart)
    return -weight * (wanted - inner(have, wanted) * have)


def leaders_flow(gain, places, topology, leaders=2):
    """Return the ``Flow`` ``u_i = -gain sum_j a_ij P(g*_ij)(p_i - p_j)``, (n, d) [m] per gain.

    The first ``leaders`` stand still.  Where ``B_ff`` of :func:`bearing_laplacian` is regular, the
    followers reach the one formation with these bearings that fits the leaders, ``-B_ff^-1 B_fl p_l``.
    Zhao, Zelazo, 2016.
    """
    wanted, still = unit(apart(places, topology.arcs)), tuple(range(leaders))
    flow = edge_flow(gain, beside_bearing, topology.arcs, topology.arcs[2], wanted)
    return flow._replace(still=still)


def beside_bearing(apart, weight, wanted):
    """Return the term ``a_ij P(g*_ij)(p_j - p_i)``, ``wanted`` (d, m) being ``g*_ij``."""
    return weight * (apart - inner(apart, wanted) * wanted)


def bearing_laplacian(places, topology, over_length=False):
    """Return the bearing Laplacian B, (d n, d n): blocks ``-a_ij P(g*_ij)``, rows sum to zero.

    ``over_length`` divides each weight by ``|d_j - d_i|`` [m]: the linearisation of
    :func:`bearing_flow` about ``places``.
    """
    receiver, sender, weight = topology.arcs
    if over_length:
        weight = weight / np.linalg.norm(places[sender] - places[receiver], axis=1)
    g = bearings(places, topology)
    projections = np.eye(places.shape[1]) - g[:, :, np.newaxis] * g[:, np.newaxis]
    return _block_laplacian(projections, topology, weight)


def fitted_to_leaders(points, places, topology, leaders=2):
    """Return the formation (n, d) with the bearings of ``places`` and the leaders of ``points``."""
    dimension = points.shape[1]
    laplacian, known = bearing_laplacian(places, topology), dimension * leaders
    followers = np.linalg.solve(
        laplacian[known:, known:], -laplacian[known:, :known] @ points[:leaders].ravel()
    )
    return np.concatenate([points[:leaders], followers.reshape(-1, dimension)])


def scale(points):
    """Return ``sqrt(sum |p_i - c|^2)``, (...) [m], of ``points`` (..., n, d), c their centroid."""
    return np.linalg.norm(points - points.mean(axis=-2, keepdims=True), axis=(-2, -1))


def _block_laplacian(blocks, topology, weight):
    """Return the (d n, d n) matrix with ``-weight blocks`` (arcs, d, d) beside its block diagonal."""
    receiver, sender, _ = topology.arcs
    blocks = weight[:, np.newaxis, np.newaxis] * blocks
    n, dimension = topology.n, blocks.shape[-1]
    matrix = np.zeros((n, n, dimension, dimension))
    np.add.at(matrix, (receiver, sender), -blocks)
    np.add.at(matrix, (receiver, receiver), blocks)
    return matrix.transpose(0, 2, 1, 3).reshape(dimension * n, dimension * n)
