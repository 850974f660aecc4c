"""Minimum-snap trajectories through points, as polynomials of degree 7 between them.

``int |p''''|^2 dt`` is least for pieces of degree 7 whose derivatives up to the sixth are continuous at
the points between, and that begin and end at rest: a linear system.  Mellinger and Kumar, 2011.
"""

import math
from typing import NamedTuple

import numpy as np

DEGREE = 7
ENDS = (1, 2, 3)  # derivatives that are zero where it begins and ends


class Trajectory(NamedTuple):
    """A curve of k pieces; before its begin and after its end it rests."""

    times: np.ndarray  # (k + 1,) [s] at which the points are passed, from 0 on
    pieces: np.ndarray  # (k, 8, d) coefficients of (t - t_i)/(t_{i+1} - t_i), the constant first
    last: np.ndarray  # (d,) [m]

    def at(self, time, order=0):
        """Return the places (m, d) [m] at ``time`` (m,) [s], or their derivatives of that ``order``."""
        time = np.clip(np.asarray(time, dtype=float), 0.0, self.times[-1])
        if not len(self.pieces):
            return np.tile(self.last if order == 0 else 0.0 * self.last, (len(time), 1))
        piece = np.searchsorted(self.times[1:-1], time, side="right")
        length = np.diff(self.times)[piece]
        share = (time - self.times[piece]) / length
        rows = np.array([powers(each, order) for each in share])
        return np.einsum("mj,mjd->md", rows, self.pieces[piece]) / length[:, np.newaxis] ** order


def powers(share, order):
    """Return the derivatives of ``order`` of 1, x, ..., x^7 at x = ``share``, (8,)."""
    result = np.zeros(DEGREE + 1)
    for j in range(order, DEGREE + 1):
        result[j] = math.factorial(j) / math.factorial(j - order) * share ** (j - order)
    return result


def minimum_snap(points, speed):
    """Return the :class:`Trajectory` through ``points`` (k + 1, d) [m], at ``speed`` [m/s] in the mean."""
    points = np.asarray(points, dtype=float)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1) / speed
    times, k, width = np.concatenate([[0.0], np.cumsum(length)]), len(length), DEGREE + 1
    if not k:
        return Trajectory(times, np.empty((0, width, points.shape[1])), points[-1])
    rows, wanted = [], []

    def add(value, *terms):
        row = np.zeros((k, width))
        for piece, share, order, sign in terms:
            row[piece] += sign * powers(share, order) / length[piece] ** order
        rows.append(row.ravel())
        wanted.append(value)

    nothing = np.zeros(points.shape[1])
    for piece in range(k):
        add(points[piece], (piece, 0.0, 0, 1.0))
        add(points[piece + 1], (piece, 1.0, 0, 1.0))
    for order in ENDS:
        add(nothing, (0, 0.0, order, 1.0))
        add(nothing, (k - 1, 1.0, order, 1.0))
    for piece in range(k - 1):
        for order in range(1, DEGREE):
            add(nothing, (piece, 1.0, order, 1.0), (piece + 1, 0.0, order, -1.0))
    found = np.linalg.solve(np.array(rows), np.array(wanted))
    return Trajectory(times, found.reshape(k, width, -1), points[-1])


def following(points, wanted, velocity, gain):
    """Return ``u_i = v_i + gain (r_i - p_i)``, (n, d) [m/s], of ``wanted`` r (n, d) [m] that move at v."""
    return velocity + gain * (wanted - points)


def tracking_bound(error, acceleration, gain, late):
    """Return by how much [m] robots that are ``late`` T [s] are off at most, nan where they may swing.

    Of robots that follow velocities as ``T v' = u - v`` the error e = r - p obeys ``T e'' + e' + gain e =
    T r''``.  For ``4 gain T <= 1`` nothing swings, and |e| stays below ``|e(0)| + T max|r''|/gain``.
    ``error`` |e(0)| [m] from rest; ``acceleration`` max|r''| [m/s^2].
    """
    if 4.0 * gain * late > 1.0:
        return math.nan
    return error + late * acceleration / gain
