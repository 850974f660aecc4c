"""Consensus laws as published, for verdicts: see :mod:`protocols.published.laws`."""

import numpy as np

from mrs_simulator.protocols.published.laws import Averaging, Published


class Delayed(Published):
    """``u_i(t) = gain sum_j a_ij (p_j - p_i)(t - tau)``, tau in whole periods: Olfati-Saber, Murray."""

    SEES = "past"

    def __init__(self, weights, gain, steps):
        self.average, self.steps = Averaging(weights, gain), steps

    def begin(self, start):
        """Return the points of the last ``steps + 1`` commands, the oldest first."""
        return [start] * (self.steps + 1)

    def velocity(self, points, time, memory):
        memory = memory[1:] + [points]
        return self.average.velocity(memory[0], time, None)[0], memory


class SecondOrder(Published):
    """``v_i' = sum_j a_ij ((p_j - p_i) + g (v_j - v_i))``, u = v: Ren and Atkins, 2007."""

    SEES = "next"

    def __init__(self, weights, g, first, period):
        self.laplacian = np.diag(weights.sum(axis=1)) - weights
        self.g, self.first, self.period = g, first, period

    def begin(self, start):
        """Return v(0), (n, d) [m/s]."""
        return self.first

    def velocity(self, points, time, memory):
        """Return ``(v+, v+)``."""
        v = memory - self.period * (self.laplacian @ (points + self.g * memory))
        return v, v


class Switching(Published):
    """``u_i = gain sum_j a_ij(t) (p_j - p_i)`` over edges dealt out to turns and lost at random."""

    NARROWS, WORK = True, 50.0

    def __init__(self, weights, edges, gain, turn, sets, loss, symmetric, seed, period, directed):
        self.weights, self.edges, self.gain, self.period = weights, edges, gain, period
        self.turn, self.sets, self.loss = turn, sets, loss
        self.symmetric, self.RANDOM = symmetric, loss > 0.0
        # Each as (receiver's row, sender's row, edge), all edges one way before the other.
        self.arcs = [(i - 1, j - 1, k) for k, (i, j, _) in enumerate(edges)]
        if not directed:
            self.arcs += [(j, i, k) for i, j, k in self.arcs]
        self.ends = np.array(self.arcs, dtype=int).reshape(-1, 3).T
        self.draws, self.drawn = np.random.default_rng(seed), []

    def velocity(self, points, time, memory):
        command = int(round(time / self.period))
        while len(self.drawn) <= command:
            count = len(self.edges) if self.symmetric else len(self.arcs)
            self.drawn.append(self.draws.random(count))
        chance = self.drawn[command]
        i, j, edge = self.ends
        up = edge % self.sets == (command // self.turn) % self.sets
        up &= chance[edge if self.symmetric else slice(None)] >= self.loss
        i, j, u = i[up], j[up], np.zeros_like(points)
        pull = self.gain * self.weights[i, j]
        np.add.at(u, i, pull[:, np.newaxis] * (points[j] - points[i]))
        return u, None


class EventTriggered(Published):
    """``u = -gain L p_hat``: Dimarogonas, Frazzoli and Johansson, 2012.

    Robot i broadcasts where ``|p_hat_i - p_i|^2 > sigma a (1 - a d_i)/d_i |sum_j a_ij (p_j - p_i)|^2``,
    with ``a = 1/(2 max d_i)``.
    """

    SEES = "past"

    def __init__(self, weights, gain, sigma):
        self.weights, self.gain, self.sigma = weights, gain, sigma
        self.broadcasts = 0

    def begin(self, start):
        """Return nothing: all robots broadcast at their first command."""
        self.broadcasts = 0

    def velocity(self, points, time, memory):
        """Return ``(u, p_hat)``."""
        degree = self.weights.sum(axis=1)
        if memory is None:
            known, self.broadcasts = points.copy(), len(points)
        else:
            known, a = memory.copy(), 0.5 / max(degree.max(), 1e-9)
            z = (self.weights[:, np.newaxis] @ points)[:, 0] - degree[:, np.newaxis] * points
            share = self.sigma * a * (1.0 - a * degree) / np.maximum(degree, 1e-9)
            told = _squared(known - points) > share * _squared(z)
            known[told] = points[told]
            self.broadcasts += int(told.sum())
        return self.gain * (self.weights @ known - degree[:, np.newaxis] * known), known


class Resilient(Published):
    """W-MSR: the F largest above and the F smallest below its own are dropped: LeBlanc, 2013."""

    WORK = 50.0

    def __init__(self, weights, gain, dropped, normal, speed, turn):
        self.weights, self.gain, self.dropped = weights, gain, dropped
        self.normal, self.speed, self.turn = normal, speed, turn
        rows = weights[:normal].tolist()
        # By normal robot: whom it hears, with their weights.
        self.heard = [{j: weight for j, weight in enumerate(row) if weight} for row in rows]

    def velocity(self, points, time, memory):
        u = np.zeros_like(points)
        u[self.normal :, 0] = self.speed * np.cos(self.turn * time)
        u[self.normal :, 1] = self.speed * np.sin(self.turn * time)
        for axis, places in enumerate(points.T.tolist()):
            for i, heard in enumerate(self.heard):
                own = places[i]
                above = sorted((places[j], j) for j in heard if places[j] > own)
                below = sorted((places[j], j) for j in heard if places[j] < own)
                kept = above[: max(0, len(above) - self.dropped)] + below[self.dropped :]
                u[i, axis] = self.gain * sum(heard[j] * (x - own) for x, j in kept)
        return u, None


class Noisy(Published):
    """``u = -gain (L (p + nu) + nu_heard) + w`` with the noise of this seed: Xiao, Boyd, Kim, 2007."""

    NARROWS, WORK, RANDOM = True, 10.0, True

    def __init__(self, weights, gain, noise, seed, period):
        """``noise``: of velocities [m/s^0.5], of robots' and of listeners' positions [m]."""
        self.weights, self.gain, self.noise, self.period = weights, gain, noise, period
        self.arcs = np.array(np.nonzero(weights))
        self.draws, self.drawn = np.random.default_rng(seed), []

    def velocity(self, points, time, memory):
        command = int(round(time / self.period))
        while len(self.drawn) <= command:
            sizes = (len(points), self.arcs.shape[1], len(points))
            shapes = [(size, points.shape[1]) for size in sizes]
            self.drawn.append([self.draws.standard_normal(shape) for shape in shapes])
        robots, listeners, pushes = self.drawn[command]
        u = self.noise[0] / np.sqrt(self.period) * pushes
        seen = points + self.noise[1] * robots
        i, j = self.arcs
        pull = self.gain * self.weights[i, j]
        np.add.at(u, i, pull[:, np.newaxis] * (seen[j] - seen[i] + self.noise[2] * listeners))
        return u, None


def _squared(rows):
    """Return the square of the length of each of ``rows`` (n, d)."""
    return (rows[:, np.newaxis] @ rows[:, :, np.newaxis])[:, 0, 0]
