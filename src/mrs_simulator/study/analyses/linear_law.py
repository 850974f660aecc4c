"""What a linear law does, by its matrix: spectrum, limit, rate, and margins of period, delay and gain.

    x' = c - M x

with x (m,) all coordinates of the team, robot by robot [m], M (m, m) [1/s] and c (m,) [m/s].
"""

from typing import Any, NamedTuple, Optional

import numpy as np

from mrs_simulator.core.spectra import stable_step

ZERO = 1e-7  # [-] of the largest eigenvalue, below which one that is computed counts as zero
DEFECTIVE = 1e6  # [-] condition of the eigenvectors from which on M has too few
DIGITS = 11  # of a matrix that is fitted
MOST_NOISY = 40  # coordinates for which the equation of variances is solved


class LinearLaw(NamedTuple):
    """What follows from M and c; see :func:`linear_law`."""

    eigenvalues: np.ndarray  # (m,) [1/s], ascending by real part
    zeros: int  # eigenvalues zero
    rate: Optional[float]  # [1/s] of the slowest mode; None where one does not decay, or none moves
    projection: Optional[np.ndarray]  # (m, m): what a start leaves in the limit
    offset: Optional[np.ndarray]  # (m,) [m], which is added to that
    drift: Optional[np.ndarray]  # (m,) [m/s] with which the limit moves
    is_defective: bool  # then decays have a polynomial beside exp(-rate t)
    is_stable: bool  # all modes but those that stay decay
    longest_period: float  # [s] of held commands, inf where nothing decays
    longest_delay: float  # [s], one on all of M x
    noise: Optional[float]  # [s], mean variance of a coordinate per unit of velocity noise [m^2/s]

    def limit(self, start):
        """Return where a ``start`` (n, d) ends, (n, d) [m]; where it drifts, at time 0."""
        start = np.asarray(start, dtype=float)
        return (self.projection @ start.ravel() + self.offset).reshape(start.shape)


def linear_law(matrix, constant):
    """Return the :class:`LinearLaw` of M = ``matrix`` (m, m) and c = ``constant`` (m,).

    With ``P`` the projector on the null space of M along its range, the limit is ``P x(0) + D c``, D the
    group inverse of M, and moves at ``P c``.  The delay is the least of ``(pi/2 - |arg mu|)/|mu|`` over
    the eigenvalues mu that are not zero, the period that of ``spectra.stable_step``.  The variance is
    that of ``M C + C M^T = I`` on the range of M.
    """
    matrix, constant = np.asarray(matrix, dtype=float), np.asarray(constant, dtype=float)
    values, vectors = np.linalg.eig(matrix)
    size = max(np.abs(values).max(initial=0.0), 1e-300)
    moving = np.abs(values) > ZERO * size
    mu, zeros = values[moving], int((~moving).sum())
    projection = _projection(matrix, zeros, size)
    stable = projection is not None and bool((mu.real > ZERO * size).all())
    found = {"offset": None, "drift": None, "noise": None}
    if stable:
        group_inverse = np.linalg.inv(matrix + size * projection) - projection / size
        found["offset"], found["drift"] = group_inverse @ constant, projection @ constant
        found["noise"] = _variance(matrix, projection)
    late = (0.5 * np.pi - np.abs(np.angle(mu))) / np.abs(mu)
    return LinearLaw(
        values[np.argsort(values.real, kind="stable")],
        zeros,
        float(mu.real.min()) if stable and len(mu) else None,
        projection if stable else None,
        is_defective=bool(np.linalg.cond(vectors) > DEFECTIVE),
        is_stable=stable,
        longest_period=float(stable_step(mu)) if stable and len(mu) else np.inf,
        longest_delay=float(late.min(initial=np.inf)) if stable else 0.0,
        **found,
    )


def _projection(matrix, zeros, size):
    """Return the projector on the null space along the range, None where zero is defective."""
    m = len(matrix)
    if zeros == 0:
        return np.zeros((m, m))
    left, singular, right = np.linalg.svd(matrix)
    if (singular <= 10.0 * ZERO * size).sum() != zeros:
        return None
    kernel, cokernel = right[m - zeros :].T, left[:, m - zeros :]
    return kernel @ np.linalg.solve(cokernel.T @ kernel, cokernel.T)


def _variance(matrix, projection):
    """Return the mean variance of a coordinate on the range of M under white velocity noise."""
    m = len(matrix)
    moving = m - int(round(np.trace(projection)))
    if not 0 < moving <= MOST_NOISY:
        return None
    basis = np.linalg.svd(np.eye(m) - projection)[0][:, :moving]  # of the range
    back = np.linalg.pinv(basis) @ (np.eye(m) - projection)
    inner = back @ matrix @ basis
    eye = np.eye(moving)
    both = np.kron(inner, eye) + np.kron(eye, inner)
    variance = np.linalg.solve(both, (back @ back.T).ravel()).reshape(moving, moving)
    return float(np.trace(basis @ variance @ basis.T)) / m


def weights_of(projection, n):
    """Return W (n, n) where each coordinate's limit is ``W x(0)`` in the same way, else None.

    ``projection`` (n d, n d), as of :class:`LinearLaw`.
    """
    d = len(projection) // n
    blocks = projection.reshape(n, d, n, d).transpose(0, 2, 1, 3)
    weights = blocks[:, :, 0, 0]
    same = np.allclose(blocks, weights[:, :, np.newaxis, np.newaxis] * np.eye(d), atol=1e-6)
    return weights if same else None


class Fit(NamedTuple):
    """``u = c - M x`` through probed states: ``matrix``, ``constant`` and the largest ``residual`` [-]."""

    matrix: Any
    constant: Any
    residual: float


def fitted(states, velocities, held_out):
    """Return the least-squares ``Fit`` of ``velocities`` (k, m) at ``states`` (k, m).

    The ``held_out`` last states are not fitted: ``residual`` is the largest miss there, of the largest
    velocity.
    """
    centre = states.mean(axis=0)
    shifted = np.column_stack([states - centre, np.ones(len(states))])
    solution = np.linalg.lstsq(shifted[:-held_out], velocities[:-held_out], rcond=None)[0]
    missed = np.abs(shifted[-held_out:] @ solution - velocities[-held_out:]).max()
    # Without the last digits, by which the eigenvalues of a Jordan block would scatter.
    size = max(np.abs(solution[:-1]).max(), 1e-300)
    matrix = -size * (solution[:-1].T / size).round(DIGITS)
    constant = solution[-1] + matrix @ centre
    return Fit(matrix, constant, float(missed / max(np.abs(velocities).max(), 1e-300)))
