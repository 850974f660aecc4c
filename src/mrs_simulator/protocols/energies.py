"""Lyapunov functions that several families use, and how fast theory says that they fall.

Each is written from its theorem, without the law's code: V of points p (n, d) and its dissipation D with
``V' = -D`` under the law, both one number.  Those of moving things also take velocities v (n, d) and
the time [s].
"""

import numpy as np

from mrs_simulator.core.linear_theorem import ZERO
from mrs_simulator.core.sample_blocks import blocks
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


def error_energy(matrix, gain, error, moving=False):
    """Return ``V = z^T P z`` of ``e' = -gain M e``, M = ``matrix``, and ``D = gain |z|^2``, ``z = U^T e``.

    U is an orthonormal basis of all but the null space of M, and ``N^T P + P N = I``, ``N = U^T M U``;
    None where z does not decay.  ``error(p)``, or ``error(p, v, t)`` of a
    ``moving`` goal, returns e, (..., k, d) [m].
    """
    _, singular, rows = np.linalg.svd(matrix)
    basis = rows[singular > ZERO * singular.max(initial=0.0)].T
    among = basis.T @ matrix @ basis
    if np.linalg.eigvals(among).real.min(initial=1.0) <= 0.0:
        return None
    weight, kept = basis @ lyapunov(among) @ basis.T, basis @ basis.T

    def value(*state):
        away = error(*state)
        return (away * (weight @ away)).sum(axis=(-2, -1))

    def dissipation(*state):
        return gain * _squares(kept @ error(*state))

    return Energy("$V = e^T P e$ [m$^2$]", value, dissipation, moving, stacks=not moving)


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

    ``of_length`` and its derivative ``slope`` are functions of the pairs' distances d (..., m) [m].
    """
    first, second = np.asarray(pairs, dtype=int).reshape(-1, 2).T

    def some_pairs(function):  # at a time: those of all states at once take much memory
        def of(hand):
            if hand.ndim == 2:
                return function(hand)
            some = blocks(len(hand), len(first))
            return np.concatenate([function(hand[rows]) for rows in some])

        return of

    def apart_of(hand):  # state after state in memory, so that sums are those of one
        apart = np.take(hand, first, axis=-2) - np.take(hand, second, axis=-2)
        return apart, np.linalg.norm(apart, axis=-1)

    def value(hand):
        return of_length(apart_of(hand)[1]).sum(axis=-1)

    def dissipation(hand):
        apart, distance = apart_of(hand)
        pull = (slope(distance) / np.maximum(distance, 1e-12))[..., np.newaxis] * apart
        total = np.zeros(hand.shape)
        np.add.at(total, (Ellipsis, first, slice(None)), pull)
        np.add.at(total, (Ellipsis, second, slice(None)), -pull)
        return gain * _squares(total)

    return Energy(name, some_pairs(value), some_pairs(dissipation), stacks=True)
