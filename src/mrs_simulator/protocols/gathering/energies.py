"""Lyapunov functions of rendezvous and coverage: see :mod:`protocols.energies`."""

import numpy as np

from mrs_simulator.protocols.curves import Energy
from mrs_simulator.protocols.energies import edge_energy


def tension_energy(pairs, radius, gain):
    """Return ``V = sum d^2/(D - d)`` over ``pairs`` (m, 2), D = ``radius``: Ji and Egerstedt, 2007."""

    def slope(d):
        return (2.0 * radius * d - d**2) / (radius - d) ** 2

    return edge_energy(pairs, lambda d: d**2 / (radius - d), slope, gain, "edge tension [m]")


def coverage_energy(samples, density, gain):
    """Return the locational cost ``H`` and ``D = 2 gain sum_i M_i |C_i - p_i|^2``.

    ``H = sum_q phi(q) min_i |q - p_i|^2 / sum_q phi(q)`` over the ``samples`` q (k, d) of ``density``
    phi (k,); ``M_i``, ``C_i`` are mass and centroid of the cell of robot i.  Cortes, Martinez, Karatas
    and Bullo, 2004.
    """
    share = density / density.sum()
    x, y = np.ascontiguousarray(samples.T)

    def squared(hand):  # (n, k); column by column, as sums of two numbers a row are slow
        return (x - hand[:, :1]) ** 2 + (y - hand[:, 1:]) ** 2

    def value(hand):
        return float(share @ squared(hand).min(axis=0))

    def dissipation(hand):
        owner = squared(hand).argmin(axis=0)
        mass = np.bincount(owner, share, len(hand))
        drawn = np.stack(
            [np.bincount(owner, share * column, len(hand)) for column in samples.T], axis=1
        )
        moment = drawn - mass[:, np.newaxis] * hand  # M_i (C_i - p_i)
        return 2.0 * gain * float((moment**2).sum(axis=1) @ (1.0 / np.maximum(mass, 1e-300)))

    return Energy("locational cost $H$ [m$^2$]", value, dissipation)
