"""Averaging over edges that are lost at random: the expected square of the disagreement.

``x+ = W x``, ``W = I - kappa Tc L(edges that are up)``, drawn anew at each command.  With the second
moment ``M = E[x x^T]``, ``M+ = E[W M W^T]``, exactly; the mean square decays at ``rho(E[W (x) W])`` on
the disagreement.  Fagnani and Zampieri, "Average consensus with packet drop communication", 2009.
"""

import numpy as np


def second_moment_step(moment, topology, share, loss, symmetric=False):
    """Return ``E[W M W^T]``, (n, n), from the second moment ``M = moment`` (n, n).

    ``share`` [-]: gain times command period; ``loss``, (n, n) of arcs (rows receive from columns) or one
    number: the chance that an edge is dropped, each arc by itself, or both directions ``symmetric``ally
    at once.
    """
    up = 1.0 - np.broadcast_to(np.asarray(loss, dtype=float), (topology.n, topology.n))
    rows, columns, weights = topology.arcs
    chance = up[rows, columns]
    mean = np.zeros((topology.n, topology.n))
    np.add.at(mean, (rows, columns), share * weights * chance)
    step = np.eye(topology.n) - np.diag(mean.sum(axis=1)) + mean
    # Beyond the mean each arc adds its variance: of r = a (x_j - x_i), in row i alone or in i and j.
    spread = (share * weights) ** 2 * chance * (1.0 - chance)
    apart = moment[rows, rows] - 2.0 * moment[rows, columns] + moment[columns, columns]
    found = step @ moment @ step.T
    np.add.at(found, (rows, rows), spread * apart)
    if symmetric:  # arc (j, i) is lost with (i, j), and pulls the other way
        np.add.at(found, (rows, columns), -spread * apart)
    return found


def mean_squares(start, topology, share, loss, count, symmetric=False):
    """Return ``E|x - mean(x)|^2`` at the first ``count`` commands, (count,) [m^2], from ``start``."""
    away = np.eye(topology.n) - 1.0 / topology.n
    moment, found = start @ start.T, np.empty(count)
    for row in range(count):
        found[row] = np.trace(away @ moment)
        moment = second_moment_step(moment, topology, share, loss, symmetric)
    return found


def mean_square_rate(topology, share, loss, symmetric=False, rounds=400):
    """Return ``rho(E[W (x) W])`` [-] on the disagreement, by powers of the map on second moments."""
    away = np.eye(topology.n) - 1.0 / topology.n
    moment, size = away.copy(), 1.0
    for _ in range(rounds):
        moment = away @ second_moment_step(moment, topology, share, loss, symmetric) @ away
        size = float(np.trace(moment))
        if size <= 0.0:
            return 0.0
        moment = moment / size
    return size


def confidence(values):
    """Return mean and half width of its 95 % confidence interval, (m,) each, of ``values`` (runs, m)."""
    runs = len(values)
    return values.mean(axis=0), 1.96 * values.std(axis=0, ddof=1) / np.sqrt(runs)
