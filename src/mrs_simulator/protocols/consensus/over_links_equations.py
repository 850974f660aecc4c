"""Laws ``e_i' = sum_j w_ij (e_j - e_i)`` over edges that are delayed or switch: their exact steps.

``w`` (n, n) [1/s], rows receive from columns; ``delays`` (n, n) are whole command periods.  The state holds
the errors e at the last commands, the newest first: with D the longest delay it has n (D + 1) rows.
In a round each graph is up for ``length`` commands, one after the other.
"""

import functools
import itertools

import numpy as np

from mrs_simulator.core.edge_terms import gathered
from mrs_simulator.core.spectra import ZERO


def step_matrix(weights, delays, period, both_terms):
    """Return the map, (n (D+1), n (D+1)), of the state over one command, held for ``period`` [s].

    ``e_i+ = e_i + period sum_j w_ij (e_j(d_ij ago) - e_i(d_ij ago))`` with ``both_terms`` of the same
    age (Olfati-Saber and Murray, 2004), else with e_i as it is now (Moreau, 2004).
    """
    n, depth = len(weights), int(delays.max(initial=0)) + 1
    matrix = np.zeros((n * depth, n * depth))
    matrix[n:, :-n] = np.eye(n * (depth - 1))
    matrix[:n, :n] = np.eye(n)
    receiver, sender = np.nonzero(weights)
    age, flow = delays[receiver, sender], period * weights[receiver, sender]
    np.add.at(matrix, (receiver, age * n + sender), flow)
    np.add.at(matrix, (receiver, (age if both_terms else 0) * n + receiver), -flow)
    return matrix


def round_of(steps, length):
    """Return the map of the state over one round of the maps ``steps``, which are taken one by one."""
    turns = (np.linalg.matrix_power(step, length) for step in steps)
    return functools.reduce(lambda product, turn: turn @ product, turns)


def agreement(matrix, n):
    """Return ``(modulus, weights)`` of the map ``matrix`` of a state over one round.

    ``modulus``: the largest of its eigenvalues other than the one at 1; errors agree from every start
    iff it is below 1.  ``weights`` (n,): they agree on ``weights @ e(0)`` if robots stood still
    before the start.
    """
    values, vectors = np.linalg.eig(matrix.T)
    one = int(np.argmin(np.abs(values - 1.0)))
    left = vectors[:, one].real
    total = left.sum()
    weights = left.reshape(-1, n).sum(axis=0) / (total if abs(total) > ZERO else 1.0)
    return float(np.abs(np.delete(values, one)).max(initial=0.0)), weights


def points_over_links(start, flows, length, delays, both_terms):
    """Yield the errors (n, d) [m] of each command from ``start`` on, as :func:`step_matrix` moves them.

    ``flows``: of each graph its arcs (m, 2), rows (i, j), i receives from j, and ``period w_ij`` (m,) [-].
    """
    n, past = len(start), np.repeat(start[np.newaxis], int(delays.max(initial=0)) + 1, axis=0)
    for arcs, share in itertools.cycle(flows):
        receiver, sender = arcs.T
        age = delays[receiver, sender]
        own = age if both_terms else 0
        for _ in range(length):
            yield past[0]
            flow = share * (past[age, sender] - past[own, receiver]).T
            past = np.concatenate([past[:1] + gathered(flow, receiver, n), past[:-1]])
