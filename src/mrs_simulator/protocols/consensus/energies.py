"""Lyapunov functions of second-order consensus: see :mod:`protocols.energies`."""

import numpy as np

from mrs_simulator.core.spectra import unshared
from mrs_simulator.protocols.consensus.equations import unshared_motion
from mrs_simulator.protocols.curves import Energy
from mrs_simulator.protocols.energies import error_energy


def second_order_energy(topology, damping):
    """Return ``V = p^T L p/2 + |v|^2/2`` of ``v' = -L (p + g v)``, undirected, and ``D = g v^T L v``.

    v less the common velocity, which stays.  Over a directed graph ``V = x^T P x``, ``D = |x|^2`` of
    what robots do not share, ``x = (U^T p, U^T v)``; None where that grows.  Ren and Atkins, 2007.
    """
    if topology.directed:
        basis = unshared(topology.n)

        def state(hand, velocity, time):
            return np.concatenate([basis.T @ hand, basis.T @ velocity])

        return error_energy(unshared_motion(topology, damping), 1.0, state, moving=True)
    first, second, weights = topology.arcs

    def stretched(x):
        return 0.5 * float((weights * ((x[first] - x[second]) ** 2).sum(axis=1)).sum())

    def value(hand, velocity, time):
        slip = velocity - velocity.mean(axis=0)
        return 0.5 * stretched(hand) + 0.5 * float((slip**2).sum())

    def dissipation(hand, velocity, time):
        return damping * stretched(velocity)

    return Energy("$V = p^T L p/2 + |v|^2/2$ [m$^2$/s$^2$]", value, dissipation, True)
