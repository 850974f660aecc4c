"""Laws of points that a current carries: keeping station, with integral action, and following a line.

Points are (n, d), one robot per row.
"""

import numpy as np

from mrs_simulator.core.edge_terms import difference_sum


def station_keeping(error, integral, topology, gain, anchor, reset):
    """Return ``u = gain sum_j a_ij (e_j - e_i) - anchor e_i - reset z_i``, (n, d) [m/s].

    ``error`` e (n, d) [m] from the robots' stations, ``integral`` z (n, d) [m s].
    """
    return gain * difference_sum(error, topology) - anchor * error - reset * integral


def integrated(integral, error, period, most):
    """Return the integral (n, d) [m s] after ``period`` [s] of ``error`` (n, d) [m], each no longer than
    ``most`` [m s]: more would only be wound up."""
    fresh = integral + period * error
    size = np.linalg.norm(fresh, axis=1)
    return fresh * np.minimum(1.0, most / np.maximum(size, 1e-300))[:, np.newaxis]


def line_of_sight(across, integral, ahead, sigma):
    """Return the direction of travel (n, 2) [-] in the path's frame, along and across it.

    ``atan(-(e + sigma z)/ahead)`` of cross-track errors e (n,) [m] and integrals z (n,) [m]; Fossen 2011,
    section 10.3; with sigma above 0 Borhaug, Pavlov and Pettersen, 2008.
    """
    aim = across + sigma * integral
    return np.stack([np.full(len(aim), ahead), -aim], axis=1) / np.hypot(ahead, aim)[:, np.newaxis]


def sight_integrated(across, integral, ahead, sigma, period):
    """Return z (n,) [m] after ``period`` [s]: ``z' = ahead e/((e + sigma z)^2 + ahead^2)``."""
    aim = across + sigma * integral
    return integral + period * ahead * across / (aim * aim + ahead * ahead)
