"""Lyapunov functions of flocking: see :mod:`protocols.energies`."""

import numpy as np

from mrs_simulator.protocols.curves import Energy

TABLE = 4001  # points at which a pair force is integrated
EPSILON, BUMP = 0.1, 0.2  # [1/m^2], [-] of the sigma-norm and the bump function: Olfati-Saber, 2006


def flock_energy(law, middle, leader):
    """Return ``E = sum_pairs psi + c1 |p - p_r|^2/2 + |v - v_r|^2/2`` of algorithm 2, and its dissipation.

    ``law`` has ``distance``, ``reach`` [m], ``strength``, ``alignment``, ``c1``, ``c2``; the virtual leader
    goes from ``middle`` (d,) [m] with ``leader`` (d,) [m/s].  ``D = c2 |v - v_r|^2 + alignment sum_pairs
    rho(z) |v_i - v_j|^2``.  Olfati-Saber, 2006.
    """
    reach, rest = _sigma(law.reach), _sigma(law.distance)
    z = np.linspace(0.0, reach, TABLE)
    force = law.strength * _bump(z / reach) * (z - rest) / np.sqrt(1.0 + (z - rest) ** 2)
    grown = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(z))])

    def pairs(x):
        first, second = np.triu_indices(len(x), 1)
        return x[first] - x[second]

    def near(hand):
        return _sigma(np.linalg.norm(pairs(hand), axis=1))

    def value(hand, velocity, time):
        potential = (np.interp(near(hand), z, grown) - np.interp(rest, z, grown)).sum()
        away, slip = hand - middle - time * leader, velocity - leader
        return float(potential + 0.5 * law.c1 * (away**2).sum() + 0.5 * (slip**2).sum())

    def dissipation(hand, velocity, time):
        shared = (_bump(near(hand) / reach) * (pairs(velocity) ** 2).sum(axis=1)).sum()
        return float(law.c2 * ((velocity - leader) ** 2).sum() + law.alignment * shared)

    return Energy("$E$ of the flock [m$^2$/s$^2$]", value, dissipation, True)


def agreement_energy(gain, beta, reach):
    """Return ``V = sum |v_i - mean v|^2/2`` of Cucker and Smale, 2007, and its dissipation.

    ``D = gain/n sum_pairs (1 + (|p_ij|/reach)^2)^-beta |v_i - v_j|^2``.
    """

    def value(hand, velocity, time):
        return 0.5 * float(((velocity - velocity.mean(axis=0)) ** 2).sum())

    def dissipation(hand, velocity, time):
        first, second = np.triu_indices(len(hand), 1)
        far = ((hand[first] - hand[second]) ** 2).sum(axis=1)
        influence = (1.0 + far / reach**2) ** -beta
        slip = ((velocity[first] - velocity[second]) ** 2).sum(axis=1)
        return gain / len(hand) * float(influence @ slip)

    return Energy("$V = |v - \\bar v|^2/2$ [m$^2$/s$^2$]", value, dissipation, True)


def _sigma(distance):
    return (np.sqrt(1.0 + EPSILON * distance**2) - 1.0) / EPSILON


def _bump(share):
    falling = 0.5 * (1.0 + np.cos(np.pi * (share - BUMP) / (1.0 - BUMP)))
    return np.where(share < BUMP, 1.0, np.where(share <= 1.0, falling, 0.0))
