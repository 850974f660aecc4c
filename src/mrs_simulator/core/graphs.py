"""Interaction topologies: which robot receives from which, with which weight.

``a_ij`` is the weight of the edge over which robot i receives from robot j.  Edges are written
``(i, j)`` with robots numbered from 1: "i receives from j".
"""

import warnings

import numpy as np

from mrs_simulator.core.fields import shown
from mrs_simulator.core.graph_presets import (
    BY_ORDER,
    both_ways,
    chance_pairs,
    nearest_pairs,
    ordered_pairs,
    refuse_many,
)
from mrs_simulator.core.neighbours import close_pairs, squared
from mrs_simulator.core.snapshots import Constant

PRESETS = tuple(BY_ORDER)  # decided by the number of robots alone


class Topology(Constant):
    """A weighted graph over robots 1..n, held as an edge list sorted by the receiving robot."""

    def __init__(self, n, edges, directed=True):
        """Build the graph from ``edges``: ``(i, j)`` or ``(i, j, weight)``, robots from 1.

        An undirected graph adds ``(j, i)`` for each edge.  Raises ``ValueError`` that names the
        edge for an unknown robot, a self-loop, a duplicate, or a weight that is not positive.
        """
        self.n = int(n)
        self.directed = bool(directed)
        self.edges = [_checked_edge(edge, self.n) for edge in edges]
        arcs = {}
        for i, j, weight in self.edges:
            for pair in ((i, j),) if directed else ((i, j), (j, i)):
                if pair in arcs:
                    raise ValueError("edge {}-{}: given twice, wanted once".format(i, j))
                arcs[pair] = weight
        rows = sorted(arcs)
        self._receiver = np.array([i - 1 for i, _ in rows], dtype=int)
        self._sender = np.array([j - 1 for _, j in rows], dtype=int)
        self._weight = np.array([arcs[pair] for pair in rows], dtype=float)
        self.receivers, self._starts = np.unique(self._receiver, return_index=True)
        # Where every robot has one neighbour, with weight 1, a sum is a look-up.
        single = len(self._receiver) == len(self.receivers) and np.all(self._weight == 1.0)
        self._look_up = bool(single)
        # Where means are look-ups: the row of each; its own for robots without neighbours.
        self._means = np.arange(self.n)
        self._means[self._receiver] = self._sender
        self._in_degree = self.neighbour_sum(np.ones((self.n, 1)))[:, 0]
        self._shares = self._weight / self._in_degree[self._receiver]
        for kept in (self._in_degree, self._shares):
            kept.setflags(write=False)

    def for_robots(self, n):
        """Return the graph over n robots, without edges of robots that are gone."""
        if n == self.n:
            return self
        kept = [edge for edge in self.edges if max(edge[:2]) <= n]
        return Topology(n, kept, self.directed)

    @classmethod
    def preset(cls, name, n, directed=None):
        """Return the graph called ``name``, one of ``PRESETS``, over n robots.

        ``chain``: i receives from i+1; ``cycle``: so does n from robot 1; ``path`` and ``ring``: the same,
        undirected; ``star``: robot 1 in the middle; ``complete``: all pairs; ``lattice``: a square
        grid, row by row.  ``directed``: other than the name's own; see
        ``graph_presets.ordered_pairs``.
        """
        if name not in BY_ORDER:
            text = "topology preset {!r}: wanted one of {}"
            raise ValueError(text.format(name, ", ".join(PRESETS)))
        directed = BY_ORDER[name] if directed is None else directed
        return cls(n, ordered_pairs(name, n, directed), directed)

    @classmethod
    def k_nearest(cls, points, k, directed=True):
        """Return the graph where each of ``points`` (n, d) [m] receives from its ``k`` nearest.

        Undirected: two are neighbours if one is among the other's nearest.
        """
        pairs = nearest_pairs(points, k)
        return cls(len(points), pairs if directed else both_ways(pairs), directed)

    @classmethod
    def erdos_renyi(cls, n, probability=0.3, seed=0, directed=False):
        """Return a graph with each pair, directed or not, by ``probability``; it may be disconnected."""
        return cls(n, chance_pairs(n, probability, seed, directed), directed)

    @classmethod
    def random(cls, n, probability=0.3, seed=0):
        """Return a connected undirected graph: a random tree, and each other pair with ``probability``."""
        refuse_many(n * (n - 1) // 2)
        draw = np.random.default_rng(seed)
        order = draw.permutation(n) + 1
        pairs = {tuple(sorted((int(order[k]), int(order[draw.integers(k)])))) for k in range(1, n)}
        chosen = draw.random((n, n)) < probability
        pairs |= {(i + 1, j + 1) for i, j in zip(*np.nonzero(np.triu(chosen, 1)))}
        return cls(n, [(int(i), int(j)) for i, j in sorted(pairs)], directed=False)

    @classmethod
    def proximity(cls, points, radius):
        """Return the undirected graph of all pairs of ``points`` (n, d) [m] within ``radius`` [m]."""
        points = np.asarray(points, dtype=float)
        # Cells as small as that radius could not be numbered where points lie far apart.
        reach = max(radius * (1.0 + 1e-9), 1e-6 * np.ptp(points, axis=0).max(), 1e-9)
        first, second = close_pairs(points, reach)
        near = np.sqrt(squared(points[first] - points[second])) <= radius
        refuse_many(np.count_nonzero(near))
        pairs = np.column_stack([first[near], second[near]]) + 1
        pairs = [tuple(pair) for pair in pairs.tolist()]
        return cls(len(points), pairs, directed=False)

    @property
    def arcs(self):
        """Return rows i (m,), j (m,) and weights ``a_ij`` (m,) of all edges, i receives from j, sorted."""
        return self._receiver, self._sender, self._weight

    def neighbours(self, robot):
        """Return the numbers of the neighbours of ``robot`` (1..n), ascending."""
        return [int(j) + 1 for j in self._sender[self._receiver == robot - 1]]

    def weighted_neighbours(self, row):
        """Return ``[(row of j, a_ij), ...]`` of the neighbours of the robot in ``row``."""
        (edges,) = (self._receiver == row).nonzero()
        return list(zip(self._sender[edges].tolist(), self._weight[edges].tolist()))

    def heard_by(self, row):
        """Return :meth:`weighted_neighbours`: its former name, with a ``FutureWarning``."""
        text = "Topology.heard_by is now weighted_neighbours; the old name goes with the next minor version"
        warnings.warn(text, FutureWarning, stacklevel=2)
        return self.weighted_neighbours(row)

    def adjacency(self):
        """Return ``A``, shape (n, n): ``A[i, j] = a_ij``, rows receive from columns."""
        matrix = np.zeros((self.n, self.n))
        matrix[self._receiver, self._sender] = self._weight
        return matrix

    def laplacian(self):
        """Return ``L = D - A``, shape (n, n), with ``D = diag(sum_j a_ij)``: rows sum to zero."""
        adjacency = self.adjacency()
        return np.diag(adjacency.sum(axis=1)) - adjacency

    def has_spanning_tree(self):
        """Return whether some robot reaches all others, as consensus needs."""
        followers = [[] for _ in range(self.n)]
        for i, j in zip(self._receiver.tolist(), self._sender.tolist()):
            followers[j].append(i)
        # The last finished of a depth-first search over all is a root if there is one.
        seen, last = set(), None
        for start in range(self.n):
            if start not in seen:
                last = start
                _reach(followers, start, seen)
        return len(_reach(followers, last, set())) == self.n

    def neighbour_sum(self, values):
        """Return ``sum_j a_ij values_j``, the shape of ``values`` (n, d); no n-by-n matrix is made."""
        # By columns, as laws' points lie in memory: a row of two numbers is slow to fetch.
        received = values.T.take(self._sender, axis=1)
        if not self._look_up:
            received = np.add.reduceat(self._weight * received, self._starts, axis=1)
        if len(self.receivers) == self.n:
            return received.T
        total = np.zeros(values.shape[::-1])
        total[:, self.receivers] = received
        return total.T

    def neighbour_mean(self, values):
        """Return ``sum_j a_ij values_j / sum_j a_ij``, (n, d); without neighbours a robot's own value."""
        if self._look_up:
            return values.T.take(self._means, axis=1).T
        if len(self.receivers) == self.n:
            return self.neighbour_sum(values) / self._in_degree[:, np.newaxis]
        mean, rows = np.array(values, dtype=float), self.receivers
        mean[rows] = self.neighbour_sum(values)[rows] / self._in_degree[rows, np.newaxis]
        return mean

    @property
    def listeners(self):
        """Return ``receivers``, by its name in earlier versions."""
        return self.receivers

    @property
    def shares(self):
        """Return ``a_ij / sum_j a_ij`` (m,) of the ``arcs``, not to be written to."""
        return self._shares

    def in_degree(self):
        """Return ``sum_j a_ij``, shape (n,), not to be written to."""
        return self._in_degree

    def out_degree(self):
        """Return ``sum_i a_ij``, shape (n,)."""
        return np.bincount(self._sender, self._weight, self.n)


def _reach(following, start, seen):
    """Add to ``seen`` all that can be reached from ``start``; return it."""
    seen.add(start)
    stack = [start]
    while stack:
        new = [node for node in following[stack.pop()] if node not in seen]
        seen.update(new)
        stack += new
    return seen


def _checked_edge(edge, n):
    edge = tuple(edge) if isinstance(edge, (list, tuple)) else (edge,)
    if len(edge) not in (2, 3):
        raise ValueError("edge {}: wanted [i, j] or [i, j, weight]".format(shown(list(edge))))
    for robot in edge[:2]:
        if isinstance(robot, bool) or not isinstance(robot, int) or not 1 <= robot <= n:
            text = "edge {}: robot {}, wanted a whole number from 1 to {}"
            raise ValueError(text.format(shown(list(edge)), shown(robot), n))
    weight = edge[2] if len(edge) == 3 else 1.0
    number = isinstance(weight, (int, float)) and not isinstance(weight, bool)
    if not number or not 0.0 < weight < np.inf:
        raise ValueError(
            "edge {}: weight {}, wanted above 0".format(shown(list(edge)), shown(weight))
        )
    if edge[0] == edge[1]:
        raise ValueError("edge {}: a robot is no neighbour of its own".format(shown(list(edge))))
    return edge[0], edge[1], float(weight)


def edges_without(edges, gone, directed):
    """Return those of ``edges``, (i, j, ...) each, that are not ``gone``, (i, j, ...) each.

    Either way round if not ``directed``.
    """
    pairs = {tuple(edge[:2]) for edge in gone}
    pairs |= set() if directed else {(j, i) for i, j in pairs}
    return [edge for edge in edges if tuple(edge[:2]) not in pairs]


def arcs_of(topology):
    """Return ``(arcs, weights, edges)`` of all m arcs (i, j), robots from 0.

    ``arcs`` (m, 2), ``weights`` (m,), ``edges`` (m,): which of ``topology.edges`` each belongs to;
    an undirected edge is two arcs.
    """
    pairs = np.array([edge[:2] for edge in topology.edges], dtype=int).reshape(-1, 2) - 1
    weights = np.array([edge[2] for edge in topology.edges], dtype=float)
    edges = np.arange(len(pairs))
    if topology.directed:
        return pairs, weights, edges
    return np.vstack([pairs, pairs[:, ::-1]]), np.tile(weights, 2), np.tile(edges, 2)
