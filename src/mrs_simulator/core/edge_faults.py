"""Delay, loss and switching of edges at run time: the states that each robot has received."""

import numpy as np

from mrs_simulator.core.graphs import Topology, arcs_of

LOSSES, TURNS = 1, 2  # streams of random numbers: losses and turns are independent
PLACE = (0, 1, 3)  # columns of x, y and z in states
MOST_GRAPHS = 256  # graphs in the cache, since the same recur


class Channel:
    """Passes the robots' states over edges as ``links`` say, from one command to the next.

    A state is a row of numbers that begins with the pose ``(x, y, theta)``, a height z where there are
    heights, and whatever else robots send.  Every ordered pair of robots is an edge here, whether a
    law uses it or not.
    """

    def __init__(self, links, n, period, seed):
        """``period`` [s] between two commands; ``seed`` of losses and random turns."""
        self._links, self._seed = links, seed
        self._steps = np.round(links.delay.matrix(n) / period).astype(int)
        self._loss = links.loss.matrix(n)
        self._turn_steps = turn_steps(links.switching, period)
        self._rows = np.arange(n)
        self._count = 0
        self._graphs, self._made_from = {}, None

    def begin(self, state):
        """Start with all robots having received ``state`` (n, s)."""
        n = len(state)
        self._draw = np.random.default_rng([self._seed, LOSSES])
        self._past = np.repeat(state[np.newaxis], int(self._steps.max(initial=0)) + 1, axis=0)
        self._received = np.repeat(state[np.newaxis], n, axis=0)
        self._arrived = np.ones((n, n), dtype=bool)
        self._receiver = np.repeat(state[:, np.newaxis], n, axis=1)
        self._count = -1

    def take(self, state, periods=1):
        """Send the states (n, s) after so many command periods, and deliver what is due.

        In periods that were skipped robots send their previous state again; of a long pause at most
        the longest delay is simulated.
        """
        for _ in range(min(periods, len(self._past)) - 1):
            self._pass_on(self._past[0])
        if periods > 0:
            self._pass_on(state)
        self._count += periods

    def _pass_on(self, state):
        self._past = np.concatenate([state[np.newaxis], self._past[:-1]])
        self._arrived = self._arrives()
        due = self._arrived[:, :, np.newaxis]
        self._received = np.where(due, self._past[self._steps, self._rows], self._received)
        own = self._past[self._steps, self._rows[:, np.newaxis]]
        self._receiver = np.where(due, own, self._receiver)

    def _arrives(self):
        if not self._loss.any():
            return np.ones(self._loss.shape, dtype=bool)
        chance = self._draw.random(self._loss.shape)
        if self._links.symmetric:
            upper = np.triu(chance, 1)
            chance = upper + upper.T
        arrived = chance >= self._loss
        np.fill_diagonal(arrived, True)
        return arrived

    def views(self, state, points):
        """Return the states that each robot has received, (n, n, s): row i those of robot i.

        Its own is the true one.  Where edges carry differences, the controlled points (..., n, d), which
        ``points`` gives for states (..., n, s), keep their distance from its own at the time of sending.
        """
        views = self._received.copy()
        if self._links.carries == "difference":
            received = points(self._received)
            # Column j of the receivers is one robot's own states: rows and columns change places.
            own = points(self._receiver.swapaxes(0, 1)).swapaxes(0, 1)
            places = PLACE[: received.shape[-1]]
            ahead = received - self._received[..., places]
            views[..., places] = points(state)[:, np.newaxis] + (received - own) - ahead
        views[self._rows, self._rows] = state
        return views

    def graph(self, topology):
        """Return the graph of the edges of ``topology`` that are up at this command."""
        if not self._links.changes_edges:
            return topology
        arcs, _, _ = arcs_of(topology)
        up = np.ones(len(arcs), dtype=bool)
        if self._links.switches:
            up = up_in(self._links.switching, topology, self._graph_number())
        if self._links.on_loss == "drop":
            up = up & self._arrived[arcs[:, 0], arcs[:, 1]]
        if up.all():
            return topology
        if self._made_from is not topology or len(self._graphs) >= MOST_GRAPHS:
            self._graphs, self._made_from = {}, topology
        key = up.tobytes()
        if key not in self._graphs:
            self._graphs[key] = kept_edges(topology, up)
        return self._graphs[key]

    def _graph_number(self):
        turn, switching = self._count // self._turn_steps, self._links.switching
        if switching.order == "periodic":
            return turn % switching.count
        return int(np.random.default_rng([self._seed, TURNS, turn]).integers(switching.count))


def turn_steps(switching, period):
    """Return the length of a turn in command periods."""
    return max(1, int(round(switching.dwell / period)))


def up_in(switching, topology, number):
    """Return which of the topology's arcs, (m,) in the order of ``arcs_of``, are in that graph."""
    arcs, _, edges = arcs_of(topology)
    if not switching.graphs:
        return edges % switching.sets == number
    chosen = set(switching.graphs[number])
    if not topology.directed:
        chosen |= {pair[::-1] for pair in chosen}
    return np.array([(i + 1, j + 1) in chosen for i, j in arcs.tolist()], dtype=bool)


def kept_edges(topology, up):
    """Return the directed graph of the arcs of ``topology`` that are ``up``, (m,)."""
    arcs, weights, _ = arcs_of(topology)
    kept = zip((arcs[up] + 1).tolist(), weights[up].tolist())
    return Topology(topology.n, [(i, j, weight) for (i, j), weight in kept])
