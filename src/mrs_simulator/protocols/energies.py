"""Lyapunov functions that several families use, and how fast theory says that they fall.

Each is written from its theorem, without the law's code: V of points p (n, d) and its dissipation D with
``V' = -D`` under the law, both one number.  Those of moving things also take velocities v (n, d) and
the time [s].
"""

import numpy as np

from mrs_simulator.protocols.curves import Energy

DOUBLINGS = 60  # [-] most of Smith's method


def laplacian_energy(topology, gain, places=0.0, standing=0):
    """Return ``V = sum_edges a_ij |e_i - e_j|^2 / 2``, ``e = p - places``, of undirected consensus.

    ``D = gain sum_i |sum_j a_ij (e_i - e_j)|^2`` over the robots that move: the last ``standing`` do not.
    Olfati-Saber and Murray, 2004.
    """
    first, second, weights = topology.arcs
    laplacian = topology.laplacian()

    def value(hand):
        away = hand - places
        apart = away[..., first, :] - away[..., second, :]
        return 0.25 * (apart**2).sum(axis=-1) @ weights

    def dissipation(hand):
        pull = laplacian @ (hand - places)
        return gain * _squares(pull[..., : topology.n - standing, :])

    return Energy("$V = p^T L p/2$ [m$^2$]", value, dissipation, stacks=True)


def _squares(points):
    """Return ``|p|^2`` of ``points`` (..., n, d)."""
    return (points**2).sum(axis=(-2, -1))


def averaging_energy(topology, gain, places=0.0):
    """Return the energy of ``p' = -gain L (p - places)``, None where none is known.

    ``V = e^T L e/2`` on an undirected graph, else :func:`disagreement_energy`.
    """
    if gain <= 0.0:
        return None
    if not topology.directed:
        return laplacian_energy(topology, gain, places)
    if topology.n < 2 or not topology.has_spanning_tree():
        return None
    return disagreement_energy(topology.laplacian(), gain, places)


def disagreement_energy(laplacian, gain, places=0.0):
    """Return ``V = z^T P z`` of ``p' = -gain L (p - places)``, L (n, n) directed, and ``D = gain |z|^2``.

    ``z = U^T (p - places)``, U (n, n-1) an orthonormal basis of what robots do not share, and ``M^T P +
    P M = I``, ``M = U^T L U``.  L has a spanning tree, so that all eigenvalues of M are to the right.
    """
    basis = unshared(len(laplacian))
    weight = basis @ lyapunov(basis.T @ laplacian @ basis) @ basis.T

    def value(hand):
        away = hand - places
        return (away * (weight @ away)).sum(axis=(-2, -1))

    def dissipation(hand):
        away = hand - places  # |U^T e| is what is left of e without its mean
        return gain * _squares(away - away.mean(axis=-2, keepdims=True))

    return Energy("$V = e^T P e$ [m$^2$]", value, dissipation, stacks=True)


def unshared(n):
    """Return an orthonormal basis, (n, n-1), of what n robots do not share."""
    return np.linalg.qr(np.column_stack([np.ones(n), np.eye(n)[:, : n - 1]]))[0][:, 1:]


def error_energy(matrix, gain, error, moving=False):
    """Return ``V = e^T P e`` of ``e' = -gain M e``, and ``D = gain |e|^2``.

    M = ``matrix`` has eigenvalues of positive real parts, and ``M^T P + P M = I``.  ``error(p)``, or
    ``error(p, v, t)`` of a ``moving`` goal, returns e, (k, d) [m].
    """
    return _quadratic(matrix, gain, error, moving)


def _quadratic(matrix, gain, error, moving=False):
    weight = lyapunov(matrix)

    def value(*state):
        away = error(*state)
        return float((away * (weight @ away)).sum())

    def dissipation(*state):
        return gain * float((error(*state) ** 2).sum())

    return Energy("$V = e^T P e$ [m$^2$]", value, dissipation, moving)


def lyapunov(matrix):
    """Return P with ``M^T P + P M = I``, M = ``matrix`` with eigenvalues of positive real parts.

    By a Cayley transform and Smith's doubling: P is the sum of ``(A^k)^T W A^k``.
    """
    n = len(matrix)
    if not n:
        return np.zeros((0, 0))
    shift = max(np.linalg.norm(matrix, 2), 1e-300)
    inverse = np.linalg.inv(matrix + shift * np.eye(n))
    step, total = inverse @ (matrix - shift * np.eye(n)), 2.0 * shift * inverse.T @ inverse
    for _ in range(DOUBLINGS):
        added = step.T @ total @ step
        total = total + added
        if np.abs(added).max(initial=0.0) <= 1e-16 * np.abs(total).max(initial=1.0):
            break
        step = step @ step
    return 0.5 * (total + total.T)


def edge_energy(pairs, of_length, slope, gain, name):
    """Return ``V = sum over pairs of of_length(d)`` and ``D = gain sum_i |grad_i V|^2``, robots from 0.

    ``of_length`` and its derivative ``slope`` are functions of the pairs' distances d (m,) [m].
    """
    first, second = np.asarray(pairs, dtype=int).reshape(-1, 2).T

    def value(hand):
        return float(of_length(np.linalg.norm(hand[first] - hand[second], axis=1)).sum())

    def dissipation(hand):
        apart = hand[first] - hand[second]
        distance = np.linalg.norm(apart, axis=1)
        pull = (slope(distance) / np.maximum(distance, 1e-12))[:, np.newaxis] * apart
        total = np.zeros_like(hand)
        np.add.at(total, first, pull)
        np.add.at(total, second, -pull)
        return gain * float((total**2).sum())

    return Energy(name, value, dissipation)
