"""Consensus laws as published, for verdicts: see :mod:`published`."""

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
        """Return ``(u, memory)``."""
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
        self.symmetric = symmetric
        # Each as (row that hears, row heard, edge), all edges one way before the other.
        self.arcs = [(i - 1, j - 1, k) for k, (i, j, _) in enumerate(edges)]
        if not directed:
            self.arcs += [(j, i, k) for i, j, k in self.arcs]
        self.draws, self.drawn = np.random.default_rng(seed), []

    def velocity(self, points, time, memory):
        """Return ``(u, None)``."""
        command = int(round(time / self.period))
        while len(self.drawn) <= command:
            count = len(self.edges) if self.symmetric else len(self.arcs)
            self.drawn.append(self.draws.random(count))
        chance = self.drawn[command]
        u = np.zeros_like(points)
        for row, (i, j, edge) in enumerate(self.arcs):
            up = edge % self.sets == (command // self.turn) % self.sets
            if up and chance[edge if self.symmetric else row] >= self.loss:
                u[i] += self.gain * self.weights[i, j] * (points[j] - points[i])
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
            for i, d in enumerate(degree):
                z = self.weights[i] @ points - d * points[i]
                allowed = self.sigma * a * (1.0 - a * d) / max(d, 1e-9) * (z @ z)
                off = known[i] - points[i]
                if off @ off > allowed:
                    known[i] = points[i]
                    self.broadcasts += 1
        return self.gain * (self.weights @ known - degree[:, np.newaxis] * known), known


class Resilient(Published):
    """W-MSR: the F largest above and the F smallest below its own are not heard: LeBlanc, 2013."""

    WORK = 50.0

    def __init__(self, weights, gain, dropped, normal, speed, turn):
        self.weights, self.gain, self.dropped = weights, gain, dropped
        self.normal, self.speed, self.turn = normal, speed, turn

    def velocity(self, points, time, memory):
        """Return ``(u, None)``."""
        u = np.zeros_like(points)
        u[self.normal :, 0] = self.speed * np.cos(self.turn * time)
        u[self.normal :, 1] = self.speed * np.sin(self.turn * time)
        for i in range(self.normal):
            for axis in range(points.shape[1]):
                own = points[i, axis]
                heard = [j for j in np.flatnonzero(self.weights[i]) if points[j, axis] != own]
                above = sorted((points[j, axis], j) for j in heard if points[j, axis] > own)
                below = sorted((points[j, axis], j) for j in heard if points[j, axis] < own)
                kept = above[: max(0, len(above) - self.dropped)] + below[self.dropped :]
                u[i, axis] = self.gain * sum(self.weights[i, j] * (x - own) for x, j in kept)
        return u, None


class Pursuit(Published):
    """``u_i = gain e^{ia} (z_{i+1} - z_i)`` in the complex plane: Marshall, Broucke, Francis, 2004."""

    def __init__(self, gain, angle):
        self.factor = gain * np.exp(1j * angle)

    def velocity(self, points, time, memory):
        """Return ``(u, None)``."""
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
        """Return ``(u, memory)``."""
        d = _distances(points)
        share = np.where(memory, (2.0 * self.radius - d) / (self.radius - d) ** 2, 0.0)
        np.fill_diagonal(share, 0.0)
        return self.gain * (share @ points - share.sum(axis=1)[:, np.newaxis] * points), memory


class Coverage(Published):
    """``u_i = gain (C_i - p_i)``, C_i the centroid of i's Voronoi cell: Cortes and others, 2004."""

    def __init__(self, gain, side, count, weight):
        """``weight`` of a place (x, y) [m]; cells are sums over ``count^2`` samples of the square."""
        middles = [side * ((k + 0.5) / count - 0.5) for k in range(count)]
        self.samples = np.array([(x, y) for y in middles for x in middles])
        self.weight, self.gain = np.array([weight(x, y) for x, y in self.samples]), gain
        self.WORK = float(len(self.samples))

    def velocity(self, points, time, memory):
        """Return ``(u, None)``."""
        x, y = self.samples.T
        owner = np.array([(x - px) ** 2 + (y - py) ** 2 for px, py in points]).argmin(axis=0)
        u = np.zeros_like(points)
        for i, point in enumerate(points):
            cell = np.flatnonzero(owner == i)
            mass = self.weight[cell]
            if mass.sum() > 1e-300:
                u[i] = self.gain * (mass @ self.samples[cell] / mass.sum() - point)
        return u, None


class Noisy(Published):
    """``u = -gain (L (p + nu) + nu_heard) + w`` with the noise of this seed: Xiao, Boyd, Kim, 2007."""

    NARROWS, WORK = True, 10.0

    def __init__(self, weights, gain, noise, seed, period):
        """``noise``: of velocities [m/s^0.5], of robots' and of listeners' positions [m]."""
        self.weights, self.gain, self.noise, self.period = weights, gain, noise, period
        self.arcs = sorted(zip(*np.nonzero(weights)))
        self.draws, self.drawn = np.random.default_rng(seed), []

    def velocity(self, points, time, memory):
        """Return ``(u, None)``."""
        command = int(round(time / self.period))
        while len(self.drawn) <= command:
            sizes = (len(points), len(self.arcs), len(points))
            shapes = [(size, points.shape[1]) for size in sizes]
            self.drawn.append([self.draws.standard_normal(shape) for shape in shapes])
        robots, listeners, pushes = self.drawn[command]
        u = self.noise[0] / np.sqrt(self.period) * pushes
        seen = points + self.noise[1] * robots
        for (i, j), error in zip(self.arcs, listeners):
            u[i] += self.gain * self.weights[i, j] * (seen[j] - seen[i] + self.noise[2] * error)
        return u, None


class Chain(Published):
    """``u_i = gain (e_(i+1) - e_i)``, late by tau, behind robot n, which sways along x.

    ``e`` is how far a robot is from its start; of the state alone ``e_i`` is not late.
    """

    SEES = "past"

    def __init__(self, gain, steps, both_late, sway, period):
        self.gain, self.steps, self.both_late = gain, steps, both_late
        self.sway, self.period = sway, period

    def begin(self, start):
        """Return the points of the last ``steps + 1`` commands, the oldest first, and the start."""
        return [start] * (self.steps + 1), start

    def velocity(self, points, time, memory):
        """Return ``(u, memory)``."""
        past, start = memory
        past = past[1:] + [points]
        late, u = past[0] - start, np.zeros_like(points)
        for i in range(len(points) - 1):
            own = late[i] if self.both_late else points[i] - start[i]
            u[i] = self.gain * (late[i + 1] - own)
        u[-1, 0] = (self.sway(time + self.period) - self.sway(time)) / self.period
        return u, (past, start)


def _distances(points):
    return np.linalg.norm(points[:, np.newaxis] - points, axis=2)
