"""What theory says of a linear law, by its matrix: spectrum, limit, rate, and margins of period and delay.

    x' = c - M x

with x (m,) all coordinates of the team, robot by robot [m], M (m, m) [1/s] and c (m,) [m/s].
"""

from typing import NamedTuple, Optional

import numpy as np

from mrs_simulator.core.claims import NEGLIGIBLE, Condition, converges_to, invariant, rate
from mrs_simulator.core.kinematics import phase_of
from mrs_simulator.core.spectra import stable_step

ZERO = 1e-7  # [-] of the largest eigenvalue, below which one that is computed counts as zero
ROUNDING = 1e-13  # [-] of the largest entry, by which a symmetric M may be off
SYMMETRIC_ZERO = 1e-11  # [-] the same where M is symmetric, whose eigenvalues have no more rounding
DEFECTIVE = 1e6  # [-] condition of the eigenvectors from which on M has too few
MOST_NOISY = 40  # coordinates for which the equation of variances is solved


class Names(NamedTuple):
    """What the claims of a linear theorem are called; "" for one that is not made."""

    limit: str = "distance from the limit [m]"
    kept: str = "drift of what stays [m]"
    rate: str = "decay rate of the error [1/s]"


class Accuracy(NamedTuple):
    """How closely the claims of a linear theorem hold."""

    place: float = 0.02  # [m] of the limit
    kept: float = 0.02  # [m] of what stays
    rate: float = 0.02  # [-] of the decay rate


NAMES, ACCURACY = Names(), Accuracy()


class LinearTheorem(NamedTuple):
    """What follows from M and c; see :func:`linear_theorem`."""

    eigenvalues: np.ndarray  # (m,) [1/s], ascending by real part
    zeros: int  # eigenvalues zero
    rate: Optional[float]  # [1/s] of the slowest mode; None where one does not decay, or none moves
    # The next four are None where zero is defective.
    kernel: Optional[np.ndarray]  # (m, zeros): a basis of what stays
    weights: Optional[np.ndarray]  # (zeros, m): its coordinates of a start
    offset: Optional[np.ndarray]  # (m,) [m], which is added to that
    drift: Optional[np.ndarray]  # (m,) [m/s] with which the limit moves
    is_defective: bool  # then decays have a polynomial beside exp(-rate t)
    is_stable: bool  # all modes but those that stay decay
    longest_period: float  # [s] of held commands, inf where nothing decays
    longest_delay: float  # [s], one on all of M x
    matrix: np.ndarray  # M (m, m) [1/s]

    @property
    def projection(self):
        """Return P (m, m), what a start leaves in the limit, or None."""
        return None if self.kernel is None else self.kernel @ self.weights

    @property
    def noise(self):
        """Return the mean variance of a coordinate per unit of velocity noise [m^2/s], in s, or None."""
        return _variance(self.matrix, self.projection) if self.is_stable else None

    def limit(self, start):
        """Return where a ``start`` (n, d) ends, (n, d) [m]; where it drifts, at time 0."""
        return self._kept(start) + self._as(self.offset, start)

    def held_rate(self, period, steps=0):
        """Return the rate [1/s] of the slowest mode under commands held for ``period`` [s], or 0.

        All of M x is late by so many ``steps`` of the period.  The least ``-ln |z|/period`` of the
        roots z of ``z^(steps + 1) - z^steps + period mu``; negative if one grows.
        """
        mu = period * self._moving()
        sizes = np.abs(1.0 - mu) if steps == 0 else [_largest_root(one, steps) for one in mu]
        return float(-np.log(max(*sizes, 1e-300)) / period) if len(mu) else 0.0

    def claims(self, start, period, delay=0.0, place=0.02, share=0.02, floor=0.0):
        """Return what theory says of a run from ``start`` (n, d), a list of ``Condition`` and ``Claim``.

        Commands are held for ``period`` [s], all of M x is late by ``delay`` [s].  The limit, which drifts
        as the constant says, and what stays of the start hold within ``place`` [m], the decay rate within
        ``share``; there is none of a defective M, or with a delay.  ``floor`` as in ``claims.rate``.
        """
        conditions = self.conditions(period, delay)
        if not all(condition.holds for condition in conditions):
            return conditions
        accuracy = Accuracy(place, place, share)
        names = NAMES._replace(rate="") if delay else NAMES
        return conditions + self.consequences(start, period, accuracy, names, floor)

    def conditions(self, period, delay=0.0):
        """Return under which conditions all that moves decays, a list of ``Condition``."""
        why = "{:.4g} against {:.4g}".format
        conditions = [
            Condition("all that moves decays", self.is_stable, "or turns for ever", necessary=True)
        ]
        for name, value, most in (
            ("Tc below its bound [s]", period, self.longest_period),
            ("delay below its bound [s]", delay, self.longest_delay),
        ):
            conditions.append(Condition(name, bool(value < most), why(value, most), necessary=True))
        return conditions

    def consequences(self, start, period, accuracy=ACCURACY, names=NAMES, floor=0.0, free=True):
        """Return the claims alone of a run from ``start`` (n, d): limit, what stays, and decay rate.

        They are those that have ``names``, and hold within the ``accuracy``.  ``floor`` [m]: of the error,
        as in ``claims.rate``; ``free``: the limit is another once robots were at their limits.
        """
        if self.kernel is None:  # as of a double integrator: nothing settles
            return []
        limit, drift = self.limit(start), self._as(self.drift, start)
        staying = np.abs(drift).max(initial=0.0) <= NEGLIGIBLE

        def moved(run):
            if staying:
                return run
            way = np.multiply.outer(run.time - run.time[0], drift)
            return run._replace(hand=run.hand - way)

        def off(hand):
            return np.linalg.norm(
                hand - self._kept(hand) - self._as(self.offset, start), axis=(1, 2)
            )

        claims = []
        if names.limit:
            at_end = converges_to(limit, accuracy.place, names.limit, free=free)
            measure = lambda run: at_end.measure(moved(run))  # noqa: E731
            claims.append(at_end._replace(measure=measure, place=limit if staying else None))
        if self.zeros and names.kept:
            each = np.sqrt(len(start))  # the norm is over all robots: that of a robot in the mean
            kept = invariant(lambda hand: self._kept(hand) / each, accuracy.kept, names.kept)
            claims.append(kept._replace(measure=lambda run: kept.measure(moved(run))))
        if names.rate and len(self._moving()) and not self.is_defective:
            value = self.held_rate(period)
            claims.append(rate(value, off, accuracy.rate, names.rate, floor=floor))
        return claims

    def _moving(self):
        """Return the eigenvalues that are not zero."""
        order = np.argsort(np.abs(self.eigenvalues), kind="stable")
        return self.eigenvalues[order[self.zeros :]]

    def _kept(self, points):
        """Return what ``points`` (..., n, d) leave in the limit, (..., n, d) [m]."""
        points = np.asarray(points, dtype=float)
        rows = points.reshape(points.shape[:-2] + (len(self.kernel), -1))
        return (self.kernel @ (self.weights @ rows)).reshape(points.shape)

    def _as(self, values, points):
        """Return ``values`` of coordinates in the shape of ``points`` (n, d)."""
        values = np.reshape(values, (len(values), -1))
        shape = len(values), np.size(points) // len(values)
        return np.broadcast_to(values, shape).reshape(np.shape(points))


def linear_theorem(matrix, constant=0.0, exact=True):
    """Return the :class:`LinearTheorem` of M = ``matrix`` (m, m) and c = ``constant`` (m,).

    M is of all coordinates, robot by robot, or of n robots (n, n), all axes alike; c is then (n, d).
    One that is not ``exact`` was measured: eigenvalues that are zero are so within ``ZERO`` alone.

    With ``P`` the projector on the null space of M along its range, the limit is ``P x(0) + D c``, D the
    group inverse of M, and moves at ``P c``.  The delay is the least of ``(pi/2 - |arg mu|)/|mu|`` over
    the eigenvalues mu that are not zero, the period that of ``spectra.stable_step``.  The variance is
    that of ``M C + C M^T = I`` on the range of M.
    """
    matrix = np.asarray(matrix, dtype=float)
    constant = np.broadcast_to(
        np.asarray(constant, dtype=float).T, np.shape(constant)[1:] + (len(matrix),)
    ).T
    uneven = np.abs(matrix - matrix.T).max(initial=0.0)
    symmetric = exact and uneven <= ROUNDING * np.abs(matrix).max(initial=0.0)
    values, vectors = (np.linalg.eigh if symmetric else np.linalg.eig)(matrix)
    size = max(np.abs(values).max(initial=0.0), 1e-300)
    zero = size * (SYMMETRIC_ZERO if symmetric else ZERO)
    moving = np.abs(values) > zero
    mu, still = values[moving], vectors[:, ~moving]
    zeros = still.shape[1]
    kernel, weights = (still, still.T) if symmetric else _null_spaces(matrix, zeros, size)
    stable = kernel is not None and bool((mu.real > zero).all())
    offset, drift = None, None
    if kernel is not None:
        offset, drift = _carried(matrix, kernel @ weights, size, constant)
    late = (0.5 * np.pi - np.abs(phase_of(mu))) / np.abs(mu)
    return LinearTheorem(
        values[np.argsort(values.real, kind="stable")],
        zeros,
        float(mu.real.min()) if stable and len(mu) else None,
        kernel,
        weights,
        offset,
        drift,
        is_defective=not symmetric and _is_defective(matrix, vectors),
        is_stable=stable,
        longest_period=float(stable_step(mu)) if stable and len(mu) else np.inf,
        longest_delay=float(late.min(initial=np.inf)) if stable else 0.0,
        matrix=matrix,
    )


def _is_defective(matrix, vectors):
    """Return whether M has too few eigenvectors, of which ``vectors`` were computed.

    Where eigenvalues are equal, rounding alone may make those nearly parallel, but not in another basis. A
    measured M that commutes with its transpose, but for rounding, has all of them whatever was computed.
    """
    uneven = np.abs(matrix @ matrix.T - matrix.T @ matrix).max(initial=0.0)
    normal = uneven <= ROUNDING * np.abs(matrix @ matrix.T).max(initial=0.0)
    if normal or np.linalg.cond(vectors) <= DEFECTIVE:
        return False
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal(matrix.shape))[0]
    return bool(np.linalg.cond(np.linalg.eig(basis @ matrix @ basis.T)[1]) > DEFECTIVE)


def _largest_root(mu, steps):
    """Return the largest modulus of a root of ``z^(steps + 1) - z^steps + mu``, ``steps`` above 0."""
    polynomial = np.zeros(steps + 2, dtype=complex)
    polynomial[[0, 1, -1]] = 1.0, -1.0, mu
    return float(np.abs(np.roots(polynomial)).max())


def _null_spaces(matrix, zeros, size):
    """Return bases (m, k) of the null space and (k, m) dual to it, of the left one, k = ``zeros``.

    Two None where zero is defective.
    """
    m = len(matrix)
    if zeros == 0:
        return np.zeros((m, 0)), np.zeros((0, m))
    left, singular, right = np.linalg.svd(matrix)
    if (singular <= 10.0 * ZERO * size).sum() != zeros:
        return None, None
    kernel, cokernel = right[m - zeros :].T, left[:, m - zeros :]
    return kernel, np.linalg.solve(cokernel.T @ kernel, cokernel.T)


def _carried(matrix, projection, size, constant):
    """Return ``(D c, P c)`` of c = ``constant``: where and how fast it moves the limit."""
    if not constant.any():
        return constant, constant
    group_inverse = np.linalg.inv(matrix + size * projection) - projection / size
    return group_inverse @ constant, projection @ constant


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
