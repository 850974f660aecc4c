"""Gathering and spreading: containment and rendezvous; in the plane, cyclic pursuit and coverage."""

import functools
import itertools
import math

import numpy as np

from mrs_simulator.core.edge_terms import Flow, difference_flow, gathered, inner, pair_flow
from mrs_simulator.core.neighbours import close_pairs, lengths

DIRECTIONS = 720  # [-] in which a hull is looked at besides those of its faces
MOST_FACES = 200000  # [-] lines or planes through corners that may be a hull's faces
FLAT = 1e-9  # [-] of the lengths of a triangle's sides: below, its corners are on one line
EMPTY = 1e-300  # [-] mass of a cell below which it counts as empty


# Containment -----------------------------------------------------------------------------------


def containment_flow(gain, topology, leaders):
    """Return the ``Flow`` ``u_i = gain sum_j a_ij (p_j - p_i)``, (n, d) [m/s]; the last ``leaders`` stand.

    If every follower has a path from some leader, the followers go to
    :func:`containment_limit`, inside the leaders' convex hull.  Ji, Ferrari-Trecate, Egerstedt and
    Buffa, 2008.
    """
    still = tuple(range(topology.n - leaders, topology.n))
    return difference_flow(gain, topology)._replace(still=still)


def follower_blocks(topology, leaders):
    """Return ``L_ff`` (f, f) and ``L_fl`` (f, leaders) of the Laplacian, f = n - leaders."""
    count = topology.n - leaders
    rows = topology.laplacian()[:count]
    return rows[:, :count], rows[:, count:]


def all_reached_by_leaders(topology, leaders):
    """Return whether each follower has a path from one of the last ``leaders`` robots."""
    adjacent = topology.adjacency() > 0.0
    reached = np.arange(topology.n) >= topology.n - leaders
    for _ in range(topology.n - leaders):
        reached = reached | (adjacent & reached).any(axis=1)
    return bool(reached.all())


def containment_limit(leader_points, topology):
    """Return ``-L_ff^-1 L_fl p_l``, (f, d) [m], for the leaders' points ``p_l`` (leaders, d) [m].

    Each row is a weighted mean of ``p_l``: non-negative weights of sum 1.
    """
    own, from_leaders = follower_blocks(topology, len(leader_points))
    return -np.linalg.solve(own, from_leaders @ leader_points)


def outside_hull(points, corners):
    """Return how far ``points`` (..., d) lie outside the convex hull of ``corners`` (c, d), (...,) [m].

    ``max_u u.p - max_c u.c`` over unit vectors u: the normals of the hull's faces and directions all
    round.  Exact, and negative inside, where a face is nearest; beyond an edge or a corner a lower bound
    above 0.  Of more than ``MOST_FACES`` candidates for faces directions all round alone.
    """
    points, corners = np.asarray(points, dtype=float), np.asarray(corners, dtype=float)
    found = np.full(points.shape[:-1], -np.inf)
    for normals in (_all_round(points.shape[-1]), _face_normals(corners)):
        for some in np.array_split(normals, 1 + len(normals) // 10000):
            support = (corners @ some.T).max(axis=0)
            beyond = (points @ some.T - support).max(axis=-1, initial=-np.inf)
            found = np.maximum(found, beyond)
    return found


def _all_round(dimension):
    """Return unit vectors (k, d) spread evenly over all directions: in space along a spiral."""
    turn = np.arange(DIRECTIONS) + 0.5
    if dimension == 2:
        angle = 2.0 * np.pi * (turn - 0.5) / DIRECTIONS
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    z, angle = 1.0 - 2.0 * turn / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * turn
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def _face_normals(corners):
    """Return the unit normals (k, d), both ways, of all lines or planes through d of ``corners`` (c, d)."""
    count, dimension = corners.shape
    if math.comb(count, dimension) > MOST_FACES:
        return np.empty((0, dimension))
    chosen = np.array(list(itertools.combinations(range(count), dimension)), dtype=int)
    chosen = corners[chosen.reshape(-1, dimension)]
    along = chosen[:, 1:] - chosen[:, :1]
    if dimension == 2:
        normals = along[:, 0] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    else:
        normals = np.cross(along[:, 0], along[:, 1])
    length = np.linalg.norm(normals, axis=1)
    spans = length > FLAT * np.prod(np.linalg.norm(along, axis=2), axis=1)
    normals = normals[spans] / length[spans, np.newaxis]
    return np.concatenate([normals, -normals])


# Rendezvous ------------------------------------------------------------------------------------


def pairs_within(points, radius):
    """Return the pairs (i, j), i < j, of ``points`` (n, d) [m] closer than ``radius`` [m], (m, 2)."""
    return np.stack(close_pairs(points, radius), axis=1)


def rendezvous_flow(gain, pairs, radius):
    """Return the ``Flow`` ``u_i = gain sum_j w(d_ij) (p_j - p_i)``, (n, d) [1/m times m] per gain.

    ``w(d) = (2D - d)/(D - d)^2`` [1/m] with ``D = radius`` [m], over the fixed ``pairs`` (m, 2): minus
    the gradient of the tension ``sum d_ij^2/(D - d_ij)``.  From a connected graph whose edges are
    shorter than D, no edge ever reaches D and all meet in their mean.  Ji and Egerstedt, 2007.
    """
    return pair_flow(gain, tension, pairs.T, radius)


def tension(apart, radius):
    """Return the term ``w(d_ij) (p_j - p_i)``."""
    return tension_weights(np.sqrt(inner(apart, apart)), radius) * apart


def tension_weights(distance, radius):
    """Return ``w(d) = (2D - d)/(D - d)^2`` [1/m], the shape of ``distance`` d [m]; ``2/D`` at zero."""
    return (2.0 * radius - distance) / (radius - distance) ** 2


def tension_curvature(points, pairs, radius):
    """Return the largest eigenvalue [1/m] of the second derivative of the tension at ``points``.

    Along an edge it is ``2 D^2/(D - d)^3``, across it ``w(d)``.  Steps of gain Tc below 2 over this
    make the tension fall.
    """
    (n, dimension), (first, second) = points.shape, pairs.T
    apart = points[second] - points[first]
    distance = np.linalg.norm(apart, axis=1)
    along = apart / np.maximum(distance, EMPTY)[:, np.newaxis]
    across = tension_weights(distance, radius)
    extra = 2.0 * radius**2 / (radius - distance) ** 3 - across
    block = across[:, np.newaxis, np.newaxis] * np.eye(dimension) + np.einsum(
        "m,mi,mj->mij", extra, along, along
    )
    hessian = np.zeros((n, dimension, n, dimension))
    for sign, row, column in ((1, first, first), (1, second, second), (-1, first, second)):
        np.add.at(hessian, (row, slice(None), column), sign * block)
    np.add.at(hessian, (second, slice(None), first), -block)
    return float(np.linalg.eigvalsh(hessian.reshape(points.size, points.size))[-1])


def edge_lengths(points, pairs):
    """Return the lengths (..., m) [m] of ``pairs`` (m, 2) among ``points`` (..., n, d) [m]."""
    first, second = pairs.T
    return lengths(points[..., second, :] - points[..., first, :])


# Cyclic pursuit --------------------------------------------------------------------------------


def cyclic_pursuit(points, angle):
    """Return ``u_i = R(a) (p_{i+1} - p_i)``, (n, 2) [m/s], robot n after robot 1; ``angle`` a [rad].

    Spirals in for ``|a| < pi/n``, circles at ``pi/n``, out beyond; the centroid stays.  Marshall,
    Broucke and Francis, 2004.
    """
    ahead = np.roll(points, -1, axis=0) - points
    cos, sin = np.cos(angle), np.sin(angle)
    return ahead @ np.array([[cos, sin], [-sin, cos]])


def pursuit_flow(gain, n, angle):
    """Return the ``Flow`` of ``gain`` times :func:`cyclic_pursuit` of n robots."""
    summed = functools.partial(cyclic_pursuit, angle=angle)
    return Flow(gain, turned, _ring(n), (math.cos(angle), math.sin(angle)), summed)


@functools.lru_cache(maxsize=8)
def _ring(n):
    return np.arange(n), np.roll(np.arange(n), -1)


def turned(apart, cos, sin):
    """Return the term ``R(a) (p_j - p_i)``, of the cosine and sine of a."""
    ahead = np.empty_like(apart)
    ahead[0] = cos * apart[0] - sin * apart[1]
    ahead[1] = sin * apart[0] + cos * apart[1]
    return ahead


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


def inside(points, corners):
    """Return which ``points`` (s, 2) lie in the polygon about ``corners`` (k, 2), (s,) bool.

    A ray to the right crosses its sides an odd number of times.
    """
    x, y = points.T
    within = np.zeros(len(points), dtype=bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0)):
        if ay == by:
            continue
        crossed = (ay > y) != (by > y)
        within ^= crossed & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return within


def cell_centroids(points, samples, density):
    """Return the centroids C_i of the Voronoi cells of ``points`` (n, 2), (n, 2) [m].

    Cells of ``samples`` (s, 2) [m] nearest to each point, weighted by ``density`` (s,); a point with
    an empty cell is its own centroid.
    """
    owner, _ = _nearest(points, samples)
    mass = np.bincount(owner, density, len(points))
    moment = gathered(density * samples.T, owner, len(points))
    empty = mass <= EMPTY
    return np.where(
        empty[:, np.newaxis], points, moment / np.where(empty, 1.0, mass)[:, np.newaxis]
    )


def coverage(points, samples, density):
    """Return ``u_i = C_i - p_i``, (n, 2) [m], C_i the centroid of robot i's Voronoi cell.

    Decreases the locational cost under any gain k with held inputs as long as ``k Tc < 2``; in
    the end each robot stands at its centroid.  Cortes, Martinez, Karatas and Bullo, 2004.
    """
    return cell_centroids(points, samples, density) - points


def _nearest(points, samples):
    """Return the nearest of ``points`` (n, 2) to each of ``samples`` (s, 2), and the distance squared.

    Of equals the first.  Point by point, along rows: numpy looks for least values of columns more slowly.
    """
    apart = points[:, :1] - samples[:, 0], points[:, 1:] - samples[:, 1]
    squared = apart[0] ** 2 + apart[1] ** 2
    owner, least = np.zeros(len(samples), dtype=int), squared[0]
    for row in range(1, len(points)):
        np.copyto(owner, row, where=squared[row] < least)
        np.minimum(least, squared[row], out=least)
    return owner, least
