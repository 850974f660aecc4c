"""Pursuit, rendezvous and coverage as published, for verdicts: see :mod:`protocols.published.laws`."""

import numpy as np

from mrs_simulator.core.neighbours import lengths
from mrs_simulator.protocols.published.laws import Published


class Pursuit(Published):
    """``u_i = gain e^{ia} (z_{i+1} - z_i)`` in the complex plane: Marshall, Broucke, Francis, 2004."""

    def __init__(self, gain, angle):
        self.factor = gain * np.exp(1j * angle)

    def velocity(self, points, time, memory):
        z = points[:, 0] + 1j * points[:, 1]
        u = self.factor * (np.append(z[1:], z[0]) - z)
        return np.column_stack([u.real, u.imag]), None


class Rendezvous(Published):
    """``u_i = gain sum (2D - d)/(D - d)^2 (p_j - p_i)`` over the pairs nearer than D at the start.

    Ji and Egerstedt, 2007.
    """

    def __init__(self, gain, radius):
        self.gain, self.radius = gain, radius

    def begin(self, start):
        """Return which pairs are neighbours, (n, n) bool."""
        return _distances(start) < self.radius

    def velocity(self, points, time, memory):
        d = _distances(points)
        with np.errstate(divide="ignore"):  # at D itself the law is infinite
            share = np.where(memory, (2.0 * self.radius - d) / (self.radius - d) ** 2, 0.0)
        np.fill_diagonal(share, 0.0)
        return self.gain * (share @ points - share.sum(axis=1)[:, np.newaxis] * points), memory


class Coverage(Published):
    """``u_i = gain (C_i - p_i)``, C_i the centroid of i's Voronoi cell: Cortes and others, 2004."""

    def __init__(self, gain, side, count, weight):
        """``weight(x, y)`` of places [m]; cells are sums over ``count^2`` samples of the square."""
        middles = [side * ((k + 0.5) / count - 0.5) for k in range(count)]
        self.samples = np.array([(x, y) for y in middles for x in middles])
        self.weight, self.gain = weight(*self.samples.T), gain
        self.WORK = float(len(self.samples))

    def velocity(self, points, time, memory):
        x, y = self.samples.T
        owner = np.array([(x - px) ** 2 + (y - py) ** 2 for px, py in points]).argmin(axis=0)
        u = np.zeros_like(points)
        for i, point in enumerate(points):
            cell = np.flatnonzero(owner == i)
            mass = self.weight[cell]
            if mass.sum() > 1e-300:
                u[i] = self.gain * (mass @ self.samples[cell] / mass.sum() - point)
        return u, None


def _distances(points):
    return lengths(points[:, np.newaxis] - points)
