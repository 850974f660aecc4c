"""Lyapunov functions of the shipped laws and how fast theory says that they fall.

Each is written from its theorem, without the law's code: V of hand points p (n, 2) and its dissipation
D with ``V' = -D`` under the law, both one number.
"""

import numpy as np

from mrs_simulator.core.curves import Energy


def laplacian_energy(topology, gain, places=0.0, standing=0):
    """Return ``V = sum_edges a_ij |e_i - e_j|^2 / 2``, ``e = p - places``, of undirected consensus.

    ``D = gain sum_i |sum_j a_ij (e_i - e_j)|^2`` over the robots that move: the last ``standing`` do not.
    Olfati-Saber and Murray, 2004.
    """
    first, second, weights = topology.arcs

    def pulls(hand):
        away = hand - places
        return weights[:, np.newaxis] * (away[first] - away[second]), away

    def value(hand):
        pull, away = pulls(hand)
        return 0.25 * float((pull * (away[first] - away[second])).sum())

    def dissipation(hand):
        total = np.zeros_like(hand)
        np.add.at(total, first, pulls(hand)[0])
        return gain * float((total[: len(hand) - standing] ** 2).sum())

    return Energy("$V = p^T L p/2$ [m$^2$]", value, dissipation)


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


def tension_energy(pairs, radius, gain):
    """Return ``V = sum d^2/(D - d)`` over ``pairs`` (m, 2), D = ``radius``: Ji and Egerstedt, 2007."""

    def slope(d):
        return (2.0 * radius * d - d**2) / (radius - d) ** 2

    return edge_energy(pairs, lambda d: d**2 / (radius - d), slope, gain, "edge tension [m]")


def length_energy(topology, places, gain):
    """Return ``V = sum_edges a_ij (d^2 - d_ij^2)^2/4``, ``d_ij`` the lengths of ``places`` (n, 2) [m].

    Krick, Broucke and Francis, 2009.
    """
    first, second, weights = topology.arcs
    once = first < second
    pairs, weights = np.stack([first[once], second[once]], axis=1), weights[once]
    wanted = ((places[first[once]] - places[second[once]]) ** 2).sum(axis=1)
    return edge_energy(
        pairs,
        lambda d: 0.25 * weights * (d**2 - wanted) ** 2,
        lambda d: weights * (d**2 - wanted) * d,
        gain,
        "potential of the lengths [m$^4$]",
    )


def coverage_energy(samples, density, gain):
    """Return the locational cost ``H`` and ``D = 2 gain sum_i M_i |C_i - p_i|^2``.

    ``H = sum_q phi(q) min_i |q - p_i|^2 / sum_q phi(q)`` over the ``samples`` q (k, 2) of ``density``
    phi (k,); ``M_i``, ``C_i`` are mass and centroid of the cell of robot i.  Cortes, Martinez, Karatas
    and Bullo, 2004.
    """
    share = density / density.sum()

    def cells(hand):
        squared = ((samples[:, np.newaxis] - hand[np.newaxis]) ** 2).sum(axis=2)
        return squared, squared.argmin(axis=1)

    def value(hand):
        squared, owner = cells(hand)
        return float(share @ squared[np.arange(len(samples)), owner])

    def dissipation(hand):
        owner = cells(hand)[1]
        mass = np.bincount(owner, share, len(hand))
        drawn = np.stack(
            [np.bincount(owner, share * column, len(hand)) for column in samples.T], axis=1
        )
        moment = drawn - mass[:, np.newaxis] * hand  # M_i (C_i - p_i)
        return 2.0 * gain * float((moment**2).sum(axis=1) @ (1.0 / np.maximum(mass, 1e-300)))

    return Energy("locational cost $H$ [m$^2$]", value, dissipation)
