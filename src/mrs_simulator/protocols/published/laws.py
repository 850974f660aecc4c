"""Laws as published, a second time: what verdicts hold the commands and the motion of a run against.

Nothing in the modules ``published`` is shared with the laws that move robots: weights are dense
matrices built from the list of edges, sums run over all pairs.  A mistake in a law is therefore not
repeated in what its runs are compared with.
"""

import itertools

import numpy as np

# [-] pairs of robots over all commands of an exact solution: seconds of arithmetic
MOST_PAIRS = 2e8
MOST_COMMANDS = 50000  # [-] of an exact solution


class Published:
    """A law for points: velocities ``u`` (n, d) [m/s] from points ``p`` (n, d) [m].

    ``SEES`` says from what a recorded sample's command follows: "now": from its points and time;
    "next": from its points and the velocities commanded before, which the law has as its memory;
    "past": from more than a sample shows.  ``NARROWS``: a difference in one robot's place never grows
    beyond itself, in the largest distance of all robots, so that small deviations add up at most.
    ``RANDOM``: it draws numbers, so that one solution proves nothing of it.
    ``WORK``: what a pair of robots costs in one command, as against a sum over all pairs.
    """

    SEES, NARROWS, WORK, RANDOM = "now", False, 1.0, False

    def begin(self, start):
        """Return the memory at the first command, of a team at ``start`` (n, d) [m]."""
        return None

    def velocity(self, points, time, memory):
        """Return ``(u, memory)`` of a team at ``points`` (n, d) [m], ``time`` [s] after the start."""
        raise NotImplementedError

    def velocities(self, points, time, memory):
        """Return u (k, n, d) of teams at ``points`` (k, n, d) [m], ``time`` (k,) [s], one ``memory``."""
        return np.array([self.velocity(p, t, memory)[0] for p, t in zip(points, time)])

    def motion(self, start, period, rows, drift=0.0, kept=None):
        """Return points and u (m, n, d) at commands ``rows`` (m,), from 0, as :func:`exact_steps`.

        ``kept``: a :class:`Steps` from that start, or None.
        """
        return (kept or Steps()).at(rows, self, start, period, drift=drift)

    def keeps_close(self, period):
        """Return whether two teams never part, in the largest distance, if u is held for ``period`` [s]."""
        return False

    def resumed(self, velocity, memory):
        """Return the memory after the command ``velocity`` (n, d) [m/s]; of laws that see "next"."""
        return velocity

    def over(self, up):
        """Return this law over the edges ``up``, (n, n) bool, rows receive from columns; or None."""
        return None


class Resumed(Published):
    """A law from a later moment on: ``time`` [s] after its start, with the ``memory`` it has then."""

    def __init__(self, law, time, memory):
        self.law, self.time, self.memory = law, time, memory
        self.SEES, self.NARROWS, self.WORK = law.SEES, law.NARROWS, law.WORK
        self.RANDOM = law.RANDOM

    def begin(self, start):
        """Return the memory at that moment."""
        return self.memory

    def velocity(self, points, time, memory):
        """Return ``(u, memory)``, ``time`` [s] after that moment."""
        return self.law.velocity(points, self.time + time, memory)

    def velocities(self, points, time, memory):
        """Return u (k, n, d) at ``time`` (k,) [s] after that moment."""
        return self.law.velocities(points, self.time + time, memory)

    def keeps_close(self, period):
        """Return what the law does."""
        return self.law.keeps_close(period)

    def resumed(self, velocity, memory):
        return self.law.resumed(velocity, memory)

    @property
    def depth(self):
        """Return how often a law that sees poses is asked, leaders first."""
        return self.law.depth

    def commands(self, pose, hand, command, time, l):
        """Return the commands of a law that sees poses, ``time`` [s] after that moment."""
        return self.law.commands(pose, hand, command, self.time + time, l)


class Averaging(Published):
    """``u_i = gain sum_j a_ij (p_j - p_i - (d_j - d_i))``; robots that are ``still`` stay.

    Consensus with d = 0 (Olfati-Saber and Murray, 2004), displacement formations (Oh, Park, Ahn,
    2015), containment with leaders that stay (Ji and others, 2008).  ``means``: each row of weights
    is divided by its sum, as in the paper's law (6).
    """

    NARROWS = True

    def __init__(self, weights, gain, places=0.0, still=(), means=False):
        self.weights, self.gain, self.places = weights, gain, places
        self.still, self.means = list(still), means
        shares = weights
        if means:
            shares = weights / np.maximum(weights.sum(axis=1), 1e-300)[:, np.newaxis]
        self._shares, self._total = shares, shares.sum(axis=1)[:, np.newaxis]

    def velocity(self, points, time, memory):
        return self.velocities(points, time, memory), None

    def velocities(self, points, time, memory):
        """Return u (k, n, d) of several teams, or (n, d) of one."""
        away = points - self.places
        u = self.gain * (self._shares @ away - self._total * away)
        u[..., self.still, :] = 0.0
        return u

    def motion(self, start, period, rows, drift=0.0, kept=None):
        """Return points and u at ``rows``, by doubling ``e+ = A e + Tc drift``, ``e = p - places``.

        From the first K of them the next K follow by ``A^K``.  Step by step where powers of A overflow.
        """
        commands = int(np.max(rows)) + 1
        moves = np.ones((len(start), 1))
        moves[self.still] = 0.0
        step = self.gain * (self._shares - self._total * np.eye(len(start)))
        step = np.eye(len(start)) + period * moves * step
        track = np.empty((commands,) + start.shape)
        track[0], shift = start - self.places, np.broadcast_to(period * drift, start.shape)
        known = 1
        with np.errstate(all="ignore"):
            while known < commands:
                more = min(known, commands - known)
                track[known : known + more] = step @ track[:more] + shift
                step, shift, known = step @ step, step @ shift + shift, known + more
        if not np.isfinite(track).all():
            return super().motion(start, period, rows, drift, kept)
        points = track[rows] + self.places
        return points, self.velocities(points, None, None)

    def keeps_close(self, period):
        """Return whether each next point is a mean of points, with weights that are not negative."""
        share = self.gain * period * self._total.max(initial=0.0)
        return bool((self.weights >= 0.0).all()) and 0.0 <= share <= 1.0

    def over(self, up):
        """Return this law with the weights of edges that are down at 0."""
        return Averaging(self.weights * up, self.gain, self.places, self.still, self.means)


def weights_of(topology):
    """Return ``a_ij``, (n, n), from the list of edges: rows receive from columns."""
    weights = np.zeros((topology.n, topology.n))
    for i, j, weight in topology.edges:
        weights[i - 1, j - 1] = weight
        if not topology.directed:
            weights[j - 1, i - 1] = weight
    return weights


def shape_of(name, n, size, dimension=2):
    """Return the places of n robots, (n, d) [m], in a ``line``, ``circle``, ``vee`` or ``grid``."""
    if name == "grid" and dimension == 3:
        return _cube_of(n, size)
    rows, width = [], int(np.ceil(np.sqrt(n)))
    for k in range(n):
        if name == "line":
            rows.append(complex(-k * size))
        elif name == "circle":
            chord = abs(np.exp(2j * np.pi / n) - 1.0) if n > 1 else 1.0
            rows.append(size / chord * np.exp(2j * np.pi * k / n) if n > 1 else 0j)
        elif name == "vee":
            side = np.exp(0.75j * np.pi) if k % 2 else np.exp(-0.75j * np.pi)
            rows.append(size * ((k + 1) // 2) * side)
        else:
            rows.append(-size * complex(k // width, k % width))
    places = np.array([[z.real, z.imag] + [0.0] * (dimension - 2) for z in rows])
    return places - places.mean(axis=0)


def _cube_of(n, size):
    """Return the places of n robots, (n, 3) [m]: layers of rows, each as long as the cube is high."""
    side = next(k for k in range(1, n + 1) if k**3 >= n)
    cells = [(i, j, -k) for k in range(side) for i in range(side) for j in range(side)]
    places = -size * np.array(cells[:n], dtype=float)
    return places - places.mean(axis=0)


def exact_steps(law, start, period, edges=None, drift=0.0):
    """Yield ``(p, u)``, (n, d) each, at each command: velocities are held for ``period`` [s].

    ``drift`` (n, d) [m/s]: by which a current carries the points besides.
    ``edges``: a :class:`FaultyEdges` over which robots receive from each other; each then runs the law on
    what it knows.
    """
    points, step = np.array(start, dtype=float), 0
    if edges is None:
        memory = law.begin(points)
        while True:
            u, memory = law.velocity(points, step * period, memory)
            yield points, u
            points, step = points + period * (u + drift), step + 1
    team = Listeners(law, edges, points)
    while True:
        u = team.velocity(points, step * period)
        yield points, u
        points, step = points + period * (u + drift), step + 1


class Steps:
    """The steps from one start, of which those that are known go on where more are asked for."""

    def __init__(self):
        self._known, self._more = [], None

    def at(self, rows, *law, **start):
        """Return points and u, (m, n, d) each, in ``rows`` (m,), counted from 0, of :func:`exact_steps`."""
        more, self._more = self._more or exact_steps(*law, **start), None
        self._known += itertools.islice(more, max(0, int(np.max(rows)) + 1 - len(self._known)))
        self._more = more  # it did not raise
        points, u = map(np.array, zip(*map(self._known.__getitem__, rows)))
        return points, u


class Listeners:
    """Robots that each run the law on what they know of the others over faulty ``edges``."""

    def __init__(self, law, edges, start):
        self.law, self.edges = law, edges
        self.memories = [law.begin(start) for _ in start]
        edges.begin(start)

    def velocity(self, points, time):
        """Return u (n, d) [m/s] at the next command, each robot's by its own view."""
        views, up = self.edges.views(points)
        law, u = self.law if up is None else self.law.over(up), np.empty_like(points)
        for i, view in enumerate(views):
            wanted, self.memories[i] = law.velocity(view, time, self.memories[i])
            u[i] = wanted[i]
        return u


def exact_motion(law, start, period, time, edges=None, drift=0.0, kept=None):
    """Return the exact points and velocities at ``time`` (m,) [s], (m, n, d) each; None if too long.

    ``drift``: as in :func:`exact_steps`; the velocities are those through the water.
    ``kept``: :class:`Steps` of solutions of the same law from the same start, which this one goes on from.
    Too long: more than ``MOST_COMMANDS``, or ``MOST_PAIRS`` over the pairs of robots.
    """
    count = np.asarray(time) / period
    before = np.floor(count + 1e-6).astype(int)
    commands, n = int(before.max()) + 1, len(start)
    work = law.WORK * commands * n * n * (1 if edges is None else n)
    if commands > MOST_COMMANDS or work > MOST_PAIRS:
        return None
    if edges is None:
        points, u = law.motion(start, period, before, drift, kept)
    else:
        points, u = (kept or Steps()).at(before, law, start, period, edges, drift)
    since = period * np.maximum(count - before, 0.0)
    return points + since[:, np.newaxis, np.newaxis] * (u + drift), u


class FaultyEdges:
    """What each robot knows of the others over edges that delay, lose and switch, as ``links`` say."""

    def __init__(self, links, topology, period, seed):
        self.links, self.topology, self.period, self.seed = links, topology, period, seed
        n = topology.n
        self.age = np.array(np.round(links.delay.matrix(n) / period), dtype=int)
        self.loss = links.loss.matrix(n)

    def begin(self, start):
        """Begin with robots at ``start`` (n, d) [m], where all know them to be."""
        n = len(start)
        self.past, self.command = [start] * (int(self.age.max(initial=0)) + 1), 0
        self.draws = np.random.default_rng([self.seed, 1])
        # received[i, j], seen[i, j]: j's point, and i's own at the time of what i received of j last.
        self.received = np.repeat(start[np.newaxis], n, axis=0)
        self.seen = np.repeat(start[:, np.newaxis], n, axis=1)

    def views(self, points):
        """Return what each robot takes for all points, (n, n, d) [m], and the edges up or None."""
        n, row = len(points), np.arange(len(points))
        self.past = [points] + self.past[:-1]
        arrived, past = self._arrived(n), np.array(self.past)
        came = arrived[:, :, np.newaxis]
        self.received = np.where(came, past[self.age, row], self.received)
        self.seen = np.where(came, past[self.age, row[:, np.newaxis]], self.seen)
        views = self.received.copy()
        if self.links.carries == "difference":
            views = points[:, np.newaxis] + self.received - self.seen
        views[row, row] = points
        up = self._up(arrived)
        self.command += 1
        return views, up

    def _arrived(self, n):
        if not self.loss.any():
            return np.ones((n, n), dtype=bool)
        chance = self.draws.random((n, n))
        if self.links.symmetric:
            chance = np.array([[chance[min(i, j), max(i, j)] for j in range(n)] for i in range(n)])
        return chance >= self.loss

    def _up(self, arrived):
        links, n = self.links, self.topology.n
        dropped = links.on_loss == "drop" and self.loss.any()
        if not links.switches and not dropped:
            return None
        up = arrived.copy() if dropped else np.ones((n, n), dtype=bool)
        return up & self._turn(n) if links.switches else up

    def _turn(self, n):
        switching, up = self.links.switching, np.zeros((n, n), dtype=bool)
        turn = self.command // max(1, int(round(switching.dwell / self.period)))
        graph = turn % switching.count
        if switching.order == "random":
            graph = int(np.random.default_rng([self.seed, 2, turn]).integers(switching.count))
        edges = [edge[:2] for edge in self.topology.edges[graph :: switching.count]]
        if switching.graphs:
            edges = switching.graphs[graph]
        for i, j in edges:
            up[i - 1, j - 1] = True
            up[j - 1, i - 1] |= not self.topology.directed
        return up
