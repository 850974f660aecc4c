"""Linear laws from what they answered: the fit of ``u = c - M x``, and the weights of a limit."""

from typing import Any, NamedTuple

import numpy as np

DIGITS = 11  # of a matrix that is fitted
ROUNDING = 1e-12  # [-] of the largest velocity, which a law of positions exceeds where these change


def weights_of(projection, n):
    """Return W (n, n) where each coordinate's limit is ``W x(0)`` in the same way, else None.

    ``projection`` (n d, n d), as of :class:`LinearTheorem`.
    """
    d = len(projection) // n
    blocks = projection.reshape(n, d, n, d).transpose(0, 2, 1, 3)
    weights = blocks[:, :, 0, 0]
    same = np.allclose(blocks, weights[:, :, np.newaxis, np.newaxis] * np.eye(d), atol=1e-6)
    return weights if same else None


class Fit(NamedTuple):
    """``u = c - M x`` through probed states: ``matrix``, ``constant`` and the largest ``residual`` [-].

    ``size`` [m/s]: of the largest velocity there, which the residual is a share of.
    """

    matrix: Any
    constant: Any
    residual: float
    size: float


def fitted(states, velocities, held_out):
    """Return the least-squares ``Fit`` of ``velocities`` (k, m) at ``states`` (k, m).

    The ``held_out`` last states are not fitted: ``residual`` is the largest miss there, of the largest
    velocity.
    """
    centre = states.mean(axis=0)
    shifted = np.column_stack([states - centre, np.ones(len(states))])
    solution = np.linalg.lstsq(shifted[:-held_out], velocities[:-held_out], rcond=None)[0]
    missed = np.abs(shifted[-held_out:] @ solution - velocities[-held_out:]).max()
    # Rounding alone, times the states, gives a matrix even where velocities do not depend on positions.
    if np.abs(solution[:-1]).max() * np.abs(shifted).max() <= ROUNDING * np.abs(velocities).max():
        solution[:-1] = 0.0
    # Without the last digits, by which the eigenvalues of a Jordan block would scatter.
    size = max(np.abs(solution[:-1]).max(), 1e-300)
    matrix = -size * (solution[:-1].T / size).round(DIGITS)
    constant = solution[-1] + matrix @ centre
    size = max(float(np.abs(velocities).max()), 1e-300)
    return Fit(matrix, constant, float(missed) / size, size)
