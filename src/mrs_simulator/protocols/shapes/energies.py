"""Lyapunov functions of formations by lengths and bearings: see :mod:`protocols.energies`."""

import numpy as np

from mrs_simulator.protocols.curves import Energy
from mrs_simulator.protocols.energies import edge_energy


def length_energy(topology, places, gain):
    """Return ``V = sum_edges a_ij (d^2 - d_ij^2)^2/4``, ``d_ij`` the lengths of ``places`` (n, d) [m].

    Krick, Broucke and Francis, 2009.
    """
    first, second, weights = _edges(topology)
    pairs = np.stack([first, second], axis=1)
    wanted = ((places[first] - places[second]) ** 2).sum(axis=1)
    return edge_energy(
        pairs,
        lambda d: 0.25 * weights * (d**2 - wanted) ** 2,
        lambda d: weights * (d**2 - wanted) * d,
        gain,
        "potential of the lengths [m$^4$]",
    )


def _edges(topology):
    """Return rows and weights of the arcs of an undirected graph, each pair once."""
    first, second, weights = topology.arcs
    once = first < second
    return first[once], second[once], weights[once]


def _units(apart):
    return apart / np.maximum(np.linalg.norm(apart, axis=1), 1e-12)[:, np.newaxis]


def bearing_energy(topology, goal, gain):
    """Return ``V = |p - p*|^2/2`` of the law by bearings alone, and its dissipation.

    ``goal``: p*, (n, d) [m], with the wanted bearings and the centroid and scale of the start, which
    stay.  ``D = gain sum_edges a_ij |p*_ij| g*_ij^T P(g_ij) g*_ij``.  Zhao and Zelazo, 2016.
    """
    first, second, weights = _edges(topology)
    far = goal[first] - goal[second]
    wanted = _units(far)
    stretch = weights * np.linalg.norm(far, axis=1)

    def value(hand):
        return 0.5 * float(((hand - goal) ** 2).sum())

    def dissipation(hand):
        along = (wanted * _units(hand[first] - hand[second])).sum(axis=1)
        return gain * float((stretch * (1.0 - along**2)).sum())

    return Energy("$V = |p - p^*|^2/2$ [m$^2$]", value, dissipation)
