"""Gathering and spreading: containment, rendezvous, cyclic pursuit and coverage."""

import numpy as np

from mrs_simulator.core.neighbours import close_pairs

EMPTY = 1e-300  # [-] mass of a cell below which it counts as empty


# Containment -----------------------------------------------------------------------------------


def containment(points, topology, leaders):
    """Return ``u_i = sum_j a_ij (p_j - p_i)``, (n, 2) [m/s], and zero for the last ``leaders`` robots.

    ``points`` p (n, 2) [m].  If every follower hears, over others, some leader, the followers go to
    :func:`containment_limit`, inside the leaders' convex hull.  Ji, Ferrari-Trecate, Egerstedt and
    Buffa, 2008.
    """
    velocity = topology.neighbour_sum(points) - topology.in_degree()[:, np.newaxis] * points
    velocity[len(points) - leaders :] = 0.0
    return velocity


def follower_blocks(topology, leaders):
    """Return ``L_ff`` (f, f) and ``L_fl`` (f, leaders) of the Laplacian, f = n - leaders."""
    count = topology.n - leaders
    rows = topology.laplacian()[:count]
    return rows[:, :count], rows[:, count:]


def all_hear_a_leader(topology, leaders):
    """Return whether each follower hears, over others, one of the last ``leaders`` robots."""
    heard = topology.adjacency() > 0.0
    reached = np.arange(topology.n) >= topology.n - leaders
    for _ in range(topology.n - leaders):
        reached = reached | (heard & reached).any(axis=1)
    return bool(reached.all())


def containment_limit(leader_points, topology):
    """Return ``-L_ff^-1 L_fl p_l``, (f, 2) [m], for the leaders' points ``p_l`` (leaders, 2) [m].

    Each row is a weighted mean of ``p_l``: non-negative weights of sum 1.
    """
    own, from_leaders = follower_blocks(topology, len(leader_points))
    return -np.linalg.solve(own, from_leaders @ leader_points)


def outside_hull(points, corners, directions=720):
    """Return how far ``points`` (..., 2) lie outside the convex hull of ``corners`` (c, 2), (...,) [m].

    Negative inside.  ``max_d d.p - max_c d.c`` over unit vectors d: exact to 1e-5 of the distance.
    """
    angle = 2.0 * np.pi * np.arange(directions) / directions
    normals = np.stack([np.cos(angle), np.sin(angle)])
    support = (np.asarray(corners) @ normals).max(axis=0)
    return (np.asarray(points) @ normals - support).max(axis=-1)


# Rendezvous ------------------------------------------------------------------------------------


def pairs_within(points, radius):
    """Return the pairs (i, j), i < j, of ``points`` (n, 2) [m] closer than ``radius`` [m], (m, 2)."""
    return np.stack(close_pairs(points, radius), axis=1)


def rendezvous(points, pairs, radius):
    """Return ``u_i = sum_j w(d_ij) (p_j - p_i)``, (n, 2) [1/m times m], from ``points`` p (n, 2) [m].

    ``w(d) = (2D - d)/(D - d)^2`` [1/m] with ``D = radius`` [m], over the fixed ``pairs`` (m, 2): minus
    the gradient of :func:`edge_tension`.  From a connected graph whose edges are shorter than D, no
    edge ever reaches D and all meet in their mean.  Ji and Egerstedt, 2007.
    """
    first, second = pairs.T
    apart = points[second] - points[first]
    pull = tension_weights(np.linalg.norm(apart, axis=1), radius)[:, np.newaxis] * apart
    return _summed(first, pull, len(points)) - _summed(second, pull, len(points))


def tension_weights(distance, radius):
    """Return ``w(d) = (2D - d)/(D - d)^2`` [1/m], the shape of ``distance`` d [m]; ``2/D`` at zero."""
    return (2.0 * radius - distance) / (radius - distance) ** 2


def edge_tension(points, pairs, radius):
    """Return ``sum d_ij^2/(D - d_ij)`` [m] over ``pairs`` for ``points`` (..., n, 2); inf from D on."""
    distance = edge_lengths(points, pairs)
    inside = distance < radius
    share = distance**2 / np.where(inside, radius - distance, 1.0)
    return np.where(inside, share, np.inf).sum(axis=-1)


def tension_curvature(points, pairs, radius):
    """Return the largest eigenvalue [1/m] of the second derivative of :func:`edge_tension` at ``points``.

    Along an edge it is ``2 D^2/(D - d)^3``, across it ``w(d)``.  Steps of gain Tc below 2 over this
    make the tension fall.
    """
    n, (first, second) = len(points), pairs.T
    apart = points[second] - points[first]
    distance = np.linalg.norm(apart, axis=1)
    along = apart / np.maximum(distance, EMPTY)[:, np.newaxis]
    across = tension_weights(distance, radius)
    extra = 2.0 * radius**2 / (radius - distance) ** 3 - across
    block = across[:, np.newaxis, np.newaxis] * np.eye(2) + np.einsum(
        "m,mi,mj->mij", extra, along, along
    )
    hessian = np.zeros((n, 2, n, 2))
    for sign, row, column in ((1, first, first), (1, second, second), (-1, first, second)):
        np.add.at(hessian, (row, slice(None), column), sign * block)
    np.add.at(hessian, (second, slice(None), first), -block)
    return float(np.linalg.eigvalsh(hessian.reshape(2 * n, 2 * n))[-1])


def edge_lengths(points, pairs):
    """Return the lengths (..., m) [m] of ``pairs`` (m, 2) among ``points`` (..., n, 2) [m]."""
    first, second = pairs.T
    return np.linalg.norm(points[..., second, :] - points[..., first, :], axis=-1)


def _summed(rows, values, n):
    """Return the sum of ``values`` (m, 2) over equal ``rows`` (m,), (n, 2)."""
    return np.stack([np.bincount(rows, column, n) for column in values.T], axis=1)


# Cyclic pursuit --------------------------------------------------------------------------------


def cyclic_pursuit(points, angle):
    """Return ``u_i = R(a) (p_{i+1} - p_i)``, (n, 2) [m/s], robot n after robot 1; ``angle`` a [rad].

    Spirals in for ``|a| < pi/n``, circles at ``pi/n``, out beyond; the centroid stays.  Marshall,
    Broucke and Francis, 2004.
    """
    ahead = np.roll(points, -1, axis=0) - points
    cos, sin = np.cos(angle), np.sin(angle)
    return ahead @ np.array([[cos, sin], [-sin, cos]])


def pursuit_eigenvalues(n, angle):
    """Return ``e^{ia} (w^k - 1)``, (n,) complex, ``w = e^{2 pi i/n}``: row k belongs to the mode w^{ki}.

    ``z' = M z`` for ``z = x + iy``.  For a > 0 mode n - 1 is the slowest, of real part
    ``-2 sin(pi/n) sin(pi/n - a)``.
    """
    return np.exp(1j * angle) * (np.exp(2j * np.pi * np.arange(n) / n) - 1.0)


def pursuit_modes(points):
    """Return ``points`` (..., n, 2) as amplitudes of the modes of cyclic pursuit, (..., n) complex [m]."""
    return np.fft.fft(points[..., 0] + 1j * points[..., 1]) / points.shape[-2]


def points_of_modes(modes):
    """Return the points (..., n, 2) [m] of amplitudes ``modes`` (..., n)."""
    place = np.fft.ifft(modes) * modes.shape[-1]
    return np.stack([place.real, place.imag], axis=-1)


# Coverage --------------------------------------------------------------------------------------


def square_samples(side, count):
    """Return ``count^2`` points, the middles of equal cells of a square about the origin, (s, 2) [m].

    ``side`` [m] is that of the square.
    """
    middle = side * ((np.arange(count) + 0.5) / count - 0.5)
    x, y = np.meshgrid(middle, middle)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def gaussian_density(samples, centre, width):
    """Return ``exp(-|q - centre|^2 / (2 width^2))``, (s,), at ``samples`` q (s, 2) [m]."""
    apart = samples - np.asarray(centre, dtype=float)
    return np.exp(-np.einsum("sd,sd->s", apart, apart) / (2.0 * width**2))


def cell_centroids(points, samples, density):
    """Return the centroids C_i of the Voronoi cells of ``points`` (n, 2), (n, 2) [m].

    Cells of ``samples`` (s, 2) [m] nearest to each point, weighted by ``density`` (s,); a point with
    an empty cell is its own centroid.
    """
    owner, _ = _nearest(points, samples)
    mass = np.bincount(owner, density, len(points))
    moment = _summed(owner, density[:, np.newaxis] * samples, len(points))
    empty = mass <= EMPTY
    return np.where(
        empty[:, np.newaxis], points, moment / np.where(empty, 1.0, mass)[:, np.newaxis]
    )


def coverage(points, samples, density):
    """Return ``u_i = C_i - p_i``, (n, 2) [m], C_i the centroid of robot i's Voronoi cell.

    Decreases :func:`locational_cost` under any gain k with held inputs as long as ``k Tc < 2``; in
    the end each robot stands at its centroid.  Cortes, Martinez, Karatas and Bullo, 2004.
    """
    return cell_centroids(points, samples, density) - points


def locational_cost(points, samples, density):
    """Return the mean of ``min_i |q - p_i|^2`` over ``samples`` q weighted by ``density`` [m^2]."""
    _, squared = _nearest(points, samples)
    return float(density @ squared / density.sum())


def _nearest(points, samples):
    """Return the nearest of ``points`` (n, 2) to each of ``samples`` (s, 2), and the distance squared."""
    apart = points[:, :1] - samples[:, 0], points[:, 1:] - samples[:, 1]
    squared = apart[0] ** 2 + apart[1] ** 2
    owner = squared.argmin(axis=0)
    return owner, squared[owner, np.arange(len(samples))]
