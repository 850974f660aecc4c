"""Lyapunov functions of second-order consensus: see :mod:`protocols.energies`."""

import numpy as np

from mrs_simulator.protocols.curves import Energy
from mrs_simulator.protocols.energies import error_energy, unshared


def second_order_energy(topology, damping):
    """Return ``V = p^T L p/2 + |v|^2/2`` of ``v' = -L (p + g v)``, undirected, and ``D = g v^T L v``.

    v less the common velocity, which stays.  Over a directed graph ``V = x^T P x``, ``D = |x|^2`` of
    what robots do not share, ``x = (U^T p, U^T v)``; None where that grows.  Ren and Atkins, 2007.
    """
    if topology.directed:
        return _of_what_is_not_shared(topology.laplacian(), damping)
    first, second, weights = topology.arcs

    def stretched(x):
        return 0.5 * float((weights * ((x[first] - x[second]) ** 2).sum(axis=1)).sum())

    def value(hand, velocity, time):
        slip = velocity - velocity.mean(axis=0)
        return 0.5 * stretched(hand) + 0.5 * float((slip**2).sum())

    def dissipation(hand, velocity, time):
        return damping * stretched(velocity)

    return Energy("$V = p^T L p/2 + |v|^2/2$ [m$^2$/s$^2$]", value, dissipation, True)


def _of_what_is_not_shared(laplacian, damping):
    nothing, one = np.zeros_like(laplacian), np.eye(len(laplacian))
    matrix = np.block([[nothing, -one], [laplacian, damping * laplacian]])

    def state(hand, velocity, time):
        return np.concatenate([hand, velocity])

    basis = np.kron(np.eye(2), unshared(len(laplacian)))
    return error_energy(matrix, 1.0, state, moving=True, basis=basis)
