"""Edges of interaction graphs: by name, at random, or by the robots' positions."""

import math

import numpy as np

MOST_PAIRS = 5000000  # [-] pairs of robots that a graph is made from
# Names of graphs that the number of robots alone decides, and whether they are directed by default.
BY_ORDER = {
    "chain": True,
    "cycle": True,
    "path": False,
    "ring": False,
    "star": False,
    "complete": False,
    "lattice": False,
}


def ordered_pairs(name, n, directed):
    """Return the edges (i, j), "i receives from j", robots from 1, of the graph ``name`` of ``BY_ORDER``.

    ``chain``, ``path``: i receives from i+1; ``cycle``, ``ring``: so does n from robot 1;
    ``star``: all receive from robot 1; ``complete``: all pairs; ``lattice``: rows of
    ``ceil(sqrt n)`` robots, as in the layout ``grid``, where each receives from the next in its row
    and column.  Of an undirected graph each edge is given once.
    """
    along = [(i, i + 1) for i in range(1, n)]
    if name in ("chain", "path"):
        return along
    if name in ("cycle", "ring"):
        return along + ([(n, 1)] if n > (1 if directed else 2) else [])
    if name == "star":
        return [(i, 1) if directed else (1, i) for i in range(2, n + 1)]
    if name == "complete":
        refuse_many(n * (n - 1) // 2)
        every = range(1, n + 1)
        return [(i, j) for i in every for j in every if i < j or (directed and i > j)]
    side = math.ceil(math.sqrt(n))
    right = [(i, i + 1) for i in range(1, n) if i % side]
    return sorted(right + [(i, i + side) for i in range(1, n - side + 1)])


def nearest_pairs(points, k):
    """Return the edges of the graph where each of ``points`` (n, d) receives from its ``k`` nearest.

    Of equal distances the lower number counts.  Raises ``ValueError`` unless ``1 <= k < n``.
    """
    points = np.asarray(points, dtype=float)
    if not 1 <= k < len(points):
        raise ValueError("k = {}: wanted from 1 to {}".format(k, len(points) - 1))
    refuse_many(len(points) * (len(points) - 1) // 2)
    apart = np.linalg.norm(points[:, np.newaxis] - points[np.newaxis], axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = np.argsort(apart, axis=1, kind="stable")[:, :k]
    return [(i + 1, j + 1) for i, row in enumerate(nearest.tolist()) for j in sorted(row)]


def chance_pairs(n, probability, seed, directed):
    """Return the edges of an Erdos-Renyi graph: each pair with ``probability``, from ``seed``.

    Directions are drawn independently where it is ``directed``.  It may be disconnected.  Gilbert, 1959.
    """
    refuse_many(n * (n - 1) // 2)
    chosen = np.random.default_rng(seed).random((n, n)) < probability
    np.fill_diagonal(chosen, False)
    chosen = chosen if directed else np.triu(chosen)
    return [(int(i) + 1, int(j) + 1) for i, j in zip(*np.nonzero(chosen))]


def refuse_many(pairs):
    """Raise ``ValueError`` where a graph would be made from more than ``MOST_PAIRS`` pairs."""
    if pairs > MOST_PAIRS:
        raise ValueError(
            "{} pairs of robots: wanted at most {}; fewer robots or edges".format(pairs, MOST_PAIRS)
        )


def both_ways(pairs):
    """Return the ``pairs`` (i, j) with i < j that are among ``pairs`` in one direction or the other."""
    return sorted({(min(pair), max(pair)) for pair in pairs})
